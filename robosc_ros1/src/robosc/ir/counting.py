"""How many components of a kind are in a state, found again in conditions that are written out.

``count(s.served for s in Station) < 2`` is written out when a model is read, with all cases. Texts
of what is made of it (guards) say it as the model does, so that people can read them. It is found
by its form: the very tree that such a count is written out to. The operands of a chain that say the
same of each component are what ``any`` and ``all`` say.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import islice
from operator import is_not
from typing import TypeGuard

from robosc.model.aggregates import at_least, chain
from robosc.model.expr import (
    Binary,
    Count,
    Expr,
    Leaf,
    Literal,
    PhaseRef,
    StateRef,
    Unary,
    VariableRef,
)
from robosc.model.quantified import Cases
from robosc.model.traversal import may_be_undefined, operands, rewritten, walk
from robosc.model.types import BooleanType

__all__ = ["copies_of", "counts", "tighter", "with_component", "with_counts"]

_LEAST_COPIES = 3
"""Conditions on fewer components are as well read one by one."""

_LEAST_LISTED = 4
"""What is said of fewer that are not of one kind is as well read case by case."""

_LEAST_CHAINED = 8
"""A chain of fewer conditions is as short as a count of them."""

_BOOLEAN = BooleanType()
_MOST_PARTS = 8
_COPY = re.compile(r"(.+)\[(\d+)\]")

_Kind = tuple[bool, str, Expr]
"""What conditions on components of one kind have in common: whether they are negated, the name of
the components, and the condition on the component of that name."""


def with_counts(expr: Expr, *, chains: bool = True) -> Expr:
    """The condition with counts for all their cases; with ``chains`` also ``any`` and ``all``."""
    return _Finder(chains).found(expr)


def with_component(expr: Expr, name: Callable[[str], str]) -> Expr:
    """The condition on the component of another name, for each that it reads."""

    def leaf(node: Literal | Leaf) -> Expr:
        match node:
            case StateRef(component=component, state=state):
                return StateRef(name(component), state)
            case VariableRef(component=component, variable=variable, type=type_):
                return VariableRef(name(component), variable, type_)
            case PhaseRef(communication=key, phase=phase):
                component, _, communication = key.partition(".")
                return PhaseRef(f"{name(component)}.{communication}", phase)
        return node

    return rewritten(expr, leaf)


def counts(expr: Expr) -> Iterator[Count]:
    """The counts in a condition; that of a list may be one of which all or none hold."""
    for part in walk(with_counts(expr)):
        negated = isinstance(part, Unary) and part.operator == "!"
        whole = part.operand if isinstance(part, Unary) and negated else part
        if isinstance(whole, Count):
            yield replace(whole, negated=whole.negated != negated)
        elif _is_junction(whole):
            parts = operands(whole, whole.operator)
            if len(parts) >= _LEAST_CHAINED and not any(
                _is_junction(one) or isinstance(one, Count) or may_be_undefined(one)
                for one in parts
            ):
                yield _counted(parts, 1 if whole.operator == "or" else len(parts), negated)


def tighter(count: Count) -> Expr | None:
    """That there is room for one more, or one more than needed, with all cases."""
    found = at_least(count.conditions, count.least + (-1 if count.negated else 1))
    return found if found is None or not count.negated else Unary("!", found, _BOOLEAN)


class _Finder:
    """Finds counts; what stands in an expression several times is looked at once."""

    def __init__(self, chains: bool) -> None:
        self._chains = chains
        self._found: dict[int, tuple[Expr, Expr]] = {}
        self._counts: dict[int, tuple[Expr, Count | None]] = {}
        self._sizes: dict[int, tuple[int, int]] = {}

    def found(self, expr: Expr) -> Expr:
        if id(expr) not in self._found:
            self._found[id(expr)] = expr, self._find(expr)
        return self._found[id(expr)][1]

    def _find(self, expr: Expr) -> Expr:
        match expr:
            case Unary(operator="!", operand=operand):
                inner = self.found(operand)
                if isinstance(inner, Count):
                    return replace(inner, negated=not inner.negated)
                return expr if inner is operand else Unary("!", inner, _BOOLEAN)
            case Binary(operator="and" | "or" as operator):
                old = operands(expr, operator)
                if any(map(_is_junction, old)):
                    count = self._count(expr)
                    if count is not None:
                        return count
                    old = list(self._operands(expr, operator))
                new = [self.found(part) for part in old]
                if self._chains:
                    new = _grouped(operator, new)
                if len(new) == len(old) and not any(map(is_not, new, old)):
                    return expr
                return chain(operator, new)
            case Binary(operator="=>", left=left, right=right):
                sides = self.found(left), self.found(right)
                if sides[0] is not left or sides[1] is not right:
                    return Binary("=>", *sides, _BOOLEAN)
        return expr

    def _operands(self, expr: Expr, operator: str) -> Iterator[Expr]:
        """Those of a chain, in which counts are left whole."""
        if not isinstance(expr, Binary) or expr.operator != operator or self._count(expr):
            yield expr
        else:
            yield from self._operands(expr.left, operator)
            yield from self._operands(expr.right, operator)

    def _count(self, expr: Binary) -> Count | None:
        """The count that this is all the cases of; None if it is none, or ``any`` or ``all``."""
        if id(expr) not in self._counts:
            self._counts[id(expr)] = expr, _count_of(expr, *self._size(expr))
        return self._counts[id(expr)][1]

    def _size(self, expr: Expr) -> tuple[int, int]:
        """How many conditions must hold, if no two operands of an ``and`` have some in common, and
        how many conditions it is written with."""
        if not _is_junction(expr):
            return 1, 1
        if id(expr) not in self._sizes:
            (left, few), (right, many) = map(self._size, expr.operands)
            fewest = left + right if expr.operator == "and" else min(left, right)
            self._sizes[id(expr)] = fewest, few + many
        return self._sizes[id(expr)]


def _count_of(expr: Binary, number: int, written: int) -> Count | None:
    if number < 2 or written == number:
        return None
    conditions = list(_conditions(expr))
    if (
        number >= len(conditions)
        or written != _written(len(conditions), number)
        or any(map(may_be_undefined, conditions))
        or (len(conditions) < _LEAST_LISTED and _copies(conditions) is None)
    ):
        return None
    # In the order of the model, too: that of a list is the user's.
    return _counted(conditions, number) if at_least(conditions, number) == expr else None


def _conditions(expr: Expr) -> dict[Expr, None]:
    """What a count goes through, in its order, if the expression is what one is written out to."""
    found: dict[Expr, None] = {}
    seen: set[int] = set()
    stack = [expr]
    while stack:
        node = stack.pop()
        if not _is_junction(node):
            found.setdefault(node)
        elif id(node) not in seen:
            seen.add(id(node))
            parts = operands(node, node.operator)
            # The last case has most of the first half; an ``or`` of conditions has no cases.
            is_in_order = node.operator == "and" or not any(map(_is_junction, parts))
            stack += reversed(parts) if is_in_order else parts
    return found


def _is_junction(expr: Expr) -> TypeGuard[Binary]:
    return isinstance(expr, Binary) and expr.operator in ("and", "or")


@cache
def _written(conditions: int, number: int) -> int:
    """With how many conditions it is written out that ``number`` of them hold."""
    return Cases[int](lambda _, parts: sum(parts), (-1, 0)).least([1] * conditions, number)


def _grouped(operator: str, parts: Sequence[Expr]) -> list[Expr]:
    """The operands of a chain, with one for those that say the same of each component."""
    kinds: dict[_Kind, dict[int, int]] = {}
    for place, part in enumerate(parts):
        literal = _literal(part)
        if literal is not None:
            kinds.setdefault(literal[0], {}).setdefault(literal[1], place)
    left: dict[int, Expr] = dict(enumerate(parts))
    for (negated, _, _), places in kinds.items():
        for run in _runs(sorted(places)):
            conditions = [parts[places[index]] for index in run]
            if negated:
                conditions = [c.operand for c in conditions if isinstance(c, Unary)]
            # None of them fails where not any of their opposites holds.
            is_any = (operator == "or") != negated
            count = _counted(conditions, 1 if is_any else len(conditions), negated)
            first, *others = sorted(places[index] for index in run)
            left[first] = count
            for place in others:
                del left[place]
    return [left[place] for place in sorted(left)]


def _counted(conditions: Sequence[Expr], least: int, negated: bool = False) -> Count:
    return Count("", (), _BOOLEAN, None, tuple(conditions), least, negated)


def _runs(indexes: Sequence[int]) -> Iterator[list[int]]:
    """Those that follow one another, if they are enough."""
    run: list[int] = []
    for index in indexes:
        if run and index != run[-1] + 1:
            if _is_run(run):
                yield run
            run = []
        run.append(index)
    if _is_run(run):
        yield run


def _is_run(indexes: Sequence[int]) -> bool:
    return len(indexes) >= _LEAST_COPIES and indexes[-1] - indexes[0] == len(indexes) - 1


def copies_of(count: Count) -> tuple[str, int] | None:
    """The name of the components that are counted, and the first index; None: it is a list."""
    return _copies(count.conditions)


def _copies(conditions: Sequence[Expr]) -> tuple[str, int] | None:
    found = [_literal(condition) for condition in conditions]
    first, kinds = found[0], {literal and literal[0] for literal in found}
    if first is None or len(kinds) > 1 or not _is_run([index for _, index in filter(None, found)]):
        return None
    (_, name, _), index = first
    return name, index


def _literal(expr: Expr) -> tuple[_Kind, int] | None:
    """The kind and the index of a condition on one of several components; None if it is none."""
    negated = isinstance(expr, Unary) and expr.operator == "!"
    inner = expr.operand if isinstance(expr, Unary) and negated else expr
    if isinstance(inner, StateRef):  # as most are
        name, bracket, index = inner.component.partition("[")
        return ((negated, name, StateRef(name, inner.state)), int(index[:-1])) if bracket else None
    if isinstance(inner, Binary) and inner.operation.is_lazy:
        return None
    if len(list(islice(walk(inner), _MOST_PARTS + 1))) > _MOST_PARTS or may_be_undefined(inner):
        return None
    components: set[str] = set()

    def named(component: str) -> str:
        components.add(component)
        return component.partition("[")[0]

    kind = with_component(inner, named)
    copy = _COPY.fullmatch(components.pop()) if len(components) == 1 else None
    return None if copy is None else ((negated, copy[1], kind), int(copy[2]))
