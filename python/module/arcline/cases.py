"""Many runs: cases in, results out, the same as ``arcline-server simulate --cases``."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice, product
from typing import Any

from arcline import _arcline

__all__ = ["campaign", "chunks", "simulate_many"]


def simulate_many(
    cases: Iterable[Mapping[str, Any]],
    program: str | os.PathLike[str] | None = None,
    config: str | os.PathLike[str] | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    seed: int = 0,
    until: float = 3600.0,
    queue_full: str = "wait",
    keep_going: bool = False,
    first: int = 0,
    threads: int = 1,
    trace: str | os.PathLike[str] | None = None,
    signals: Sequence[str] = (),
) -> list[dict[str, Any]]:
    """Runs a program for each case, and returns their results in the order of the cases.

    A case is a dictionary with the members of a line of ``--cases`` (docs/BATCHES.md); what it leaves out, the arguments say. ``program`` and
    ``config`` are files. ``first`` is the number of the first case, when the cases are a part of more: seeds and numbers are those of the whole.
    One thread, unless more are asked for, so that an engine with a worker for each processor keeps them all busy and no busier.

    >>> move = "MAM(X, M1, Absolute, {}, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);"
    >>> results = simulate_many([{"text": move.format(5)}, {"text": move.format(-1), "id": "back"}])
    >>> [(r["end"], r["positions"]["X"], r["ticks"]) for r in results]
    [('finished', 5.0, 200), ('finished', -1.0, 90)]
    """
    if queue_full not in ("wait", "error"):
        raise ValueError(f"queue_full is {queue_full!r}, expected 'wait' or 'error'")
    if threads < 1:
        raise ValueError(f"threads is {threads}, expected 1 or more")
    lines = _arcline._simulate_many(
        "".join(json.dumps(dict(case)) + "\n" for case in cases),
        None if program is None else os.fspath(program),
        None if config is None else os.fspath(config),
        list((set or {}).items()),
        seed,
        until,
        queue_full == "wait",
        keep_going,
        first,
        threads,
        None if trace is None else os.fspath(trace),
        list(signals),
    )
    return [json.loads(line) for line in lines.splitlines()]


def chunks(cases: Iterable[Mapping[str, Any]], size: int = 1000) -> Iterator[tuple[int, list[dict[str, Any]]]]:
    """The cases in parts for workers: the number of the first one of each, and its cases.

    >>> [(first, len(part)) for first, part in chunks([{}] * 5, size=2)]
    [(0, 2), (2, 2), (4, 1)]
    """
    if size < 1:
        raise ValueError(f"size is {size}, expected 1 or more")
    rest, first = iter(cases), 0
    while part := [dict(case) for case in islice(rest, size)]:
        yield first, part
        first += len(part)


def campaign(
    programs: Iterable[str], faults: Iterable[tuple[str, str]], times: Iterable[float | tuple[float, float]], seeds: Iterable[int] = (0,)
) -> Iterator[dict[str, Any]]:
    """The cases of a fault campaign: each program with each fault ``(axis, fault)`` at each time, with each seed. A time may be a range, in which the
    seed decides. The ``id`` of a case names all four.

    >>> cases = list(campaign(["part.st"], [("X", "overcurrent"), ("Y", "overcurrent")], [0.5, 1.0]))
    >>> len(cases), cases[0]["id"]
    (4, {'program': 'part.st', 'axis': 'X', 'fault': 'overcurrent', 'at': 0.5, 'seed': 0})
    """
    for program, (axis, fault), at, seed in product(list(programs), list(faults), list(times), list(seeds)):
        when = list(at) if isinstance(at, tuple) else at
        yield {
            "id": {"program": program, "axis": axis, "fault": fault, "at": when, "seed": seed},
            "program": program,
            "seed": seed,
            "faults": [{"axis": axis, "fault": fault, "at": when}],
        }
