"""Helpers for tests that need ROS 2: real rclpy processes, without an installation of ROS 2.

How to use them
---------------
The *bed* is a virtual environment with ROS 2 as wheels (``requirements.txt``), colcon, and
interface packages built for it: ``robosc_testing`` and the examples' ``robot_common``. It lies in
``.cache/ros2`` of the checkout and is made once. Tests run under the usual Python and start
processes of the bed's; the fixture ``graph`` is a ROS graph of the test's own, that is, a
``ROS_DOMAIN_ID``::

    def test_something(graph):
        robot = graph.peer()                        # a node that does as told, see peer.py
        robot.subscribe("vel", "geometry_msgs/msg/Twist")
        with graph.start(graph.bed.python, "node.py") as node:
            robot.publish("distance", "std_msgs/msg/Float32", {"data": 3.0}, matched=1)
            robot.expect("message", name="vel")

A test is skipped, saying why, only where the wheels are not to be had (another processor, no
network) or Debian's ament-cmake packages are not installed; everything else that goes wrong fails.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import threading
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import IO, Any

from fork_server import Forked, ForkServer
from free import free_domain
from ros2.bed import HERE, Bed

__all__ = ["Graph", "Peer", "Process", "free_domain"]

PATIENCE = 60.0
"""Seconds after which something that must come has not come, even on a machine that is busy."""


IMPORTED = (
    "rclpy", "rclpy.action", "rclpy.executors", "rclpy.lifecycle", "rclpy.parameter_client",
    "std_msgs.msg", "std_srvs.srv", "diagnostic_msgs.msg", "geometry_msgs.msg", "rosgraph_msgs.msg",
)  # fmt: skip


class Process:
    """A process of a graph; what it prints goes to the file ``log``."""

    def __init__(self, popen: subprocess.Popen[bytes] | Forked, log: Path) -> None:
        self.popen = popen
        self.log = log

    def signal(self, number: int) -> None:
        self.popen.send_signal(number)

    def wait(self, seconds: float = PATIENCE) -> int:
        """Its exit code, once it has ended by itself."""
        try:
            return self.popen.wait(seconds)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"still running after {seconds:g} s:\n{self.output}") from None

    def end(self) -> None:
        if self.popen.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self.popen.stdin.close()  # which is how a peer is told
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.popen.wait(10)
        for stop, seconds in ((self.popen.terminate, 10), (self.popen.kill, 5)):
            if self.popen.poll() is None:
                stop()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self.popen.wait(seconds)

    @property
    def output(self) -> str:
        return self.log.read_text(encoding="utf-8", errors="replace")


@cache
def nodes(bed: Bed) -> ForkServer:
    """What starts nodes and peers, once per process of tests."""
    return ForkServer(bed.python, IMPORTED, bed.environment)


class Graph:
    """A ROS graph of its own: processes on one domain, ended with it."""

    def __init__(self, bed: Bed, domain: int, folder: Path) -> None:
        self.bed = bed
        self.folder = folder
        self.environment = bed.environment | {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": str(folder / "ros"),
        }
        self._processes: list[Process] = []

    def start(self, *command: str | Path, **environment: str) -> Process:
        words = [str(word) for word in command]
        log = self._new_log(words)
        with log.open("wb") as output:
            popen = subprocess.Popen(
                words, env=self.environment | environment, cwd=log.parent, stdout=output,
                stderr=output, start_new_session=True,
            )  # fmt: skip
        return self._add(Process(popen, log))

    def fork(self, *command: str | Path, piped: bool = False, **environment: str) -> Process:
        """Start what follows ``python3``, in a process that need not import rclpy."""
        words = [str(word) for word in command]
        log = self._new_log(words)
        with log.open("wb") as output:
            server = nodes(self.bed)
            forked = server.start(words, self.environment | environment, output, log.parent, piped)
        return self._add(Process(forked, log))

    def peer(self, name: str = "robot", **environment: str) -> Peer:
        """A node that does as it is told; see peer.py."""
        return Peer(self.fork(HERE / "peer.py", name, piped=True, **environment))

    def _new_log(self, command: list[str]) -> Path:
        return self.folder / f"{len(self._processes)}-{Path(command[-1]).stem}.log"

    def _add(self, process: Process) -> Process:
        self._processes.append(process)
        return process

    def close(self) -> None:
        for process in reversed(self._processes):
            process.end()


class Peer:
    """The test's end of a peer (see peer.py): orders go there, events come back."""

    def __init__(self, process: Process) -> None:
        self.process = process
        assert process.popen.stdin is not None and process.popen.stdout is not None
        self._orders: IO[bytes] = process.popen.stdin
        self._news = threading.Condition()
        self._events: list[dict[str, Any]] = []
        self._count = 0
        threading.Thread(target=self._read, args=(process.popen.stdout,), daemon=True).start()

    def _read(self, stream: IO[bytes]) -> None:
        for line in stream:
            if not line.startswith(b"{"):
                continue  # the middleware tells of its shared memory there, too
            with self._news:
                self._events.append(json.loads(line))
                self._news.notify_all()

    def order(self, do: str, seconds: float = PATIENCE, **arguments: Any) -> Any:
        """Have something done; what the peer answers to it."""
        answer = self.expect("done", seconds, order=self.begin(do, **arguments))
        assert "fault" not in answer, answer["fault"]
        return answer.get("result")

    def begin(self, do: str, **arguments: Any) -> int:
        """Have something begun, without waiting for its end; the number of the order."""
        self._count += 1
        text = json.dumps({"do": do, "order": self._count, **arguments})
        self._orders.write(text.encode() + b"\n")
        self._orders.flush()
        return self._count

    def expect(
        self,
        event: str,
        seconds: float = PATIENCE,
        where: Callable[[Any], object] = lambda data: True,
        **fields: Any,
    ) -> dict[str, Any]:
        """Wait for an event with these fields, and such ``data`` if ``where`` is given.

        It and those before it of its kind are used up.
        """
        wanted = {"event": event, **fields}
        end = time.monotonic() + seconds
        with self._news:
            while True:
                for index, found in enumerate(self._events):
                    if wanted.items() <= found.items() and where(found.get("data")):
                        same = ("event", "name")
                        self._events = [
                            e for i, e in enumerate(self._events)
                            if i > index or any(e.get(f) != found.get(f) for f in same)
                        ]  # fmt: skip
                        return found
                if not self._news.wait(end - time.monotonic()):
                    last = "".join(f"\n  {str(e)[:1000]}" for e in self._events[-5:])
                    raise AssertionError(
                        f"no {wanted} within {seconds:g} s; the last were{last}\n"
                        + self.process.output
                    )

    def events(self, event: str, **fields: Any) -> list[dict[str, Any]]:
        """The events of this kind that nobody has expected yet; they stay."""
        wanted = {"event": event, **fields}
        with self._news:
            return [e for e in self._events if wanted.items() <= e.items()]

    def watch(self, node: str) -> None:
        """Listen to a controller's own topic ``~/state``."""
        self.subscribe(f"{node}/state", "std_msgs/msg/String", durability="transient_local")

    def expect_state(
        self, node: str, where: Callable[[dict[str, Any]], object], seconds: float = PATIENCE
    ) -> dict[str, Any]:
        """Wait for a state of a watched controller."""
        documents: list[dict[str, Any]] = []

        def fits(data: dict[str, str]) -> object:
            documents.append(json.loads(data["data"]))
            return where(documents[-1])

        self.expect("message", seconds, where=fits, name=f"{node}/state")
        return documents[-1]

    def subscribe(self, name: str, type: str, **qos: Any) -> None:
        self.order("subscribe", name=name, type=type, qos=qos)

    def publish(self, name: str, type: str, data: Any = None, matched: int = 1, **qos: Any) -> None:
        """Publish once there are ``matched`` subscribers.

        Only a reliable subscriber is then sure to get the message: the two sides of a match do not
        come to know of each other at the same moment.
        """
        self.order("publish", name=name, type=type, data=data or {}, matched=matched, qos=qos)

    def serve(self, name: str, type: str, reply: Any = None) -> None:
        """Offer a service that replies so at once; without a reply it waits to be told."""
        self.order("serve", name=name, type=type, reply=reply)

    def act(self, name: str, type: str, **policy: Any) -> None:
        """Offer an action; see peer.py for the policy."""
        self.order("act", name=name, type=type, **policy)
