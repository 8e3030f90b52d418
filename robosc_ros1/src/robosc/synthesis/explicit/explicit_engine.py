"""The explicit engine: the states that the plant reaches, and the fixpoint over their numbers.

A state that violates a requirement is not kept, only that a step leads to one: what follows is of
no interest, and there may be ten times as many as others. The states that the plant reaches without
its requirements are only counted, and that in independent parts, which are few where the
requirements alone hold things together.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import count
from math import prod
from operator import itemgetter
from typing import TypeAlias

from robosc.errors import StateSpaceError
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.step import Verdict
from robosc.plant.support import step_support
from robosc.synthesis.compiled_steps import CompiledEvent, Stepper, Test
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.fixpoint import supremal

_States: TypeAlias = set[int]
_UNSAFE = -1
"""The number of all states that violate a requirement, but initial ones."""
_FEW = 2**12
"""Combinations of what several events read up to which these are looked up together."""
_REPORTED = 2**6
"""States between two questions whether to go on."""
_MOST_VALUES = 2**16
"""Combinations of one event's parameter values that are tried in each state."""


class TooMany(StateSpaceError):
    """There are more states than the explicit engine may visit."""


class ManyGuarded(TooMany):
    """Commands are restricted in more states than guards are made of one by one.

    ``states`` are those that are reached under the requirements and violate none.
    """

    def __init__(self, states: Sequence[PlantState]) -> None:
        super().__init__("there are too many states for guards from single ones")
        self.states = states


Limit: TypeAlias = Callable[[int, int, int], None]
"""Called with how many states were found, how many of them are to be left yet, and how many steps
were taken; may raise TooMany."""


@dataclass(frozen=True, slots=True)
class Outcomes:
    """Where an event leads from a state: per outcome the new values of variables that change.

    ``number`` is how many values of the event have an outcome; ``leaves``: with another one, a
    variable would leave its range.
    """

    changes: tuple[tuple[tuple[int, int], ...], ...]
    number: int
    leaves: bool


class EventOutcomes:
    """The outcomes of an event, computed once for all states that are alike in what it reads."""

    def __init__(self, event: Event, compiled: CompiledEvent, plant: Plant) -> None:
        self.event = event
        self.number = compiled.number
        self.test = compiled.test
        self._compiled = compiled
        read = sorted(step_support(plant, event) | event.writes)
        self.read = frozenset(read)
        self._key = _projection(read)
        self._known: dict[object, Outcomes] = {}

    def of(self, state: PlantState) -> Outcomes:
        key = self._key(state)
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self._computed(state)
        return found

    def number_in(self, states: Iterable[PlantState]) -> int:
        """Return how many steps by the event leave states that were visited."""
        alike = Counter(map(self._key, states))
        return sum(times * self._known[key].number for key, times in alike.items())

    def _computed(self, state: PlantState) -> Outcomes:
        changes: dict[tuple[tuple[int, int], ...], None] = {}
        number, leaves = 0, False
        for values in self._compiled.values:
            after = self._compiled.step(state, values)
            if isinstance(after, Verdict):
                leaves = leaves or after is Verdict.OUT_OF_RANGE
            else:
                number += 1
                pairs = enumerate(zip(state, after, strict=True))
                changes[tuple((n, new) for n, (old, new) in pairs if old != new)] = None
        return Outcomes(tuple(changes), number, leaves)


_Projection: TypeAlias = Callable[[PlantState], object]
_Possible: TypeAlias = list[tuple[EventOutcomes, Outcomes]]


def _projection(variables: Sequence[int]) -> _Projection:
    return itemgetter(*variables) if variables else lambda state: ()


def possible_events(
    plant: Plant, events: Sequence[EventOutcomes]
) -> Callable[[PlantState], Iterator[tuple[EventOutcomes, Outcomes]]]:
    """Return what gives the events that are possible in a state of the plant, with their outcomes.

    Events that read the same few variables are looked up together.
    """
    groups: list[tuple[frozenset[int], list[EventOutcomes]]] = []
    for event in events:
        together = groups[-1][0] | event.read if groups else event.read
        if groups and prod(plant.sizes(together)) <= max(_FEW, prod(plant.sizes(event.read))):
            groups[-1] = together, [*groups[-1][1], event]
        else:
            groups.append((event.read, [event]))
    known: list[tuple[_Projection, list[EventOutcomes], dict[object, _Possible]]] = [
        (_projection(sorted(read)), some, {}) for read, some in groups
    ]

    def possible(state: PlantState) -> Iterator[tuple[EventOutcomes, Outcomes]]:
        for projection, some, seen in known:
            key = projection(state)
            found = seen.get(key)
            if found is None:
                every = ((event, event.of(state)) for event in some)
                found = seen[key] = [(e, o) for e, o in every if o.changes or o.leaves]
            yield from found

    return possible


