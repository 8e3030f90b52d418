"""The world of ``wire.py`` on rclpy."""

from __future__ import annotations

import contextlib
import json
import signal
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import wire
from ros2.bed import Bed
from ros2.ros2_support import Graph, Peer, Process, free_domain
from ros_support import await_condition

__all__ = ["packages", "world"]

TYPES = {
    "wanted": "std_msgs/msg/Bool",
    "estop": "std_msgs/msg/Bool",
    "level": "std_msgs/msg/Int16",
    "drive": "std_msgs/msg/Int16",
    "halt": "std_msgs/msg/Empty",
}
MOVE, SWITCH = "robosc_testing/action/Move", "std_srvs/srv/SetBool"
PARTS = ("send_goal", "cancel_goal", "get_result", "feedback", "status")
SUPERVISED = (
    *("drive", "halt", "light", "wanted", "estop"),
    *(f"{name}/_action/{part}" for name in wire.ACTIONS for part in PARTS),
)
TRANSITIONS = {"activate": 3, "deactivate": 4}  # lifecycle_msgs/msg/Transition
CONFIGURE = 1


def packages(bed: Bed, folder: Path) -> None:
    """Generate a controller and a supervisor, plain and managed, and a controller for the latter
    that wants everything."""
    (folder / "managed.yaml").write_text("lifecycle: true\n", encoding="utf-8")
    managed = {f"managed_{mode}": ("--config", "managed.yaml") for mode in wire.MODES}
    known = {"AMENT_PREFIX_PATH": bed.environment["AMENT_PREFIX_PATH"]}
    wire.generate(folder, 2, {**dict.fromkeys(wire.NODES, ()), **managed}, known)


class _World:
    def __init__(self, graph: Graph, made: Path, mode: str, managed: bool) -> None:
        self._graph = graph
        self._made = made
        self._guards = mode == "supervisor"
        self._name = f"managed_{mode}" if managed else mode
        self._is_managed = managed
        self._ear = graph.peer("ear")
        self._servers: list[Peer] = []
        self._foreign: Counter[str] = Counter()
        self._node: Process

    def serve(self, server: str) -> None:
        peer = self._graph.peer(f"robot{len(self._servers)}")
        self._servers.append(peer)
        peer.serve("light", SWITCH, {"success": False} if server == "refusing" else None)
        for name in wire.ACTIONS:
            peer.act(name, MOVE, accept=server != "refusing")
            if server == "foreign":
                self._ear.order("send_goal", name=name, type=MOVE, data={"target": 1.0})
                goal = peer.expect("goal", name=name)
                self._foreign[goal["id"]] += 1

    def kill_servers(self) -> None:
        process = self._servers[-1].process
        process.signal(signal.SIGKILL)
        process.popen.wait()

    def free_servers(self) -> None:
        for goal in self._foreign:
            self._servers[-1].order("tell_server", id=goal, end="succeed")

    def begin(self) -> None:
        for topic in ("drive", "halt"):
            self._ear.subscribe(topic, TYPES[topic])
        self._node = self._start(self._name)
        if self._is_managed:
            self._change(CONFIGURE)
            self._change(TRANSITIONS["activate"])
        self.shows(lambda s: s["stopped"] is None)
        if self._guards:
            self._start("lax", *(f"{name}:=supervised/{name}" for name in SUPERVISED))
            self._ear.expect_state("wire_lax", lambda s: "supervised" not in str(s["unconnected"]))

    def _start(self, name: str, *rules: str) -> Process:
        parameters = {
            "operate": True, "on_mismatch": "stop", "state_rate": 20.0, "rate": 10.0,
            **{f"timeout.{call}": 90.0 for call in wire.CALLS},
            **{f"qos.{topic}.reliability": "reliable" for topic in ("wanted", "estop", "level")},
        }  # fmt: skip
        words = [f"-p {key}:={json.dumps(value)}" for key, value in parameters.items()]
        words += [f"-r {rule}" for rule in rules]
        code = f"from wire_{name}.start import main; main()"
        path = (
            f"{self._made / 'src' / ('wire_' + name)}:{self._graph.bed.environment['PYTHONPATH']}"
        )
        node = self._graph.fork(
            "-c", code, "--ros-args", *" ".join(words).split(),
            PYTHONPATH=path,
        )  # fmt: skip
        self._ear.watch(f"wire_{name}")
        return node

    def _change(self, transition: int) -> None:
        name, type_ = f"wire_{self._name}/change_state", "lifecycle_msgs/srv/ChangeState"
        data = {"transition": {"id": transition}}
        assert self._ear.order("call", name=name, type=type_, data=data)["success"]

    def say(self, topic: str, value: Any) -> None:
        self._ear.publish(topic, TYPES[topic], {"data": value})

    def order(self, what: str) -> None:
        if what == "end":
            self._node.signal(signal.SIGINT)
            self._node.wait()
        elif what in TRANSITIONS:
            self._change(TRANSITIONS[what])
        else:
            name = f"wire_{self._name}/operate"
            self._ear.publish(name, "std_msgs/msg/String", {"data": what})

    def asks(self, names: tuple[str, ...]) -> None:
        node = "wire_lax" if self._guards else f"wire_{self._name}"
        self._ear.expect_state(node, lambda s: all(s["communications"][n] == "busy" for n in names))

    def shows(self, condition: Callable[[dict[str, Any]], Any]) -> dict[str, Any]:
        return self._ear.expect_state(f"wire_{self._name}", condition)

    def heard(self) -> Counter[str]:
        found: Counter[str] = Counter()
        for topic in ("drive", "halt"):
            found[topic] = len(self._ear.events("message", name=topic))
        for peer in self._servers:
            found["light"] += len(peer.events("request", name="light"))
            for name in wire.ACTIONS:
                found[name] += len(peer.events("goal", name=name))
                found[f"cancel {name}"] += len(peer.events("cancel", name=name))
        return found

    def until(self, condition: Callable[[], Any], what: str) -> None:
        await_condition(condition, what)


@contextlib.contextmanager
def world(made: Path, mode: str, event: str, bed: Bed, folder: Path) -> Iterator[wire.World]:
    """A node of this mode and its robot, in a graph of their own."""
    with free_domain() as domain:
        graph = Graph(bed, domain, folder)
        try:
            yield _World(graph, made, mode, event == "deactivate")
        finally:
            graph.close()
