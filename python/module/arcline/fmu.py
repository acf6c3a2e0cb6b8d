"""An FMU as the plant of axes: a model of FMI 2.0 or 3.0, for co-simulation, that FMPy steps once in each tick. ``pip install fmpy``"""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from types import TracebackType
from typing import Any, NamedTuple

from arcline.plant import Feedback, SetPoints

__all__ = ["FmuAxis", "FmuPlant"]


class FmuAxis(NamedTuple):
    """The names of the variables of an FMU for an axis; None: the FMU has no such variable."""

    #: Output: where the axis is, position units.
    position: str
    #: Output: its velocity.
    velocity: str | None = None
    #: Input: where it is to be.
    command_position: str | None = None
    #: Input: its velocity then.
    command_velocity: str | None = None
    #: Input: its acceleration then.
    command_acceleration: str | None = None
    #: Input: 1 while the drive is to hold the axis, else 0.
    enable: str | None = None


class FmuPlant:
    """A plant for ``arcline.Machine(plant=..., plant_axes=plant.axes)``. All its variables are of type Float64 (Real in FMI 2.0).

    At tick 0 the FMU is initialised with the first set-points. At every later tick its inputs get the set-points of the tick, then it does a step of the length
    of a tick, then its outputs are the feedback. ``start`` gives parameters their values. A step that fails is an exception of FMPy, one that the FMU ends
    early or with the end of the simulation a :class:`RuntimeError`. An FMU is the plant of one machine: another machine, or another run, needs another.
    """

    def __init__(
        self, file: str | os.PathLike[str], axes: Mapping[str, FmuAxis], start: Mapping[str, float] | None = None
    ) -> None:
        import fmpy  # type: ignore[import-untyped, import-not-found, unused-ignore]

        description = fmpy.read_model_description(os.fspath(file))
        if description.coSimulation is None:
            raise ValueError(f"{file}: the FMU is none for co-simulation")
        #: The names of its axes.
        self.axes = list(axes)
        variables = {variable.name: variable for variable in description.modelVariables}
        rows = list(axes.values())
        for name in [*(name for row in rows for name in row if name is not None), *(start or {})]:
            if name not in variables:
                raise ValueError(f"{file}: the FMU has no variable {name!r}")
            if variables[name].type not in ("Float64", "Real"):
                raise ValueError(f"{file}: {name} is of type {variables[name].type}, expected Float64")
        self._folder = fmpy.extract(os.fspath(file))
        self._references = {name: variable.valueReference for name, variable in variables.items()}
        self._rows = rows
        self._is_2 = description.fmiVersion.startswith("2")
        self._fmu: Any = fmpy.instantiate_fmu(self._folder, description, "CoSimulation")
        self._time: float | None = None
        self._start = dict(start or {})

    def __call__(self, set_points: SetPoints, feedback: Feedback, /) -> None:
        if self._time is None:
            self._begin(set_points)
        elif set_points.time > self._time:
            self._give(set_points)
            self._step(self._time, set_points.time)
        else:
            raise ValueError(
                f"the FMU is at {self._time} s, and the machine at {set_points.time} s: an FMU is the plant of one machine, make another FmuPlant"
            )
        self._time = set_points.time
        for index, row in enumerate(self._rows):
            feedback.position[index] = self._get(row.position)
            if row.velocity is not None:
                feedback.velocity[index] = self._get(row.velocity)

    def _begin(self, set_points: SetPoints) -> None:
        if self._is_2:
            self._fmu.setupExperiment(startTime=set_points.time)
        for name, value in self._start.items():
            self._set(name, value)
        if self._is_2:
            self._fmu.enterInitializationMode()
        else:
            self._fmu.enterInitializationMode(startTime=set_points.time)
        self._give(set_points)
        self._fmu.exitInitializationMode()

    def _step(self, now: float, then: float) -> None:
        result = self._fmu.doStep(currentCommunicationPoint=now, communicationStepSize=then - now)
        if self._is_2:
            return
        _, ends, is_early, reached = result
        if ends:
            raise RuntimeError(f"the FMU ends the simulation at {reached} s")
        if is_early:
            raise RuntimeError(f"the step of the FMU to {then} s returned early, at {reached} s")

    def _give(self, set_points: SetPoints) -> None:
        enable = set_points.enable
        for index, row in enumerate(self._rows):
            for name, value in (
                (row.command_position, set_points.position[index]),
                (row.command_velocity, set_points.velocity[index]),
                (row.command_acceleration, set_points.acceleration[index]),
                (row.enable, enable[index]),
            ):
                if name is not None:
                    self._set(name, float(value))

    def _set(self, name: str, value: float) -> None:
        (self._fmu.setReal if self._is_2 else self._fmu.setFloat64)([self._references[name]], [value])

    def _get(self, name: str) -> float:
        values = (self._fmu.getReal if self._is_2 else self._fmu.getFloat64)([self._references[name]])
        return float(values[0])

    def close(self) -> None:
        """Ends the FMU, and removes what was unpacked."""
        if self._fmu is not None:
            if self._time is not None:
                self._fmu.terminate()
            self._fmu.freeInstance()
            self._fmu = None
            shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> FmuPlant:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
