"""The test bed itself: two processes talk by topic, service and action, own interfaces too."""

from __future__ import annotations

from ros2.ros2_support import Graph

SAMPLE = {
    "valid": True, "count": -7, "level": 200, "ratio": 0.5, "distance": 1.25, "label": "door",
    "samples": [0.5, 1.5], "vector": [1.0, 2.0, 3.0],
}  # fmt: skip


def test_topic(graph: Graph) -> None:
    left, right = graph.peer("left"), graph.peer("right")
    right.subscribe("reading", "robosc_testing/msg/Reading")
    left.publish("reading", "robosc_testing/msg/Reading", SAMPLE)
    assert right.expect("message", name="reading")["data"] == SAMPLE


def test_service(graph: Graph) -> None:
    left, right = graph.peer("left"), graph.peer("right")
    right.serve("light", "std_srvs/srv/SetBool", {"success": True, "message": "on"})
    reply = left.order("call", name="light", type="std_srvs/srv/SetBool", data={"data": True})
    assert reply == {"success": True, "message": "on"}
    assert right.expect("request", name="light")["data"] == {"data": True}


def test_action(graph: Graph) -> None:
    left, right = graph.peer("left"), graph.peer("right")
    right.act("move", "robosc_testing/action/Move")
    left.order("send_goal", name="move", type="robosc_testing/action/Move", data={"target": 2})
    goal = right.expect("goal", name="move")
    assert goal["data"] == {"target": 2.0}
    right.order("tell_server", id=goal["id"], feedback={"progress": 0.5})
    assert left.expect("feedback", name="move")["data"] == {"progress": 0.5}
    right.order("tell_server", id=goal["id"], end="succeed", result={"code": 3, "reached": 2})
    result = left.expect("result", name="move")
    assert (result["status"], result["data"]) == (4, {"code": 3, "reached": 2.0})
