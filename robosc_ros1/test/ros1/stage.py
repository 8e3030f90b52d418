"""A stage for a generated controller: a workspace with it, and puppets that play its robot."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any
from xmlrpc.client import Fault, ServerProxy

from emit.golden_packages import GOLDEN
from fork_server import Forked
from ros_support import Master, Workspace

__all__ = ["NAMES", "PATIENCE", "PUPPET", "Node", "Puppet", "Stage", "event", "master_pid"]

PATIENCE = 60.0
"""Seconds after which something that must come has not come, even on a machine that is busy."""

PUPPET = (str(Path(__file__).with_name("puppet_node.py")),)

_ACTIVE = 1  # of actionlib_msgs/GoalStatus, which is not there without ROS

Json = dict[str, Any]


def action(name: str) -> tuple[str, ...]:
    """The topics of an action."""
    return tuple(f"{name}/{part}" for part in ("goal", "cancel", "status", "feedback", "result"))


NAMES = {
    "orders": ("order", "switch", "door", "lamp"),
    "missions": ("step", "fault", "lamp", *action("mission")),
    "reflector": ("reflect", *action("shine")),
}
"""What the controllers of models that are called use, and have elsewhere behind a supervisor."""


def event(kind: str, name: str, **more: Any) -> Callable[[Json], bool]:
    """A condition on what is heard on ``~events``."""

    def condition(document: Json) -> bool:
        told = document["event"]
        return (told["kind"], told["name"]) == (kind, name) and all(
            document.get(key, told.get(key)) == value for key, value in more.items()
        )

    return condition


def master_pid(master: Master) -> int:
    """The process of the master itself; roscore is its parent."""
    return int(ServerProxy(master.uri).getPid("/test")[2])  # type: ignore[index, call-overload]


class Puppet:
    """The test's side of ``puppet_node.py``."""

    def __init__(self, process: Forked) -> None:
        self.process = process
        self.lines: list[Json] = []
        self._orders = 0
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as lines:
            for line in lines:
                if line.startswith(b"{"):
                    with self._changed:
                        self.lines.append(json.loads(line))
                        self._changed.notify_all()

    def begin(self, what: str, **arguments: Any) -> int:
        """Have the puppet do something; the number of the order."""
        number = self._orders
        self._orders += 1
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps({"do": what, **arguments}).encode() + b"\n")
        self.process.stdin.flush()
        return number

    def do(self, what: str, **arguments: Any) -> None:
        """Have the puppet do something, and wait until it has."""
        number = self.begin(what, **arguments)
        done = self.wait(lambda line: line.get("done") == number, f"the end of {what}")
        assert "failed" not in done, done["failed"]

    def publish(self, topic: str, type_: str, data: Any = None, **more: Any) -> None:
        fields = {} if data is None else {"data": data}
        self.do("publish", topic=topic, type=type_, fields=fields, **more)

    def steadily(self, topic: str, type_: str, data: Any) -> None:
        """Have the puppet publish a value again and again, until the next one."""
        self.do("steadily", topic=topic, type=type_, fields={"data": data})

    def wait(
        self, condition: Callable[[Json], Any], what: str, seconds: float = PATIENCE, since: int = 0
    ) -> Json:
        """The first line (from the ``since``-th on) for which the condition holds."""
        end = time.monotonic() + seconds
        with self._changed:
            position = since
            while True:
                for line in self.lines[position:]:
                    if condition(line):
                        return line
                position = len(self.lines)
                left = end - time.monotonic()
                assert left > 0, f"waited in vain for {what}; heard last: {self.lines[-5:]}"
                self._changed.wait(left)

    def hears(
        self, topic: str, condition: Callable[[Json], Any] = lambda _: True, **more: Any
    ) -> Json:
        """What is heard on a topic and meets the condition."""

        def heard(line: Json) -> bool:
            return line.get("heard") == topic and bool(condition(line["message"]))

        message: Json = self.wait(heard, f"a message on {topic}", **more)["message"]
        return message

    def sees_a_goal_run(self, action: str) -> None:
        """Wait until the server of an action has told everybody that a goal runs. What it has not
        told that it has, it may never have got."""
        topic = f"{action}/status"
        self.do("listen", topic=topic, type="actionlib_msgs/GoalStatusArray")
        self.hears(topic, lambda told: any(s["status"] == _ACTIVE for s in told["status_list"]))

    def all_heard(self, topic: str, since: int = 0) -> list[Json]:
        with self._changed:
            lines = self.lines[since:]
        return [line["message"] for line in lines if line.get("heard") == topic]

    @property
    def mark(self) -> int:
        """The number of lines so far, for ``since``."""
        with self._changed:
            return len(self.lines)


