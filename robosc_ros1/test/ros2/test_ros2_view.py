"""The live picture of a generated controller on real rclpy, in a browser."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable

import pytest
from ros2.ros2_support import Graph, Process
from ros2.viewing import address, viewing
from ros_support import SOURCES, await_condition
from view.browser import Browser
from view.watching import Watcher, command_is, is_in, link_says

Start = Callable[..., Process]
NODE = "line_follower_controller"
DISTANCE = ("/distance", "std_msgs/msg/Float32")


@pytest.fixture
def viewer(graph: Graph) -> Process:
    return viewing(graph, NODE)


@pytest.fixture
def url(viewer: Process) -> str:
    return address(viewer)


def test_the_page_shows_what_a_controller_of_ros_2_tells(
    graph: Graph, controller: Start, url: str, browser: Browser
) -> None:
    browser.open(url)
    browser.sees(link_says(f"waiting for /{NODE}"))
    node = controller(NODE)
    browser.sees(link_says("live"))
    browser.sees("document.getElementById('robot').textContent === 'LineFollower'")
    robot, other = graph.peer(), graph.peer("other")
    other.subscribe("/vel", "geometry_msgs/msg/Twist")
    # What came before the sensor's subscription was matched is lost, as from any sensor.
    robot.order("repeat", name=DISTANCE[0], type=DISTANCE[1], data={"data": 1.0}, qos={})
    browser.sees(is_in("DistanceSensor", "sensing"))
    browser.sees(is_in("Motor", "moving"))
    browser.sees(command_is("move.request", "enabled"))
    sent = "document.querySelector('[data-command=\"move.request\"] .sent').textContent"
    browser.sees(f"{sent}.startsWith('sent {{linear: {{x: ')")
    robot.process.end()
    other.order("repeat", name=DISTANCE[0], type=DISTANCE[1], data={"data": 0.1}, qos={})
    browser.sees(is_in("Motor", "stopped"))
    browser.sees(command_is("move.request", "forbidden"))
    # Until the other sensor is heard, there may be silence, which is a reason, too.
    reason = (
        r"line \d+ DistanceSensor\.current is \w+: requirement move needs DistanceSensor\.current"
    )
    await_condition(
        lambda: re.search(reason, browser.text("[data-command='move.request'] .below:last-child")),
        "the reason",
    )
    browser.sees("page.events.some((e) => e.event.name === 'stop')")

    node.end()
    browser.sees("document.body.classList.contains('stale')")
    # Another robot's controller takes its name.
    controller("guarded_arm", remap=[f"__node:={NODE}"])
    browser.sees(link_says("live"))
    browser.sees("document.getElementById('robot').textContent === 'GuardedArm'")
    browser.sees(is_in("Arm", "resting"))
    assert browser.run("return document.querySelectorAll('[data-component=Motor]').length") == 0


def test_who_mistypes_a_name_is_told_which_there_are(
    controller: Start, viewer: Process, url: str
) -> None:
    controller("guarded_arm")
    watcher = Watcher(int(url.rstrip("/").rpartition(":")[2]))
    told = f"waiting for /{NODE}; also running: /guarded_arm"
    watcher.until(lambda w: w.seen.get("status", {}).get("text") == told)
    watcher.close()


def test_a_viewer_of_ros_2_takes_part_in_nothing_and_leaves_in_order(
    graph: Graph, viewer: Process, url: str
) -> None:
    robot = graph.peer()

    def ends() -> dict[str, list[str]] | None:
        found: dict[str, list[str]] = robot.order("ends_of", prefix="robosc_view_")
        return found if len(found["hears"]) >= 3 else None

    found = await_condition(ends, "the viewer's subscriptions")
    assert sorted(found["hears"]) == [f"/{NODE}/{topic}" for topic in ("events", "model", "state")]
    # Every node of rclpy has the second, and says there nothing but which parameters it has.
    assert sorted(found["publishes"]) == ["/diagnostics", "/parameter_events"]
    robot.subscribe("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    (status,) = robot.expect("message", name="/diagnostics")["data"]["status"]
    assert (status["name"], status["message"]) == (f"{NODE}: page", url)
    assert found["serves"] == []
    viewer.signal(signal.SIGINT)
    assert viewer.wait() == 130
    assert "Traceback" not in viewer.output


def test_messages_of_ros_1_that_python_finds_first_are_told(graph: Graph) -> None:
    path = os.pathsep.join((str(SOURCES), "/usr/lib/python3/dist-packages"))
    command = (graph.bed.python, "-m", "robosc", "view", "--ros", NODE, "--port", "0")
    viewer = graph.start(*command, PYTHONPATH=path)
    assert viewer.wait() == 2
    assert "std_msgs is that of ROS 1 here (/usr/lib/python3" in viewer.output.replace("\n", " ")
    assert "Traceback" not in viewer.output
