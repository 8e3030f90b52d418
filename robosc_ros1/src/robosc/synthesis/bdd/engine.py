"""The symbolic engine: sets of states as decision diagrams, for products that no array could hold.

The fixpoints are those of the dense engine (Ramadge & Wonham 1987; Ouedraogo et al. 2011), confined
to states that the plant can reach. An event is carried to its own fixpoint before another is tried,
those low in the variable order first, and after a change only the events that share something with
it are tried again: chaining in the manner of saturation (Ciardo, Luettgen & Siminiceanu 2001).
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from robosc.ir.automaton import Plant
from robosc.model.entities import EventKind
from robosc.synthesis.bdd.encoding import Encoding
from robosc.synthesis.bdd.manager import DEFAULT_MEMORY, Bdd
from robosc.synthesis.bdd.relations import Disjunct, EventRelation, Relations
from robosc.synthesis.dropping import drop
from robosc.synthesis.parameters import weight

__all__ = ["Iterates", "Progress", "SymbolicEngine", "SymbolicSolution"]

Progress = Callable[[str, int, int], None]
"""Called now and then: what is being computed, diagram nodes in use, and the most there can be."""

Iterates: TypeAlias = list[tuple[int, Bdd]]
"""The sets that a fixpoint passes through, each with the number of the event that made it."""

_Narrowed: TypeAlias = tuple[Bdd, Bdd, frozenset[int]]
"""Allowed and refused states, and the axes by which they are told apart."""


@dataclass(frozen=True, eq=False)
class SymbolicSolution:
    """The controlled system: the ``states`` reached under control; ``good`` are all worth keeping.

    ``plant_reach`` is what the plant reaches, requirements apart. ``restricted`` tells whether
    something is forbidden beyond the requirements. Without a single state to keep, ``good`` means
    something only of states that the uncontrollable loss of the initial one passes through.
    """

    engine: SymbolicEngine
    plant_reach: Bdd
    states: Bdd
    good: Bdd
    restricted: bool

    @property
    def empty(self) -> bool:
        """Whether not even the initial state can be kept."""
        return self.states == self.engine.manager.false

    @property
    def plant_states(self) -> int:
        return self.engine.encoding.count(self.plant_reach)

    @property
    def controlled_states(self) -> int:
        return self.engine.encoding.count(self.states)

    @property
    def controlled_transitions(self) -> int:
        """State-event-value triples, self-loops included."""
        engine = self.engine
        total = 0
        for event in engine.events:
            if engine.plant.events[event.number].controllable:
                choices = weight(engine.plant.events[event.number])
                total += engine.encoding.count(self.enabled(event)) * choices
            else:
                occurring = self.states & event.occurring
                total += engine.encoding.count_with_parameters(event.number, occurring)
        return total

    def possible(self, event: EventRelation) -> Bdd:
        """The states in which the plant can do an event."""
        return self.states & event.possible

    def enabled(self, event: EventRelation) -> Bdd:
        """The states in which a controllable event is allowed."""
        if not self.restricted:
            return self.possible(event) & event.required
        return self.engine.required_preimage(event, self.states) & self.states


class SymbolicEngine:
    """Synthesis with decision diagrams, within ``memory`` bytes.

    Raises MemoryError when they do not suffice.
    """

    def __init__(
        self,
        plant: Plant,
        progress: Progress | None = None,
        memory: int = DEFAULT_MEMORY,
        most_disjuncts: int | None = None,
    ) -> None:
        self.plant = plant
        self.encoding = Encoding(plant, memory)
        self.manager = self.encoding.manager
        options = {} if most_disjuncts is None else {"most_disjuncts": most_disjuncts}
        self.relations = Relations(self.encoding, **options)
        self.events = self.relations.events
        self._progress = progress
        self._required = tuple(_guarded(event.disjuncts, event.required) for event in self.events)
        self._permitted: tuple[Sequence[Disjunct], ...] = self._required
        reads = [event.reads for event in self.events]
        self._related = _related(self.events, reads)
        self._priority = [
            -min((self.encoding.place(axis) for axis in event.reads | event.writes), default=0)
            for event in self.events
        ]

    def solve(self) -> SymbolicSolution:
        """The controlled system."""
        encoding = self.encoding
        initial = encoding.initial
        reach = plant_reach = self._forward(initial, [event.disjuncts for event in self.events])
        if any(event.required != self.manager.true for event in self.events):
            reach = self._forward(initial, self._required)
        good = reach
        bad = good & self.unsafe()
        while True:
            if bad != self.manager.false:
                good = good & ~self._uncontrollably(bad, good)
            if initial & good == self.manager.false:
                return SymbolicSolution(self, plant_reach, self.manager.false, good, True)
            back = self._coreachable(good)
            if back == good:
                break
            bad, good = good & ~back, back
        restricted = good != reach
        if restricted:
            self._permitted = self._inside(good)
            reach = self._forward(initial, *self._controlled(good))
        return SymbolicSolution(self, plant_reach, reach, good, restricted)

    def unsafe(self) -> Bdd:
        """The states that break a state requirement or leave a range, reachable or not."""
        found = [
            event.range_violation
            for event in self.events
            if not self.plant.events[event.number].controllable
        ]
        found.extend(~self.encoding.holds(expr) for expr, _ in self.plant.invariants)
        return self.manager.union(found)

    def successors(self, states: Bdd) -> Bdd:
        """Where the plant under its requirements leads in one step."""
        return self.manager.union(
            self._run(lambda m=disjunct: self.relations.image(m, states))  # type: ignore[misc]
            for disjuncts in self._permitted
            for disjunct in disjuncts
            if not disjunct.stays
        )

    def required_preimage(self, event: EventRelation, states: Bdd) -> Bdd:
        """From where the event leads into ``states`` in the plant under its requirements."""
        return self.manager.union(
            self.relations.preimage(disjunct, states) for disjunct in self._permitted[event.number]
        )

    def iterates(self, states: Bdd) -> Iterates:
        """How the controlled system unfolds from the initial state, ``states`` being all of it."""
        found: Iterates = [(-1, self.encoding.initial)]
        self._forward(self.encoding.initial, *self._controlled(states), iterates=found)
        return found

    def longest_completion(self, states: Bdd) -> int | None:
        """The most internal transitions that can follow one another in the controlled system.

        A greatest fixpoint: after n rounds those states are left from which n transitions can
        follow one another. None if there is no end.
        """
        transitions = [
            disjunct
            for event in self.events
            if self.plant.events[event.number].kind is EventKind.TAU
            for disjunct in self._required[event.number]
            if not disjunct.stays
        ]
        left = states
        length = 0
        while left != self.manager.false:
            self.manager.collect_garbage()
            before = self.manager.union(
                self.relations.preimage(disjunct, left) & left for disjunct in transitions
            )
            if before == left:
                return None
            left = before
            length += 1
        return max(0, length - 1)

    # --- control

    def _inside(self, good: Bdd) -> tuple[Sequence[Disjunct], ...]:
        """The disjuncts of all events, those of commands where nothing leads out of ``good``.

        That matters for commands about which the environment decides: any other command leads to
        one state, and what is kept inside ``good`` afterwards is kept by that alone.
        """
        found = []
        for event, disjuncts in zip(self.events, self._required, strict=True):
            taken = self.plant.events[event.number]
            if taken.controllable and taken.parameters:
                lost = self.manager.union(self.relations.preimage(d, ~good) for d in disjuncts)
                disjuncts = _guarded(disjuncts, ~lost)
            found.append(disjuncts)
        return tuple(found)

    def _controlled(self, good: Bdd) -> tuple[list[Sequence[Disjunct]], list[list[int]]]:
        """The disjuncts that stay in ``good``, and which events can set each other going.

        A command's guard is told by as few axes as possible: with all that ``good`` reads, every
        event would have to be tried again after every other.
        """
        disjuncts: list[Sequence[Disjunct]] = []
        reads: list[frozenset[int]] = []
        for event in self.events:
            required, axes = self._permitted[event.number], event.reads
            if self.plant.events[event.number].controllable:
                here = good & event.possible & event.required
                allowed = here & self.required_preimage(event, good)
                refused = here & ~allowed
                if refused != self.manager.false:
                    guard, needed = self._narrow(allowed, refused)
                    required, axes = _guarded(required, guard), axes | needed
            disjuncts.append(required)
            reads.append(axes)
        return disjuncts, _related(self.events, reads)

    def _narrow(self, allowed: Bdd, refused: Bdd) -> tuple[Bdd, frozenset[int]]:
        """A condition that tells two sets apart, and the few axes that it reads."""
        self.manager.collect_garbage()

        def without(left: _Narrowed, axes: Sequence[int]) -> _Narrowed | None:
            cube = self.encoding.now(axes)
            some, none = (self.manager.exists(states, cube) for states in left[:2])
            if some & none != self.manager.false:
                return None
            return some, none, left[2].difference(axes)

        axes = sorted(range(len(self.plant.variables)), key=self.encoding.place)
        found = drop(axes, (allowed, refused, frozenset(axes)), without)
        return found[0], found[2]

    # --- fixpoints

    def _forward(
        self,
        states: Bdd,
        disjuncts: Sequence[Sequence[Disjunct]],
        related: Sequence[Sequence[int]] | None = None,
        iterates: Iterates | None = None,
    ) -> Bdd:
        """All that the disjuncts reach."""

        def step(disjunct: Disjunct, found: Bdd) -> Bdd:
            return self.relations.image(disjunct, found)

        return self._closure("reachable states", states, disjuncts, step, related, iterates)

    def _uncontrollably(self, bad: Bdd, good: Bdd) -> Bdd:
        """``bad``, and the states of ``good`` from which uncontrollable events lead there."""
        disjuncts = [
            () if self.plant.events[event.number].controllable else event.disjuncts
            for event in self.events
        ]
        return self._closure("states to be avoided", bad, disjuncts, self._step_back(good))

    def _coreachable(self, good: Bdd) -> Bdd:
        """The states of ``good`` from which a marked state is reached inside ``good``."""
        marked = self.encoding.marked & good
        step = self._step_back(good)
        return self._closure("nonblocking states", marked, self._inside(good), step)

    def _step_back(self, within: Bdd) -> Callable[[Disjunct, Bdd], Bdd]:
        def step(disjunct: Disjunct, found: Bdd) -> Bdd:
            return self.relations.preimage(disjunct, found) & within

        return step

    def _closure(
        self,
        what: str,
        states: Bdd,
        disjuncts: Sequence[Sequence[Disjunct]],
        step: Callable[[Disjunct, Bdd], Bdd],
        related: Sequence[Sequence[int]] | None = None,
        iterates: Iterates | None = None,
    ) -> Bdd:
        """Return the least fixpoint above ``states`` of the steps of all disjuncts.

        That events which share no axis need not be tried again is exact for the disjuncts alone,
        but a set that steps are confined to may couple them; so a pass over all has the last word.
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
                    more = self._run(lambda m=disjunct, f=found: f | step(m, f))  # type: ignore[misc]
                    if iterates is not None and more != found:
                        iterates.append((number, more))
                    found = more
                if found == before:
                    return found

        while True:
            before = states
            states = self._saturate(what, states, active, carry, related or self._related)
            if states == before:
                return states

    def _saturate(
        self,
        what: str,
        states: Bdd,
        active: Iterable[int],
        carry: Callable[[int, Bdd], Bdd],
        related: Sequence[Sequence[int]],
    ) -> Bdd:
        waiting = set(active)
        allowed = frozenset(waiting)
        queue = [(self._priority[n], n) for n in waiting]
        heapq.heapify(queue)
        while queue:
            _, number = heapq.heappop(queue)
            waiting.discard(number)
            found = carry(number, states)
            if found == states:
                continue
            states = found
            if self._progress is not None:
                self._progress(what, self.manager.nodes, self.manager.capacity)
            for other in related[number]:
                if other in allowed and other not in waiting:
                    waiting.add(other)
                    heapq.heappush(queue, (self._priority[other], other))
        return states

    def _run(self, operation: Callable[[], Bdd]) -> Bdd:
        return self.manager.run(operation)


def _guarded(disjuncts: Sequence[Disjunct], guard: Bdd) -> tuple[Disjunct, ...]:
    return tuple(replace(disjunct, relation=disjunct.relation & guard) for disjunct in disjuncts)


def _related(events: Sequence[EventRelation], reads: Sequence[frozenset[int]]) -> list[list[int]]:
    """Per event those that share an axis with it which one of the two writes."""
    users: dict[int, set[int]] = {}
    for event, axes in zip(events, reads, strict=True):
        for axis in axes | event.writes:
            users.setdefault(axis, set()).add(event.number)
    related: list[set[int]] = [set() for _ in events]
    for event in events:
        for axis in event.writes:
            for other in users[axis] - {event.number}:
                related[event.number].add(other)
                related[other].add(event.number)
    return [sorted(others) for others in related]
