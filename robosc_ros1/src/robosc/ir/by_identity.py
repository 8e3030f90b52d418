"""What was found of expressions, by their identity."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from robosc.model.expr import Expr

__all__ = ["ByIdentity"]

_Found = TypeVar("_Found")


class ByIdentity(Generic[_Found]):
    """Finds something once for each expression.

    Large conditions are shared, as by the requirements of copies, and hashing them would go
    through all of them. Each is kept, so that no other one gets its identity.
    """

    def __init__(self) -> None:
        self._found: dict[int, tuple[Expr, _Found]] = {}

    def known(self, expr: Expr) -> _Found | None:
        """What was found of an expression before."""
        return self._found.get(id(expr), (expr, None))[1]

    def of(self, expr: Expr, find: Callable[[Expr], _Found]) -> _Found:
        known = self._found.get(id(expr))
        if known is None:
            known = self._found[id(expr)] = (expr, find(expr))
        return known[1]
