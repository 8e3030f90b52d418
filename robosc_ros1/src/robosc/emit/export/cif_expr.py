"""Expressions in CIF, within what its data-based synthesis computes with.

Integers there start at 0, and sums are safest where nothing in between is negative. So a variable
whose range starts below 0 is kept as its distance from that bound, and a comparison is written with
every term on the side where it is added: ``x - y < 2`` becomes ``x < y + 2``. What is no such sum
(products, divisions, fractions, numbers without bounds, strings) is written out value by value; all
is finite here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from typing import TypeAlias

from robosc.emit.export.cif_names import CifScope, CifVariable
from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import fold, walk
from robosc.expr.tree import Binary, Expr, Holds, Leaf, Literal, Operation, TestRef, VariableRef
from robosc.expr.types import BooleanType, EnumType, IntegerType, Value, domain, is_number
from robosc.language.operators import Spelled
from robosc.lazy_dataclasses import dataclass
from robosc.plant.places import written_out

_MOST_REPEATED = 4  # `x + x + x + x`; larger factors are written out value by value

_Variable: TypeAlias = VariableRef | TestRef
_Valuation: TypeAlias = Mapping[Leaf, Value]


# --- conditions ----------------------------------------------------------------------------------

_ATOM = 9


def condition(scope: CifScope, expr: Expr, least: int = 0) -> str:
    """A boolean expression; in parentheses if it binds weaker than ``least``."""

    def whole(node: Expr) -> Spelled | None:
        """A condition on anything but booleans."""
        if not isinstance(node, Operation) or isinstance(node.operands[0].type, BooleanType):
            return None
        compared = _comparison(scope, node) if isinstance(node, Binary) else None
        return compared or _written_out(scope, node)

    def leaf(node: Literal | Leaf) -> Spelled:
        text = _constant(node.value) if isinstance(node, Literal) else scope.reference(node)
        return Spelled(text, _ATOM)

    def operation(node: Operation, operands: tuple[Spelled, ...]) -> Spelled:
        if isinstance(node, Holds):
            return operands[0]  # nothing is undefined here
        return _spelled(
            node,
            (
                Spelled(text.text, _ATOM) if _is_same_chain(part, node) else text
                for part, text in zip(node.operands, operands, strict=True)
            ),
        )

    return f"{fold(written_out(expr), leaf, operation, known=whole):{least}}"


def _spelled(node: Operation, operands: Iterable[Spelled]) -> Spelled:
    template = node.operation.cif
    assert template is not None
    return template.of(operands)


def _constant(value: Value) -> str:
    return "true" if value else "false"


def _is_same_chain(part: Expr, node: Operation) -> bool:
    """Whether parentheses can be left out: ``a and (b and c)`` is ``a and b and c``."""
    return (
        isinstance(part, Binary)
        and part.operator == node.operator
        and part.operation.is_lazy
        and not part.operation.right_associative
    )


def _comparison(scope: CifScope, node: Binary) -> Spelled | None:
    """A comparison of sums, or of variables of an enum; None for any other."""
    if isinstance(node.left.type, EnumType):
        texts = [text for side in node.operands if (text := _enum_text(scope, side)) is not None]
        return _spelled(node, (Spelled(t, _ATOM) for t in texts)) if len(texts) == 2 else None
    left, right = (_sum(side) if is_number(side.type) else None for side in node.operands)
    if left is None or right is None:
        return None
    difference = left.plus(right, -1).shifted(scope)
    if not difference.terms:  # any values will do
        return Spelled(_constant(evaluate(node, lambda leaf: 0)), _ATOM)
    sides = (" + ".join(_added(scope, difference, sign)) or "0" for sign in (1, -1))
    return _spelled(node, (Spelled(side, _ATOM) for side in sides))


def _enum_text(scope: CifScope, node: Expr) -> str | None:
    """A variable or a declared constant of an enum; None for what is computed."""
    match node:
        case Literal(value=value, type=EnumType() as enum):
            return scope.literal(value, enum)
        case VariableRef() | TestRef():
            return scope.reference(node)
    return None


def _written_out(scope: CifScope, expr: Expr) -> Spelled:
    """A condition as the values of its variables for which it holds."""
    points = list(_valuations(scope, expr))
    held = [_point(scope, values) for values in points if evaluate(expr, values.__getitem__)]
    if len(held) in (0, len(points)):
        return Spelled(_constant(bool(held)), _ATOM)
    several = len(points[0]) > 1
    if len(held) == 1:
        return Spelled(held[0], 3 if several else 4)
    return Spelled(" or ".join(f"({point})" if several else point for point in held), 2)


def _valuations(scope: CifScope, expr: Expr) -> Iterator[_Valuation]:
    """All values of the variables that an expression reads."""
    read = dict.fromkeys(part for part in walk(expr) if isinstance(part, _Variable))
    for values in product(*(scope.variable(leaf).state.values for leaf in read)):
        yield dict(zip(read, values, strict=True))


def _point(scope: CifScope, values: _Valuation) -> str:
    return " and ".join(
        f"{scope.reference(leaf)} = {scope.variable(leaf).text(value)}"
        for leaf, value in values.items()
    )


# --- sums of integers ----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Sum:
    """``terms`` (variable to factor, never 0) and a constant, over the variables' own values."""

    terms: Mapping[_Variable, int]
    constant: int

    def plus(self, other: _Sum, factor: int = 1) -> _Sum:
        terms = dict(self.terms)
        for variable, count in other.terms.items():
            terms[variable] = terms.get(variable, 0) + factor * count
        kept = {variable: count for variable, count in terms.items() if count}
        return _Sum(kept, self.constant + factor * other.constant)

    def shifted(self, scope: CifScope) -> _Sum:
        """The same number in terms of the variables as CIF keeps them."""
        moved = sum(count * scope.variable(leaf).offset for leaf, count in self.terms.items())
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
    found = fold(expr, _summand, _linear)
    if found is None or any(abs(count) > _MOST_REPEATED for count in found.terms.values()):
        return None
    return found