def changed(state: PlantState, change: Iterable[tuple[int, int]]) -> PlantState:
    """Return the state with the new values of some variables."""
    after = list(state)
    for variable, value in change:
        after[variable] = value
    return tuple(after)


_STEPS = 2**14
"""Steps after which the limit is asked at the latest."""


class ReachedStates:
    """The states that a plant reaches by some events, numbered in breadth-first order.

    ``after`` are the steps from each state, as pairs of the event's number and the target; a
    negative target is not ``safe``. ``unsafe`` are those that are not, or that something
    uncontrollable takes to such a state or out of a range.
    """

    def __init__(self, plant: Plant, events: Sequence[EventOutcomes], safe: Test) -> None:
        self.states = list(plant.initial_states)
        self.starts = len(self.states)
        self.numbers = {state: number for number, state in enumerate(self.states)}
        self.after: list[tuple[tuple[int, int], ...]] = []
        self.unsafe: _States = set()
        self._possible = possible_events(plant, events)
        self._safe = safe
        self._steps = 0

    def search(self, limit: Limit) -> None:
        """Find all states, from where a search ended before; states that are not safe are not left.

        Raises:
            TooMany: by ``limit``.
        """
        states, numbers, safe, possible = self.states, self.numbers, self._safe, self._possible
        steps = due = self._steps
        for number in count(len(self.after)):
            if not number % _REPORTED or steps >= due or number == len(states):
                due, self._steps = steps + _STEPS, steps
                limit(len(states), len(states) - number, steps)
            if number == len(states):
                return
            state = states[number]
            after: list[tuple[int, int]] = []
            if number < self.starts and not safe(state):
                self.unsafe.add(number)
                self.after.append(())
                continue
            for event, outcomes in possible(state):
                steps += 1
                if event.test is not None and not event.test(state):
                    continue
                lost = outcomes.leaves
                for change in outcomes.changes:
                    target = changed(state, change)
                    place = numbers.get(target)
                    if place is None:
                        place = numbers[target] = len(states) if safe(target) else _UNSAFE
                        if place != _UNSAFE:
                            states.append(target)
                    lost = lost or place == _UNSAFE
                    after.append((event.number, place))
                if lost and not event.event.controllable:
                    self.unsafe.add(number)
            steps += len(after)
            self.after.append(tuple(after))


def outcomes_of(plant: Plant, stepper: Stepper, required: bool) -> list[EventOutcomes]:
    """Return the outcomes of all events of a plant, under its requirements or without them.

    Raises:
        TooMany: an event has too many values.
    """
    found = []
    for number, event in enumerate(plant.events):
        compiled = stepper.compiled(number, event.requirement if required else None)
        if weight(event) > _MOST_VALUES:
            raise TooMany(
                f"the explicit engine would have to try {weight(event)} values of {event.name}"
            )
        found.append(EventOutcomes(event, compiled, plant))
    return found


@dataclass(frozen=True, eq=False)
class ExplicitSolution:
    """The controlled system: numbers of states reached under control (``states``).

    ``good`` is the supremal safe, controllable and nonblocking set, or if it does not contain the
    initial states an intermediate set; ``states`` is empty then.
    """

    engine: ExplicitEngine
    states: frozenset[int]
    good: frozenset[int]
    empty: bool

    @property
    def restricted(self) -> bool:
        """Whether synthesis forbids anything that the requirements allow."""
        after = self.engine.found.after
        return any(t not in self.states for number in self.states for _, t in after[number])

    @cached_property
    def keeping(self) -> Mapping[int, Collection[int]]:
        """Per event the controlled states from which it leads to a good one."""
        found: dict[int, set[int]] = defaultdict(set)
        for number in self.states:
            for event, target in self.engine.found.after[number]:
                if target in self.good:
                    found[event].add(number)
        return found


