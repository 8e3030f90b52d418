"""From a command line to a page that is served: a running node, of either ROS.

Apart from models and logs, for a robot's computer need not have what synthesis takes.
"""

from __future__ import annotations

import contextlib
import importlib.util
import secrets
import sys
from collections.abc import Callable, Mapping, Sequence

from robosc.errors import UsageError
from robosc.runtime.core.telemetry import dump
from robosc.view import listening, operating, ros1
from robosc.view.hub import Hub
from robosc.view.ros2 import Ros2
from robosc.view.server import Answers, PageServer, Where

_LISTENERS: Mapping[str, Callable[[str, Hub], listening.Listener]] = {"1": ros1.Ros1, "2": Ros2}


def view_node(
    node: str, where: Where, environment: Mapping[str, str], persons: Sequence[str] | None = None
) -> None:
    """Show a running node, until interrupted; with ``persons``, the components that stand for
    such, whoever sits at this machine may operate it.

    Raises:
        UsageError: there is no ROS, it cannot listen there, or the node's name is none.
    """
    version = which_ros(environment)
    hub = Hub()
    listener = _LISTENERS[version](node, hub)
    answers: Answers = {}
    token = None
    if persons is not None:
        hub.put("operate", dump({"persons": list(persons)}))
        answers = operating.OperatorDesk(listener, persons, listener.heard.document).answers
        token = secrets.token_urlsafe(24)
    with PageServer(where, hub, answers, token) as server, contextlib.closing(listener):
        listener.start(server.address)
        server.run()


def which_ros(environment: Mapping[str, str]) -> str:
    """``"1"`` or ``"2"``: the one whose setup was sourced, else the one that this Python has.

    Where it has both, a master that is named decides for the first.

    Raises:
        UsageError: it is not there.
    """
    libraries = {"1": "rospy", "2": "rclpy"}
    sourced = environment.get("ROS_VERSION")
    if sourced in libraries:
        libraries = {sourced: libraries[sourced]}
    there = [version for version, name in libraries.items() if importlib.util.find_spec(name)]
    if not there:
        raise UsageError(
            f"{sys.executable} has no {' and no '.join(libraries.values())}: take the Python that"
            " ROS is installed for, and source the setup of a workspace first"
        )
    if len(there) == 1:
        return there[0]
    return "1" if "ROS_MASTER_URI" in environment else "2"
