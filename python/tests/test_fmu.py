"""An FMU as the plant of an axis, made by PythonFMU3 and stepped by FMPy."""

from pathlib import Path

import numpy as np
import pytest
from test_plant import MOVE, closed_form

import arcline

pytest.importorskip("fmpy")
builder = pytest.importorskip("pythonfmu3.builder")

from arcline.fmu import FmuAxis, FmuPlant  # noqa: E402

FOLDER = Path(__file__).parent / "fmu"
VARIABLES = FmuAxis("x", "v", command_position="r", command_velocity="rv")


@pytest.fixture
def fmu(request, tmp_path):
    return tmp_path / builder.FmuBuilder.build_FMU(FOLDER / f"{request.param}.py", dest=tmp_path)


@pytest.mark.parametrize("fmu", ["ideal"], indirect=True)
def test_an_ideal_fmu_gives_the_trace_of_the_simulated_drives_to_the_bit(fmu, tmp_path):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(fmu)) == []
    text = "MCLM(CS1, M1, Absolute, [30, 20, 10], 200, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2); WAIT(M1.PC);" + MOVE.replace("M1", "M2")
    files = [(tmp_path / f"{name}.csv", tmp_path / f"{name}.jsonl") for name in ("simulated", "fmu")]
    arcline.simulate(text, trace_csv=files[0][0], events_jsonl=files[0][1]).check()
    with FmuPlant(fmu, {"X": VARIABLES}) as plant:
        arcline.simulate(text, trace_csv=files[1][0], events_jsonl=files[1][1], plant=plant, plant_axes=plant.axes).check()
    for simulated, planted in zip(*files):
        assert simulated.read_bytes() == planted.read_bytes()


@pytest.mark.parametrize("fmu", ["spring_mass"], indirect=True)
def test_a_mass_on_a_spring_moves_as_the_closed_form_says(fmu):
    for hertz in (27.0, 41.0):
        with FmuPlant(fmu, {"X": VARIABLES}, start={"hertz": hertz}) as plant:
            m = arcline.Machine(plant=plant, plant_axes=plant.axes)
            m.program(MOVE)
            actual = m.trace(["X.ActualPosition"], 1000)[:, 0]
        assert np.abs(actual - closed_form(np.arange(1000) / 1000, hertz)).max() < 1e-9
        assert np.abs(actual[600:] - 40.0).max() > 1e-3


@pytest.mark.parametrize("fmu", ["ideal"], indirect=True)
def test_a_step_that_fails_is_an_exception_and_a_fault(fmu):
    with FmuPlant(fmu, {"X": VARIABLES}, start={"ends": 0.0995}) as plant:
        m = arcline.Machine(plant=plant, plant_axes=plant.axes)
        m.program(MOVE)
        with pytest.raises(Exception, match="fmi3DoStep"):
            m.step(1000)
        assert m.tick == 101 and m["X.AxisFault"] != 0
    for axis, start, words in [(VARIABLES._replace(position="y"), {}, "no variable 'y'"), (VARIABLES, {"mass": 1.0}, "no variable 'mass'")]:
        with pytest.raises(ValueError, match=words):
            FmuPlant(fmu, {"X": axis}, start)


@pytest.mark.parametrize("fmu", ["ideal"], indirect=True)
def test_an_fmu_is_of_one_machine(fmu):
    with FmuPlant(fmu, {"X": VARIABLES}) as plant:
        m = arcline.Machine(plant=plant, plant_axes=plant.axes)
        with pytest.raises(ValueError, match="at 0.0 s, and the machine at 0.0 s: an FMU is the plant of one machine"):
            arcline.Machine(plant=plant, plant_axes=plant.axes)
        m.step(100)
        with pytest.raises(ValueError, match="at 0.1 s, and the machine at 0.0 s"):
            arcline.simulate(MOVE, plant=plant, plant_axes=plant.axes)
        m.step(1)
        assert m["X.AxisFault"] == 0


@pytest.mark.parametrize("fmu", ["ideal"], indirect=True)
@pytest.mark.parametrize(
    ("result", "words"),
    [
        ((False, True, False, 0.05), "ends the simulation at 0.05 s"),
        ((False, False, True, 0.0495), "returned early, at 0.0495 s"),
    ],
)
def test_an_fmu_that_does_not_do_the_whole_step_is_an_error(fmu, monkeypatch, result, words):
    with FmuPlant(fmu, {"X": VARIABLES}) as plant:
        does = plant._fmu.doStep

        def step(currentCommunicationPoint, communicationStepSize):
            done = does(currentCommunicationPoint=currentCommunicationPoint, communicationStepSize=communicationStepSize)
            assert done[1:3] == (False, False)
            return result if currentCommunicationPoint > 0.0485 else done

        monkeypatch.setattr(plant._fmu, "doStep", step)
        m = arcline.Machine(plant=plant, plant_axes=plant.axes)
        with pytest.raises(RuntimeError, match=words):
            m.step(1000)
        assert m.tick == 50 and m["X.AxisFault"] != 0
