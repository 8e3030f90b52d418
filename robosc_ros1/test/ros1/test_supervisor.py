"""A generated supervisor between a robot and a controller, on a real roscore.

The test plays both: the robot under its own names, the controller under those that begin with
``/supervised``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from ros1.stage import Node, Puppet, Stage, event
from ros_support import EXAMPLES, Workspace, await_condition
from runtime.schemas import validate

from robosc.simulate.replay import replay

NODE = "line_follower_supervisor"
TWIST = "geometry_msgs/Twist"
FLOAT = "std_msgs/Float32"
LIGHT = {"type": "robot_common/LightBulbService"}
GRAB = {"type": "robot_common/GrabberAction"}
STOP = {"linear": {"x": 0.0}, "angular": {"z": 0.0}}


def speed(x: float) -> dict[str, Any]:
    return {"linear": {"x": x}, "angular": {"z": 0.1}}


@pytest.fixture
def robot(guarded: Stage) -> Iterator[Puppet]:
    with guarded.puppet() as running:
        running.do("listen", topic="/vel", type=TWIST)
        running.do("service", name="/set_light_state", **LIGHT)
        running.do("action", name="/grab", **GRAB, mode="hold")
        yield running


@pytest.fixture
def other(guarded: Stage) -> Iterator[Puppet]:
    with guarded.puppet() as running:
        running.do("listen", topic=f"/{NODE}/blocked", type="std_msgs/String")
        running.do("listen", topic="/supervised/distance", type=FLOAT)
        yield running


def blocked(other: Puppet, since: int = 0) -> tuple[str, list[str]]:
    """Which command is reported as blocked, and why."""
    document = json.loads(other.hears(f"/{NODE}/blocked", since=since)["data"])
    validate(document, "blocked")
    return document["event"]["name"], [reason["text"] for reason in document["blocked_by"]]


def vel(other: Puppet, fields: dict[str, Any]) -> None:
    other.do("publish", topic="/supervised/vel", type=TWIST, fields=fields)


@pytest.mark.once
def test_messages_pass_with_their_own_data_or_are_blocked(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    with guarded.controller(other, NODE, timeout__distance=600.0) as node:
        vel(other, speed(0.3))
        name, reasons = blocked(other)
        assert name == "move"
        assert "requirement move needs DistanceSensor.current = free" in reasons
        # More than once: a publisher does not wait for its subscribers.
        robot.publish("/distance", FLOAT, 2.0, times=20, rate=20.0)
        other.hears("/supervised/distance", lambda m: m["data"] == 2.0)
        node.shows(lambda s: s["variables"]["DistanceSensor.current"] == "free")
        vel(other, speed(0.3))
        passed = robot.hears("/vel")
        assert (passed["linear"]["x"], passed["angular"]["z"]) == (0.3, 0.1)
        mark = other.mark
        vel(other, speed(float("nan")))
        assert blocked(other, mark) == ("move", ["linear.x is nan"])
        # Nothing forbids to drive now, so there is no need to stop.
        mark = other.mark
        vel(other, STOP)
        assert blocked(other, mark)[0] == "stop"
        assert len(robot.all_heard("/vel")) == 1


@pytest.mark.once
def test_a_message_in_effect_is_stopped_when_it_becomes_forbidden(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    parameters = {"stop_command": "stop", "timeout__distance": 600.0}
    with guarded.controller(other, NODE, **parameters) as node:
        robot.publish("/distance", FLOAT, 2.0)
        node.shows(lambda s: s["variables"]["DistanceSensor.current"] == "free")
        vel(other, speed(0.3))
        robot.hears("/vel", lambda m: m["linear"]["x"] == 0.3)
        robot.publish("/distance", FLOAT, 0.1)
        robot.hears("/vel", lambda m: m["linear"]["x"] == 0.0)


def test_silence_stops_a_message_in_effect_and_blocks_the_next_one(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    with guarded.controller(other, NODE, stop_command="stop", timeout__distance=2.0) as node:
        with guarded.puppet() as sensor:
            fields = {"data": 2.0}
            sensor.begin(
                "publish", topic="/distance", type=FLOAT, fields=fields, times=10_000, rate=20.0
            )
            node.shows(lambda s: s["variables"]["DistanceSensor.current"] == "free")
            vel(other, speed(0.3))
            robot.hears("/vel", lambda m: m["linear"]["x"] == 0.3)
            sensor.process.kill()
            node.tells(event("timeout", "distance"))
        robot.hears("/vel", lambda m: m["linear"]["x"] == 0.0)
        mark = other.mark
        vel(other, speed(0.3))
        assert blocked(other, mark) == ("move", ["requirement move needs distance.fresh"])


def test_a_goal_is_cancelled_when_it_becomes_forbidden(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    with guarded.controller(other, NODE, stop_command="stop") as node:
        ready_to_grab(node, robot, other)
        other.do("send", name="/supervised/grab", **GRAB, fields={})
        grabs(node, robot)
        robot.publish("/distance", FLOAT, 2.0)
        robot.wait(lambda line: line.get("cancelled"), "the cancel")
        assert other.wait(lambda line: line.get("ended"), "the end")["status"] == 2
        node.tells(event("cancel", "grab"))


def test_calls_pass_or_fail_with_the_reason(guarded: Stage, robot: Puppet, other: Puppet) -> None:
    with guarded.controller(other, NODE) as node:
        light = {"name": "/supervised/set_light_state", **LIGHT}
        other.do("call", **light, fields={"state": True})
        asked = robot.wait(lambda line: line.get("asked") == "/set_light_state", "the call")
        assert asked["message"] == {"state": True}
        other.wait(lambda line: line.get("answered") and "message" in line, "the response")
        node.enters("LightBulb", "known")
        other.do("call", **light, fields={"state": True})
        failed = other.wait(lambda line: line.get("failure"), "the failure")["failure"]
        assert "blocked: requirement set_light_state needs" in failed


def test_a_goal_without_an_id_gets_one(guarded: Stage, robot: Puppet, other: Puppet) -> None:
    robot.do("listen", topic="/grab/cancel", type="actionlib_msgs/GoalID")
    with guarded.controller(other, NODE, goal_timeout__grab=1.0) as node:
        ready_to_grab(node, robot, other)
        goal = {"topic": "/supervised/grab/goal", "type": "robot_common/GrabberActionGoal"}
        other.do("publish", **goal, fields={})
        asked = robot.wait(lambda line: line.get("asked") == "/grab", "the goal")
        assert asked["id"].startswith(f"/{NODE}-")
        node.tells(event("request", "grab"))
        # Without an id, the cancel at the deadline would be one of all goals.
        assert robot.hears("/grab/cancel")["id"] == asked["id"]
        node.tells(event("error", "grab"))


def test_goals_pass_with_their_ids_and_what_comes_of_them(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    with guarded.controller(other, NODE) as node:
        ready_to_grab(node, robot, other)
        other.do("send", name="/supervised/grab", **GRAB, fields={})
        asked = robot.wait(lambda line: line.get("asked") == "/grab", "the goal")
        assert asked["id"] == other.wait(lambda line: line.get("sent"), "the id")["id"]
        grabs(node, robot)
        robot.do("finish", name="/grab", mode="succeed")
        assert other.wait(lambda line: line.get("ended"), "the result")["status"] == 3
        node.enters("ObstacleGrabber", "looking")


def ready_to_grab(node: Node, robot: Puppet, other: Puppet) -> None:
    robot.publish("/distance", FLOAT, 0.1)
    node.enters("DistanceSensor", "sensing")
    vel(other, STOP)
    robot.hears("/vel")


def grabs(node: Node, robot: Puppet) -> None:
    """Wait until it is grabbing, and the robot knows: a cancel might overtake the goal."""
    node.enters("ObstacleGrabber", "grabbing")
    robot.wait(lambda line: line.get("asked") == "/grab", "the goal")


@pytest.mark.once
def test_a_goal_that_is_blocked_is_rejected(guarded: Stage, robot: Puppet, other: Puppet) -> None:
    with guarded.controller(other, NODE):
        other.do("send", name="/supervised/grab", **GRAB, fields={})
        ended = other.wait(lambda line: line.get("ended"), "the end")
        assert ended["status"] == 5
        assert ended["text"].startswith("blocked: requirement grab needs")
        assert not [line for line in robot.lines if line.get("asked") == "/grab"]


@pytest.mark.parametrize("end", ["abort", "preempt"])
def test_other_ends_of_a_goal_reach_the_controller(
    guarded: Stage, robot: Puppet, other: Puppet, end: str
) -> None:
    with guarded.controller(other, NODE) as node:
        ready_to_grab(node, robot, other)
        other.do("send", name="/supervised/grab", **GRAB, fields={})
        robot.wait(lambda line: line.get("asked") == "/grab", "the goal")
        robot.do("finish", name="/grab", mode=end)
        ended = other.wait(lambda line: line.get("ended"), "the result")
        assert ended["status"] == {"abort": 4, "preempt": 2}[end]
        node.shows(lambda s: s["counters"]["errors"] == 1)


@pytest.mark.once
def test_a_cancel_of_the_controller_reaches_the_robot(
    guarded: Stage, robot: Puppet, other: Puppet
) -> None:
    with guarded.controller(other, NODE) as node:
        ready_to_grab(node, robot, other)
        other.do("send", name="/supervised/grab", **GRAB, fields={})
        grabs(node, robot)
        other.do("cancel")
        robot.wait(lambda line: line.get("cancelled"), "the cancel")
        assert other.wait(lambda line: line.get("ended"), "the end")["status"] == 2
        node.enters("ObstacleGrabber", "looking")


LONG_AGO, LATER = {"secs": 1, "nsecs": 0}, {"secs": 4000000000, "nsecs": 0}


@pytest.mark.parametrize(
    ("fields", "meant"),
    [
        ({"id": ""}, True),
        ({"id": "", "stamp": LATER}, True),
        ({"id": "another", "stamp": LATER}, True),
        ({"id": "", "stamp": LONG_AGO}, False),
        ({"id": "another"}, False),
        ({"id": "another", "stamp": LONG_AGO}, False),
    ],
)
def test_a_cancel_counts_if_the_server_cancels_the_goal(
    guarded: Stage, robot: Puppet, other: Puppet, fields: dict[str, Any], meant: bool
) -> None:
    with guarded.controller(other, NODE, stop_command="stop") as node:
        ready_to_grab(node, robot, other)
        other.do("send", name="/supervised/grab", **GRAB, fields={})
        grabs(node, robot)
        cancel = {"topic": "/supervised/grab/cancel", "type": "actionlib_msgs/GoalID"}
        other.do("publish", **cancel, fields=fields)
        if not meant:
            # The goal is still the supervisor's to cancel.
            robot.publish("/distance", FLOAT, 2.0)
            node.tells(event("cancel", "grab"))
        robot.wait(lambda line: line.get("cancelled"), "the cancel")
        assert other.wait(lambda line: line.get("ended"), "the end")["status"] == 2


def test_goals_that_are_sent_upon_the_result_before_pass(guarded: Stage, other: Puppet) -> None:
    """The supervisor's own state follows a result before the controller hears of it."""
    action = {"type": "robot_common/NavigateAction"}
    with guarded.puppet() as robot:
        robot.do("action", name="/lift", **action)
        with guarded.controller(other, "lifter_supervisor"):
            other.do("chain", name="/supervised/lift", **action, count=400)
            ends = other.wait(lambda line: line.get("chained"), "400 goals", seconds=120.0)["ends"]
    assert [end for end in ends if end[0] != 3] == []


