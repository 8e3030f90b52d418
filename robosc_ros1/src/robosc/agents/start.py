"""From a command line to a server for agents."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import anyio

from robosc.agents import calls, ros1, ros2, running, simulated
from robosc.agents.server import AgentServer
from robosc.agents.tools import tools
from robosc.errors import UsageError
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.node import which_ros


def serve(
    supervisor: Supervisor,
    node: str | None,
    environment: Mapping[str, str],
    given: Mapping[str, Any],
    version: str,
    *,
    port: int | None,
    read_only: bool,
    log: Path | None,
) -> None:
    """Serve an agent that commands through a running node, or without one a simulated robot, which
    it plays. ``port`` None is standard input and output.

    Raises:
        UsageError: there is no ROS, the node's name is none, or the model has nothing to command.
    """
    robot = supervisor.plant.robot
    offered = tools(robot)
    if not offered:
        raise UsageError(
            f"{robot.name} has nothing to command: a supervisor's model has commands, a"
            " controller's one serves calls (outgoing service, outgoing action)"
        )
    with contextlib.ExitStack() as stack:
        try:
            file = stack.enter_context(log.open("a", encoding="utf-8")) if log else sys.stderr
        except OSError as error:
            raise UsageError(f"cannot write {log}: {error.strerror or error}") from error
        make = machine_maker(supervisor, execute=True)
        gateway: calls.Gateway
        if node is None:
            gateway = simulated.Simulated(make, given)
        else:
            hub = Hub()
            callers: Mapping[str, Callable[[str, Hub], running.Caller]] = {
                "1": ros1.Ros1Caller,
                "2": ros2.Ros2Caller,
            }
            ros = callers[which_ros(environment)](node, hub)
            ros.start(None)
            gateway = running.Running(ros, hub, make, guarded=robot.supervises)
        stack.callback(gateway.close)
        server = AgentServer(robot, offered, gateway, version, read_only=read_only, log=file)
        anyio.run(server.serve, port)
