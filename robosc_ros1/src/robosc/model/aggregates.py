"""Typing of aggregates, ``any(E for x in A)``; those over lists of expressions are expanded.

``count(x for x in [A.busy, !B.on]) < 2`` becomes a condition that enumerates the cases, so that
later stages have no aggregates over such lists. A list of constants is an array like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from typing import NamedTuple

from robosc.language.functions import AGGREGATES
from robosc.language.operators import MIRRORED, Operand
from robosc.model.compatibility import result_type
from robosc.model.diagnostics import Report
from robosc.model.evaluation import constant
from robosc.model.expected import BOOLEAN, needs_of
from robosc.model.expr import (
    FALSE,
    TRUE,
    Aggregate,
    Binary,
    Call,
    ElementRef,
    Expr,
    Holds,
    Leaf,
    Literal,
    opposite,
)
from robosc.model.function_calls import Check, list_literal, typed_elements
from robosc.model.quantified import MOST_NODES, Cases, compared, halves
from robosc.model.traversal import may_be_undefined, part_of, rewritten
from robosc.model.types import ArrayType, BooleanType, Type
from robosc.syntax.nodes import AggregateNode, ArrayNode, BinaryNode, ExprNode

__all__ = ["Aggregates", "at_least", "chain"]

_BOOLEAN = BooleanType()


def at_least(conditions: Sequence[Expr], number: int) -> Expr | None:
    """The condition that at least ``number`` of the conditions hold; None if it is too large."""
    cases = Cases[Expr](chain, (FALSE, TRUE))
    found = cases.least(conditions, number)
    return None if cases.nodes > MOST_NODES else found


def chain(operator: str, parts: Sequence[Expr]) -> Expr:
    """The parts joined by ``and`` or ``or``; a tree of logarithmic height if they are many."""
    if len(parts) == 1:
        return parts[0]
    left, right = halves(parts)
    return Binary(operator, chain(operator, left), chain(operator, right), _BOOLEAN)


class Counted(NamedTuple):
    """An expanded comparison of a count over a list; ``expr`` is None after a reported error."""

    expr: Expr | None


class Aggregates:
    """Types aggregates; ``bound`` maps the variables of enclosing ones to their types."""

    def __init__(self, check: Check, bound: dict[str, Type], report: Report) -> None:
        self._check = check
        self._bound = bound
        self._report = report

    def typed(self, node: AggregateNode) -> Expr | None:
        """The aggregate, or the expression to which it expands; None after a reported error."""
        name = node.function.text
        operation = AGGREGATES.get(name)
        if operation is None:
            hint = self._report.suggest(name, AGGREGATES)
            message = f"'{name}' is not a function over arrays"
            self._report.add("unknown-name", node.function.span, message, hint)
            return None
        if node.variable.text in self._bound or node.variable.text == "value":
            message = f"'{node.variable.text}' already has another meaning here"
            self._report.add("duplicate-name", node.variable.span, message, "give it another name")
            return None
        if not isinstance(node.array, ArrayNode):
            array = self._check(node.array, needs_of(Operand.ARRAY), f"'{name}'")
            return None if array is None else self._through(node, array)
        listed = typed_elements(node.array, self._check, self._report)
        if listed is None:
            return None
        if all(constant(element) is not None for element in listed[0]):
            array = list_literal(node.array, *listed, self._report)
            return None if array is None else self._through(node, array)
        return self._written_out(node, *listed)

    def counted(self, node: BinaryNode) -> Counted | None:
        """``count(…) < 2`` over a list of expressions, expanded; None for other comparisons."""
        for many, bound, operator in (
            (node.left, node.right, node.operator),
            (node.right, node.left, MIRRORED.get(node.operator, "")),
        ):
            if (
                operator in MIRRORED
                and isinstance(many, AggregateNode)
                and many.function.text == "count"
                and isinstance(many.array, ArrayNode)
            ):
                listed = typed_elements(many.array, self._check, self._report)
                if listed is None:
                    return Counted(None)
                if all(constant(element) is not None for element in listed[0]):
                    return None
                return Counted(self._compared(many, operator, bound, *listed))
        return None

    def _through(self, node: AggregateNode, array: Expr) -> Expr | None:
        assert isinstance(array.type, ArrayType)
        parts = self._parts(node, array.type.element)
        if parts is None:
            return None
        name, (element, condition) = node.function.text, parts
        type_ = result_type(AGGREGATES[name].result, (element.type,))
        return Aggregate(name, node.variable.text, array, element, condition, type_, node.span)

    def _parts(self, node: AggregateNode, type_: Type) -> tuple[Expr, Expr | None] | None:
        """The typed element and condition of an aggregate; None after a reported error."""
        name = node.function.text
        self._bound[node.variable.text] = type_
        element = self._check(node.element, needs_of(AGGREGATES[name].operands), f"'{name}'")
        condition = None
        if node.condition is not None:
            condition = self._check(node.condition, BOOLEAN, "the 'if' of an array")
        del self._bound[node.variable.text]
        if element is None or (condition is None) != (node.condition is None):
            return None
        return element, condition

    # --- lists of expressions ---

    def _written_out(
        self, node: AggregateNode, elements: Sequence[Expr], type_: Type
    ) -> Expr | None:
        name = node.function.text
        if name in ("any", "all"):
            conditions = self._conditions(node, elements, type_)
            if conditions is None:
                return None
            return replace(chain("or" if name == "any" else "and", conditions), span=node.span)
        parts = self._parts(node, type_)
        if parts is None:
            return None
        numbers = [_of_element(parts[0], node.variable.text, element) for element in elements]
        if name == "count" or parts[1] is not None or any(map(may_be_undefined, numbers)):
            hint = "compare count(…) with a number" if name == "count" else None
            message = f"'{name}' over a list of expressions is not allowed here"
            self._report.add("not-over-components", node.span, message, hint)
            return None
        operation = "+" if name == "sum" else name

        def joined(left: Expr, right: Expr) -> Expr:
            both = result_type(AGGREGATES[name].result, (left.type, right.type))
            if operation == "+":
                return Binary("+", left, right, both, node.span)
            return Call(operation, (left, right), both, node.span)

        return reduce(joined, numbers)

    def _compared(
        self,
        many: AggregateNode,
        operator: str,
        bound: ExprNode,
        elements: Sequence[Expr],
        type_: Type,
    ) -> Expr | None:
        conditions = self._conditions(many, elements, type_)
        number = self._check(bound, needs_of(Operand.INTEGER), f"'{operator}'")
        if conditions is None or number is None:
            return None
        value = constant(number)
        if not isinstance(value, int):
            message = "the number of elements can only be compared with a whole number"
            self._report.add("not-over-components", bound.span, message)
            return None
        least, more = at_least(conditions, value), at_least(conditions, value + 1)
        if least is None or more is None:
            message = "this count has too many cases to be expanded"
            hint = "compare it with a smaller number, or count fewer elements"
            self._report.add("not-over-components", many.span, message, hint)
            return None
        cases = {value: least, value + 1: more}
        return compared(operator, value, cases.__getitem__, _both, opposite)

    def _conditions(
        self, node: AggregateNode, elements: Sequence[Expr], type_: Type
    ) -> list[Expr] | None:
        """The condition on each element, its ``if`` included; an undefined one does not count."""
        parts = self._parts(node, type_)
        if parts is None:
            return None
        said, condition = parts
        if condition is not None:
            operator = "=>" if node.function.text == "all" else "and"
            said = Binary(operator, condition, said, _BOOLEAN)
        found = [_of_element(said, node.variable.text, element) for element in elements]
        if node.function.text == "all":
            return [opposite(_surely(opposite(one))) if may_be_undefined(one) else one
                    for one in found]  # fmt: skip
        return [_surely(one) for one in found]


def _of_element(said: Expr, variable: str, element: Expr) -> Expr:
    """The expression over the variable of an aggregate, with an element in its place."""

    def leaf(node: Literal | Leaf) -> Expr:
        if isinstance(node, ElementRef) and node.variable == variable:
            return part_of(element, node.path, node.type, node.span) if node.path else element
        return node

    return rewritten(said, leaf)


def _surely(condition: Expr) -> Expr:
    return Holds(condition) if may_be_undefined(condition) else condition


def _both(left: Expr, right: Expr) -> Expr:
    return Binary("and", left, right, _BOOLEAN)
