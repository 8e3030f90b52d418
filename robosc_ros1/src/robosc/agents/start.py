"""From a command line to a server for agents."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import anyio

from robosc.agents.calls import Gateway
from robosc.agents.ros1 import Ros1Caller
from robosc.agents.ros2 import Ros2Caller
from robosc.agents.running import Caller, Running
from robosc.agents.server import AgentServer
from robosc.agents.simulated import Simulated
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
        gateway: Gateway
        if node is None:
            gateway = Simulated(make, given)
        else:
            hub = Hub()
            callers: Mapping[str, Callable[[str, Hub], Caller]] = {"1": Ros1Caller, "2": Ros2Caller}
            ros = callers[which_ros(environment)](node, hub)
            ros.start(None)
            gateway = Running(ros, hub, make, guarded=robot.supervises)
        stack.callback(gateway.close)
        server = AgentServer(robot, offered, gateway, version, read_only=read_only, log=file)
        anyio.run(server.serve, port)
