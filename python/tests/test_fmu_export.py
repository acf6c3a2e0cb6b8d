"""Arcline as an FMU, made by fmi/make.sh and simulated by FMPy. Needs cargo."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import arcline

fmpy = pytest.importorskip("fmpy")

ROOT = Path(__file__).parent.parent.parent
COLUMNS = ("CommandPosition", "CommandVelocity", "CommandAcceleration", "ActualPosition")
MACHINE = arcline.DEFAULT_CONFIG + '\n[[tag]]\nname = "Go"\ntype = "BOOL"\n[[tag]]\nname = "Distance"\ntype = "REAL"\n[[tag]]\nname = "Parts"\ntype = "DINT"\n'
PROGRAM = """
MCLM(CS1, M1, Absolute, [40, 20, 10], 200, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2);
WAIT(M1.PC);
MCCM(XY, M2, Absolute, [40, 60], Center, [40, 40], CW, 150, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2);
WAIT(M2.PC);
DELAY(0.0105);
MAM(S, M3, Absolute, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);
"""

if shutil.which("cargo") is None:
    assert os.environ.get("CI") != "true", "cargo is missing"
    pytest.skip("cargo is missing", allow_module_level=True)


@pytest.fixture(scope="module")
def make(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmu")

    def make(program, *tags):
        (folder / "machine.toml").write_text(MACHINE)
        (folder / "program.st").write_text(program)
        command = [ROOT / "fmi" / "make.sh", folder / "machine.toml", folder / "program.st", folder / "arcline.fmu", *tags]
        subprocess.run(command, check=True)
        return str(folder / "arcline.fmu")

    return make


def simulate(fmu, stop, step=0.001, **more):
    return fmpy.simulate_fmu(fmu, stop_time=stop, step_size=step, output_interval=step, **more)


def test_positions_are_those_of_simulate_to_the_bit(make, tmp_path):
    from fmpy.validation import validate_fmu

    fmu = make(PROGRAM)
    assert validate_fmu(fmu) == []
    names = [f"{axis}.{column}" for axis in arcline.Machine().axes for column in COLUMNS]
    signals = [name for name in names if name[0] in "XYZS"]
    result = arcline.simulate(PROGRAM, MACHINE, trace=signals).check()
    assert result.ticks > 1000
    for every in (1, 7):
        got = simulate(fmu, result.ticks // every * every / 1000, every / 1000, output=[*signals, "done"])
        rows = np.column_stack([got[name] for name in signals])
        assert len(rows) == result.ticks // every + 1
        positions = [signals.index(name) for name in signals if name.endswith("Position")]
        np.testing.assert_array_equal(rows[:, positions], result.trace[::every][: len(rows), positions])
        assert not got["done"][-2 - 10 // every]
    assert simulate(fmu, (result.ticks + 5) / 1000, output=["done"])["done"][-1]


def test_tags_are_inputs_and_outputs(make):
    program = "WAIT(Go); MAM(X, M1, Absolute, Distance, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2); WAIT(M1.PC); Parts := Parts + 3;"
    fmu = make(program, "input", "Go", "input", "Distance", "output", "Parts", "output", "Move1.Speed")
    inputs = np.array([(0.0, False, 12.5), (0.2, True, 12.5), (9.0, True, 12.5)], dtype=[("time", "f8"), ("Go", "?"), ("Distance", "f8")])
    got = simulate(fmu, 1.0, input=inputs, output=["X.CommandPosition", "Parts", "Move1.Speed", "done", "err"])
    moving = np.flatnonzero(got["X.CommandPosition"])
    assert 0.199 <= got["time"][moving[0]] <= 0.204
    assert (got["X.CommandPosition"][-1], got["Parts"][-1], got["Parts"][0]) == (12.5, 3, 0)
    assert got["Move1.Speed"][-1] == arcline.Machine()["Move1.Speed"] and got["done"][-1] and not got["err"].any()


def test_feedback_of_a_plant_outside(make):
    """Every axis follows 50 ticks late: what the importer gives back is what it has read by then."""
    fmu = make("MAM(X, M1, Absolute, 2, 20, Unitspersec, 100, Unitspersec2, 100, Unitspersec2); WAIT(M1.PC);")
    description = fmpy.read_model_description(fmu)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    folder = fmpy.extract(fmu)
    slave = fmpy.instantiate_fmu(folder, description, "CoSimulation")
    slave.setBoolean([references["external_plant"]], [True])
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    commands, actual = [], []
    get = lambda name: slave.getFloat64([references[name]])[0]
    for tick in range(400):
        commands.append(get("X.CommandPosition"))
        actual.append(get("X.ActualPosition"))
        slave.setFloat64([references["X.Feedback"]], [commands[max(0, tick - 49)]])
        slave.doStep(currentCommunicationPoint=tick / 1000, communicationStepSize=0.001)
    assert actual[50:] == commands[:-50] and max(commands) == 2.0
    with pytest.raises(Exception, match="fmi3SetFloat64"):
        slave.setFloat64([references["X.Feedback"]], [float("nan")])
    with pytest.raises(Exception, match="fmi3DoStep"):
        slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.001)
    slave.terminate()
    slave.freeInstance()
    shutil.rmtree(folder)


def test_errors_are_outputs_and_wrong_files_are_refused(make):
    fmu = make("MAM(X, M1, Absolute, 5, -1);")
    got = simulate(fmu, 0.01, output=["err", "exerr", "done"])
    assert (got["err"][-1], got["exerr"][-1]) == (13, 4)
    with pytest.raises(subprocess.CalledProcessError):
        make("MAM(Q, M1, Absolute, 5, 1);")
    with pytest.raises(subprocess.CalledProcessError):
        make(PROGRAM, "input", "Nobody")
