"""Machines, programs and their results."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from arcline import _arcline
from arcline.errors import TimeoutError
from arcline.plant import Plant

__all__ = ["Event", "Machine", "Program", "Result", "simulate"]



class Event(NamedTuple):
    """A change of an instruction's status."""

    #: Seconds since the beginning.
    time: float
    #: The tick.
    tick: int
    #: The motion control tag; empty: none.
    tag: str
    #: The mnemonic.
    instruction: str
    #: Bits that were set, such as ``["DN", "IP"]``.
    set: list[str]
    #: Bits that were cleared.
    clear: list[str]
    #: ERR.
    err: int
    #: EXERR.
    exerr: int


class Machine(_arcline.Machine):
    """A machine on a virtual clock, with its tags and programs.

    It stands within a tick: writes and programs act at that instant, and time passes by :meth:`step`, :meth:`run`, :meth:`until` and
    :meth:`trace` only. The same calls in the same order give the same state to the bit; ``seed`` is kept for what a caller makes at random.
    ``set`` is written to tags at the beginning. With ``journal=False`` the machine does not remember what was done, and cannot be pickled.

    ``plant`` is a callable of ``(set_points, feedback)``, called once in every tick: it gets the set-points of the axes (:class:`SetPoints`) and writes
    where they are (:class:`Feedback`). ``plant_axes`` names the axes that it moves; without it they are all that have a drive. An exception of
    the plant is raised by the call that lets time pass; its axes have the fault ``drive`` then, and the plant is not called any more. Ctrl-C while
    the plant is at work is no exception of the plant: the tick passes with the feedback of the one before. A machine with a plant cannot be saved.

    >>> m = Machine()
    >>> m["Move1.Speed"] = 250.0
    >>> m.step(10)
    >>> m.tick, m.time, m["Move1.Speed"]
    (10, 0.01, 250.0)
    >>> m["Move1.Sped"]
    Traceback (most recent call last):
        ...
    arcline.errors.TagError: Move1.Sped: MCLM has no member "Sped", did you mean "Speed"?
    """

    def __new__(
        cls,
        config: str | os.PathLike[str] | None = None,
        *,
        seed: int = 0,
        set: Mapping[str, Any] | None = None,
        journal: bool = True,
        plant: Plant | None = None,
        plant_axes: Sequence[str] | None = None,
    ) -> Machine:
        text = None if config is None else os.fspath(config)
        axes = None if plant_axes is None else list(plant_axes)
        values = list((set or {}).items())
        return super().__new__(cls, text, seed=seed, set=values, journal=journal, plant=plant, plant_axes=axes)

    def program(self, text: str, *, queue_full: str = "wait", keep_going: bool = False) -> Program:
        """Starts a program in Structured Text: it runs at the present tick until it waits, and continues as time passes.

        >>> m = Machine()
        >>> p = m.program("MSO(X, On); WAIT(On.DN); DELAY(0.5);")
        >>> p.done
        False
        >>> m.run(1.0)
        >>> p.done
        True
        """
        if queue_full not in ("wait", "error"):
            raise ValueError(f"queue_full is {queue_full!r}, expected 'wait' or 'error'")
        return Program(self, self._start(text, queue_full == "wait", keep_going))

    def until(self, condition: str | Callable[[], object], *, timeout: float = 60.0, every: int = 1) -> float:
        """Lets time pass until a tag is not 0, or a function returns true, and returns the seconds that it took.

        The condition is looked at first, and then every ``every`` ticks. A function of Python at each tick takes far longer than the tick itself.

        >>> m = Machine()
        >>> p = m.program("DELAY(0.25);")
        >>> m.until(lambda: p.done, timeout=1.0)
        0.25
        """
        if every < 1:
            raise ValueError(f"every is {every}, expected 1 or more ticks")
        is_true = condition if callable(condition) else lambda: self[condition]
        began = self.time
        while not is_true():
            if self.time - began >= timeout:
                what = condition if isinstance(condition, str) else "the condition"
                raise TimeoutError(f"{what} did not become true in {timeout} s of simulated time")
            self.step(every)
        return self.time - began

    def events(self) -> list[Event]:
        """The changes of instructions since the last call. They are collected from the first call on; those of the present tick come when it has passed.

        >>> m = Machine()
        >>> m.events()
        []
        >>> p = m.program("MSO(X, On);")
        >>> m.step(1)
        >>> [(event.tick, event.tag, event.set) for event in m.events()]
        [(0, 'On', ['EN', 'DN'])]
        """
        self._collect_events()
        return [Event(*row) for row in self._events()]

    def clear_faults(self, axis: str, *, at: float | None = None) -> None:
        """Takes the injected causes of faults of an axis away. Its faults stay until MAFR or MASR resets them.

        >>> m = Machine()
        >>> m.fault("X", "overcurrent")
        >>> m.clear_faults("X")
        """
        self.fault(axis, None, at)

    def save(self) -> bytes:
        """The state, as the inputs that led to it: :meth:`restore` does them again.

        >>> m = Machine()
        >>> m.run(0.1)
        >>> state = m.save()
        >>> m.run(0.1)
        >>> m.restore(state)
        >>> m.tick
        100
        """
        return pickle.dumps(self._journal())

    def restore(self, state: bytes) -> None:
        """Brings the machine to a state of :meth:`save`, to the bit. It takes as long as to run there. Programs are those of the state:
        programs that were started by then go on, those that were started since are gone. :meth:`events` has those behind the state.

        Read states of your own only: as everything that is pickled, a state of a stranger can run code.
        """
        config, _, journal = pickle.loads(state)
        self._restore(config, journal)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, self._journal()


def _restored(config: str, seed: int, journal: list[tuple[Any, ...]]) -> Machine:
    machine = Machine(config, seed=seed)
    machine._replay(journal)
    return machine


