"""Lower bounds for the time of a zig-zag path with S-curves, from its y axis alone (see ../NOTES.md).

usage: zigzag_bound.py PATHS/zigzag1000.json [GRID]      needs numpy; the legs rise and fall by 15 degrees
"""
import json
import math
import sys

import numpy as np

with open(sys.argv[1]) as file:
    path = json.load(file)
y = [path["start"][1]] + [move["to"][1] for move in path["moves"]]
# What run_paths.py lets pass.
jerk = path["limits"]["j"] * 1.001 + 10
short = path["tol"] * 1.001 / math.cos(math.radians(15))
count = len(y)
side = [0] + [1 if y[i] > y[i - 1] else -1 for i in range(1, count)]
side[0] = -side[1]
# What y must reach at each vertex; the ends are met exactly.
need = [y[i] - short * side[i] for i in range(count)]
need[0], need[-1] = y[0], y[-1]

# Every alternating choice of vertices gives a bound: the best of them.
best, before = [0.0] + [-1.0] * (count - 1), [None] * count
for i in range(1, count):
    for k in range(max(0, i - 60), i):
        swing = (need[i] - need[k]) * side[i]
        if side[k] == -side[i] and swing > 0 and best[k] >= 0:
            bound = best[k] + (12 * swing / jerk) ** (1 / 3)
            if bound > best[i]:
                best[i], before[i] = bound, k
chosen = [count - 1]
while before[chosen[-1]] is not None:
    chosen.append(before[chosen[-1]])
chosen.reverse()
swings = [abs(need[b] - need[a]) for a, b in zip(chosen, chosen[1:])]
print(f"{len(swings)} swings, each by itself: {best[-1]:.3f} s")

# The acceleration at an extreme is that of both swings. How far a swing of a duration comes, from one acceleration
# to the other, with +j, -j, +j.
grid = np.linspace(0, 3000, int(sys.argv[2]) if len(sys.argv) > 2 else 100)
first, last = grid[:, None], grid[None, :]


def reach(time):
    length = (time + (first + last) / jerk) / 2
    back = (time * time / 2 + first * time / jerk) / (2 * length)
    begin, end = time - back - length / 2, time - back + length / 2
    way = first * time * time / 2 + jerk * (time**3 / 6 - ((time - begin) ** 3 - (time - end) ** 3) / 3)
    return np.where((begin >= -1e-9) & (end <= time + 1e-9), way, -1)


total = np.full(len(grid), np.inf)
total[0] = 0.0
for swing in swings:
    low, high = np.full((len(grid), len(grid)), 1e-4), np.full((len(grid), len(grid)), 0.3)
    for _ in range(36):
        middle = (low + high) / 2
        good = reach(middle) >= swing
        high, low = np.where(good, middle, high), np.where(good, low, middle)
    total = np.min(total[:, None] + high, axis=0)
print(f"with the accelerations at the extremes in common: {total.min():.3f} s")
