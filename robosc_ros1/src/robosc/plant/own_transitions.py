"""Transitions that belong to one component only: internal ones, and those after a delay."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from robosc.language.events import EventKind
from robosc.model.automata import Behaviour, Transition
from robosc.runtime.core.places import place_of


class OwnTransition(NamedTuple):
    """A transition, the locations that it leaves, and where it leads as people read it.

    ``path`` is ``idle->busy``, with the line if another one of its kind leads there as well.
    """

    transition: Transition
    locations: list[int]
    path: str


def own_transitions(behaviour: Behaviour) -> Iterator[OwnTransition]:
    """The internal transitions, then those after a delay, in the order of the model."""
    for kind in (EventKind.TAU, EventKind.AFTER):
        placed = (item for item in behaviour.placed if item[1].event is kind)
        found = sorted(placed, key=lambda item: item[1].index)
        paths = [_path(place, transition) for place, transition in found]
        for (place, transition), path in zip(found, paths, strict=True):
            told = path if paths.count(path) == 1 else f"{path} (line {transition.span.line})"
            inside = [n for n, state in enumerate(behaviour.states) if state.is_in(place)]
            yield OwnTransition(transition, inside, told)


def _path(place: str | None, transition: Transition) -> str:
    """From the state in which it stands (None: from every one) to its target."""
    begin = "every state" if place is None else place
    return "->".join(map(place_of, (begin, transition.goto or begin)))
