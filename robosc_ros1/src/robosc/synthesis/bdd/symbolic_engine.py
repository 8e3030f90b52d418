"""The symbolic engine: sets of states as decision diagrams, for products too large for arrays.

The fixpoint is that of :mod:`robosc.synthesis.fixpoint`, over the states that the plant can reach;
least fixpoints in it are computed by saturation (:mod:`robosc.synthesis.bdd.saturation`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from robosc import limits
from robosc.language.events import EventKind
from robosc.plant.automaton import Plant
from robosc.progress import Progress
from robosc.synthesis.bdd.encoding import Encoding
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import MOST_DISJUNCTS, Disjunct, EventRelation, Relations
from robosc.synthesis.bdd.saturation import saturated
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.fixpoint import supremal


class TooManyNodes(Exception):
    """The search takes more nodes than it may; another order of the variables may do with fewer."""


_SECONDS = 0.05
"""Between two reports of progress."""


@dataclass(frozen=True, eq=False)
class SymbolicSolution:
    """The controlled system: ``states`` are those reached under control.

    ``good`` is the supremal safe, controllable and nonblocking set. If it does not contain the
    initial states, ``states`` is empty, and ``good`` is an intermediate set of the fixpoint, enough
    to explain the loss of an initial state by uncontrollable events. ``plant_reach`` is what the
    plant reaches without its requirements. ``restricted`` says whether something is forbidden
    beyond the requirements.
    """

    engine: SymbolicEngine
    plant_reach: Bdd
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

    @property
    def controlled_transitions(self) -> int:
        """The number of triples (state, event, values), self-loops included."""
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
    ) -> None:
        self.plant = plant
        self._most_nodes = most_nodes
        self.encoding = Encoding(plant, memory, reverse)
        self.manager = self.encoding.manager
        self.relations = Relations(self.encoding, most_disjuncts)
        self.events = self.relations.events
        self._required = tuple(_guarded(event.disjuncts, event.required) for event in self.events)
        self._permitted: tuple[Sequence[Disjunct], ...] = self._required
        self._progress = progress
        self._plant_reach = self.manager.false
        self._rounds: list[tuple[Bdd, Bdd]] = []

    def place(self, event: EventRelation) -> int:
        """Return the position of an event in the variable order: that of its first variable."""
        return min(map(self.encoding.place, event.variables), default=0)

    def solve(self) -> SymbolicSolution:
        """Return the controlled system."""
        true = self.manager.true
        good, starts = supremal(self)
        plant_reach = self._plant_reach
        if not starts:
            none, rounds = self.manager.false, tuple(self._rounds)
            return SymbolicSolution(self, plant_reach, none, good, True, rounds)
        if good == plant_reach:
            reach = plant_reach
            if any(event.required != true for event in self.events):
                reach = self._forward(self._required, true)
            return SymbolicSolution(self, plant_reach, reach, good, False)
        self._permitted = self._inside(good)
        reach = self._forward(self._permitted, good)
        restricted = self._leaves(reach)
        if not restricted:
            self._permitted = self._required
        rounds = tuple(self._rounds)
        return SymbolicSolution(self, plant_reach, reach, good, restricted, rounds)

    def reachable(self) -> Bdd:
        """Return the states that the plant reaches without its requirements.

        What it reaches under them would do as well, and can have a far larger diagram.
        """
        self._plant_reach = self._forward(
            [event.disjuncts for event in self.events], self.manager.true
        )
        return self._plant_reach

    def safe(self, states: Bdd) -> Bdd:
        return states & ~self.unsafe()

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
        for goal in self.plant.goals:
            there, along, origin = (self.encoding.holds(expr) & states for expr in goal.conditions)
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

    def unsafe(self) -> Bdd:
        """Return the states that violate a state requirement or leave a range, reachable or not."""
        found = [self.leaving_range()]
        found.extend(~self.encoding.holds(expr) for expr, _ in self.plant.invariants)
        return self.manager.union(found)

    def leaving_range(self) -> Bdd:
        """Return the states in which an uncontrollable event would leave a range."""
        return self.manager.union(
            event.range_violation
            for event in self.events
            if not self.plant.events[event.number].controllable
        )

    def successors(self, states: Bdd) -> Bdd:
        """Return the image of ``states`` under one step of the plant under its requirements."""
        return self.manager.union(
            self.manager.run(lambda m=disjunct: self.relations.image(m, states))  # type: ignore[misc]
            for disjuncts in self._permitted
            for disjunct in disjuncts
            if not disjunct.stays
        )

    def required_preimage(self, event: EventRelation, states: Bdd) -> Bdd:
        """Return the preimage of ``states`` under an event of the plant under its requirements."""
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
            if self._most_nodes is not None and self.manager.nodes > self._most_nodes:
                raise TooManyNodes
            # Counting takes longer than closing a small part.
            if self._progress is not None and (now := time.monotonic()) >= again:
                again = now + _SECONDS
                latest = max(latest, self.encoding.count_from(level, part))
                self._progress(what, latest, most)

        return saturated(self.manager, states, within, disjuncts, step, report)


def _guarded(disjuncts: Sequence[Disjunct], guard: Bdd) -> tuple[Disjunct, ...]:
    return tuple(replace(disjunct, relation=disjunct.relation & guard) for disjunct in disjuncts)
