"""The operator's hand in a real browser, on real controllers and a supervisor of rclpy."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from ros2.viewing import address, viewing
from ros_support import await_condition
from view.browser import Browser
from view.operators_hand import TOLD, click, send
from view.watching import is_in, link_says

Start = Callable[..., Process]
FOLLOWER, ARM = "line_follower_controller", "guarded_arm"
FLOAT, READING = "std_msgs/msg/Float32", "robosc_testing/msg/Reading"


@pytest.fixture
def robot(graph: Graph) -> Peer:
    return graph.peer("robot")


def watch(robot: Peer, node: str) -> None:
    robot.watch(node)
    robot.subscribe(f"{node}/events", "std_msgs/msg/String")


def told(robot: Peer, node: str, kind: str) -> list[Any]:
    heard = robot.events("message", name=f"{node}/events")
    documents = [json.loads(one["data"]["data"]) for one in heard]
    return [e for e in documents if e["event"]["kind"] == kind]


def orders(robot: Peer, node: str) -> list[tuple[str, str]]:
    return [(e["event"]["value"], e["outcome"]) for e in told(robot, node, "operator")]


def shown(robot: Peer, node: str, inputs: int) -> Any:
    """The state after as many inputs more: long enough for whoever would send something."""
    now = robot.expect_state(node, lambda s: True)["counters"]["inputs"]
    return robot.expect_state(node, lambda s: s["counters"]["inputs"] >= now + inputs)


def test_a_person_holds_steps_and_releases_a_controller_and_sends_to_it(
    graph: Graph, robot: Peer, controller: Start, browser: Browser
) -> None:
    view = viewing(graph, FOLLOWER, "--operate", "DistanceSensor")
    # Once the light shows that there is no line, it is no command that may be stepped.
    robot.serve("/set_light_state", "robot_common/srv/LightBulbService", {})
    # Nor is to stop, however late a reading comes.
    controller(
        FOLLOWER, operate=True, timeout__distance=600.0, qos__distance__reliability="reliable"
    )
    watch(robot, FOLLOWER)
    robot.expect_state(FOLLOWER, lambda s: s["components"]["LightBulb"] == "known")
    robot.subscribe("/vel", "geometry_msgs/msg/Twist")
    robot.expect("message", name=f"{FOLLOWER}/events")  # from now on it hears each of them
    browser.open(address(view))
    browser.sees(link_says("live"))
    assert browser.run("return location.href").endswith("/")  # the token is out of sight
    # The C code of rclpy would end the viewer for a text that it takes for a number.
    for unfit in ("nonsense", '"text"', "true", "[1]", '{"current": 1}', "1e300"):
        send(browser, "distance", unfit)
        browser.sees(f"{TOLD} !== ''")
        browser.run("document.getElementById('told').textContent = ''")
    browser.complaints()  # of what was refused
    send(browser, "distance", "1")

    def readings() -> list[Any]:  # the light's answer is a response, too
        return [e for e in told(robot, FOLLOWER, "response") if e["event"]["name"] == "distance"]

    await_condition(readings, "what the person sent")
    assert readings()[0]["event"]["value"] == "free"
    browser.sees(f"{TOLD} === ''")

    click(browser, "hold-all")
    robot.expect_state(FOLLOWER, lambda s: s["stopped"] == "held by the operator")
    browser.sees("document.getElementById('alert').textContent.includes('held by the operator')")
    robot.order("repeat", name="/distance", type=FLOAT, data={"data": 1.0}, qos={})
    before = shown(robot, FOLLOWER, 20)["counters"]["commands"]
    assert shown(robot, FOLLOWER, 10)["counters"]["commands"] == before

    # One command at a time, and only what is allowed: with nothing near, that is to move.
    click(browser, "step")
    robot.expect_state(FOLLOWER, lambda s: s["counters"]["commands"] == before + 1)
    browser.sees(is_in("Motor", "moving"))
    click(browser, "release")
    robot.expect_state(FOLLOWER, lambda s: s["counters"]["commands"] > before + 5)
    done = [("hold", "operated"), ("step", "operated"), ("release", "operated")]
    assert orders(robot, FOLLOWER) == done
    for what in ("distance 1", "hold", "step", "release"):
        await_condition(lambda what=what: f"operator: {what}\n" in view.output, what)


def test_a_node_that_was_not_started_for_it_takes_no_orders(
    graph: Graph, robot: Peer, controller: Start, browser: Browser
) -> None:
    view = viewing(graph, ARM, "--operate")
    controller(ARM)
    robot.watch(ARM)
    browser.open(address(view))
    browser.sees(link_says("live"))
    click(browser, "hold-all")
    browser.sees(f"{TOLD}.includes('operate:=true')")
    browser.complaints()  # of what was refused
    assert robot.expect_state(ARM, lambda s: True)["stopped"] is None


def test_messages_with_parts_and_every_quality_of_service(
    graph: Graph, robot: Peer, controller: Start, browser: Browser
) -> None:
    """The node asks for a deadline, so it hears only who promises one."""
    view = viewing(graph, ARM, "--operate", "Person", "Operator")
    controller(
        ARM, operate=True, qos__zone__deadline=600.0, qos__zone__durability="transient_local"
    )
    watch(robot, ARM)
    browser.open(address(view))
    browser.sees(link_says("live"))
    send(browser, "zone", '{"valid": true, "distance": 9, "vector": [0, 1, 5]}')
    robot.expect_state(ARM, lambda s: s["variables"]["Person.where"] == "near")
    assert browser.run(f"return {TOLD}") == ""
    send(browser, "zone", '{"vector": [0, 1]}')
    browser.sees(f"{TOLD}.includes('this does not fit {READING}')")
    browser.complaints()  # of what was refused
    send(browser, "go", "true")
    robot.expect_state(ARM, lambda s: s["variables"]["Operator.wanted"])


def test_the_operator_holds_a_supervisor_and_lets_one_command_of_its_controller_through(
    graph: Graph, robot: Peer, controller: Start, browser: Browser
) -> None:
    node = "guarded_arm_supervisor"
    view = viewing(graph, node, "--operate")
    controller(node, operate=True)
    watch(robot, node)
    robot.subscribe("speed", FLOAT)
    other = graph.peer("other")
    speeds = {"name": "supervised/speed", "type": FLOAT, "data": {"data": 1.5}, "qos": {}}
    other.order("repeat", **speeds)
    robot.expect("message", name="speed")
    robot.expect("message", name=f"{node}/events")  # from now on it hears each of them
    browser.open(address(view))
    click(browser, "hold-all")
    robot.expect_state(node, lambda s: s["stopped"] == "held by the operator")
    blocked = robot.expect_state(node, lambda s: True)["counters"]["blocked"]
    robot.expect_state(node, lambda s: s["counters"]["blocked"] >= blocked + 10)
    before = len(robot.events("message", name="speed"))
    robot.expect_state(node, lambda s: s["counters"]["blocked"] >= blocked + 20)
    assert len(robot.events("message", name="speed")) == before

    click(browser, "step")
    robot.expect_state(node, lambda s: ("step", "operated") in orders(robot, node))
    blocked = robot.expect_state(node, lambda s: True)["counters"]["blocked"]
    robot.expect_state(node, lambda s: s["counters"]["blocked"] >= blocked + 10)
    assert len(robot.events("message", name="speed")) == before + 1
    click(browser, "release")
    await_condition(lambda: len(robot.events("message", name="speed")) > before + 10, "speeds")
