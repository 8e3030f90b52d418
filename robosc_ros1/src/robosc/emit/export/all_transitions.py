"""All transitions of a component in one form, for what is exported of a model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from robosc.expr.tree import Expr
from robosc.language.events import EventKind
from robosc.model.automata import After, Assignment, Behaviour, ResultTransition, Tau
from robosc.model.entities import Robot
from robosc.plant.formulas import to_dsl
from robosc.runtime.places import DUE, place_of
from robosc.source import Span


@dataclass(frozen=True, slots=True)
class AnyTransition:
    """A transition on an event of a communication, after a delay, or an internal one.

    ``source`` None: it leaves every state; of a state with states in it, each of those. ``target``
    None: it stays; ``named`` is the state with states in it that the model names instead.
    ``communication`` is the key of one; None for others, which ``index`` counts from 1.
    """

    source: str | None
    target: str | None
    named: str | None
    kind: EventKind
    communication: str | None
    index: int
    delay: Expr | None
    guard: Expr | None
    assignments: tuple[Assignment, ...]
    span: Span


def transitions(behaviour: Behaviour) -> Iterator[AnyTransition]:
    """Those of every state, of states with states in them, then state by state."""
    yield from (_on_event(None, t) for t in behaviour.transitions)
    yield from (_internal(None, tau) for tau in behaviour.taus)
    for outer in behaviour.composites:
        yield from (_on_event(outer.name, t) for t in outer.transitions)
        yield from (_internal(outer.name, tau) for tau in outer.taus)
        yield from (_delayed(outer.name, after) for after in outer.afters)
    for state in behaviour.states:
        yield from (_on_event(state.name, t) for t in state.transitions)
        yield from (_internal(state.name, tau) for tau in state.taus)
        yield from (_delayed(state.name, after) for after in state.afters)


def pictured(behaviour: Behaviour) -> Iterator[AnyTransition]:
    """Those that pictures show, between states as the model names them.

    A state that performs a command is one: what leads from one of its stages to another is left
    out, and so are the counts of its errors.
    """
    for found in transitions(behaviour):
        source = None if found.source is None else place_of(found.source)
        target = None if found.target is None else place_of(found.target)
        assigned = tuple(a for a in found.assignments if " " not in a.variable)
        staged = source != found.source
        between = staged and source == target and not assigned
        if between and (found.kind in _BETWEEN_STAGES or found.target != f"{source} {DUE}"):
            continue
        guard = found.guard
        if staged and guard is not None:
            guard = replace(guard, span=None)  # what the performing asks for is not in the text
        yield replace(found, source=source, target=target, guard=guard, assignments=assigned)


_BETWEEN_STAGES = (EventKind.ERROR, EventKind.CANCELLED, EventKind.AFTER)


def _on_event(source: str | None, found: ResultTransition) -> AnyTransition:
    taken = found.guard, found.assignments, found.span
    return AnyTransition(
        source, found.goto, found.named, found.event, found.communication, 0, None, *taken
    )


def _internal(source: str | None, tau: Tau) -> AnyTransition:
    return replace(_on_event(source, tau.transition), communication=None, index=tau.index)


def _delayed(source: str, after: After) -> AnyTransition:
    found = _on_event(source, after.transition)
    return replace(found, communication=None, index=after.index, delay=after.delay)


def as_written(expr: Expr, robot: Robot) -> str:
    """Return an expression as it was written, white space folded."""
    if expr.span is not None:
        return " ".join(expr.span.text.split())
    return to_dsl(expr, robot)
