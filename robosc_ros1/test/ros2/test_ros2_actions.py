"""Goals of a generated controller on real rclpy: each ends exactly once, whatever happens."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest
from ros2.bed import HERE
from ros2.ros2_support import Graph, Peer, Process
from ros_support import stopped

Start = Callable[..., Process]
ACTION = "robosc_testing/action/Move"
READING = "robosc_testing/msg/Reading"
State = dict[str, Any]


def ready(graph: Graph, **policy: Any) -> Peer:
    """A robot whose door is locked and whose operator wants the arm to reach."""
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
    if policy.pop("serve", True):
        robot.act("reach", ACTION, **policy)
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    return robot


def arm(robot: Peer, state: str, where: Callable[[State], object] = lambda s: True) -> State:
    return robot.expect_state("guarded_arm", lambda s: s["components"]["Arm"] == state and where(s))


def told(robot: Peer, goal: dict[str, Any], **words: Any) -> None:
    robot.order("tell_server", id=goal["id"], **words)


@pytest.mark.once
def test_goal_feedback_and_result(graph: Graph, controller: Start) -> None:
    controller(rate=0.1)
    robot = ready(graph)
    robot.subscribe("speed", "std_msgs/msg/Float32")
    goal = robot.expect("goal", name="reach")
    assert goal["data"] == {"target": 2.0}
    told(robot, goal, feedback={"progress": 0.25})
    state = arm(robot, "reaching", lambda s: s["variables"]["Arm.progress"] == 0.25)
    assert state["communications"]["reach"] == "busy"
    told(robot, goal, end="succeed", result={"code": 0})
    state = arm(robot, "resting", lambda s: s["variables"]["Arm.last"] == "good")
    assert state["counters"]["errors"] == 0


def test_rejection_becomes_an_error(graph: Graph, controller: Start) -> None:
    node = controller(rate=0.1)
    robot = ready(graph, accept=False)
    arm(robot, "resting", lambda s: s["counters"]["errors"] == 1)
    assert "reach failed: rejected" in node.output


def test_abort_becomes_an_error(graph: Graph, controller: Start) -> None:
    node = controller(rate=0.1)
    robot = ready(graph, end="abort")
    arm(robot, "resting", lambda s: s["counters"]["errors"] == 1)
    assert "reach failed: aborted" in node.output


def test_absence_of_the_server_becomes_an_error(graph: Graph, controller: Start) -> None:
    node = controller(timeout__reach=0.3)
    robot = ready(graph, serve=False)
    arm(robot, "resting", lambda s: s["counters"]["errors"] >= 2)
    missing = "no server of /reach is connected"
    assert "reach failed: " + missing in node.output
    arm(robot, "resting", lambda s: missing in s["unconnected"] and missing in str(s["faults"]))
    # And when it comes at last, it is used.
    robot.act("reach", ACTION)
    robot.expect("goal", name="reach")
    told = robot.expect_state("guarded_arm", lambda s: missing not in s["unconnected"])
    assert missing not in str(told["faults"])


@pytest.mark.parametrize("end", ["canceled", "succeed", "abort"])
def test_a_violated_requirement_cancels(graph: Graph, controller: Start, end: str) -> None:
    controller()
    robot = ready(graph)
    goal = robot.expect("goal", name="reach")
    robot.publish("person", READING, {"valid": True, "distance": 0.5})
    assert robot.expect("cancel", name="reach")["id"] == goal["id"]
    # It goes on until the server says how it has ended.
    arm(robot, "reaching", lambda s: s["communications"]["reach"] == "cancelling")
    told(robot, goal, feedback={"progress": 0.5})
    told(robot, goal, end=end, result={"code": 0})
    state = arm(robot, "resting", lambda s: s["communications"]["reach"] == "idle")
    assert state["variables"]["Arm.last"] == ("good" if end == "succeed" else "bad")
    assert state["variables"]["Arm.progress"] == 0.0
    robot.publish("person", READING, {"valid": True, "distance": 5.0})
    told(robot, robot.expect("goal", name="reach"), end="succeed", result={"code": 0})
    # The arm rests for a moment only, which need not be told: it is wanted to reach again.
    state = robot.expect_state("guarded_arm", lambda s: s["counters"]["inputs"] >= 6)
    assert state["variables"]["Arm.last"] == "good"
    assert state["counters"]["errors"] == (end == "abort")
    assert state["counters"]["mismatches"] == 0


def test_the_server_of_a_goal_that_was_accepted_while_it_was_cancelled_is_watched(
    graph: Graph, built: Any
) -> None:
    """The executor takes the acceptance before what the cancel has left to it."""
    robot = graph.peer()
    robot.act("go", "robot_common/action/Navigate")
    script = HERE / "cancelled_goal_node.py"
    node = graph.fork(script, **built.environment("courier_controller"))
    assert node.wait(60.0) == 0, node.output


def test_a_refused_cancel_is_survived(graph: Graph, controller: Start) -> None:
    node = controller(timeout__reach=60.0)
    robot = ready(graph, cancel=False)
    goal = robot.expect("goal", name="reach")
    robot.publish("person", READING, {"valid": True, "distance": 0.5})
    robot.expect("cancel", name="reach")
    # The goal goes on: the next one waits for its end, and the server is asked again.
    robot.publish("person", READING, {"valid": True, "distance": 5.0})
    robot.expect_state(
        "guarded_arm", lambda s: any("reach: a goal goes on" in f for f in s["faults"])
    )
    robot.expect("cancel", name="reach")
    assert "refuses to cancel" in node.output
    assert robot.events("goal", name="reach") == []
    told(robot, goal, end="succeed", result={"code": 0})
    robot.expect("goal", name="reach")
    robot.expect_state("guarded_arm", lambda s: s["faults"] == [])


def test_a_cancel_that_is_not_answered_is_repeated(graph: Graph, controller: Start) -> None:
    controller()
    robot = ready(graph, cancel=None)
    goal = robot.expect("goal", name="reach")
    robot.publish("person", READING, {"valid": True, "distance": 0.5})
    for _ in range(3):
        assert robot.expect("cancel", name="reach")["id"] == goal["id"]
    robot.expect_state(
        "guarded_arm",
        lambda s: (
            s["communications"]["reach"] == "cancelling"
            and any("reach: a goal goes on" in fault for fault in s["faults"])
        ),
    )
    told(robot, goal, end="succeed", result={"code": 0})
    arm(robot, "resting", lambda s: s["communications"]["reach"] == "idle")


def test_a_goal_over_its_deadline_is_cancelled(graph: Graph, controller: Start) -> None:
    node = controller(goal_timeout__reach=0.4, rate=0.1)
    robot = ready(graph)
    goal = robot.expect("goal", name="reach")
    robot.expect("cancel", name="reach")
    arm(robot, "reaching")
    assert "reach is cancelled: deadline exceeded" in node.output
    told(robot, goal, end="canceled")
    arm(robot, "resting", lambda s: s["counters"]["errors"] == 1)
    assert "reach failed: deadline exceeded" in node.output


def test_a_server_that_leaves_the_graph_is_lost(graph: Graph, controller: Start) -> None:
    node = controller(server_lost_after=0.5)
    robot = ready(graph, serve=False)
    # How soon a killed process is noticed, is said by itself when it joins.
    profile = str(HERE / "short_lease.xml")
    server = graph.peer("server", FASTRTPS_DEFAULT_PROFILES_FILE=profile)
    server.act("reach", ACTION)
    server.expect("goal", name="reach")
    server.process.signal(signal.SIGKILL)
    arm(robot, "resting", lambda s: s["counters"]["errors"] >= 1)
    assert "reach failed: server lost" in node.output
    # Another one takes its place.
    robot.act("reach", ACTION, end="succeed")
    arm(robot, "resting", lambda s: s["variables"]["Arm.last"] == "good")


def test_a_server_that_was_started_anew_does_not_know_the_goal(
    graph: Graph, controller: Start
) -> None:
    node = controller(server_lost_after=600.0, rate=0.1)
    robot = ready(graph)
    robot.expect("goal", name="reach")
    robot.order("withdraw", name="reach")
    robot.act("reach", ACTION)
    arm(robot, "resting", lambda s: s["counters"]["errors"] == 1)
    assert "reach failed: unknown to the server" in node.output


def test_a_goal_accepted_after_its_deadline_is_cancelled(graph: Graph, controller: Start) -> None:
    # An accepted goal has the same deadline, in case it is accepted before all stands still.
    controller(timeout__reach=1.0, goal_timeout__reach=1.0, rate=0.3)
    robot = ready(graph, serve=False)
    server = graph.peer("server")
    server.act("reach", ACTION)
    told(server, server.expect("goal", name="reach"), end="abort")
    before = arm(robot, "resting", lambda s: s["counters"]["errors"] >= 1)["counters"]["errors"]
    # Now it is there, but does not answer to the next.
    with stopped(server.process.popen.pid):
        state = arm(robot, "resting", lambda s: s["counters"]["errors"] > before)
    late = server.expect("goal", name="reach")
    assert server.expect("cancel", name="reach")["id"] == late["id"]
    assert state["counters"]["mismatches"] == 0


def test_no_goal_is_sent_while_the_one_before_may_be_accepted(
    graph: Graph, controller: Start
) -> None:
    controller(timeout__reach=0.5, server_lost_after=0.5)
    robot = ready(graph, accept=None)
    first = robot.expect("asked", name="reach")
    # It has failed, and so do the goals that are not sent.
    arm(robot, "resting", lambda s: s["counters"]["errors"] >= 3)
    assert robot.events("asked", name="reach") == []
    robot.expect_state("guarded_arm", lambda s: any("a goal goes on" in f for f in s["faults"]))
    told(robot, first, accept=True)
    late = robot.expect("goal", name="reach")
    assert robot.expect("cancel", name="reach")["id"] == late["id"]
    assert robot.events("asked", name="reach") == []
    told(robot, late, end="canceled")
    told(robot, robot.expect("asked", name="reach"), accept=False)
    told(robot, robot.expect("asked", name="reach"), accept=True)
    told(robot, robot.expect("goal", name="reach"), end="succeed", result={"code": 0})
    robot.expect_state("guarded_arm", lambda s: s["variables"]["Arm.last"] == "good")


def test_nothing_is_asked_of_a_server_while_another_of_its_actions_goes_on(
    graph: Graph, controller: Start
) -> None:
    timeouts = {"timeout__drive": 1.5, "server_lost_after": 0.5, "timeout__home": 60.0}
    controller("shared_controller", qos__target__reliability="reliable", **timeouts)
    robot, name = graph.peer(), "navigate"
    robot.watch("shared_controller")
    robot.serve("switch", "std_srvs/srv/SetBool", {"success": True})
    robot.act(name, "robot_common/action/Navigate", accept=None)
    target = {"pose": {"position": {"x": 3.0}}}
    robot.publish("target", "geometry_msgs/msg/PoseStamped", target)
    drive = robot.expect("asked", name=name)
    assert drive["data"]["x"] == 3.0
    # That has failed, and home is to begin.
    robot.expect_state("shared_controller", lambda s: s["communications"]["home"] == "busy")
    told(robot, drive, accept=True)
    late = robot.expect("goal", name=name)
    assert robot.expect("cancel", name=name)["id"] == late["id"]
    assert robot.events("asked", name=name) == []
    told(robot, late, end="canceled")
    home = robot.expect("asked", name=name)
    assert home["data"]["x"] == 0.0
    told(robot, home, accept=True)
    told(robot, robot.expect("goal", name=name), end="succeed", result={"distance": 0.1})
    # It is ready, and goes there again.
    assert robot.expect("asked", name=name)["data"]["x"] == 3.0


@pytest.mark.once
def test_two_servers_of_one_action_are_a_fault(graph: Graph, controller: Start) -> None:
    controller()
    robot, other = ready(graph), graph.peer("other")
    other.act("reach", ACTION)
    several = "all publish /reach/_action/status: a goal goes to each"
    robot.expect_state("guarded_arm", lambda s: any(several in fault for fault in s["faults"]))
    other.order("withdraw", name="reach")
    robot.expect_state("guarded_arm", lambda s: s["faults"] == [])


def test_goals_of_others_are_none_of_its_own(graph: Graph, controller: Start) -> None:
    controller(rate=0.1)
    robot, other = ready(graph), graph.peer("other")
    goal = robot.expect("goal", name="reach")
    other.order("send_goal", name="reach", type=ACTION, data={"target": 9})
    foreign = robot.expect("goal", name="reach", where=lambda data: data["target"] == 9)
    told(robot, foreign, feedback={"progress": 0.75})
    other.expect("feedback", name="reach")
    told(robot, foreign, end="succeed", result={"code": 0})
    other.expect("result", name="reach")
    told(robot, goal, feedback={"progress": 0.25})
    state = arm(robot, "reaching", lambda s: s["variables"]["Arm.progress"] == 0.25)
    assert (state["variables"]["Arm.last"], state["counters"]["late"]) == ("bad", 0)
    told(robot, goal, end="succeed", result={"code": 0})
    arm(robot, "resting", lambda s: s["variables"]["Arm.last"] == "good")


def test_a_goal_of_somebody_else_makes_the_server_busy(graph: Graph, controller: Start) -> None:
    """Also one that was begun before the node was; it is not the node's to cancel."""
    other = graph.peer("other")
    robot = graph.peer()
    robot.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
    robot.act("reach", ACTION)
    other.order("send_goal", name="reach", type=ACTION, data={"target": 9})
    foreign = robot.expect("goal", name="reach")
    controller()
    robot.watch("guarded_arm")
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    told_by = "/reach: the server carries out a goal that this node did not send"
    robot.expect_state("guarded_arm", lambda s: any(told_by in fault for fault in s["faults"]))
    robot.expect_state("guarded_arm", lambda s: s["communications"]["reach"] == "busy")
    told(robot, foreign, end="succeed", result={"code": 0})
    other.expect("result", name="reach")
    own = robot.expect("goal", name="reach", where=lambda data: data["target"] != 9)
    assert own["id"] != foreign["id"]
    robot.expect_state("guarded_arm", lambda s: s["faults"] == [])


