"""The state of a robot as both machines have it, and conditions over it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field, replace
from typing import Any, cast

from robosc.emit.controller import assembly
from robosc.emit.package.rendering import render
from robosc.expr import evaluation, tree
from robosc.expr.types import ArrayType, DoubleType, IntegerType, NoneType, ObjectType, Type, Value
from robosc.lazy_dataclasses import dataclass
from robosc.model import entities
from robosc.plant.automaton import Plant, PlantState, VariableKind
from robosc.plant.data.terms import value_of
from robosc.plant.step import is_true
from robosc.runtime.core.model import Controller
from robosc.runtime.core.places import places, stages
from robosc.runtime.core.values import Undefined, widen
from robosc.supervisor import Supervisor


@dataclass(frozen=True)
class SystemState:
    """Component to its state, ``Component.variable`` to its value, key to the phase."""

    components: Mapping[str, str]
    variables: Mapping[str, Value | None]
    phases: Mapping[str, str]
    tests: Mapping[str, Value] = field(default_factory=dict)
    """What tests of data came to, by name: where single events choose them."""

    def look(self, leaf: tree.Leaf) -> Value | None:
        match leaf:
            case tree.StateRef(component=component, places=names):
                return self.components[component] in names
            case tree.TestRef(name=name):
                return self.tests[name] if name in self.tests else value_of(leaf, self.look)
            case tree.VariableRef(component=component, variable=name):
                return self.variables[f"{component}.{name}"]
            case tree.PhaseRef(communication=key, places=phases):
                return self.phases[key] in phases
            case tree.ValueRef():
                return None
            case tree.ElementRef() | tree.ParameterRef():
                raise AssertionError("it belongs to an aggregate, or has its default")

    def holds(self, condition: tree.Expr) -> bool:
        return is_true(condition, self.look)

    def marked(self, robot: entities.Robot) -> bool:
        """Whether every component and every communication is in a marked state."""
        for key, phase in self.phases.items():
            phases = robot.communications[key].phases
            if phases is not None and phase not in phases.marked:
                return False
        return all(
            any(s.marked and s.name == self.components[c.name] for s in c.states)
            for c in robot.components
            if c.states
        )


def state_of(plant: Plant, state: PlantState, data: Mapping[str, Value | None]) -> SystemState:
    """A state of the plant, with the data beside it, in model order."""
    found: dict[VariableKind, dict[str, Value]] = {kind: {} for kind in VariableKind}
    for variable, index in zip(plant.variables, state, strict=True):
        found[variable.kind][variable.name] = variable.values[index]
    known = {**found[VariableKind.DATA], **data}
    variables = {key: known[key] for key in plant.robot.variables}
    return SystemState(
        {name: str(value) for name, value in found[VariableKind.LOCATION].items()},
        variables,
        {key: str(phase) for key, phase in found[VariableKind.PHASE].items()},
        found[VariableKind.TEST],
    )


def sent_data(robot: entities.Robot, key: str, state: SystemState) -> dict[str, Any] | None:
    """What a request carries now: the fields of the first provide statement that holds.

    None: there is none, so that all fields keep their defaults, or some data have not arrived yet.
    """
    command = robot.commands[key]
    for provide in robot.provides:
        if provide.communication != key:
            continue
        if provide.condition is not None and not state.holds(provide.condition):
            continue
        try:
            data = _plain(provide.data, command.type, state)
        except Undefined:
            return None
        if isinstance(command.type, ObjectType | NoneType):
            return cast(dict[str, Any], data)
        return {command.field or "": data}
    return None


def _plain(data: entities.Data, type_: Type, state: SystemState) -> Any:
    """Provided data as plain values; integers become floating point where the field is."""
    if isinstance(data, entities.DataObject):
        inner = dict(type_.properties) if isinstance(type_, ObjectType) else {}
        return {name: _plain(part, inner[name], state) for name, part in data.fields}
    if isinstance(data, entities.DataArray):
        element = type_.element if isinstance(type_, ArrayType) else type_
        return [_plain(part, element, state) for part in data.elements]
    value = evaluation.evaluate(data, state.look)
    if isinstance(type_, DoubleType) and isinstance(data.type, IntegerType):
        return widen(value)
    return value


# The controller that ``robosc generate`` writes, made in memory from the very same template.


def make_controller(supervisor: Supervisor) -> Controller:
    """A controller in its initial state."""
    return controller_class(supervisor)()


def controller_class(supervisor: Supervisor) -> Callable[[], Controller]:
    """What makes a controller in its initial state."""
    context = assembly.controller_context(supervisor, supervisor.plant.robot.span.source.file_name)
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