class ExplicitEngine:
    """Synthesis over the states that are reached; the sets of :mod:`robosc.synthesis.fixpoint`."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.stepper = Stepper(plant)
        self.events = outcomes_of(plant, self.stepper, True)
        safe = self.stepper.every(condition for condition, _ in plant.invariants)
        self.found = ReachedStates(plant, self.events, safe)

    @cached_property
    def _before(self) -> list[list[int]]:
        return self._sources(lambda event: not event.branches)

    @cached_property
    def _uncontrolled(self) -> list[list[int]]:
        return self._sources(lambda event: not event.controllable)

    @cached_property
    def _branching(self) -> list[tuple[int, int, list[int]]]:
        return [
            (number, event, [t for e, t in after if e == event])
            for event in (n for n, one in enumerate(self.plant.events) if one.branches)
            for number, after in enumerate(self.found.after)
            if any(e == event for e, _ in after)
        ]

    def _sources(self, which: Callable[[Event], bool]) -> list[list[int]]:
        chosen = {number for number, event in enumerate(self.plant.events) if which(event)}
        before: list[list[int]] = [[] for _ in self.found.states]
        for number, after in enumerate(self.found.after):
            for event, target in after:
                if event in chosen and target != _UNSAFE:
                    before[target].append(number)
        return before

    def solve(self, limit: Limit) -> ExplicitSolution:
        """Return the controlled system; the search goes on where a limit ended it before.

        Raises:
            TooMany: by ``limit``.
        """
        self.found.search(limit)
        return self._solution

    @cached_property
    def _solution(self) -> ExplicitSolution:
        good, starts = supremal(self)
        if not starts:
            return ExplicitSolution(self, frozenset(), frozenset(good), True)
        refused = self.refused(good)
        states = set(range(self.found.starts))
        left = list(states)
        for number in left:  # appended to below
            for event, target in self.found.after[number]:
                if target in good and target not in states and (number, event) not in refused:
                    states.add(target)
                    left.append(target)
        return ExplicitSolution(self, frozenset(states), frozenset(good), False)

    def refused(self, good: _States | frozenset[int]) -> set[tuple[int, int]]:
        """Return states and commands in them of which some outcome is not good."""
        return {
            (number, event)
            for number, event, targets in self._branching
            if not good.issuperset(targets)
        }

    # --- the fixpoint

    def reachable(self) -> _States:
        return set(range(len(self.found.states)))

    def safe(self, states: _States) -> _States:
        return states - self.found.unsafe

    def controllable(self, states: _States, before: _States) -> _States:
        bad = before - states
        return states - self._leading(bad, self._uncontrolled, states) if bad else states

    def nonblocking(self, states: _States) -> _States:
        is_marked, all_states = self.plant.is_marked, self.found.states
        return self._coreachable({n for n in states if is_marked(all_states[n])}, states, states)

    def reaching_goals(self, states: _States) -> _States:
        for goal in self.plant.goals:
            there, along, origin = (
                {n for n in states if test(self.found.states[n])}
                for test in map(self.stepper.test, goal.conditions)
            )
            states = states - (origin - self._coreachable(there, along, states))
        return states

    def same(self, states: _States, subset: _States) -> bool:
        return len(states) == len(subset)

    def has_start(self, states: _States) -> bool:
        return states.issuperset(range(self.found.starts))

    def _coreachable(self, targets: _States, along: _States, inside: _States) -> _States:
        """Return the states from which targets are reached on states ``along``, under control."""
        refused = self.refused(inside)
        before = self._before
        if self._branching:
            before = [list(sources) for sources in before]
            for number, event, after in self._branching:
                if (number, event) not in refused:
                    for target in after:
                        before[target].append(number)
        return self._leading(targets, before, along)

    @staticmethod
    def _leading(to: _States, before: Sequence[Sequence[int]], within: _States) -> _States:
        """Return some states, and those from which they are reached on states ``within``."""
        found = set(to)
        left = list(to)
        while left:
            for number in before[left.pop()]:
                if number in within and number not in found:
                    found.add(number)
                    left.append(number)
        return found
