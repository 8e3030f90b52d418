"""The controller that ``robosc generate`` writes, made in memory from the very same template."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from robosc.emit.controller import assembly, naming
from robosc.emit.package.rendering import render
from robosc.plant.automaton import Plant, VariableKind
from robosc.runtime.core.model import Controller
from robosc.runtime.core.places import places, stages
from robosc.simulate.machines.state import SystemState
from robosc.supervisor import Supervisor


def make_controller(supervisor: Supervisor) -> Controller:
    """A controller in its initial state."""
    return controller_class(supervisor)()


def controller_class(supervisor: Supervisor) -> Callable[[], Controller]:
    """What makes a controller in its initial state."""
    context = assembly.controller_context(supervisor, naming.file_of(supervisor.plant.robot.span))
    # In a package the runtime is a copy beside the controller; here it is robosc's own.
    context = replace(context, runtime="robosc.runtime")
    text = render("common/node/controller.py.jinja", context)
    namespace: dict[str, Any] = {"__name__": "controller"}
    exec(compile(text, "controller.py", "exec"), namespace)
    found: Callable[[], Controller] = namespace[context.class_name]
    return found


def restore(controller: Controller, plant: Plant, state: Mapping[str, Any]) -> list[str]:
    """Put a controller into a state as a document of ``~state`` has it.

    Returns the variables that remain as they were, because the document has not all of their value.
    """
    told = state["variables"]
    partial = set(state.get("shortened", ()))
    known = {name: value for name, value in told.items() if name not in partial}
    for variable in plant.variables:
        if variable.kind is VariableKind.LOCATION:
            values = [str(value) for value in variable.values]
            place = state["components"][variable.name]
            known[variable.name] = _standing(variable.name, values, place, told, controller.STAGES)
    for name, attribute in _attributes(controller).items():
        if name in known:
            setattr(controller, attribute, known[name])
    names = plant.robot.display_names
    for communication in controller.COMMUNICATIONS:
        phase = state["communications"].get(names[communication.key])
        for flag, name in zip(communication.flags, communication.phases[1:], strict=True):
            setattr(controller, flag, name == phase)
    return sorted(partial)


def _standing(
    component: str, values: list[str], place: str, told: Mapping[str, Any], names: tuple[str, ...]
) -> str:
    """The one of a component's states that is told as ``place``, with these stages beside it."""
    shown = {value: stages({component: value}, names) for value in values}
    own = [name for name in names if any(found[name] for found in shown.values())]
    return next(
        value
        for value, found in shown.items()
        if places({component: value})[component] == place
        and all(found[name] == bool(told.get(name)) for name in own)
    )


def _attributes(controller: Controller) -> dict[str, str]:
    """The attribute of each component and each variable, by name: what its values come from."""
    twin = controller.copy()
    marks = {attribute: object() for attribute in vars(controller)}
    vars(twin).update(marks)
    found = {**twin.components(), **twin.variables()}
    by_mark = {id(mark): attribute for attribute, mark in marks.items()}
    return {name: by_mark[id(mark)] for name, mark in found.items() if id(mark) in by_mark}


def state_of_controller(controller: Controller) -> SystemState:
    phases = {c.key: controller.phase(c) for c in controller.COMMUNICATIONS if c.phases}
    return SystemState(controller.components(), controller.variables(), phases)
