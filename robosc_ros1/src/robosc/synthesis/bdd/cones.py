"""Paths to a state by the events that concern it: the rest of a large system stands still.

A path by some of the events is one of the whole controlled system. So a path is looked for first by
the events of a relaxed plan (:mod:`robosc.synthesis.bdd.relaxed`), then by those that write what
its end is about (the *cone* of the condition), then also by those that write what these read, hop
by hop, at last by all. A cone that stands still in most of its variables has small sets of states
where those of the system are large. A path goes backwards through the sets that chaining passes,
from the first one that contains a state to the one before; it is short, usually a shortest one of
its cone.

The work is bounded by a number of nodes, not by time, so that the same model has the same traces
everywhere.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import chain

from robosc import limits
from robosc.plant.automaton import PlantState
from robosc.plant.support import support
from robosc.supervisor import Guard
from robosc.synthesis.bdd.chaining import chained, related_events
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import Disjunct
from robosc.synthesis.bdd.relaxed import Relaxation
from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution

_SHARE = 4
"""One cone may take this part of the work that is left, so that something is left for others."""


class Cones:
    """The cones of a solution, each with the sets found so far."""

    def __init__(
        self,
        solution: SymbolicSolution,
        guards: Iterable[Guard],
        most_work: int = limits.TRACE_NODES,
    ) -> None:
        self._solution = solution
        self._guards = {g.event.identity: g.expr for g in guards if g.status != "as required"}
        self._engine = solution.engine
        self._work_left = most_work
        self._controlled: dict[int, tuple[Sequence[Disjunct], frozenset[int]]] = {}
        self._found: dict[frozenset[int], _Cone] = {}

    def path(self, wanted: Bdd, read: frozenset[int]) -> tuple[PlantState, ...] | None:
        """Return a path to one of the wanted states, whose condition reads some state variables.

        At least one of them is a controlled state. None: looking for a path is too much work.
        """
        for events in chain([self._relaxation.events(wanted)], self._widening(read)):
            cone = self._found.get(events)
            if cone is None:
                cone = self._found[events] = self._cone(events)
            place = cone.first(wanted)
            if place is not None:
                path, taken = cone.back(place, wanted)
                return self._shortest(taken, wanted, len(path)) or path
            if cone.is_cut_off:
                return None
        raise AssertionError("a controlled state is not reached")

    def _shortest(
        self, events: frozenset[int], wanted: Bdd, length: int
    ) -> tuple[PlantState, ...] | None:
        """Return a shortest path by some events: chaining may take a long way round.

        None: it has no fewer states than ``length``, or finding it is too much work.
        """
        engine, false = self._engine, self._engine.manager.false
        encoding, image = engine.encoding, engine.relations.image
        moves = {number: self.moves(number)[0] for number in events}
        layers, seen = [encoding.initial], encoding.initial
        work = self.share
        while layers[-1] & wanted == false:
            if len(layers) + 1 >= length or work < 0:
                return None
            engine.manager.make_room()
            try:
                new = engine.manager.union(
                    image(one, layers[-1]) for several in moves.values() for one in several
                )
            except MemoryError:
                return None
            layers.append(new & ~seen)
            seen = seen | new
            work -= engine.manager.size(seen)
            self.spend(engine.manager.size(seen))
        states = [encoding.least(layers[-1] & wanted)]
        for layer in reversed(layers[:-1]):
            after = encoding.state(states[-1])
            before = (engine.required_preimage(engine.events[n], after) & layer for n in events)
            states.append(encoding.least(next(one for one in before if one != false)))
        return tuple(reversed(states))

    @cached_property
    def _relaxation(self) -> Relaxation:
        return Relaxation(
            self._engine, {e.number: self.moves(e.number) for e in self._engine.events}
        )

    def _widening(self, read: frozenset[int]) -> Iterator[frozenset[int]]:
        """Yield sets of event numbers, each with more than the one before, the last with all."""
        writing = frozenset[int]()
        everything = frozenset(event.number for event in self._engine.events)
        while True:
            wider = frozenset(
                e.number for e in self._engine.events if not e.writes.isdisjoint(read)
            )
            if wider == writing:
                break
            yield wider
            writing = wider
            read = read.union(*(self.moves(number)[1] for number in writing))
        if writing != everything:
            yield everything

    def moves(self, number: int) -> tuple[Sequence[Disjunct], frozenset[int]]:
        """Return an event's disjuncts under control, and the state variables that it touches.

        A command's guard reads few of them: if it read all that the controlled states read, every
        event would have to be tried again after every other.
        """
        found = self._controlled.get(number)
        if found is None:
            engine = self._engine
            relation = engine.events[number]
            guard = self._guards.get(engine.plant.events[number].identity)
            if guard is None:
                found = engine.required_disjuncts[number], relation.variables
            else:
                touched = relation.variables.union(support(engine.plant, guard))
                found = engine.guarded(relation, engine.encoding.holds(guard)), touched
            self._controlled[number] = found
        return found

    def _cone(self, numbers: frozenset[int]) -> _Cone:
        engine = self._engine
        events = [event for event in engine.events if event.number in numbers]
        sets = chained(
            engine.manager,
            engine.encoding.initial,
            {event.number: self.moves(event.number)[0] for event in events},
            engine.relations.image,
            related_events(events, {e.number: self.moves(e.number)[1] for e in events}),
            {event.number: -engine.place(event) for event in events},
        )
        return _Cone(self, sets)

    def spend(self, nodes: int) -> None:
        self._work_left -= nodes

    @property
    def share(self) -> int:
        """The work that a new cone may take."""
        return self._work_left // _SHARE

    @property
    def solution(self) -> SymbolicSolution:
        return self._solution


class _Cone:
    """The sets of states that some events reach, from the initial states on, as far as needed."""

    def __init__(self, cones: Cones, sets: Iterator[tuple[int, Bdd]]) -> None:
        self._cones = cones
        self._engine = cones.solution.engine
        self._false = self._engine.manager.false
        self._sets = [(-1, self._engine.encoding.initial)]
        self._more = sets
        self._work_left = cones.share
        self._size = 0
        self.is_cut_off = False

    def first(self, wanted: Bdd) -> int | None:
        """Return the place of the first set with a wanted state; None: there is none so far."""
        if self._sets[-1][1] & wanted != self._false:
            return bisect_left(self._sets, True, key=lambda item: item[1] & wanted != self._false)
        while not self.is_cut_off and self._extend():
            if self._sets[-1][1] & wanted != self._false:
                return len(self._sets) - 1
        return None

    def _extend(self) -> bool:
        """Look for the next set. False: there is none, or finding it is too much work."""
        try:
            for number, states in self._more:
                if states == self._sets[-1][1]:
                    self._spend()
                    if self.is_cut_off:
                        return False
                    continue
                self._sets.append((number, states))
                self._size = self._engine.manager.size(states)
                self._spend()
                return True
        except MemoryError:
            self.is_cut_off = True
        return False

    def _spend(self) -> None:
        self._work_left -= self._size
        self._cones.spend(self._size)
        self.is_cut_off = self._work_left <= 0

    def back(self, number: int, wanted: Bdd) -> tuple[tuple[PlantState, ...], frozenset[int]]:
        """Return the path to a wanted state of a set, backwards through the sets; its events."""
        encoding = self._engine.encoding
        states = [encoding.pick(self._sets[number][1] & wanted)]
        taken = set()
        while number > 0:
            event = self._engine.events[self._sets[number][0]]
            taken.add(event.number)
            after = encoding.state(states[-1])
            before = self._engine.required_preimage(event, after) & self._sets[number - 1][1]
            states.append(encoding.pick(before))
            number = self._first_with(encoding.assignment(states[-1]), number)
        return tuple(reversed(states)), frozenset(taken)

    def _first_with(self, assignment: Sequence[tuple[int, bool]], before: int) -> int:
        """Return the place of the first set, before another, that contains a state."""
        contains = self._engine.manager.contains
        return bisect_left(
            self._sets, True, hi=before, key=lambda item: contains(item[1], assignment)
        )
