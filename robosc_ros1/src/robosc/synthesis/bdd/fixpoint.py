"""Least fixpoints of transition relations by chaining.

Each event is applied to its own fixpoint before another is tried, and after a change only the
events that share a state variable with it are tried again: chaining in the manner of saturation
(Ciardo, Luettgen & Siminiceanu, TACAS 2001). Whether to go upwards or downwards in the variable
order depends on the model, and makes a difference of up to a factor of ten. Where one event undoes
what others must do again, as with priorities, both enumerate all combinations, and only rounds, in
which each event is tried once, are short. So these three strategies are raced: each gets a budget
of work, then larger budgets in turn until one finishes. The result of many small steps is the start
of the next strategy; sets with large diagrams are discarded, since it would not recover from them.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import count
from typing import TypeAlias

from robosc.progress import Progress
from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.bdd.relations import Disjunct, EventRelation

__all__ = ["Fixpoint", "Iterates", "related_events"]

Iterates: TypeAlias = list[tuple[int, Bdd]]
"""The sets that a fixpoint passes through, each with the number of the event that added to it."""

_Strategy: TypeAlias = tuple[Sequence[int], int]
"""Priorities of the events, and after how many rounds a tried event is tried again."""

_FIRST_BUDGET = 2**20
"""New nodes, a second of work; with a smaller budget synthesis took up to 1.5 times as long."""
_MORE = 4
"""Factor between one budget and the next."""
_STEP = 32
"""New nodes that a step counts as, since many small steps take time, too."""


class _OverBudgetError(Exception):
    """Raised when a budget is used up; ``states`` are those found, None if diagrams grew large."""

    def __init__(self, states: Bdd | None) -> None:
        self.states = states


class Fixpoint:
    """Least fixpoints of one plant; ``places`` are the events' positions in the variable order."""

    def __init__(
        self, manager: Manager, places: Sequence[int], progress: Progress | None = None
    ) -> None:
        self.manager = manager
        self._progress = progress
        upwards = [-place for place in places]
        self._strategies: list[_Strategy] = [(upwards, 0), (list(places), 0), (upwards, 1)]

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

        ``related`` are the events to try again after each. A set that steps are confined to may
        couple further events, so passes over all are repeated until nothing changes.
        """
        active = [
            n for n in range(len(disjuncts)) if any(not disjunct.stays for disjunct in disjuncts[n])
        ]

        def closed(number: int, found: Bdd) -> Bdd:
            """Apply one event to its own fixpoint."""
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

        chained = partial(self._chained, what, active, closed, related)
        while True:
            before = states
            if iterates is None:
                states = self._raced(states, chained)
            else:
                states = chained(states, self._strategies[0], None)
            if states == before:
                return states

    def _raced(self, states: Bdd, chained: Callable[[Bdd, _Strategy, int | None], Bdd]) -> Bdd:
        """Race the strategies; the one that finishes is tried first next time."""
        for attempt in count():
            budget = _FIRST_BUDGET * _MORE**attempt
            strategies = list(self._strategies)
            while strategies:
                strategy = strategies.pop(0)
                try:
                    found = chained(states, strategy, budget)
                except _OverBudgetError as over:
                    self.manager.collect_garbage()
                    if over.states is not None:
                        states = over.states
                        strategies.sort(key=lambda strategy: strategy[1], reverse=True)
                else:
                    self._strategies.remove(strategy)
                    self._strategies.insert(0, strategy)
                    return found
        raise AssertionError("a race without end")

    def _chained(
        self,
        what: str,
        active: Iterable[int],
        closed: Callable[[int, Bdd], Bdd],
        related: Sequence[Sequence[int]],
        states: Bdd,
        strategy: _Strategy,
        budget: int | None,
    ) -> Bdd:
        priority, later = strategy
        most = self.manager.capacity if budget is None else self.manager.nodes + budget
        waiting = set(active)
        allowed = frozenset(waiting)
        queue = [(0, priority[n], n) for n in waiting]
        heapq.heapify(queue)
        work = 0
        while queue:
            turn, _, number = heapq.heappop(queue)
            waiting.discard(number)
            found = closed(number, states)
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
    events: Sequence[EventRelation], touched: Sequence[frozenset[int]]
) -> list[list[int]]:
    """Return, per event, those that share a state variable with it that one of them writes.

    ``touched`` are the state variables that each event reads or writes.
    """
    users: dict[int, set[int]] = {}
    for event, variables in zip(events, touched, strict=True):
        for variable in variables:
            users.setdefault(variable, set()).add(event.number)
    related: list[set[int]] = [set() for _ in events]
    for event in events:
        for variable in event.writes:
            for other in users[variable] - {event.number}:
                related[event.number].add(other)
                related[other].add(event.number)
    return [sorted(others) for others in related]
