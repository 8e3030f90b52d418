"""A cache of results for expressions, by their identity."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from robosc.expr.tree import Expr

_Found = TypeVar("_Found")


class IdentityCache(Generic[_Found]):
    """Computes a result once for each expression object.

    Large conditions are shared objects (for instance by the requirements of component copies), and
    hashing one would traverse it. The expressions are kept alive, so that no identity is reused.
    """

    def __init__(self) -> None:
        self._found: dict[int, tuple[Expr, _Found]] = {}

    def known(self, expr: Expr) -> _Found | None:
        """Return the cached result; None if there is none."""
        return self._found.get(id(expr), (expr, None))[1]

    def of(self, expr: Expr, find: Callable[[Expr], _Found]) -> _Found:
        """The result for an expression, computed by ``find`` the first time."""
        known = self._found.get(id(expr))
        if known is None:
            known = self._found[id(expr)] = (expr, find(expr))
        return known[1]
