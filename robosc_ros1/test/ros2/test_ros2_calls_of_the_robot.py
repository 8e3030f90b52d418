"""Services of a generated controller on real rclpy: each call is answered once, or refused."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros2.test_ros2_lifecycle import ACTIVATE, CONFIGURE, DEACTIVATE, change

Start = Callable[..., Process]
NODE = "orders_controller"
ORDER, SWITCH = "/order", "/switch"
TYPE = "std_srvs/srv/SetBool"
DONE = {"success": True, "message": "done"}


@pytest.fixture
def node(controller: Start) -> Process:
    return controller(NODE, qos__door__reliability="reliable")


@pytest.fixture
def robot(graph: Graph, node: Process) -> Peer:
    peer = graph.peer()
    peer.watch(NODE)
    return peer


def call(peer: Peer, name: str, data: bool) -> dict[str, Any]:
    answer: dict[str, Any] = peer.order("call", name=name, type=TYPE, data={"data": data})
    return answer


def order_and_wait(peer: Peer, robot: Peer) -> None:
    peer.order("start_call", name=ORDER, type=TYPE, data={"data": True})
    robot.expect_state(NODE, lambda s: s["communications"]["order"] == "busy")


def open_door(robot: Peer) -> None:
    robot.publish("/door", "std_msgs/msg/Bool", {"data": True})


@pytest.mark.once
def test_a_call_is_answered_when_its_requirement_holds(robot: Peer) -> None:
    order_and_wait(robot, robot)
    open_door(robot)
    assert robot.expect("response", name=ORDER)["data"] == DONE
    assert call(robot, ORDER, True) == DONE


def test_one_call_at_a_time(graph: Graph, robot: Peer) -> None:
    order_and_wait(robot, robot)
    refused = call(graph.peer(), ORDER, True)
    assert refused == {"success": False, "message": "order is busy: it serves one call at a time"}
    open_door(robot)
    assert robot.expect("response", name=ORDER)["data"] == DONE
    robot.expect_state(NODE, lambda s: s["counters"]["refused"] == 1)


def test_a_refused_call_gets_the_reason(robot: Peer) -> None:
    assert "Switch is in ready" in call(robot, SWITCH, False)["message"]
    assert call(robot, SWITCH, True) == {"success": True, "message": ""}
    assert "switch is taken where" in call(robot, SWITCH, True)["message"]
    assert "Orders is in unwanted" in call(robot, ORDER, False)["message"]


def test_a_caller_that_is_killed_leaves_the_service_to_others(graph: Graph, robot: Peer) -> None:
    caller = graph.peer()
    order_and_wait(caller, robot)
    caller.process.popen.kill()
    caller.process.popen.wait()
    open_door(robot)
    robot.expect_state(NODE, lambda s: s["communications"]["order"] == "idle")
    assert call(robot, ORDER, True) == DONE


def test_a_waiting_call_does_not_hold_up_the_node(robot: Peer) -> None:
    order_and_wait(robot, robot)
    assert call(robot, SWITCH, True)["success"] is True
    robot.expect_state(NODE, lambda s: s["components"]["Orders"] == "asked")
    open_door(robot)
    assert robot.expect("response", name=ORDER)["data"] == DONE


def test_a_managed_node_serves_only_while_it_is_active(graph: Graph, controller: Start) -> None:
    managed = "orders_managed_controller"
    controller(managed, qos__door__reliability="reliable")
    robot = graph.peer()
    assert change(robot, managed, CONFIGURE)
    robot.watch(managed)
    assert "not active" in call(robot, SWITCH, True)["message"]
    assert change(robot, managed, ACTIVATE)
    assert call(robot, SWITCH, True)["success"] is True
    robot.order("start_call", name=ORDER, type=TYPE, data={"data": True})
    robot.expect_state(managed, lambda s: s["communications"]["order"] == "busy")
    assert change(robot, managed, DEACTIVATE)
    assert "not active" in robot.expect("response", name=ORDER)["data"]["message"]
    assert change(robot, managed, ACTIVATE)
    open_door(robot)  # so that the call that nobody waits for ends
    robot.expect_state(managed, lambda s: s["communications"]["order"] == "idle")
    assert call(robot, ORDER, True) == DONE


@pytest.mark.once
def test_the_end_of_the_node_answers_what_waits(robot: Peer, node: Process) -> None:
    order_and_wait(robot, robot)
    node.signal(signal.SIGINT)
    answer = robot.expect("response", name=ORDER)["data"]
    assert not answer["success"] and "the node ends" in answer["message"]
    assert node.wait() == 0
