"""The symbolic engine: sets of states as decision diagrams, for products too large for arrays.

The fixpoint is that of :mod:`robosc.synthesis.fixpoint`, over the states that the plant can reach;
least fixpoints in it are computed by saturation (:mod:`robosc.synthesis.bdd.saturation`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

from robosc import limits
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.support import support
from robosc.progress import Progress
from robosc.synthesis.bdd.encoding import Encoding
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import MOST_DISJUNCTS, Disjunct, EventRelation, Relations
from robosc.synthesis.bdd.saturation import saturated
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.fixpoint import supremal


class TooManyNodes(Exception):
    """The search takes more nodes than it may; another order of the variables may do with fewer."""


class Turn:
    """A turn of another engine, which is called once diagrams take more than some nodes, garbage
    included.

    It raises what ends synthesis, or returns the states that are reached under the requirements and
    violate none (``found``), if it knows them.
    """

    def __init__(self, nodes: int, engine: Callable[[], Sequence[PlantState] | None]) -> None:
        self._nodes = nodes
        self._engine: Callable[[], Sequence[PlantState] | None] | None = engine
        self.found: Sequence[PlantState] | None = None

    def call(self, nodes: int) -> None:
        """Call the engine if it is its turn; only once."""
        if self._engine is not None and nodes > self._nodes:
            engine, self._engine = self._engine, None
            self.found = engine()


_SECONDS = 0.05
"""Between two reports of progress."""


@dataclass(frozen=True, eq=False)
class SymbolicSolution:
    """The controlled system: ``states`` are those reached under control.

    ``good`` is the supremal safe, controllable and nonblocking set. If it does not contain the
    initial states, ``states`` is empty, and ``good`` is an intermediate set of the fixpoint, enough
    to explain the loss of an initial state by uncontrollable events. ``plant_reach`` is what the
    plant reaches without its requirements, ``explored`` the part of it that the fixpoint is about.
    ``restricted`` says whether something is forbidden
    beyond the requirements.
    """

    engine: SymbolicEngine
    plant_reach: Bdd
    explored: Bdd
    states: Bdd
    good: Bdd
    restricted: bool
    rounds: tuple[tuple[Bdd, Bdd], ...] = ()
    """Per round of the fixpoint, the states lost in it, and those left after it."""

    @property
    def empty(self) -> bool:
        """Whether an initial state is not good."""
        return self.states == self.engine.manager.false

    @property
    def plant_states(self) -> int:
        return self.engine.encoding.count(self.plant_reach)

    @property
    def controlled_states(self) -> int:
        return self.engine.encoding.count(self.states)

    def occurrences(self, event: EventRelation, enabled: Bdd | None = None) -> int:
        """Return the number of pairs of a state and values with which an event happens; a command
        does in the states in which it is ``enabled``."""
        encoding = self.engine.encoding
        if enabled is not None:
            return encoding.count(enabled) * weight(self.engine.plant.events[event.number])
        return encoding.count_with_parameters(event.number, self.states & event.occurring)

    def possible(self, event: EventRelation) -> Bdd:
        """Return the controlled states in which an event is possible in the plant."""
        return self.states & event.possible

    def enabled(self, event: EventRelation) -> Bdd:
        """Return the controlled states in which a controllable event is enabled."""
        if not self.restricted:
            return self.possible(event) & event.required
        return self.engine.required_preimage(event, self.states) & self.states


class SymbolicEngine:
    """Synthesis with decision diagrams, within ``memory`` bytes.

    Raises:
        MemoryError: they do not suffice.
    """

    def __init__(
        self,
        plant: Plant,
        progress: Progress | None = None,
        memory: int = limits.MEMORY,
        most_disjuncts: int = MOST_DISJUNCTS,
        reverse: bool = False,
        most_nodes: int | None = None,
        turn: Turn | None = None,
        invariants_first: bool = False,
        most_made: float = math.inf,
        together: bool = False,
    ) -> None:
        """``most_nodes`` are those that may be in use, ``most_made`` those that may be made until
        it has begun. ``together``: the order does not tear components apart."""
        self.plant = plant
        self._most_made = most_made
        self.opposite_order = reverse
        self.together = together
        self._most_nodes = most_nodes
        self._turn = turn
        self._invariants_first = invariants_first
        self.encoding = Encoding(plant, memory, reverse, invariants_first, together)
        self.manager = self.encoding.manager
        self.relations = Relations(self.encoding, most_disjuncts, self._check_nodes)
        self.events = self.relations.events
        self._required = tuple(_guarded(event.disjuncts, event.required) for event in self.events)
        self._permitted: tuple[Sequence[Disjunct], ...] = self._required
        self._progress = progress
        self._explored = self.manager.false
        self._found: Sequence[PlantState] | None = None
        self._rounds: list[tuple[Bdd, Bdd]] = []

    def place(self, event: EventRelation) -> int:
        """Return the position of an event in the variable order: that of its first variable."""
        return min(map(self.encoding.place, event.variables), default=0)

    def solve(self, found: Sequence[PlantState] | None = None) -> SymbolicSolution:
        """Return the controlled system.

        ``found`` are the states reached under the requirements that violate none, if known.
        """
        self._found = found
        true = self.manager.true
        good, starts = supremal(self)
        if not starts:
            return self._solution(self.manager.false, good, True)
        if good == self.plant_reach:
            reach = good
            if any(event.required != true for event in self.events):
                reach = self._forward(self._required, true)
            return self._solution(reach, good, False)
        self._permitted = self._inside(good)
        reach = self._forward(self._permitted, good)
        restricted = self._leaves(reach)
        if not restricted:
            self._permitted = self._required
        return self._solution(reach, good, restricted)

    def _solution(self, states: Bdd, good: Bdd, restricted: bool) -> SymbolicSolution:
        rounds = tuple(self._rounds)
        return SymbolicSolution(
            self, self.plant_reach, self._explored, states, good, restricted, rounds
        )

    def begin(self) -> None:
        """Explore what the plant reaches without its requirements.

        Raises:
            TooManyNodes: that takes more than it may.
        """
        self._explored = self.plant_reach
        self._most_made = math.inf

    @cached_property
    def plant_reach(self) -> Bdd:
        """The states that the plant reaches without its requirements."""
        return self._forward([event.disjuncts for event in self.events], self.manager.true)

    def reachable(self) -> Bdd:
        """Return the states that the plant reaches without its requirements.

        What it reaches under them would do as well, and can have a far larger diagram; or a far
        smaller one, so that it is tried where all that violates requirements has too many nodes.
        """
        self._explored = self.plant_reach
        if not self._invariants_first:
            return self.plant_reach
        known = self._found
        found = self._inside_invariants() if known is None else self.encoding.states(known)
        self._explored = found | self._next(self._required, found)
        return found

    def _inside_invariants(self) -> Bdd:
        """Return what the plant reaches under its requirements over states that violate none.

        An event applies those that it may come to violate, one after the other, to what it reaches:
        all of them together can have a far larger diagram. What waits for others may stand on
        either side of them in the order, so that rounds go down and up.
        """
        found, before = self.encoding.initial, self.manager.false
        down = sorted(self.events, key=self.place)
        while found != before:
            before = found
            for event in (*down, *reversed(down)):
                self._check_nodes()
                for disjunct in self._required[event.number]:
                    if not disjunct.stays:
                        found = self._closed_under(disjunct, self._touched[event.number], found)
        return found

    def _closed_under(self, disjunct: Disjunct, conditions: Sequence[Bdd], states: Bdd) -> Bdd:
        while True:
            after = self.manager.run(lambda s=states: self.relations.image(disjunct, s))  # type: ignore[misc]
            for condition in conditions:
                after = after & condition
            if after | states == states:
                return states
            states = states | after

    @cached_property
    def _touched(self) -> list[list[Bdd]]:
        """Per event, where the state requirements hold that it may come to violate: of those that
        read what it writes, not those that it never leads out of. one_tool_each 16 12."""
        holds, preimage = self.encoding.holds, self.relations.preimage
        read = [(holds(expr), support(self.plant, expr)) for expr, _ in self.plant.invariants]
        return [
            [
                condition
                for condition, of in read
                if not event.writes.isdisjoint(of)
                if any(
                    preimage(disjunct, ~condition) & condition != self.manager.false
                    for disjunct in event.disjuncts
                )
            ]
            for event in self.events
        ]

    def safe(self, states: Bdd) -> Bdd:
        if self._invariants_first:
            return states & ~self._leading_to_unsafe(states)
        return states & ~self.unsafe()

    def _leading_to_unsafe(self, states: Bdd) -> Bdd:
        """Return the states of a set that are unsafe, or that an uncontrollable event may lead to
        an unsafe state outside."""
        found = [self.leaving_range()]
        found += [states & ~self.encoding.holds(expr) for expr, _ in self.plant.invariants]
        for event in self.events:
            if not self.plant.events[event.number].controllable:
                found += [
                    self.relations.preimage(disjunct, ~condition) & states
                    for disjunct in event.disjuncts
                    for condition in self._touched[event.number]
                ]
        return self.manager.union(found)

    def controllable(self, states: Bdd, before: Bdd) -> Bdd:
        bad = before & ~states
        if bad == self.manager.false:
            return states
        left = states & ~self._uncontrollably(bad, states)
        self._rounds.append((bad, left))
        return left

    def nonblocking(self, states: Bdd) -> Bdd:
        return self._coreachable(states)

    def reaching_goals(self, states: Bdd) -> Bdd:
        whole, marked = states, self.encoding.marked & states
        for goal in self.plant.goals:
            there, along, origin = (self.encoding.holds(expr) & states for expr in goal.conditions)
            if states == whole == along and marked & ~there == self.manager.false:
                continue  # from each state a marked one is reached, and so is this
            inside = self._inside(states)
            what = "states from which all goals can be reached"
            back = self._closure(what, there, along | there, inside, self.relations.preimage)
            states = states & ~(origin & ~back)
        return states

    def same(self, states: Bdd, subset: Bdd) -> bool:
        return states == subset

    def has_start(self, states: Bdd) -> bool:
        return self.encoding.initial & states == self.encoding.initial

    def _leaves(self, states: Bdd) -> bool:
        """Whether something that the requirements allow leads out of a set."""
        return any(
            self.manager.run(lambda d=disjunct: self.relations.image(d, states) & ~states)  # type: ignore[misc]
            != self.manager.false
            for disjuncts in self._required
            for disjunct in disjuncts
            if not disjunct.stays
        )

    @property
    def required_disjuncts(self) -> tuple[Sequence[Disjunct], ...]:
        """Per event its transitions in the plant under its requirements."""
        return self._required

    @property
    def permitted(self) -> tuple[Sequence[Disjunct], ...]:
        """Per event its transitions under the supervisor, once there is one, where they lead to
        controlled states."""
        return self._permitted

    def unsafe(self) -> Bdd:
        """Return the states that violate a state requirement or leave a range, reachable or not."""
        found = [self.leaving_range()]
        found.extend(~self.encoding.holds(expr) for expr, _ in self.plant.invariants)
        while len(found) > 1:
            self._check_nodes()
            pairs = [a | b for a, b in zip(found[::2], found[1::2], strict=False)]
            found = pairs + found[len(pairs) * 2 :]
        return found[0]

    def leaving_range(self) -> Bdd:
        """Return the states in which an uncontrollable event would leave a range."""
        return self.manager.union(
            event.range_violation
            for event in self.events
            if not self.plant.events[event.number].controllable
        )

    def successors(self, states: Bdd) -> Bdd:
        """Return the image of ``states`` under one step of the plant under its requirements."""
        return self._next(self._permitted, states)

    def _next(self, disjuncts: Sequence[Sequence[Disjunct]], states: Bdd) -> Bdd:
        return self.manager.union(
            self.manager.run(lambda m=disjunct: self.relations.image(m, states))  # type: ignore[misc]
            for several in disjuncts
            for disjunct in several
            if not disjunct.stays
        )

    def required_preimage(self, event: EventRelation, states: Bdd) -> Bdd:
        """Return the preimage of ``states`` under an event of the plant under its requirements."""
        self.manager.make_room()
        return self.manager.union(
            self.relations.preimage(disjunct, states) for disjunct in self._permitted[event.number]
        )

    def longest_completion(self, states: Bdd) -> int | None:
        """Return the length of the longest sequence of internal transitions; None if unbounded.

        A greatest fixpoint: after n rounds those states are left from which n transitions can
        follow one another.
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
            self.manager.make_room()
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
        """Return the disjuncts of all events; commands only where all outcomes are in ``good``.

        Only commands whose outcome the environment chooses are restricted: any other command has
        one outcome, so intersecting the image with ``good`` suffices.
        """
        found = []
        for event, disjuncts in zip(self.events, self._required, strict=True):
            if self.plant.events[event.number].branches:
                lost = self.manager.union(self.relations.preimage(d, ~good) for d in disjuncts)
                disjuncts = _guarded(disjuncts, ~lost)
            found.append(disjuncts)
        return tuple(found)

    def guarded(self, event: EventRelation, guard: Bdd) -> Sequence[Disjunct]:
        """Return the disjuncts of a command where the requirements and its guard allow it."""
        return _guarded(self._required[event.number], guard)

    # --- fixpoints

    def _forward(self, disjuncts: Sequence[Sequence[Disjunct]], within: Bdd) -> Bdd:
        """Return all states that the disjuncts reach without leaving ``within``."""
        return self._closure(
            "reachable states", self.encoding.initial, within, disjuncts, self.relations.image
        )

    def _uncontrollably(self, bad: Bdd, good: Bdd) -> Bdd:
        """Return ``bad`` and the states of ``good`` from which uncontrollable events lead there."""
        disjuncts = [
            () if self.plant.events[event.number].controllable else event.disjuncts
            for event in self.events
        ]
        return self._closure("states to be avoided", bad, good, disjuncts, self.relations.preimage)

    def _coreachable(self, good: Bdd) -> Bdd:
        """Return the states of ``good`` from which a marked state is reached inside ``good``."""
        marked = self.encoding.marked & good
        inside = self._inside(good)
        return self._closure("nonblocking states", marked, good, inside, self.relations.preimage)

    def _check_nodes(self) -> None:
        if self._turn is not None:
            self._turn.call(self.manager.nodes)
        self.manager.make_room()
        if self._most_nodes is not None and self.manager.in_use > self._most_nodes:
            raise TooManyNodes
        if self.manager.made > self._most_made:
            raise TooManyNodes

    def _closure(
        self,
        what: str,
        states: Bdd,
        within: Bdd,
        disjuncts: Sequence[Sequence[Disjunct]],
        step: Callable[[Disjunct, Bdd], Bdd],
    ) -> Bdd:
        most, latest, again = self.encoding.most, 0, 0.0

        def report(part: Bdd, level: int) -> None:
            nonlocal latest, again
            self._check_nodes()
            # Counting takes longer than closing a small part.
            if self._progress is not None and (now := time.monotonic()) >= again:
                again = now + _SECONDS
                latest = max(latest, self.encoding.count_from(level, part))
                self._progress(what, latest, most)

        return saturated(self.manager, states, within, disjuncts, step, report)


def _guarded(disjuncts: Sequence[Disjunct], guard: Bdd) -> tuple[Disjunct, ...]:
    return tuple(replace(disjunct, relation=disjunct.relation & guard) for disjunct in disjuncts)
