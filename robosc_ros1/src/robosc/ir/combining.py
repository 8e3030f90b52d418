"""How transitions of a state and of the whole automaton combine on one event."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

from robosc.language.events import EventKind
from robosc.model.entities import Behaviour, ResultTransition, State
from robosc.model.expr import Expr

Level: TypeAlias = Literal["state", "automaton", "both"]


@dataclass(frozen=True)
class Taken:
    """A possible reaction of a state: ``transition`` is taken where all ``guards`` hold; if two are
    taken together, it has the assignments of both."""

    transition: ResultTransition
    guards: tuple[Expr, ...]
    level: Level


def taken_in(behaviour: Behaviour, state: State, event: EventKind, key: str) -> Iterator[Taken]:
    """Yield a state's reactions to an event; the first one that is possible is taken.

    If the state has transitions for a request, only these apply. For events that no component
    blocks, a transition of the whole automaton without ``goto`` is taken together with one of the
    state, whose assignments take precedence; one with ``goto`` is taken only if none of the state
    is.
    """
    local = [t for t in state.transitions if t.event is event and t.communication == key]
    common = [t for t in behaviour.transitions if t.event is event and t.communication == key]
    staying = [t for t in common if t.goto is None]
    for own in local:
        if not event.synchronised:
            for other in staying:
                level: Level = "state" if other.guard is None else "both"
                yield Taken(_joined(own, other), _guards(own, other), level)
        if event.synchronised or all(other.guard is not None for other in staying):
            yield Taken(own, _guards(own), "state")
        if own.guard is None:
            return
    if not (local and event.synchronised):
        for transition in common:
            yield Taken(transition, _guards(transition), "automaton")


def result_transitions(behaviour: Behaviour) -> Iterator[ResultTransition]:
    """Yield all transitions; also, without a guard, each two that may be taken together, as one."""
    yield from behaviour.all_transitions
    for state in behaviour.states:
        for own in state.transitions:
            for other in behaviour.transitions:
                same = (own.event, own.communication) == (other.event, other.communication)
                if same and other.goto is None and not own.event.synchronised:
                    yield replace(_joined(own, other), guard=None)


def _joined(own: ResultTransition, other: ResultTransition) -> ResultTransition:
    assigned = {a.variable for a in own.assignments}
    more = tuple(a for a in other.assignments if a.variable not in assigned)
    return replace(own, assignments=(*own.assignments, *more))


def _guards(*transitions: ResultTransition) -> tuple[Expr, ...]:
    return tuple(t.guard for t in transitions if t.guard is not None)
