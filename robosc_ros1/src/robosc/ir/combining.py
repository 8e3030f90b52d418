"""Which transitions of a component are taken together on one event."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

from robosc.language.events import EventKind
from robosc.model.entities import Behaviour, ResultTransition, State
from robosc.model.expr import Expr

__all__ = ["Level", "Taken", "result_transitions", "taken_in"]

Level: TypeAlias = Literal["state", "automaton", "both"]


@dataclass(frozen=True)
class Taken:
    """One way in which a state reacts: ``transition`` has the assignments of both if two are taken
    together, and is taken where all ``guards`` hold."""

    transition: ResultTransition
    guards: tuple[Expr, ...]
    level: Level


def taken_in(behaviour: Behaviour, state: State, event: EventKind, key: str) -> Iterator[Taken]:
    """What a state does on an event of a communication: the first that is possible.

    For a request the state's own transitions stand alone, if it has some. For events that no
    component blocks, a transition of the whole automaton without ``goto`` is taken together with
    one of the state, which decides on the variables that both assign; one with ``goto`` only where
    none of the state is.
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
    """All transitions, and with ``guard`` None the assignments of those taken together."""
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
