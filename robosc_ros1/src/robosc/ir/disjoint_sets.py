"""Disjoint sets of items that belong together (union-find; Tarjan, J. ACM 22(2), 1975)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import Generic, TypeVar

__all__ = ["DisjointSets"]

_Item = TypeVar("_Item", bound=Hashable)


class DisjointSets(Generic[_Item]):
    """A partition of items; one that was never joined is a set of its own."""

    def __init__(self) -> None:
        self._parents: dict[_Item, _Item] = {}

    def find(self, item: _Item) -> _Item:
        """Return the representative of the set that contains an item."""
        parents = self._parents
        while (parent := parents.get(item, item)) != item:
            parents[item] = parents.get(parent, parent)
            item = parent
        return item

    def join(self, items: Iterable[_Item]) -> None:
        """Join the sets that contain the items."""
        roots = [self.find(item) for item in items]
        for root in roots[1:]:
            self._parents[root] = roots[0]
