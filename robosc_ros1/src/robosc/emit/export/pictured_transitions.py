"""The transitions of a component as pictures of it show them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from robosc.expr import traversal, tree
from robosc.language.events import EventKind
from robosc.model import automata, entities
from robosc.plant import logic, model_text
from robosc.runtime.core.places import DUE, place_of
from robosc.source import Span


def pictured(behaviour: automata.Behaviour) -> Iterator[tuple[str | None, automata.Transition]]:
    """Yield transitions with the state that they leave (None: every state), as the model names
    states.

    A state that performs a command is one: what leads from one of its stages to another is left
    out, and so are the counts of its errors.
    """
    for stage, transition in behaviour.placed:
        source = None if stage is None else place_of(stage)
        target = None if transition.goto is None else place_of(transition.goto)
        assigned = tuple(a for a in transition.assignments if " " not in a.variable)
        between = source != stage and source == target and not assigned
        if between and (
            transition.event in _BETWEEN_STAGES or transition.goto != f"{source} {DUE}"
        ):
            continue
        guard = transition.guard
        if source != stage and guard is not None:
            guard = _told(guard, transition.span)
        yield source, replace(transition, goto=target, guard=guard, assignments=assigned)


def _told(guard: tree.Expr, span: Span) -> tree.Expr | None:
    """A guard of a state that performs a command, without a text: what the performing asks for is
    not in it. ``span`` is that of the transition: a ``retry`` is about goals that nobody cancelled,
    which is left out.
    """
    parts = traversal.operands(guard, "and")
    told = [part for part in parts if not (_is_of_cancelling(part) and part.span == span)]
    return replace(logic.conjunction(told), span=None) if told else None


def _is_of_cancelling(part: tree.Expr) -> bool:
    asked = part.operand if isinstance(part, tree.Unary) else None
    return isinstance(asked, tree.PhaseRef) and asked.phase == "cancelling"


_BETWEEN_STAGES = (EventKind.ERROR, EventKind.CANCELLED, EventKind.AFTER)


def as_written(expr: tree.Expr, robot: entities.Robot) -> str:
    """Return an expression as it was written, white space folded."""
    if expr.span is not None:
        return " ".join(expr.span.text.split())
    return model_text.to_dsl(expr, robot)
