"""A plant in Python behind the drives: the ideal one, a mass on a spring, and those that fail."""

import copy
import json
import math
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from test_traces import PROGRAM, text_of

import arcline

PAGE = Path(__file__).parent.parent.parent / "docs" / "PLANTS.md"

HOMING = """
[[axis]]
name = "X"
type = "servo"
max_speed = 1000
max_acceleration = 2000
max_acceleration_jerk = 40000
home = { sequence = "switch-marker", position = 100, offset = 5, speed = 50, return_speed = 20, switch = { min = 10 }, marker = { at = 3, every = 8 } }
[[axis]]
name = "V"
type = "virtual"
max_speed = 1000
max_acceleration = 2000
"""
MOVE = "MAM(X, M1, Absolute, 40, 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, Trapezoidal);"


def ideal(set_points, feedback):
    feedback.position[:] = set_points.position
    feedback.velocity[:] = set_points.velocity


def nothing(set_points, feedback):
    pass


class SpringMass:
    """A mass that a spring ties to the set-point, without damping; exact where the acceleration of the set-point is constant between ticks."""

    def __init__(self, hertz):
        self.omega = 2 * math.pi * hertz
        self.behind = self.rate = 0.0
        self.last = None

    def __call__(self, set_points, feedback):
        position, velocity = set_points.position[0], set_points.velocity[0]
        if self.last is not None:
            acceleration = (velocity - self.last) / set_points.period
            rest = -acceleration / self.omega**2
            cos, sin = math.cos(self.omega * set_points.period), math.sin(self.omega * set_points.period)
            away = self.behind - rest
            self.behind = rest + away * cos + self.rate / self.omega * sin
            self.rate = self.rate * cos - away * self.omega * sin
        self.last = velocity
        feedback.position[0] = position + self.behind
        feedback.velocity[0] = velocity + self.rate


def closed_form(times, hertz, speed=100.0, rate=1000.0, distance=40.0):
    """The position of the mass when its spring moves by a trapezoid: the sum of the responses to four steps of the acceleration."""
    omega = 2 * math.pi * hertz
    ramp = speed / rate
    whole = distance / speed + ramp
    x = np.zeros_like(times)
    for start, step in [(0.0, rate), (ramp, -rate), (whole - ramp, -rate), (whole, rate)]:
        t = np.maximum(times - start, 0.0)
        x += step * (t**2 / 2 - (1 - np.cos(omega * t)) / omega**2)
    return x


@pytest.mark.parametrize("plant", [ideal, nothing])
def test_an_ideal_plant_gives_the_trace_of_the_simulated_drives_to_the_bit(plant, tmp_path):
    homing = "MAH(X, H1); WAIT(H1.PC); " + MOVE
    cases = [(text_of(seed), None) for seed in range(12)] + [(homing, HOMING)]
    for text, config in cases:
        files = [(tmp_path / f"{name}.csv", tmp_path / f"{name}.jsonl") for name in ("simulated", "plant")]
        for (trace, events), given in zip(files, (None, plant)):
            result = arcline.simulate(text, config, until=60.0, trace_csv=trace, events_jsonl=events, plant=given)
            assert config is None or result.check().positions["X"] == 40.0
        for simulated, planted in zip(*files):
            assert simulated.read_bytes() == planted.read_bytes(), text


def test_a_plant_is_called_once_a_tick_with_the_set_points_of_its_axes():
    seen = []

    def plant(set_points, feedback):
        seen.append((set_points.time, set_points.position[0], bool(set_points.enable[0])))
        assert set_points.axes == feedback.axes == ["Y"] and np.isnan(feedback.velocity[0])

    m = arcline.Machine(plant=plant, plant_axes=["Y"])
    m.program(MOVE.replace("(X", "(Y"))
    row = m.trace(["Y.CommandPosition"], 300)[:, 0]
    assert [time for time, *_ in seen] == [tick / 1000 for tick in range(301)]
    assert [position for _, position, _ in seen[:300]] == list(row)
    assert all(enable for *_, enable in seen[1:])


def test_a_mass_on_a_spring_moves_as_the_closed_form_says():
    hertz = 27.0
    m = arcline.Machine(plant=SpringMass(hertz), plant_axes=["X"])
    p = m.program(MOVE)
    trace = m.trace(["X.CommandPosition", "X.ActualPosition", "Y.ActualPosition"], 1000)
    expected = closed_form(np.arange(1000) / 1000, hertz)
    assert np.abs(trace[:, 1] - expected).max() < 1e-9
    # The mass swings about the command position, by the effect of the acceleration.
    swing = np.abs(trace[600:, 1] - 40.0).max()
    assert 1e-3 < swing < 5 * 1000 / (2 * math.pi * hertz) ** 2
    assert trace[-1, 0] == 40.0 and not trace[:, 2].any() and p.done


def test_an_exception_of_a_plant_is_raised_and_its_axes_have_a_fault():
    calls = []

    def plant(set_points, feedback):
        calls.append(set_points.time)
        if set_points.time >= 0.25:
            raise ZeroDivisionError("the model is broken")

    m = arcline.Machine(plant=plant, plant_axes=["X"])
    m.program(MOVE.replace("40", "400") + MOVE.replace("40", "400").replace("(X, M1", "(Y, M2"))
    m.step(100)
    for letting_time_pass in (lambda: m.step(1000), lambda: m.trace(["X.CommandPosition"], 100)):
        if m["X.AxisFault"] == 0:
            with pytest.raises(ZeroDivisionError, match="the model is broken"):
                letting_time_pass()
            assert m.tick == 250 and calls[-1] == 0.25
        else:
            letting_time_pass()
    stands = m["X.ActualPosition"]
    assert m["X.AxisFault"] != 0 and m["M1.IP"] is False and 0 < stands < 30
    assert m["Y.AxisFault"] == 0 and m["Y.ActualPosition"] > stands
    assert m["X.ActualPosition"] == stands and calls[-1] == 0.25
    with pytest.raises(ZeroDivisionError):
        arcline.simulate(MOVE.replace("40", "400"), plant=plant)
    with pytest.raises(RuntimeError, match="at once"):
        arcline.Machine(plant=lambda *_: (_ for _ in ()).throw(RuntimeError("at once")))


