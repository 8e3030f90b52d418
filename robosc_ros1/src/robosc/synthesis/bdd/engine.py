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
from robosc.synthesis.bdd.encoding import Encoding
from robosc.synthesis.bdd.manager import DEFAULT_MEMORY, Set
from robosc.synthesis.bdd.relations import EventRelation, Move, Relations

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
        self._ruled = tuple(_guarded(event.moves, event.required) for event in self.events)
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
            reach = self._forward(initial, *self._controlled(good))
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
        self._forward(self.encoding.initial, *self._controlled(states), growth=found)
        return found

    # --- control

    def _controlled(self, good: Set) -> tuple[list[Sequence[Move]], list[list[int]]]:
        """The moves that stay in ``good``, and which events can set each other going.

        A command's guard is told by as few axes as possible: with all that ``good`` reads, every
        event would have to be tried again after every other.
        """
        moves: list[Sequence[Move]] = []
        reads: list[frozenset[int]] = []
        for event in self.events:
            ruled, axes = self._ruled[event.number], event.reads
            if self.plant.events[event.number].controllable:
                here = good & event.possible & event.required
                allowed = here & self.required_preimage(event, good)
                refused = here & ~allowed
                if refused != self.diagrams.false:
                    guard, needed = self._narrow(allowed, refused)
                    ruled, axes = _guarded(ruled, guard), axes | needed
            moves.append(ruled)
            reads.append(axes)
        return moves, _related(self.events, reads)

    def _narrow(self, allowed: Set, refused: Set) -> tuple[Set, frozenset[int]]:
        """A condition that tells two sets apart, and the few axes that it reads."""
        self.diagrams.tidy()
        axes = set(range(len(self.plant.axes)))
        for axis in sorted(axes, key=self.encoding.place):
            cube = self.encoding.now([axis])
            wider = self.diagrams.exists(allowed, cube), self.diagrams.exists(refused, cube)
            if wider[0] & wider[1] == self.diagrams.false:
                allowed, refused = wider
                axes.discard(axis)
        return allowed, frozenset(axes)

    # --- fixpoints

    def _forward(
        self,
        states: Set,
        moves: Sequence[Sequence[Move]],
        related: Sequence[Sequence[int]] | None = None,
        growth: Growth | None = None,
    ) -> Set:
        """All that the moves reach."""

        def step(move: Move, found: Set) -> Set:
            return self.relations.image(move, found)

        return self._closure("reachable states", states, moves, step, related, growth)

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

    def _step_back(self, within: Set) -> Callable[[Move, Set], Set]:
        def step(move: Move, found: Set) -> Set:
            return self.relations.preimage(move, found) & within

        return step

    def _closure(
        self,
        what: str,
        states: Set,
        moves: Sequence[Sequence[Move]],
        step: Callable[[Move, Set], Set],
        related: Sequence[Sequence[int]] | None = None,
        growth: Growth | None = None,
    ) -> Set:
        """Add to ``states`` what the steps of all moves give, until they give no more.

        That events which share no axis need not be tried again is exact for the moves alone, but a
        set that steps are confined to may couple them; so a pass over all has the last word.
        """
        active = [n for n in range(len(moves)) if any(not move.stays for move in moves[n])]

        def carry(number: int, found: Set) -> Set:
            while True:
                before = found
                for move in moves[number]:
                    if move.stays:
                        continue
                    more = self._run(lambda m=move, f=found: f | step(m, f))  # type: ignore[misc]
                    if growth is not None and more != found:
                        growth.append((number, more))
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
        states: Set,
        active: Iterable[int],
        carry: Callable[[int, Set], Set],
        related: Sequence[Sequence[int]],
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
            for other in related[number]:
                if other in allowed and other not in waiting:
                    waiting.add(other)
                    heapq.heappush(queue, (self._priority[other], other))
        return states

    def _run(self, operation: Callable[[], Set]) -> Set:
        return self.diagrams.run(operation)


def _guarded(moves: Sequence[Move], guard: Set) -> tuple[Move, ...]:
    return tuple(replace(move, relation=move.relation & guard) for move in moves)


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
