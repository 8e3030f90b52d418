"""Projection of state variables that depend on each other to one dimension of the state array.

A component often mirrors the phase of its service, and then half of the combinations of the two
never occur. For a group of state variables, the reachable combinations are over-approximated by the
projection of the plant to the group: conditions on other state variables are assumed to hold. The
result is closed under every event of the plant, so it contains the combination of every reachable
state, and the others need no memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from robosc.plant.automaton import Plant
from robosc.synthesis.dense.bitset import Bitset, count, places
from robosc.synthesis.dense.dimensions import Dim
from robosc.synthesis.dense.images import Stages, forward, image
from robosc.synthesis.dense.layout import Layout
from robosc.synthesis.dense.merging import Condition, EventRules, TransitionRule
from robosc.synthesis.dense.operations import sweep_order

_LARGEST_LOOK = 2**14
"""Combinations above which a group is not projected."""
_LARGEST_DIM = 256
"""Positions above which dimensions are not joined."""
_MOST_PAIRS = 20_000
"""Pairs of state variables above which none is projected: it would take minutes."""
_WORTH = 0.75
"""Largest share of combinations left for which to join: long dimensions need more operations."""


def projected_layout(plant: Plant, rules: Sequence[EventRules]) -> Layout:
    """Return the layout of a plant with dependent state variables in common dimensions.

    The size of the layout determines the memory of the engine; ``max_states`` limits it.
    """
    projector = _Projector(plant, rules)
    projector.reduce_variables()
    projector.merge()
    return Layout(plant, sorted(projector.dims(), key=lambda dim: dim.variables[0]))


class _Projector:
    def __init__(self, plant: Plant, rules: Sequence[EventRules]) -> None:
        self.plant = plant
        self.rules = rules
        self.written = [_written(event) for event in rules]
        self.touched = [
            written | _read(event) for event, written in zip(rules, self.written, strict=True)
        ]
        # Computed once, since there are many groups and many events.
        self.writers: dict[int, list[int]] = {}
        for number, written in enumerate(self.written):
            for variable in written:
                self.writers.setdefault(variable, []).append(number)
        self.dim_of = {
            number: Dim((number,), np.arange(variable.size).reshape(-1, 1))
            for number, variable in enumerate(plant.variables)
        }

    def dims(self) -> list[Dim]:
        return list(dict.fromkeys(self.dim_of.values()))

    def reduce_variables(self) -> None:
        """Drop the values that a state variable never has."""
        for variable, dim in self.dim_of.items():
            if 1 < dim.size <= _LARGEST_LOOK:
                self.dim_of[variable] = self._reached([dim])

    def merge(self) -> None:
        """Join pairs of dimensions, the most dependent first, while that saves enough."""
        ranked = []
        for first, second in sorted(self._related()):
            one, other = self.dim_of[first], self.dim_of[second]
            if min(one.size, other.size) > 1 and one.size * other.size <= _LARGEST_LOOK:
                ratio = self._reached([one, other]).size / (one.size * other.size)
                if ratio <= _WORTH:
                    ranked.append((ratio, first, second))
        for _, first, second in sorted(ranked):
            one, other = self.dim_of[first], self.dim_of[second]
            most = one.size * other.size
            if one is other or most > _LARGEST_LOOK:
                continue
            joint = self._reached([one, other])
            if joint.size <= _LARGEST_DIM and joint.size <= _WORTH * most:
                self.dim_of.update(dict.fromkeys(joint.variables, joint))

    def _related(self) -> set[tuple[int, int]]:
        """Return pairs of variables of which an event writes one and reads or writes the other.

        Empty if there are too many: one event may assign thousands of variables.
        """
        pairs: set[tuple[int, int]] = set()
        for written, touched in zip(self.written, self.touched, strict=True):
            for a in written:
                pairs.update((min(a, b), max(a, b)) for b in touched if a != b)
                if len(pairs) > _MOST_PAIRS:
                    return set()
        return pairs

    def _reached(self, dims: Sequence[Dim]) -> Dim:
        """Return the combinations of some dimensions that can occur, as one dimension."""
        variables = tuple(sorted(variable for dim in dims for variable in dim.variables))
        layout = Layout(self.plant, dims)
        numbers = sorted(
            {number for variable in variables for number in self.writers.get(variable, ())}
        )
        events = [self._projected(self.rules[number], layout, set(variables)) for number in numbers]
        states = layout.of(layout.starts())
        between = layout.nothing()
        before, now = 0, count(states)
        while before != now < layout.size:
            for stages in events:
                _apply(stages, states, between)
            before, now = now, count(states)
        columns = layout.columns(places(states | between))
        return Dim(variables, np.stack([columns[variable] for variable in variables], axis=1))

    def _projected(self, event: EventRules, layout: Layout, variables: set[int]) -> Stages:
        return tuple(
            sweep_order(
                op for rule in _distinct(stage, variables) for op in layout.operations(rule)
            )
            for stage in event.stages
        )


def _apply(stages: Stages, states: Bitset, between: Bitset) -> None:
    """Add the image of an event to ``states``, and the states between its stages to ``between``."""
    if len(stages) == 1:
        for op in stages[0]:
            forward(op, states, states, None)
        return
    after = states
    for stage in stages:
        after = image([stage], after)
        np.bitwise_or(between, after, out=between)
    np.bitwise_or(states, after, out=states)


def _distinct(stage: Iterable[TransitionRule], variables: set[int]) -> list[TransitionRule]:
    """Return the distinct projections of rules to some state variables."""
    found: dict[tuple[object, ...], TransitionRule] = {}
    for rule in stage:
        condition = Condition(
            {
                variable: values
                for variable, values in rule.condition.allowed.items()
                if variable in variables
            },
            tuple(
                factor
                for factor in rule.condition.factors
                if variables.issuperset(factor.variables)
            ),
        )
        writes = {
            variable: write for variable, write in rule.writes.items() if variable in variables
        }
        found[condition.key(), tuple(sorted(writes.items()))] = TransitionRule(condition, writes)
    return list(found.values())


def _written(event: EventRules) -> set[int]:
    return {variable for stage in event.stages for rule in stage for variable in rule.writes}


def _read(event: EventRules) -> set[int]:
    conditions = [rule.condition for stage in event.stages for rule in stage]
    return {variable for condition in conditions for variable in condition.allowed} | {
        variable
        for condition in conditions
        for factor in condition.factors
        for variable in factor.variables
    }
