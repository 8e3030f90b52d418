"""The variables that belong to the plant's state, and the expressions that decide about that."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from robosc.expr import traversal, tree, types
from robosc.model import diagnostics, entities
from robosc.model.automata import Assignment
from robosc.model.typing.compatibility import describe
from robosc.source import Span


def select_state_variables(robot: entities.Robot, report: diagnostics.Report) -> entities.Robot:
    """The robot with ``Variable.in_state`` set; report assigned values that are not finite.

    A variable belongs to the state if a guard, a requirement or a provide condition reads it, an
    internal transition that may stay in its state assigns it, or the right-hand side of an
    assignment to a finite variable of the state reads it. A variable with an infinite domain is
    abstracted to the comparisons in which it stands: a variable that is copied to it belongs to the
    state as well, but those from which its value is computed do not.
    """
    data = {key for key, variable in robot.variables.items() if types.domain(variable.type) is None}
    readers = _state_readers(robot, data)
    for component, assignment in _assignments(robot):
        key = f"{component.name}.{assignment.variable}"
        if key in readers and key not in data:
            _check_finite(assignment, report)
    components = tuple(_with_state(c, readers) for c in robot.components)
    return replace(robot, components=components)


def _with_state(component: entities.Component, readers: dict[str, Span]) -> entities.Component:
    variables = tuple(replace(v, in_state=v.key in readers) for v in component.variables)
    return replace(component, behaviour=replace(component.behaviour, variables=variables))


def _state_readers(robot: entities.Robot, data: Collection[str]) -> dict[str, Span]:
    """The keys of the variables of the state, each with the first place that reads it."""
    readers: dict[str, Span] = {}
    sources: dict[str, list[tree.VariableRef]] = {}
    for component, assignment in _assignments(robot):
        key = f"{component.name}.{assignment.variable}"
        parts = [assignment.value] if key in data else traversal.walk(assignment.value)
        sources.setdefault(key, []).extend(r for r in parts if isinstance(r, tree.VariableRef))
    work = [r for r in traversal.walk_all(_deciding(robot)) if isinstance(r, tree.VariableRef)]
    work.reverse()
    for component, assignment in _assigned_in_place(robot):
        key = f"{component.name}.{assignment.variable}"
        readers.setdefault(key, assignment.span)
        work.extend(sources[key])
    while work:
        ref = work.pop()
        if ref.key not in readers and ref.span is not None:
            readers[ref.key] = ref.span
            work.extend(sources.get(ref.key, ()))
    return readers


def _deciding(robot: entities.Robot) -> Iterator[tree.Expr]:
    """Guards, requirements, expectations and provide conditions: what enables events."""
    for component in robot.components:
        yield from (t.guard for t in component.transitions if t.guard is not None)
        yield from (c.expect for c in component.communications if c.expect is not None)
    for requirement in robot.requirements:
        yield requirement.condition
    for goal in robot.goals:
        yield from goal.conditions
    for assumption in robot.assumptions:
        yield assumption.condition
    for provide in robot.provides:
        if provide.condition is not None:
            yield provide.condition


def _assigned_in_place(robot: entities.Robot) -> Iterator[tuple[entities.Component, Assignment]]:
    """The assignments of internal transitions that may stay in their state."""
    for component in robot.components:
        for transition in component.behaviour.staying:
            yield from ((component, assignment) for assignment in transition.assignments)


def _assignments(robot: entities.Robot) -> Iterator[tuple[entities.Component, Assignment]]:
    for component, transition in robot.transitions:
        yield from ((component, assignment) for assignment in transition.assignments)


def _check_finite(assignment: Assignment, report: diagnostics.Report) -> None:
    """Report what a finite variable takes from an infinite domain, unless it is only compared."""
    for part in _taken(assignment.value):
        reads = isinstance(part, tree.VariableRef | tree.ValueRef | tree.ParameterRef | tree.Part)
        computed = _goes_through_data(part)
        if (reads or computed) and types.domain(part.type) is None and part.span is not None:
            integer = isinstance(part.type, types.IntegerType)
            named = integer and isinstance(part, tree.VariableRef | tree.ParameterRef)
            report.add(
                "not-finite",
                part.span,
                f"'{assignment.variable}' has a range and decides about events, so it cannot take"
                f" {describe(part.type)}{' without a range' if integer else ''}",
                "give it a range, integer(0..9), or convert it by an enum"
                if named
                else f"leave out the range of '{assignment.variable}', or convert it by an enum",
            )


def _goes_through_data(expr: tree.Expr) -> bool:
    """Whether an expression has an array or an object as an operand."""
    operands = expr.operands if isinstance(expr, tree.Operation) else ()
    return any(isinstance(operand.type, types.ArrayType | types.ObjectType) for operand in operands)


def _taken(expr: tree.Expr) -> Iterator[tree.Expr]:
    """The parts of an expression of which its value consists: not those that it compares."""

    def consists_of_operands(node: tree.Expr) -> bool:
        return (
            isinstance(node, tree.Operation)
            and not (isinstance(node, tree.Convert | tree.Part) or _goes_through_data(node))
            and not node.operation.is_comparison
        )

    return traversal.walk(expr, inside=consists_of_operands)


def all_expressions(robot: entities.Robot) -> Iterator[tree.Expr]:
    """All expressions of components, requirements and provide statements."""
    yield from _deciding(robot)
    for _, assignment in _assignments(robot):
        yield assignment.value
    for provide in robot.provides:
        yield from entities.data_expressions(provide.data)
