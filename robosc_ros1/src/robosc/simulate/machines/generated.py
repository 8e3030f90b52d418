"""The controller that ``robosc generate`` writes, made in memory from the very same template."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from robosc.emit.controller.assembly import controller_context
from robosc.emit.controller.naming import file_of
from robosc.emit.package.rendering import render
from robosc.runtime.model import Controller
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


def state_of_controller(controller: Controller) -> SystemState:
    phases = {c.key: controller.phase(c) for c in controller.COMMUNICATIONS if c.phases}
    return SystemState(controller.components(), controller.variables(), phases)
