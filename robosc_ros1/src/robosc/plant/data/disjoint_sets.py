"""Disjoint sets of items that belong together (union-find; Tarjan, J. ACM 22(2), 1975)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TypeVar

_Item = TypeVar("_Item", bound=Hashable)


class DisjointSets:
    """A partition of items; one that was never joined is a set of its own."""

    def __init__(self) -> None:
        self._parents: dict[Hashable, Hashable] = {}

    def find(self, item: Hashable) -> Hashable:
        """Return the representative of the set that contains an item."""
        parents = self._parents
        while (parent := parents.get(item, item)) != item:
            parents[item] = parents.get(parent, parent)
            item = parent
        return item

    def join(self, items: Iterable[Hashable]) -> None:
        """Join the sets that contain the items."""
        roots = [self.find(item) for item in items]
        for root in roots[1:]:
            self._parents[root] = roots[0]

    def groups(self, items: Iterable[_Item]) -> list[list[_Item]]:
        """Return some items as groups, one per set, in the order of first members."""
        found: dict[Hashable, list[_Item]] = {}
        for item in items:
            found.setdefault(self.find(item), []).append(item)
        return list(found.values())
