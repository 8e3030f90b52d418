"""An agent that commands a robot through a generated supervisor, on a real roscore.

The test plays the robot, and listens to what reaches it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from agents.agent_support import Agent, StartAgent
from agents.tried import (
    LIBRARIES,
    LIMITER,
    LINE_FOLLOWER,
    TRIALS,
    Arrived,
    Trial,
    rounds,
    try_everything,
)
from ros1.stage import Node, Puppet, Stage
from ros_support import EXAMPLES, Master, Workspace, await_condition

MODEL = str(LINE_FOLLOWER)
NODE = "line_follower_supervisor"
FLOAT = "std_msgs/Float32"


@pytest.fixture
def robot(guarded: Stage) -> Iterator[Puppet]:
    with guarded.puppet() as running:
        running.do("listen", topic="/vel", type="geometry_msgs/Twist")
        running.do("service", name="/set_light_state", type="robot_common/LightBulbService")
        running.do("action", name="/grab", type="robot_common/GrabberAction", mode="hold")
        yield running


@contextmanager
def running(
    stage: Stage, robot: Puppet, start: StartAgent, *more: str
) -> Iterator[tuple[Node, Agent]]:
    environment = stage.workspace.environment(master=stage.master)
    with (
        stage.controller(robot, NODE, timeout__distance=600.0) as node,
        start(MODEL, "--ros", f"/{NODE}", *more, env=environment) as agent,
    ):
        await_condition(lambda: agent.call("state").get("components"), "the state")
        yield node, agent


def sense(robot: Puppet, node: Node, distance: float, state: str) -> None:
    robot.publish("/distance", FLOAT, distance, times=5, rate=20.0)
    node.shows(lambda s: s["variables"]["DistanceSensor.current"] == state)


def test_what_an_agent_commands_reaches_the_robot_only_where_it_is_allowed(
    guarded: Stage, robot: Puppet, start_agent: StartAgent
) -> None:
    with running(guarded, robot, start_agent) as (node, agent):
        told = agent.call("move", linear={"x": 0.3})
        assert (told["error"], told["outcome"]) == (True, "blocked"), told
        assert any("move needs" in reason["text"] for reason in told["blocked_by"])
        sense(robot, node, 2.0, "free")
        await_condition(lambda: "now: enabled" in agent.call("why", command="move")["text"], "it")
        told = agent.call("move", linear={"x": 0.3})
        assert told == {"error": False, "outcome": "sent"}
        assert robot.hears("/vel")["linear"]["x"] == 0.3
        found = agent.call("what_if", calls=[{"command": "stop"}, {"command": "grab"}])
        assert [r["outcome"] for r in found["results"]] == ["blocked", "blocked"]
        assert len(robot.all_heard("/vel")) == 1


def test_a_goal_reports_progress_and_ends_where_its_client_cancels_it(
    guarded: Stage, robot: Puppet, start_agent: StartAgent
) -> None:
    with running(guarded, robot, start_agent) as (node, agent):
        sense(robot, node, 0.1, "obstructed")
        assert agent.call("stop")["outcome"] == "sent"
        agent.begin(call="grab", arguments={}, cancel_after=1)
        node.shows(lambda s: s["communications"]["grab"] == "busy")
        robot.wait(lambda line: line.get("asked") == "/grab", "the goal")
        robot.do("progress", name="/grab", fields={})
        told = agent.hear()
        assert "progress" in told
        assert agent.hear() == {"gave_up": True}
        node.shows(lambda s: s["communications"]["grab"] != "busy")


def test_the_goal_of_a_client_that_is_killed_is_cancelled(
    guarded: Stage, robot: Puppet, start_agent: StartAgent
) -> None:
    with running(guarded, robot, start_agent) as (node, agent):
        sense(robot, node, 0.1, "obstructed")
        assert agent.call("stop")["outcome"] == "sent"
        agent.begin(call="grab", arguments={})
        node.shows(lambda s: s["communications"]["grab"] == "busy")
        agent.process.kill()
        agent.process.wait()
        robot.wait(lambda line: line.get("cancelled") == "/grab", "the cancel")


def test_nothing_is_sent_while_the_operator_holds(
    guarded: Stage, robot: Puppet, start_agent: StartAgent
) -> None:
    environment = guarded.workspace.environment(master=guarded.master)
    with (
        guarded.controller(robot, NODE, timeout__distance=600.0, operate=True) as node,
        start_agent(MODEL, "--ros", f"/{NODE}", env=environment) as agent,
    ):
        sense(robot, node, 2.0, "free")
        robot.publish(f"/{NODE}/operate", "std_msgs/String", "hold")
        node.shows(lambda s: s["stopped"])
        await_condition(lambda: "stopped" in json.dumps(agent.call("state")), "the state")
        told = agent.call("move", linear={"x": 0.3})
        assert told["outcome"] in ("refused", "blocked"), told
        assert all(m["linear"]["x"] == 0.0 for m in robot.all_heard("/vel"))


def test_a_call_to_a_node_that_dies_ends(
    guarded: Stage, robot: Puppet, start_agent: StartAgent
) -> None:
    with running(guarded, robot, start_agent) as (node, agent):
        sense(robot, node, 0.1, "obstructed")
        assert agent.call("stop")["outcome"] == "sent"
        agent.begin(call="grab", arguments={})
        node.shows(lambda s: s["communications"]["grab"] == "busy")
        node.process.kill()
        told = agent.hear()
        assert (told["error"], told["outcome"]) == (True, "unknown")
        assert "silent" in told["why"][0]
        told = agent.call("stop")
        assert (told["outcome"], "silent" in told["why"][0]) == ("refused", True)


@pytest.fixture
def orders(example_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(example_workspace, shared_master)


def test_an_agent_orders_what_a_controller_serves(orders: Stage, start_agent: StartAgent) -> None:
    """It is told why an order is not taken, how far one is, and that it has ended."""
    name = "order_controller"
    environment = orders.workspace.environment(master=orders.master)
    drive = {"name": "/drive", "type": "robot_common/NavigateAction"}
    way = {"x": [1.0], "y": [2.0]}
    model = (str(EXAMPLES / "order" / "order.rscd"), "--mode", "controller")
    with (
        orders.puppet() as base,
        orders.puppet() as ear,
        orders.controller(ear, name, stop__silence=3600.0) as node,
        start_agent(*model, "--ros", f"/{name}", env=environment) as agent,
    ):
        base.do("action", **drive, mode="hold")
        await_condition(lambda: agent.call("state").get("components"), "the state")
        told = agent.call("order", **way)
        assert (told["error"], told["outcome"]) == (True, "refused")
        assert "stop.fresh" in told["why"][0]
        ear.publish("/emergency_stop", "std_msgs/Bool", False)
        node.shows(lambda s: s["communications"]["stop"] == "fresh")
        agent.begin(call="order", arguments=way)
        base.wait(lambda line: line.get("asked") == "/drive", "a drive")
        assert agent.hear()["progress"]["reached"] == 0
        base.do("finish", name="/drive", mode="succeed")
        while "progress" in (told := agent.hear()):
            pass
        assert (told["error"], told["outcome"]) == (False, "answered")
        assert told["answer"] == {"reached": 1, "message": "done"}
        mark = base.mark
        agent.begin(call="order", arguments=way, cancel_after=1)
        while "progress" in (told := agent.hear()):
            pass
        assert told == {"gave_up": True}
        base.wait(lambda line: line.get("cancelled") == "/drive", "the cancel", since=mark)


ROUNDS = 12
"""Of four calls each. ROBOSC_AGENT_ROUNDS=250 makes a thousand of them."""


class LineFollower:
    """The robot of the line follower's example, as :mod:`agents.tried` has it."""

    def __init__(self, node: Node, puppet: Puppet) -> None:
        self._node, self._puppet = node, puppet
        puppet.do("action", name="/grab", type="robot_common/GrabberAction", mode="succeed")

    def sense(self, value: float) -> None:
        mark = self._puppet.mark
        self._puppet.publish("/distance", FLOAT, value)
        state = "free" if value >= 0.35 else "obstructed"
        # After a grab one more measurement is waited for: this one.
        self._node.shows(lambda s: s["variables"]["DistanceSensor.current"] == state, since=mark)

    def arrived(self) -> dict[str, list[Any]]:
        return arrived_at(self._puppet)


