"""Explanation of an uncontrollable event that takes a variable out of its range."""

from __future__ import annotations

from dataclasses import dataclass

from robosc.ir.automaton import Edge, LocalAutomaton, Plant, PlantState
from robosc.ir.formulas import Leaf, Undefined, evaluate, to_dsl
from robosc.model.expr import Binary, Expr, Literal, PhaseRef, StateRef, ValueRef, VariableRef
from robosc.model.types import BooleanType, Value
from robosc.source import Span
from robosc.supervisor import Step
from robosc.synthesis.stepper import Stepper
from robosc.synthesis.vectorised import variable_of

__all__ = ["Leaving", "leaving_remedy"]


@dataclass(frozen=True, slots=True)
class Leaving:
    reason: str
    remedy: str | None
    span: Span | None


def leaving_remedy(stepper: Stepper, step: Step, state: PlantState) -> Leaving:
    """Return which variable leaves its range by a step, and the guard that would prevent it."""
    plant = stepper.plant

    def lookup(leaf: Leaf) -> Value | None:
        if isinstance(leaf, ValueRef):
            return next(
                value
                for parameter, value in zip(step.event.parameters, step.values, strict=True)
                if parameter.path == leaf.path
            )
        variable = variable_of(plant, leaf)
        assert variable is not None
        value = plant.variables[variable].values[state[variable]]
        match leaf:
            case StateRef(state=name):
                return value == name
            case PhaseRef():
                return value == leaf.phase
        return value

    for automaton in step.event.automata:
        edge = _taken(automaton, state, lookup)
        for variable, expr in edge.updates if edge is not None else ():
            try:
                value = evaluate(expr, lookup)
            except Undefined:
                continue
            if value not in plant.variables[variable].values:
                assert edge is not None
                return _told(plant, automaton, edge, variable, expr, value, step)
    raise AssertionError("no variable leaves its range")


def _taken(automaton: LocalAutomaton, state: PlantState, lookup: object) -> Edge | None:
    for edge in automaton.edges:
        if edge.source != state[automaton.variable]:
            continue
        if edge.guard is None:
            return edge
        try:
            if evaluate(edge.guard, lookup) is True:  # type: ignore[arg-type]
                return edge
        except Undefined:
            continue
    return None


def _told(
    plant: Plant,
    automaton: LocalAutomaton,
    edge: Edge,
    variable: int,
    expr: Expr,
    value: Value,
    step: Step,
) -> Leaving:
    name, values = plant.variables[variable].name, plant.variables[variable].values
    reason = f"{name} leaves its range {values[0]}..{values[-1]} (it becomes {value})"
    guard = _preventing(plant, variable, expr)
    widen = f"widen the range of {name}"
    if guard is None:
        return Leaving(reason, widen, edge.span)
    condition = to_dsl(guard, plant.robot)
    event = step.event
    where = (
        f"'on {event.kind.value} from {event.name}' in state"
        f" {plant.variables[automaton.variable].values[edge.source]} of {automaton.component}"
    )
    remedy = f"add 'if {condition}' to {where}, or {widen}"
    return Leaving(reason, remedy, edge.span)


def _preventing(plant: Plant, index: int, expr: Expr) -> Expr | None:
    """Return a guard that keeps ``x := x + c`` or ``x := x - c`` in range, if there is one."""
    values = plant.variables[index].values
    match expr:
        case Binary(
            operator="+" | "-" as op, left=VariableRef() as variable, right=Literal(value=int(by))
        ) if variable_of(plant, variable) == index:
            shift = by if op == "+" else -by
            low, high = int(values[0]), int(values[-1])
            bound = (high if shift >= 0 else low) - shift
            if not low <= bound <= high:
                return None  # no value is far enough from the end: such a guard never holds
            comparison = "<=" if shift >= 0 else ">="
            literal = Literal(bound, variable.type)
            return Binary(comparison, variable, literal, BooleanType())
    return None
