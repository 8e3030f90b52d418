"""The attributes of a controller: each part of a robot's state has one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from robosc import dotted
from robosc.emit.controller import naming, python
from robosc.expr.types import EnumType
from robosc.model.entities import Component, Robot
from robosc.names import snake_case
from robosc.plant.part_names import PartNames


def attributes_of(
    robot: Robot, enums: Iterable[EnumType], part_names: PartNames, names: naming.PythonNames
) -> python.Attributes:
    """Take a name for each part of the state, for conversions to enums, and for parts of guards."""
    functions = {e: names.take(snake_case(e.name)) for e in enums}
    locations: dict[str, str] = {}
    variables: dict[str, str] = {}
    for component in robot.components:
        if not component.states:
            continue
        locations[component.name] = names.take(snake_case(component.name))
        for variable in component.behaviour.variables:
            wish = f"{snake_case(component.name)}_{snake_case(variable.name)}"
            variables[variable.key] = names.take(wish)
    entries = {
        name: names.take(f"{snake_case(name.replace('.', '_'))}_entries")
        for component in robot.components
        for name in counting_entries(component)
    }
    phases = {
        (c.key, phase): names.take(f"{word_of(c.key, robot)}_{phase}")
        for c in robot.communications.values()
        if c.phases is not None
        for phase in c.phases.active
    }
    parameters = {
        p.key: names.take("_".join(snake_case(part) for part in dotted.parts(p.key)))
        for p in robot.parameters
    }
    parts = {part.name: names.take(part.name) for part in part_names.definitions}
    lasting = {one.name: names.take(f"is_{snake_case(one.name)}") for one in robot.lasting}
    return python.Attributes(
        robot, locations, variables, phases, functions, entries, parameters, parts, lasting
    )


def word_of(key: str, robot: Robot) -> str:
    """A communication as a part of an identifier."""
    return snake_case(robot.display_names[key].replace(".", "_")) or "n"


def counting_entries(component: Component) -> Iterator[str]:
    """The keys of what counts the entries into states (:class:`Attributes`)."""
    if any(state.afters for state in component.states):
        yield component.name
    yield from (f"{component.name}.{o.name}" for o in component.behaviour.composites if o.afters)
