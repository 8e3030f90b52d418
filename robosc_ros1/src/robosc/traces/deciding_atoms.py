"""Conditions that are evaluated with the atoms that alone decide them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from robosc.expr.tree import Binary, Expr, Unary
from robosc.expr.types import BooleanType, DoubleType, IntegerType
from robosc.runtime.values import Undefined
from robosc.traces.exact_steps import NOTHING, Carried, Function, State, function, holds
from robosc.traces.samples import NEAR


@dataclass(frozen=True, eq=False)
class Atom:
    """An atom of a condition: its text, and how near its numbers are, if it compares some."""

    text: str
    value: Function
    sides: tuple[Function, Function] | None
    step: float

    def outcome(self, state: State, carried: Carried) -> tuple[bool, str]:
        """Whether it holds, and where its left number lies from its right one, if that is near."""
        found = holds(self.value, state, carried)
        if self.sides is None:
            return found, ""
        try:
            left, right = self.sides[0](state, carried), self.sides[1](state, carried)
        except Undefined:
            return found, ""
        if left == right:
            return found, "at"
        reach = self.step or NEAR * 1.5 * max(1.0, abs(right))
        return found, ("above" if left > right else "below") if abs(left - right) <= reach else ""


class DecidedCondition:
    """A condition that is evaluated with the atoms that alone decide it."""

    def __init__(self, expr: Expr, text: Callable[[Expr], str]) -> None:
        self.atoms: list[Atom] = []
        self._text = text
        self._evaluate = self._compiled(expr)

    def deciding(self, state: State, carried: Carried = NOTHING) -> tuple[bool, Iterable[int]]:
        """Whether it holds, and the numbers of the atoms that alone decide that."""
        return self._evaluate(state, carried)

    def _compiled(self, expr: Expr) -> Callable[[State, Carried], tuple[bool, tuple[int, ...]]]:
        match expr:
            case Unary(operator="!", operand=operand):
                inner = self._compiled(operand)

                def negated(s: State, v: Carried) -> tuple[bool, tuple[int, ...]]:
                    value, atoms = inner(s, v)
                    return not value, atoms

                return negated
            case Binary(operator="and" | "or" | "=>" as word, left=left, right=right):
                first, second = self._compiled(left), self._compiled(right)
                neutral = word != "or"
                flipped = word == "=>"

                def joined(s: State, v: Carried) -> tuple[bool, tuple[int, ...]]:
                    one, by_one = first(s, v)
                    two, by_two = second(s, v)
                    if flipped:  # a => b is !(a and !b)
                        value = not one or two
                        return value, (by_one if not two else ()) + (by_two if one else ())
                    value = (one and two) if neutral else (one or two)
                    return value, (by_one if two is neutral else ()) + (
                        by_two if one is neutral else ()
                    )

                return joined
            case Binary(operator="=" | "!=", left=left, right=right) if left.type == BooleanType():
                first, second = self._compiled(left), self._compiled(right)
                same = expr.operator == "="

                def equal(s: State, v: Carried) -> tuple[bool, tuple[int, ...]]:
                    one, by_one = first(s, v)
                    two, by_two = second(s, v)
                    return (one is two) is same, by_one + by_two

                return equal
        number, atom = len(self.atoms), self._atom(expr)
        self.atoms.append(atom)
        mine = (number,)
        return lambda s, v: (holds(atom.value, s, v), mine)

    def _atom(self, expr: Expr) -> Atom:
        sides, step = None, 0.0
        if (
            isinstance(expr, Binary)
            and expr.operation.is_comparison
            and isinstance(expr.left.type, DoubleType | IntegerType)
        ):
            sides = function(expr.left), function(expr.right)
            both = (expr.left.type, expr.right.type)
            step = float(all(isinstance(t, IntegerType) for t in both))
        return Atom(self._text(expr), function(expr), sides, step)
