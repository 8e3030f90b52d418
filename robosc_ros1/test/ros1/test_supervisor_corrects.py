"""The limiter of the gallery on a real roscore: the test plays a robot and a reckless driver."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from ros1.stage import Node, Puppet, Stage
from ros_support import EXAMPLES, Workspace, run_robosc

NODE = "limiter_supervisor"
SCAN = "sensor_msgs/LaserScan"
TWIST = "geometry_msgs/Twist"


@pytest.fixture(scope="module")
def limiter_workspace(make_workspace: Callable[[], Workspace]) -> Workspace:
    workspace = make_workspace()
    model = str(EXAMPLES / "gallery" / "limiter" / "limiter.rscd")
    where = ("--output", str(workspace.folder / "src"))
    done = run_robosc(
        ("generate", model, "--mode", "supervisor", *where), workspace.folder, {}, tested=False
    )
    assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.fixture
def limiter(limiter_workspace: Workspace, shared_master: Any) -> Stage:
    return Stage(limiter_workspace, shared_master)


@pytest.fixture
def robot(limiter: Stage) -> Iterator[Puppet]:
    with limiter.puppet() as running:
        running.do("listen", topic="/cmd_vel", type=TWIST)
        yield running


@pytest.fixture
def driver(limiter: Stage) -> Iterator[Puppet]:
    with limiter.puppet() as running:
        running.do("listen", topic=f"/{NODE}/blocked", type="std_msgs/String")
        yield running


@pytest.fixture
def node(limiter: Stage, driver: Puppet) -> Iterator[Node]:
    # One scan holds until the next: what is judged here is the data.
    with limiter.controller(driver, NODE, timeout__scan=600.0) as running:
        yield running


def see(node: Node, robot: Puppet, ahead: float, beside: float = 3.0) -> None:
    """Let the robot see so far, and wait until the node has taken it."""
    ranges = [*[ahead] * 61, *[beside] * 238, *[ahead] * 61]
    fields = {"ranges": ranges, "range_min": 0.1, "range_max": 10.0}
    mark = node.ear.mark
    # More than once: a publisher does not wait for its subscribers.
    robot.begin("publish", topic="/scan", type=SCAN, fields=fields, times=20, rate=20.0)
    node.shows(lambda s: near(s["variables"]["Laser.ahead"], ahead), since=mark)


def near(found: float | None, expected: float) -> bool:
    return found is not None and abs(found - expected) < 1e-5


def drive(driver: Puppet, speed: float, turn: float) -> None:
    fields = {"linear": {"x": speed}, "angular": {"z": turn}}
    driver.do("publish", topic="/supervised/cmd_vel", type=TWIST, fields=fields)


@pytest.mark.parametrize(
    ("seen", "asked", "sent"),
    [
        ((3.0, 3.0), (0.3, 0.2), (0.3, 0.2)),  # nothing to correct
        ((3.0, 3.0), (1.0, 0.6), (0.5, 0.3)),  # limited, on the same curve
        ((0.4, 3.0), (0.5, 0.4), (0.25, 0.2)),  # approaching
        ((3.0, 0.2), (0.4, -0.4), (0.2, -0.2)),  # slow beside a wall
        ((0.2, 3.0), (0.5, 0.4), (0.0, 0.4)),  # only turning
        ((0.2, 3.0), (0.0, 0.7), (0.0, 0.7)),
    ],
)
def test_what_is_sent_keeps_the_curve_and_the_distance(
    node: Node,
    robot: Puppet,
    driver: Puppet,
    seen: tuple[float, float],
    asked: tuple[float, float],
    sent: tuple[float, float],
) -> None:
    see(node, robot, *seen)
    drive(driver, *asked)
    twist = robot.hears("/cmd_vel")
    assert (twist["linear"]["x"], twist["angular"]["z"]) == pytest.approx(sent, abs=1e-5)
    told = node.tells(lambda e: e["event"]["name"] == "move")
    corrected = asked != sent
    assert ("corrected" in told) is corrected
    if corrected:
        assert told["event"]["value"]["linear.x"] == pytest.approx(sent[0], abs=1e-5)


def test_what_no_correction_may_let_pass_is_blocked(
    node: Node, robot: Puppet, driver: Puppet
) -> None:
    see(node, robot, 3.0)
    drive(driver, 0.3, 0.0)
    robot.hears("/cmd_vel", lambda m: m["linear"]["x"] == 0.3)
    see(node, robot, 0.0, 0.0)
    # Nothing may go on with the speed that was allowed before.
    robot.hears("/cmd_vel", lambda m: m["linear"]["x"] == 0.0)
    drive(driver, 0.3, 0.1)
    document = json.loads(driver.hears(f"/{NODE}/blocked")["data"])
    assert document["event"]["name"] == "move"
    assert [reason["text"] for reason in document["blocked_by"]] == [
        "requirement move needs scan.fresh and !Laser.blind"
    ]
    # What was corrected is told beside what was asked for: at a distance of 0 it would not move.
    assert document["corrected"]


def test_the_controllers_data_may_be_no_numbers(node: Node, robot: Puppet, driver: Puppet) -> None:
    see(node, robot, 3.0)
    for speed, turn in ((float("nan"), 0.0), (float("inf"), 0.0), (0.2, float("nan"))):
        mark = driver.mark
        drive(driver, speed, turn)
        document = json.loads(driver.hears(f"/{NODE}/blocked", since=mark)["data"])
        assert document["event"]["name"] == "move"
    drive(driver, 0.25, 0.0)
    robot.hears("/cmd_vel", lambda m: m["linear"]["x"] == 0.25)
    assert len(robot.all_heard("/cmd_vel")) == 1
