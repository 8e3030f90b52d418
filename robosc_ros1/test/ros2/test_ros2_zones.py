"""Four robots in eight zones, of which one is killed and started again, on ROS 2."""

from __future__ import annotations

import signal
from collections.abc import Callable

import pytest
from fleet_of_four import play
from ros2.ros2_support import Graph, Peer, Process

NODE = "floor_controller"
TYPES = {"zone": "std_msgs/msg/Int16", "wants": "std_msgs/msg/Bool"}


class Peers:
    """A peer for each robot."""

    def __init__(self, graph: Graph, ear: Peer) -> None:
        self._graph, self._ear = graph, ear
        self._robots: dict[str, Peer] = {}
        self._told: dict[tuple[str, str], set[int]] = {}

    def start(self, robot: str) -> None:
        peer = self._robots[robot] = self._graph.peer(robot)
        for what in ("go", "wait"):
            peer.subscribe(f"/{robot}/{what}", "std_msgs/msg/Int16")

    def kill(self, robot: str) -> None:
        process = self._robots[robot].process
        process.signal(signal.SIGKILL)
        process.wait()

    def say(self, robot: str, what: str, value: int | bool) -> None:
        self._robots[robot].order(
            "say", name=f"/{robot}/{what}", type=TYPES[what], data={"data": value}
        )

    def hears(self, robot: str, what: str, value: int) -> None:
        self._take(robot, what)
        name = f"/{robot}/{what}"
        self._robots[robot].expect("message", where=lambda m: m["data"] == value, name=name)

    def told(self, robot: str, what: str) -> set[int]:
        self._take(robot, what)
        return self._told[robot, what]

    def _take(self, robot: str, what: str) -> None:
        peer, name = self._robots[robot], f"/{robot}/{what}"
        told = self._told.setdefault((robot, what), set())
        for _ in peer.events("message", name=name):
            told.add(peer.expect("message", name=name)["data"]["data"])

    def falls_silent(self, robot: str) -> None:
        side, number = robot.split("_")
        name = f"{side.capitalize()}[{number}].place"
        self._ear.expect_state(NODE, lambda s: s["communications"][name] == "silent")


@pytest.mark.once
def test_no_robot_enters_a_zone_of_another(
    graph: Graph, controller: Callable[..., Process]
) -> None:
    ear = graph.peer("ear")
    ear.watch(NODE)
    controller(NODE)
    play(Peers(graph, ear))
