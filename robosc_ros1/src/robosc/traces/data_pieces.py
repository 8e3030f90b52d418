"""Which pieces data of a command are made of: the least of several numbers is one of these."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Any

from robosc.expr.traversal import walk, with_operands
from robosc.expr.tree import Aggregate, Call, Expr, Literal, Operation, Unary
from robosc.expr.types import BooleanType
from robosc.model.entities import Data, data_expressions
from robosc.plant.logic import exact
from robosc.runtime.core.values import Undefined
from robosc.traces.exact_steps import NOTHING, Function, State, function, keys_read


@dataclass(frozen=True, eq=False)
class DataPiece:
    """A part of data that comes to one of several things: its texts, and the data with each."""

    texts: tuple[str, ...]
    ways: tuple[Function, ...]
    whole: Function
    reads: Collection[str]
    """The keys of the state that the data read."""

    def deciding(self, state: State) -> tuple[int, ...]:
        """The ways, by number, that the data are made in; none, where another would be the same;
        all, where not all is known."""
        try:
            whole = _value(self.whole, state)
            values = [_value(way, state) for way in self.ways]
        except KeyError:
            return tuple(range(len(self.ways)))
        found = tuple(number for number, value in enumerate(values) if value == whole)
        return found if len(found) < len(values) else ()


def _value(of: Function, state: State) -> Any:
    try:
        return of(state, NOTHING)
    except Undefined:
        return None


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
