"""Processes of Python programs, forked from one that has imported what takes long.

Half a second of processor time goes into the imports of a ROS node before it does anything, and tests
start hundreds. Each is a process of its own all the same, with its own arguments, environment, folder,
standard streams and session. The modules that are imported before must start no thread.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import types
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import CodeType
from typing import IO, Any

import costs

__all__ = ["ForkServer", "Forked"]

LARGEST_REQUEST = 2**20


class Forked:
    """A process that was forked; what it has of ``subprocess.Popen`` means the same."""

    def __init__(
        self, server: ForkServer, pid: int, stdin: IO[bytes] | None, stdout: IO[bytes] | None
    ) -> None:
        self.pid, self.stdin, self.stdout = pid, stdin, stdout
        self.returncode: int | None = None
        self.log = Path(os.devnull)
        self._server, self._reaping = server, threading.Lock()
        self._handle = os.pidfd_open(pid)

    def poll(self) -> int | None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait(0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        with self._reaping:
            if self.returncode is None:
                end = select.poll()
                end.register(self._handle, select.POLLIN)
                if not end.poll(None if timeout is None else timeout * 1000):
                    raise subprocess.TimeoutExpired([str(self.pid)], timeout or 0.0)
                os.close(self._handle)
                self.returncode = self._server.reap(self.pid)
            return self.returncode

    def send_signal(self, number: int) -> None:
        with self._reaping:
            if self.returncode is None:
                signal.pidfd_send_signal(self._handle, number)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


class ForkServer:
    """Starts processes of Python programs; ends with the process that made it."""

    def __init__(
        self, python: str | Path, modules: Sequence[str], environment: Mapping[str, str]
    ) -> None:
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._turn = threading.Lock()
        with theirs:
            self._process = subprocess.Popen(
                [python, __file__, str(theirs.fileno()), *modules],
                env=dict(environment),
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )

    def start(
        self,
        command: Sequence[str],
        environment: Mapping[str, str],
        errors: IO[bytes],
        folder: Path | None = None,
        piped: bool = False,
    ) -> Forked:
        """Start a program: the words after ``python3``, a file or ``-c`` and code, and arguments.

        Without pipes it writes where its errors go.
        """
        request = {
            "command": command,
            "environment": dict(environment),
            "folder": str(folder or ""),
        }
        if not piped:
            with open(os.devnull, "rb") as nothing:  # noqa: PTH123
                streams = [nothing.fileno(), errors.fileno(), errors.fileno()]
                return Forked(self, self._ask(request, streams), None, None)
        (stdin, to_stdin), (from_stdout, stdout) = os.pipe(), os.pipe()
        pid = self._ask(request, [stdin, stdout, errors.fileno()])
        os.close(stdin)
        os.close(stdout)
        return Forked(self, pid, os.fdopen(to_stdin, "wb"), os.fdopen(from_stdout, "rb"))

    def reap(self, pid: int) -> int:
        """Return the exit code of a process that has ended, as ``subprocess.Popen`` has it."""
        code, seconds = self._ask({"ended": pid})
        costs.ELSEWHERE.append(seconds)
        return int(code)

    def _ask(self, request: dict[str, Any], streams: Sequence[int] = ()) -> Any:
        with self._turn:
            socket.send_fds(self._socket, [json.dumps(request).encode()], streams)
            return json.loads(self._socket.recv(LARGEST_REQUEST))


def serve(control: socket.socket) -> None:
    """Fork a process for each request, until nobody can ask for any more; return in each of them."""
    gc.freeze()
    while True:
        text, streams, _, _ = socket.recv_fds(control, LARGEST_REQUEST, 3)
        if not text:
            os._exit(0)
        request = json.loads(text)
        answer: Any
        if (pid := request.get("ended")) is not None:
            _, status, usage = os.wait4(pid, 0)
            answer = os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime
        else:
            code = code_of(*request["command"][:2])
            answer = os.fork()
            if not answer:
                control.close()
                become(request, streams)
                exec(code, vars(sys.modules["__main__"]))
                return
            for stream in streams:
                os.close(stream)
        control.sendall(json.dumps(answer).encode())


def code_of(program: str, code: str = "") -> CodeType:
    if program == "-c":
        return compiled(code.encode(), "<string>")
    return compiled(Path(program).read_bytes(), program)


@functools.cache
def compiled(text: bytes, name: str) -> CodeType:
    return compile(text, name, "exec", dont_inherit=True)


def become(request: dict[str, Any], streams: list[int]) -> None:
    """Make the forked process what a started one would be."""
    os.setsid()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
    for stream in streams:
        os.close(stream)
    os.chdir(request["folder"] or ".")
    os.environ.clear()
    os.environ.update(request["environment"])
    program, *words = request["command"]
    sys.argv[:] = [program, *words[program == "-c" :]]
    sys.path[0] = "" if program == "-c" else str(Path(program).parent)
    sys.path[1:1] = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    main = sys.modules["__main__"] = types.ModuleType("__main__")
    main.__file__ = program
    if (names := sys.modules.get("rospy.names")) is not None:
        importlib.reload(names)  # it has read the server's arguments and environment


if __name__ == "__main__":
    for module in sys.argv[2:]:
        importlib.import_module(module)
    serve(socket.socket(fileno=int(sys.argv[1])))
