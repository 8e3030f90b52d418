"""Least fixpoints of transition relations by chaining.

An event is carried to its own fixpoint before another is tried, and after a change only the events
that share something with it are tried again: chaining in the manner of saturation (Ciardo, Luettgen
& Siminiceanu, TACAS 2001). Whether it is better to go from the low variables of the order to the
high ones or the other way depends on the model, by a factor of ten; and where one event undoes what
others must do again, as with priorities, both count through all combinations, and only rounds, in
which each event has its turn once, are short. So the three are raced: each gets a budget of work,
and larger ones in turn until one of them is done. What many small steps have found the next way
carries on; from sets with large diagrams it would not recover, and starts again.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Sequence
from itertools import count
from typing import TypeAlias

from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.bdd.relations import Disjunct, EventRelation

__all__ = ["Fixpoint", "Iterates", "Progress", "related_events"]

Progress = Callable[[str, int, int], None]
"""Called now and then: what is being computed, diagram nodes in use, and the most there can be."""

Iterates: TypeAlias = list[tuple[int, Bdd]]
"""The sets that a fixpoint passes through, each with the number of the event that made it."""

_Way: TypeAlias = tuple[Sequence[int], int]
"""Priorities of the events, and how many rounds later an event that was tried is tried again."""

_FIRST_BUDGET = 2**20
"""A second of work: below that nothing is raced. Measured: a smaller one costs up to 1.5 times."""
_MORE = 4
_STEP = 32
"""As how many new nodes a step counts, since many small ones take time, too."""


class _OverBudgetError(Exception):
    """More work than a race allows; ``states`` are those found if it was many small steps, None if
    it was large diagrams."""

    def __init__(self, states: Bdd | None) -> None:
        self.states = states


class Fixpoint:
    """Fixpoints of one plant; ``places`` says where each event stands in the variable order."""

    def __init__(
        self, manager: Manager, places: Sequence[int], progress: Progress | None = None
    ) -> None:
        self.manager = manager
        self._progress = progress
        upwards = [-place for place in places]
        self._ways: list[_Way] = [(upwards, 0), (list(places), 0), (upwards, 1)]

    def closure(
        self,
        what: str,
        states: Bdd,
        disjuncts: Sequence[Sequence[Disjunct]],
        step: Callable[[Disjunct, Bdd], Bdd],
        related: Sequence[Sequence[int]],
        iterates: Iterates | None = None,
    ) -> Bdd:
        """Return the least fixpoint above ``states`` of the steps of all disjuncts.

        That events which share no state variable need not be tried again is exact for the disjuncts
        alone, but a set that steps are confined to may couple them; so a pass over all has the last
        word.
        """
        active = [
            n for n in range(len(disjuncts)) if any(not disjunct.stays for disjunct in disjuncts[n])
        ]

        def carry(number: int, found: Bdd) -> Bdd:
            while True:
                before = found
                for disjunct in disjuncts[number]:
                    if disjunct.stays:
                        continue
                    more = self.manager.run(lambda m=disjunct, f=found: f | step(m, f))  # type: ignore[misc]
                    if iterates is not None and more != found:
                        iterates.append((number, more))
                    found = more
                if found == before:
                    return found

        while True:
            before = states
            if iterates is None:
                states = self._raced(what, states, active, carry, related)
            else:
                way = self._ways[0]
                states = self._chained(what, states, active, carry, related, way, None)
            if states == before:
                return states

    def _raced(
        self,
        what: str,
        states: Bdd,
        active: Sequence[int],
        carry: Callable[[int, Bdd], Bdd],
        related: Sequence[Sequence[int]],
    ) -> Bdd:
        """Chain in one way or another; the one that was best is tried first next time."""
        for attempt in count():
            budget = _FIRST_BUDGET * _MORE**attempt
            ways = list(self._ways)
            while ways:
                way = ways.pop(0)
                try:
                    found = self._chained(what, states, active, carry, related, way, budget)
                except _OverBudgetError as over:
                    self.manager.collect()
                    if over.states is not None:
                        states = over.states
                        ways.sort(key=lambda way: way[1], reverse=True)
                else:
                    self._ways = [way, *(other for other in self._ways if other is not way)]
                    return found
        raise AssertionError("a race without end")

    def _chained(
        self,
        what: str,
        states: Bdd,
        active: Iterable[int],
        carry: Callable[[int, Bdd], Bdd],
        related: Sequence[Sequence[int]],
        way: _Way,
        budget: int | None,
    ) -> Bdd:
        priority, later = way
        most = self.manager.capacity if budget is None else self.manager.nodes + budget
        waiting = set(active)
        allowed = frozenset(waiting)
        queue = [(0, priority[n], n) for n in waiting]
        heapq.heapify(queue)
        work = 0
        while queue:
            turn, _, number = heapq.heappop(queue)
            waiting.discard(number)
            found = carry(number, states)
            work += _STEP
            if found == states:
                continue
            states = found
            if self.manager.nodes + work > most < self.manager.capacity // 2:
                raise _OverBudgetError(states if 2 * work > (budget or 0) else None)
            if self._progress is not None:
                self._progress(what, self.manager.nodes, self.manager.capacity)
            for other in related[number]:
                if other in allowed and other not in waiting:
                    waiting.add(other)
                    heapq.heappush(queue, (turn + later, priority[other], other))
        return states


def related_events(
    events: Sequence[EventRelation], reads: Sequence[frozenset[int]]
) -> list[list[int]]:
    """Per event those that share a state variable with it which one of the two writes."""
    users: dict[int, set[int]] = {}
    for event, variables in zip(events, reads, strict=True):
        for variable in variables | event.writes:
            users.setdefault(variable, set()).add(event.number)
    related: list[set[int]] = [set() for _ in events]
    for event in events:
        for variable in event.writes:
            for other in users[variable] - {event.number}:
                related[event.number].add(other)
                related[other].add(event.number)
    return [sorted(others) for others in related]
