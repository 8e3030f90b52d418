"""The state of a robot as both machines have it, and conditions over it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from robosc.expr import evaluation, tree
from robosc.expr.types import ArrayType, DoubleType, IntegerType, ObjectType, Type, Value
from robosc.model import entities
from robosc.plant.automaton import Plant, PlantState, VariableKind
from robosc.plant.data.terms import value_of
from robosc.plant.step import is_true
from robosc.runtime.core.values import Undefined, widen


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
        if isinstance(command.type, ObjectType):
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
