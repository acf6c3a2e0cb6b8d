"""The example with MuJoCo: ramps as long as a swing leave the load at rest, short ones do not."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("matplotlib")

EXAMPLE = Path(__file__).parent.parent.parent / "examples" / "plants" / "mujoco_crane.py"


def test_the_load_of_the_crane_swings_as_a_pendulum_does(tmp_path):
    spec = importlib.util.spec_from_file_location("mujoco_crane", EXAMPLE)
    crane = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(crane)
    command, actual, angle = crane.main(tmp_path / "crane.png")
    behind = np.abs(command - actual)
    assert 0.1 < behind.max() < 1.0 and behind[-1] < 0.1, behind.max()
    arrived = int(np.argmax(command == crane.DISTANCE))
    waiting, there = angle[arrived : arrived + 2500], angle[:arrived]
    assert np.abs(waiting).max() < 0.01 < 2.0 < np.abs(there).max()
    # Two steps of acceleration a, and two back: each leaves a swing of up to 2 a/g.
    left = np.abs(angle[-2500:]).max()
    assert 10.0 < left < np.degrees(4 * 2.0 / 9.81)
    # The load swings with the period of a pendulum, longer by the effect of the amplitude: 1 + left² / 16.
    zeros = np.flatnonzero(np.diff(np.signbit(angle[-3000:])))
    period = 2e-3 * np.diff(zeros).mean()
    assert period == pytest.approx(crane.PERIOD * (1 + np.radians(left) ** 2 / 16), rel=2e-3)
    assert (tmp_path / "crane.png").stat().st_size > 10_000