def test_many_goals_of_others_hide_nothing(graph: Graph, controller: Start) -> None:
    controller()
    robot, other = ready(graph, cancel=False), graph.peer("other")
    robot.expect("goal", name="reach")
    for number in range(5):
        other.order("send_goal", name="reach", type=ACTION, data={"target": number})
    robot.publish("person", READING, {"valid": True, "distance": 0.5})
    robot.expect("cancel", name="reach")
    state = robot.expect_state("guarded_arm", lambda s: len(s["faults"]) == 2)
    assert "did not send" in state["faults"][0] and state["faults"][0].endswith(", 2 more")
    assert "was cancelled" in state["faults"][1]


def test_a_goal_that_others_cancel_becomes_an_error(graph: Graph, controller: Start) -> None:
    node = controller(rate=0.1)
    robot, other = ready(graph), graph.peer("other")
    goal = robot.expect("goal", name="reach")
    everything = {"type": "action_msgs/srv/CancelGoal", "data": {}}
    other.order("call", name="reach/_action/cancel_goal", **everything)
    robot.expect("cancel", name="reach")
    told(robot, goal, end="canceled")
    arm(robot, "resting", lambda s: s["counters"]["errors"] == 1)
    assert "reach failed: cancelled" in node.output


def test_a_storm_of_feedback_is_followed_to_its_end(graph: Graph, controller: Start) -> None:
    controller(rate=0.1)
    robot = ready(graph)
    goal = robot.expect("goal", name="reach")
    for part in range(10):
        told(robot, goal, feedback=[{"progress": part + n / 100} for n in range(1, 101)])
    told(robot, goal, feedback={"progress": -1.0})
    arm(robot, "reaching", lambda s: s["variables"]["Arm.progress"] == -1.0)
    told(robot, goal, end="succeed", result={"code": 0})
    state = arm(robot, "resting", lambda s: s["variables"]["Arm.last"] == "good")
    assert state["counters"]["errors"] == state["counters"]["mismatches"] == 0