class Node:
    """A running controller, with a puppet that listens to what it tells.

    What the ear heard before its ``since``-th line came from another node of that name.
    """

    def __init__(self, process: Forked, name: str, ear: Puppet, since: int) -> None:
        self.process = process
        self.name = name
        self.ear = ear
        self.since = since

    @property
    def log(self) -> str:
        return self.process.log.read_text(encoding="utf-8", errors="replace")

    def tells(self, condition: Callable[[Json], Any], **more: Any) -> Json:
        """An event that the controller tells."""
        return self.ear.hears(f"{self.name}/events", condition, **{"since": self.since} | more)

    def shows(self, condition: Callable[[Json], Any], **more: Any) -> Json:
        """A state that the controller shows."""
        return self.ear.hears(f"{self.name}/state", condition, **{"since": self.since} | more)

    def events(self, condition: Callable[[Json], Any] = lambda _: True) -> list[Json]:
        heard = self.ear.all_heard(f"{self.name}/events", since=self.since)
        return [e for e in heard if condition(e)]

    def enters(self, component: str, state: str) -> Json:
        return self.shows(lambda s: s["components"][component] == state)


class Stage:
    """A built workspace and a master."""

    def __init__(self, workspace: Workspace, master: Master) -> None:
        self.workspace = workspace
        self.master = master
        self.model_folder = GOLDEN / "models"

    @contextlib.contextmanager
    def puppet(self) -> Iterator[Puppet]:
        with self.workspace.fork(*PUPPET, master=self.master, piped=True) as process:
            try:
                yield Puppet(process)
            finally:
                process.kill()
        self.master.forget(f"/puppet_{process.pid}_")

    @contextlib.contextmanager
    def simulated_time(self) -> Iterator[None]:
        """The clock stands at 0 until somebody publishes one."""
        self.master.set("/use_sim_time", True)
        try:
            yield
        finally:
            self.master.set("/use_sim_time", False)

    @contextlib.contextmanager
    def controller(
        self,
        ear: Puppet,
        package: str = "probe_controller",
        remap: Sequence[str] = (),
        **parameters: Any,
    ) -> Iterator[Node]:
        """A controller with parameters (``__`` stands for ``/`` in a name); the ear listens first.

        ``remap`` are rules like ``/old:=/new`` and ``__ns:=/left``.

        The node is up when this begins: it has shown a state, and its connections to those that are
        there stand.
        """
        spaces = [rule.partition(":=")[2] for rule in remap if rule.startswith("__ns:=")]
        name = "".join([*spaces, "/", package])
        mark = ear.mark
        ear.do("listen", topic=f"{name}/events", type="std_msgs/String")
        ear.do("listen", topic=f"{name}/state", type="std_msgs/String")
        arguments = [f"_{k.replace('__', '/')}:={v}" for k, v in parameters.items()]
        # As rosrun would, which would take as long for finding it as the node for starting.
        executable = self.workspace.folder / "devel" / "lib" / package / package
        with self.workspace.fork(
            str(executable), *remap, *arguments, master=self.master
        ) as process:
            node = Node(process, name, ear, mark)
            ear.hears(f"{name}/state", since=mark)
            self.master.await_links(name)
            yield node
        self.master.forget(name)  # it may have been killed
        if ear.process.poll() is None:
            ear.do("lose", node=name)  # so that nothing of it comes when the next one runs
        # Parameters outlive their node, and the next test's node has the same name.
        with contextlib.suppress(OSError, Fault):
            ServerProxy(self.master.uri).deleteParam("/stage", name)

    @contextlib.contextmanager
    def guarded(self, ear: Puppet, model: str) -> Iterator[tuple[Node, Node]]:
        """The supervisor, and the controller that it guards."""
        rules = [f"/{name}:=/supervised/{name}" for name in NAMES[model]]
        with (
            self.controller(ear, f"{model}_controller", rules) as controller,
            self.controller(ear, f"{model}_supervisor") as supervisor,
        ):
            yield supervisor, controller
