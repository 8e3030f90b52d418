"""Which cases no run can show, because the plant under its supervisor excludes them.

Looked at is each state that is reached, as far as the plant knows it: its locations, phases and
finite variables. What depends on numbers or on data may come out in any way. So what is possible
here need not be possible on the robot, but what is not possible here is nowhere. For each event it
is enough what those variables are together that its cases read.
"""

from __future__ import annotations

from collections.abc import Sequence

from robosc.errors import StateSpaceError
from robosc.plant.automaton import Plant, VariableKind
from robosc.synthesis.explore import explore
from robosc.synthesis.verify.state_sets import Assigned
from robosc.synthesis.verify.symbolic import reached_values
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import ExactStep, State, Steps

STATES, COMBINATIONS = 10000, 20000
"""So many states are looked at one by one; of a larger system, so many combinations of values."""
_KNOWN = (VariableKind.LOCATION, VariableKind.ASSUMPTION, VariableKind.PHASE)


def unreachable(coverage: Coverage) -> frozenset[Case]:
    """The cases of which it is proved that no run shows them. A monitor's robot is under no
    supervisor, so there it proves nothing."""
    steps = coverage.steps
    if steps.follows:
        return frozenset()
    keys = _keys(steps.plant)
    numbers = {key: number for number, key in keys.items()}
    read = (coverage.reads(step) | _assigned(step) for step in steps.steps)
    groups = [frozenset(numbers[key] for key in some if key in numbers) for some in read]
    try:
        reached = _reached(steps, groups)
    except StateSpaceError:
        return frozenset()
    pairs = list(zip(steps.steps, reached, strict=True))
    unknown = {step.number for step, several in pairs if several is None}
    found = {case for case in coverage.cases if case[1] in unknown}
    for step, several in pairs:
        for assigned in several or ():
            state = _state(steps.plant, keys, assigned)
            if step.in_phase(state):
                found |= coverage.possible(step, state)
    return frozenset(coverage.cases.keys() - found)


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