def test_feedback_that_came_before_the_result_is_taken_before_it(
    graph: Graph, controller: Start
) -> None:
    controller(rate=0.1)
    robot = ready(graph)
    goal = robot.expect("goal", name="reach")
    reports = [{"progress": n / 100} for n in range(1, 51)]
    told(robot, goal, feedback=reports, end="succeed", result={"code": 0})
    state = arm(robot, "resting", lambda s: s["variables"]["Arm.last"] == "good")
    assert (state["variables"]["Arm.progress"], state["counters"]["late"]) == (0.5, 0)


def test_a_result_that_got_lost_is_asked_for_again(graph: Graph, controller: Start) -> None:
    controller(rate=0.1)
    robot = ready(graph, lose=1)
    told(robot, robot.expect("goal", name="reach"), end="succeed", result={"code": 0})
    state = arm(robot, "resting", lambda s: s["variables"]["Arm.last"] == "good")
    assert state["counters"]["errors"] == state["counters"]["late"] == 0


def test_a_result_that_got_lost_while_the_goal_was_cancelled_is_asked_for_again(
    graph: Graph, controller: Start
) -> None:
    controller()
    robot = ready(graph, lose=1)
    goal = robot.expect("goal", name="reach")
    robot.publish("person", READING, {"valid": True, "distance": 0.5})
    robot.expect("cancel", name="reach")
    told(robot, goal, end="canceled", result={"code": 0})
    arm(robot, "resting", lambda s: s["communications"]["reach"] == "idle")
    robot.publish("person", READING, {"valid": True, "distance": 5.0})
    told(robot, robot.expect("goal", name="reach"), end="succeed", result={"code": 0})
    robot.expect_state("guarded_arm", lambda s: s["variables"]["Arm.last"] == "good")
