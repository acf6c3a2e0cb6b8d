#!/bin/sh
# A batch on all processors of one computer, or several, with GNU parallel: parallel.sh PROGRAM.st CASES.jsonl > RESULTS.jsonl
# Each process gets CHUNK cases on its standard input and runs them on one thread; --keep-order puts their results in the order of the cases. A process that
# is lost is started again with its chunk. For several computers add --sshlogin.
set -eu
export PROGRAM="$1" CHUNK="${CHUNK:-1000}"
exec <"$2"
# Blank lines are no cases, and parallel counts them.
grep -v '^[[:space:]]*$' | parallel --will-cite --pipe -N "$CHUNK" --keep-order --retries 3 --jobs "${JOBS:-100%}" \
    'arcline-server simulate "$PROGRAM" --cases - --first $((({#} - 1) * CHUNK)) --jobs 1'
