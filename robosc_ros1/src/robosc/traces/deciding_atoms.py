"""Conditions that are evaluated with the atoms that alone decide them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import compress
from typing import Any, TypeAlias

from robosc.expr.traversal import operands, walk
from robosc.expr.tree import Aggregate, Binary, ElementRef, Expr, Holds, Literal, Unary, ValueRef
from robosc.expr.types import BooleanType, DoubleType, IntegerType
from robosc.lazy_dataclasses import dataclass
from robosc.runtime.core.values import Undefined
from robosc.traces.exact_steps import (
    NOTHING,
    UNKNOWN,
    Carried,
    Function,
    Results,
    State,
    Unknown,
    function,
    holds,
    keys_read,
    of_carried,
    possible_values,
    remembering,
)
from robosc.traces.samples import NEAR

Outcome: TypeAlias = tuple[int, bool, str]
"""The number of an atom, whether it holds, and where its left number lies from its right one, if
that is near; else ``""``."""
NEARS = ("", "at", "below", "above")
_CHOSEN = ("chosen elements",)
_Deciding: TypeAlias = tuple[tuple[int, bool, Carried | str], ...]
"""Atoms that alone decide, each with whether it holds, and what it reads, or where it is near."""
_Values: TypeAlias = dict[bool, _Deciding]
"""What a condition may come to, with what alone decides that: one value, where all is known."""
_Compiled: TypeAlias = Callable[[State, Carried], _Values]
_LONG = 8
"""Parts of a chain from which on those are evaluated only that read what has changed."""


@dataclass(frozen=True, eq=False)
class Atom:
    """An atom of a condition: its text, and how near its numbers are, if it compares some.

    Where it holds and alone decides, the condition comes to ``decided``; None: to one or the other.
    """

    text: str
    value: Function
    sides: tuple[Function, Function] | None
    step: float
    reads: Collection[str]
    """The keys of the state that it reads."""
    operator: str = ""
    decided: bool | None = None

    def outcome(self, state: State, carried: Carried) -> tuple[bool, str]:
        """Whether it holds, and where its left number lies from its right one, if that is near."""
        return holds(self.value, state, carried), self.near(state, carried)

    def near(self, state: State, carried: Carried) -> str:
        if self.sides is None:
            return ""
        try:
            left, right = self.sides[0](state, carried), self.sides[1](state, carried)
        except Undefined:
            return ""
        if left == right:
            return "at"
        reach = self.step or NEAR * 1.5 * max(1.0, abs(right))
        return ("above" if left > right else "below") if abs(left - right) <= reach else ""


class DecidedCondition:
    """A condition that is evaluated with the atoms that alone decide it.

    In ``any`` and ``all`` over an array, an atom stands for what it comes to for each element.
    """

    def __init__(self, expr: Expr, text: Callable[[Expr], str]) -> None:
        self.expr = expr
        self.atoms: list[Atom] = []
        self.outer: list[Atom] = []
        """What states differ in: the atoms, and in place of those of elements the whole."""
        self._text = text
        self._sign: bool | None = True
        """What the condition comes to where the part that is being compiled holds, and decides."""
        self._evaluate = self._compiled(expr)
        self._of_state: Callable[[State], Mapping[bool, set[Outcome]]] | None = None
        if not any(isinstance(part, ValueRef | ElementRef) for part in walk(expr)):
            read = tuple(dict.fromkeys(key for atom in self.atoms for key in atom.reads))
            self._of_state = remembering(partial(self._possible, carried=NOTHING), read)

    def comes_to(self, atom: int, value: bool) -> bool | None:
        """What it comes to where an atom of this value alone decides; None: that depends."""
        decided = self.atoms[atom].decided
        return None if decided is None else value is decided

    def deciding(self, state: State, carried: Carried = NOTHING) -> tuple[bool, set[Outcome]]:
        """Whether it holds, and the outcomes of the atoms that alone decide that."""
        ((value, outcomes),) = self.possible(state, carried).items()
        return value, outcomes

    def possible(self, state: State, carried: Carried = UNKNOWN) -> Mapping[bool, set[Outcome]]:
        """The same for each value that it may have, where not all is known."""
        if self._of_state is not None:
            with suppress(KeyError):  # not all of the state is known
                return self._of_state(state)
        return self._possible(state, carried)

    def _possible(self, state: State, carried: Carried) -> Mapping[bool, set[Outcome]]:
        found: dict[bool, set[Outcome]] = {}
        for value, atoms in self._evaluate(state, carried).items():
            outcomes = found[value] = set()
            for number, holds_, read in atoms:
                try:
                    near = read if isinstance(read, str) else self.atoms[number].near(state, read)
                    outcomes |= {(number, holds_, ""), (number, holds_, near)}
                except KeyError:
                    outcomes |= {(number, holds_, near) for near in NEARS}
        return found

    def _compiled(self, expr: Expr) -> _Compiled:
        match expr:
            case Literal(value=bool(value)):
                return lambda s, v: {value: ()}
            case Unary(operator="!", operand=operand):
                inner = self._part(operand, _opposite(self._sign))
                return lambda s, v: {not value: atoms for value, atoms in inner(s, v).items()}
            case Binary(operator="and" | "or" as word):
                return self._chain(operands(expr, word), word == "or")
            case Binary(operator="=>" | "=" | "!=" as word, left=left, right=right) if (
                left.type == BooleanType()
            ):
                implies = word == "=>"
                first = self._part(left, _opposite(self._sign) if implies else None)
                second = self._compiled(right) if implies else self._part(right, None)
                return self._joined(_TABLES[word], first, second)
            case Aggregate(operator="any" | "all") if _is_flat(expr):
                return self._quantified(expr)
            case _ if expr.type != BooleanType() and (filtered := filtered_in(expr)):
                return self._filtered(filtered[0])
        number, atom = len(self.atoms), self._atom(expr)
        self.atoms.append(atom)
        self.outer.append(atom)

        def alone(s: State, v: Carried) -> _Values:
            values = possible_values(atom.value, s, v)
            return {value: ((number, value, v),) for value in values}

        return alone

    def _part(self, expr: Expr, sign: bool | None) -> _Compiled:
        """:meth:`_compiled`, for a part that decides in another way than the whole."""
        before, self._sign = self._sign, sign
        found = self._compiled(expr)
        self._sign = before
        return found

    def _joined(
        self, table: Callable[[bool, bool], bool], first: _Compiled, second: _Compiled
    ) -> _Compiled:
        def joined(s: State, v: Carried) -> _Values:
            found: _Values = {}
            seconds = second(s, v).items()
            for one, by_one in first(s, v).items():
                for two, by_two in seconds:
                    value = table(one, two)
                    atoms = by_one if table(not one, two) is not value else ()
                    atoms += by_two if table(one, not two) is not value else ()
                    found[value] = found.get(value, ()) + atoms
            return found

        return joined

    def _chain(self, parts: Sequence[Expr], decider: bool) -> _Compiled:
        """The same for parts of which one that is ``decider`` suffices; there may be thousands."""
        compiled, other = [self._compiled(part) for part in parts], not decider
        of_state = [not any(isinstance(p, ValueRef | ElementRef) for p in walk(o)) for o in parts]
        of_state = of_state if len(parts) >= _LONG else [False] * len(parts)
        known = Results(
            (partial(self._nears, evaluate), keys_read([part]))
            for part, evaluate in compress(zip(parts, compiled, strict=True), of_state)
        )

        def joined(s: State, v: Carried) -> _Values:
            results = iter(() if isinstance(v, Unknown) else known(s))
            each = [
                next(results) if is_known and not isinstance(v, Unknown) else evaluate(s, v)
                for is_known, evaluate in zip(of_state, compiled, strict=True)
            ]
            surely = [one for one in each if other not in one]
            found: _Values = {}
            if any(decider in one for one in each):
                alone = each if not surely else surely if len(surely) == 1 else []
                found[decider] = tuple(pair for one in alone for pair in one.get(decider, ()))
            if not surely:
                found[other] = tuple(pair for one in each for pair in one[other])
            return found

        return joined

    def _nears(self, evaluate: _Compiled, s: State) -> _Values:
        """What a part comes to, of which all is known, and where its atoms are near."""
        values = evaluate(s, NOTHING).items()
        return {
            v: tuple((n, h, self.atoms[n].near(s, NOTHING)) for n, h, _ in a) for v, a in values
        }

    def _quantified(self, expr: Aggregate) -> _Compiled:
        element, decider = expr.element, expr.operator == "any"
        if expr.condition is not None:
            word = "and" if decider else "=>"
            element = Binary(word, expr.condition, element, BooleanType())
        first, outer = len(self.atoms), list(self.outer)
        inner = self._compiled(element)
        every = _every(range(first, len(self.atoms)))
        array, whole = function(expr.array), function(expr)
        self.outer = [*outer, Atom("", whole, None, 0.0, keys_read([expr]))]

        def over(s: State, v: Carried) -> _Values:
            if isinstance(v, Unknown):
                return dict.fromkeys(possible_values(whole, s, v), every)
            value = holds(whole, s, v)
            try:
                items = array(s, v)
            except Undefined:
                return {value: ()}
            found = [
                next(iter(inner(s, {**v, expr.variable: item, expr.position: n}).items()))
                for n, item in enumerate(items)
            ]
            deciding = [atoms for one, atoms in found if one is decider]
            if (value is decider) is not bool(deciding):
                return {value: ()}  # where an element is undefined
            several = deciding if len(deciding) == 1 else [] if deciding else [a for _, a in found]
            return {value: tuple(pair for atoms in several for pair in atoms)}

        return of_carried(expr, over)

    def _filtered(self, expr: Aggregate) -> _Compiled:
        """What decides of which elements a value is made; it holds where the value is defined."""
        assert expr.condition is not None
        first, outer = len(self.atoms), list(self.outer)
        inner = self._part(expr.condition, None)
        every = _every(range(first, len(self.atoms)))
        self.outer = outer  # which elements they are is seen in the value
        array = function(expr.array)
        made = function(replace(expr, array=ValueRef(_CHOSEN, expr.array.type), condition=None))

        def of(items: list[Any], s: State, v: Carried) -> Any:
            try:
                return made(s, {**v, _CHOSEN: items})
            except Undefined:
                return None

        def over(s: State, v: Carried) -> _Values:
            if isinstance(v, Unknown):
                return {True: every, False: every}
            try:
                items = list(array(s, v))
            except Undefined:
                return {False: ()}
            found = [
                next(iter(inner(s, {**v, expr.variable: item, expr.position: n}).items()))
                for n, item in enumerate(items)
            ]
            kept = [one for one, _ in found]
            value = of(list(compress(items, kept)), s, v)
            alike = {
                (repr(item), one): n for n, (item, one) in enumerate(zip(items, kept, strict=True))
            }
            pairs: _Deciding = ()
            for n in alike.values():
                others = [one is not (n == m) for m, one in enumerate(kept)]
                if of(list(compress(items, others)), s, v) != value:
                    pairs += found[n][1]
            return {value is not None: pairs}

        return of_carried(expr, over)

    def _atom(self, expr: Expr) -> Atom:
        compared = expr.operand if isinstance(expr, Holds) else expr
        if (
            isinstance(compared, Binary)
            and compared.operation.is_comparison
            and isinstance(compared.left.type, DoubleType | IntegerType)
        ):
            sides = function(compared.left), function(compared.right)
            both = (compared.left.type, compared.right.type)
            step = float(all(isinstance(t, IntegerType) for t in both))
            read, operator = keys_read([expr]), compared.operator
            return Atom(self._text(expr), function(expr), sides, step, read, operator, self._sign)
        return Atom(
            self._text(expr), function(expr), None, 0.0, keys_read([expr]), decided=self._sign
        )


_TABLES: dict[str, Callable[[bool, bool], bool]] = {
    "=>": lambda one, two: not one or two,
    "=": lambda one, two: one is two,
    "!=": lambda one, two: one is not two,
}


def _opposite(sign: bool | None) -> bool | None:
    return None if sign is None else not sign


def _every(numbers: Iterable[int]) -> _Deciding:
    return tuple((n, value, UNKNOWN) for n in numbers for value in (True, False))


def filtered_in(expr: Expr) -> list[Aggregate]:
    """The parts of an expression that are made of some elements of an array."""
    found = [p for p in walk(expr) if isinstance(p, Aggregate) and p.condition is not None]
    return [p for p in found if p.type != BooleanType() and not p.position and _is_flat(p)]


def _is_flat(expr: Aggregate) -> bool:
    """Whether each element can be looked at by itself."""
    inner = [expr.element, *([] if expr.condition is None else [expr.condition])]
    return not any(isinstance(part, Aggregate) for one in inner for part in walk(one))
