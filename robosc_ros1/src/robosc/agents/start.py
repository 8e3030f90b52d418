"""From a command line to a server for agents."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import anyio

from robosc.agents.running import Running, Verdicts
from robosc.agents.server import AgentServer, Gateway
from robosc.agents.simulated import Simulated
from robosc.agents.tools import tools
from robosc.errors import UsageError
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.node import which_ros
from robosc.view.ros1 import Ros1
from robosc.view.ros2 import Ros2


@dataclass(frozen=True)
class Service:
    """How agents reach the server: ``port`` None is standard input and output."""

    port: int | None = None
    read_only: bool = False
    log: Path | None = None


def serve_simulated(
    supervisor: Supervisor, given: Mapping[str, Any], service: Service, version: str
) -> None:
    """Serve an agent that commands a simulated robot, and plays it."""
    gateway = Simulated(machine_maker(supervisor, execute=True), given)
    _serve(supervisor, gateway, service, version, plays=True)


def serve_running(
    supervisor: Supervisor,
    node: str,
    environment: Mapping[str, str],
    service: Service,
    version: str,
) -> None:
    """Serve an agent that commands through a running node.

    Raises:
        UsageError: there is no ROS, or the node's name is none.
    """
    verdicts = Verdicts()
    more = {"state": verdicts.state, "events": verdicts.event, "blocked": verdicts.blocked}
    make = machine_maker(supervisor, execute=True)
    guarded = supervisor.plant.robot.supervises
    listener: Any
    if which_ros(environment) == "1":
        from robosc.agents.ros1 import Ros1Caller

        listener = Ros1(node, Hub(), more)
        caller: Any = Ros1Caller(listener)
    else:
        from robosc.agents.ros2 import Ros2Caller

        listener = Ros2(node, Hub(), more)
        caller = Ros2Caller(listener)
    listener.start(None)
    gateway = Running(listener.heard.node, caller, verdicts, make, guarded=guarded)
    _serve(supervisor, gateway, service, version, plays=False)


def _serve(
    supervisor: Supervisor, gateway: Gateway, service: Service, version: str, *, plays: bool
) -> None:
    robot = supervisor.plant.robot
    offered = tools(robot, robot.supervises)
    if not offered:
        raise UsageError(
            f"{robot.name} has nothing to command: a supervisor's model has commands, a"
            " controller's one serves calls (outgoing service, outgoing action)"
        )
    with contextlib.ExitStack() as stack:
        log = None if service.log is None else stack.enter_context(_log(service.log))
        stack.callback(gateway.close)
        server = AgentServer(
            robot.name,
            robot.span.source.text,
            offered,
            gateway,
            version,
            read_only=service.read_only,
            plays=plays,
            log=log or sys.stderr,
        )
        if service.port is None:
            anyio.run(server.serve_stdio)
        else:
            anyio.run(server.serve_http, service.port, _tell)


def _log(path: Path) -> Any:
    try:
        return path.open("a", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror or error}") from error


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
