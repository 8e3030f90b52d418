"""States that are bad by themselves, and the shortest ways to them.

A state is bad by itself if a state requirement fails in it, if an event that no controller prevents
takes a variable out of its range, or if no marked state, or not what must remain possible, can be
reached from it whatever the controller does. All other states that must be avoided are so because
of these. A way to one is found by walking backward from all of them, ring by ring, so that one
search serves all that is to be explained.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Literal, Protocol, TypeAlias

from robosc import limits
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Plant, PlantState
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.explicit.explicit_engine import (
    EventOutcomes,
    Outcomes,
    changed,
    possible_events,
)
from robosc.synthesis.time_limit import ExplanationTime


@dataclass(frozen=True, slots=True)
class Round:
    """States that synthesis removed in a round: those ``lost`` in it, or all of ``earlier`` ones.

    In the first round those are lost that violate a requirement or leave a range, in each other one
    those from which a marked state, or a goal, can no longer be reached; states from which
    uncontrollable events lead to these are removed in the same round.
    """

    number: int
    part: Literal["lost", "earlier"]


Fault: TypeAlias = Literal["requirement", "range", "blocked"] | int
"""What is wrong with a state; a number is the index in ``Plant.goals`` of what is out of reach."""
Faults: TypeAlias = tuple[Fault, ...]
_CHECKED = 2**6
"""States between two looks at the time: one may take longer than a state."""
UNSAFE: Faults = ("requirement", "range")


class FaultSearch(Protocol):
    """Where the states are that are bad by themselves. All functions may raise TimeIsUp."""

    def way(
        self, start: PlantState, to: Faults | Round, forced: bool
    ) -> tuple[PlantState, ...] | None:
        """Return a shortest way from a state that is not good to one with one of the faults, or of
        a round.

        It consists of events that the requirements allow, with ``forced`` of uncontrollable ones.
        None: there is none, or it is unknown.
        """

    def has(self, state: PlantState, fault: Fault) -> bool:
        """Whether a state at the end of a way has a fault."""

    def round_of(self, state: PlantState) -> int | None:
        """Return the number of the round in which a state was removed, if that is known."""

    def values_beyond(self, state: PlantState) -> Sequence[frozenset[int]]:
        """Return the indexes of values that each state variable may still have after a state in
        which the plant is blocked, that one included."""


def way_through_rounds(search: FaultSearch, start: PlantState) -> Iterator[PlantState]:
    """Yield the states on a way along which each one shows why those before it were removed.

    It goes by uncontrollable events to a state that was lost, from there to one that was removed in
    an earlier round, since all ways back pass through these, and so on.
    """
    yield start
    number = search.round_of(start)
    while number is not None:
        for to, forced in (Round(number, "lost"), True), (Round(number, "earlier"), False):
            way = search.way(start, to, forced)
            if way is None:
                return
            yield from way[1:]
            start = way[-1]
        number = search.round_of(start)


class ExplicitFaults:
    """A search state by state, through those that must be avoided; what was seen is kept."""

    def __init__(
        self, stepper: Stepper, is_good: Callable[[PlantState], bool], time: ExplanationTime
    ) -> None:
        plant = stepper.plant
        self._plant: Plant = plant
        self._is_good = is_good
        self._time = time
        events = stepper.required()
        self._is_whole = not any(event.is_sampled for event in events)
        sampled = (replace(e, values=tuple(e.some_values)) if e.is_sampled else e for e in events)
        self._possible = possible_events(
            plant, [EventOutcomes(plant.events[e.number], e, plant) for e in sampled]
        )
        self._is_safe = stepper.every(condition for condition, _ in plant.invariants)
        self._goals = [tuple(map(stepper.test, goal.conditions)) for goal in plant.goals]
        self._numbers: dict[PlantState, int] = {}
        self._states: list[PlantState] = []
        self._after: list[tuple[list[int], list[int]]] = []
        """Per state, where uncontrollable events and where all events lead, in their order."""
        self._leaving: set[int] = set()
        """States in which an uncontrollable event takes a variable out of its range."""
        self._failing: set[int] = set()
        """States in which a state requirement fails."""
        self._ending: set[int] = set()
        """States that are marked, or from which an event leads to a good state, or to what is not
        searched any more."""
        self._returning: list[set[int]] = [set() for _ in self._goals]
        """Per goal, states on the way from which it is reached by way of a good state, or that are
        not searched any more."""
        self._distances: dict[tuple[Faults | Round, bool], tuple[int, dict[int, int]]] = {}
        self._coming: dict[Fault, tuple[int, set[int]]] = {}
        self._rounds: tuple[int, list[tuple[set[int], set[int]]]] = -1, []

    def way(
        self, start: PlantState, to: Faults | Round, forced: bool
    ) -> tuple[PlantState, ...] | None:
        if not isinstance(to, Round) and "requirement" in to and self.has(start, "requirement"):
            return (start,)  # what may follow need not be searched
        number = self._known(start)
        distances = self._distances_to(to, forced)
        if number not in distances:
            return None
        path = [number]
        while distances[path[-1]]:
            after = self._after[path[-1]][0 if forced else 1]
            path.append(next(n for n in after if distances.get(n) == distances[path[-1]] - 1))
        return tuple(self._states[n] for n in path)

    def has(self, state: PlantState, fault: Fault) -> bool:
        if fault == "requirement":
            return not self._is_safe(state)
        return self._has(self._known(state), fault)

    def _has(self, number: int, fault: Fault) -> bool:
        match fault:
            case "requirement":
                return number in self._failing
            case "range":
                return number in self._leaving
            case "blocked":
                return self._is_whole and number not in self._leading_back(fault)
        there, _, origin = self._goals[fault]
        state = self._states[number]
        return (
            self._is_whole
            and origin(state)
            and not there(state)
            and number not in self._leading_back(fault)
        )

    def round_of(self, state: PlantState) -> int | None:
        number = self._known(state)
        rounds = (n for n, (_, removed) in enumerate(self._all_rounds()) if number in removed)
        return next(rounds, None)

    def values_beyond(self, state: PlantState) -> Sequence[frozenset[int]]:
        reached = {self._known(state): None}
        left = list(reached)
        for number in left:  # appended to below
            new = [n for n in self._after[number][1] if n not in reached]
            reached.update(dict.fromkeys(new))
            left += new
        columns = zip(*(self._states[number] for number in left), strict=True)
        return [frozenset(column) for column in columns]

    def _distances_to(self, to: Faults | Round, forced: bool) -> dict[int, int]:
        """Return for each state from which one of some is reached how far that is."""
        size, distances = self._distances.get((to, forced), (-1, {}))
        if size != len(self._states):
            distances = self._backward(self._at(to), 0 if forced else 1)
            self._distances[to, forced] = len(self._states), distances
        return distances

    def _at(self, to: Faults | Round) -> Iterable[int]:
        if isinstance(to, Round):
            rounds = self._all_rounds()
            if to.part == "lost":
                return rounds[to.number][0]
            return set().union(*(removed for _, removed in rounds[: to.number]))
        return (
            number
            for number in range(len(self._states))
            if any(self._has(number, fault) for fault in to)
        )

    def _backward(
        self, to: Iterable[int], which: int, within: Collection[int] | None = None
    ) -> dict[int, int]:
        """Return the distances to some states, breadth first."""
        distances = dict.fromkeys(to, 0)
        before = self._before(which)
        left = list(distances)
        for number in left:  # appended to below
            for other in before[number]:
                if other not in distances and (within is None or other in within):
                    distances[other] = distances[number] + 1
                    left.append(other)
        return distances

    def _all_rounds(self) -> list[tuple[set[int], set[int]]]:
        """Return what is lost and what is removed in each round of synthesis, but for goals."""
        size, rounds = self._rounds
        if size == len(self._states):
            return rounds
        left = set(range(len(self._states)))
        lost = {n for n in left if any(self._has(n, fault) for fault in UNSAFE)}
        rounds = []
        while lost or not rounds:
            self._time.check()
            removed = set(self._backward(lost, 0, left))
            rounds.append((lost, removed))
            left -= removed
            lost = left - set(self._backward(self._ending & left, 1, left))
        self._rounds = len(self._states), rounds
        return rounds

    def _leading_back(self, fault: Fault) -> set[int]:
        """Return the states from which a marked state, or a goal, is reached."""
        size, found = self._coming.get(fault, (-1, set()))
        if size == len(self._states):
            return found
        there, along = self._ending, None
        if isinstance(fault, int):
            ends, way, _ = self._goals[fault]
            there, along = ({n for n, s in enumerate(self._states) if t(s)} for t in (ends, way))
            there |= self._returning[fault]
        found = set(self._backward(there, 1, along))
        self._coming[fault] = len(self._states), found
        return found

    def _before(self, which: int) -> list[list[int]]:
        before: list[list[int]] = [[] for _ in self._states]
        for number, after in enumerate(self._after):
            for target in after[which]:
                before[target].append(number)
        return before

    def _known(self, state: PlantState) -> int:
        """Return the number of a state, after a search of all that follows."""
        if state not in self._numbers:
            self._number(state)
            for number in range(len(self._after), limits.FAULT_STATES):
                if number == len(self._states):
                    break
                if not number % _CHECKED:
                    self._time.check()
                self._expand(number)
            else:
                self._time.give_up()
        return self._numbers[state]

    def _number(self, state: PlantState) -> int:
        number = self._numbers.setdefault(state, len(self._states))
        if number == len(self._states):
            self._states.append(state)
        return number

    def _expand(self, number: int) -> None:
        forced: dict[int, None] = {}
        after: dict[int, None] = {}
        state = self._states[number]
        if not self._is_safe(state):
            self._failing.add(number)
            if len(self._states) > limits.FAULT_SURROUNDINGS:
                for ending in (self._ending, *self._returning):
                    ending.add(number)
                self._after.append(([], []))
                return
        if self._plant.is_marked(state):
            self._ending.add(number)
        for event, outcomes in self._outcomes(state):
            controllable = event.event.controllable
            if outcomes.leaves and not controllable:
                self._leaving.add(number)
            for change in outcomes.changes:
                target = changed(state, change)
                if self._is_good(target):
                    self._ending.add(number)
                    for goal, returning in enumerate(self._returning):
                        if number not in returning and self._comes_by(goal, state, target):
                            returning.add(number)
                    continue
                after[self._number(target)] = None
                if not controllable:
                    forced[self._number(target)] = None
        self._after.append((list(forced), list(after)))

    def _outcomes(self, state: PlantState) -> Iterator[tuple[EventOutcomes, Outcomes]]:
        """Yield the events that the requirements allow in a state."""
        for event, outcomes in self._possible(state):
            if event.test is None or event.test(state):
                yield event, outcomes

    def _comes_by(self, goal: int, state: PlantState, after: PlantState) -> bool:
        """Whether a goal is reached from a state by a step to one that is good."""
        there, along, origin = self._goals[goal]
        if not along(state):
            return False
        way, seen = [after], {after}
        for number, here in enumerate(way):  # appended to below
            if there(here) or (origin(here) and self._is_good(here)):
                return True
            if not number % _CHECKED:
                self._time.check()
            if number == limits.FAULT_STATES:
                self._time.give_up()
            for _, outcomes in self._outcomes(here) if along(here) else ():
                new = {changed(here, change) for change in outcomes.changes} - seen
                seen |= new
                way += new
        return False
