"""Images and preimages of sets of states under operations, partly in place."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import and_, or_
from typing import TypeAlias

import numpy as np

from robosc.synthesis.dense.bitset import Bitset, count
from robosc.synthesis.dense.operations import Operation, SourceSlice

Stages: TypeAlias = Sequence[Sequence[Operation]]
"""The operations of an event in stages that follow one another, in most cases a single one."""


def image(stages: Stages, states: Bitset) -> Bitset:
    """Return the states after an event, as a new array."""
    for stage in stages:
        after = np.zeros_like(states)
        for op in stage:
            forward(op, states, after, None)
        states = after
    return states


def preimage(stages: Stages, states: Bitset) -> Bitset:
    """Return the states before an event, as a new array."""
    for stage in reversed(stages):
        before = np.zeros_like(states)
        for op in stage:
            origins = op.moved_back(_targets(op, states))
            for source in op.sources:
                here = op.at(before, source.offset)
                np.bitwise_or(here, op.masked(source, origins), out=here)
        states = before
    return states


def forward(op: Operation, states: Bitset, after: Bitset, within: Bitset | None) -> None:
    """Add to ``after`` the image of ``states``, restricted to ``within`` if given.

    ``states`` and ``after`` may be the same array.
    """
    sources = op.changing if states is after else op.sources
    if not sources:
        return
    reached = op.moved(_sources(op, states, sources))
    for target in op.targets:
        here = op.at(after, target)
        new = reached if within is None else reached & op.at(within, target)
        np.bitwise_or(here, new, out=here)


def backward(op: Operation, states: Bitset, within: Bitset | None) -> None:
    """Add to ``states`` their preimage, restricted to ``within`` if given."""
    sources = op.changing
    if not sources:
        return
    origins = op.moved_back(_targets(op, states))
    for source in sources:
        here = op.at(states, source.offset)
        new = op.masked(source, origins)
        if within is not None:
            new = new & op.at(within, source.offset)
        np.bitwise_or(here, new, out=here)


def uncontrolled(op: Operation, good: Bitset) -> None:
    """Remove from ``good`` the states that an operation can lead out of it."""
    sources = op.changing
    if not sources:
        return
    safe = reduce(and_, (op.at(good, target) for target in op.targets))
    lost = op.moved_back(np.bitwise_not(safe))
    for source in sources:
        here = op.at(good, source.offset)
        np.bitwise_and(here, np.bitwise_not(op.masked(source, lost)), out=here)


def applying(ops: Iterable[Operation], states: Bitset, within: Bitset | None = None) -> Bitset:
    """Return from which of ``states`` operations lead, into ``within`` if given, as a new array."""
    places = np.zeros_like(states)
    for op in ops:
        for source in op.sources:
            into = op.at(places, source.offset)
            np.bitwise_or(into, _origins(op, source, states, within), out=into)
    return places


def _origins(op: Operation, source: SourceSlice, states: Bitset, within: Bitset | None) -> Bitset:
    """Return the states of a source from which an operation leads into ``within`` if given.

    An operation without targets leads nowhere; all states that it applies to are returned.
    """
    origins = op.masked(source, op.at(states, source.offset)) & op.held
    if within is not None:
        origins = origins & op.moved_back(op.at(within, op.targets[0]))
    return origins


def measure(op: Operation, states: Bitset, within: Bitset | None = None) -> int:
    """Return from how many of ``states`` an operation leads, into ``within`` if given."""
    return sum(count(_origins(op, source, states, within)) for source in op.sources)


def clear(op: Operation, states: Bitset) -> None:
    """Remove the states that an operation applies to from ``states``."""
    for source in op.sources:
        here = op.at(states, source.offset)
        there = op.masked(source, np.broadcast_to(op.held, op.shape))
        np.bitwise_and(here, np.bitwise_not(there), out=here)


def _sources(op: Operation, states: Bitset, sources: Sequence[SourceSlice]) -> Bitset:
    """Return the union of some sources of an operation."""
    return reduce(or_, (op.masked(source, op.at(states, source.offset)) for source in sources))


def _targets(op: Operation, states: Bitset) -> Bitset:
    """Return the union of the targets of an operation."""
    return reduce(or_, (op.at(states, target) for target in op.targets))
