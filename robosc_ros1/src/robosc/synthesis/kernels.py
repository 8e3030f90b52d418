"""What operations do to arrays of states: images, preimages and what is lost, in place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from robosc.synthesis.columns import Bools
from robosc.synthesis.layout import Operation

__all__ = ["Stages", "backward", "count", "forward", "image", "preimage", "uncontrolled"]

Stages: TypeAlias = Sequence[Sequence[Operation]]
"""An event: its operations in stages that follow one another; one stage is the rule."""


def count(states: Bools) -> int:
    """How many states there are in what an operation slices out."""
    if states.dtype != np.bool_:
        states = np.ascontiguousarray(states).view(np.bool_)
    return int(np.count_nonzero(states))


def image(stages: Stages, states: Bools) -> Bools:
    """The states after an event, as an array of its own."""
    for stage in stages:
        after = np.zeros(states.size, np.bool_)
        for op in stage:
            forward(op, states, after, None)
        states = after
    return states


def preimage(stages: Stages, states: Bools) -> Bools:
    """The states before an event, as an array of its own."""
    for stage in reversed(stages):
        before = np.zeros(states.size, np.bool_)
        for op in stage:
            found = _targets(op, states)
            for number in range(len(op.sources)):
                here = op.slice(before, op.sources[number][0])
                np.bitwise_or(here, _masked(op, number, found), out=here)
        states = before
    return states


def _masked(op: Operation, number: int, states: Bools) -> Bools:
    for mask in op.sources[number][1]:
        states = states & op.mask(mask)
    return states


def _sources(op: Operation, states: Bools, numbers: Sequence[int]) -> Bools:
    """Some sources of an operation in one."""
    found = op.source(states, numbers[0])
    for number in numbers[1:]:
        found = found | op.source(states, number)
    return found


def _targets(op: Operation, states: Bools) -> Bools:
    """All targets of an operation in one."""
    found = op.slice(states, op.targets[0])
    for target in op.targets[1:]:
        found = found | op.slice(states, target)
    return found


def forward(op: Operation, states: Bools, after: Bools, within: Bools | None) -> None:
    """Add to ``after`` what an operation makes of ``states``, inside ``within`` if given.

    Both may be one array.
    """
    numbers = op.leaving if states is after else range(len(op.sources))
    if not numbers:
        return
    found = _sources(op, states, numbers)
    for target in op.targets:
        here = op.slice(after, target)
        if within is None:
            np.bitwise_or(here, found, out=here)
        else:
            np.bitwise_or(here, found & op.slice(within, target), out=here)


def backward(op: Operation, states: Bools, within: Bools | None) -> None:
    """Add to ``states`` what leads to them by an operation, inside ``within`` if given."""
    numbers = op.leaving
    if not numbers:
        return
    found = _targets(op, states)
    for number in numbers:
        source = op.sources[number][0]
        here = op.slice(states, source)
        add = _masked(op, number, found)
        if within is not None:
            add = add & op.slice(within, source)
        np.bitwise_or(here, add, out=here)


def uncontrolled(op: Operation, good: Bools) -> None:
    """Take out of ``good`` what an operation can lead out of it."""
    numbers = op.leaving
    if not numbers:
        return
    safe = op.slice(good, op.targets[0])
    for target in op.targets[1:]:
        safe = safe & op.slice(good, target)
    for number in numbers:
        source, masks = op.sources[number]
        here = op.slice(good, source)
        kept = safe
        if masks:
            where = op.mask(masks[0])
            for mask in masks[1:]:
                where = where & op.mask(mask)
            kept = np.logical_or(safe, np.logical_not(where))
        np.bitwise_and(here, kept, out=here)
