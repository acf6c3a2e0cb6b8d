"""A batch on a cluster of Dask: python with_dask.py PROGRAM.st CASES.jsonl RESULTS.jsonl [SCHEDULER].

Without the address of a scheduler it starts two workers here. A chunk of cases is a task: scheduling one costs about a millisecond, a case often less. A
worker that is lost costs the chunks it was at, which others do again.
"""

import json
import sys
from pathlib import Path

import arcline
from dask.distributed import Client, LocalCluster


def run(chunk, program):
    first, cases = chunk
    return arcline.simulate_many(cases, program, first=first)


def main(program, cases, results, scheduler=None, size=1000):
    lines = Path(cases).read_text().splitlines()
    parts = list(arcline.chunks(map(json.loads, filter(str.strip, lines)), size))
    cluster = None if scheduler else LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with Client(scheduler or cluster) as client, open(results, "w") as file:
        futures = client.map(run, parts, program=str(Path(program).resolve()), retries=3)
        for future in futures:  # in the order of the cases
            for result in future.result():
                print(json.dumps(result), file=file)
    if cluster:
        cluster.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
