"""The navigation example on ROS 2: the simulated base and its generated controller."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from ros2.bed import REPOSITORY
from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition

Start = Callable[..., Process]
NODE = "navigation_controller"
BASE = REPOSITORY / "examples" / "navigation" / "nodes" / "simulated_base_ros2.py"


@pytest.fixture
def person(graph: Graph, controller: Start, tmp_path: Path) -> Peer:
    """Clicks, presses the stop, and watches; the first drive takes half the way for the whole, the next gets
    stuck."""
    parameters = ("--ros-args", "-p", "speed:=10.0", "-p", "failures:=2")
    graph.fork(BASE, *parameters)
    inputs = ("clicked_point", "emergency_stop")
    quality = {f"qos__{name}__reliability": "reliable" for name in inputs}
    controller(NODE, event_log=str(tmp_path / "events.jsonl"), **quality)
    peer = graph.peer("person")
    peer.watch(NODE)
    peer.subscribe("/pose", "geometry_msgs/msg/Pose2D")
    return peer


def click(person: Peer, x: float, y: float) -> None:
    data = {"point": {"x": x, "y": y}}
    person.publish("/clicked_point", "geometry_msgs/msg/PointStamped", data)


def stop(person: Peer, pressed: bool) -> None:
    person.publish("/press", "std_msgs/msg/Bool", {"data": pressed})


@pytest.mark.once
def test_it_drives_to_the_click_and_tries_again_after_an_error(
    person: Peer, tmp_path: Path
) -> None:
    click(person, 3.0, 4.0)
    person.expect("message", name="/pose", where=lambda d: (d["x"], d["y"]) == (3.0, 4.0))
    person.expect_state(
        NODE,
        lambda s: s["counters"]["errors"] == 2 and s["components"]["Operator"] == "content",
    )
    log = tmp_path / "events.jsonl"

    def reasons() -> list[str]:
        events = map(json.loads, log.read_text().splitlines())
        return [e["reason"] for e in events if e["event"]["kind"] == "error"]

    await_condition(lambda: reasons() == ["refused", "failed"], "both errors in the log")


@pytest.mark.once
def test_the_emergency_stop_cancels_and_release_goes_on(person: Peer) -> None:
    click(person, 30.0, 40.0)
    person.expect_state(NODE, lambda s: s["components"]["Navigator"] == "driving")
    stop(person, True)
    state = person.expect_state(NODE, lambda s: s["components"]["Navigator"] == "resting")
    assert state["components"]["Operator"] == "waiting"
    click(person, 3.0, 0.0)
    stop(person, False)
    person.expect("message", name="/pose", where=lambda d: (d["x"], d["y"]) == (3.0, 0.0))
    person.expect_state(NODE, lambda s: s["components"]["Operator"] == "content")