@pytest.mark.once
def test_the_launch_file_starts_both_with_the_right_names(
    guarded: Stage, robot: Puppet, other: Puppet, tmp_path: Path
) -> None:
    log = str(tmp_path / "events.jsonl")
    other.do("listen", topic=f"/{NODE}/state", type="std_msgs/String")
    package = "line_follower_controller"
    with guarded.workspace.start(
        "roslaunch", NODE, f"{NODE}.launch", "stop_command:=stop",
        f"controller_package:={package}", f"controller_executable:={package}",
        f"event_log:={log}", master=guarded.master,
    ):  # fmt: skip
        # The controller switches the light, stops, and grabs what stands there; all of it passes.
        robot.wait(lambda line: line.get("asked") == "/set_light_state", "the call")

        # Nobody knows when all links between the two are there, so the robot says it again.
        def asked() -> bool:
            robot.publish("/distance", FLOAT, 0.1)
            return any(line.get("asked") == "/grab" for line in robot.lines)

        await_condition(asked, "the goal")
        robot.hears("/vel", lambda m: m["linear"]["x"] == 0.0)
        other.hears(f"/{NODE}/state", lambda s: s["components"]["ObstacleGrabber"] == "grabbing")
    model = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"
    found = replay(supervisor_of(model.read_text(encoding="utf-8")), log)
    assert (found.departures, found.missing) == ((), ())
    assert found.events > 3


