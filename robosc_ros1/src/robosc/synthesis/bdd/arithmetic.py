"""Integers as vectors of boolean functions: adders and comparators instead of pairs of values.

A number is in two's complement, least significant bit first, as wide as its range needs; sums are
computed by ripple-carry adders (Clarke, Fujita & Zhao, "Hybrid decision diagrams", ICCAD 1995, for
the sizes). Only linear expressions are encoded this way; others are combined value by value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from robosc.expr.tree import Binary, Expr, Leaf, Literal, TestRef, Unary, ValueRef, VariableRef
from robosc.expr.types import IntegerType
from robosc.lazy_dataclasses import dataclass
from robosc.synthesis.bdd.manager import Bdd, Manager


@dataclass(frozen=True, eq=False, slots=True)
class Number:
    """A number between ``low`` and ``high`` that depends on the state; its last bit is the sign."""

    bits: tuple[Bdd, ...]
    low: int
    high: int


def of_index(manager: Manager, variables: Sequence[int], values: range) -> Number:
    """Return the value of a variable or parameter, given its index's bits, the highest first."""
    bits = [manager.literal(variable, True) for variable in reversed(variables)]
    index = Number((*bits, manager.false), 0, (1 << len(bits)) - 1)
    return _sum(manager, index, _constant(manager, values[0]))


def number_of(manager: Manager, expr: Expr, leaf: Callable[[Leaf], Number | None]) -> Number | None:
    """Return the number of a linear expression over integers; None for any other."""
    if not isinstance(expr.type, IntegerType):
        return None
    match expr:
        case Literal(value=int(value)):
            return _constant(manager, value)
        case Unary(operator="-", operand=operand):
            inner = number_of(manager, operand, leaf)
            return None if inner is None else _negated(manager, inner)
        case Binary(operator="+" | "-" | "*" as operator, left=left, right=right):
            first, second = number_of(manager, left, leaf), number_of(manager, right, leaf)
            if first is None or second is None:
                return None
            if operator == "*":
                return _multiple(manager, first, second)
            return _sum(manager, first, second if operator == "+" else _negated(manager, second))
        case VariableRef() | ValueRef() | TestRef():
            return leaf(expr)
    return None


def is_linear(expr: Expr) -> bool:
    """Whether :func:`number_of` can represent an expression over ranged integers."""
    if not isinstance(expr.type, IntegerType):
        return False
    match expr:
        case Unary(operand=operand):
            return is_linear(operand)
        case Binary(operator=operator, left=left, right=right):
            constant = isinstance(left, Literal) or isinstance(right, Literal)
            known = operator in ("+", "-") or (operator == "*" and constant)
            return known and is_linear(left) and is_linear(right)
    return isinstance(expr, Literal | VariableRef | ValueRef | TestRef)


def compared(manager: Manager, operator: str, left: Number, right: Number) -> Bdd:
    """Return where a comparison holds."""
    if operator in (">", "<="):
        left, right = right, left
    difference = _sum(manager, left, _negated(manager, right))
    if operator in ("<", ">"):
        return difference.bits[-1]
    if operator in ("<=", ">="):
        return ~difference.bits[-1]
    differs = manager.union(difference.bits)
    return ~differs if operator == "=" else differs


def _constant(manager: Manager, value: int) -> Number:
    width = value.bit_length() + 1
    bits = tuple(manager.true if value >> place & 1 else manager.false for place in range(width))
    return Number(bits, value, value)


def _sum(manager: Manager, first: Number, second: Number) -> Number:
    low, high = first.low + second.low, first.high + second.high
    width = max(low.bit_length(), high.bit_length()) + 1
    carry = manager.false
    bits = []
    for place in range(width):
        a, b = (number.bits[min(place, len(number.bits) - 1)] for number in (first, second))
        either = a ^ b
        bits.append(either ^ carry)
        carry = (a & b) | (either & carry)
    return Number(tuple(bits), low, high)


def _negated(manager: Manager, number: Number) -> Number:
    flipped = Number(tuple(~bit for bit in number.bits), -1 - number.high, -1 - number.low)
    return _sum(manager, flipped, _constant(manager, 1))


def _multiple(manager: Manager, first: Number, second: Number) -> Number | None:
    """Return the product if one side is a constant, else None."""
    if first.low != first.high:
        first, second = second, first
    if first.low != first.high:
        return None
    factor = abs(first.low)
    found = _constant(manager, 0)
    for place in range(factor.bit_length()):
        if factor >> place & 1:
            zeros = (manager.false,) * place
            shifted = Number((*zeros, *second.bits), second.low << place, second.high << place)
            found = _sum(manager, found, shifted)
    return _negated(manager, found) if first.low < 0 else found
