"""What values are made of: the least of several numbers is one of these; of an array, they may read
some elements and not those beside them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from typing import Any

from robosc.expr.traversal import walk, with_operands
from robosc.expr.tree import Aggregate, Binary, Call, Expr, Literal, Operation, Unary
from robosc.expr.types import BooleanType
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Data, data_expressions
from robosc.plant.logic import exact
from robosc.runtime.core.values import Undefined
from robosc.traces.exact_steps import Carried, Function, State, function, keys_read
from robosc.traces.model_numbers import SECTIONS


@dataclass(frozen=True, eq=False)
class DataPiece:
    """A part of data that comes to one of several things: its texts, and the data with each."""

    texts: tuple[str, ...]
    ways: tuple[Function, ...]
    whole: Function
    reads: Collection[str]
    """The keys of the state that the data read."""

    def deciding(self, state: State, carried: Carried) -> tuple[int, ...]:
        """The ways, by number, that the data are made in; none, where another would be the same;
        all, where not all is known."""
        try:
            whole = _value(self.whole, state, carried)
            values = [_value(way, state, carried) for way in self.ways]
        except KeyError:
            return tuple(range(len(self.ways)))
        found = tuple(number for number, value in enumerate(values) if value == whole)
        return found if len(found) < len(values) else ()


class SectionEnds:
    """The ends of the sections of arrays in an expression, each twice, and its masks: ``texts`` say
    which element counts and which, beside it, does not."""

    def __init__(self, expr: Expr, text: Callable[[Expr], str]) -> None:
        moved = dict(_moved(expr := exact(expr), text))
        self.texts = tuple(moved)
        self._functions = [function(one) for one in (expr, *moved.values())] if moved else []

    def mattering(self, state: State, carried: Carried) -> Iterator[int]:
        """The ends, by number, with each of which elsewhere the expression would come to something
        else; all, where not all is known."""
        if not self._functions:
            return
        try:
            whole, *others = (_value(of, state, carried) for of in self._functions)
        except KeyError:
            whole, others = None, [0] * len(self.texts)
        for number, other in enumerate(others):
            if other != whole and (other == other or whole == whole):  # NaN is not itself
                yield number


def _value(of: Function, state: State, carried: Carried) -> Any:
    try:
        return of(state, carried)
    except Undefined:
        return None


_ENDS = (
    (-2, "+", "the first element of {} counts"),
    (-2, "-", "the element before {} does not count"),
    (-1, "-", "the last element of {} counts"),
    (-1, "+", "the element behind {} does not count"),
)


def _moved(expr: Expr, text: Callable[[Expr], str]) -> Iterator[tuple[str, Expr]]:
    """The expression with each end of a section one element further in, and out, and with each mask
    one bit wider."""
    for part in walk(expr):
        if isinstance(part, Call) and part.operator == "has":
            bits, mask = part.operands
            if isinstance(mask, Literal) and isinstance(mask.value, int):
                wider = replace(mask, value=mask.value | mask.value + 1)
                other = replace(part, operands=(bits, wider))
                yield f"in {text(part)} no other bit counts", _with(expr, part, other)
        if not (isinstance(part, Call) and part.operator in SECTIONS):
            continue
        # Two rays of a scan are apart by its angle_increment.
        by = part.operands[2] if part.operator == "sector" else Literal(1, part.operands[-1].type)
        for place, sign, told in _ENDS:
            operands = list(part.operands)
            operands[place] = Binary(sign, operands[place], by, operands[place].type)
            yield (
                told.format(text(part)),
                _with(expr, part, replace(part, operands=tuple(operands))),
            )


def pieces_of(data: Data, text: Callable[[Expr], str]) -> list[DataPiece]:
    """The pieces of provided data, in source order; ``text`` is an expression as people read it."""
    found = []
    for expr in map(exact, data_expressions(data)):
        bound = {id(p) for a in walk(expr) if isinstance(a, Aggregate) for p in walk(a)}
        for part in (p for p in walk(expr) if id(p) not in bound):
            ways = dict(_ways(part, text))
            if ways:
                made = tuple(function(_with(expr, part, way)) for way in ways.values())
                found.append(DataPiece(tuple(ways), made, function(expr), keys_read([expr])))
    return found


def _ways(part: Expr, text: Callable[[Expr], str]) -> Iterator[tuple[str, Expr]]:
    """What a part may come to, by text."""
    match part:
        case Call(operator="min" | "max" as word, operands=operands):
            which = "least" if word == "min" else "greatest"
            yield from ((f"{text(one)}, which is the {which},", one) for one in operands)
        case Call(operator="abs", operands=(one,)):
            yield f"{text(one)}, which is not negative,", one
            yield f"{text(one)}, which is negative,", Unary("-", one, part.type)
        case _ if isinstance(part, Operation) and part.type == BooleanType():
            for value in (True, False):
                yield f"{text(part)}, which is {str(value).lower()},", Literal(value, part.type)


def _with(expr: Expr, part: Expr, other: Expr) -> Expr:
    """An expression in which a part is another one."""
    if expr is part:
        return other
    if isinstance(expr, Operation):
        return with_operands(expr, tuple(_with(o, part, other) for o in expr.operands))
    return expr