class Limited:
    """The rover of the limiter."""

    def __init__(self, node: Node, puppet: Puppet) -> None:
        self._node, self._puppet = node, puppet

    def sense(self, value: float) -> None:
        mark = self._puppet.mark
        scan = {"ranges": [value] * 360, "range_min": 0.05, "range_max": 10.0}
        self._puppet.do("publish", topic="/scan", type="sensor_msgs/LaserScan", fields=scan)
        ahead = pytest.approx(value, abs=1e-6)
        self._node.shows(lambda s: s["variables"]["Laser.ahead"] == ahead, since=mark)

    def arrived(self) -> dict[str, list[Any]]:
        return arrived_at(self._puppet)


class Crane:
    """The crane, which is asked for too much."""

    def __init__(self, node: Node, puppet: Puppet) -> None:
        self._node, self._puppet = node, puppet

    def sense(self, value: float) -> None:
        mark = self._puppet.mark
        self._puppet.publish("/limit", FLOAT, value)
        self._node.shows(lambda s: s["variables"]["Limit.most"] == value, since=mark)

    def arrived(self) -> dict[str, list[Any]]:
        return arrived_at(self._puppet)


def _crane_allows(most: float, arrived: Arrived) -> bool:
    """No higher than the limit, and no lower than 0; a level is at least 1."""
    name, message = arrived
    if name == "/set_level":
        return bool(message["level"] > 0)
    if name == "/gear":
        return -128 <= message["data"] <= 127
    return bool(0.0 <= message["data" if name == "/hoist" else "height"] <= most)


