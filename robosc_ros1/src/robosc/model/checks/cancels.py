"""The check for models that take the cancel of an action for its end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from robosc.errors import Note
from robosc.language.events import EventKind
from robosc.model.diagnostics import Report
from robosc.model.entities import Communication, Component

_ENDS = (EventKind.RESPONSE, EventKind.ERROR)


def check_cancels(
    components: Iterable[Component], communications: Mapping[str, Communication], report: Report
) -> None:
    """Report transitions for a cancel that lead where the end of the action leads.

    The component then looks as if the goal had ended, while the server still carries it out.
    """
    for component in components:
        transitions = list(component.transitions)
        ends = {(t.communication, t.goto): t for t in transitions if t.event in _ENDS}
        for transition in transitions:
            if transition.event is not EventKind.CANCEL or transition.goto is None:
                continue
            end = ends.get((transition.communication, transition.goto))
            if end is not None:
                name = communications[transition.communication].name
                report.add(
                    "cancel-is-not-end",
                    transition.span,
                    f"{component.name} is in '{transition.goto}', as after the end of {name},"
                    f" while {name} is still being cancelled",
                    f"react to its end: on cancelled from {name} goto {transition.goto}",
                    [Note("this is where it goes at the end", end.span)],
                )
