"""The dense engine: one bit per state of the product, fixpoints computed in place.

It holds the sets of :mod:`robosc.synthesis.fixpoint`, and the reach of the controlled system.
The product contains unreachable states; what the fixpoints compute for those is irrelevant, since
no reachable state leads there. A sweep applies the events in model order, so that those of one
component follow each other, and updates the set in place: what one event adds, the next one sees.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from robosc.expr.tree import Expr, Unary
from robosc.plant.acceptance import gates_of
from robosc.plant.automaton import Event, LocalAutomaton
from robosc.plant.logic import conjunction, junction
from robosc.plant.partial_evaluation import PartValues, holds
from robosc.progress import Progress
from robosc.synthesis.dense.bitset import Bitset, count, members
from robosc.synthesis.dense.care_set import DenseCareSet
from robosc.synthesis.dense.images import (
    Stages,
    applying,
    backward,
    clear,
    forward,
    image,
    measure,
    preimage,
    uncontrolled,
)
from robosc.synthesis.dense.layout import Layout
from robosc.synthesis.dense.merging import Condition, EventRules
from robosc.synthesis.dense.operations import Operation, sweep_order
from robosc.synthesis.dense.transitions import Compiler
from robosc.synthesis.event_parameters import choices, weight
from robosc.synthesis.fixpoint import supremal

_NOTHING_REFUSED: Mapping[int, Bitset] = {}


@dataclass(frozen=True, eq=False)
class EventOperations:
    """The operations of an event in the plant, and where its requirement also holds.

    ``plant`` and ``required`` are sequences of stages, in most cases a single one.
    """

    rules: EventRules
    plant: tuple[tuple[Operation, ...], ...]
    required: tuple[tuple[Operation, ...], ...]

    @property
    def event(self) -> Event:
        return self.rules.event


@dataclass(frozen=True, eq=False)
class DenseSolution:
    """The controlled system, in the engine's layout.

    ``states`` are those reached under control, ``good`` the supremal safe, controllable and
    nonblocking set. ``restricted`` says whether synthesis forbids anything that the requirements
    allow, ``empty`` whether an initial state is not good (``states`` are then undefined).
    """

    engine: DenseEngine
    states: Bitset
    good: Bitset
    restricted: bool
    empty: bool


class DenseEngine:
    """Synthesis over a layout; holds at most four sets of ``layout.words`` words at once."""

    def __init__(
        self,
        compiler: Compiler,
        rules: Iterable[EventRules],
        layout: Layout,
        progress: Progress | None = None,
    ) -> None:
        self.plant = compiler.plant
        self.layout = layout
        self.compiler = compiler
        self._progress = progress
        self.plant_states = 0
        self._restricted = False
        self.steps = tuple(self._compile(event) for event in rules)

    def _compile(self, rules: EventRules) -> EventOperations:
        plant = tuple(
            sweep_order(op for rule in stage for op in self.layout.operations(rule))
            for stage in rules.stages
        )
        if rules.event.requirement is None:
            return EventOperations(rules, plant, plant)
        first = sweep_order(
            op
            for rule in rules.stages[0]
            for condition in rules.required
            for op in self.layout.operations(rule, condition)
        )
        return EventOperations(rules, plant, (first, *plant[1:]))

    # --- synthesis

    def solve(self) -> DenseSolution:
        """Return the controlled system."""
        good, starts = supremal(self)
        if not starts:
            return DenseSolution(self, good, good, True, True)
        states = good
        if self._restricted:
            states = self.layout.of(self.layout.starts())
            self._forward(states, self._required_stages(), good, self._refused(good))
        return DenseSolution(self, states, good, self._restricted, False)

    def reachable(self) -> Bitset:
        """Return the states that the plant reaches under the requirements on events."""
        states = self.plant_reach()
        self.plant_states = count(states)
        if any(step.event.requirement is not None for step in self.steps):
            states = self.layout.of(self.layout.starts())
            self._forward(states, self._required_stages())
        return states

    def safe(self, states: Bitset) -> Bitset:
        self._restricted = self._remove_bad(states)
        return states

    def controllable(self, states: Bitset, before: Bitset) -> Bitset:
        self._restricted = self._restricted or states is not before
        if self._restricted:
            self._close_bad(states)
        return states

    def nonblocking(self, states: Bitset) -> Bitset:
        back = self._coreachable(states, self._restricted)
        if not self._restricted:
            np.bitwise_and(back, states, out=back)
        return back

    def reaching_goals(self, states: Bitset) -> Bitset:
        for goal in self.plant.goals:
            back = self.meeting(states, goal.condition).copy()
            via = self.meeting(states, goal.along)
            self._lead(back, via, self._refused(states), self.layout.size)
            lost = self.meeting(states, goal.origin) & np.bitwise_not(back)
            states = np.bitwise_and(states, np.bitwise_not(lost))
        return states

    def same(self, states: Bitset, subset: Bitset) -> bool:
        return count(states) == count(subset)

    def has_start(self, states: Bitset) -> bool:
        return bool(members(states, self.layout.starts()).all())

    def plant_reach(self) -> Bitset:
        """Return the states that the plant without its requirements reaches."""
        states = self.layout.of(self.layout.starts())
        self._forward(states, [step.plant for step in self.steps])
        return states

    def _required_stages(self) -> list[Stages]:
        return [step.required for step in self.steps]

    def _refused(self, good: Bitset) -> dict[int, Bitset]:
        """Return where commands with several outcomes may lead out of ``good``, by event number."""
        outside = np.bitwise_not(good)
        return {
            number: preimage(step.required, outside)
            for number, step in enumerate(self.steps)
            if step.event.branches
        }

    def _forward(
        self,
        states: Bitset,
        events: Sequence[Stages],
        within: Bitset | None = None,
        refused: Mapping[int, Bitset] = _NOTHING_REFUSED,
    ) -> None:
        """Add all that is reached from ``states``, restricted to ``within`` if given."""
        most = self.layout.size if within is None else count(within)

        def sweep() -> None:
            for number, stages in enumerate(events):
                if len(stages) == 1 and number not in refused:
                    for op in stages[0]:
                        forward(op, states, states, within)
                else:
                    start = states
                    if number in refused:
                        start = np.bitwise_and(states, np.bitwise_not(refused[number]))
                    reached = image(stages, start)
                    if within is not None:
                        reached &= within
                    np.bitwise_or(states, reached, out=states)

        self._fixpoint("reachable states", states, sweep, most)

    def _remove_bad(self, good: Bitset) -> bool:
        """Remove the states that violate an invariant or leave a range; whether there are any."""
        before = count(good)
        for step in self.steps:
            if not step.event.controllable:
                self._clear(good, step.rules.range_violations)
        for expr, _ in self.plant.invariants:
            self._clear(good, self.compiler.condition(expr, False))
        return count(good) != before

    def _clear(self, states: Bitset, conditions: Iterable[Condition]) -> None:
        for condition in conditions:
            for op in self.layout.regions(condition):
                clear(op, states)

    def _close_bad(self, good: Bitset) -> None:
        """Remove the states from which uncontrollable events lead out of ``good``."""
        events = [step.plant for step in self.steps if not step.event.controllable]

        def sweep() -> None:
            for stages in events:
                if len(stages) == 1:
                    for op in reversed(stages[0]):
                        uncontrolled(op, good)
                else:
                    lost = preimage(stages, np.bitwise_not(good))
                    np.bitwise_and(good, np.bitwise_not(lost), out=good)

        self._fixpoint("states to be avoided", good, sweep, 0)

    def _coreachable(self, good: Bitset, restricted: bool) -> Bitset:
        """Return the states of ``good`` from which a marked state is reached inside ``good``.

        Unless ``restricted``, ``good`` is closed under all events, so intermediate results are not
        intersected with it, and the result may contain further states.
        """
        back = self._regions(good if restricted else self.layout.everything(), [self._marked()])
        refused = self._refused(good) if restricted else {}
        most = count(good) if restricted else self.layout.size
        self._lead(back, good if restricted else None, refused, most)
        return back

    def _lead(
        self, back: Bitset, within: Bitset | None, refused: Mapping[int, Bitset], most: int
    ) -> None:
        """Add all states from which ``back`` is reached, if given only those ``within``."""
        events = self._required_stages()

        def sweep() -> None:
            for number, stages in enumerate(events):
                if len(stages) == 1 and number not in refused:
                    for op in reversed(stages[0]):
                        backward(op, back, within)
                else:
                    found = preimage(stages, back)
                    if number in refused:
                        found &= np.bitwise_not(refused[number])
                    if within is not None:
                        found &= within
                    np.bitwise_or(back, found, out=back)

        self._fixpoint("nonblocking states", back, sweep, most)

    def _marked(self) -> Condition:
        return Condition(
            {
                number: self.compiler.values(number, variable.marked)
                for number, variable in enumerate(self.plant.variables)
                if variable.marked is not None
            }
        )

    def _fixpoint(self, what: str, states: Bitset, sweep: Callable[[], None], most: int) -> None:
        """Sweep until nothing changes, or ``most`` states are reached."""
        before = -1
        now = count(states)
        while now not in (before, most):
            sweep()
            before, now = now, count(states)
            if self._progress is not None:
                self._progress(what, now, self.layout.size)

    # --- counting

    def meeting(self, states: Bitset, expr: Expr, polarity: bool = True) -> Bitset:
        """Return those of ``states`` in which an expression is ``polarity``, as a new array.

        It is built set by set: mutually exclusive conditions may be very many.
        """
        if isinstance(expr, Unary):
            return self.meeting(states, expr.operand, not polarity)
        parts = junction(expr, polarity)
        if parts is None or not (parts.conjunctive or self.compiler.is_wide(expr)):
            return self._regions(states, self.compiler.condition(expr, polarity))
        met = states if parts.conjunctive else self.layout.nothing()
        for part, own in parts.parts:
            if parts.conjunctive:
                met = self.meeting(met, part, own)
            else:
                np.bitwise_or(met, self.meeting(states, part, own), out=met)
        return met

    def _regions(self, states: Bitset, conditions: Iterable[Condition]) -> Bitset:
        """Return those of ``states`` that satisfy one of the conditions, as a new array."""
        return applying((op for one in conditions for op in self.layout.regions(one)), states)

    def enabled(self, step: EventOperations, states: Bitset) -> int:
        """Return in how many of ``states`` a controllable event stays inside ``states``."""
        if step.event.branches:
            return count(self._allowed(step, states))
        return self._count_sources(step, step.required, states, states)

    def _allowed(self, step: EventOperations, states: Bitset) -> Bitset:
        """Return in which of ``states`` all outcomes of a controllable event are in ``states``."""
        if not step.event.branches:
            return self._sources_of(step.required, states, states)
        allowed = preimage(step.required, states)
        lost = preimage(step.required, np.bitwise_not(states))
        np.bitwise_and(allowed, np.bitwise_not(lost), out=allowed)
        return np.bitwise_and(allowed, states, out=allowed)

    def required(self, step: EventOperations, states: Bitset) -> int:
        """Return in how many of ``states`` the plant under requirements allows an event."""
        return self._count_sources(step, step.required, states, None)

    def _count_sources(
        self, step: EventOperations, stages: Stages, states: Bitset, within: Bitset | None
    ) -> int:
        if step.event.branches or len(stages) > 1:  # several operations may apply to one state
            return count(self._sources_of(stages, states, within))
        return sum(measure(op, states, within) for op in stages[0])

    def care_set(self, step: EventOperations, states: Bitset, required: bool) -> DenseCareSet:
        """Return where a controllable event is allowed, and where it is possible but refused.

        ``required``: the refused states are those that the requirements allow.
        """
        allowed = self._allowed(step, states)
        refused = self._sources_of(step.required if required else step.plant, states, None)
        np.bitwise_and(refused, np.bitwise_not(allowed), out=refused)
        return DenseCareSet.of(self.layout, allowed, refused)

    def _sources_of(self, stages: Stages, states: Bitset, within: Bitset | None) -> Bitset:
        """Return in which of ``states`` an event is possible and leads into ``within`` if given."""
        if len(stages) > 1:
            everything = self.layout.everything() if within is None else within
            before = preimage(stages, everything)
            return np.bitwise_and(before, states, out=before)
        return applying(stages[0], states, within)

    def occurrences(self, step: EventOperations, states: Bitset) -> int:
        """Return the number of transitions (state, event, values) of an uncontrollable event.

        Only events of time, and those that only happen in some states, are blocked by automata; for
        the others the phase decides.
        """
        event, phase = step.event, step.event.phase
        if event.kind.synchronised:
            return self._count_sources(step, step.plant, states, None) * step.rules.weight
        gates = gates_of(event)
        if gates:
            return self._passing(event, gates, states)
        if phase is None:
            return count(states) * step.rules.weight
        there = self._in(phase.variable, phase.sources)
        return sum(measure(op, states) for op in self.layout.regions(there)) * step.rules.weight

    def _in(self, variable: int, indexes: Collection[int]) -> Condition:
        return Condition({variable: self.compiler.values(variable, indexes)})

    def _passing(self, event: Event, gates: Sequence[LocalAutomaton], states: Bitset) -> int:
        """Return the number of pairs of a state and values with which gates let an event pass."""
        if event.phase is not None:
            states = self._regions(states, (self._in(event.phase.variable, event.phase.sources),))
        number = 0
        for edges in product(*(gate.edges for gate in gates)):
            there = states
            for gate, edge in zip(gates, edges, strict=True):
                there = self._regions(there, (self._in(gate.variable, (edge.source,)),))
            guard = conjunction(edge.guard for edge in edges if edge.guard is not None)
            for chosen in choices(event, [guard]):
                here = count(self.meeting(there, holds(guard, chosen)))
                number += here * weight(_with(event, chosen))
        return number


def _with(event: Event, chosen: PartValues) -> Event:
    """Return the event with these values of some parameters only."""
    parameters = (
        replace(p, values=(chosen[p.path],)) if p.path in chosen else p for p in event.parameters
    )
    return replace(event, parameters=tuple(parameters))
