"""The arrays that a plant behind the drives gets at each tick: the set-points of its axes, and the feedback that it fills in.

A plant is a callable of ``(set_points, feedback)``, given to :class:`arcline.Machine` or :func:`arcline.simulate`. Positions are those of the machine, in
position units, without the redefinitions of homing and MRP.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

__all__ = ["Feedback", "Plant", "SetPoints"]

_Row = npt.NDArray[np.float64]


class SetPoints:
    """The set-points of the axes of a plant at a tick. The arrays are the same at every tick: copy the ones to store."""

    #: The names of the axes, in the order of the arrays.
    axes: list[str]
    #: Seconds of a tick.
    period: float
    #: The set-point of each axis, position units.
    position: _Row
    #: Position units per second.
    velocity: _Row
    #: Position units per second².
    acceleration: _Row

    def __init__(self, axes: list[str], period: float, values: npt.NDArray[np.float64]) -> None:
        self.axes = axes
        self.period = period
        self.position, self.velocity, self.acceleration, self._enable, self._time = values

    @property
    def enable(self) -> npt.NDArray[np.bool_]:
        """Whether the drive of each axis is to hold it and to follow."""
        enable: npt.NDArray[np.bool_] = np.not_equal(self._enable, 0.0)
        return enable

    @property
    def time(self) -> float:
        """Seconds at the tick."""
        return float(self._time[0]) if len(self._time) else 0.0


class Feedback:
    """The feedback of the axes of a plant at a tick, of which the plant writes the part that it knows.

    ``position`` holds the answer of the simulated drive of each axis, and the set-point of an axis that the plant has moved otherwise before: a plant that
    writes nothing changes nothing. ``velocity`` and ``acceleration``
    are NaN, which stands for the change since the last tick. ``fault`` is 0; any other number is a fault of the drive.
    """

    #: The names of the axes, in the order of the arrays.
    axes: list[str]
    #: The position of each axis, position units.
    position: _Row
    #: Position units per second.
    velocity: _Row
    #: Position units per second².
    acceleration: _Row
    #: Not 0: the drive of the axis has a fault.
    fault: _Row

    def __init__(self, axes: list[str], values: npt.NDArray[np.float64]) -> None:
        self.axes = axes
        self.position, self.velocity, self.acceleration, self.fault = values


class Plant(Protocol):
    """A callable that gets the set-points of a tick and writes the feedback. What it returns is not looked at."""

    def __call__(self, set_points: SetPoints, feedback: Feedback, /) -> object:
        """One tick."""
