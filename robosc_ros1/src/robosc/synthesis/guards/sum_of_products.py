"""Irredundant sums of products of sets over many state variables, on decision diagrams.

Minato, "Fast generation of irredundant sum-of-products forms from binary decision diagrams" (SASIMI
1992), after Morreale (IEEE Trans. Electronic Computers 19, 1970), for multi-valued variables: what
is permitted for every value of the first variable is covered without reading it; only the rest of
each value needs products with a literal of that variable.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import reduce
from typing import TypeAlias

from robosc.errors import StateSpaceError

NOTHING = 0
"""The empty set, at every depth."""
END = 1
"""The set of the empty combination, below the last variable."""

_MOST_CHILDREN = 2**21
MOST_STEPS = 200_000
"""Steps, about a second, that a sum of products may take: values of nodes that are looked at."""

Product: TypeAlias = tuple[tuple[int, int], ...]
"""Per variable, the values that it must contain and those that it may contain, as bit masks."""

_Term: TypeAlias = tuple[Product, int]
"""A product over the last variables, and the set of all that it may contain."""


class TooLarge(StateSpaceError):
    """Raised when a diagram or a sum of products exceeds its budget."""


class Diagrams:
    """Multi-valued decision diagrams over variables of the given sizes; no level is skipped.

    A set is a number: ``NOTHING``, ``END``, or a node, which has a set over the following variables
    for each value of its own. Equal sets over the same variables are equal numbers.
    """

    def __init__(self, sizes: Sequence[int], most_steps: int = MOST_STEPS) -> None:
        self.sizes = tuple(sizes)
        self._most_steps = most_steps
        self._children: list[tuple[int, ...]] = [(), ()]
        self._numbers: dict[tuple[int, ...], int] = {}
        self._stored = 0
        self._steps = 0
        self._unions: dict[tuple[int, int], int] = {}
        self._differences: dict[tuple[int, int], int] = {}
        self._within: dict[tuple[int, int], bool] = {}
        self._sums: dict[tuple[int, int], tuple[tuple[_Term, ...], int]] = {}
        full = [END]
        for size in reversed(self.sizes):
            full.append(self.node((full[-1],) * size))
        self._full = full[::-1]

    def node(self, children: Iterable[int]) -> int:
        """Return the set that has these sets for the values of its first variable."""
        own = tuple(children)
        if not any(own):
            return NOTHING
        number = self._numbers.get(own)
        if number is None:
            self._stored += len(own)
            if self._stored > _MOST_CHILDREN:
                raise TooLarge("a guard reads too many values")
            number = self._numbers[own] = len(self._children)
            self._children.append(own)
        return number

    def step(self, number: int) -> None:
        """Count the values of nodes that are looked at.

        Raises:
            TooLarge: there were too many.
        """
        self._steps += number
        if self._steps > self._most_steps:
            raise TooLarge("a guard would be too long")

    def of_rows(self, rows: Iterable[tuple[int, ...]]) -> int:
        """Return the set of some combinations of values."""
        return self._of(list(rows), 0)

    def _of(self, rows: Sequence[tuple[int, ...]], depth: int) -> int:
        if not rows:
            return NOTHING
        if depth == len(self.sizes):
            return END
        by_value: list[list[tuple[int, ...]]] = [[] for _ in range(self.sizes[depth])]
        for row in rows:
            by_value[row[depth]].append(row)
        return self.node(self._of(same, depth + 1) for same in by_value)

    # --- sets

    def union(self, first: int, second: int) -> int:
        if first == second or not second:
            return first
        if not first:
            return second
        key = (first, second) if first < second else (second, first)
        union = self._unions.get(key)
        if union is None:
            pairs = zip(self._children[first], self._children[second], strict=True)
            union = self._unions[key] = self.node([self.union(a, b) for a, b in pairs])
        return union

    def difference(self, first: int, second: int) -> int:
        if first == second or not first:
            return NOTHING
        if not second:
            return first
        difference = self._differences.get((first, second))
        if difference is None:
            self.step(len(self._children[first]))
            pairs = zip(self._children[first], self._children[second], strict=True)
            difference = self.node([self.difference(a, b) for a, b in pairs])
            self._differences[first, second] = difference
        return difference

    def complement(self, of: int) -> int:
        return self.difference(self._full[0], of)

    def _intersection(self, first: int, second: int) -> int:
        return self.difference(first, self.difference(first, second))

    # --- sums of products

    def products(self, inside: int, upper: int) -> tuple[Product, ...]:
        """Return an irredundant sum of products that contains ``inside`` and is within ``upper``.

        Raises:
            TooLarge: it takes too many steps.
        """
        return tuple(product for product, _ in self._sum(inside, upper, 0)[0])

    def _sum(self, lower: int, upper: int, depth: int) -> tuple[tuple[_Term, ...], int]:
        """Return products over the variables from ``depth`` on, and the set that they cover."""
        if not lower:
            return (), NOTHING
        if upper == self._full[depth]:
            everything = tuple((full, full) for full in map(full_mask, self.sizes[depth:]))
            return ((everything, upper),), upper
        products = self._sums.get((lower, upper))
        if products is None:
            products = self._sums[lower, upper] = self._new_sum(lower, upper, depth)
        return products

    def _new_sum(self, lower: int, upper: int, depth: int) -> tuple[tuple[_Term, ...], int]:
        self.step(self.sizes[depth])
        low, high = self._children[lower], self._children[upper]
        common = reduce(self._intersection, dict.fromkeys(high))
        needed: dict[_Term, int] = {}
        covered = [NOTHING] * len(low)
        for (inside, most), values in _groups(zip(low, high, strict=True)):
            rest = self.difference(inside, common)
            if not rest:
                continue
            terms, held = self._sum(rest, most, depth + 1)
            for term in terms:
                needed[term] = needed.get(term, 0) | sum(1 << value for value in values)
            for value in values:
                covered[value] = held
        left = NOTHING
        for inside, held in zip(low, covered, strict=True):
            left = self.union(left, self.difference(inside, held))
        terms, held = self._sum(left, common, depth + 1)
        full = full_mask(self.sizes[depth])
        products = [
            self._term((mask, self._free(high, term[1], mask)), term)
            for term, mask in needed.items()
        ]
        products += [self._term((full, full), term) for term in terms]
        return tuple(products), self.node([self.union(inside, held) for inside in covered])

    def _term(self, values: tuple[int, int], rest: _Term) -> _Term:
        """Return a product extended by the values of the variable before its first."""
        _, free = values
        size = self.sizes[len(self.sizes) - len(rest[0]) - 1]
        node = self.node(rest[1] if free >> value & 1 else NOTHING for value in range(size))
        return (values, *rest[0]), node

    def _free(self, high: Sequence[int], held: int, mask: int) -> int:
        """Return the values that a product may have in addition and stay within the upper sets."""
        for value, upper in enumerate(high):
            if self._is_within(held, upper):
                mask |= 1 << value
        return mask

    def _is_within(self, first: int, second: int) -> bool:
        if first == second or not first:
            return True
        if not second:
            return False
        within = self._within.get((first, second))
        if within is None:
            self.step(1)
            pairs = {*zip(self._children[first], self._children[second], strict=True)}
            within = self._within[first, second] = all(self._is_within(a, b) for a, b in pairs)
        return within


def full_mask(size: int) -> int:
    """Return the mask of all values of a variable."""
    return (1 << size) - 1


def _groups(
    pairs: Iterable[tuple[int, int]],
) -> Iterator[tuple[tuple[int, int], list[int]]]:
    """Yield the distinct pairs of lower and upper sets, each with its values."""
    groups: dict[tuple[int, int], list[int]] = {}
    for value, pair in enumerate(pairs):
        groups.setdefault(pair, []).append(value)
    yield from groups.items()
