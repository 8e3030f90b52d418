"""Which cases no run can show, because the plant under its supervisor excludes them.

Looked at is each state that is reached, as far as the plant knows it: its locations, phases and
finite variables. What depends on data may come out in any way, and numbers may be anything. So what
is possible here need not be possible on the robot, but what is not possible here is nowhere. For
each event it is enough what those variables are together that its cases read.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import product
from types import MappingProxyType
from typing import Any, TypeAlias

from robosc.errors import StateSpaceError
from robosc.plant.automaton import Plant, VariableKind
from robosc.synthesis.explore import explore
from robosc.synthesis.verify.state_sets import Assigned
from robosc.synthesis.verify.symbolic import reached_values
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import ExactStep, State, Steps, Unknown

Regions: TypeAlias = Mapping[Any, list[Any]]
_ALL: Regions = MappingProxyType({})
"""Where nothing is known of numbers."""
STATES, COMBINATIONS = 10000, 20000
"""So many states are looked at one by one; of a larger system, so many combinations of values."""
_KNOWN = (VariableKind.LOCATION, VariableKind.ASSUMPTION, VariableKind.PHASE)


class Unreachable:
    """Which cases it is proved of that no run shows them. A monitor's robot is under no supervisor,
    so there nothing is proved."""

    def __init__(self, coverage: Coverage) -> None:
        self._coverage = coverage
        steps = coverage.steps
        keys = _keys(steps.plant)
        numbers = {key: number for number, key in keys.items()}
        read = (coverage.reads(step) | _assigned(step) for step in steps.steps)
        groups = [frozenset(numbers[key] for key in some if key in numbers) for some in read]
        reached: Sequence[list[Assigned] | None] = [None] * len(groups)
        if not steps.follows:
            with suppress(StateSpaceError):
                reached = _reached(steps, groups)
        self._states = [
            (step, None if some is None else [_state(steps.plant, keys, one) for one in some])
            for step, some in zip(steps.steps, reached, strict=True)
        ]

    def whatever_numbers_are(self) -> frozenset[Case]:
        """Those of which locations, phases and finite variables are reason enough."""
        unknown = {step.number for step, states in self._states if states is None}
        if len(unknown) == len(self._states):
            return frozenset()
        found = {case for case in self._coverage.cases if case[1] in unknown}
        for step, states in self._states:
            found |= self._possible(step, states or ())
        return frozenset(self._coverage.cases.keys() - found)

    def with_numbers(self, cases: Collection[Case]) -> frozenset[Case]:
        """Those of some cases of which it is enough, too, where numbers lie among those with which
        the conditions of an event compare them."""
        by_number: dict[int, set[Case]] = {}
        for case in cases:
            by_number.setdefault(case[1], set()).add(case)
        found: set[Case] = set()
        for step, states in self._states:
            wanted = by_number.get(step.number)
            if wanted and states:
                few = _few(self._coverage.regions(step), COMBINATIONS // len(states))
                if few:
                    found |= wanted - self._possible(step, states, few)
        return frozenset(found)

    def _possible(
        self,
        step: ExactStep,
        states: Iterable[State],
        regions: Regions = _ALL,
    ) -> set[Case]:
        """What may show in some states, with some values of numbers."""
        found: set[Case] = set()
        values = [Unknown(zip(regions, each, strict=True)) for each in product(*regions.values())]
        for state in filter(step.in_phase, states):
            for some in values:  # the names of variables are texts, those of parts are paths
                found |= self._coverage.possible(step, state | some, some)
        return found


def _few(regions: Mapping[Any, list[Any]], most: int) -> dict[Any, list[Any]]:
    """Those with the fewest values, of which there are not too many combinations."""
    found: dict[Any, list[Any]] = {}
    for key, values in sorted(regions.items(), key=lambda one: len(one[1])):
        if math.prod(map(len, found.values())) * len(values) <= most:
            found[key] = values
    return found


def _reached(steps: Steps, groups: list[frozenset[int]]) -> Sequence[list[Assigned] | None]:
    """The values that each group of variables has in some state under the supervisor; None: they
    are too many.

    Raises:
        StateSpaceError: the system is too large.
    """
    try:
        states = explore(steps.supervisor, STATES).states
    except StateSpaceError:
        return reached_values(steps.supervisor, groups, COMBINATIONS)
    return [
        list(dict.fromkeys(tuple((n, state[n]) for n in group) for state in states))
        for group in groups
    ]


def _assigned(step: ExactStep) -> set[str]:
    """The variables that an event may change."""
    edges = (edge for p in step.partners for several in p.edges.values() for edge in several)
    return {key for edge in edges for key, *_ in edge.assigned}


def _keys(plant: Plant) -> dict[int, str]:
    """By number, the variables of which a state of the plant tells the value."""
    return {
        number: f"~{variable.name}" if variable.kind is VariableKind.PHASE else variable.name
        for number, variable in enumerate(plant.variables)
        if variable.kind in _KNOWN or isinstance(variable.values, tuple | range)
    }


def _state(plant: Plant, keys: dict[int, str], assigned: Assigned) -> State:
    """What some variables are, as a state of the robot tells it."""
    found: State = {}
    for number, index in assigned:
        variable = plant.variables[number]
        value = variable.values[index]
        found[keys[number]] = str(value) if variable.kind in _KNOWN else value
    return found
