"""Recognises counts, ``any`` and ``all`` in conditions where they have been expanded.

Reading a model expands ``count(s.served for s in Station) < 2`` into a condition with all cases.
Texts made from such conditions (guards) show the count again, so that people can read them. A count
is recognised by its form: exactly the tree that expanding it gives. Operands of a chain that are
the same condition on each component become ``any`` or ``all``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import islice
from operator import is_not
from typing import TypeGuard

from robosc import dotted, names
from robosc.expr import identity_cache, quantified, tree, types
from robosc.expr.traversal import may_be_undefined, operands, rewritten, walk
from robosc.model.entities import Robot

_LEAST_COPIES = 3
"""Conditions on fewer components are listed one by one."""

_LEAST_LISTED = 4
"""Counts of fewer conditions that are not on components of one kind stay expanded."""

_LEAST_CHAINED = 8
"""A chain of fewer conditions is not treated as a count."""

_BOOLEAN = types.BooleanType()
_MOST_PARTS = 8

_Kind = tuple[bool, str, tree.Expr]
"""What conditions on copies of a component have in common: whether they are negated, the name
without an index, and the condition on a component of that name."""


def with_counts(expr: tree.Expr, robot: Robot, *, chains: bool = True) -> tree.Expr:
    """Return the condition with counts (``chains``: also ``any`` and ``all``) recognised."""
    return _Finder(chains, robot).found(expr)


def with_component(expr: tree.Expr, name: Callable[[str], str]) -> tree.Expr:
    """Return the condition with each component that it reads renamed by ``name``."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        match node:
            case tree.StateRef(component=component):
                return replace(node, component=name(component))
            case tree.VariableRef(component=component, variable=variable, type=type_):
                return tree.VariableRef(name(component), variable, type_)
            case tree.PhaseRef(communication=key):
                return replace(
                    node, communication=f"{name(dotted.first(key))}.{dotted.inside(key)}"
                )
        return node

    return rewritten(expr, leaf)


def counts(expr: tree.Expr, robot: Robot) -> Iterator[tree.Count]:
    """Yield the counts in a condition; a long chain is a count of all, or at least one."""
    for part in walk(with_counts(expr, robot)):
        negated = isinstance(part, tree.Unary) and part.operator == "!"
        whole = part.operand if isinstance(part, tree.Unary) and negated else part
        if isinstance(whole, tree.Count):
            yield replace(whole, negated=whole.negated != negated)
        elif _is_junction(whole):
            parts = operands(whole, whole.operator)
            if len(parts) >= _LEAST_CHAINED and not any(
                _is_junction(one) or isinstance(one, tree.Count) or may_be_undefined(one)
                for one in parts
            ):
                yield _counted(parts, 1 if whole.operator == "or" else len(parts), negated)


def tighter(count: tree.Count) -> tree.Expr | None:
    """Return the expanded condition with a bound that is tighter by one; None: it would be too
    large."""
    tight = quantified.at_least(count.conditions, count.least + (-1 if count.negated else 1))
    return tight if tight is None or not count.negated else tree.Unary("!", tight, _BOOLEAN)


class _Finder:
    """Finds counts; each shared subexpression of a robot is examined once."""

    def __init__(self, chains: bool, robot: Robot) -> None:
        self._chains = chains
        self._found: identity_cache.IdentityCache[tree.Expr] = identity_cache.IdentityCache()
        self._counts, self._sizes = robot.counts

    def found(self, expr: tree.Expr) -> tree.Expr:
        return self._found.of(expr, self._find)

    def _find(self, expr: tree.Expr) -> tree.Expr:
        match expr:
            case tree.Unary(operator="!", operand=operand):
                inner = self.found(operand)
                if isinstance(inner, tree.Count):
                    return replace(inner, negated=not inner.negated)
                return expr if inner is operand else tree.Unary("!", inner, _BOOLEAN)
            case tree.Binary(operator="and" | "or" as operator):
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
                return quantified.chain(operator, new)
            case tree.Binary(operator="=>", left=left, right=right):
                sides = self.found(left), self.found(right)
                if sides[0] is not left or sides[1] is not right:
                    return tree.Binary("=>", *sides, _BOOLEAN)
        return expr

    def _operands(self, expr: tree.Expr, operator: str) -> Iterator[tree.Expr]:
        """Yield the operands of a chain; an operand that is a count is not split."""
        if not isinstance(expr, tree.Binary) or expr.operator != operator or self._count(expr):
            yield expr
        else:
            yield from self._operands(expr.left, operator)
            yield from self._operands(expr.right, operator)

    def _count(self, expr: tree.Binary) -> tree.Count | None:
        """Return the count with this expansion; None if there is none, or it is ``any`` or
        ``all``."""
        return self._counts.of(expr, self._new_count)

    def _new_count(self, expr: tree.Expr) -> tree.Count | None:
        number, written = self._size(expr)
        return _count_of(expr, number, written)

    def _size(self, expr: tree.Expr) -> tuple[int, int]:
        """Return the least number of conditions that must hold (if the operands of each ``and``
        have none in common), and the number of leaves."""
        return self._sizes.of(expr, self._new_size) if _is_junction(expr) else (1, 1)

    def _new_size(self, expr: tree.Expr) -> tuple[int, int]:
        assert isinstance(expr, tree.Binary)
        (left, few), (right, many) = map(self._size, expr.operands)
        return left + right if expr.operator == "and" else min(left, right), few + many


