"""Projects of controllers: their programs beside their machines."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from typing import Any

from arcline import _arcline
from arcline.errors import TimeoutError

__all__ = ["Cell"]

#: A tag or a part of one in an expression.
_NAME = re.compile(r"\\?[A-Za-z_](?:\w|:(?=\w)|\.(?=\w)|\[[\w,]+\])*")


class Cell(_arcline.Cell):
    """The program of a controller project (L5X) beside its machine, on a virtual clock: what ``arcline-server simulate Cell.L5X`` runs.

    ``project`` is a file, or the text of one. The machine is that of the project, or that of ``config``, which is as for :class:`Machine`.
    ``scan_phase`` is a seed by which the scans of the continuous task fall in other ticks, to find races. With ``allow_missing`` a project runs of
    which parts are not supported; ``findings`` names them. ``set`` is written to tags before the first scan.

    Tags are read and written by name, those of a program as ``Program:Main.Tag``, also those that clients of a controller do not see; members, elements
    and bits as in a routine. Time stands still between calls, and the cell stands at the end of the tick that was scanned last: what is written is seen
    by the next scan. Before the first scan it is tick 0. The same calls in the same order give the same state to the bit.

    >>> cell = Cell("Cell.L5X")
    >>> cell["Start"] = 1
    >>> cell.run_until("Done", 10)
    0.452
    >>> cell["X.CommandPosition"], cell["Program:Main.Settle.ACC"], cell["Batch.Steps"]
    (25.0, 50, [4, 5, 6])
    >>> cell["Strat"]
    Traceback (most recent call last):
        ...
    arcline.errors.TagError: there is no tag "Strat"; did you mean "Start"?
    """

    def __new__(
        cls,
        project: str | os.PathLike[str],
        config: str | os.PathLike[str] | None = None,
        *,
        scan_phase: int | None = None,
        allow_missing: bool = False,
        set: Mapping[str, Any] | None = None,
    ) -> Cell:
        text = None if config is None else os.fspath(config)
        cell = super().__new__(cls, os.fspath(project), text, scan_phase=scan_phase, allow_missing=allow_missing)
        for tag, value in (set or {}).items():
            cell[tag] = value
        return cell

    def get(self, tag: str) -> Any:
        """The value of a tag, as ``cell[tag]``.

        >>> Cell("Cell.L5X").get("Target")
        25.0
        """
        return self[tag]

    def set(self, tag: str, value: Any) -> None:
        """Writes a value to a tag, as ``cell[tag] = value``.

        >>> cell = Cell("Cell.L5X")
        >>> cell.set("Batch.Steps", [7, 8, 9])
        >>> cell.get("Middle")
        8
        """
        self[tag] = value

    def run_until(self, condition: str | Callable[[], object], max_seconds: float = 60.0) -> float:
        """Lets time pass until a tag, or an expression of tags as routines have it, is true, or a function returns true. Returns the seconds that it took.

        The condition is looked at at the end of each tick, the present one first. A function of Python at each tick takes far longer than the tick itself.
        A :class:`TimeoutError` shows the tags of the expression, the axes and the faults.

        >>> cell = Cell("Cell.L5X", set={"Start": 1})
        >>> cell.run_until("Program:Main.Scans >= 10 AND NOT Done", 1)
        0.092
        >>> cell.run_until(lambda: cell["X.CommandPosition"] > 10.0) < 0.2
        True
        """
        began = self.time
        if isinstance(condition, str):
            if self._until(condition, max_seconds):
                return self.time - began
            raise TimeoutError(self._not_reached(condition, max_seconds))
        while not condition():
            if self.time - began >= max_seconds:
                raise TimeoutError(self._not_reached("the condition", max_seconds))
            self.step()
        return self.time - began

    def clear_faults(self, axis: str) -> None:
        """Takes the injected causes of faults of an axis away. Its faults stay until MAFR or MASR resets them.

        >>> cell = Cell("Cell.L5X")
        >>> cell.fault("X", "overcurrent")
        >>> cell.clear_faults("X")
        """
        self.fault(axis, None)

    def _not_reached(self, condition: str, seconds: float) -> str:
        names = dict.fromkeys(name.removeprefix("\\") for name in _NAME.findall(condition))
        state = [f"{name} is {self[name]!r}" for name in names if name in self and not isinstance(self[name], (dict, list))]
        state += [f"{axis} is at {self[axis + '.ActualPosition']:.6g}" for axis in self.axes]
        state += [str(fault) for fault in self.faults]
        return f"{condition} did not become true in {seconds} s of simulated time: {', '.join(state)}"
