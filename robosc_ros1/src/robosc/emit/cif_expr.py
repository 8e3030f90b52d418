"""Expressions and names in CIF, within what its data-based synthesis computes with.

Integers there start at 0, and sums are safest where nothing in between is negative. So a variable
whose range starts below 0 is kept as its distance from that bound (:func:`offset`), and a
comparison is written with every term on the side where it is added: ``x - y < 2`` becomes
``x < y + 2``. What is no such sum (products, divisions, fractions) is written out value by value;
all is finite here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from robosc.emit.cif_names import CifScope, initial, offset
from robosc.language.operators import Spelled, Text
from robosc.model.evaluation import evaluate
from robosc.model.expr import Binary, Call, Convert, Expr, Leaf, Literal, Operation, VariableRef
from robosc.model.traversal import fold, walk
from robosc.model.types import BooleanType, EnumType, IntegerType, Type, Value, domain, is_number

__all__ = ["condition", "in_range", "update"]

_MOST_REPEATED = 4  # `x + x + x + x`; larger factors are written out value by value


# --- booleans ------------------------------------------------------------------------------------

_ATOM = 9


def condition(context: CifScope, expr: Expr, least: int = 0) -> str:
    """A boolean expression; in parentheses if it binds weaker than ``least``."""
    return f"{_boolean(context, expr):{least}}"


def _boolean(context: CifScope, expr: Expr) -> Spelled:

    def whole(node: Expr) -> Spelled | None:
        """A comparison of anything but booleans, and the result of a function."""
        if isinstance(node, Call) or any(isinstance(part, Convert) for part in _sides(node)):
            return _written_out(context, node)
        if not isinstance(node, Binary) or isinstance(node.left.type, BooleanType):
            return None
        if is_number(node.left.type):
            return _comparison(context, node)
        if isinstance(node.left.type, EnumType):
            sides = (Spelled(_enum(context, side), _ATOM) for side in node.operands)
            return _text(node).of(sides)
        return _constant(evaluate(node, _no_leaf))

    def leaf(node: Literal | Leaf) -> Spelled:
        if isinstance(node, Literal):
            return _constant(node.value)
        return Spelled(context.reference(node), _ATOM)

    def operation(node: Operation, operands: tuple[Spelled, ...]) -> Spelled:
        text = _text(node)
        return text.of(
            Spelled(inner.text, _ATOM) if _same(part, node) else inner
            for part, inner in zip(node.operands, operands, strict=True)
        )

    return fold(expr, leaf, operation, known=whole)


def _text(node: Operation) -> Text:
    text = node.operation.cif
    assert text is not None
    return text


def _constant(value: Value) -> Spelled:
    return Spelled("true" if value else "false", _ATOM)


def _sides(node: Expr) -> tuple[Expr, ...]:
    return node.operands if isinstance(node, Binary) else ()


def _same(part: Expr, node: Operation) -> bool:
    """Whether parentheses can be left out: ``a and (b and c)`` is ``a and b and c``."""
    return (
        isinstance(part, Binary)
        and part.operator == node.operator
        and part.operation.is_lazy
        and not part.operation.right_associative
    )


def _enum(context: CifScope, expr: Expr) -> str:
    if isinstance(expr, Literal):
        return context.literal(expr.value, expr.type)
    assert isinstance(expr, VariableRef)
    return context.reference(expr)


def _no_leaf(leaf: Leaf) -> Value | None:
    raise TypeError(leaf)


# --- integers ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Sum:
    """``terms`` (variable to factor, never 0) and a constant, over the variables' own values."""

    terms: Mapping[VariableRef, int]
    constant: int

    def plus(self, other: _Sum, factor: int = 1) -> _Sum:
        terms = dict(self.terms)
        for variable, count in other.terms.items():
            terms[variable] = terms.get(variable, 0) + factor * count
        kept = {variable: count for variable, count in terms.items() if count}
        return _Sum(kept, self.constant + factor * other.constant)

    def shifted(self) -> _Sum:
        """The same number in terms of the variables as CIF keeps them."""
        moved = sum(count * offset(variable.type) for variable, count in self.terms.items())
        return _Sum(self.terms, self.constant - moved)

    def span(self) -> tuple[int, int]:
        low = high = self.constant
        for variable, count in self.terms.items():
            values = domain(variable.type)
            assert values is not None
            ends = sorted((count * int(values[0]), count * int(values[-1])))
            low, high = low + ends[0], high + ends[1]
        return low, high


def _sum(expr: Expr) -> _Sum | None:
    """The expression as a sum of variables, None if it is none (or one with large factors)."""
    found = _any_sum(expr)
    if found is None or any(abs(count) > _MOST_REPEATED for count in found.terms.values()):
        return None
    return found


def _any_sum(expr: Expr) -> _Sum | None:
    def leaf(node: Literal | Leaf) -> _Sum | None:
        if isinstance(node, VariableRef):
            return _Sum({node: 1}, 0)
        assert isinstance(node, Literal)
        value = float(node.value)
        return _Sum({}, int(node.value)) if value.is_integer() else None

    return fold(expr, leaf, _linear)


