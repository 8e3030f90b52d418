"""An agent that commands a robot through a generated supervisor, on real rclpy."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from agents.agent_support import Agent, StartAgent
from ros2.bed import HERE
from ros2.ros2_support import Graph, Process
from ros_support import SOURCES, await_condition

Start = Callable[..., Process]
NODE = "guarded_arm_supervisor"
MODEL = str(HERE / "models" / "guarded_arm.rscd")


@contextmanager
def running(graph: Graph, sdk: str, start: StartAgent) -> Iterator[Agent]:
    # What synthesis needs is Debian's, which has messages of ROS 1 by the same names: it comes last.
    sites = [
        str(next(Path(python).parents[1].glob("lib/python3*/site-packages")))
        for python in (graph.bed.python, sdk)
    ]
    behind = "/usr/lib/python3/dist-packages"
    path = os.pathsep.join((str(SOURCES), graph.environment["PYTHONPATH"], *sites, behind))
    command = (graph.bed.python, "-m", "robosc", "mcp", MODEL, "--ros", NODE)
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
    with running(graph, sdk, start_agent) as agent:

        def heard() -> list[dict[str, object]]:
            """What the robot hears; what is sent before it and the supervisor met is lost."""
            told = agent.call("speed", value=12.5)
            assert told["outcome"] == "sent" or "calls per second" in str(told["why"]), told
            return robot.events("message", name="speed")

        assert await_condition(heard, "a speed")[0]["data"] == {"data": 12.5}
        told = agent.call("warn")
        assert (told["error"], told["outcome"]) == (True, "blocked"), told
        assert "Person.where = near" in told["why"][0]
        assert robot.events("message", name="beacon") == []
        told = agent.call("lock", data=True)
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
