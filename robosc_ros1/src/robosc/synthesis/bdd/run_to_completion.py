"""Symbolic search of the controller that runs a supervisor: its run-to-completion steps.

After each event the controller takes internal transitions in source order, round by round, until
none is possible. A round is a function on states with images and preimages, so the properties of
:mod:`robosc.synthesis.explain.properties` are fixpoints:

- a step ends from the states from which rounds lead to a state at rest;
- its end depends on the order if, for some state variable that internal transitions change, either
  of two values can be the last one;
- the states from which a marked state at rest is reachable are found backward from those.

All of that is asked first of every state under the supervisor, for those that the controller comes
to can have far larger diagrams; these are looked for only where something fails.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, cached_property, partial
from typing import TypeAlias

from robosc import limits
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event, PlantState
from robosc.synthesis.bdd.commuting import TauGroups
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import Disjunct, EventRelation
from robosc.synthesis.bdd.saturation import Saturation
from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution
from robosc.synthesis.controlled_system import Runs, inputs

_Steps: TypeAlias = tuple[tuple[Disjunct, ...], ...]
_Enabled: TypeAlias = Callable[[EventRelation], Bdd]
"""Where a command is enabled under the supervisor."""


@dataclass(frozen=True, eq=False, slots=True)
class _Reached:
    """The states that an input led to first: where steps start (``starts``) and end (``rests``).

    ``event`` is the input's first event; ``earlier`` contains the states at rest before it.
    """

    event: int
    starts: Bdd
    rests: Bdd
    earlier: Bdd


class SymbolicController:
    """The controller of a solution that is not empty.

    Relations of events read only what these read: images have to be intersected with what the
    supervisor allows. Methods raise MemoryError if they need too many diagram nodes.
    """

    def __init__(self, solution: SymbolicSolution) -> None:
        self.states = solution.states
        self.engine = solution.engine
        self.encoding = solution.engine.encoding
        self.manager = solution.engine.manager
        self.plant = solution.engine.plant
        self._false = self.manager.false
        self._most = self.manager.nodes + limits.COMPLETION_NODES
        self._taus = TauGroups(solution)
        self._moving = self._taus.moving
        self._at_rest = self.states & ~self._moving
        enabled = cache(solution.enabled)
        self._inputs = {
            numbers[0]: self._steps([self.engine.events[n] for n in numbers], enabled)
            for numbers in inputs(self.plant)
        }
        # Most steps lead from rest to rest, and are followed by saturation: two_tools_each 12.
        direct = [steps[0] for steps in self._inputs.values() if len(steps) == 1]
        image, preimage = self.engine.relations.image, self.engine.relations.preimage
        self._forward = self._saturation(direct, image)
        self._back = self._saturation(direct, preimage)
        own = [[move.disjunct for move in tau.moves] for tau in self._taus.all]
        self._back_internally = self._saturation(own, preimage)
        self._back_freely = self._saturation([*own, *self._free_steps()], preimage)
        found = [self._after(steps, self._at_rest) for steps in self._inputs.values()]
        self._possible = self.manager.union([self.encoding.initial, *found])
        """Where steps start that begin in any state at rest, reached or not."""

    def runs(self, exactly: bool = False) -> Runs:
        """Return what fails of the controller's run to completion.

        ``exactly``: the longest step is the longest that is reached.
        """
        livelock = self._chain(self._possible & ~self._ending)
        return Runs(
            livelock=livelock,
            differing=self._differing(),
            stuck=self._chain(self._leading(self._at_rest & ~self._reaching())),
            longest=None
            if livelock is not None
            else self._longest(self._starts if exactly else self._possible),
            missed=self._missed(),
        )

    @cached_property
    def _ending(self) -> Bdd:
        """From where a run to completion ends."""
        return self._leading(self._at_rest)

    @property
    def _any_order(self) -> bool:
        """Whether internal transitions end in the same state in any order, from all states."""
        return self._taus.commute and self._ending == self.states

    # --- events and rounds

    def _saturation(
        self, disjuncts: Sequence[Sequence[Disjunct]], step: Callable[[Disjunct, Bdd], Bdd]
    ) -> Saturation:
        return Saturation(self.manager, disjuncts, step, lambda *_: self._limit())

    def _steps(self, events: Sequence[EventRelation], enabled: _Enabled) -> _Steps:
        """Return the events of one input, one after the other.

        The first is possible where the controller is at rest and sends no preferred command. One
        of several events may change nothing.
        """
        steps: list[tuple[Disjunct, ...]] = []
        for event in events:
            disjuncts = [
                d for d in self.engine.permitted[event.number] if len(events) > 1 or not d.stays
            ]
            if not steps:
                here = self._unless_preferred(event, enabled)
                disjuncts = [replace(d, relation=d.relation & here) for d in disjuncts]
            if disjuncts:
                steps.append(tuple(disjuncts))
        return tuple(steps)

    def _free_steps(self) -> Iterator[Sequence[Disjunct]]:
        """Yield inputs where internal transitions that they touch are not possible, and others may
        be; those that yield to others only at rest."""
        for number, steps in self._inputs.items():
            if len(steps) == 1:
                event = self.engine.events[number]
                yields = self.plant.robot.yields_to.get(self.plant.events[number].command)
                before = self._moving if yields else self._taus.concerned(event)
                yield [replace(d, relation=d.relation & ~before) for d in steps[0]]

    def _unless_preferred(self, event: EventRelation, enabled: _Enabled) -> Bdd:
        here = self.manager.true
        taken = self.plant.events[event.number]
        if taken.kind.sent:
            preferred = self.plant.robot.yields_to.get(taken.command, ())
            for relation in self.engine.events:
                other = self.plant.events[relation.number]
                if other.kind.sent and other.command in preferred:
                    here = here & ~(enabled(relation) & ~self._replacing(other))
        return here

    def _replacing(self, event: Event) -> Bdd:
        """Return the states in which a request would replace a goal."""
        phase = event.phase
        if phase is None or event.kind is not EventKind.REQUEST:
            return self._false
        return self.encoding.holds(self.plant.variables[phase.variable].phase(phase.target))

    def _image(self, disjunct: Disjunct, states: Bdd) -> Bdd:
        return self.engine.relations.image(disjunct, states) & self.states

    def _preimage(self, disjunct: Disjunct, states: Bdd) -> Bdd:
        return self.engine.relations.preimage(disjunct, states) & self.states

    def _after(self, steps: _Steps, states: Bdd) -> Bdd:
        """Return the image of an input; an event that changes nothing leads nowhere."""
        for step in steps:
            states = self.manager.union(self._image(disjunct, states) for disjunct in step)
        return states if steps else self._false

    def _before(self, steps: _Steps, states: Bdd) -> Bdd:
        for step in reversed(steps):
            states = self.manager.union(self._preimage(disjunct, states) for disjunct in step)
        return states if steps else self._false

    def _round(self, states: Bdd) -> Bdd:
        """Return the image of one round of internal transitions, each tried once."""
        for tau in self._taus.all:
            moved = []
            for move in tau.moves:
                moved.append(self._image(move.disjunct, states))
            states = self.manager.union([states & ~tau.before, *moved])
        return states

    def _before_round(self, states: Bdd, way: tuple[Bdd, Bdd] | None = None) -> Bdd:
        """Return the preimage of one round of internal transitions; with a ``way``, of one that
        comes through the first set, or to ``states`` through the second one only."""
        for tau in reversed(self._taus.all):
            entered = states if way is None else way[0] | (states & way[1])
            came = []
            for move in tau.moves:
                came.append(self._preimage(move.disjunct, entered))
            states = self.manager.union([states & ~tau.before, *came])
        return states

    def _completed(self, starts: Bdd) -> Bdd:
        """Return the states at rest in which steps from ``starts`` end."""
        rests, seen, left = self._false, starts, starts
        while left != self._false:
            rests = rests | (left & ~self._moving)
            left = self._round(left & self._moving) & ~seen
            seen = seen | left
            self._limit()
        return rests

    def _leading(self, states: Bdd) -> Bdd:
        """Return the states from which a step passes through ``states``, those included."""
        return self._closure(states, lambda found: found | self._before_round(found))

    def _closure(self, states: Bdd, step: Callable[[Bdd], Bdd]) -> Bdd:
        while True:
            self._limit()
            before, states = states, step(states)
            if states == before:
                return states

    def _limit(self) -> None:
        self.manager.make_room()
        work = sum(
            each.work
            for each in (self._forward, self._back, self._back_internally, self._back_freely)
        )
        if self.manager.nodes > self._most or work > limits.COMPLETION_PARTS:
            raise MemoryError

    # --- from rest to rest

    @cached_property
    def _starts(self) -> Bdd:
        """All starts of steps that the controller reaches."""
        starts = new = self.encoding.initial
        rests = self._false
        while new != self._false:
            before, rests = rests, self._forward.of(rests | self._completed(new), self._at_rest)
            found = [self._after(steps, rests & ~before) for steps in self._inputs.values()]
            new = self.manager.union(found) & ~starts
            starts = starts | new
        return starts

    @cached_property
    def _reached(self) -> list[_Reached]:
        """What inputs led to first, in the order in which chains are to be found."""
        found: list[_Reached] = []
        rests = all_starts = self._false

        def add(event: int, starts: Bdd) -> None:
            nonlocal rests, all_starts
            if starts != self._false:
                new = self._completed(starts) & ~rests
                found.append(_Reached(event, starts, new, rests))
                all_starts, rests = all_starts | starts, rests | new

        add(-1, self.encoding.initial)
        while all_starts != self._starts:
            for number, steps in self._inputs.items():
                add(number, self._after(steps, rests) & ~all_starts)
        return found

    def _reaching(self) -> Bdd:
        """Return the states at rest from which a marked one at rest can be reached."""
        return self._backward(self._at_rest & self.encoding.marked, self._at_rest, self._leading)

    def _backward(self, rests: Bdd, within: Bdd, leading: Callable[[Bdd], Bdd]) -> Bdd:
        """Return ``rests`` and the states at rest ``within`` from which steps lead there.

        ``leading`` gives the states from which a step ends in some states at rest.
        """

        def step(found: Bdd) -> Bdd:
            into = leading(found)
            for steps in self._inputs.values():
                targets = into & ~found if len(steps) == 1 else into
                found = found | (self._before(steps, targets) & within)
            return self._directly_before(found, within)

        return self._closure(self._directly_before(rests, within), step)

    def _directly_before(self, rests: Bdd, within: Bdd) -> Bdd:
        """Return ``rests`` and states at rest ``within`` from which steps lead there: at least all
        those from which steps without internal transitions do."""
        if within == self._at_rest and self._any_order:
            return self._back_freely.of(rests, self.states) & within
        return self._back.of(rests, within)

    def _missed(self) -> tuple[tuple[PlantState, ...], int] | None:
        """Return the chain to a step that ends where something must remain possible and is not."""
        for number, goal in enumerate(self.plant.goals):
            there, along, origin = (self.encoding.holds(expr) for expr in goal.conditions)
            there = there & self.states

            way = partial(self._on_the_way, there=there, along=along)
            reaching = self._backward(self._at_rest & there, self._at_rest & along, way)
            chain = self._chain(self._leading(self._at_rest & origin & ~reaching))
            if chain is not None:
                return chain, number
        return None

    def _on_the_way(self, rests: Bdd, there: Bdd, along: Bdd) -> Bdd:
        """Return the states from which a step passes through ``there``, or ends in ``rests``, and
        until then through states ``along`` only, be it within a round."""
        return self._closure(
            there | rests,
            lambda found: found | (self._before_round(found, (there, along)) & along),
        )

    def _longest(self, starts: Bdd) -> int:
        """Return how many internal transitions a step from ``starts`` takes at the most, of those
        that end."""
        longest, left = 0, {0: starts & self._moving & self._ending}  # by how many were taken
        while left:
            for tau in self._taus.all:
                after: dict[int, Bdd] = {}
                for taken, states in left.items():
                    moved = self.manager.union(self._image(m.disjunct, states) for m in tau.moves)
                    for count, part in ((taken, states & ~tau.before), (taken + 1, moved)):
                        if part != self._false:
                            after[count] = after.get(count, self._false) | part
                left = after
            longest = max([longest, *left])
            moving = ((taken, states & self._moving) for taken, states in left.items())
            left = {taken: states for taken, states in moving if states != self._false}
            self._limit()
        return longest

    # --- any order

    def _differing(self) -> tuple[tuple[PlantState, ...], PlantState, PlantState] | None:
        """Return the chain to a step that can end in two states, and both, if there is one."""
        for variable in sorted(self._taus.undecided()):
            seen = self._false
            for index in range(self.plant.variables[variable].size):
                here = self.encoding.value(variable, index)
                to = self._back_internally.of(self._at_rest & here, self.states)
                chain = self._chain(to & seen)
                if chain is not None:
                    start = self.encoding.state(chain[-1])
                    found = self._closure(start, self._any_after) & self._at_rest
                    least = self.encoding.least
                    return chain, least(found & ~here), least(found & here)
                seen = seen | to
        return None

    def _any_after(self, states: Bdd) -> Bdd:
        for tau in self._taus.all:
            for move in tau.moves:
                states = states | self._image(move.disjunct, states)
        return states

    # --- chains

    def _chain(self, starts: Bdd) -> tuple[PlantState, ...] | None:
        """Return a chain (:class:`Runs`) to one of ``starts``; None if none is reached."""
        starts = starts & self._possible
        if starts == self._false or starts & self._starts == self._false:
            return None
        for place, reached in enumerate(self._reached):
            if reached.starts & starts != self._false:
                return self._chain_from(place, self.encoding.least(reached.starts & starts))
        return None

    def _start_of(self, place: int, rests: Bdd) -> PlantState:
        return self.encoding.least(self._leading(rests) & self._reached[place].starts)

    def _chain_from(self, place: int, start: PlantState) -> tuple[PlantState, ...]:
        chain = [start]
        while place > 0:
            reached = self._reached[place]
            after = self.encoding.state(chain[-1])
            rests = reached.earlier & self._before(self._inputs[reached.event], after)
            place = next(n for n, r in enumerate(self._reached) if r.rests & rests != self._false)
            chain.append(self._start_of(place, rests & self._reached[place].rests))
        return tuple(reversed(chain))
