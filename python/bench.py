"""The speed of the module, as ratios within one run: python3 bench.py. Run it on a machine that does nothing else."""

import os
import statistics
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
native = seconds(lambda: arcline.simulate(MOVE).check())
whole = arcline.simulate(MOVE).ticks
run = of_machine(lambda machine: machine.step(whole))
print(f"simulate: {whole / native:,.0f} ticks/s; Machine.step({whole}): {whole / run:,.0f} ticks/s; ratio {native / run:.3f}")


def one_by_one(machine):
    step = machine.step
    for _ in range(TICKS):
        step(1)


print(f"step(1) while moving: {TICKS / of_machine(one_by_one):,.0f}/s")
still = arcline.Machine(journal=False)
print(f"step(1) at rest: {TICKS / seconds(lambda: one_by_one(still)):,.0f}/s")

out = np.empty((TICKS, 8))
names = [f"{axis}.{signal}" for axis in "XYZS" for signal in ("CommandPosition", "ActualPosition")]
traced = of_machine(lambda machine: machine.trace(names, TICKS, out=out))
plain = of_machine(lambda machine: machine.step(TICKS))
print(f"trace of {TICKS} x 8: {traced / plain:.3f} of the time of the steps alone")


def batch(threads):
    machines = arcline.Batch(n=64, threads=threads)
    machines.program(MOVE)
    machines.bind("X.CommandPosition")
    began = time.perf_counter()
    for _ in range(40):
        machines.step(100)
    return 64 * 4000 / (time.perf_counter() - began)


cores = os.cpu_count() or 1
one, many = statistics.median(batch(1) for _ in range(3)), statistics.median(batch(cores) for _ in range(3))
print(f"Batch of 64: {one:,.0f} ticks/s on 1 thread, {many:,.0f} on {cores}: {many / one / cores:.3f} x threads")
