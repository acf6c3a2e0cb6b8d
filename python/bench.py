"""The speed of the module, as ratios within one run: python3 bench.py [--check] [FIGURE...]. Run it on a machine that does nothing else.

With --check the exit code is 1 when one of these figures stays below its floor in each of three tries; without names all of them.
"""

import os
import statistics
import sys
import time

import numpy as np

import arcline

MOVE = (
    "MCLM(CS1, M1, Absolute, [100, 50, 25], 20, Unitspersec, 200, Unitspersec2, 200, Unitspersec2);\nWAIT(M1.PC);\n"
    "MCLM(CS1, M2, Absolute, [0, 0, 0], 20, Unitspersec, 200, Unitspersec2, 200, Unitspersec2);\nWAIT(M2.PC);\n"
) * 10


def seconds(work, times=5):
    """The median of some runs."""
    took = []
    for _ in range(times):
        began = time.perf_counter()
        work()
        took.append(time.perf_counter() - began)
    return statistics.median(took)


def of_machine(work):
    """The median of a work on machines that move."""
    took = []
    for _ in range(5):
        machine = arcline.Machine(journal=False)
        machine.program(MOVE)
        began = time.perf_counter()
        work(machine)
        took.append(time.perf_counter() - began)
    return statistics.median(took)


TICKS = 100_000
CORES = os.cpu_count() or 1
#: The floors of the specification (spec/beyond-one-machine.md, section 5.4).
FLOORS = {"run": 0.95, "step": 500_000.0, "batch": 0.9}
TRIES = 3


def run():
    """The speed of Machine.step by that of simulate, turn by turn."""
    whole = arcline.simulate(MOVE).ticks
    native = seconds(lambda: arcline.simulate(MOVE).check())
    stepped = of_machine(lambda machine: machine.step(whole))
    print(f"simulate: {whole / native:,.0f} ticks/s; Machine.step({whole}): {whole / stepped:,.0f} ticks/s; ratio {native / stepped:.3f}")
    return native / stepped


def one_by_one(machine):
    step = machine.step
    for _ in range(TICKS):
        step(1)


def step():
    """step(1) a second, while axes move."""
    each = TICKS / of_machine(one_by_one)
    still = arcline.Machine(journal=False)
    print(f"step(1) while moving: {each:,.0f}/s; at rest: {TICKS / seconds(lambda: one_by_one(still)):,.0f}/s")
    return each


def trace():
    out = np.empty((TICKS, 8))
    names = [f"{axis}.{signal}" for axis in "XYZS" for signal in ("CommandPosition", "ActualPosition")]
    traced = of_machine(lambda machine: machine.trace(names, TICKS, out=out))
    plain = of_machine(lambda machine: machine.step(TICKS))
    print(f"trace of {TICKS} x 8: {traced / plain:.3f} of the time of the steps alone")


def of_batch(threads):
    machines = arcline.Batch(n=64, threads=threads)
    machines.program(MOVE)
    machines.bind("X.CommandPosition")
    began = time.perf_counter()
    for _ in range(40):
        machines.step(100)
    return 64 * 4000 / (time.perf_counter() - began)


def batch():
    """The speed of a batch on all cores by that on one, for each core; the median of pairs, so that other work strikes both."""
    pairs = [(of_batch(1), of_batch(CORES)) for _ in range(5)]
    ratio = statistics.median(many / one / CORES for one, many in pairs)
    one, many = (statistics.median(column) for column in zip(*pairs))
    print(f"Batch of 64: {one:,.0f} ticks/s on 1 thread, {many:,.0f} on {CORES}: {ratio:.3f} x threads")
    return ratio


def plant():
    """The cost of a plant in Python."""
    machine = arcline.Machine(plant=lambda set_points, feedback: None)
    machine.program(MOVE)
    print(f"ticks with a plant: {TICKS / 10 / seconds(lambda: machine.step(TICKS // 10)):,.0f}/s")


def check(figures):
    """Return whether each figure reaches its floor in one of some tries."""
    below = []
    for figure in figures:
        floor = FLOORS[figure.__name__]
        if not any(figure() >= floor for _ in range(TRIES)):
            below.append(f"{figure.__name__} stays below {floor:,}")
    print("\n".join(below) or "all floors are reached")
    return not below


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        with_floor = {figure.__name__: figure for figure in (run, step, batch)}
        names = sys.argv[sys.argv.index("--check") + 1 :] or with_floor
        sys.exit(0 if check([with_floor[name] for name in names]) else 1)
    for figure in (run, step, trace, batch, plant):
        figure()
