"""Copies of a component (``Bot[1]``, ``Bot[2]``, …): what holds of one is told once for all.

A path that explains the command of one copy explains that of another if both change places in it.
Whether it is a path then as well is checked step by step: other components may tell copies apart.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from robosc import dotted
from robosc.expr.traversal import operands, walk_all
from robosc.expr.tree import VariableRef
from robosc.lazy_dataclasses import dataclass
from robosc.names import Copy
from robosc.plant.automaton import Event, Plant, PlantState, StateVariable
from robosc.plant.logic import conjunction
from robosc.plant.model_text import to_dsl
from robosc.supervisor import Explanation, Guard
from robosc.synthesis.formatting import event_text

_LONGEST = 100
"""Characters of what guards add to the requirements, if it is told."""


def copy_of(event: Event) -> Copy | None:
    """Return which copy of a component an event belongs to; None: it is that of no copy."""
    return Copy.of(dotted.first(event.key))


def family_of(event: Event) -> object:
    """Return what the events of all copies have in common; None for that of no copy."""
    copy = copy_of(event)
    if copy is None:
        return None
    return (
        event.kind,
        copy.family,
        dotted.inside(event.key),
        event.index,
        event.path,
        event.known,
    )


class Copies:
    """The state variables of each copy in a plant."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant

    def exchanged(self, state: PlantState, one: Copy, other: Copy) -> PlantState | None:
        """Return a state in which two copies have changed places; None: they are not alike."""
        first, second = self._variables[one.name], self._variables[other.name]
        sizes = self._plant.sizes
        if sizes(first) != sizes(second):
            return None
        values = list(state)
        for own, others in zip(first, second, strict=True):
            values[own], values[others] = state[others], state[own]
        return tuple(values)

    @cached_property
    def _variables(self) -> Mapping[str, Sequence[int]]:
        found: defaultdict[str, list[int]] = defaultdict(list)
        for number, variable in enumerate(self._plant.variables):
            for component in _components(variable):
                found[component].append(number)
        return found


def _components(variable: StateVariable) -> set[str]:
    """Return the component of a state variable; of a test of data, the only one that it reads."""
    if variable.test is None:
        return {dotted.first(variable.name)}
    read = walk_all(variable.test.sides)
    found = {part.component for part in read if isinstance(part, VariableRef)}
    return found if len(found) == 1 else set()


@dataclass(frozen=True, slots=True)
class Told:
    """An explanation of a guard, whose message says what happens to the command (``head``), then
    why (``rest``). ``copied``: its trace is that of another copy, with which it changes places."""

    guard: Guard
    head: str
    rest: str
    explanation: Explanation
    copied: bool = False


def told_once(plant: Plant, found: Sequence[Told]) -> tuple[Explanation, ...]:
    """Return the explanations, of which one stands for those that say the same of other copies."""
    groups: defaultdict[object, list[int]] = defaultdict(list)
    for number, told in enumerate(found):
        family = family_of(told.guard.event)
        if family is not None:
            alike = groups[family, told.head]
            if not alike or told.copied or told.rest == found[alike[0]].rest:
                alike.append(number)
    explanations = [told.explanation for told in found]
    for numbers in groups.values():
        if len(numbers) > 1:
            first, *others = numbers
            explanations[first] = _of_family(plant, [found[number] for number in numbers])
            for number in others:
                explanations[number] = replace(explanations[number], told=False)
    return tuple(explanations)


def _of_family(plant: Plant, alike: Sequence[Told]) -> Explanation:
    """Return the explanation of the first of some copies, with a diagnostic for all of them."""
    first = alike[0]
    event, copy = first.guard.event, copy_of(first.guard.event)
    assert copy is not None
    name = event.path
    if not event.kind.of_component:
        name = event_text(replace(event, name=dotted.inside(event.key)))
    copies = [c.copy for c in plant.robot.components if c.copy and c.copy.family == copy.family]
    of = f"each {copy.family}" if len(alike) == len(copies) else f"{len(alike)} of {copy.family}"
    which = f"with {copy.name}, " if any(told.copied for told in alike) else ""
    added = {_added(plant, told.guard) for told in alike}
    to = f", to {text}" if len(added) == 1 and 0 < len(text := added.pop()) <= _LONGEST else ""
    message = f"{name} of {of} {first.head}{to}: {which}{first.rest}"
    diagnostic = replace(first.explanation.diagnostic, message=message)
    return replace(first.explanation, diagnostic=diagnostic)


def _added(plant: Plant, guard: Guard) -> str:
    """Return what synthesis adds to the requirements of a command; empty if it never happens."""
    if guard.status != "restricted":
        return ""
    required = operands(guard.required, "and")
    added = [part for part in operands(guard.expr, "and") if part not in required]
    return to_dsl(conjunction(added), plant.robot)
