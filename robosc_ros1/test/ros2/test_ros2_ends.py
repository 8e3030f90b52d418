"""How a generated controller ends: safe stop and shutdown on real rclpy."""

from __future__ import annotations

import re
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from ros2.bed import HERE
from ros2.ros2_support import Graph, Process

from robosc.simulate.event_log import read_log
from robosc.simulate.replay import replay

Start = Callable[..., Process]
ACTION = "robosc_testing/action/Move"


@pytest.mark.once
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_shutdown_cancels_goals_and_sends_the_stop_command(
    graph: Graph, controller: Start, how: int
) -> None:
    node = controller(stop_command="warn")
    robot = graph.peer()
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
    robot.act("reach", ACTION)
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    goal = robot.expect("goal", name="reach")
    node.signal(how)
    assert robot.expect("cancel", name="reach")["id"] == goal["id"]
    robot.expect("message", name="beacon")
    assert node.wait() == 0
    assert "Traceback" not in node.output


def test_a_goal_that_its_server_has_not_accepted_is_named_at_the_end(
    graph: Graph, controller: Start
) -> None:
    node = controller()
    robot = graph.peer()
    robot.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
    robot.act("reach", ACTION, accept=None)
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect("asked", name="reach")
    node.signal(signal.SIGQUIT)
    assert node.wait() == 0
    assert re.search(r"the goal \w{32} of /reach may go on", node.output)


SIGNALLED = """
import os, signal, sys
class Signalling:
    def find_spec(name, path=None, target=None):
        if name == "rclpy":
            os.kill(os.getpid(), signal.{how})
sys.meta_path.insert(0, Signalling)
from guarded_arm.start import main
main()
"""


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_it_may_end_while_modules_are_imported(graph: Graph, built: Any, how: str) -> None:
    """On a busy machine that takes seconds."""
    environment = built.environment("guarded_arm")
    node = graph.start(graph.bed.python, "-c", SIGNALLED.format(how=how), **environment)
    assert node.wait() == 0
    assert node.output == ""


def test_the_stop_command_may_be_a_service(graph: Graph, controller: Start) -> None:
    node = controller(stop_command="lock", rate=0.01)
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.serve("door/lock", "std_srvs/srv/SetBool", {"success": False})
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect("request", name="door/lock")
    robot.expect_state("guarded_arm", lambda s: s["counters"]["inputs"] == 2)
    node.signal(signal.SIGINT)
    assert robot.expect("request", name="door/lock")["data"] == {"data": True}
    assert node.wait() == 0


def test_shutdown_while_everything_is_absent(graph: Graph, controller: Start) -> None:
    node = controller(stop_command="lock")
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect_state("guarded_arm", lambda s: s["components"]["Door"] == "locking")
    node.signal(signal.SIGINT)
    assert node.wait() == 0
    assert "Traceback" not in node.output


def test_safe_stop_stops_commands_and_stays_to_tell(
    graph: Graph, controller: Start, tmp_path: Path
) -> None:
    log = tmp_path / "log" / "events.jsonl"
    node = controller(on_mismatch="stop", stop_command="warn", event_log=str(log))
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
    robot.act("reach", ACTION)
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    goal = robot.expect("goal", name="reach")
    robot.publish("charge", "std_msgs/msg/Int16", {"data": 101})
    robot.expect("cancel", name="reach")
    robot.expect("message", name="beacon")
    # The state stays true: the goal still ends, and nothing is sent any more.
    robot.order("tell_server", id=goal["id"], end="abort")
    state = robot.expect_state(
        "guarded_arm", lambda s: s["stopped"] and s["components"]["Arm"] == "resting"
    )
    assert "mismatch" in state["stopped"]
    later = robot.expect_state("guarded_arm", lambda s: s["time"] > state["time"] + 0.5)
    assert later["counters"]["commands"] == state["counters"]["commands"]
    # All of that can be followed in the model afterwards.
    node.signal(signal.SIGINT)
    assert node.wait() == 0
    text = (HERE / "models" / "guarded_arm.rscd").read_text(encoding="utf-8")
    found = replay(supervisor_of(text), str(log))
    assert (found.departures, found.missing) == ((), ())
    assert (found.events, found.mismatches) == (later["number"], 1)
    assert "stop command" in [entry.document["detail"] for entry in read_log(str(log))]


def test_the_node_ends_after_a_safe_stop_if_told_to(graph: Graph, controller: Start) -> None:
    node = controller(on_mismatch="stop", exit_on_stop=True)
    robot = graph.peer()
    robot.publish("charge", "std_msgs/msg/Int16", {"data": -1})
    assert node.wait() == 1
    assert "safe stop: mismatch" in node.output


def test_a_mismatch_is_counted_and_ignored_by_default(graph: Graph, controller: Start) -> None:
    controller()
    robot = graph.peer()
    robot.watch("guarded_arm")
    robot.publish("charge", "std_msgs/msg/Int16", [{"data": 101}, {"data": 100}])
    state = robot.expect_state("guarded_arm", lambda s: s["counters"]["inputs"] == 1)
    assert (state["counters"]["mismatches"], state["stopped"]) == (1, None)


@pytest.mark.parametrize("role", ["", "_supervisor", "_managed_controller", "_managed_supervisor"])
def test_the_end_in_the_midst_of_traffic_leaves_no_traceback(
    graph: Graph, controller: Start, role: str
) -> None:
    robot = graph.peer()
    traffic = (
        ("zone", "std_msgs/msg/Bool", {"data": False}),
        ("person", "robosc_testing/msg/Reading", {"valid": True, "distance": 5.0}),
        ("charge", "std_msgs/msg/Int16", {"data": 50}),
    )
    for name, kind, data in traffic:
        robot.order("repeat", name=name, type=kind, data=data, qos={}, period=0.002)
    for round_ in range(4):
        node = controller(f"guarded_arm{role}", state_rate=100.0)
        since = time.time()
        if "managed" in role:
            request = {"transition": {"id": 1}}  # to configure it
            name, type_ = f"guarded_arm{role}/change_state", "lifecycle_msgs/srv/ChangeState"
            assert robot.order("call", name=name, type=type_, data=request)["success"]
        if not round_:
            robot.watch(f"guarded_arm{role}")
        robot.expect_state(
            f"guarded_arm{role}",
            lambda s, since=since: s["time"] > since and s["counters"]["inputs"] >= 10,
        )
        node.signal(signal.SIGTERM)
        assert node.wait() == 0
        assert "Traceback" not in node.output, node.output
        assert "InvalidHandle" not in node.output, node.output
