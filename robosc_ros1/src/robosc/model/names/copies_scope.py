"""The meaning of names in one copy of a component, or of the statements of a ``for``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Set
from dataclasses import dataclass, field, replace
from typing import Any

from robosc import limits, source
from robosc.model.diagnostics import Report
from robosc.names import Copy
from robosc.syntax import nodes

_PLACEHOLDER = re.compile(r"\{([A-Za-z_]\w*)\}", re.ASCII)


@dataclass(frozen=True)
class Scope:
    """The meanings of names in the copy that is being made.

    ``index`` and the variables of ``for`` are numbers, the variables of aggregates over components
    the names of components, and the conditions declared in a ``for`` expressions. ``own`` is the
    copy of a component that is being made: the bare name ``family`` means it.
    """

    names: Mapping[str, int | str | nodes.ExprNode] = field(default_factory=dict)
    own: Copy | None = None

    @property
    def family(self) -> str:
        return "" if self.own is None else self.own.family

    def inside(self, name: str, meaning: int | str | nodes.ExprNode) -> Scope:
        """The scope with one more name, which hides an outer one."""
        return replace(self, names={**self.names, name: meaning})

    @property
    def numbers(self) -> dict[str, int]:
        return {name: number for name, number in self.names.items() if isinstance(number, int)}

    def meanings(self, words: Set[str]) -> tuple[tuple[str, int | str], ...]:
        """What tells two scopes apart for a text of these words; of an expression its identity."""
        found = tuple(
            (name, meaning if isinstance(meaning, int | str) else f"condition {id(meaning)}")
            for name, meaning in self.names.items()
            if name in words
        )
        own = () if self.own is None or self.family not in words else (("", self.own.name),)
        return *found, *own

    def filled_in(self, text: str) -> str:
        """A string with its placeholders ``{index}`` and ``{i}`` replaced."""
        numbers = self.numbers
        return _PLACEHOLDER.sub(lambda match: str(numbers.get(match[1], match[0])), text)


def repeated(statement: Any, scope: Scope, block: source.Span) -> Any:
    """A statement that is one of the copies of those in a block, if its kind tells that."""
    if not hasattr(statement, "repeated") or statement.repeated is not None:
        return statement
    return replace(statement, repeated=nodes.Repeated(tuple(scope.numbers.items()), block))


def indexes_of(node: nodes.RangeNode, report: Report) -> range:
    """The indexes of a range; only the first one after a reported error."""
    if node.first > node.last:
        message = f"{node.first} is greater than {node.last}"
        report.add("empty-range", node.span, message, "write the smaller one first")
    elif node.last - node.first >= limits.COPIES:
        message = f"this range has more than {limits.COPIES:,} indexes"
        report.add("bad-index", node.span, message)
    else:
        return range(node.first, node.last + 1)
    return range(node.first, node.first + 1)


def indexes_of_for(node: nodes.ForNode, scope: Scope, report: Report) -> range:
    """The indexes of a ``for``, with the statements of all that are in it taken into account."""
    indexes = indexes_of(node.indexes, report)
    if len(indexes) == 1 or _statements_from(node) <= limits.STATEMENTS:
        return indexes
    if not scope.numbers:  # reported once, for the outermost
        message = f"this makes more than {limits.STATEMENTS:,} statements"
        report.add("bad-index", node.indexes.span, message)
    return indexes[:1]


def _statements_from(node: nodes.ForNode) -> int:
    """How many statements a ``for`` stands for, if all its ranges have a permitted length."""
    length = min(max(0, node.indexes.last - node.indexes.first + 1), limits.COPIES)
    each = (_statements_from(s) if isinstance(s, nodes.ForNode) else 1 for s in node.statements)
    return length * max(1, sum(each))  # an empty one is visited, too
