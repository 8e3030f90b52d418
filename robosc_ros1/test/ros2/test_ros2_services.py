"""Service calls of a generated controller on real rclpy: each request ends exactly once."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ros2.ros2_support import Graph, Peer, Process
from ros_support import await_condition, stopped

Start = Callable[..., Process]
SERVICE = "std_srvs/srv/SetBool"
State = dict[str, Any]


def wanting(graph: Graph) -> Peer:
    """A robot whose operator wants the arm to reach, for which the door must be locked."""
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    return robot


def door(robot: Peer, state: str, where: Callable[[State], object] = lambda s: True) -> State:
    return robot.expect_state(
        "guarded_arm", lambda s: s["components"]["Door"] == state and where(s)
    )


def test_a_call_carries_its_data_and_brings_the_response(graph: Graph, controller: Start) -> None:
    controller()
    robot = wanting(graph)
    robot.serve("door/lock", SERVICE)
    request = robot.expect("request", name="door/lock")
    assert request["data"] == {"data": True}
    state = door(robot, "locking")
    assert state["communications"]["lock"] == "busy"
    robot.order("tell_server", id=request["id"], data={"success": True})
    door(robot, "locked")


def test_a_refusal_is_a_response(graph: Graph, controller: Start) -> None:
    controller(rate=0.1)
    robot = wanting(graph)
    robot.serve("door/lock", SERVICE, {"success": False})
    door(robot, "open", lambda s: s["communications"]["lock"] == "idle" and s["latest"])
    robot.expect("request", name="door/lock")
    state = door(robot, "open", lambda s: s["counters"]["inputs"] == 2)
    assert state["counters"]["errors"] == 0


def test_a_server_that_is_absent_becomes_an_error(graph: Graph, controller: Start) -> None:
    node = controller(timeout__lock=0.3)
    robot = wanting(graph)
    door(robot, "open", lambda s: s["counters"]["errors"] >= 2)
    missing = "no server of /door/lock is connected"
    assert "lock failed: " + missing in node.output
    door(robot, "open", lambda s: missing in s["unconnected"] and missing in str(s["faults"]))
    await_condition(lambda: "]: " + missing in node.output, "the warning")
    robot.serve("door/lock", SERVICE, {"success": True})
    robot.expect_state(
        "guarded_arm",
        lambda s: missing not in s["unconnected"] and missing not in str(s["faults"]),
    )
    await_condition(lambda: "no longer: " + missing in node.output, "that it is back")
    assert node.output.count("]: " + missing) == 1


def test_a_server_that_comes_in_time_is_waited_for(graph: Graph, controller: Start) -> None:
    controller(timeout__lock=60.0)
    robot = wanting(graph)
    door(robot, "locking")
    robot.serve("door/lock", SERVICE, {"success": True})
    state = door(robot, "locked")
    assert state["counters"]["errors"] == 0


def test_an_answer_after_the_deadline_is_dropped(graph: Graph, controller: Start) -> None:
    controller(timeout__lock=0.5, rate=0.5)
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.serve("door/lock", SERVICE)
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    request = robot.expect("request", name="door/lock")
    now = door(robot, "open", lambda s: s["counters"]["errors"] > 0)
    robot.order("tell_server", id=request["id"], data={"success": True})
    # What locks is a later call, the first that is answered in time.
    while now["components"]["Door"] != "locked":
        request = robot.expect("request", name="door/lock")
        robot.order("tell_server", id=request["id"], data={"success": True})
        now = robot.expect_state(
            "guarded_arm",
            lambda s, n=now["counters"]["errors"]: (
                s["components"]["Door"] == "locked" or s["counters"]["errors"] > n
            ),
        )
    assert now["counters"]["mismatches"] == 0
    assert now["counters"]["inputs"] == 2 + now["counters"]["errors"]


def test_a_server_that_dies_in_the_call_becomes_an_error(graph: Graph, controller: Start) -> None:
    controller(timeout__lock=1.0)
    robot, server = wanting(graph), graph.peer("server")
    server.serve("door/lock", SERVICE)
    server.expect("request", name="door/lock")
    server.process.popen.kill()
    door(robot, "open", lambda s: s["counters"]["errors"] >= 1)


def test_a_server_that_stands_still_gives_one_error_per_request(
    graph: Graph, controller: Start, tmp_path: Path
) -> None:
    log = tmp_path / "events.jsonl"
    controller(timeout__lock=0.2, event_log=str(log))
    robot, server = wanting(graph), graph.peer("server")
    server.serve("door/lock", SERVICE, {"success": False})
    door(robot, "open", lambda s: s["counters"]["inputs"] >= 2)
    with stopped(server.process.popen.pid):
        state = robot.expect_state("guarded_arm", lambda s: s["counters"]["errors"] >= 4)
    # What it then answers to calls that are over is dropped, and the next one is served.
    errors, inputs = state["counters"]["errors"], state["counters"]["inputs"]
    robot.expect_state(
        "guarded_arm",
        lambda s: s["counters"]["inputs"] - s["counters"]["errors"] > inputs - errors,
    )
    calls = [kind for kind, name in events(log) if name == "lock"]
    assert set(calls[::2]) == {"request"}
    assert set(calls[1::2]) == {"response", "error"}


def events(log: Path) -> list[tuple[str, str]]:
    lines = map(json.loads, log.read_text().splitlines())
    return [(line["event"]["kind"], line["event"]["name"]) for line in lines]


def test_responses_to_other_clients_are_none_of_its_own(graph: Graph, controller: Start) -> None:
    controller()
    robot, other = wanting(graph), graph.peer("other")
    robot.serve("door/lock", SERVICE)
    own = robot.expect("request", name="door/lock")
    other.order("start_call", name="door/lock", type=SERVICE, data={"data": False})
    foreign = robot.expect("request", name="door/lock")
    robot.order("tell_server", id=foreign["id"], data={"success": True})
    assert other.expect("response")["data"]["success"]
    assert door(robot, "locking")["communications"]["lock"] == "busy"
    robot.order("tell_server", id=own["id"], data={"success": False})
    door(robot, "open")


def test_a_service_of_another_type_is_told_and_does_no_harm(
    graph: Graph, controller: Start
) -> None:
    controller(timeout__lock=0.2)
    robot, stranger = wanting(graph), graph.peer("stranger")
    stranger.serve("door/lock", "std_srvs/srv/Trigger", {"success": True})
    told = (
        "the service /door/lock is a std_srvs/srv/Trigger, but this node has std_srvs/srv/SetBool"
    )
    robot.expect_state(
        "guarded_arm",
        lambda s: s["counters"]["errors"] and any(told in fault for fault in s["faults"]),
    )
    stranger.process.end()
    robot.serve("door/lock", SERVICE, {"success": True})
    door(robot, "locked")
