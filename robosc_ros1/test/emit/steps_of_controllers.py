"""Generated controllers at work, each step held against the plant."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from emit.generated_code import controller_class

from robosc.expr.evaluation import Undefined, part_of_value
from robosc.expr.tree import Leaf, PhaseRef, StateRef, ValueRef, VariableRef
from robosc.expr.types import Value
from robosc.language.events import EventKind
from robosc.plant.automaton import Event, EventParameter, PlantState, StateVariable, VariableKind
from robosc.plant.data.terms import value_of
from robosc.plant.step import Verdict, holds, outcome
from robosc.runtime.core.values import Mismatch
from robosc.simulate.start import supervisor_with
from robosc.supervisor import Supervisor

__all__ = ["Run", "step"]


class Run:
    """A controller at work, and the state of the plant that its data belong to."""

    def __init__(
        self, supervisor: Supervisor, parameters: Mapping[str, Value] = MappingProxyType({})
    ) -> None:
        make, context = controller_class(supervisor)
        self.supervisor = supervisor = supervisor_with(supervisor, parameters)
        self.plant = supervisor.plant
        self.controller = make()
        self.controller.configure(parameters)
        self.rows = {c.key: c for c in self.controller.COMMUNICATIONS}
        self.attributes = dict(context.variables)
        self.guards = {id(g.event): g for g in supervisor.guards}

    def look(self, leaf: Leaf, value: Value | None = None) -> Value | None:
        match leaf:
            case VariableRef(component=component, variable=name):
                found: Value = getattr(self.controller, self.attributes[f"{component}.{name}"])
                return found
            case StateRef(component=component, places=names):
                return self.controller.components()[component] in names
            case PhaseRef(communication=key, places=phases):
                return self.controller.phase(self.rows[key]) in phases
            case ValueRef(path=path):
                return part_of_value(value, path)
        raise TypeError(leaf)

    def state(self) -> PlantState:
        return tuple(v.values.index(self.value(v)) for v in self.plant.variables)

    def value(self, variable: StateVariable) -> Any:
        if variable.kind is VariableKind.TEST:
            assert variable.test is not None
            return value_of(variable.test, self.look)
        if variable.kind is VariableKind.ASSUMPTION:
            return True
        if variable.kind is VariableKind.LOCATION:
            return self.controller.components()[variable.name]
        if variable.kind is VariableKind.PHASE:
            return self.controller.phase(self.rows[variable.name])
        return getattr(self.controller, self.attributes[variable.name])

    def perform(self, event: Event, value: Value | None) -> bool:
        """Let the controller take an event if it may; whether it did."""
        if event.kind is EventKind.AFTER:
            delays = self.controller.AFTERS
            row = next(a for a in delays if (a.component, a.number) == (event.key, event.index))
            return _call(self.controller, row.step) is not None
        table = self.controller.COMMANDS if event.controllable else self.controller.INPUTS
        if event.kind is EventKind.TAU:
            steps = [
                t
                for t in self.controller.TAUS
                if (t.component, t.number) == (event.key, event.index)
            ]
            return any(_call(self.controller, tau.step) is not None for tau in steps)
        entry = next(e for e in table if (e.key, e.kind) == (event.key, event.kind.word))
        if event.controllable:
            conditions = (entry.guard, entry.synchronisation)
            if not entry.possible(vars(self.controller)):
                return False
            if not all(_call(self.controller, c) for c in conditions if c is not None):
                return False
            _call(self.controller, entry.apply)
            return True
        try:
            read = value if isinstance(value, int | float | str | None) else entry.read(None, value)
            _call(self.controller, entry.apply, read)
        except Mismatch:
            return False
        return True


def _call(controller: Any, method: Any, *arguments: Any) -> Any:
    if method is None:
        return None
    if isinstance(method, str):
        return getattr(controller, method)(*arguments)
    return method(controller, *arguments)


def taken(run: Run, parameter: EventParameter, value: Value | None) -> Value | None:
    """What a part of the event's value is, or a test of it comes to, before the event."""
    if renewed(parameter) is not None:
        return None  # known after the event only
    try:
        if parameter.test is not None:
            return value_of(parameter.test, lambda leaf: run.look(leaf, value))
        return None if value is None else part_of_value(value, parameter.path)
    except Undefined:
        return None


def renewed(parameter: EventParameter) -> str | None:
    """The state variable to which the event gives an outcome that the plant leaves open."""
    name = str(parameter.path[0]) if parameter.path else ""
    return name.removeprefix("new ") if name.startswith("new ") else None


def step(run: Run, event: Event, value: Value | None) -> None:
    """Take an event if the controller does, and ask for a step of the plant; one that it does not
    take is none, as far as what the event decides is known."""
    before = run.state()
    values = [taken(run, parameter, value) for parameter in event.parameters]
    guard = run.guards.get(id(event))
    if not run.perform(event, value):
        is_known = all(renewed(parameter) is None for parameter in event.parameters)
        if is_known and (guard is None or holds(run.plant, guard.expr, before)):
            expected = outcome(run.plant, event, tuple(values), before)
            changes_nothing = event.kind is EventKind.TAU and expected == before
            assert isinstance(expected, Verdict) or changes_nothing, (event, value, before)
        return
    after = run.state()
    for number, parameter in enumerate(event.parameters):
        name = renewed(parameter)
        if name is not None:
            variable = next(v for v in run.plant.variables if v.name == name)
            values[number] = run.value(variable)
    if guard is not None:
        assert holds(run.plant, guard.expr, before), (event, before)
    expected = outcome(run.plant, event, tuple(values), before)
    assert not isinstance(expected, Verdict), (event, value, before)
    assert after == expected, (event, value, before)
