"""A real server for the length of a test."""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
import weakref
from pathlib import Path
from types import TracebackType

__all__ = ["Server"]


class Server:
    """A real ``arcline-server`` on free ports. It ends with :meth:`close`, and with the process that started it, however that ends.

    The program is that of ``program``, of the environment variable ``ARCLINE_SERVER_PROGRAM``, or ``arcline-server`` of the path. ``clock`` is
    ``real``, ``step`` or ``fast:N``; further arguments go to the program. Processes that are forked from this one, as ``multiprocessing`` does, neither
    keep the server nor end it.
    """

    #: Address of EtherNet/IP, ``HOST:PORT``: what LogixDriver of pycomm3 takes.
    enip: str
    #: Address of the web page, ``http://HOST:PORT``.
    hmi: str

    def __init__(
        self,
        config: str | os.PathLike[str] | None = None,
        *arguments: str,
        clock: str = "real",
        program: str | os.PathLike[str] | None = None,
        ready_within: float = 20.0,
    ) -> None:
        command = [str(_program(program)), "run", "--listen", "127.0.0.1:0", "--hmi", "127.0.0.1:0", "--state", "off"]
        command += ["--clock", clock, "--end-with-stdin"]
        if config is not None:
            command += ["--config", os.fspath(config)]
        self._log: list[str] = []
        self._owner = os.getpid()
        self._process = subprocess.Popen(
            [*command, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        _SERVERS.add(self)
        self._reader = threading.Thread(target=self._read_log, daemon=True)
        self._reader.start()
        late = threading.Timer(ready_within, self._process.kill)
        late.start()
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        late.cancel()
        if not line.startswith("ready "):
            self.close()
            raise RuntimeError(f"{command[0]} is not ready: {line}{self.log}")
        places = dict(part.split("=", 1) for part in line.split()[1:])
        self.enip = places["eip"]
        self.hmi = f"http://{places['hmi']}"

    @property
    def log(self) -> str:
        """The text that the server has written to standard error so far."""
        return "".join(self._log)

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    def close(self) -> int:
        """Stops all motion and the server; returns its exit code. In a forked process it does nothing and returns 0: the server is not that process's."""
        if os.getpid() != self._owner:
            return 0
        self._close_input()
        self._process.terminate()
        try:
            code = self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        self._reader.join(5)
        for stream in (self._process.stdout, self._process.stderr):
            if stream is not None:
                stream.close()
        return code

    def __enter__(self) -> Server:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _close_input(self) -> None:
        """Closes this process's end of the pipe at whose end the server stops."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.close()
        except BrokenPipeError:
            pass

    def _read_log(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self._log.append(line)


#: The servers of this process.
_SERVERS: weakref.WeakSet[Server] = weakref.WeakSet()


def _close_inputs() -> None:
    """A forked process has the pipes of the servers of its parent too, whose end would not come while it lives."""
    for server in list(_SERVERS):
        server._close_input()


os.register_at_fork(after_in_child=_close_inputs)


def _program(program: str | os.PathLike[str] | None) -> Path:
    given = program or os.environ.get("ARCLINE_SERVER_PROGRAM") or shutil.which("arcline-server")
    if given is None:
        raise FileNotFoundError(
            "there is no arcline-server on the path: build it with `cargo install --locked --path server`, or name it by ARCLINE_SERVER_PROGRAM"
        )
    return Path(given)
