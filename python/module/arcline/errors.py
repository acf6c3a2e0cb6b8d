"""The exceptions of arcline. All of them are an :class:`ArclineError`."""

from __future__ import annotations

import builtins


class ArclineError(Exception):
    """An error of arcline."""


class ConfigError(ArclineError, ValueError):
    """A configuration that is not valid; the text names file, line and key."""


class TagError(ArclineError, KeyError):
    """A name that is not that of a tag; the text has the nearest name of a tag."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class TagValueError(ArclineError, ValueError):
    """A value that a tag cannot hold, or a tag that is read-only."""


class ProgramError(ArclineError):
    """A program that cannot be read, or cannot go on."""

    def __init__(self, text: str, line: int) -> None:
        super().__init__(text, line)
        #: The error in words.
        self.text = text
        #: The line of the program, from 1.
        self.line = line

    def __str__(self) -> str:
        return self.text


class ProjectError(ArclineError):
    """A controller project that cannot be read, or of which parts do not run."""

    def __init__(self, text: str, findings: list[str]) -> None:
        super().__init__(text, findings)
        #: The error in words.
        self.text = text
        #: The parts that do not run, each with its place.
        self.findings = findings

    def __str__(self) -> str:
        return self.text


class MajorFault(ArclineError):
    """A major fault of a controller project that no fault routine cleared: its tasks have stopped."""

    def __init__(
        self,
        type: int,
        code: int,
        program: str,
        routine: str,
        rung: int | None,
        line: int | None,
        instruction: str,
        text: str,
    ) -> None:
        super().__init__(type, code, program, routine, rung, line, instruction, text)
        #: The type of the fault, such as 4 of the program.
        self.type = type
        #: Its code, such as 20 of a subscript out of range.
        self.code = code
        #: The program.
        self.program = program
        #: The routine; of an add-on instruction its name and routine.
        self.routine = routine
        #: The number of the rung; None: the routine is Structured Text.
        self.rung = rung
        #: The number of the line; None: the routine is ladder.
        self.line = line
        #: The instruction.
        self.instruction = instruction
        #: The fault in words, with the operand and its value.
        self.text = text

    def __str__(self) -> str:
        return self.text


class MotionError(ArclineError):
    """An instruction that erred.

    >>> import arcline
    >>> m = arcline.Machine()
    >>> try:
    ...     m.program("MCLM(CS1, M1, Absolute, [1, 2, 3], -5, Unitspersec);").wait()
    ... except arcline.MotionError as error:
    ...     print(error.err, error.exerr, error.instruction)
    13 4 MCLM
    """

    def __init__(self, err: int, exerr: int, text: str, instruction: str, line: int, tag: str) -> None:
        super().__init__(err, exerr, text, instruction, line, tag)
        #: ERR, the error code of the instruction.
        self.err = err
        #: EXERR, the extended error code.
        self.exerr = exerr
        #: Both in words.
        self.text = text
        #: The mnemonic of the instruction.
        self.instruction = instruction
        #: The line of its call, from 1.
        self.line = line
        #: Its motion control tag; empty: none.
        self.tag = tag

    def __str__(self) -> str:
        tag = f" ({self.tag})" if self.tag else ""
        return f"line {self.line}: {self.instruction}{tag}: {self.text}"


class TimeoutError(ArclineError, builtins.TimeoutError):
    """Simulated time that has passed before what was waited for."""
