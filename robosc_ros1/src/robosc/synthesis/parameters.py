"""The values that the parameters of an event can have."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product
from math import prod

from robosc.ir.automaton import Event
from robosc.ir.partial_evaluation import PartValues
from robosc.ir.step import Values, valuations
from robosc.model.expr import Expr, ValueRef
from robosc.model.traversal import walk

__all__ = ["choices", "weight"]


def choices(event: Event, read: Iterable[Expr]) -> Iterator[PartValues]:
    """All combinations of the parameters that the expressions read; one, empty, if none."""
    paths = {node.path for expr in read for node in walk(expr) if isinstance(node, ValueRef)}
    used = [i for i, p in enumerate(event.parameters) if p.path in paths]
    taken = [event.parameters[i] for i in used]
    combinations: Iterable[Values]
    if len(taken) > 1 and any(None in p.values for p in taken):
        # Which missing parts go together is for the reference semantics to say.
        combinations = dict.fromkeys(tuple(v[i] for i in used) for v in valuations(event))
    else:
        combinations = product(*(p.values for p in taken))
    for values in combinations:
        yield {p.path: value for p, value in zip(taken, values, strict=True)}


def weight(event: Event) -> int:
    """How many combinations of parameter values an event has."""
    if any(None in p.values for p in event.parameters):
        return sum(1 for _ in valuations(event))
    return prod(len(p.values) for p in event.parameters)
