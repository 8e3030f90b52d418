"""Case distinction of conditions on data that also read states.

``any(A.s and r < 1 for r in L.ranges)`` changes when A leaves s, though no data are assigned. So it
becomes ``A.s and any(r < 1 for r in L.ranges)``, or what remains for ``!A.s``, so that no term over
data reads a state (Shannon, "The synthesis of two-terminal switching circuits", 1949: expansion by
one variable).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import Any

from robosc import limits
from robosc.expr import evaluation, tree, types
from robosc.expr.traversal import fold, may_be_undefined, parameters_of, walk, with_operands
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.places import each_place


def reads_states(expr: tree.Expr) -> bool:
    """Whether an expression reads the state of a component or the phase of a communication."""
    return any(isinstance(part, tree.StateRef | tree.PhaseRef) for part in walk(expr))


def by_state(expr: tree.Expr) -> Iterator[tuple[tree.Expr, tree.Expr]]:
    """Yield the cases of the first component or communication read: a condition, and the expression
    then.

    Exactly one of the conditions holds in each state; the last one is "in none of the states read".
    """
    read = [part for part in walk(expr) if isinstance(part, tree.StateRef | tree.PhaseRef)]
    named = list(dict.fromkeys(part for part in read if _owner(part) == _owner(read[0])))
    places = dict.fromkeys(place for part in named for place in each_place(part))
    for current in (*places, None):
        there = () if current is None else current.places
        given = {part: not {*there}.isdisjoint(part.places) for part in named}
        where = conjunction(map(negation, named)) if current is None else current
        yield where, _given(expr, given)


def reads_arrays(expr: tree.Expr) -> bool:
    """Whether an expression reads an array."""
    return any(isinstance(part.type, types.ArrayType) for part in walk(expr))


def by_value(expr: tree.Expr) -> tree.Expr | None:
    """Return a condition as comparisons of the finite leaves that it reads with their values.

    None if there are too many combinations of values.
    """
    parts = (
        part
        for part in walk(expr)
        if not isinstance(part, tree.Literal | tree.Operation | tree.ElementRef)
    )
    read = tuple(dict.fromkeys(parts))
    if prod(len(types.domain(leaf.type) or ()) for leaf in read) > limits.CASES_OF_A_CONDITION:
        return None
    return _by_values(expr, read, {})


def _by_values(
    expr: tree.Expr, read: Sequence[tree.Leaf], given: Mapping[tree.Leaf, types.Value]
) -> tree.Expr:
    if not read:
        # An undefined condition does not hold.
        return tree.TRUE if evaluation.evaluate(tree.Holds(expr), given.get) else tree.FALSE
    first, *others = read
    cases: dict[tree.Expr, list[tree.Expr]] = {}
    for value in types.domain(first.type) or ():
        condition = _by_values(expr, others, {**given, first: value})
        cases.setdefault(condition, []).append(has_value(first, value))
    if len(cases) == 1:
        return next(iter(cases))
    return disjunction(
        conjunction([disjunction(values), condition]) for condition, values in cases.items()
    )


def has_value(leaf: tree.Leaf, value: types.Value) -> tree.Expr:
    """Return the condition that a leaf has a value."""
    if isinstance(leaf.type, types.BooleanType):
        return leaf if value else negation(leaf)
    return tree.Binary("=", leaf, tree.Literal(value, leaf.type), types.BooleanType())


def _owner(part: tree.StateRef | tree.PhaseRef) -> tuple[type, str]:
    return type(part), part.component if isinstance(part, tree.StateRef) else part.communication


def _given(expr: tree.Expr, states: Mapping[tree.StateRef | tree.PhaseRef, bool]) -> tree.Expr:
    """Return the simplified expression in those states, undefined in the same cases."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        if isinstance(node, tree.StateRef | tree.PhaseRef) and node in states:
            return tree.TRUE if states[node] else tree.FALSE
        return node

    return fold(expr, leaf, lambda node, operands: _shortened(with_operands(node, operands)))


def _shortened(expr: tree.Expr) -> tree.Expr:
    if not isinstance(expr, tree.Operation):
        return expr
    match expr:
        case tree.Binary(left=left, right=right) if expr.operation.is_lazy:
            return _connected(expr, left, right)
        case tree.Unary(operator="!", operand=operand):
            return negation(operand)
        case tree.Holds(operand=operand):
            return _present(expr, operand)
        case tree.Aggregate(array=array) as through:
            known = None if may_be_undefined(array) else _of_none(through)
            every = replace(through, condition=None) if through.condition == tree.TRUE else through
            return known or every
    constant = all(isinstance(part, tree.Literal) for part in expr.operands)
    if constant and not any(True for _ in parameters_of(expr)):
        return _literal(evaluation.evaluate(expr, _nothing), expr.type)
    return expr


def _connected(expr: tree.Binary, left: tree.Expr, right: tree.Expr) -> tree.Expr:
    """Simplify ``and``, ``or`` or ``=>`` with a constant operand."""
    operation = expr.operation
    if isinstance(left, tree.Literal):
        return (
            tree.Literal(operation.decided, expr.type) if left.value is operation.decider else right
        )
    if not isinstance(right, tree.Literal):
        return expr
    if right.value is not operation.decided:
        return left if operation.decider == operation.decided else negation(left)
    return expr if may_be_undefined(left) else right


def _of_none(expr: tree.Aggregate) -> tree.Literal | None:
    """Return the value of an aggregate to which no element contributes; None: one may."""
    none = expr.condition == tree.FALSE or (
        expr.element
        == {"any": tree.FALSE, "count": tree.FALSE, "all": tree.TRUE}.get(expr.operator)
    )
    if not none or expr.operator in ("min", "max", "first"):
        return None
    return _literal(expr.operation.scalar([]), expr.type)


def _literal(value: Any, type_: types.Type) -> tree.Literal:
    plain: Any = tuple(value) if isinstance(value, list) else value
    return tree.Literal(plain, type_)


def _present(expr: tree.Holds, operand: tree.Expr) -> tree.Expr:
    """Simplify "defined and true" if the condition depends only on whether arrays are present."""
    arrays: dict[tree.Expr, None] = {}

    def strict(node: tree.Operation, operands: tuple[tree.Expr, ...]) -> tree.Expr:
        made = with_operands(node, operands)
        known = _of_none(made) if isinstance(made, tree.Aggregate) else None
        if known is not None and isinstance(made, tree.Aggregate):
            arrays.setdefault(made.array)
        return known or _shortened(made)

    def bound(
        node: tree.Aggregate, array: tree.Expr, visit: Callable[[tree.Expr], tree.Expr]
    ) -> tree.Expr:
        return strict(node, (array, *node.operands[1:]))

    lazy = any(isinstance(part, tree.Binary) and part.operation.is_lazy for part in walk(operand))
    known = fold(operand, lambda node: node, strict, bound=bound)
    if known == tree.FALSE:
        return tree.FALSE
    if known == tree.TRUE and not lazy:
        return conjunction(tree.Holds(array) for array in arrays if may_be_undefined(array))
    return expr


def _nothing(leaf: tree.Leaf) -> types.Value | None:
    raise AssertionError(f"{leaf} is not a constant")
