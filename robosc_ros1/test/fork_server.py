"""Processes of one program, forked from one that has imported all that it needs.

Half a second of processor time goes into the imports of a ROS node before it does anything, and tests
start hundreds. Each is a process of its own all the same, with its own environment, standard streams
and session. The program is a module with a function ``main`` that starts no thread when imported.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import IO

__all__ = ["ForkServer", "Forked"]

LARGEST_REQUEST = 2**20


class Forked:
    """A process that was forked, with pipes to its standard input and from its output."""

    def __init__(self, pid: int, stdin: IO[str], stdout: IO[str]) -> None:
        self.pid = pid
        self.stdin = stdin
        self.stdout = stdout
        self._handle = os.pidfd_open(pid)

    def kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._handle, signal.SIGKILL)

    def wait(self) -> None:
        """Wait until it has ended."""
        end = select.poll()
        end.register(self._handle, select.POLLIN)
        end.poll()

    def close(self) -> None:
        """Close what is left of a process that has ended; its output may still be read."""
        os.close(self._handle)
        with contextlib.suppress(BrokenPipeError):
            self.stdin.close()


class ForkServer:
    """Starts processes of a program; ends with the process that made it."""

    def __init__(self, python: Path, program: Path, environment: Mapping[str, str]) -> None:
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [python, __file__, program, str(theirs.fileno())],
                env=environment,
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )

    def start(self, environment: Mapping[str, str], errors: Path) -> Forked:
        """Start a process; what it writes to its standard error is added to a file."""
        stdin, to_stdin = os.pipe()
        from_stdout, stdout = os.pipe()
        with errors.open("ab") as log:
            request = json.dumps(dict(environment)).encode()
            socket.send_fds(self._socket, [request], [stdin, stdout, log.fileno()])
        os.close(stdin)
        os.close(stdout)
        pid = int(self._socket.recv(16))
        return Forked(pid, os.fdopen(to_stdin, "w"), os.fdopen(from_stdout))


def serve(program: Path, control: socket.socket) -> None:
    """Fork a process for each request, until nobody can ask for any more."""
    specification = importlib.util.spec_from_file_location("program", program)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for them here
    while True:
        request, streams, _, _ = socket.recv_fds(control, LARGEST_REQUEST, 3)
        if not request:
            break
        pid = os.fork()
        if not pid:
            control.close()
            become(json.loads(request), streams)
            module.main()
            os._exit(0)
        for stream in streams:
            os.close(stream)
        control.sendall(str(pid).encode())


def become(environment: dict[str, str], streams: list[int]) -> None:
    """Make the forked process what a started one would be."""
    os.setsid()
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[1:1] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))


if __name__ == "__main__":
    serve(Path(sys.argv[1]), socket.socket(fileno=int(sys.argv[2])))
