"""The explicit transition system of a plant or of a plant under its supervisor."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TypeVar

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.step import Values
from robosc.supervisor import Supervisor
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.formatting import amount

_State = TypeVar("_State", bound=Hashable)


@dataclass(frozen=True, slots=True)
class GraphTransition:
    """One transition of a :class:`Graph`.

    ``event`` is an index into the plant's events; source and target into the graph's states.
    """

    source: int
    event: int
    values: Values
    target: int


@dataclass(frozen=True)
class Graph:
    """A transition system; states in breadth-first order, transitions in the order of discovery.

    The first ``starts`` states are the initial ones.
    """

    plant: Plant
    states: tuple[PlantState, ...]
    transitions: tuple[GraphTransition, ...]
    starts: int = 1


def explore(system: Supervisor | Plant, limit: int | None = None) -> Graph:
    """Return what is reachable: under control, or in the plant without its requirements.

    The graph of an empty supervisor has no states.

    Raises:
        StateSpaceError: there are more than ``limit`` states, or 30 times as many transitions.
    """
    plant = system.plant if isinstance(system, Supervisor) else system
    if isinstance(system, Supervisor) and system.empty:
        return Graph(plant, (), (), 0)
    most = None if limit is None else limit * limits.TRANSITIONS_PER_STATE
    if isinstance(system, Supervisor):
        _refuse(system.controlled_states, system.controlled_transitions, limit)
    stepper = Stepper(plant)
    events = stepper.controlled(system.guards if isinstance(system, Supervisor) else ())
    states = list(plant.initial_states)
    starts = len(states)
    numbers = {state: number for number, state in enumerate(states)}
    transitions: list[GraphTransition] = []
    for source, state in enumerate(states):  # appended to below: breadth first
        for event in events:
            for values, target in event.targets(state):
                if target not in numbers:
                    numbers[target] = len(states)
                    states.append(target)
                    if limit is not None and len(states) > limit:
                        raise StateSpaceError(f"there are more than {limit} states; raise --limit")
                if most is not None and len(transitions) >= most:
                    raise StateSpaceError(
                        f"there are more than {most} transitions; raise --limit (of states)"
                    )
                transitions.append(GraphTransition(source, event.number, values, numbers[target]))
    return Graph(plant, tuple(states), tuple(transitions), starts)


def _refuse(states: int, transitions: int, limit: int | None) -> None:
    """Raise StateSpaceError before the search if the known sizes exceed the limit."""
    if limit is None:
        return
    for found, what, most in (
        (states, "states", limit),
        (transitions, "transitions", limit * limits.TRANSITIONS_PER_STATE),
    ):
        if found > most:
            raise StateSpaceError(
                f"there are {amount(found)} {what}, more than {most}; raise --limit (of states)"
            )


def reaching(targets: Iterable[_State], steps: Iterable[tuple[_State, _State]]) -> set[_State]:
    """Return the targets and the states from which steps, as (before, after), lead to one."""
    before: dict[_State, list[_State]] = {}
    for state, after in steps:
        before.setdefault(after, []).append(state)
    left = list(targets)
    found = set(left)
    while left:
        for state in before.get(left.pop(), ()):
            if state not in found:
                found.add(state)
                left.append(state)
    return found
