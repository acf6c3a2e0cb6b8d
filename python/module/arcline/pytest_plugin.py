"""Fixtures for pytest: ``machine``, a machine in this process, and ``server``, a real server on free ports.

``@pytest.mark.arcline(config="machine.toml", clock="step")`` before a test says of what machine, and on which clock the server is.
``--arcline-trace DIR`` keeps the trace of the machine of a test that fails, as CSV, and as SVG where ``arcline`` is on the path.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arcline.machine import Machine
from arcline.server import Server

SIGNALS = ("CommandPosition", "CommandVelocity", "CommandAcceleration", "ActualPosition")


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("arcline")
    group.addoption(
        "--arcline-trace", metavar="DIR", help="keep the traces of the machines of failed tests in this folder"
    )


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "arcline(config=None, clock='real'): the machine of the fixtures machine and server")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if report.when != "call" or not report.failed:
        return report
    fixtures: dict[str, Any] = getattr(item, "funcargs", {})
    server = fixtures.get("server")
    if isinstance(server, Server):
        report.sections.append(("log of arcline-server", server.log))
    machine, folder = fixtures.get("machine"), item.config.getoption("--arcline-trace")
    if isinstance(machine, Machine) and folder:
        report.sections.append(("trace of the machine", "\n".join(map(str, keep_trace(machine, Path(folder), item.nodeid)))))
    return report


def _given(request: pytest.FixtureRequest) -> dict[str, Any]:
    mark = request.node.get_closest_marker("arcline")
    return dict(mark.kwargs) if mark else {}


@pytest.fixture
def machine(request: pytest.FixtureRequest) -> Machine:
    """A machine on the virtual clock, in this process."""
    return Machine(_given(request).get("config"))


@pytest.fixture
def server(request: pytest.FixtureRequest) -> Iterator[Server]:
    """A real server on free ports."""
    given = _given(request)
    with Server(given.get("config"), clock=given.get("clock", "real")) as server:
        yield server


def keep_trace(machine: Machine, folder: Path, test: str) -> list[Path]:
    """Writes what a machine has done to a file of the test, by doing it again. Returns the files."""
    config, seed, journal = machine._journal()
    again = Machine(config, seed=seed)
    names = [f"{axis}.{signal}" for axis in again.axes for signal in SIGNALS]
    rows: list[Any] = []
    for entry in journal:
        if entry[0] != "step":
            again._replay([entry])
            continue
        first, period = again.tick, again.period
        values = again.trace(names, entry[1])
        ticks = np.arange(first, first + entry[1])
        rows.append(np.column_stack([ticks, ticks * period, values]))
    folder.mkdir(parents=True, exist_ok=True)
    csv = folder / (re.sub(r"[^\w.-]+", "-", test).strip("-") + ".csv")
    with csv.open("w") as file:
        file.write(",".join(["tick", "time_s", *names]) + "\n")
        for block in rows:
            for row in block:
                file.write(",".join([str(int(row[0])), *(repr(float(value)).removesuffix(".0") for value in row[1:])]) + "\n")
    files = [csv]
    program = shutil.which("arcline")
    if program is not None:
        svg = csv.with_suffix(".svg")
        plotted = subprocess.run([program, "plot", str(csv), "-o", str(svg)], capture_output=True, check=False)
        if plotted.returncode == 0:
            files.append(svg)
    return files
