"""An agent that commands a robot through a generated supervisor, on real rclpy."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
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
    called,
    rounds,
    try_everything,
)
from ros2.bed import HERE
from ros2.ros2_support import Graph, Peer, Process
from ros_support import SOURCES, await_condition

Start = Callable[..., Process]
NODE = "guarded_arm_supervisor"
MODEL = str(HERE / "models" / "guarded_arm.rscd")


@contextmanager
def running(
    graph: Graph, sdk: str, start: StartAgent, *model: str, node: str = NODE
) -> Iterator[Agent]:
    # What synthesis needs is Debian's, which has messages of ROS 1 by the same names: it comes last.
    sites = [
        str(next(Path(python).parents[1].glob("lib/python3*/site-packages")))
        for python in (graph.bed.python, sdk)
    ]
    behind = "/usr/lib/python3/dist-packages"
    path = os.pathsep.join((str(SOURCES), graph.environment["PYTHONPATH"], *sites, behind))
    command = (graph.bed.python, "-m", "robosc", "mcp", *(model or (MODEL,)), "--ros", node)
    with start(*command, env={**graph.environment, "PYTHONPATH": path}, whole=True) as agent:
        await_condition(lambda: agent.call("state").get("components"), "the state")
        yield agent


def test_an_agent_commands_through_the_supervisor(
    graph: Graph, controller: Start, sdk: str, start_agent: StartAgent
) -> None:
    robot = graph.peer("robot")
    robot.watch(NODE)
    robot.subscribe("speed", "std_msgs/msg/Float32")
    robot.subscribe("beacon", "std_msgs/msg/Empty")
    robot.serve("door/lock", "std_srvs/srv/SetBool")
    robot.act("reach", "robosc_testing/action/Move")
    controller(NODE)
    robot.expect_state(NODE, lambda s: "/speed" not in s["unconnected"])
    with running(graph, sdk, start_agent) as agent:

        def heard() -> list[dict[str, object]]:
            """What the robot hears; what is sent before it and the supervisor met is lost."""
            told = agent.call("speed", value=12.5)
            assert told["outcome"] == "sent" or "calls per second" in str(told["why"]), told
            return robot.events("message", name="speed")

        assert await_condition(heard, "a speed")[0]["data"] == {"data": 12.5}
        told = called(agent, "warn", {})
        assert (told["error"], told["outcome"]) == (True, "blocked"), told
        assert "Person.where = near" in told["why"][0]
        assert robot.events("message", name="beacon") == []
        told = called(agent, "lock", {"data": True})
        assert told["outcome"] == "blocked", told
        robot.publish("go", "std_msgs/msg/Bool", {"data": True})
        robot.expect_state(NODE, lambda s: s["variables"]["Operator.wanted"])
        agent.begin(call="lock", arguments={"data": True})
        request = robot.expect("request", name="door/lock")
        robot.order("tell_server", id=request["id"], data={"success": True, "message": "m"})
        answered = agent.hear()
        assert answered["outcome"] == "answered"
        assert answered["answer"] == {"success": True, "message": "m"}
        robot.expect_state(NODE, lambda s: s["components"]["Door"] == "locked")
        agent.begin(call="reach", arguments={"target": 2.0}, cancel_after=1)
        goal = robot.expect("goal", name="reach")
        robot.order("tell_server", id=goal["id"], feedback={"progress": 0.5})
        assert agent.hear() == {"progress": {"progress": 0.5}}
        assert agent.hear() == {"gave_up": True}
        robot.expect("cancel", name="reach")
        robot.order("tell_server", id=goal["id"], end="canceled")


def test_a_call_to_a_node_that_dies_ends(
    graph: Graph, controller: Start, sdk: str, start_agent: StartAgent
) -> None:
    robot = graph.peer("robot")
    robot.watch(NODE)
    robot.serve("door/lock", "std_srvs/srv/SetBool")
    supervisor = controller(NODE)
    robot.expect_state(NODE, lambda s: "/door/lock" not in s["unconnected"])
    robot.publish("go", "std_msgs/msg/Bool", {"data": True})
    robot.expect_state(NODE, lambda s: s["variables"]["Operator.wanted"])
    with running(graph, sdk, start_agent) as agent:
        agent.begin(call="lock", arguments={"data": True})
        robot.expect("request", name="door/lock")
        supervisor.signal(signal.SIGKILL)
        told = agent.hear()
        assert (told["error"], told["outcome"]) == (True, "unknown")
        assert "silent" in told["why"][0]


FLOAT = "std_msgs/msg/Float32"
TWIST = "geometry_msgs/msg/Twist"
ROUNDS = 6
"""Of four or five calls each. ROBOSC_AGENT_ROUNDS=250 makes a thousand of them."""


class Played:
    """A robot as :mod:`agents.tried` has it: what it senses, and what reaches it."""

    def __init__(self, peer: Peer, node: str, parts: dict[str, str]) -> None:
        self._peer, self.node, self._parts = peer, node, parts
        peer.watch(node)

    def meet(self) -> None:
        """Wait until the supervisor knows this robot."""
        self._peer.expect_state(
            self.node, lambda s: not any(f"/{name}" in s["unconnected"] for name in self._parts)
        )

    def arrived(self) -> dict[str, list[Any]]:
        return {
            f"/{name}": [event["data"] for event in self._peer.events(kind, name=name)]
            for name, kind in self._parts.items()
        }


class LineFollower(Played):
    inputs = ("distance",)

    def __init__(self, peer: Peer) -> None:
        names = {"vel": "message", "grab": "goal", "set_light_state": "request"}
        super().__init__(peer, "line_follower_supervisor", names)
        peer.subscribe("vel", TWIST)
        peer.serve("set_light_state", "robot_common/srv/LightBulbService", {})
        peer.act("grab", "robot_common/action/Grabber", end="succeed")

    def sense(self, value: float) -> None:
        self._peer.publish("distance", FLOAT, {"data": value})
        state = "free" if value >= 0.35 else "obstructed"
        self._peer.expect_state(
            self.node, lambda s: s["variables"]["DistanceSensor.current"] == state
        )


class Limited(Played):
    inputs = ("scan",)

    def __init__(self, peer: Peer) -> None:
        super().__init__(peer, "limiter_supervisor", {"cmd_vel": "message"})
        peer.subscribe("cmd_vel", TWIST)

    def sense(self, value: float) -> None:
        scan = {"ranges": [value] * 360, "range_min": 0.05, "range_max": 10.0}
        self._peer.publish("scan", "sensor_msgs/msg/LaserScan", scan)
        ahead = pytest.approx(value, abs=1e-6)
        self._peer.expect_state(self.node, lambda s: s["variables"]["Laser.ahead"] == ahead)


class Crane(Played):
    inputs = ("limit",)

    def __init__(self, peer: Peer) -> None:
        names = {"hoist": "message", "brake": "request", "reach": "goal"}
        super().__init__(peer, "crane_supervisor", names)
        peer.subscribe("hoist", FLOAT)
        peer.serve("brake", "std_srvs/srv/SetBool", {"success": True})
        peer.act("reach", "robosc_testing/action/Move", end="succeed")

    def sense(self, value: float) -> None:
        self._peer.publish("limit", FLOAT, {"data": value})
        self._peer.expect_state(self.node, lambda s: s["variables"]["Limit.most"] == value)


class GuardedArm(Played):
    """Its situations: 0 nobody is near and work is wanted, 1 somebody is near, 2 nothing is wanted."""

    inputs = ("zone", "go")

    def __init__(self, peer: Peer) -> None:
        names = {"speed": "message", "beacon": "message", "door/lock": "request", "reach": "goal"}
        super().__init__(peer, NODE, names)
        peer.subscribe("speed", FLOAT)
        peer.subscribe("beacon", "std_msgs/msg/Empty")
        peer.serve("door/lock", "std_srvs/srv/SetBool", {"success": True})
        peer.act("reach", "robosc_testing/action/Move", end="succeed")

    def sense(self, value: float) -> None:
        near, wanted = value == 1, value != 2
        reading = {"valid": near, "distance": 0.5, "vector": [0.0, 0.0, 0.0]}
        self._peer.publish("person", "robosc_testing/msg/Reading", reading)
        self._peer.publish("go", "std_msgs/msg/Bool", {"data": wanted})
        where = "near" if near else "far"
        self._peer.expect_state(
            self.node,
            lambda s: (
                (s["variables"]["Person.where"], s["variables"]["Operator.wanted"])
                == (where, wanted)
            ),
        )


ARM = Trial(
    (0, 1, 2),
    lambda rng: [
        ("speed", {"value": rng.uniform(-5.0, 5.0)}),
        ("warn", {}),
        ("lock", {"data": True}),
        ("reach", {"target": 2.0}),
    ],
    lambda situation, arrived: {
        "/beacon": situation == 1,
        "/door/lock": situation != 2,
        "/reach": situation == 0,
    }.get(arrived[0], True),
)


def _crane_allows(most: float, arrived: Arrived) -> bool:
    """Whatever is asked for, the crane goes no higher than the limit, and no lower than 0."""
    name, message = arrived
    if name == "/brake":
        return bool(message["data"])
    return bool(0.0 <= message["data" if name == "/hoist" else "target"] <= most)


CRANE = Trial(
    (-1.0, 2.0, 8.0),
    lambda rng: [
        ("hoist", {"value": rng.uniform(-2.0, 10.0)}),
        ("brake", {"data": rng.random() < 0.5}),
        ("reach", {"target": rng.uniform(-2.0, 10.0)}),
        ("hoist", {"value": rng.uniform(-2.0, 10.0)}),
    ],
    _crane_allows,
)


@pytest.mark.parametrize(
    ("play", "model", "trial"),
    [
        (LineFollower, (str(LINE_FOLLOWER),), TRIALS["line_follower"]),
        (Limited, (str(LIMITER), "--library-path", str(LIBRARIES)), TRIALS["limiter"]),
        (Crane, (str(HERE / "models" / "crane.rscd"),), CRANE),
        (GuardedArm, (MODEL,), ARM),
    ],
    ids=["line_follower", "limiter", "crane", "guarded_arm"],
)
def test_an_agent_that_tries_everything_violates_nothing(
    graph: Graph,
    controller: Start,
    sdk: str,
    start_agent: StartAgent,
    play: Any,
    model: tuple[str, ...],
    trial: Trial,
) -> None:
    robot = play(graph.peer("robot"))
    node = robot.node
    reliable: dict[str, object] = {f"qos__{name}__reliability": "reliable" for name in robot.inputs}
    silence: dict[str, object] = {
        f"timeout__{name}": 600.0 for name in robot.inputs if name in ("distance", "scan")
    }
    controller(node, **reliable, **silence)
    robot.meet()
    with running(graph, sdk, start_agent, *model, node=node) as agent:
        try_everything(agent, robot, trial, rounds(ROUNDS))
