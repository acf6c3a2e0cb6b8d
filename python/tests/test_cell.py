"""Projects of controllers as users of the module see them, and the bytes of `arcline-server simulate`."""

import doctest
import json
import os
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import arcline
import arcline.cell

CONFIG = Path(__file__).parent.parent.parent / "tests" / "config"
CELL = CONFIG / "Cell.L5X"
LADDER = CONFIG / "ladder.L5X"
PROGRAM = os.environ.get("ARCLINE_SERVER_PROGRAM") or shutil.which("arcline-server")
needs_server = pytest.mark.skipif(PROGRAM is None, reason="no arcline-server: name it by ARCLINE_SERVER_PROGRAM")


def project(*rungs, tags=""):
    """The text of Cell.L5X with other rungs and more tags."""
    text = CELL.read_text()
    begin = text.index('<Rung Number="0" Type="N"><Text><![CDATA[XIC(Start)')
    end = text.index("</RLLContent>", begin)
    lines = "".join(f'<Rung Number="{number}" Type="N"><Text><![CDATA[{rung}]]></Text></Rung>' for number, rung in enumerate(rungs))
    return (text[:begin] + lines + text[end:]).replace("</Tags>", tags + "</Tags>", 1)


def done(**given):
    cell = arcline.Cell(CELL, **given)
    cell["Start"] = 1
    return cell, cell.run_until("Done", 10)


def test_examples_of_the_docstrings(monkeypatch):
    monkeypatch.chdir(CONFIG)
    result = doctest.testmod(arcline.cell)
    assert result.failed == 0 and result.attempted > 10


def test_every_method_has_a_docstring():
    for name in dir(arcline.Cell):
        if not name.startswith("_"):
            assert getattr(arcline.Cell, name).__doc__, name


def simulated(tmp_path, *arguments):
    """What the program writes for a project: trace, events, tags."""
    files = {name: tmp_path / f"server-{name}" for name in ("trace.csv", "events.jsonl", "tags.json")}
    command = [PROGRAM, "simulate", CELL, "--trace", files["trace.csv"], "--events", files["events.jsonl"], "--tags", files["tags.json"]]
    ran = subprocess.run([*command, *arguments], capture_output=True, text=True)
    return ran, {name: file.read_bytes() for name, file in files.items()}


CASES = [
    pytest.param({"set": {"Start": 1}, "until": "Done", "max_seconds": 10}, ["--set", "Start=1", "--until", "Done", "--max", "10"], id="until"),
    pytest.param({"max_seconds": 0.5}, ["--max", "0.5"], id="time"),
    pytest.param(
        {"set": {"Start": True, "Target": -3.7, "Program:Main.Settle.PRE": 7}, "until": "Program:Main.Sum.Total = 5", "scan_phase": 7},
        ["--set", "Start=1", "--set", "Target=-3.7", "--set", "Program:Main.Settle.PRE=7", "--until", "Program:Main.Sum.Total = 5", "--scan-phase", "7"],
        id="tags",
    ),
    pytest.param({"until": "Done", "max_seconds": 0.25}, ["--until", "Done", "--max", "0.25"], id="not in time"),
]


@needs_server
@pytest.mark.parametrize(("given", "arguments"), CASES)
def test_a_project_gives_the_bytes_of_simulate(tmp_path, given, arguments):
    ran, theirs = simulated(tmp_path, *arguments)
    files = {name: tmp_path / f"module-{name}" for name in theirs}
    keywords = {name.replace(".", "_"): file for name, file in files.items()}
    result = arcline.simulate(CELL, **given, **keywords)
    assert (ran.returncode == 0) == (result.error is None), (ran.stderr, result.error)
    assert {name: file.read_bytes() for name, file in files.items()} == theirs


