"""Fixtures for pytest: ``machine``, a machine in this process, ``cell``, a controller project in this process, and ``server``, a real server on free
ports.

``@pytest.mark.arcline(config="machine.toml", clock="step")`` before a test says of what machine, and on which clock the server is;
``@pytest.mark.arcline(project="Cell.L5X")`` names the project, with ``config``, ``scan_phase`` and ``allow_missing`` as for :class:`arcline.Cell`.
``--arcline-trace DIR`` keeps the trace of the machine or the cell of a test that fails, as CSV, and as SVG where ``arcline`` is on the path: of the last
60 s of simulated time, or of those that ``--arcline-trace-seconds`` says.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import traceback
from collections.abc import Generator, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import pytest

from arcline.cell import Cell
from arcline.errors import MajorFault
from arcline.machine import Machine
from arcline.server import Server

#: Ticks of a trace in memory at a time.
SLICE = 8192
SIGNALS = ("CommandPosition", "CommandVelocity", "CommandAcceleration", "ActualPosition")


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("arcline")
    group.addoption(
        "--arcline-trace", metavar="DIR", help="keep the traces of the machines and cells of failed tests in this folder"
    )
    group.addoption(
        "--arcline-trace-seconds",
        metavar="SECONDS",
        type=float,
        default=60.0,
        help="the simulated seconds before the failure that these traces have (default: 60)",
    )


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers",
        "arcline(config=None, clock='real', project=None, scan_phase=None, allow_missing=False): "
        "the machine of the fixtures machine, cell and server",
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if report.when != "call" or not report.failed:
        return report
    fixtures: dict[str, Any] = getattr(item, "funcargs", {})
    server = fixtures.get("server")
    if isinstance(server, Server):
        report.sections.append(("log of arcline-server", server.log))
    folder = item.config.getoption("--arcline-trace")
    for name in ("machine", "cell"):
        traced = fixtures.get(name)
        if isinstance(traced, (Machine, Cell)) and folder:
            test = item.nodeid if name == "machine" or "machine" not in fixtures else f"{item.nodeid}-cell"
            seconds = item.config.getoption("--arcline-trace-seconds")
            report.sections.append((f"trace of the {name}", _kept(traced, Path(folder), test, seconds)))
    return report


def _kept(traced: Machine | Cell, folder: Path, test: str, seconds: float) -> str:
    """The files of a trace, or why there are none: a report never ends the session."""
    try:
        return "\n".join(keep_trace(traced, folder, test, seconds))
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # A panic of the module is no Exception.
        return "there is no trace: " + "".join(traceback.format_exception_only(error)).strip()


def _given(request: pytest.FixtureRequest) -> dict[str, Any]:
    mark = request.node.get_closest_marker("arcline")
    return dict(mark.kwargs) if mark else {}


@pytest.fixture
def machine(request: pytest.FixtureRequest) -> Machine:
    """A machine on the virtual clock, in this process."""
    return Machine(_given(request).get("config"))


@pytest.fixture
def cell(request: pytest.FixtureRequest) -> Cell:
    """The controller project that the mark names, on the virtual clock, in this process."""
    given = _given(request)
    if "project" not in given:
        pytest.fail("the fixture cell needs @pytest.mark.arcline(project='Cell.L5X') before the test", pytrace=False)
    return Cell(
        given["project"],
        given.get("config"),
        scan_phase=given.get("scan_phase"),
        allow_missing=given.get("allow_missing", False),
    )


@pytest.fixture
def server(request: pytest.FixtureRequest) -> Iterator[Server]:
    """A real server on free ports."""
    given = _given(request)
    with Server(given.get("config"), clock=given.get("clock", "real")) as server:
        yield server


def _again(traced: Machine | Cell) -> tuple[Machine | Cell, list[tuple[Any, ...]]]:
    """The same at its beginning, and what was done with it."""
    if isinstance(traced, Machine):
        config, seed, journal = traced._journal()
        return Machine(config, seed=seed), journal
    project, config_of_cell, scan_phase, allow_missing, journal = traced._journal()
    return Cell(project, config_of_cell, scan_phase=scan_phase, allow_missing=allow_missing), journal


def keep_trace(traced: Machine | Cell, folder: Path, test: str, seconds: float) -> list[str]:
    """Writes the last seconds of what a machine or a cell has done to a file of the test, by doing it again. Returns the files, in words."""
    again, journal = _again(traced)
    names = [f"{axis}.{signal}" for axis in again.axes for signal in SIGNALS]
    ticks = sum(entry[1] for entry in journal if entry[0] == "step")
    # Ticks that are repeated without a trace.
    before = max(0, ticks - round(seconds / again.period))
    folder.mkdir(parents=True, exist_ok=True)
    csv = folder / (re.sub(r"[^\w.-]+", "-", test).strip("-") + ".csv")
    with csv.open("w") as file:
        file.write(",".join(["tick", "time_s", *names]) + "\n")
        for entry in journal:
            if entry[0] != "step":
                again._replay([entry])
                continue
            passed = min(before, entry[1])
            before -= passed
            with suppress(MajorFault):
                again.step(passed)
            while passed < entry[1]:
                count = min(SLICE, entry[1] - passed)
                _write_ticks(again, names, count, file)
                passed += count
    files = [str(csv) + (f" (the last {seconds:g} s of {ticks * again.period:g} s)" if ticks * again.period > seconds else "")]
    program = shutil.which("arcline")
    if program is not None:
        svg = csv.with_suffix(".svg")
        plotted = subprocess.run([program, "plot", str(csv), "-o", str(svg)], capture_output=True, check=False)
        if plotted.returncode == 0:
            files.append(str(svg))
    return files


def _write_ticks(again: Machine | Cell, names: list[str], count: int, file: TextIO) -> None:
    """Lets ticks pass, and writes a row for each."""
    first = again.tick
    values = np.zeros((count, len(names)))
    # The tick in which the tasks stop has a row too.
    with suppress(MajorFault):
        again.trace(names, count, out=values)
    if isinstance(again, Cell):
        first = again.tick + 1 - count
    for tick, row in enumerate(values.tolist(), first):
        file.write(",".join([str(tick), *(repr(value).removesuffix(".0") for value in (tick * again.period, *row))]) + "\n")
