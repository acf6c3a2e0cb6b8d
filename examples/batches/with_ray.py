"""A batch on a cluster of Ray: python with_ray.py PROGRAM.st CASES.jsonl RESULTS.jsonl [ADDRESS].

Without the address of a cluster it starts one here, with two processors. A chunk of cases is a task; a worker that is lost costs the chunk it was at, which
another does again.
"""

import json
import sys
from pathlib import Path

import arcline
import ray


@ray.remote(num_cpus=1, max_retries=3)
def run(first, cases, program):
    return arcline.simulate_many(cases, program, first=first)


def main(program, cases, results, address=None, size=1000):
    lines = Path(cases).read_text().splitlines()
    parts = arcline.chunks(map(json.loads, filter(str.strip, lines)), size)
    ray.init(address=address, **({} if address else {"num_cpus": 2, "include_dashboard": False}))
    program = str(Path(program).resolve())
    with open(results, "w") as file:
        for part in [run.remote(first, cases, program) for first, cases in parts]:  # in the order of the cases
            for result in ray.get(part):
                print(json.dumps(result), file=file)
    ray.shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
