"""From a command line to a page that is served."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from robosc.errors import UsageError
from robosc.simulate.faults import Wrong
from robosc.simulate.start import machine_maker, parameters
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.listening import Listener
from robosc.view.played import Played
from robosc.view.recorded import Recording
from robosc.view.server import PageServer

__all__ = ["Where", "view_log", "view_model", "view_node"]


@dataclass(frozen=True)
class Where:
    """Where to listen; ``port`` None is any that is free, the usual one if possible."""

    host: str = "127.0.0.1"
    port: int | None = None


def view_model(
    supervisor: Supervisor, where: Where, *, execute: bool, given: Sequence[str] = ()
) -> None:
    """Have the model played in browsers, until interrupted.

    Raises:
        UsageError: it cannot listen there, or a parameter is none.
    """
    hub = Hub()
    try:
        machine = machine_maker(supervisor, execute=execute)(parameters(given))
    except Wrong as fault:
        raise UsageError(str(fault)) from None
    played = Played(machine, hub)
    _serve(PageServer(where.host, where.port, hub, played.answers), played.start)


def view_log(supervisor: Supervisor, log: str, where: Where, stop_command: str | None) -> None:
    """Show an event log of the model's node, until interrupted.

    Raises:
        UsageError: it cannot listen there, or the log cannot be read.
    """
    hub = Hub()
    recording = Recording(supervisor, log, hub, stop_command)
    _serve(PageServer(where.host, where.port, hub, recording.answers), lambda: None)


def view_node(node: str, where: Where) -> None:
    """Show a running node of ROS 1, until interrupted.

    Raises:
        UsageError: it cannot listen there, or the node's name is none.
        ModuleNotFoundError: this Python has no rospy.
    """
    hub = Hub()
    listener = Listener(node, hub)
    _serve(PageServer(where.host, where.port, hub, {}), listener.start, listener.close)


def _serve(
    server: PageServer, start: Callable[[], None], close: Callable[[], None] = lambda: None
) -> None:
    with server:
        start()
        print(server.url, flush=True)
        print("Ctrl-C ends it", file=sys.stderr, flush=True)
        try:
            server.serve_forever(poll_interval=0.2)
        finally:
            close()