@needs_server
def test_a_cell_that_is_stepped_has_the_tags_and_positions_of_simulate(tmp_path):
    ran, theirs = simulated(tmp_path, "--set", "Start=1", "--until", "Done", "--max", "10")
    assert ran.returncode == 0, ran.stderr
    rows = np.loadtxt(theirs["trace.csv"].decode().splitlines(), delimiter=",", skiprows=1)
    cell, seconds = done()
    tags = json.loads(theirs["tags.json"])
    assert cell.tags_json() + "\n" == theirs["tags.json"].decode()
    assert (seconds, cell.time) == (tags["@time_s"], tags["@time_s"])
    for name in ("Start", "Done", "Middle", "Batch.Steps", "Program:Main.Scans", "Program:Main.Move.PC", "X.ActualPosition"):
        cell[name]
    assert cell["Program:Main.Scans"] == tags["Program:Main.Scans"]
    assert cell["Batch.Steps"] == tags["Batch"]["Steps"]
    # In steps of any length, with reads between them, it is the same run.
    names = [f"X.{signal}" for signal in ("CommandPosition", "CommandVelocity", "CommandAcceleration", "ActualPosition")]
    again = arcline.Cell(CELL, set={"Start": 1})
    parts = []
    for count in (1, 7, 100, len(rows) - 108):
        parts.append(again.trace(names, count))
        assert again["X.CommandPosition"] == np.float32(parts[-1][-1][0])
    assert np.array_equal(np.concatenate(parts), rows[:, 2:])
    assert again.tags_json() == cell.tags_json()


def test_two_runs_are_equal_and_a_phase_is_another_run():
    (one, _), (two, _) = done(), done()
    assert one.tags_json() == two.tags_json()
    continuous = project("ADD(Secret,1,Secret);").replace('Type="PERIODIC" Rate="10"', 'Type="CONTINUOUS"')
    scans = []
    for seed in (None, 3, 3, 4):
        cell = arcline.Cell(continuous, scan_phase=seed)
        cell.run(1.0)
        scans.append(cell["Secret"])
    assert scans[0] == 251 and scans[1] == scans[2] < scans[0]


def test_time_passes_in_ticks_and_seconds():
    cell = arcline.Cell(CELL)
    assert (cell.tick, cell.time, cell.period, cell.axes) == (0, 0.0, 0.004, ["X"])
    cell.step(0)
    cell.run(0.0)
    assert cell["Program:Main.Scans"] == 0
    cell.step()
    assert (cell.tick, cell["Program:Main.Scans"]) == (0, 1)
    cell.step(5)
    assert (cell.tick, cell.time, cell["Program:Main.Scans"]) == (5, 0.02, 3)
    cell.run(0.1)
    assert cell.time == 0.12
    fresh = arcline.Cell(CELL)
    fresh.run(0.12)
    assert fresh.tags_json() == cell.tags_json()
    assert cell.run_until("Program:Main.Scans > 3") == 0.0, "it is true already"
    with pytest.raises(ValueError):
        cell.run(-1.0)


def test_tags_are_python_values():
    tags = (
        '<Tag Name="Grid" TagType="Base" DataType="DINT" Dimensions="2 3"/><Tag Name="Flags" TagType="Base" DataType="BOOL" Dimensions="40"/>'
        '<Tag Name="Word" TagType="Base" DataType="STRING"/>'
    )
    cell = arcline.Cell(project("NOP();", tags=tags))
    cases = [
        ("Start", True), ("Target", 12.5), ("Fixed", -3), ("Secret", 4), ("Batch.Steps", [7, 8, 9]), ("Batch.Steps[1]", 80), ("Middle", 81),
        ("Fixed.31", False), ("Grid", [[1, 2, 3], [4, 5, 6]]), ("Grid[1,1]", 55), ("Flags[33]", True), ("Word", "ready"),
        ("Program:Main.Settle.PRE", 500), ("program:main.settle.EN", True),
    ]
    for path, value in cases:
        cell[path] = value
        read = cell[path]
        assert read == value and type(read) is type(value), path
    assert cell["Batch"] == {"Steps": [7, 81, 9], "Speed": 80.0}
    assert cell["Flags"] == [bit == 33 for bit in range(40)]
    assert cell["X"]["CommandPosition"] == 0.0
    assert "Program:Main.Settle.ACC" in cell and "Program:Main.Setle" not in cell
    assert {"Start", "Secret", "Program:Main.Once", "X"} <= set(cell.tags())
    assert json.loads(cell.tags_json())["Grid"] == cell["Grid"]