def _count_of(expr: tree.Expr, number: int, written: int) -> tree.Count | None:
    if number < 2 or (size := _counted_of(number, written)) is None:
        return None
    conditions = list(_conditions(expr))
    if (
        len(conditions) != size
        or any(map(may_be_undefined, conditions))
        or (len(conditions) < _LEAST_LISTED and _copies(conditions) is None)
    ):
        return None
    # The order of the conditions must match, too: that of a list was chosen by the user.
    return _counted(conditions, number) if quantified.at_least(conditions, number) == expr else None


def _conditions(expr: tree.Expr) -> dict[tree.Expr, None]:
    """Return the conditions of the count, in order, if the expression is the expansion of one."""
    conditions: dict[tree.Expr, None] = {}
    seen: set[int] = set()
    stack = [expr]
    while stack:
        node = stack.pop()
        if not _is_junction(node):
            conditions.setdefault(node)
        elif id(node) not in seen:
            seen.add(id(node))
            parts = operands(node, node.operator)
            # In an expansion the last case has the most conditions of the first half; an ``or`` of
            # plain conditions has no cases.
            is_in_order = node.operator == "and" or not any(map(_is_junction, parts))
            stack += reversed(parts) if is_in_order else parts
    return conditions


def _is_junction(expr: tree.Expr) -> TypeGuard[tree.Binary]:
    return isinstance(expr, tree.Binary) and expr.operator in ("and", "or")


@cache
def _counted_of(number: int, written: int) -> int | None:
    """Return of how many conditions the expansion of "at least ``number`` of them hold" has so many
    leaves; None: of no number of them. Without it each part of a large condition would be read."""
    size = number + 1
    while _written(size, number) < written:
        size += 1
    return size if _written(size, number) == written else None


@cache
def _written(conditions: int, number: int) -> int:
    """Return the number of leaves of the expansion of "at least ``number`` of them hold"."""
    if number in (0, 1, conditions):
        return conditions if number else 0
    left = conditions // 2  # as in :func:`robosc.expr.quantified.at_least`
    right = conditions - left
    return sum(
        _written(left, first) + _written(right, number - first)
        for first in range(max(0, number - right), min(number, left) + 1)
    )


def _grouped(operator: str, parts: Sequence[tree.Expr]) -> list[tree.Expr]:
    """Return the operands of a chain, the same conditions on copies of a component as one."""
    kinds: dict[_Kind, dict[int, int]] = {}
    for place, part in enumerate(parts):
        literal = _literal(part)
        if literal is not None:
            kinds.setdefault(literal[0], {}).setdefault(literal[1], place)
    left: dict[int, tree.Expr] = dict(enumerate(parts))
    for (negated, _, _), places in kinds.items():
        for run in _runs(sorted(places)):
            conditions = [parts[places[index]] for index in run]
            if negated:
                conditions = [c.operand for c in conditions if isinstance(c, tree.Unary)]
            # All of them hold if and only if not any of their opposites does.
            is_any = (operator == "or") != negated
            count = _counted(conditions, 1 if is_any else len(conditions), negated)
            first, *others = sorted(places[index] for index in run)
            left[first] = count
            for place in others:
                del left[place]
    return [left[place] for place in sorted(left)]


def _counted(conditions: Sequence[tree.Expr], least: int, negated: bool = False) -> tree.Count:
    return tree.Count("", (), _BOOLEAN, conditions=tuple(conditions), least=least, negated=negated)


def _runs(indexes: Sequence[int]) -> Iterator[list[int]]:
    """Yield the runs of consecutive indexes that are long enough."""
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


def copies_of(count: tree.Count) -> tuple[str, int] | None:
    """Return the name and the first index of the copies counted; None: it counts a list."""
    return _copies(count.conditions)


def _copies(conditions: Sequence[tree.Expr]) -> tuple[str, int] | None:
    read = [_literal(condition) for condition in conditions]
    first, kinds = read[0], {literal and literal[0] for literal in read}
    if first is None or len(kinds) > 1 or not _is_run([index for _, index in filter(None, read)]):
        return None
    (_, name, _), index = first
    return name, index


def _literal(expr: tree.Expr) -> tuple[_Kind, int] | None:
    """Return kind and index of a condition on one copy of a component; None if it is none."""
    negated = isinstance(expr, tree.Unary) and expr.operator == "!"
    inner = expr.operand if isinstance(expr, tree.Unary) and negated else expr
    if isinstance(inner, tree.StateRef):  # as most are
        copy = names.Copy.of(inner.component)
        if copy is None:
            return None
        return (negated, copy.family, replace(inner, component=copy.family)), copy.index
    if isinstance(inner, tree.Binary) and inner.operation.is_lazy:
        return None
    if len(list(islice(walk(inner), _MOST_PARTS + 1))) > _MOST_PARTS or may_be_undefined(inner):
        return None
    components: set[str] = set()

    def named(component: str) -> str:
        components.add(component)
        return names.declared(component)

    shared = with_component(inner, named)
    copy = names.Copy.of(components.pop()) if len(components) == 1 else None
    return None if copy is None else ((negated, copy.family, shared), copy.index)
