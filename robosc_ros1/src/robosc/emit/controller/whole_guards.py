"""One guard for each command, where synthesis found one for each case of the data."""

from __future__ import annotations

from collections.abc import Sequence

from robosc.expr import tree, undefined_data
from robosc.expr.types import BooleanType, Value
from robosc.plant.automaton import EventParameter
from robosc.plant.data.classes import Classes
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.supervisor import Guard, Supervisor


def whole_guards(supervisor: Supervisor) -> tuple[Guard, ...]:
    """The guards of a supervisor; those of requests whose data it judges read ``value``."""
    found: dict[object, list[Guard]] = {}
    for guard in supervisor.guards:
        whole = guard.event.whole or guard.event
        found.setdefault(whole.identity, []).append(guard)
    return tuple(
        _whole(guards) if guards[0].event.whole else guards[0] for guards in found.values()
    )


def _whole(cases: Sequence[Guard]) -> Guard:
    event = cases[0].event.whole
    assert event is not None
    required = event.requirement or tree.TRUE
    asked = [guard for guard in cases if guard.required != tree.FALSE]
    if all(guard.status == "as required" for guard in asked):
        return Guard(event, required, required, "as required" if asked else "never")
    if all(guard.status == "never" for guard in asked):
        return Guard(event, tree.FALSE, required, "never")
    parameters = [event.parameters[i] for i in cases[0].event.known]
    beyond = _by_value(parameters, [(_numbers(guard, parameters), guard) for guard in cases])
    return Guard(event, conjunction([required, beyond]), required, "restricted")


_Case = tuple[tuple[int, ...], Guard]
"""A guard, with the number of each parameter's value."""


def _numbers(guard: Guard, parameters: Sequence[EventParameter]) -> tuple[int, ...]:
    data = guard.event.data
    return tuple(p.values.index(data[p.path]) for p in parameters)


def _by_value(parameters: Sequence[EventParameter], cases: Sequence[_Case]) -> tree.Expr:
    """What is demanded beyond the requirements, by the values of the parameters one by one."""
    if not parameters:
        ((_, guard),) = cases
        # Where the requirements forbid these data, nothing more has to.
        required = guard.status == "as required" or guard.required == tree.FALSE
        return tree.TRUE if required else guard.expr
    by_number: dict[int, list[_Case]] = {}
    for (number, *rest), guard in cases:
        by_number.setdefault(number, []).append((tuple(rest), guard))
    alike: dict[tree.Expr, list[int]] = {}
    for number, found in by_number.items():
        alike.setdefault(_by_value(parameters[1:], found), []).append(number)
    if len(alike) == 1:
        return next(iter(alike))
    return disjunction(
        conjunction([_is_one_of(parameters[0], numbers), rest]) for rest, numbers in alike.items()
    )


def _is_one_of(parameter: EventParameter, numbers: Sequence[int]) -> tree.Expr:
    reference = _reference(parameter)
    values = parameter.values
    if isinstance(values, Classes):
        return values.condition(numbers, numbers).of(reference)
    return disjunction(_has(reference, parameter, values[number]) for number in numbers)


def _reference(parameter: EventParameter) -> tree.ValueRef:
    if parameter.test is not None:
        return tree.ChoiceRef(parameter.path, parameter.type, test=parameter.test)
    return tree.ValueRef(parameter.path, parameter.type)


def _has(reference: tree.ValueRef, parameter: EventParameter, value: Value | None) -> tree.Expr:
    if value is None:
        return negation(undefined_data.defined(reference))
    if isinstance(parameter.type, BooleanType):
        return reference if value else negation(reference)
    return tree.Binary("=", reference, tree.Literal(value, parameter.type), BooleanType())