def test_a_fault_of_a_plant_is_one_of_the_drive_and_can_be_reset():
    broken = [False]

    def plant(set_points, feedback):
        feedback.fault[0] = broken[0]

    m = arcline.Machine(plant=plant, plant_axes=["X"])
    m.program(MOVE)
    m.step(100)
    broken[0] = True
    m.step(2)
    assert m["X.AxisFault"] != 0 and m["M1.IP"] is False
    broken[0] = False
    m.program("MAFR(X, F1); WAIT(F1.DN); MSO(X, On1); WAIT(On1.DN); " + MOVE).wait()
    assert m["X.AxisFault"] == 0 and m["X.ActualPosition"] == 40.0


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit])
def test_ctrl_c_in_a_plant_is_no_fault_of_its_axes(error):
    seen = []

    def plant(set_points, feedback):
        seen.append(set_points.time)
        if len(seen) in (101, 202):
            feedback.position[:] = np.nan
            raise error
        feedback.position[:] = set_points.position + 0.5

    m = arcline.Machine(plant=plant, plant_axes=["X"])
    m.program(MOVE)
    with pytest.raises(error):
        m.step(150)
    assert m.tick == 100 and m["X.AxisFault"] == 0
    m.step(100)
    with pytest.raises(error):
        m.trace(["X.ActualPosition"], 50)
    trace = m.trace(["X.CommandPosition", "X.ActualPosition"], 500)
    assert m["X.AxisFault"] == 0 and m["M1.PC"] is True and m["X.ActualPosition"] == 40.5
    np.testing.assert_allclose(trace[2:, 1] - trace[2:, 0], 0.5, atol=1e-9)
    # The interrupted ticks have passed, with the feedback of the one before.
    assert seen == [tick / 1000 for tick in range(m.tick + 1)]


def test_ctrl_c_in_a_plant_ends_simulate():
    def plant(set_points, feedback):
        if set_points.time == 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        arcline.simulate(MOVE, plant=plant)


@pytest.mark.parametrize(
    ("write", "words"),
    [
        (lambda feedback: feedback.position.fill(math.nan), "position of X is NaN"),
        (lambda feedback: feedback.velocity.fill(math.inf), "velocity of X is inf"),
    ],
)
def test_feedback_that_is_no_number_is_an_error(write, words):
    m = arcline.Machine(plant=lambda set_points, feedback: write(feedback) if set_points.time > 0 else None)
    with pytest.raises(ValueError, match=words):
        m.step(10)
    assert m.tick == 1


def test_wrong_plants_are_refused():
    with pytest.raises(TypeError, match="callable"):
        arcline.Machine(plant=5)
    with pytest.raises(arcline.TagError, match="V"):
        arcline.Machine(HOMING, plant=ideal, plant_axes=["V"])
    m = arcline.Machine(plant=ideal)
    with pytest.raises(arcline.ArclineError, match="plant"):
        m.save()
    with pytest.raises(arcline.ArclineError, match="plant"):
        copy.copy(m)
    held = []
    inside = arcline.Machine(plant=lambda *_: held and held[0].tick)
    held.append(inside)
    with pytest.raises(RuntimeError, match="its own machine"):
        inside.step(1)


def test_the_examples_of_the_page(tmp_path, monkeypatch, capsys):
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.M | re.S)
    assert len(blocks) == 3
    names = {}
    exec(blocks[0], names)
    assert re.fullmatch(r"swings to 4[01]\.\d\d mm\n", capsys.readouterr().out)
    assert names["trace"][-1, 0] == 40.0 < names["trace"][:, 1].max()
    if PROGRAM is not None:
        (tmp_path / "part.st").write_text(MOVE)
        monkeypatch.chdir(tmp_path)
        exec(blocks[2].replace('"arcline-server"', repr(PROGRAM)), names)
        assert capsys.readouterr().out.startswith("0 {'X': 40.0, 'Y': 0.0, ")


@pytest.mark.skipif(PROGRAM is None, reason="no arcline-server: name it by ARCLINE_SERVER_PROGRAM")
def test_the_same_plant_over_a_pipe_gives_the_same_trace(tmp_path):
    (tmp_path / "part.st").write_text(MOVE)
    arcline.simulate(MOVE, plant=SpringMass(27.0), plant_axes=["X"], trace_csv=tmp_path / "here.csv").check()
    command = [PROGRAM, "simulate", "part.st", "--step", "--trace", "there.csv"]
    child = subprocess.Popen(command, cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    head = json.loads(child.stdout.readline())
    plant = SpringMass(27.0)
    for line in child.stdout:
        sent = json.loads(line)
        rows = [np.array(sent[key]) for key in ("position", "velocity", "acceleration", "enable")]
        set_points = arcline.SetPoints(head["axes"], head["period_s"], np.array([*rows, rows[0]]))
        feedback = arcline.Feedback(head["axes"], np.full((4, len(head["axes"])), np.nan))
        plant(set_points, feedback)
        position, velocity = ([None if math.isnan(value) else value for value in row] for row in (feedback.position, feedback.velocity))
        child.stdin.write(json.dumps({"position": position, "velocity": velocity}) + "\n")
        child.stdin.flush()
    assert child.wait() == 0
    assert (tmp_path / "here.csv").read_bytes() == (tmp_path / "there.csv").read_bytes()
