"""Which cases no run can show, because the plant under its supervisor excludes them.

Looked at is each state that is reached, as far as the plant knows it: its locations, phases and
finite variables. What depends on numbers or on data may come out in any way. So what is possible
here need not be possible on the robot, but what is not possible here is nowhere.
"""

from __future__ import annotations

from robosc.errors import StateSpaceError
from robosc.plant.automaton import Plant, PlantState, VariableKind
from robosc.synthesis.explore import explore
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import State

STATES = 10000
"""So many states are looked at; of a larger system nothing is proved."""
_KNOWN = (VariableKind.LOCATION, VariableKind.ASSUMPTION, VariableKind.PHASE)


def unreachable(coverage: Coverage) -> frozenset[Case]:
    """The cases of which it is proved that no run shows them. A monitor's robot is under no
    supervisor, so there it proves nothing."""
    steps = coverage.steps
    if steps.follows:
        return frozenset()
    try:
        states = explore(steps.supervisor, STATES).states
    except StateSpaceError:
        return frozenset()
    found: set[Case] = set()
    for known in {tuple(_known(steps.plant, state).items()) for state in states}:
        state = dict(known)
        for step in steps.steps:
            if step.in_phase(state):
                found |= coverage.possible(step, state)
    return frozenset(coverage.cases.keys() - found)


def _known(plant: Plant, state: PlantState) -> State:
    """What a state of the plant tells for certain."""
    found: State = {}
    for variable, index in zip(plant.variables, state, strict=True):
        if variable.kind in _KNOWN:
            phase = "~" if variable.kind is VariableKind.PHASE else ""
            found[phase + variable.name] = str(variable.values[index])
        elif isinstance(variable.values, tuple | range):
            found[variable.name] = variable.values[index]
    return found
