"""The states that a plant reaches, event by event: the sets on the way, for traces.

Each event is applied to its own fixpoint before another is tried, and after a change only the
events that share a state variable with it are tried again: chaining, upwards in the variable
order. The fixpoints themselves come from :mod:`robosc.synthesis.bdd.saturation`, whose parts are no
sets of states that an event leads to.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from typing import TypeAlias

from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.bdd.relations import Disjunct, EventRelation

Iterates: TypeAlias = list[tuple[int, Bdd]]
"""The sets that a fixpoint passes through, each with the number of the event that added to it."""


def chained(
    manager: Manager,
    states: Bdd,
    disjuncts: Sequence[Sequence[Disjunct]],
    step: Callable[[Disjunct, Bdd], Bdd],
    related: Sequence[Sequence[int]],
    priority: Sequence[int],
) -> Iterates:
    """Return the sets from ``states`` to the least fixpoint of the steps of all disjuncts.

    ``related`` are the events to try again after each, ``priority`` tells which is tried first.
    """
    waiting = {n for n, several in enumerate(disjuncts) if any(not d.stays for d in several)}
    allowed = frozenset(waiting)
    queue = [(priority[n], n) for n in waiting]
    heapq.heapify(queue)
    iterates: Iterates = [(-1, states)]
    while queue:
        _, number = heapq.heappop(queue)
        waiting.discard(number)
        before, last = None, iterates[-1][1]
        found = last
        while found != before:
            before = found
            for disjunct in disjuncts[number]:
                if disjunct.stays:
                    continue
                more = manager.run(lambda d=disjunct, f=found: f | step(d, f))  # type: ignore[misc]
                if more != found:
                    iterates.append((number, more))
                found = more
        if found == last:
            continue
        for other in related[number]:
            if other in allowed and other not in waiting:
                waiting.add(other)
                heapq.heappush(queue, (priority[other], other))
    return iterates


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
