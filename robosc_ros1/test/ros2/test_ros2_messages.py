"""Messages through a generated controller on real rclpy, and the package's build."""

from __future__ import annotations

from collections.abc import Callable

from ros2.ros2_support import Graph, Process

READING = "robosc_testing/msg/Reading"


def test_a_command_follows_the_input_that_allows_it(
    graph: Graph, controller: Callable[..., Process]
) -> None:
    controller()
    robot = graph.peer()
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.publish("person", READING, {"valid": True, "distance": 3.0})
    robot.publish("person", READING, {"valid": True, "distance": 0.5})
    robot.expect("message", name="beacon")
