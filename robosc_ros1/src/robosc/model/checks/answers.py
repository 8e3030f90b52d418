"""The check for answers that say that it did not work, which nothing reads."""

from __future__ import annotations

from robosc.expr import tree, types
from robosc.language.events import EventKind, Kind
from robosc.model.checks.used_fields import Usage
from robosc.model.diagnostics import Report
from robosc.model.entities import Component, Robot

_SAYS = "success"
"""The boolean of a response that says by the custom of ROS whether it worked."""


def check_answers(robot: Robot, usage: Usage, report: Report) -> None:
    """Warn of calls whose refusal leads where success leads, though an error leads elsewhere."""
    for call in robot.communications.values():
        if (
            call.kind in (Kind.SERVICE, Kind.ACTION)
            and isinstance(call.response, types.ObjectType)
            and isinstance(call.response.property(_SAYS), types.BooleanType)
            and not usage.uses(call.key, "response", (_SAYS,))
            and any(_depends(component, call.key) for component in robot.components)
        ):
            report.add(
                "refusal-unread",
                call.span,
                f"an answer of {call.name} that says success: false counts as done",
                f"add 'expect: value.{_SAYS},', which makes it an error",
            )


def _depends(component: Component, key: str) -> bool:
    """Whether a component goes elsewhere after an error than after a response."""
    done, failed = (
        _effects(component, key, kind) for kind in (EventKind.RESPONSE, EventKind.ERROR)
    )
    return bool(done) and bool(failed) and done != failed


def _effects(
    component: Component, key: str, kind: EventKind
) -> set[tuple[str | None, tuple[tuple[str, tree.Expr], ...]]]:
    return {
        (taken.goto, tuple((a.variable, a.value) for a in taken.assignments))
        for taken in component.transitions
        if taken.communication == key and taken.event is kind
    }