FAULTS = {
    "forbidden": (
        "_runtime/judge/judge.py",
        "        if command.possible and command.authorised(*data):\n",
        # What the robot cannot do now stays blocked: else the supervisor ends at the first of it.
        # A cancel stays blocked, too: else the first thing to complain of may be that no requirement
        # wants it.
        "        fits = not command.synchronisation or command.synchronisation(*data)\n"
        "        if kind == 'request' and command.possible and fits:\n"
        "            return []\n"
        "        if command.possible and command.authorised(*data):\n",
        "expected to be sent: nothing; sent: ",
    ),
    "allowed": (
        "controller.py",
        ' and self.motor == "stopped"\n',
        " and False\n",
        "sent: nothing",
    ),
    "data": (
        "relay.py",
        "            engine.role.offer(controller, patterns, read(raw, type_), passed_on(raw), packed)",
        "            message = read(raw, type_)\n"
        "            raw.bytes = b'?' * len(raw.bytes)\n"
        "            engine.role.offer(controller, patterns, message, passed_on(raw), packed)",
        "the controller sent: ",
    ),
}


@pytest.mark.parametrize("fault", [None, *FAULTS])
def test_the_package_s_own_test_finds_faults(
    guarded_workspace: Workspace, fault: str | None
) -> None:
    """It passes; and it finds what passes or is blocked wrongly, and what passes otherwise."""
    package = guarded_workspace.folder / "src" / NODE / "src" / NODE
    file, before, after, complaint = FAULTS[fault] if fault else ("relay.py", "", "", "SUCCESS")
    source = (package / file).read_text(encoding="utf-8")
    assert before in source
    (package / file).write_text(source.replace(before, after, 1), encoding="utf-8")
    try:
        done = guarded_workspace.own_test(NODE)
    finally:
        (package / file).write_text(source, encoding="utf-8")
    assert complaint in done.stdout, done.stdout[-4000:]
