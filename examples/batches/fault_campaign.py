"""A fault campaign: what becomes of a part when a fault comes, by fault and time. python fault_campaign.py FOLDER

Writes the cases, the results as JSON lines and as Parquet, and a picture: how far off its path the tool comes to
rest, since each axis brakes by itself.
"""

import json
import sys
from pathlib import Path

import arcline
import matplotlib
import numpy as np
import pyarrow.json
import pyarrow.parquet

matplotlib.use("Agg")
import matplotlib.pyplot as plt

SPEEDS = {"slow": 100, "fast": 200}
PART = """
MCLM(CS1, Out, Absolute, [100, 50, 0], {speed}, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
MCLM(CS1, Back, Absolute, [0, 0, 0], {speed}, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
"""
# Y brakes four times as hard as X; a fault of the drive of X shuts it down at once.
MACHINE = {"axis.X.max_deceleration": 500, "axis.Y.max_deceleration": 2000, "axis.X.exception_actions.drive": "shutdown"}
FAULTS = [("X", "overcurrent"), ("Y", "overcurrent"), ("X", "drive")]
TIMES = [round(0.05 * step, 3) for step in range(52)]


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    programs = []
    for name, speed in SPEEDS.items():
        programs.append(str(folder / f"{name}.st"))
        Path(programs[-1]).write_text(PART.format(speed=speed))
    cases = list(arcline.campaign(programs, FAULTS, TIMES))
    results = arcline.simulate_many(cases, set=MACHINE, threads=2)
    lines = folder / "results.jsonl"

    lines.write_text("".join(json.dumps(result) + "\n" for result in results))
    table = pyarrow.json.read_json(lines)
    pyarrow.parquet.write_table(table, folder / "results.parquet")

    rows = [(program, *fault) for program in programs for fault in FAULTS]
    off_path = np.zeros((len(rows), len(TIMES)))
    for result in results:
        row = rows.index((result["id"]["program"], result["id"]["axis"], result["id"]["fault"]))
        x, y = result["positions"]["X"], result["positions"]["Y"]
        off_path[row, TIMES.index(result["id"]["at"])] = abs(50 * x - 100 * y) / np.hypot(100, 50)
    names = [f"{Path(program).stem}: {axis} {fault}" for program, axis, fault in rows]
    plot(off_path, names, folder / "campaign.png")
    return results


def plot(off_path, names, file):
    figure, axes = plt.subplots(figsize=(9, 3.6), layout="constrained")
    edges = np.append(TIMES, TIMES[-1] + TIMES[1])
    image = axes.pcolormesh(edges, np.arange(len(names) + 1), off_path, cmap="viridis")
    axes.set_yticks(np.arange(len(names)) + 0.5, names)
    axes.invert_yaxis()
    axes.set_xlabel("time of the fault, s")
    axes.set_title("How far off its path the tool comes to rest")
    figure.colorbar(image, label="mm")
    figure.savefig(file, dpi=120)


if __name__ == "__main__":
    main(*sys.argv[1:])
