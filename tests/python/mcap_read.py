"""Reads an MCAP file with the reader of Foxglove's own package and tells what is in it, as one line of JSON."""

import json
import sys

from mcap.reader import make_reader

topics = {}
with open(sys.argv[1], "rb") as file:
    reader = make_reader(file)
    summary = reader.get_summary()
    for schema, channel, message in reader.iter_messages():
        topic = topics.setdefault(channel.topic, {"count": 0, "first": message.log_time, "schema": schema.encoding})
        sample = json.loads(message.data)
        assert channel.message_encoding == "json"
        assert set(sample) == set(json.loads(schema.data)["properties"]), (sample, schema.data)
        topic["count"] += 1
        topic["last"] = message.log_time
        topic["sample"] = sample
    # The second half only, by the index.
    middle = (summary.statistics.message_start_time + summary.statistics.message_end_time) // 2
    later = sum(1 for _ in reader.iter_messages(start_time=middle))
print(json.dumps({"messages": summary.statistics.message_count, "topics": topics, "later": later}))
