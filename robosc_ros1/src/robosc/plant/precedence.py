"""How transitions of a state and of the whole automaton combine on one event."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import TypeAlias

from robosc.expr.tree import Expr
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.automata import Behaviour, State, Transition


@dataclass(frozen=True)
class Taken:
    """A possible reaction of a state: ``transition`` is taken where all ``guards`` hold.

    If it ``joins`` several that are taken together, it has the assignments of all. ``levels`` are
    those of the guards, 0 for the state's own: reactions with the same levels exclude each other.
    """

    transition: Transition
    guards: tuple[Expr, ...]
    levels: tuple[int, ...]
    joins: bool = False


def taken_in(behaviour: Behaviour, state: State, event: EventKind, key: str) -> Iterator[Taken]:
    """Yield a state's reactions to an event; the first one that is possible is taken.

    If a level (the state, those around it, the whole automaton) has transitions for a request, only
    those of the innermost such level apply. For events that no component blocks, a transition
    without ``goto`` of an outer level is taken together with one of an inner level, whose
    assignments take precedence; one with ``goto`` is taken only if none of an inner level is.
    """
    levels = [
        [t for t in level if t.event is event and t.communication == key]
        for level in behaviour.levels(state)
    ]
    if event.synchronised:
        depth = next((n for n, level in enumerate(levels) if level), 0)
        for transition in levels[depth]:
            yield _taken(((depth, transition),))
    else:
        for together in _together(levels, 0, False):
            if together:
                yield _taken(together)


_Several: TypeAlias = tuple[tuple[int, Transition], ...]
"""Transitions that are taken together, each with its level: that of the state is 0."""


def _together(
    levels: Sequence[Sequence[Transition]], depth: int, inner: bool
) -> Iterator[_Several]:
    """Yield what the levels from ``depth`` on take together; the first that is possible is taken.

    ``inner``: one of an inner level is taken, too.
    """
    if depth == len(levels):
        yield ()
        return
    for transition in levels[depth]:
        if not inner or transition.goto is None:
            for others in _together(levels, depth + 1, True):
                yield (depth, transition), *others
            if transition.guard is None:
                return
    yield from _together(levels, depth + 1, inner)


def _taken(together: _Several) -> Taken:
    own = together[0][1]
    assignments = {a.variable: a for _, t in reversed(together) for a in t.assignments}
    order = dict.fromkeys(a.variable for _, t in together for a in t.assignments)
    guarded = [(depth, t.guard) for depth, t in together if t.guard is not None]
    return Taken(
        replace(own, assignments=tuple(assignments[name] for name in order)),
        tuple(guard for _, guard in guarded),
        tuple(depth for depth, _ in guarded),
        len(together) > 1,
    )


def joined_transitions(behaviour: Behaviour) -> Iterator[Transition]:
    """Yield all transitions; also, without a guard, each two that may be taken together, as one."""
    yield from behaviour.all_transitions
    for state in behaviour.states:
        mentioned = ((t.event, t.communication) for t in chain(*behaviour.levels(state)))
        for event, key in dict.fromkeys(mentioned):
            for taken in taken_in(behaviour, state, event, key):
                if taken.joins:
                    yield replace(taken.transition, guard=None)
