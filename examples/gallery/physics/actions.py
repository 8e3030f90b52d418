"""The actions of a world, each served by a process of its own that faults kill."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing import Pipe
from typing import Any

from physics.world import Task, World

__all__ = ["ActionServer"]


class ActionServer:
    """Serves one action of a world, one goal at a time.

    What its process tells comes through ``post``, which calls a function in the bridge's thread;
    ``arrived`` is called for each goal.
    """

    def __init__(
        self,
        version: int,
        post: Callable[[Callable[[], None]], None],
        world: World,
        name: str,
        arrived: Callable[[], None],
    ) -> None:
        self._command = [sys.executable, "-m", "physics.server"]
        self._command += [str(version), name, world.actions[name]]
        self._post, self._world, self._name = post, world, name
        self._arrived = arrived
        self._goal: str | None = None
        self._task: Task | None = None
        self._ended: tuple[float, bool] | None = None
        self._is_cancelled = False
        self.late = 0.0
        """Seconds of simulated time from a goal's end until its result is told."""
        self.is_ready = False
        """Whether it is there, and the controller is connected to it."""
        self.is_killed = True
        self._prepare()

    def _prepare(self) -> None:
        """Start a process, which is no node yet: to load what it needs takes time."""
        self._pipe, other = Pipe()
        self._process = subprocess.Popen(
            [*self._command, str(other.fileno())], pass_fds=[other.fileno()]
        )
        other.close()
        reader = threading.Thread(target=self._read, args=(self._pipe,), daemon=True)
        reader.start()

    def begin(self) -> None:
        """Be a node."""
        self.is_killed = False
        self._pipe.send(("begin",))

    def kill(self) -> None:
        self._end_process()
        self.is_killed, self.is_ready = True, False
        self._drop()
        self._prepare()

    def close(self) -> None:
        self._end_process()

    def _end_process(self) -> None:
        self._process.kill()
        self._process.wait()

    def _read(self, pipe: Any) -> None:
        try:
            while True:
                self._pass(pipe, pipe.recv())
        except (EOFError, OSError):
            pipe.close()

    def _pass(self, pipe: Any, news: tuple[Any, ...]) -> None:
        self._post(lambda: self._take(*news) if pipe is self._pipe else None)

    @property
    def is_busy(self) -> bool:
        return self._goal is not None

    @property
    def is_cancelled(self) -> bool:
        """Whether the goal is to end because the controller said so."""
        return self._is_cancelled

    def _take(self, what: str, identifier: str = "", request: Any = None) -> None:
        if what == "ready":
            self.is_ready = True
        elif what == "cancel":
            self._is_cancelled |= identifier == self._goal
        else:
            self._arrived()
            if self._goal is not None:
                self._end("aborted")
            self._goal, self._task = identifier, self._world.begin(self._name, request)

    def _end(self, how: str, result: dict[str, Any] | None = None) -> None:
        self._pipe.send(("end", self._goal, how, result or {}))
        self._drop()

    def _drop(self) -> None:
        if self._task is not None:
            self._task.stop()
        self._goal = self._task = self._ended = None
        self._is_cancelled = False

    def step(self) -> bool:
        """Go on with the goal; whether it ended."""
        if self._goal is None or self._task is None:
            return False
        if self._is_cancelled:
            self._end("canceled")
            return True
        if self._ended is None:
            done = self._task.step()
            self._pipe.send(("feed_back", self._goal, self._task.feedback()))
            if done is not None:
                self._ended = (self._world.time + self.late, done)
        if self._ended is not None and self._world.time >= self._ended[0]:
            self._end("succeeded" if self._ended[1] else "aborted", self._task.result())
            return True
        return False