class Program:
    """A program of a :class:`Machine`."""

    def __init__(self, machine: Machine, number: int) -> None:
        self._machine = machine
        self._number = number

    @property
    def done(self) -> bool:
        """Whether the program has ended. Motion that it began may go on."""
        return not self._machine._runs(self._number)

    @property
    def error(self) -> BaseException | None:
        """Why it failed: a :class:`MotionError` with ERR and EXERR, or a :class:`ProgramError`; None: it did not.

        >>> p = Machine().program("MAM(X, M1, Absolute, 5, -1);")
        >>> p.error
        MotionError(13, 4, 'ERR 13 Parameter Out Of Range, operand 4 (Speed)', 'MAM', 1, 'M1')
        """
        return self._machine._error(self._number)

    def wait(self, timeout: float = 3600.0) -> None:
        """Lets time pass until the program and all motion have ended, and raises its error.

        >>> m = Machine()
        >>> m.program("DELAY(0.1);").wait()
        >>> m.tick
        100
        """
        machine = self._machine
        began = machine.time
        while not (self.done and (self.error is not None or machine.at_rest)):
            if machine.time - began >= timeout:
                raise TimeoutError(f"the program is not at its end after {timeout} s of simulated time")
            machine.step(1)
        error = self.error
        if error is not None:
            raise error

    def stop(self) -> None:
        """Ends the program where it is. Motion that it began goes on."""
        self._machine._remove(self._number)


class Result(NamedTuple):
    """The result of a simulation."""

    #: The error of the program; None: it ran to its end.
    error: BaseException | None
    #: Simulated seconds.
    time: float
    #: The last tick.
    ticks: int
    #: Command positions of the axes at the end.
    positions: dict[str, float]
    #: A row of the signals for each tick.
    trace: npt.NDArray[np.float64]

    def check(self) -> Result:
        """Raises the error, if there is one; returns the result."""
        if self.error is not None:
            raise self.error
        return self


def simulate(
    program: str | os.PathLike[str],
    config: str | os.PathLike[str] | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    trace: Sequence[str] = (),
    until: float | str | None = None,
    max_seconds: float = 60.0,
    queue_full: str = "wait",
    keep_going: bool = False,
    scan_phase: int | None = None,
    allow_missing: bool = False,
    trace_csv: str | os.PathLike[str] | None = None,
    events_jsonl: str | os.PathLike[str] | None = None,
    tags_json: str | os.PathLike[str] | None = None,
    plant: Plant | None = None,
    plant_axes: Sequence[str] | None = None,
) -> Result:
    """Runs a program from its beginning until it and all motion have ended, or a controller project, as ``arcline-server simulate`` does.

    ``program`` is a text, or a file when it ends with ``.st`` or is a path. ``trace`` names signals of axes; ``trace_csv`` and ``events_jsonl``
    are files, the same bytes as those of ``--trace`` and ``--events``. ``until`` is the longest simulated time, 3600 s if not given. ``plant`` and
    ``plant_axes`` are those of :class:`Machine`; an exception of the plant ends the run and is raised.

    A file that ends with ``.L5X`` is a project, which runs until the expression ``until`` is true, and for ``max_seconds`` at most; without
    ``until`` for ``max_seconds``. ``scan_phase`` and ``allow_missing`` are those of :class:`Cell`; ``tags_json`` is a file, the same bytes as
    that of ``--tags``. The error of the result is a :class:`MajorFault`, or a :class:`TimeoutError` when the expression did not become true.
    :class:`Cell` runs a project step by step.

    >>> r = simulate("MAM(X, M1, Absolute, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);", trace=["X.CommandPosition"])
    >>> r.positions["X"], r.trace.shape, float(r.trace.max())
    (5.0, (201, 1), 5.0)
    """
    name = os.fspath(program)
    if "\n" not in name and name.lower().endswith(".l5x"):
        others = {"queue_full": queue_full != "wait", "keep_going": keep_going, "plant": plant, "plant_axes": plant_axes}
        for what in (what for what, given in others.items() if given):
            raise TypeError(f"{what} is for programs in Structured Text, not for projects")
        if not isinstance(until, (str, type(None))):
            raise TypeError("until of a project is an expression of tags; max_seconds is its longest time")
        return Result(
            *_arcline._simulate_project(
                name,
                None if config is None else os.fspath(config),
                list((set or {}).items()),
                list(trace),
                until,
                max_seconds,
                scan_phase,
                allow_missing,
                None if trace_csv is None else os.fspath(trace_csv),
                None if events_jsonl is None else os.fspath(events_jsonl),
                None if tags_json is None else os.fspath(tags_json),
            )
        )
    of_projects = {"scan_phase": scan_phase is not None, "allow_missing": allow_missing, "tags_json": tags_json is not None}
    for what in (what for what, given in of_projects.items() if given):
        raise TypeError(f"{what} is for projects (.L5X), not for programs in Structured Text")
    if isinstance(until, str):
        raise TypeError("until of a program in Structured Text is its longest time in seconds")
    is_file = not isinstance(program, str) or (program.endswith(".st") and "\n" not in program)
    text = Path(program).read_text() if is_file else str(program)
    if queue_full not in ("wait", "error"):
        raise ValueError(f"queue_full is {queue_full!r}, expected 'wait' or 'error'")
    row = _arcline._simulate(
        text,
        None if config is None else os.fspath(config),
        list((set or {}).items()),
        list(trace),
        3600.0 if until is None else until,
        queue_full == "wait",
        keep_going,
        None if trace_csv is None else os.fspath(trace_csv),
        None if events_jsonl is None else os.fspath(events_jsonl),
        plant,
        None if plant_axes is None else list(plant_axes),
    )
    return Result(*row)