def _summand(node: Literal | Leaf) -> _Sum | None:
    match node:
        case (
            VariableRef(type=IntegerType(bounds=(_, _))) | TestRef(type=IntegerType(bounds=(_, _)))
        ):
            return _Sum({node: 1}, 0)
        case Literal(value=float(value)) if value.is_integer():
            return _Sum({}, int(value))
        case Literal(value=int(value)):
            return _Sum({}, value)
    return None


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


def _added(scope: CifScope, sum_: _Sum, sign: int) -> list[str]:
    """The terms that are added (``sign`` 1) or taken away (-1), the constant last."""
    parts = [
        scope.reference(variable)
        for variable, count in sum_.terms.items()
        for _ in range(sign * count)
    ]
    if sign * sum_.constant > 0:
        parts.append(str(sign * sum_.constant))
    return parts


# --- assignments ---------------------------------------------------------------------------------


def in_range(scope: CifScope, target: CifVariable, expr: Expr) -> list[str]:
    """What must hold so that the variable can have the value; empty if it always can."""
    values = target.state.values
    if not isinstance(values, range):
        return []
    sum_ = _sum(expr)
    if sum_ is not None:
        least, greatest = sum_.span()
    else:
        found = [evaluate(expr, point.__getitem__) for point in _valuations(scope, expr)]
        least, greatest = int(min(found)), int(max(found))
    texts = []
    if least < values[0]:
        texts.append(_bounded(scope, expr, ">=", values[0]))
    if greatest > values[-1]:
        texts.append(_bounded(scope, expr, "<=", values[-1]))
    return texts


def _bounded(scope: CifScope, expr: Expr, operator: str, bound: int) -> str:
    comparison = Binary(operator, expr, Literal(bound, IntegerType()), BooleanType())
    return condition(scope, comparison, 3)


def update(scope: CifScope, target: CifVariable, expr: Expr) -> str:
    """The right-hand side of an assignment to a variable."""
    if isinstance(expr.type, BooleanType):
        return condition(scope, expr)
    if isinstance(target.state.values, range) and (sum_ := _sum(expr)) is not None:
        kept = _Sum(sum_.terms, sum_.constant + target.offset).shifted(scope)
        added = " + ".join(_added(scope, kept, 1)) or "0"
        return " - ".join([added, *_added(scope, kept, -1)])
    if isinstance(expr, _Variable) and scope.variable(expr).type == target.type:
        return scope.reference(expr)
    return _by_cases(scope, target, expr)


def _by_cases(scope: CifScope, target: CifVariable, expr: Expr) -> str:
    """``if x = 0: 1 elif …``; values outside the range are ruled out by the edge's guard."""
    found = ((evaluate(expr, p.__getitem__), p) for p in _valuations(scope, expr))
    values = target.state.values
    cases = [(target.text(value), point) for value, point in found if value in values]
    if len(cases) < 2:
        return cases[0][0] if cases else target.text(values[0])
    texts = [f"{_point(scope, point)}: {text}" for text, point in cases[:-1]]
    return f"if {' elif '.join(texts)} else {cases[-1][0]} end"
