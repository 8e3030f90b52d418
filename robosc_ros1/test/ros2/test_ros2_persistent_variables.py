"""What stays when a ROS 2 node is killed and started again."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ros2.ros2_support import Graph, Process
from ros_support import await_condition

NODE = "tour_controller"


@pytest.mark.once
def test_a_killed_node_goes_on(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path
) -> None:
    file = tmp_path / "tour.json"
    peer = graph.peer("robot")
    peer.watch(NODE)

    def first_after(**given: Any) -> tuple[Process, int, list[str]]:
        """A new node, with what it says at first."""
        # Reliable: a message is sent once, perhaps before both sides know of each other.
        given["qos__arrived__reliability"] = "reliable"
        node = controller(NODE, persistent_file=str(file), **given)
        state = peer.expect_state(NODE, lambda s: s["begun"] not in seen)
        seen.add(state["begun"])
        return node, state["variables"]["Tour.next"], state["faults"]

    def kill(node: Process) -> None:
        node.signal(signal.SIGKILL)
        node.wait()

    seen: set[float] = set()
    node, value, faults = first_after()
    assert value == 2
    assert any("No such file" in fault for fault in faults)
    for number in (3, 4):
        peer.publish("arrived", "std_msgs/msg/Empty", {})
        peer.expect_state(NODE, lambda s, n=number: s["variables"]["Tour.next"] == n)
    await_condition(lambda: file.is_file() and '"Tour.next": 4' in file.read_text(), "the write")
    kill(node)
    node, value, faults = first_after()
    assert (value, [f for f in faults if str(file) in f]) == (4, [])
    kill(node)
    node, value, faults = first_after(forget=True)
    assert (value, [f for f in faults if str(file) in f]) == (2, [])
    kill(node)
    file.write_text(file.read_text()[:-9])
    node, value, faults = first_after()
    assert value == 2
    assert any("it is torn" in fault for fault in faults)
