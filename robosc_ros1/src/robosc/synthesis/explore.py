"""The transition system of a supervisor or a plant, state by state (CLI.md, ``explore``)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from robosc.errors import StateSpaceError
from robosc.ir.automaton import Plant, PlantState
from robosc.ir.step import Values, Verdict, valuations
from robosc.model.expr import TRUE
from robosc.supervisor import Supervisor
from robosc.synthesis.stepper import Stepper

__all__ = ["Graph", "Transition", "explore"]


@dataclass(frozen=True, slots=True)
class Transition:
    """``event`` is an index into the plant's events; source and target into the graph's states."""

    source: int
    event: int
    values: Values
    target: int


@dataclass(frozen=True)
class Graph:
    """States in breadth-first order from the initial one; transitions in the order of discovery."""

    plant: Plant
    states: tuple[PlantState, ...]
    transitions: tuple[Transition, ...]


def explore(system: Supervisor | Plant, limit: int | None = None) -> Graph:
    """All that can be reached: under control, or without any requirement if a plant is given.

    The graph of an empty supervisor has no states.

    Raises:
        StateSpaceError: there are more than ``limit`` states.
    """
    plant = system.plant if isinstance(system, Supervisor) else system
    if isinstance(system, Supervisor) and system.empty:
        return Graph(plant, (), ())
    stepper = Stepper(plant)
    tests: dict[int, Callable[[PlantState], bool]] = {}
    if isinstance(system, Supervisor):
        number_of = {id(event): number for number, event in enumerate(plant.events)}
        for guard in system.guards:
            if guard.expr != TRUE:
                tests[number_of[id(guard.event)]] = stepper.test(guard.expr)
    events = [(i, tests.get(i), tuple(valuations(e))) for i, e in enumerate(plant.events)]
    numbers: dict[PlantState, int] = {plant.initial: 0}
    states = [plant.initial]
    transitions: list[Transition] = []
    for source, state in enumerate(states):  # grows while it is walked: breadth first
        for event, test, combinations in events:
            if test is not None and not test(state):
                continue
            for values in combinations:
                target = stepper.outcome(event, values, state)
                if isinstance(target, Verdict):
                    continue
                if target not in numbers:
                    numbers[target] = len(states)
                    states.append(target)
                    if limit is not None and len(states) > limit:
                        raise StateSpaceError(f"there are more than {limit} states; raise --limit")
                transitions.append(Transition(source, event, values, numbers[target]))
    return Graph(plant, tuple(states), tuple(transitions))
