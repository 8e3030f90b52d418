"""The controller that ``robosc generate`` writes, made in memory from the very same template."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from robosc.emit.controller.assembly import controller_context
from robosc.emit.controller.naming import file_of
from robosc.emit.package.rendering import render
from robosc.runtime.model import Controller
from robosc.runtime.places import staged
from robosc.simulate.machines.state import SystemState
from robosc.supervisor import Supervisor


def make_controller(supervisor: Supervisor) -> Controller:
    """A controller in its initial state."""
    context = controller_context(supervisor, file_of(supervisor.plant.robot.span))
    # In a package the runtime is a copy beside the controller; here it is robosc's own.
    context = replace(context, runtime="robosc.runtime")
    text = render("common/node/controller.py.jinja", context)
    namespace: dict[str, Any] = {"__name__": "controller"}
    exec(compile(text, "controller.py", "exec"), namespace)
    controller: Controller = namespace[context.class_name]()
    return controller


def restore(controller: Controller, state: Mapping[str, Any], names: Mapping[str, str]) -> list[str]:
    """Put a controller into a state as a document of ``~state`` has it; ``names`` are those of
    communications, by key.

    Returns the variables that remain as they were, because the document has not all of their value.
    """
    told = {name for name in controller.STAGES if state["variables"].get(name) is True}
    places = {
        component: staged(component, place, controller.STAGES, told)
        for component, place in state["components"].items()
    }
    partial = set(state.get("shortened", ()))
    known = {**places, **{n: v for n, v in state["variables"].items() if n not in partial}}
    for name, attribute in _attributes(controller).items():
        if name in known:
            setattr(controller, attribute, known[name])
    for communication in controller.COMMUNICATIONS:
        phase = state["communications"].get(names[communication.key])
        for flag, name in zip(communication.flags, communication.phases[1:], strict=True):
            setattr(controller, flag, name == phase)
    return sorted(partial)


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
