"""Guards as short expressions of the language.

Synthesis gives each controllable event a set of states; users want a condition. Where the
requirements alone give the same set, their own wording is the guard. Otherwise an expression is
made that is right in every state of the controlled system in which the plant can do the event, and
means nothing elsewhere: the axes that do not matter are dropped one after another, and what the
rest tells apart is covered by few and wide boxes (:mod:`robosc.synthesis.minimise`).

Engines hand in their sets as a :class:`CareSet`; nothing here depends on their representation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

from robosc.ir.automaton import Event, Plant, VariableKind
from robosc.ir.expr import conjunction
from robosc.model.expr import FALSE, TRUE, Expr, Unary, walk
from robosc.supervisor import Guard, Status
from robosc.synthesis.minimise import Table, condition_of
from robosc.synthesis.vectorised import support

__all__ = ["CareSet", "GuardInputs", "make_guard"]


class CareSet(Protocol):
    """States in which an event is allowed, and states in which it is refused.

    ``parts`` are the groups of axes that still tell states apart, each to be kept or forgotten as a
    whole.
    """

    @property
    def parts(self) -> tuple[tuple[int, ...], ...]: ...

    def without(self, part: tuple[int, ...]) -> CareSet | None:
        """The same with a part forgotten; None if the two sets would then overlap."""

    def table(self) -> Table:
        """Both sets, told by the axes of the parts that are left."""


@dataclass(frozen=True)
class GuardInputs:
    """What an engine knows of a controllable event, of states of the controlled system alone.

    ``required`` is how many states allow it in the plant under requirements, ``enabled`` in how
    many of them it is allowed under control. The functions give the refused states among those in
    which requirements allow it, and among all those in which the plant can do it.
    """

    required: int
    enabled: int
    within_requirement: Callable[[], CareSet]
    within_plant: Callable[[], CareSet]


def make_guard(plant: Plant, event: Event, inputs: GuardInputs) -> Guard:
    """The guard of a controllable event."""
    required = TRUE if event.requirement is None else event.requirement
    if inputs.enabled == 0:
        return Guard(event, FALSE, required, "never")
    if inputs.enabled == inputs.required:
        return Guard(event, required, required, "as required")
    status: Status = "restricted"
    extra = _condition(plant, event, inputs.within_requirement())
    together = conjunction([required, extra])
    if event.requirement is None:
        return Guard(event, together, required, status)
    fresh = _condition(plant, event, inputs.within_plant())
    shorter = fresh if _length(fresh) < _length(together) else together
    return Guard(event, shorter, required, status)


def _condition(plant: Plant, event: Event, care_set: CareSet) -> Expr:
    for part in sorted(care_set.parts, key=_order(plant, event, care_set.parts)):
        care_set = care_set.without(part) or care_set
    return condition_of(plant, care_set.table().reduced(_axis_order(plant, event)))


def _order(
    plant: Plant, event: Event, parts: Iterable[tuple[int, ...]]
) -> Callable[[tuple[int, ...]], tuple[bool, bool, int]]:
    """Which parts to forget first: those that the event has nothing to do with, from the last."""
    rank = _axis_order(plant, event)
    return lambda part: max(rank(axis) for axis in part)


def _axis_order(plant: Plant, event: Event) -> Callable[[int], tuple[bool, bool, int]]:
    near = _touched(plant, event)

    def rank(axis: int) -> tuple[bool, bool, int]:
        # Users cannot write a phase, so it is the first to go among equals.
        return axis in near, plant.variables[axis].kind is not VariableKind.PHASE, -axis

    return rank


def _touched(plant: Plant, event: Event) -> set[int]:
    """The axes that an event reads or writes."""
    found = {automaton.variable for automaton in event.automata}
    expressions = [] if event.requirement is None else [event.requirement]
    for automaton in event.automata:
        for edge in automaton.edges:
            found.update(axis for axis, _ in edge.updates)
            expressions += [expr for _, expr in edge.updates]
            expressions += [] if edge.guard is None else [edge.guard]
    for expr in expressions:
        found.update(support(plant, expr))
    return found


def _length(expr: Expr) -> int:
    """How much there is to read: leaves, and a little for each negation."""
    nodes = list(walk(expr))
    leaves = sum(2 for node in nodes if not hasattr(node, "operator"))
    return leaves + sum(1 for node in nodes if isinstance(node, Unary))
