"""A behaviour tree (py_trees) orders, is refused, and interrupts, on real rclpy."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from ros2.bed import HERE
from ros2.ros2_support import Graph, Peer, Process
from ros2.test_ros2_goals_of_the_robot import NODE, step
from ros_support import await_condition

Start = Callable[..., Process]


class Tree:
    """The running tree, which is ticked when something is awaited of it."""

    def __init__(self, process: Process, robot: Peer) -> None:
        self._process = process
        self.robot = robot
        robot.order("repeat", name="/tick", type="std_msgs/msg/Empty", data={}, qos={}, period=0.05)

    @property
    def told(self) -> list[dict[str, Any]]:
        lines = self._process.output.splitlines()
        return [json.loads(line) for line in lines if line.startswith("{")]

    def expect(self, leaf: str, status: str, message: str = "") -> None:
        def is_told() -> bool:
            return any(
                (line["leaf"], line["status"]) == (leaf, status) and message in line["message"]
                for line in self.told
            )

        await_condition(is_told, f"{leaf} to be {status}", 60.0)

    def expect_controller(self, where: Callable[[dict[str, Any]], object]) -> None:
        self.robot.expect_state(NODE, where)


@pytest.fixture
def tree(graph: Graph, controller: Start) -> Tree:
    controller(NODE, qos__step__reliability="reliable", qos__fault__reliability="reliable")
    robot = graph.peer()
    robot.watch(NODE)
    return Tree(graph.fork(HERE / "tree_node.py"), robot)


def test_a_refused_order_falls_back_to_others(tree: Tree) -> None:
    tree.expect("nowhere", "FAILURE", "rejected")
    tree.expect_controller(lambda s: s["components"]["Missions"] == "running")
    step(tree.robot, 3)
    tree.expect("there", "SUCCESS")
    tree.expect("back", "SUCCESS")
    tree.expect("root", "SUCCESS")


def test_an_alarm_cancels_the_order(tree: Tree) -> None:
    """The order that comes after it finds the controller free again."""
    alarm = {"name": "/alarm", "type": "std_msgs/msg/Bool"}
    tree.expect_controller(lambda s: s["components"]["Missions"] == "running")
    tree.robot.publish(**alarm, data={"data": True})
    tree.expect("there", "INVALID")
    tree.expect_controller(lambda s: s["communications"]["mission"] == "idle")
    tree.robot.publish(**alarm, data={"data": False})
    tree.expect_controller(lambda s: s["components"]["Missions"] == "running")
    step(tree.robot, 3)
    tree.expect("root", "SUCCESS")


def test_a_broken_robot_fails_the_tree(tree: Tree) -> None:
    tree.expect_controller(lambda s: s["components"]["Missions"] == "running")
    tree.robot.publish("/fault", "std_msgs/msg/Bool", {"data": True})
    tree.expect("there", "FAILURE", "Missions is in running")
    tree.expect("root", "FAILURE")