CRANE = Trial(
    (-1.0, 2.0, 8.0),
    lambda rng: [
        ("hoist", {"value": rng.uniform(-2.0, 10.0)}),
        ("set_level", {"level": rng.randint(-2, 5)}),
        ("reach", {"height": rng.randint(-2, 10)}),
        ("gear", {"data": rng.randint(-1, 1)}),
    ],
    _crane_allows,
)


def arrived_at(puppet: Puppet) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {name: [] for name in ROBOTS_NAMES}
    for line in puppet.lines[: puppet.mark]:
        name = line.get("heard") or line.get("asked")
        if name in found:
            found[name].append(line["message"])
    return found


ROBOTS_NAMES = (
    "/vel",
    "/grab",
    "/set_light_state",
    "/cmd_vel",
    "/hoist",
    "/gear",
    "/set_level",
    "/reach",
)


def test_an_agent_that_tries_everything_violates_nothing(
    guarded: Stage, robot: Puppet, start_agent: StartAgent
) -> None:
    with running(guarded, robot, start_agent) as (node, agent):
        try_everything(agent, LineFollower(node, robot), TRIALS["line_follower"], rounds(ROUNDS))


def test_an_agent_that_drives_a_limited_rover_violates_nothing(
    guarded: Stage, start_agent: StartAgent
) -> None:
    name = "limiter_supervisor"
    environment = guarded.workspace.environment(master=guarded.master)
    model = (str(LIMITER), "--library-path", str(LIBRARIES))
    with guarded.puppet() as puppet:
        puppet.do("listen", topic="/cmd_vel", type="geometry_msgs/Twist")
        with (
            guarded.controller(puppet, name, timeout__scan=600.0) as node,
            start_agent(*model, "--ros", f"/{name}", env=environment) as agent,
        ):
            await_condition(lambda: agent.call("state").get("components"), "the state")
            try_everything(agent, Limited(node, puppet), TRIALS["limiter"], rounds(ROUNDS))


def test_an_agent_at_a_crane_violates_nothing(crane: Stage, start_agent: StartAgent) -> None:
    name = "crane_supervisor"
    environment = crane.workspace.environment(master=crane.master)
    model = str(Path(__file__).with_name("crane.rscd"))
    with crane.puppet() as puppet:
        puppet.do("listen", topic="/hoist", type=FLOAT)
        puppet.do("listen", topic="/gear", type="std_msgs/Int8")
        puppet.do("service", name="/set_level", type="gauntlet_interfaces/SetLevel")
        puppet.do("action", name="/reach", type="gauntlet_interfaces/ReachAction", mode="succeed")
        with (
            crane.controller(puppet, name) as node,
            start_agent(model, "--ros", f"/{name}", env=environment) as agent,
        ):
            await_condition(lambda: agent.call("state").get("components"), "the state")
            try_everything(agent, Crane(node, puppet), CRANE, rounds(ROUNDS))
