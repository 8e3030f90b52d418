"""The meaning of names in one copy of a component, or of the statements of a ``for``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from robosc.syntax.nodes import ExprNode

__all__ = ["Scope", "filled_in", "is_alike", "with_place"]

_PLACEHOLDER = re.compile(r"\{([A-Za-z_]\w*)\}", re.ASCII)


@dataclass(frozen=True)
class Scope:
    """The bindings of names in the copy that is being made.

    ``numbers`` are ``index`` and the variables of ``for``, ``components`` the variables of
    aggregates over components, and ``conditions`` those that are named in the ``for``.
    """

    numbers: Mapping[str, int] = field(default_factory=dict)
    components: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, ExprNode] = field(default_factory=dict)

    def number(self, name: str, value: int) -> Scope:
        return replace(self, numbers={**self.numbers, name: value})

    def component(self, name: str, component: str) -> Scope:
        return replace(self, components={**self.components, name: component})

    def condition(self, name: str, value: ExprNode) -> Scope:
        return replace(self, conditions={**self.conditions, name: value})

    def place(self) -> str:
        """The indexes as text for messages and comments: ``i = 3, j = 4``."""
        return ", ".join(f"{name} = {value}" for name, value in self.numbers.items())


def filled_in(text: str, scope: Scope) -> str:
    """A string with its placeholders ``{index}`` and ``{i}`` replaced."""
    return _PLACEHOLDER.sub(
        lambda match: str(scope.numbers.get(match[1], match[0])),
        text,
    )


def with_place(copy: Any, scope: Scope) -> Any:
    """The copy of a statement with the text of its indexes, if its kind has one."""
    return replace(copy, place=scope.place()) if hasattr(copy, "place") and not copy.place else copy


def is_alike(node: ExprNode, scope: Scope) -> bool:
    """Whether a node is the same in all copies: names no number or condition of the scope."""
    words = set(re.findall(r"\w+", node.span.text))
    return words.isdisjoint({*scope.numbers, *scope.conditions})