def test_names_and_values_that_are_wrong_are_errors():
    cell = arcline.Cell(CELL)
    cases = [
        (arcline.TagError, "Strat", 1, 'there is no tag "Strat"; did you mean "Start"?'),
        (arcline.TagError, "Program:Main.Scan", 1, 'did you mean "Program:Main.Scans"?'),
        (arcline.TagError, "Batch.Sped", 1, 'has no member "Sped", did you mean "Speed"?'),
        (arcline.TagError, "Batch.Steps[3]", 1, "index 3 is out of range"),
        (arcline.TagError, "Batch..Speed", 1, "no path of a tag"),
    ]
    for error, path, value, text in cases:
        with pytest.raises(error) as read:
            cell[path]
        with pytest.raises(error) as written:
            cell[path] = value
        assert text in str(read.value) and text in str(written.value), (path, read.value, written.value)
    for path, value, text in [("Fixed", 1.5, "whole numbers"), ("Fixed", 2**40, "cannot hold"), ("Target", "ab", "another kind"), ("Start.0", 1, "has no bit")]:
        with pytest.raises(arcline.ArclineError, match=text):
            cell[path] = value
    with pytest.raises(TypeError):
        cell["Target"] = object()


def test_a_condition_that_does_not_come_shows_the_state():
    cell = arcline.Cell(CELL)
    with pytest.raises(arcline.TimeoutError) as error:
        cell.run_until("Done AND Program:Main.Settle.ACC >= 50", 0.5)
    text = str(error.value)
    assert text.startswith("Done AND Program:Main.Settle.ACC >= 50 did not become true in 0.5 s of simulated time: ")
    for part in ("Done is False", "Program:Main.Settle.ACC is 0", "X is at 0"):
        assert part in text, text
    assert cell.time == 0.5
    with pytest.raises(arcline.TimeoutError, match="the condition did not become true"):
        cell.run_until(lambda: cell["Done"], 0.1)
    with pytest.raises(arcline.TagError, match='did you mean "Done"'):
        cell.run_until("Dune", 1)
    with pytest.raises(arcline.ProgramError, match="Done AND"):
        cell.run_until("Done AND", 1)


def test_a_major_fault_is_an_exception_with_its_place():
    tags = '<Tag Name="At" TagType="Base" DataType="DINT"/>'
    cell = arcline.Cell(project("NOP();", "MOV(0,Batch.Steps[At]);", tags=tags))
    cell.run(0.1)
    assert cell.faults == []
    cell["At"] = 3
    with pytest.raises(arcline.MajorFault) as error:
        cell.run(1.0)
    fault = error.value
    assert (fault.type, fault.code, fault.program, fault.routine, fault.rung, fault.line, fault.instruction) == (4, 20, "Main", "Go", 1, None, "MOV")
    assert str(fault) == "major fault 4/20 (subscript out of range) in Main/Go rung 1, MOV: At is 3"
    tick = cell.tick
    with pytest.raises(arcline.MajorFault):
        cell.step()
    assert cell.tick == tick, "the tasks have stopped"
    assert [str(fault) for fault in cell.faults] == [str(fault)]


def test_a_fault_of_an_axis_reaches_the_program():
    cell = arcline.Cell(CELL, set={"Start": 1})
    cell.run_until("Program:Main.Move.IP", 1)
    cell.fault("X", "overcurrent")
    cell.run(0.5)
    assert not cell["Program:Main.Move.IP"] and not cell["Done"] and cell["X.CommandPosition"] < 25.0
    cell.clear_faults("X")
    with pytest.raises(arcline.TagError, match="there is no axis"):
        cell.fault("Q", "overcurrent")


