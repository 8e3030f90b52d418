"""Requests of another controller: one event for each case of the data that conditions read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from math import prod
from typing import Any, overload

from robosc import errors, limits
from robosc.expr import traversal, tree, types
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event, EventParameter, LocalAutomaton
from robosc.plant.data.classes import Classes
from robosc.plant.partial_evaluation import PartValues, holds
from robosc.plant.step import is_consistent, missing_together


@dataclass(frozen=True, eq=False)
class OneClass(Sequence[Any]):
    """One of several classes: a sequence of its representative; the values of the class are
    ``in`` it."""

    classes: Classes
    number: int

    def __len__(self) -> int:
        return 1

    @overload
    def __getitem__(self, index: int) -> types.Value | None: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[types.Value | None]: ...
    def __getitem__(self, index: int | slice) -> Any:
        return (self.classes[self.number],)[index]

    def __contains__(self, value: object) -> bool:
        return value in self.classes and self.classes.index(value) == self.number

    def index(self, value: Any, start: int = 0, stop: int | None = None) -> int:
        """Return 0, the number of its only class."""
        return 0


def by_data(event: Event) -> Iterator[Event]:
    """Yield the events that a request with data represents; any other event as it is.

    A supervisor knows the data before it allows the request, so each case of them is an event that
    it can allow or refuse. Of a controller's requests nothing is read: its data follow from the
    state.

    Raises:
        StateSpaceError: there are more than ``limits.CASES_OF_A_COMMAND``.
    """
    known = tuple(i for i, p in enumerate(event.parameters) if _is_of_data(p))
    if event.kind is not EventKind.REQUEST or not known:
        yield event
        return
    sizes = [len(event.parameters[i].values) for i in known]
    if prod(sizes) > limits.CASES_OF_A_COMMAND:
        raise errors.StateSpaceError(
            f"what is asked of the data of {event.name} has {prod(sizes)} cases, more than the"
            f" limit of {limits.CASES_OF_A_COMMAND}: ask for fewer things of one command"
        )
    places = {number: place for place, number in enumerate(known)}
    pairs = [
        (places[i], places[j]) for i, j in missing_together(event) if i in places and j in places
    ]
    number = 0
    for chosen in product(*(range(size) for size in sizes)):
        values = tuple(event.parameters[i].values[n] for i, n in zip(known, chosen, strict=True))
        if is_consistent(values, pairs):
            number += 1
            yield _case(event, known, chosen, number)


def _case(event: Event, known: tuple[int, ...], chosen: tuple[int, ...], number: int) -> Event:
    parameters = list(event.parameters)
    for i, n in zip(known, chosen, strict=True):
        whole = parameters[i]
        labels = None if whole.labels is None else (whole.labels[n],)
        classes = whole.values
        values = OneClass(classes, n) if isinstance(classes, Classes) else (classes[n],)
        parameters[i] = replace(whole, values=values, labels=labels)
    case = replace(event, parameters=tuple(parameters), known=known, index=number, whole=event)
    data = case.data
    requirement = holds(event.requirement, data)
    return replace(
        case,
        automata=tuple(_automaton(automaton, data) for automaton in event.automata),
        requirement=None if requirement == tree.TRUE else requirement,
    )


def _automaton(automaton: LocalAutomaton, data: PartValues) -> LocalAutomaton:
    """Return the automaton without the transitions that these data rule out."""
    edges = (
        replace(edge, guard=None if guard == tree.TRUE else guard)
        for edge, guard in ((edge, holds(edge.guard, data)) for edge in automaton.edges)
        if guard != tree.FALSE
    )
    return replace(automaton, edges=tuple(edges))


def _is_of_data(parameter: EventParameter) -> bool:
    """Whether a parameter follows from the data, and is not chosen when the event happens."""
    if parameter.test is not None:
        return any(map(traversal.reads_value, parameter.test.sides))
    return not parameter.renews
