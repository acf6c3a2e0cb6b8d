"""A coordinated-motion controller on a virtual clock.

>>> import arcline
>>> m = arcline.Machine()
>>> m.program("MCLM(CS1, M1, Absolute, [10, 5, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);").wait()
>>> m["X.CommandPosition"], m["M1.PC"]
(10.0, True)
"""

from arcline._arcline import DEFAULT_CONFIG, Batch, __version__
from arcline.cases import campaign, chunks, simulate_many
from arcline.cell import Cell
from arcline.errors import (
    ArclineError,
    ConfigError,
    MajorFault,
    MotionError,
    ProgramError,
    ProjectError,
    TagError,
    TagValueError,
    TimeoutError,
)
from arcline.machine import Event, Machine, Program, Result, simulate
from arcline.plant import Feedback, Plant, SetPoints

__all__ = [
    "DEFAULT_CONFIG",
    "ArclineError",
    "Batch",
    "Cell",
    "ConfigError",
    "Event",
    "Feedback",
    "Machine",
    "MajorFault",
    "MotionError",
    "Plant",
    "Program",
    "ProgramError",
    "ProjectError",
    "Result",
    "SetPoints",
    "TagError",
    "TagValueError",
    "TimeoutError",
    "__version__",
    "campaign",
    "chunks",
    "simulate",
    "simulate_many",
]