def test_projects_that_do_not_run_say_why(tmp_path):
    with pytest.raises(FileNotFoundError):
        arcline.Cell(tmp_path / "nowhere.L5X")
    broken = tmp_path / "Broken.L5X"
    broken.write_text("<RSLogix5000Content>\n<Controller></RSLogix5000Content>")
    with pytest.raises(arcline.ProjectError, match=r"Broken\.L5X:2:"):
        arcline.Cell(broken)
    broken.write_bytes(b"<a>\n\xff</a>")
    with pytest.raises(arcline.ProjectError, match=r"Broken\.L5X:2: not UTF-8"):
        arcline.Cell(broken)
    text = project("PID(Batch);", "MOV(1,Secret);")
    with pytest.raises(arcline.ProjectError) as error:
        arcline.Cell(text)
    assert error.value.findings == ["Main/Go rung 0: instruction PID is not supported"]
    cell = arcline.Cell(text, allow_missing=True)
    cell.step()
    assert (cell.findings, cell["Secret"]) == (error.value.findings, 1)
    with pytest.raises(arcline.ConfigError):
        arcline.Cell(CELL, "[[axis]]\nname = 5\n")


def test_a_project_runs_on_the_machine_of_a_configuration():
    machine = arcline.DEFAULT_CONFIG
    cell = arcline.Cell(CELL, machine, set={"Start": 1})
    assert cell.axes[:3] == ["X", "Y", "Z"] and cell.period == 0.001
    cell.run_until("Done", 10)
    assert cell["X.CommandPosition"] == 25.0
    cell["Move1.Position"] = [0.0, 5.0, 0.0]
    cell["Move1.EnableIn"] = True
    cell.run(5.0)
    assert cell["Move1.MotionControl.ER"] or cell["Y.CommandPosition"] == 5.0


def test_simulate_refuses_what_does_not_belong_to_the_program():
    for given in ({"queue_full": "error"}, {"keep_going": True}, {"plant": lambda *_: None}, {"until": 5.0}):
        with pytest.raises(TypeError):
            arcline.simulate(CELL, **given)
    for given in ({"scan_phase": 1}, {"allow_missing": True}, {"tags_json": "tags.json"}, {"until": "Done"}):
        with pytest.raises(TypeError):
            arcline.simulate("DELAY(1);", **given)
    result = arcline.simulate(CELL, set={"Start": 1}, until="Done", trace=["X.CommandPosition"]).check()
    assert result.positions == {"X": 25.0} and float(result.trace[-1][0]) == 25.0 and len(result.trace) == result.ticks + 1
    fault = arcline.simulate(CELL, until="Done", max_seconds=0.1).error
    assert isinstance(fault, arcline.TimeoutError)
    with pytest.raises(arcline.TagError):
        arcline.simulate(CELL, set={"Strat": 1})


def test_deep_routines_have_stack_enough():
    deep = "(" * 60 + "Target" + ")" * 60
    cell = arcline.Cell(project(f"CMP({deep} > 1.0)OTE(Done);"))
    cell.step()
    assert cell["Done"]
    # A routine that calls itself ends in a fault of the program, and not in one of the process.
    with pytest.raises(arcline.MajorFault) as error:
        arcline.Cell(project("JSR(Go,0);")).step()
    assert error.value.code == 84


def test_ctrl_c_ends_a_run_and_other_threads_run_meanwhile():
    cell = arcline.Cell(LADDER)
    counted = []
    over = threading.Event()

    def count():
        while not over.is_set():
            counted.append(cell.tick)

    def interrupt():
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

    threads = [threading.Thread(target=count), threading.Thread(target=interrupt)]
    # A shell lets its background jobs ignore it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    began = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            for thread in threads:
                thread.start()
            cell.run(1e8)
    finally:
        over.set()
        for thread in threads:
            thread.join()
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - began < 60
    assert len(set(counted)) > 1
    tick = cell.tick
    cell.step()
    assert cell.tick == tick + 1
