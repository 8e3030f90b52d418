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
from robosc.synthesis.bdd_diagrams import DEFAULT_MEMORY, Set
from robosc.synthesis.bdd_encoding import Encoding
from robosc.synthesis.bdd_events import EventRelation, Move, Relations

__all__ = ["Growth", "Progress", "SymbolicEngine", "SymbolicSolution"]

Progress = Callable[[str, int, int], None]
"""Called now and then: what is being computed, diagram nodes in use, and the most there can be."""

Growth: TypeAlias = list[tuple[int, Set]]
"""The sets that a fixpoint passes through, each with the number of the event that made it."""


@dataclass(frozen=True, eq=False)
class SymbolicSolution:
    """The controlled system: the ``states`` reached under control; ``good`` are all worth keeping.

    ``plant_reach`` is what the plant reaches, requirements apart. ``restricted`` tells whether
    something is forbidden beyond the requirements. Without a single state to keep, ``good`` means
    something only of states that the uncontrollable loss of the initial one passes through.
    """

    engine: SymbolicEngine
    plant_reach: Set
    states: Set
    good: Set
    restricted: bool

    @property
    def empty(self) -> bool:
        """Whether not even the initial state can be kept."""
        return self.states == self.engine.diagrams.false

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
                total += engine.encoding.count(self.enabled(event))
            else:
                occurring = self.states & event.occurring
                total += engine.encoding.count_with_parameters(event.number, occurring)
        return total

    def possible(self, event: EventRelation) -> Set:
        """The states in which the plant can do an event."""
        return self.states & event.possible

    def enabled(self, event: EventRelation) -> Set:
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
        most_moves: int | None = None,
    ) -> None:
        self.plant = plant
        self.encoding = Encoding(plant, memory)
        self.diagrams = self.encoding.diagrams
        options = {} if most_moves is None else {"most_moves": most_moves}
        self.relations = Relations(self.encoding, **options)
        self.events = self.relations.events
        self._progress = progress
        self._ruled = tuple(
            tuple(replace(m, relation=m.relation & event.required) for m in event.moves)
            for event in self.events
        )
        self._priority, self._related = _schedule(self.encoding, self.events)

    def solve(self) -> SymbolicSolution:
        """The controlled system."""
        encoding = self.encoding
        initial = encoding.initial
        reach = plant_reach = self._forward(initial, [event.moves for event in self.events])
        if any(event.required != self.diagrams.true for event in self.events):
            reach = self._forward(initial, self._ruled)
        good = reach
        bad = good & self.unsafe()
        while True:
            if bad != self.diagrams.false:
                good = good & ~self._uncontrollably(bad, good)
            if initial & good == self.diagrams.false:
                return SymbolicSolution(self, plant_reach, self.diagrams.false, good, True)
            back = self._coreachable(good)
            if back == good:
                break
            bad, good = good & ~back, back
        restricted = good != reach
        if restricted:
            reach = self._forward(initial, self._ruled, good)
        return SymbolicSolution(self, plant_reach, reach, good, restricted)

    def unsafe(self) -> Set:
        """The states that break a state requirement or leave a range, reachable or not."""
        found = [
            event.leaving
            for event in self.events
            if not self.plant.events[event.number].controllable
        ]
        found.extend(~self.encoding.holds(expr) for expr, _ in self.plant.invariants)
        return self.diagrams.union(found)

    def successors(self, states: Set) -> Set:
        """Where the plant under its requirements leads in one step."""
        return self.diagrams.union(
            self._run(lambda m=move: self.relations.image(m, states))  # type: ignore[misc]
            for moves in self._ruled
            for move in moves
            if not move.stays
        )

    def required_preimage(self, event: EventRelation, states: Set) -> Set:
        """From where the event leads into ``states`` in the plant under its requirements."""
        return self.diagrams.union(
            self.relations.preimage(move, states) for move in self._ruled[event.number]
        )

    def growth(self, states: Set) -> Growth:
        """How the controlled system unfolds from the initial state, ``states`` being all of it."""
        found: Growth = [(-1, self.encoding.initial)]
        self._forward(self.encoding.initial, self._ruled, states, found)
        return found

    # --- fixpoints

    def _forward(
        self,
        states: Set,
        moves: Sequence[Sequence[Move]],
        within: Set | None = None,
        growth: Growth | None = None,
    ) -> Set:
        """All that is reached; controllable events only into ``within``, if given."""
        image = self.relations.image

        def step(number: int, move: Move, found: Set) -> Set:
            reached = image(move, found)
            if within is not None and self.plant.events[number].controllable:
                reached = reached & within
            return reached

        return self._closure("reachable states", states, moves, step, growth)

    def _uncontrollably(self, bad: Set, good: Set) -> Set:
        """``bad``, and the states of ``good`` from which uncontrollable events lead there."""
        moves = [
            () if self.plant.events[event.number].controllable else event.moves
            for event in self.events
        ]
        return self._closure("states to be avoided", bad, moves, self._step_back(good))

    def _coreachable(self, good: Set) -> Set:
        """The states of ``good`` from which a marked state is reached inside ``good``."""
        marked = self.encoding.marked & good
        return self._closure("nonblocking states", marked, self._ruled, self._step_back(good))

    def _step_back(self, within: Set) -> Callable[[int, Move, Set], Set]:
        def step(number: int, move: Move, found: Set) -> Set:
            return self.relations.preimage(move, found) & within

        return step

    def _closure(
        self,
        what: str,
        states: Set,
        moves: Sequence[Sequence[Move]],
        step: Callable[[int, Move, Set], Set],
        growth: Growth | None = None,
    ) -> Set:
        """Add to ``states`` what the steps of all moves give, until they give no more.

        That events which share no axis need not be tried again is exact for the plant, but what a
        set confines them to may couple them; so a pass over all events has the last word.
        """
        active = [n for n in range(len(moves)) if any(not move.stays for move in moves[n])]

        def carry(number: int, found: Set) -> Set:
            while True:
                before = found
                for move in moves[number]:
                    if move.stays:
                        continue
                    more = self._run(lambda m=move, f=found: f | step(number, m, f))  # type: ignore[misc]
                    if growth is not None and more != found:
                        growth.append((number, more))
                    found = more
                if found == before:
                    return found

        while True:
            before = states
            states = self._saturate(what, states, active, carry)
            if states == before:
                return states

    def _saturate(
        self,
        what: str,
        states: Set,
        active: Iterable[int],
        carry: Callable[[int, Set], Set],
    ) -> Set:
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
                self._progress(what, self.diagrams.nodes, self.diagrams.capacity)
            for other in self._related[number]:
                if other in allowed and other not in waiting:
                    waiting.add(other)
                    heapq.heappush(queue, (self._priority[other], other))
        return states

    def _run(self, operation: Callable[[], Set]) -> Set:
        return self.diagrams.run(operation)


def _schedule(
    encoding: Encoding, events: Sequence[EventRelation]
) -> tuple[list[int], list[list[int]]]:
    """Per event: when its turn is (lower is sooner), and the events that it can set going again."""
    priority = []
    users: dict[int, set[int]] = {}
    for event in events:
        axes = event.reads | event.writes
        priority.append(-min((encoding.place(axis) for axis in axes), default=0))
        for axis in axes:
            users.setdefault(axis, set()).add(event.number)
    related: list[set[int]] = [set() for _ in events]
    for event in events:
        for axis in event.writes:
            for other in users[axis] - {event.number}:
                related[event.number].add(other)
                related[other].add(event.number)
    return priority, [sorted(others) for others in related]
