"""From a command line to a page that is served: a model, or an event log of its node."""

from __future__ import annotations

from collections.abc import Sequence

from robosc.errors import UsageError
from robosc.simulate import faults, start
from robosc.supervisor import Supervisor
from robosc.view import exported, recorded
from robosc.view.hub import Hub
from robosc.view.played import Played
from robosc.view.server import PageServer, Where


def view_model(
    supervisor: Supervisor, where: Where, *, execute: bool, given: Sequence[str] = ()
) -> None:
    """Have the model played in browsers, until interrupted.

    Raises:
        UsageError: it cannot listen there, or a parameter is none.
    """
    hub = Hub()
    try:
        machine = start.machine_maker(supervisor, execute=execute)(start.parameters(given), {})
    except faults.InvalidLine as fault:
        raise UsageError(str(fault)) from None
    played = Played(machine, hub)
    with PageServer(where, hub, played.answers) as server:
        played.start()
        server.run()


def view_log(supervisor: Supervisor, log: str, where: Where) -> None:
    """Show an event log of the model's node, until interrupted.

    Raises:
        UsageError: it cannot listen there, or the log cannot be read.
    """
    hub = Hub()
    recording = recorded.Recording(supervisor, log, hub)
    with PageServer(where, hub, recording.answers) as server:
        server.run()


def export_log(supervisor: Supervisor, log: str) -> str:
    """Return an event log of the model's node as one HTML file.

    Raises:
        UsageError: the log cannot be read.
    """
    return exported.html_of(recorded.Recording(supervisor, log, Hub()))
