"""The states that a plant reaches, event by event: the sets on the way, for traces.

Each event is applied to its own fixpoint before another is tried, and after a change only the
events that share a state variable with it are tried again: chaining, upwards in the variable
order. The fixpoints themselves come from :mod:`robosc.synthesis.bdd.saturation`, whose parts are no
sets of states that an event leads to.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping, Sequence

from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.bdd.relations import Disjunct, EventRelation


def chained(
    manager: Manager,
    states: Bdd,
    disjuncts: Mapping[int, Sequence[Disjunct]],
    step: Callable[[Disjunct, Bdd], Bdd],
    related: Mapping[int, Sequence[int]],
    priority: Mapping[int, int],
) -> Iterator[tuple[int, Bdd]]:
    """Yield a set after each image, from ``states`` to the least fixpoint of all disjuncts.

    Each comes with the number of its event; it is the one before if the image adds nothing.
    ``disjuncts`` are those of each event, by its number, ``related`` the events to try again after
    each, ``priority`` tells which is tried first.
    """
    waiting = {n for n, several in disjuncts.items() if any(not d.stays for d in several)}
    allowed = frozenset(waiting)
    queue = [(priority[n], n) for n in waiting]
    heapq.heapify(queue)
    found = states
    while queue:
        _, number = heapq.heappop(queue)
        waiting.discard(number)
        before, last = None, found
        while found != before:
            before = found
            for disjunct in disjuncts[number]:
                if not disjunct.stays:
                    found = manager.run(lambda d=disjunct, f=found: f | step(d, f))  # type: ignore[misc]
                    yield number, found
        if found == last:
            continue
        for other in related[number]:
            if other in allowed and other not in waiting:
                waiting.add(other)
                heapq.heappush(queue, (priority[other], other))


def related_events(
    events: Sequence[EventRelation], touched: Mapping[int, frozenset[int]]
) -> dict[int, list[int]]:
    """Return, per event, those that share a state variable with it that one of them writes.

    ``touched`` are the state variables that each event reads or writes, by its number.
    """
    users: dict[int, set[int]] = {}
    for event in events:
        for variable in touched[event.number]:
            users.setdefault(variable, set()).add(event.number)
    related: dict[int, set[int]] = {event.number: set() for event in events}
    for event in events:
        for variable in event.writes:
            for other in users[variable] - {event.number}:
                related[event.number].add(other)
                related[other].add(event.number)
    return {number: sorted(others) for number, others in related.items()}
