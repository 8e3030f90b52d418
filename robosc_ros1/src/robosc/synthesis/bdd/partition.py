"""Partitions of the states by the value of an expression, and operators on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TypeAlias

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.expr.evaluation import scalar_of
from robosc.expr.tree import Holds, Operation
from robosc.expr.types import Value
from robosc.language.operators import Operator
from robosc.synthesis.bdd.manager import Bdd, Manager

Partition: TypeAlias = list[tuple[Value | None, Bdd]]
"""The values that an expression can have, each once, with the states in which it has it.

The value None stands for undefined.
"""


def key_of(value: Value | None) -> object:
    """Return a key by which values are distinguished; for floats their text.

    0.0 and -0.0 are distinct, as divisors differ; NaN equals itself.
    """
    return repr(value) if isinstance(value, float) else (type(value), value)


def combined(manager: Manager, node: Operation, operands: Sequence[Partition]) -> Partition:
    """Return the partition of an operation, given those of its operands."""
    if isinstance(node, Holds):
        return _present(manager, operands[0])
    if len(operands) == 1:
        return _each(manager, scalar_of(node), operands[0])
    if node.operator == "else":
        return _otherwise(manager, *operands)
    if node.operation.is_lazy:
        return _lazily(manager, node.operation, *operands)
    return _strictly(manager, node.operation.scalar, *operands)


def _each(manager: Manager, scalar: Callable[..., Value], operand: Partition) -> Partition:
    grouped = _Grouping()
    for value, states in operand:
        grouped.add(None if value is None else scalar(value), states)
    return grouped.partition(manager)


def _present(manager: Manager, operand: Partition) -> Partition:
    """Return where a condition is defined and true, or where data are there."""
    grouped = _Grouping()
    for value, states in operand:
        grouped.add(value is not None and value is not False, states)
    return grouped.partition(manager)


def _otherwise(manager: Manager, left: Partition, right: Partition) -> Partition:
    """Return the partition of ``left else right``."""
    grouped = _Grouping()
    for value, states in left:
        if value is None or value != value:
            grouped.add_within(states, right)
        else:
            grouped.add(value, states)
    return grouped.partition(manager)


def _lazily(manager: Manager, operation: Operator, left: Partition, right: Partition) -> Partition:
    """Return the partition of an operator whose left operand may decide alone."""
    grouped = _Grouping()
    for value, states in left:
        if value is None:
            grouped.add(None, states)
        elif value is operation.decider:
            grouped.add(operation.decided, states)
        else:
            grouped.add_within(states, right)
    return grouped.partition(manager)


def _strictly(
    manager: Manager, scalar: Callable[..., Value], left: Partition, right: Partition
) -> Partition:
    """Return the partition of an operator that is undefined where an operand is.

    Raises:
        StateSpaceError: there are more than ``limits.OPERAND_PAIRS`` pairs of values.
    """
    if len(left) * len(right) > limits.OPERAND_PAIRS:
        raise StateSpaceError(
            f"an expression combines {len(left)} values with {len(right)}: "
            "reduce the ranges of the variables that it reads"
        )
    grouped = _Grouping()
    ranges = _Ranges(manager, [states for _, states in right])
    for first, states in left:
        # Neighbouring values often have the same result (comparisons have two) and are grouped.
        results = [
            None if first is None or second is None else scalar(first, second)
            for second, _ in right
        ]
        start = 0
        for result, run in groupby(results, key=key_of):
            end = start + sum(1 for _ in run)
            grouped.add(results[start], states & ranges.union(start, end), result)
            start = end
    return grouped.partition(manager)


class _Ranges:
    """Unions of ranges of a list of sets, from cached unions of 1, 2, 4, 8..."""

    def __init__(self, manager: Manager, sets: list[Bdd]) -> None:
        self._manager = manager
        self._levels = [sets]

    def union(self, start: int, end: int) -> Bdd:
        parts = []
        level = 0
        while start < end:
            sets = self._level(level)
            if start % 2:
                parts.append(sets[start])
                start += 1
            if end % 2:
                end -= 1
                parts.append(sets[end])
            start, end, level = start // 2, end // 2, level + 1
        return self._manager.union(parts)

    def _level(self, number: int) -> list[Bdd]:
        if number == len(self._levels):
            below = self._levels[-1]
            pairs = zip(below[::2], below[1::2], strict=False)
            self._levels.append([first | second for first, second in pairs])
        return self._levels[number]


class _Grouping:
    """Sets of states collected by value."""

    def __init__(self) -> None:
        self._found: dict[object, tuple[Value | None, list[Bdd]]] = {}

    def add(self, value: Value | None, states: Bdd, key: object = None) -> None:
        """Add states; ``key`` is ``key_of(value)`` if it is known already."""
        found = key_of(value) if key is None else key
        self._found.setdefault(found, (value, []))[1].append(states)

    def add_within(self, states: Bdd, partition: Partition) -> None:
        """Add the part of a partition that lies within these states."""
        for value, others in partition:
            self.add(value, states & others)

    def partition(self, manager: Manager) -> Partition:
        united = [(value, manager.union(sets)) for value, sets in self._found.values()]
        return [(value, states) for value, states in united if states != manager.false]
