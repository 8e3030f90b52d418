"""The explicit engine: one boolean per state of the product, fixpoints as operations in place.

The product space holds states that are never reached; what the fixpoints say of those means nothing
and does no harm, since nothing leads there. Sweeps go over the events in model order, so that those
of one component follow each other, and work in place: what one event adds the next one carries on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from robosc.ir.automaton import Event, Plant
from robosc.synthesis.cases import DenseCases
from robosc.synthesis.columns import Bools
from robosc.synthesis.layout import Layout, Operation
from robosc.synthesis.moves import Compiler, Condition, EventMoves

__all__ = ["DenseEngine", "DenseSolution", "Progress"]

Progress = Callable[[str, int, int], None]
"""Called now and then: what is being computed, how far it is, and the most it can be."""


@dataclass(frozen=True, eq=False)
class _Steps:
    """The operations of an event in the plant, and where its requirement also holds.

    Each is a sequence of stages; one stage is the rule. ``possible`` is where the plant allows the
    event as far as that is told by states alone (ranges left aside).
    """

    moves: EventMoves
    plant: tuple[tuple[Operation, ...], ...]
    required: tuple[tuple[Operation, ...], ...]

    @property
    def event(self) -> Event:
        return self.moves.event


@dataclass(frozen=True, eq=False)
class DenseSolution:
    """The controlled system, in the engine's layout.

    ``states`` are those reached under control, ``good`` those that need not be avoided.
    ``restricted`` tells whether synthesis forbids anything that the requirements allow, ``empty``
    whether not even the initial state can be kept (then ``states`` mean nothing).
    """

    engine: DenseEngine
    states: Bools
    good: Bools
    restricted: bool
    empty: bool


class DenseEngine:
    """Synthesis over a layout; allocates arrays of ``layout.size`` bytes, three at the most."""

    def __init__(self, plant: Plant, layout: Layout, progress: Progress | None = None) -> None:
        self.plant = plant
        self.layout = layout
        self.compiler = Compiler(plant)
        self._progress = progress
        self.plant_states = 0
        self.steps = tuple(self._compile(event) for event in plant.events)

    def _compile(self, event: Event) -> _Steps:
        moves = self.compiler.event(event)
        plant = tuple(
            tuple(op for move in stage for op in self.layout.operations(move))
            for stage in moves.stages
        )
        if event.requirement is None:
            return _Steps(moves, plant, plant)
        first = tuple(
            op
            for move in moves.stages[0]
            for condition in moves.required
            for op in self.layout.operations(move, condition)
        )
        return _Steps(moves, plant, (first, *plant[1:]))

    # --- synthesis

    def solve(self) -> DenseSolution:
        """The controlled system."""
        initial = self.layout.index(self.plant.initial)
        assert initial is not None
        plant_stages = [step.plant for step in self.steps]
        required_stages = [step.required for step in self.steps]
        states = self._only(initial)
        self._forward(states, plant_stages)
        self.plant_states = int(np.count_nonzero(states))
        if any(step.event.requirement is not None for step in self.steps):
            states = self._only(initial)
            self._forward(states, required_stages)
        good = states
        bad = self._remove_bad(good)
        restricted = bad
        while True:
            if bad:
                self._close_bad(good)
            if not good[initial]:
                return DenseSolution(self, good, good, True, True)
            back = self._coreachable(good, restricted)
            before = np.count_nonzero(good)
            if restricted:
                good = back
            else:
                np.logical_and(good, back, out=good)
            del back
            if np.count_nonzero(good) == before:
                break
            bad = restricted = True
        if restricted:
            states = self._only(initial)
            self._forward(states, required_stages, good)
        return DenseSolution(self, states, good, restricted, False)

    def _only(self, index: int) -> Bools:
        states = np.zeros(self.layout.size, np.bool_)
        states[index] = True
        return states

    def _forward(
        self,
        states: Bools,
        events: Sequence[tuple[tuple[Operation, ...], ...]],
        within: Bools | None = None,
    ) -> None:
        """Add all that is reached from ``states``, inside ``within`` if given."""
        most = states.size if within is None else int(np.count_nonzero(within))

        def sweep() -> None:
            for stages in events:
                if len(stages) == 1:
                    for op in stages[0]:
                        _forward(op, states, states, within)
                else:
                    reached = self._image(stages, states)
                    if within is not None:
                        reached &= within
                    np.logical_or(states, reached, out=states)

        self._fixpoint("reachable states", states, sweep, most)

    def _remove_bad(self, good: Bools) -> bool:
        """Take out the states that break an invariant or leave a range; whether there are any."""
        before = int(np.count_nonzero(good))
        for step in self.steps:
            if not step.event.controllable:
                self._clear(good, step.moves.leaving)
        for expr, _ in self.plant.invariants:
            self._clear(good, self.compiler.condition(expr, False))
        return int(np.count_nonzero(good)) != before

    def _clear(self, states: Bools, conditions: Iterable[Condition]) -> None:
        for condition in conditions:
            for op in self.layout.regions(condition):
                for number in range(len(op.sources)):
                    offset, masks = op.sources[number]
                    here = op.slice(states, offset)
                    if masks:
                        where = op.mask(masks[0])
                        for mask in masks[1:]:
                            where = where & op.mask(mask)
                        np.logical_and(here, np.logical_not(where), out=here)
                    else:
                        here[...] = False

    def _close_bad(self, good: Bools) -> None:
        """Take out the states from which uncontrollable events lead out of ``good``."""
        events = [step.plant for step in self.steps if not step.event.controllable]

        def sweep() -> None:
            for stages in events:
                if len(stages) == 1:
                    for op in stages[0]:
                        _uncontrolled(op, good)
                else:
                    lost = self._preimage(stages, np.logical_not(good))
                    np.logical_and(good, np.logical_not(lost), out=good)

        self._fixpoint("states to be avoided", good, sweep, 0)

    def _coreachable(self, good: Bools, restricted: bool) -> Bools:
        """The states of ``good`` from which a marked state is reached inside ``good``.

        Unless something is forbidden already, all that ``good`` leads to is in ``good``; then
        nothing needs to be compared with it on the way, and the result may hold more.
        """
        back = np.zeros(self.layout.size, np.bool_)
        for op in self.layout.regions(self._marked()):
            for offset, _ in op.sources:
                op.slice(back, offset)[...] = True
        if restricted:
            np.logical_and(back, good, out=back)
        within = good if restricted else None
        events = [step.required for step in self.steps]
        most = int(np.count_nonzero(good)) if restricted else back.size

        def sweep() -> None:
            for stages in events:
                if len(stages) == 1:
                    for op in stages[0]:
                        _backward(op, back, within)
                else:
                    found = self._preimage(stages, back)
                    if within is not None:
                        found &= within
                    np.logical_or(back, found, out=back)

        self._fixpoint("nonblocking states", back, sweep, most)
        return back

    def _marked(self) -> Condition:
        allowed: dict[int, Bools] = {}
        for number, axis in enumerate(self.plant.axes):
            if axis.marked is not None:
                values = np.zeros(axis.size, np.bool_)
                values[sorted(axis.marked)] = True
                allowed[number] = values
        return Condition(allowed)

    def _fixpoint(self, what: str, states: Bools, sweep: Callable[[], None], most: int) -> None:
        """Sweep until nothing changes, or until nothing can change any more."""
        before = -1
        now = int(np.count_nonzero(states))
        while now not in (before, most):
            sweep()
            before, now = now, int(np.count_nonzero(states))
            if self._progress is not None:
                self._progress(what, now, states.size)

    # --- events in stages

    def _image(self, stages: Sequence[Sequence[Operation]], states: Bools) -> Bools:
        for stage in stages:
            after = np.zeros(self.layout.size, np.bool_)
            for op in stage:
                _forward(op, states, after, None)
            states = after
        return states

    def _preimage(self, stages: Sequence[Sequence[Operation]], states: Bools) -> Bools:
        for stage in reversed(stages):
            before = np.zeros(self.layout.size, np.bool_)
            for op in stage:
                found = _targets(op, states)
                for number in range(len(op.sources)):
                    here = op.slice(before, op.sources[number][0])
                    np.logical_or(here, _masked(op, number, found), out=here)
            states = before
        return states

    # --- counting

    def count(self, states: Bools, conditions: Iterable[Condition]) -> int:
        """How many of ``states`` meet one of the conditions, which exclude each other."""
        return sum(
            int(np.count_nonzero(op.source(states, number)))
            for condition in conditions
            for op in self.layout.regions(condition)
            for number in range(len(op.sources))
        )

    def enabled(self, step: _Steps, states: Bools) -> int:
        """How many of ``states`` allow a controllable event that stays inside ``states``."""
        return self._count_steps(step.required, states, states)

    def required(self, step: _Steps, states: Bools) -> int:
        """How many of ``states`` allow a controllable event in the plant under requirements."""
        return self._count_steps(step.required, states, None)

    def possible(self, step: _Steps, states: Bools) -> int:
        """How many of ``states`` allow an event in the plant."""
        return self._count_steps(step.plant, states, None)

    def _count_steps(
        self, stages: Sequence[Sequence[Operation]], states: Bools, within: Bools | None
    ) -> int:
        if len(stages) > 1:
            everything = np.ones(self.layout.size, np.bool_) if within is None else within
            before = self._preimage(stages, everything)
            return int(np.count_nonzero(np.logical_and(before, states, out=before)))
        total = 0
        for op in stages[0]:
            for number in range(len(op.sources)):
                here = op.source(states, number)
                if within is not None:
                    here = here & op.slice(within, op.targets[0])
                total += int(np.count_nonzero(here))
        return total

    def cases(self, step: _Steps, states: Bools, required: bool) -> DenseCases:
        """Where a controllable event is allowed, and where refused though the plant could."""
        allowed = self._sources_of(step.required, states, states)
        refused = self._sources_of(step.required if required else step.plant, states, None)
        np.logical_and(refused, np.logical_not(allowed), out=refused)
        return DenseCases(self.plant, self.layout.dims, allowed, refused)

    def _sources_of(
        self, stages: Sequence[Sequence[Operation]], states: Bools, within: Bools | None
    ) -> Bools:
        """The states that allow a controllable event, and lead inside ``within`` if given."""
        if len(stages) > 1:
            everything = np.ones(self.layout.size, np.bool_) if within is None else within
            before = self._preimage(stages, everything)
            return np.logical_and(before, states, out=before)
        found = np.zeros(self.layout.size, np.bool_)
        for op in stages[0]:
            for number in range(len(op.sources)):
                here = op.source(states, number)
                if within is not None:
                    here = here & op.slice(within, op.targets[0])
                into = op.slice(found, op.sources[number][0])
                np.logical_or(into, here, out=into)
        return found

    def occurrences(self, step: _Steps, states: Bools) -> int:
        """State-event-value triples of an uncontrollable event, which is never blocked."""
        phase = step.event.phase
        if phase is None:
            return int(np.count_nonzero(states)) * step.moves.weight
        values = np.zeros(self.plant.axes[phase.axis].size, np.bool_)
        values[phase.source] = True
        return self.count(states, [Condition({phase.axis: values})]) * step.moves.weight


def _masked(op: Operation, number: int, states: Bools) -> Bools:
    for mask in op.sources[number][1]:
        states = states & op.mask(mask)
    return states


def _sources(op: Operation, states: Bools) -> Bools:
    """All sources of an operation in one."""
    found = op.source(states, 0)
    for number in range(1, len(op.sources)):
        found = found | op.source(states, number)
    return found


def _targets(op: Operation, states: Bools) -> Bools:
    """All targets of an operation in one."""
    found = op.slice(states, op.targets[0])
    for target in op.targets[1:]:
        found = found | op.slice(states, target)
    return found


def _forward(op: Operation, states: Bools, after: Bools, within: Bools | None) -> None:
    if op.stays and states is after:
        return
    found = _sources(op, states)
    for target in op.targets:
        here = op.slice(after, target)
        if within is None:
            np.logical_or(here, found, out=here)
        else:
            np.logical_or(here, found & op.slice(within, target), out=here)


def _backward(op: Operation, states: Bools, within: Bools | None) -> None:
    if op.stays:
        return
    found = _targets(op, states)
    for number, (source, _) in enumerate(op.sources):
        here = op.slice(states, source)
        add = _masked(op, number, found)
        if within is not None:
            add = add & op.slice(within, source)
        np.logical_or(here, add, out=here)


def _uncontrolled(op: Operation, good: Bools) -> None:
    if op.stays:
        return
    safe = op.slice(good, op.targets[0])
    for target in op.targets[1:]:
        safe = safe & op.slice(good, target)
    for source, masks in op.sources:
        here = op.slice(good, source)
        kept = safe
        if masks:
            where = op.mask(masks[0])
            for mask in masks[1:]:
                where = where & op.mask(mask)
            kept = np.logical_or(safe, np.logical_not(where))
        np.logical_and(here, kept, out=here)
