"""A hundred programs: the module writes the bytes that `arcline-server simulate` writes. Needs the server's program."""

import os
import random
import shutil
import subprocess

import pytest

import arcline

PROGRAM = os.environ.get("ARCLINE_SERVER_PROGRAM") or shutil.which("arcline-server")


def text_of(seed):
    """A program of lines, arcs, moves of single axes, waits and changes of dynamics."""
    rng = random.Random(seed)
    number = lambda low, high: round(rng.uniform(low, high), 3)
    lines = []
    for index in range(rng.randint(3, 8)):
        control = f"M{index}"
        dynamics = (
            f"{number(20, 400)}, Unitspersec, {number(500, 4000)}, Unitspersec2, {number(500, 4000)}, Unitspersec2, "
            f"{rng.choice(['Trapezoidal', 'S-curve'])}, {rng.randint(20, 100)}, {rng.randint(20, 100)}, %ofTime, {rng.randint(0, 3)}"
        )
        kind = rng.random()
        if kind < 0.6:
            target = [number(-200, 200) for _ in "XYZ"]
            lines.append(f"MCLM(CS1, {control}, {rng.choice(['Absolute', 'Incremental'])}, {target}, {dynamics});")
        elif kind < 0.8:
            lines.append(f"MAM(S, {control}, Absolute, {number(-90, 90)}, {number(10, 90)}, Unitspersec, {number(100, 900)}, Unitspersec2, {number(100, 900)}, Unitspersec2);")
        else:
            lines.append(f"DELAY({number(0.01, 0.3)});")
            continue
        if rng.random() < 0.4:
            lines.append(f"WAIT({control}.PC OR {control}.ER);")
    return "\n".join(lines) + "\n"


@pytest.mark.skipif(PROGRAM is None, reason="no arcline-server: name it by ARCLINE_SERVER_PROGRAM")
def test_traces_and_events_of_100_programs_are_those_of_simulate(tmp_path):
    finished = 0
    for seed in range(100):
        text = text_of(seed)
        program = tmp_path / "program.st"
        program.write_text(text)
        files = {name: (tmp_path / f"server-{name}", tmp_path / f"module-{name}") for name in ("trace.csv", "events.jsonl")}
        command = [PROGRAM, "simulate", program, "--trace", files["trace.csv"][0], "--events", files["events.jsonl"][0], "--until", "60"]
        ran = subprocess.run(command, capture_output=True, text=True)
        result = arcline.simulate(program, until=60.0, trace_csv=files["trace.csv"][1], events_jsonl=files["events.jsonl"][1])
        assert (ran.returncode == 0) == (result.error is None), f"seed {seed}: {ran.stderr} {result.error!r}\n{text}"
        for name, (theirs, ours) in files.items():
            assert theirs.read_bytes() == ours.read_bytes(), f"seed {seed}: {name}\n{text}"
        finished += result.error is None
        # In steps it is the same machine.
        machine = arcline.Machine(journal=False)
        machine.program(text)
        machine.step(result.ticks)
        row = machine.trace(["X.CommandPosition", "S.CommandPosition"], 1)[0]
        if result.error is None:
            assert list(row) == [result.positions["X"], result.positions["S"]], f"seed {seed}\n{text}"
    assert finished > 60, finished
