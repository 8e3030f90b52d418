"""A robot docks by what is told on /tf and /tf_static."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from ros2.ros2_support import Graph, Process

NODE = "docking_controller"
SPEEDS = {"approach": 0.4, "creep": 0.1, "halt": 0.0}


@pytest.mark.once
def test_it_docks(graph: Graph, controller: Callable[..., Process]) -> None:
    peer = graph.peer("robot")
    peer.watch(NODE)
    peer.subscribe("/cmd_vel", "geometry_msgs/msg/Twist")

    def stands_at(x: float) -> None:
        peer.order("broadcast", links=[("map", "odom", 1.0), ("odom", "base_link", x - 1.0)])

    def moves(name: str) -> None:
        peer.expect("message", where=lambda m: m["linear"]["x"] == SPEEDS[name], name="/cmd_vel")

    stands_at(0.0)  # before the node starts: where the dock is, is latched
    controller(NODE)
    moves("approach")
    for x, name in ((4.2, "creep"), (4.8, "halt"), (-1.0, "approach")):
        stands_at(x)
        moves(name)
    # Localisation dies, and odometry goes on.
    peer.order("broadcast", links=[("odom", "base_link", 0.0)])
    moves("halt")
    stands_at(0.0)
    moves("approach")
    stranger = graph.peer("stranger")
    stranger.order("broadcast", links=[("world", "base_link", 0.0)])
    moves("halt")
    # rclpy does not tell which of them it was.
    both = "(from /robot or /stranger)"
    state = peer.expect_state(NODE, lambda s: str(s["faults"]).count(both) == 2)
    assert "two parents" in str(state["faults"])
    stranger.order("broadcast", links=[("stranger", "frame", 0.0)])
    moves("approach")
