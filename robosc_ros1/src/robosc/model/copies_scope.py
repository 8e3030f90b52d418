"""The meaning of names in one copy of a component, or of the statements of a ``for``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Set
from dataclasses import dataclass, field, replace
from typing import Any

from robosc.syntax.nodes import ExprNode

__all__ = ["Scope", "with_place"]

_PLACEHOLDER = re.compile(r"\{([A-Za-z_]\w*)\}", re.ASCII)


@dataclass(frozen=True)
class Scope:
    """The meanings of names in the copy that is being made.

    ``index`` and the variables of ``for`` are numbers, the variables of aggregates over components
    the names of components, and the conditions declared in a ``for`` expressions.
    """

    names: Mapping[str, int | str | ExprNode] = field(default_factory=dict)

    def inside(self, name: str, meaning: int | str | ExprNode) -> Scope:
        """The scope with one more name, which hides an outer one."""
        return Scope({**self.names, name: meaning})

    @property
    def numbers(self) -> dict[str, int]:
        return {name: number for name, number in self.names.items() if isinstance(number, int)}

    def meanings(self, words: Set[str]) -> tuple[tuple[str, int | str], ...]:
        """What tells two scopes apart for a text of these words; of an expression its identity."""
        return tuple(
            (name, meaning if isinstance(meaning, int | str) else f"condition {id(meaning)}")
            for name, meaning in self.names.items()
            if name in words
        )

    def place(self) -> str:
        """The indexes as text for messages and comments: ``i = 3, j = 4``."""
        return ", ".join(f"{name} = {value}" for name, value in self.numbers.items())

    def filled_in(self, text: str) -> str:
        """A string with its placeholders ``{index}`` and ``{i}`` replaced."""
        numbers = self.numbers
        return _PLACEHOLDER.sub(lambda match: str(numbers.get(match[1], match[0])), text)


def with_place(copy: Any, scope: Scope) -> Any:
    """The copy of a statement with the text of its indexes, if its kind has one."""
    return replace(copy, place=scope.place()) if hasattr(copy, "place") and not copy.place else copy
