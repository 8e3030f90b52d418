"""Explanation of an uncontrollable event that takes a variable out of its range."""

from __future__ import annotations

from dataclasses import replace

from robosc import dotted
from robosc.expr.evaluation import evaluate
from robosc.expr.tree import Binary, Expr, Literal, VariableRef
from robosc.expr.types import BooleanType, Value
from robosc.plant.automaton import Edge, LocalAutomaton, Plant, PlantState
from robosc.plant.model_text import to_dsl
from robosc.plant.step import lookup, taken_edge
from robosc.runtime.core.values import Undefined
from robosc.supervisor import Step
from robosc.synthesis.controlled_system import location_name
from robosc.synthesis.explain.blocking import Cause, written


def why_out_of_range(plant: Plant, step: Step, state: PlantState) -> Cause:
    """Return which variable leaves its range by a step, and the guard that would prevent it."""
    look = lookup(plant, step.event, step.values, state)
    for automaton in step.event.automata:
        edge = taken_edge(automaton, state, look)
        if edge is None:
            continue
        for variable, expr in edge.updates:
            try:
                value = evaluate(expr, look)
            except Undefined:
                continue
            if value not in plant.variables[variable].values:
                return _cause(plant, automaton, edge, variable, expr, value, step)
    raise AssertionError("no variable leaves its range")


def _cause(
    plant: Plant,
    automaton: LocalAutomaton,
    edge: Edge,
    variable: int,
    expr: Expr,
    value: Value,
    step: Step,
) -> Cause:
    name, values = plant.variables[variable].name, plant.variables[variable].values
    reason = f"{name} leaves its range {values[0]}..{values[-1]} (it becomes {value})"
    component = plant.robot.component(automaton.component)
    widen = f"widen the range of {component.declared}.{dotted.inside(name)}"
    guard = _preventing(plant, variable, component.declared, expr)
    if guard is None:
        return Cause(reason, widen, edge.span)
    event = step.event
    happens = f"on {event.kind.word} from {written(plant, event, component)}"
    if event.kind.of_component:
        happens = f"{event.kind.word} …"
    where = (
        f"'{happens}' in state"
        f" {location_name(plant, automaton.variable, edge.source)} of {component.declared}"
    )
    remedy = f"add 'if {to_dsl(guard, plant.robot)}' to {where}, or {widen}"
    return Cause(reason, remedy, edge.span)


def _preventing(plant: Plant, index: int, declared: str, expr: Expr) -> Expr | None:
    """Return a guard that keeps ``x := x + c`` or ``x := x - c`` in range, if there is one, as it
    may stand where the component is declared."""
    values = plant.variables[index].values
    match expr:
        case Binary(
            operator="+" | "-" as op, left=VariableRef() as variable, right=Literal(value=int(by))
        ) if plant.variable_of(variable) == index:
            shift = by if op == "+" else -by
            low, high = int(values[0]), int(values[-1])
            bound = (high if shift >= 0 else low) - shift
            if not low <= bound <= high:
                return None  # no value is far enough from the end: such a guard never holds
            comparison = "<=" if shift >= 0 else ">="
            literal = Literal(bound, variable.type)
            own = replace(variable, component=declared)
            return Binary(comparison, own, literal, BooleanType())
    return None
