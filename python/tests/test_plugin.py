"""The fixtures, as a project of tests uses them. Those with a server need its program."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from xml.etree import ElementTree

import pytest

from arcline.server import Server


PROGRAM = os.environ.get("ARCLINE_SERVER_PROGRAM") or shutil.which("arcline-server")
needs_server = pytest.mark.skipif(PROGRAM is None, reason="no arcline-server: name it by ARCLINE_SERVER_PROGRAM")


def connects(server):
    host, port = server.enip.split(":")
    with socket.create_connection((host, int(port)), timeout=5):
        return True


def test_a_machine_of_its_own_for_each_test_and_the_trace_of_a_failed_one(pytester):
    pytester.makepyfile(
        """
        import pytest

        def test_moves(machine):
            machine.program("MAM(X, M1, Absolute, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);").wait()
            assert machine["X.CommandPosition"] == 5.0

        def test_fails(machine):
            assert machine["X.CommandPosition"] == 0.0
            machine.program("MAM(X, M1, Absolute, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);").wait()
            assert machine["X.CommandPosition"] == 4.0
        """
    )
    result = pytester.runpytest_subprocess("--arcline-trace", "kept")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*trace of the machine*", "*test_fails.csv*"])
    (kept,) = (pytester.path / "kept").glob("*.csv")
    plots = list((pytester.path / "kept").glob("*.svg"))
    if shutil.which("arcline") is None:
        assert os.environ.get("CI") != "true", "arcline is missing"
        assert plots == []
    else:
        (plot,) = plots
        root = ElementTree.parse(plot).getroot()
        assert plot.stem == kept.stem and root.tag == "{http://www.w3.org/2000/svg}svg"
        assert len(list(root.iter("{http://www.w3.org/2000/svg}path"))) + len(list(root.iter("{http://www.w3.org/2000/svg}polyline"))) >= 3
        assert "X" in "".join(root.itertext())
        result.stdout.fnmatch_lines(["*test_fails.svg*"])
    lines = kept.read_text().splitlines()
    assert lines[0].startswith("tick,time_s,X.CommandPosition") and lines[1].startswith("0,0,0,0,500,0")
    assert len(lines) > 100


def test_the_project_that_the_mark_names_and_the_trace_of_a_failed_test(pytester):
    shutil.copy(Path(__file__).parent.parent.parent / "tests" / "config" / "Cell.L5X", pytester.path)
    pytester.makepyfile(
        """
        import arcline
        import pytest

        @pytest.mark.arcline(project="Cell.L5X")
        def test_moves(cell):
            cell.set("Start", 1)
            assert cell.run_until("Done", 10) > 0.0
            assert cell["X.CommandPosition"] == 25.0

        @pytest.mark.arcline(project="Cell.L5X")
        def test_fails(cell):
            assert cell["Start"] is False and cell.time == 0.0
            cell["Start"] = 1
            cell.run(0.1)
            cell["Target"] = 12.5
            cell.run_until("Done", 0.2)

        def test_has_no_project(cell):
            pass
        """
    )
    result = pytester.runpytest_subprocess("--arcline-trace", "kept", "-W", "error::pytest.PytestUnknownMarkWarning")
    result.assert_outcomes(passed=1, failed=1, errors=1)
    result.stdout.fnmatch_lines(["*the fixture cell needs @pytest.mark.arcline(project='Cell.L5X')*"])
    result.stdout.fnmatch_lines(["*trace of the cell*", "*test_fails.csv*"])
    (kept,) = (pytester.path / "kept").glob("*.csv")
    lines = kept.read_text().splitlines()
    assert lines[0].startswith("tick,time_s,X.CommandPosition") and lines[1].startswith("0,0,0,")
    assert [int(line.split(",")[0]) for line in lines[1:]] == list(range(76)), "from tick 0 to the last at 0.3 s"
    assert float(lines[-1].split(",")[2]) > 0.0


def test_the_trace_of_a_long_test_is_that_of_its_last_seconds(pytester):
    pytester.makepyfile(
        """
        def test_fails(machine):
            machine.run(20.0)
            machine["Move1.Speed"] = 250.0
            machine.program("MAM(X, M1, Absolute, 5, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);")
            machine.run(0.4)
            assert False
        """
    )
    result = pytester.runpytest_subprocess("--arcline-trace", "kept", "--arcline-trace-seconds", "0.5")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*test_fails.csv (the last 0.5 s of 20.4 s)*"])
    (kept,) = (pytester.path / "kept").glob("*.csv")
    rows = [line.split(",") for line in kept.read_text().splitlines()[1:]]
    assert [int(row[0]) for row in rows] == list(range(19_900, 20_400))
    assert float(rows[0][2]) == 0.0 and float(rows[-1][2]) == 5.0


def test_a_trace_that_cannot_be_made_is_a_section_of_the_report(pytester):
    pytester.makepyfile(
        """
        import arcline
        import pytest

        @pytest.fixture
        def machine():
            return arcline.Machine(journal=False)

        def test_fails(machine):
            assert False

        def test_passes(machine):
            pass
        """
    )
    result = pytester.runpytest_subprocess("--arcline-trace", "kept")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*trace of the machine*", "*ArclineError: a machine with journal=False cannot be saved or pickled*"])
    (pytester.path / "file").touch()
    result = pytester.runpytest_subprocess("--arcline-trace", "file/kept", "-p", "no:cacheprovider")
    result.assert_outcomes(passed=1, failed=1)


@needs_server
def test_a_server_on_the_clock_that_the_mark_names(pytester):
    pytester.makepyfile(
        """
        import pytest, urllib.request

        @pytest.mark.arcline(clock="step")
        def test_page(server):
            with urllib.request.urlopen(server.hmi) as page:
                assert page.status == 200

        def test_log(server):
            assert False
        """
    )
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*log of arcline-server*"])


@needs_server
def test_fifty_servers_run_beside_each_other():
    with ThreadPoolExecutor(50) as pool:
        servers = list(pool.map(lambda _: Server(), range(50)))
    try:
        assert len({server.enip for server in servers}) == 50
        assert all(connects(server) for server in servers)
    finally:
        with ThreadPoolExecutor(50) as pool:
            codes = list(pool.map(Server.close, servers))
    assert codes == [0] * 50


@needs_server
def test_a_server_ends_with_the_process_that_started_it_however_that_ends():
    code = textwrap.dedent(
        """
        import time
        from arcline.server import Server
        server = Server()
        print(server.pid, flush=True)
        time.sleep(600)
        """
    )
    starter = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid = int(starter.stdout.readline())
    starter.send_signal(signal.SIGKILL)
    starter.wait()
    ends(pid)


@needs_server
def test_a_server_closes_at_once_while_a_forked_child_lives():
    server = Server()
    child = get_context("fork").Process(target=time.sleep, args=(600,))
    child.start()
    try:
        began = time.monotonic()
        assert server.close() == 0
        assert time.monotonic() - began < 5
    finally:
        child.kill()
        child.join()


@needs_server
def test_a_forked_child_does_not_end_the_server_of_its_parent():
    with Server() as server:
        child = get_context("fork").Process(target=server.close)
        child.start()
        child.join(20)
        assert child.exitcode == 0 and connects(server)


@needs_server
def test_a_server_ends_with_its_process_while_a_forked_child_of_that_lives():
    code = textwrap.dedent(
        """
        import time
        from multiprocessing import get_context
        from arcline.server import Server
        server = Server()
        child = get_context("fork").Process(target=time.sleep, args=(600,))
        child.start()
        print(server.pid, child.pid, flush=True)
        time.sleep(600)
        """
    )
    starter = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid, child = map(int, starter.stdout.readline().split())
    starter.send_signal(signal.SIGKILL)
    starter.wait()
    try:
        ends(pid)
    finally:
        os.kill(child, signal.SIGKILL)


def ends(pid):
    deadline = time.monotonic() + 20
    while os.path.exists(f"/proc/{pid}/exe") and _state(pid) != "Z":
        assert time.monotonic() < deadline, "the server lives on"
        time.sleep(0.02)


def _state(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return "Z"


@needs_server
def test_a_server_that_cannot_start_says_why(tmp_path):
    (tmp_path / "wrong.toml").write_text("[[axis]]\nname = 5\n")
    with pytest.raises(RuntimeError, match="missing, expected"):
        Server(tmp_path / "wrong.toml")
    with pytest.raises(FileNotFoundError):
        Server(program=tmp_path / "nowhere")


@needs_server
def test_a_server_is_ready_within_300_ms():
    """The figure of the release build; the least of several starts, since the machine may be busy with something else."""
    best = float("inf")
    for _ in range(20):
        began = time.perf_counter()
        with Server():
            best = min(best, time.perf_counter() - began)
        if best <= 0.3:
            break
    print(f"ready after {best * 1000:.0f} ms")
    assert best <= 0.3
