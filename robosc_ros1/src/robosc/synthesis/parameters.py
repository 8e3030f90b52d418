"""Parameter values put into guards and updates, undefined ones included.

A value that did not come (an array index past the end) leaves the parts that read it undefined, but
``and``, ``or`` and ``=>`` may not look at them (:mod:`robosc.ir.expr`). Whether a guard is true is
then an expression over the state again, which :func:`specialise` builds.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from math import prod
from typing import TypeAlias

from robosc.ir.automaton import Event, Plant
from robosc.ir.expr import conjunction, disjunction, negation
from robosc.ir.step import Values, valuations
from robosc.model.expr import FALSE, Binary, Expr, Literal, Unary, ValueRef, VariableRef, walk
from robosc.model.types import BooleanType, Value

__all__ = ["Chosen", "choices", "defined_update", "specialise", "weight"]

Chosen: TypeAlias = Mapping[tuple[str | int, ...], Value | None]
"""Values by path."""


def choices(event: Event, read: Iterable[Expr]) -> Iterator[Chosen]:
    """All combinations of the parameters that the expressions read; one, empty, if none."""
    paths = {node.path for expr in read for node in walk(expr) if isinstance(node, ValueRef)}
    used = [i for i, p in enumerate(event.parameters) if p.path in paths]
    taken = [event.parameters[i] for i in used]
    combinations: Iterable[Values]
    if len(taken) > 1 and any(None in p.values for p in taken):
        # Which missing parts go together is for the reference semantics to say.
        combinations = dict.fromkeys(tuple(v[i] for i in used) for v in valuations(event))
    else:
        combinations = product(*(p.values for p in taken))
    for values in combinations:
        yield {p.path: value for p, value in zip(taken, values, strict=True)}


def weight(event: Event) -> int:
    """How many combinations of parameter values an event has."""
    if any(None in p.values for p in event.parameters):
        return sum(1 for _ in valuations(event))
    return prod(len(p.values) for p in event.parameters)


def specialise(guard: Expr, chosen: Chosen) -> Expr:
    """When the guard holds, given the values: an expression over the state alone."""
    if _undefined(guard, chosen):
        return _truth(guard, chosen)[0]
    return _substitute(guard, chosen)


def defined_update(
    plant: Plant, axis: int, expr: Expr, chosen: Chosen, before: Expr | None
) -> Expr | None:
    """What an update assigns, given the values; None if it leaves the variable as it is.

    ``before`` is what an earlier update of the same edge assigns to the axis.
    """
    if not _undefined(expr, chosen):
        return _substitute(expr, chosen)
    if not isinstance(expr.type, BooleanType):
        return None
    true, false = _truth(expr, chosen)
    if true == false == FALSE:
        return None
    component, variable = plant.variables[axis].name.split(".")
    old = before or VariableRef(component, variable, BooleanType())
    return disjunction([true, conjunction([negation(false), old])])


def _undefined(expr: Expr, chosen: Chosen) -> bool:
    return any(isinstance(node, ValueRef) and chosen[node.path] is None for node in walk(expr))


def _substitute(expr: Expr, chosen: Chosen) -> Expr:
    match expr:
        case ValueRef(path=path, type=type_):
            value = chosen[path]
            assert value is not None
            return Literal(value, type_)
        case Unary(operator=op, operand=operand, type=type_):
            return Unary(op, _substitute(operand, chosen), type_)
        case Binary(operator=op, left=left, right=right, type=type_):
            return Binary(op, _substitute(left, chosen), _substitute(right, chosen), type_)
    return expr


def _truth(expr: Expr, chosen: Chosen) -> tuple[Expr, Expr]:
    """When a boolean expression is defined and true, and when it is defined and false."""
    if not _undefined(expr, chosen):
        known = _substitute(expr, chosen)
        return known, negation(known)
    match expr:
        case Unary(operator="!", operand=operand):
            true, false = _truth(operand, chosen)
            return false, true
        case Binary(operator="and" | "or" | "=>" as op, left=left, right=right):
            first, first_not = _truth(left, chosen)
            second, second_not = _truth(right, chosen)
            if op == "and":
                return (
                    conjunction([first, second]),
                    disjunction([first_not, conjunction([first, second_not])]),
                )
            if op == "=>":
                first, first_not = first_not, first
            return (
                disjunction([first, conjunction([first_not, second])]),
                conjunction([first_not, second_not]),
            )
        case Binary(operator="=" | "!=" as op, left=left, right=right) if isinstance(
            left.type, BooleanType
        ):
            first, first_not = _truth(left, chosen)
            second, second_not = _truth(right, chosen)
            same = disjunction([conjunction([first, second]), conjunction([first_not, second_not])])
            different = disjunction(
                [conjunction([first, second_not]), conjunction([first_not, second])]
            )
            return (same, different) if op == "=" else (different, same)
    return FALSE, FALSE
