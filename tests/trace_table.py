#!/usr/bin/env python3
"""Does a change of the code leave every motion test as it was, to the bit?

    ARCLINE_TRACES=/tmp/traces.txt cargo test -p arcline-tests --test motion -- --skip wandering --skip half_a_turn
    python3 tests/trace_table.py compare /tmp/traces.txt     names the tests whose traces changed
    python3 tests/trace_table.py check /tmp/traces.txt       the same, and fails when a test of the table did not run
    python3 tests/trace_table.py record /tmp/traces.txt      rewrites the table

The table, tests/motion_traces.txt, has one line per test: its name and a hash over every snapshot, event and change of
faults of its benches (tests/src/trace.rs). A refactoring changes no line; a change of behaviour rewrites the lines that it
changes in the same commit. The file of ARCLINE_TRACES is appended to: remove it before each run.
"""
import collections, hashlib, pathlib, sys

TABLE = pathlib.Path(__file__).with_name("motion_traces.txt")


def read_benches(path):
    benches = collections.defaultdict(list)
    for line in open(path):
        name, digest = line.rstrip("\n").split("\t")
        benches[name].append(digest)
    benches.pop("unnamed", None)
    return {name: hashlib.sha256(" ".join(digests).encode()).hexdigest()[:16] for name, digests in benches.items()}


def read_table():
    return dict(line.rsplit(" ", 1) for line in TABLE.read_text().splitlines())


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in ("compare", "check", "record"):
        sys.exit(__doc__)
    found = read_benches(sys.argv[2])
    if sys.argv[1] == "record":
        TABLE.write_text("".join(f"{name} {found[name]}\n" for name in sorted(found)))
        print(f"{len(found)} tests recorded")
        return
    kept = read_table()
    changed = sorted(name for name in found if name in kept and kept[name] != found[name])
    for name in changed:
        print("changed:", name)
    for name in sorted(found.keys() - kept.keys()):
        print("new:", name)
    missing = sorted(kept.keys() - found.keys())
    if sys.argv[1] == "check":
        for name in missing:
            print("did not run:", name)
    print(f"{len(found)} tests, {len(changed)} changed, {len(missing)} of the table did not run")
    sys.exit(1 if changed or (missing and sys.argv[1] == "check") else 0)


main()
