"""Conditions that are evaluated with the atoms that alone decide them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from typing import Any, TypeAlias

from robosc.expr.traversal import operands, walk
from robosc.expr.tree import Aggregate, Binary, Expr, Holds, Literal, Unary, ValueRef
from robosc.expr.types import BooleanType, DoubleType, IntegerType
from robosc.runtime.core.values import Undefined
from robosc.traces.exact_steps import NOTHING, UNKNOWN, Carried, Function, State, function, holds
from robosc.traces.samples import NEAR

Outcome: TypeAlias = tuple[int, bool, str]
"""The number of an atom, whether it holds, and where its left number lies from its right one, if
that is near; else ``""``."""
Possible: TypeAlias = dict[bool, frozenset[Outcome]]
"""Where not all is known: the values that a condition may have, each with the outcomes of atoms
that may alone decide it."""
NEARS = ("", "at", "below", "above")
_CHOSEN = ("chosen elements",)
_Decision: TypeAlias = tuple[bool, tuple[tuple[int, Carried], ...]]


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
    """A condition that is evaluated with the atoms that alone decide it.

    In ``any`` and ``all`` over an array, an atom stands for what it comes to for each element.
    """

    def __init__(self, expr: Expr, text: Callable[[Expr], str]) -> None:
        self.atoms: list[Atom] = []
        self.outer: list[Atom] = []
        """What states differ in: the atoms, and in place of those of elements the whole."""
        self._text = text
        self._evaluate, self._possible = self._compiled(expr)

    def deciding(self, state: State, carried: Carried = NOTHING) -> tuple[bool, set[Outcome]]:
        """Whether it holds, and the outcomes of the atoms that alone decide that."""
        value, atoms = self._evaluate(state, carried)
        found: set[Outcome] = set()
        for number, read in atoms:
            outcome, near = self.atoms[number].outcome(state, read)
            found |= {(number, outcome, ""), (number, outcome, near)}
        return value, found

    def possible(self, state: State) -> Possible:
        """The same in a state of the plant, of which numbers are left out."""
        return self._possible(state)

    def _compiled(
        self, expr: Expr
    ) -> tuple[Callable[[State, Carried], _Decision], Callable[[State], Possible]]:
        match expr:
            case Literal(value=bool(value)):
                return lambda s, v: (value, ()), lambda s: {value: frozenset()}
            case Unary(operator="!", operand=operand):
                inner, may = self._compiled(operand)

                def negated(s: State, v: Carried) -> _Decision:
                    value, atoms = inner(s, v)
                    return not value, atoms

                return negated, lambda s: {not value: a for value, a in may(s).items()}
            case Binary(operator="and" | "or" as word):
                return self._chain(operands(expr, word), word == "or")
            case Binary(operator="=>" | "=" | "!=" as word, left=left, right=right) if (
                left.type == BooleanType()
            ):
                (first, may_first), (second, may_second) = (
                    self._compiled(left),
                    self._compiled(right),
                )
                table = _TABLES[word]

                def joined(s: State, v: Carried) -> _Decision:
                    one, by_one = first(s, v)
                    two, by_two = second(s, v)
                    value = table(one, two)
                    atoms = by_one if table(not one, two) is not value else ()
                    return value, atoms + (by_two if table(one, not two) is not value else ())

                def may(s: State) -> Possible:
                    found: Possible = {}
                    seconds = may_second(s).items()
                    for one, by_one in may_first(s).items():
                        for two, by_two in seconds:
                            value = table(one, two)
                            atoms = by_one if table(not one, two) is not value else frozenset()
                            atoms |= by_two if table(one, not two) is not value else frozenset()
                            found[value] = found.get(value, frozenset()) | atoms
                    return found

                return joined, may
            case Aggregate(operator="any" | "all") if _is_flat(expr):
                return self._quantified(expr)
            case _ if expr.type != BooleanType() and (filtered := filtered_in(expr)):
                return self._filtered(filtered[0])
        number, atom = len(self.atoms), self._atom(expr)
        self.atoms.append(atom)
        self.outer.append(atom)

        def perhaps(s: State) -> Possible:
            try:
                value, near = atom.outcome(s, UNKNOWN)
                return {value: frozenset({(number, value, ""), (number, value, near)})}
            except KeyError:
                return {v: frozenset((number, v, near) for near in NEARS) for v in (True, False)}

        return lambda s, v: (holds(atom.value, s, v), ((number, v),)), perhaps

    def _chain(
        self, parts: Sequence[Expr], decider: bool
    ) -> tuple[Callable[[State, Carried], _Decision], Callable[[State], Possible]]:
        """The same for parts of which one that is ``decider`` suffices; there may be thousands."""
        compiled, other = [self._compiled(part) for part in parts], not decider

        def joined(s: State, v: Carried) -> _Decision:
            found = [evaluate(s, v) for evaluate, _ in compiled]
            deciding = [atoms for value, atoms in found if value is decider]
            if not deciding:
                return other, tuple(pair for _, atoms in found for pair in atoms)
            return decider, deciding[0] if len(deciding) == 1 else ()

        def may(s: State) -> Possible:
            each = [possible(s) for _, possible in compiled]
            surely = [one for one in each if other not in one]
            found: Possible = {}
            if any(decider in one for one in each):
                alone = each if not surely else surely if len(surely) == 1 else []
                found[decider] = frozenset().union(*(one.get(decider, ()) for one in alone))
            if not surely:
                found[other] = frozenset().union(*(one[other] for one in each))
            return found

        return joined, may

    def _quantified(
        self, expr: Aggregate
    ) -> tuple[Callable[[State, Carried], _Decision], Callable[[State], Possible]]:
        element, decider = expr.element, expr.operator == "any"
        if expr.condition is not None:
            word = "and" if decider else "=>"
            element = Binary(word, expr.condition, element, BooleanType())
        first, outer = len(self.atoms), list(self.outer)
        inner, _ = self._compiled(element)
        numbers = range(first, len(self.atoms))
        array, whole = function(expr.array), function(expr)
        self.outer = [*outer, Atom("", whole, None, 0.0)]

        def over(s: State, v: Carried) -> _Decision:
            value = holds(whole, s, v)
            try:
                items = array(s, v)
            except Undefined:
                return value, ()
            found = [
                inner(s, {**v, expr.variable: item, expr.position: position})
                for position, item in enumerate(items)
            ]
            deciding = [atoms for one, atoms in found if one is decider]
            if (value is decider) is not bool(deciding):
                return value, ()  # where an element is undefined
            several = deciding if len(deciding) == 1 else [] if deciding else [a for _, a in found]
            return value, tuple(pair for atoms in several for pair in atoms)

        every = frozenset((n, v, near) for n in numbers for v in (True, False) for near in NEARS)
        return over, lambda s: dict.fromkeys(possible_values(whole, s), every)

    def _filtered(
        self, expr: Aggregate
    ) -> tuple[Callable[[State, Carried], _Decision], Callable[[State], Possible]]:
        """What decides of which elements a value is made; it holds where the value is defined."""
        assert expr.condition is not None
        first, outer = len(self.atoms), list(self.outer)
        inner, _ = self._compiled(expr.condition)
        numbers = range(first, len(self.atoms))
        self.outer = outer  # which elements they are is seen in the value
        array = function(expr.array)
        made = function(replace(expr, array=ValueRef(_CHOSEN, expr.array.type), condition=None))

        def of(items: list[Any], s: State, v: Carried) -> Any:
            try:
                return made(s, {**v, _CHOSEN: items})
            except Undefined:
                return None

        def over(s: State, v: Carried) -> _Decision:
            try:
                items = list(array(s, v))
            except Undefined:
                return False, ()
            found = [
                inner(s, {**v, expr.variable: item, expr.position: position})
                for position, item in enumerate(items)
            ]
            kept = [one for one, _ in found]
            value = of(list(compress(items, kept)), s, v)
            alike = {
                (repr(item), one): n for n, (item, one) in enumerate(zip(items, kept, strict=True))
            }
            pairs: list[tuple[int, Carried]] = []
            for n in alike.values():
                others = [one is not (n == m) for m, one in enumerate(kept)]
                if of(list(compress(items, others)), s, v) != value:
                    pairs += found[n][1]
            return value is not None, tuple(pairs)

        every = frozenset((n, v, near) for n in numbers for v in (True, False) for near in NEARS)
        return over, lambda s: {True: every, False: every}

    def _atom(self, expr: Expr) -> Atom:
        sides, step = None, 0.0
        compared = expr.operand if isinstance(expr, Holds) else expr
        if (
            isinstance(compared, Binary)
            and compared.operation.is_comparison
            and isinstance(compared.left.type, DoubleType | IntegerType)
        ):
            sides = function(compared.left), function(compared.right)
            both = (compared.left.type, compared.right.type)
            step = float(all(isinstance(t, IntegerType) for t in both))
        return Atom(self._text(expr), function(expr), sides, step)


_TABLES: dict[str, Callable[[bool, bool], bool]] = {
    "=>": lambda one, two: not one or two,
    "=": lambda one, two: one is two,
    "!=": lambda one, two: one is not two,
}


def possible_values(condition: Function, state: State) -> tuple[bool, ...]:
    """What a condition may come to in a state of the plant, of which numbers are left out."""
    try:
        return (condition(state, UNKNOWN) is True,)
    except (Undefined, KeyError):
        return (True, False)


def filtered_in(expr: Expr) -> list[Aggregate]:
    """The parts of an expression that are made of some elements of an array."""
    found = [p for p in walk(expr) if isinstance(p, Aggregate) and p.condition is not None]
    return [p for p in found if p.type != BooleanType() and not p.position and _is_flat(p)]


def _is_flat(expr: Aggregate) -> bool:
    """Whether each element can be looked at by itself."""
    inner = [expr.element, *([] if expr.condition is None else [expr.condition])]
    return not any(isinstance(part, Aggregate) for one in inner for part in walk(one))