def _linear(node: Operation, operands: tuple[_Sum | None, ...]) -> _Sum | None:
    """Sums, differences and multiples of sums; everything else is none."""
    match node.operator, operands:
        case "-", (_Sum() as inner,):
            return _Sum({}, 0).plus(inner, -1)
        case "+" | "-", (_Sum() as left, _Sum() as right):
            return left.plus(right, 1 if node.operator == "+" else -1)
        case "*", (_Sum() as left, _Sum() as right) if not (left.terms and right.terms):
            terms, factor = (left, right) if left.terms else (right, left)
            return _Sum({}, 0).plus(terms, factor.constant)
    return None


def _added(context: CifScope, sum_: _Sum, sign: int) -> list[str]:
    """The terms that are added (``sign`` 1) or taken away (-1), the constant last."""
    parts = [
        context.reference(variable)
        for variable, count in sum_.terms.items()
        for _ in range(sign * count)
    ]
    if sign * sum_.constant > 0:
        parts.append(str(sign * sum_.constant))
    return parts


def _comparison(context: CifScope, expr: Binary) -> Spelled:
    left, right = _sum(expr.left), _sum(expr.right)
    difference = None if left is None or right is None else left.plus(right, -1).shifted()
    if difference is None:
        return _written_out(context, expr)
    if not difference.terms:
        return _constant(evaluate(expr, _zero))
    sides = (" + ".join(_added(context, difference, sign)) or "0" for sign in (1, -1))
    return _text(expr).of(Spelled(side, _ATOM) for side in sides)


def _zero(leaf: Leaf) -> Value:
    """Any value will do where the terms cancel out."""
    return 0


def _valuations(expr: Expr) -> Iterator[dict[Expr, Value]]:
    """All values of the variables that an expression reads."""
    variables = list(dict.fromkeys(part for part in walk(expr) if isinstance(part, VariableRef)))
    for values in product(*(domain(variable.type) or () for variable in variables)):
        yield dict(zip(variables, values, strict=True))


def _point(context: CifScope, values: Mapping[Expr, Value]) -> str:
    parts = [
        f"{context.reference(variable)} = {initial(context, variable.type, value)}"
        for variable, value in values.items()
        if isinstance(variable, VariableRef)
    ]
    return " and ".join(parts)


def _written_out(context: CifScope, expr: Expr) -> Spelled:
    """A condition as the values of its variables for which it holds."""
    found = [(evaluate(expr, values.__getitem__), values) for values in _valuations(expr)]
    points = [_point(context, values) for holds, values in found if holds]
    if len(points) in (0, len(found)):
        return _constant(bool(points))
    several = len(found[0][1]) > 1
    texts = [f"({point})" if several and len(points) > 1 else point for point in points]
    return Spelled(" or ".join(texts), 2 if len(points) > 1 else (3 if several else 4))


# --- assignments ---------------------------------------------------------------------------------


def in_range(context: CifScope, type_: Type, expr: Expr) -> list[str]:
    """What must hold so that the assigned value is one of the type; empty if it always is."""
    match type_:
        case IntegerType(bounds=(low, high)):
            least, greatest = _span(expr)
            texts = []
            if least < low:
                texts.append(_against(context, expr, ">=", low))
            if greatest > high:
                texts.append(_against(context, expr, "<=", high))
            return texts
    return []


def _against(context: CifScope, expr: Expr, operator: str, bound: int) -> str:
    comparison = Binary(operator, expr, Literal(bound, IntegerType()), BooleanType())
    return condition(context, comparison, 3)


def _span(expr: Expr) -> tuple[int, int]:
    sum_ = _sum(expr)
    if sum_ is not None:
        return sum_.span()
    values = [int(evaluate(expr, point.__getitem__)) for point in _valuations(expr)]
    return min(values), max(values)


def update(context: CifScope, type_: Type, expr: Expr) -> str:
    """The right-hand side of an assignment to a variable of that type."""
    match type_:
        case EnumType() if isinstance(expr, Convert):
            points = list(_valuations(expr))
            values = [(evaluate(expr, p.__getitem__), _point(context, p)) for p in points]
            texts = [f"{point}: {context.literal(value, type_)}" for value, point in values[:-1]]
            last = context.literal(values[-1][0], type_)
            return f"if {' elif '.join(texts)} else {last} end" if texts else last
        case EnumType():
            return _enum(context, expr)
        case IntegerType(bounds=(low, high)):
            sum_ = _sum(expr)
            if sum_ is None:
                return _by_cases(context, type_, expr, low, high)
            kept = _Sum(sum_.terms, sum_.constant + offset(type_)).shifted()
            added = " + ".join(_added(context, kept, 1)) or "0"
            return " - ".join([added, *_added(context, kept, -1)])
    return condition(context, expr)


def _by_cases(context: CifScope, type_: Type, expr: Expr, low: int, high: int) -> str:
    """``if x = 0: 1 elif …``; values outside the range are ruled out by the edge's guard."""
    cases = [(int(evaluate(expr, p.__getitem__)), _point(context, p)) for p in _valuations(expr)]
    kept = [(value, point) for value, point in cases if low <= value <= high]
    if len(kept) < 2:
        return initial(context, type_, kept[0][0] if kept else low)
    texts = [f"{point}: {initial(context, type_, value)}" for value, point in kept[:-1]]
    return f"if {' elif '.join(texts)} else {initial(context, type_, kept[-1][0])} end"
