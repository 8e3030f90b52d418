"""Symbolic search of the controller that runs a supervisor: its run-to-completion steps.

After each event the controller takes internal transitions in source order, round by round, until
none is possible. A round is a function on states with images and preimages, so the properties of
:mod:`robosc.synthesis.explain.properties` are fixpoints:

- a step ends from the states from which rounds lead to a state at rest;
- its end depends on the order if, for some state variable that internal transitions change, either
  of two values can be the last one;
- the states from which a marked state at rest is reachable are found backward from those.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TypeAlias

from robosc import limits
from robosc.language.events import EventKind
from robosc.plant.automaton import Event, PlantState
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import Disjunct, EventRelation
from robosc.synthesis.bdd.saturation import Saturation
from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution
from robosc.synthesis.controlled_system import Runs, inputs

_Steps: TypeAlias = tuple[tuple[Disjunct, ...], ...]


@dataclass(frozen=True, eq=False, slots=True)
class _TauMove:
    """A disjunct of an internal transition under the supervisor, and where it is taken."""

    disjunct: Disjunct
    before: Bdd


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

    Methods raise MemoryError if they need too many diagram nodes.
    """

    def __init__(self, solution: SymbolicSolution) -> None:
        self.states = solution.states
        self.engine = solution.engine
        self.encoding = solution.engine.encoding
        self.manager = solution.engine.manager
        self.plant = solution.engine.plant
        self._false = self.manager.false
        self._most = self.manager.nodes + limits.COMPLETION_NODES
        enabled = {
            event.number: solution.enabled(event)
            for event in self.engine.events
            if self.plant.events[event.number].controllable
        }
        moves = [self._moves(event, enabled) for event in self._taus_of_plant()]
        self._taus = [several for several in moves if several]
        self._moving = self.manager.union(move.before for tau in self._taus for move in tau)
        self._inputs = {
            numbers[0]: self._steps([self.engine.events[n] for n in numbers], enabled)
            for numbers in inputs(self.plant)
        }
        # Most steps lead from rest to rest, and are followed by saturation: two_tools_each 12.
        direct = [s for steps in self._inputs.values() if len(steps) == 1 for s in steps]
        image, preimage = self.engine.relations.image, self.engine.relations.preimage
        self._forward, self._back = (
            Saturation(self.manager, direct, step, lambda *_: self._limit())
            for step in (image, preimage)
        )
        self._starts, self._rests = self._run()

    def runs(self) -> Runs:
        """Return what fails of the controller's run to completion."""
        ending = self._leading(self.states & ~self._moving)
        livelock = self._starts & ~ending
        return Runs(
            livelock=self._chain(livelock),
            differing=self._differing(),
            stuck=self._chain(self._leading(self._rests & ~self._reaching())),
            longest=None if livelock != self._false else self._longest(),
            missed=self._missed(),
        )

    # --- events and rounds

    def _taus_of_plant(self) -> list[EventRelation]:
        events = self.plant.events
        return [e for e in self.engine.events if events[e.number].kind is EventKind.TAU]

    def _moves(self, event: EventRelation, enabled: dict[int, Bdd]) -> list[_TauMove]:
        moves = []
        for disjunct in event.disjuncts:
            if not disjunct.stays:  # the controller does not take what changes nothing
                relation = disjunct.relation & enabled[event.number]
                before = self.manager.exists(relation, disjunct.after)
                moves.append(_TauMove(replace(disjunct, relation=relation), before))
        return [move for move in moves if move.before != self._false]

    def _steps(self, events: Sequence[EventRelation], enabled: dict[int, Bdd]) -> _Steps:
        """Return the events of one input, one after the other.

        The first is possible where the controller is at rest and sends no preferred command. One
        of several events may change nothing.
        """
        steps: list[tuple[Disjunct, ...]] = []
        for event in events:
            here = self.states if steps else self._at_rest(event, enabled)
            disjuncts = (d for d in event.disjuncts if len(events) > 1 or not d.stays)
            step = tuple(replace(d, relation=d.relation & here) for d in disjuncts)
            if step:
                steps.append(step)
        return tuple(steps)

    def _at_rest(self, event: EventRelation, enabled: dict[int, Bdd]) -> Bdd:
        here = self.states & ~self._moving & enabled.get(event.number, self.manager.true)
        taken = self.plant.events[event.number]
        if taken.kind.sent:
            preferred = self.plant.robot.yields_to.get(taken.command, ())
            for number, other in enumerate(self.plant.events):
                if other.kind.sent and other.command in preferred:
                    here = here & ~(enabled[number] & ~self._replacing(other))
        return here

    def _replacing(self, event: Event) -> Bdd:
        """Return the states in which a request would replace a goal."""
        phase = event.phase
        if phase is None or event.kind is not EventKind.REQUEST:
            return self._false
        return self.encoding.holds(self.plant.variables[phase.variable].phase(phase.target))

    def _after(self, steps: _Steps, states: Bdd) -> Bdd:
        """Return the image of an input; an event that changes nothing leads nowhere."""
        relations = self.engine.relations
        for step in steps:
            states = self.manager.union(relations.image(disjunct, states) for disjunct in step)
        return states if steps else self._false

    def _before(self, steps: _Steps, states: Bdd) -> Bdd:
        relations = self.engine.relations
        for step in reversed(steps):
            states = self.manager.union(relations.preimage(disjunct, states) for disjunct in step)
        return states if steps else self._false

    def _round(self, states: Bdd) -> Bdd:
        """Return the image of one round of internal transitions, each tried once."""
        for tau in self._taus:
            left = states
            moved = []
            for move in tau:
                moved.append(self.engine.relations.image(move.disjunct, states))
                left = left & ~move.before
            states = self.manager.union([left, *moved])
        return states

    def _before_round(self, states: Bdd, way: tuple[Bdd, Bdd] | None = None) -> Bdd:
        """Return the preimage of one round of internal transitions; with a ``way``, of one that
        comes through the first set, or to ``states`` through the second one only."""
        for tau in reversed(self._taus):
            left = states
            entered = states if way is None else way[0] | (states & way[1])
            came = []
            for move in tau:
                came.append(self.engine.relations.preimage(move.disjunct, entered))
                left = left & ~move.before
            states = self.manager.union([left, *came])
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
        return self._closure(
            states, lambda found: found | (self._before_round(found) & self.states)
        )

    def _closure(self, states: Bdd, step: Callable[[Bdd], Bdd]) -> Bdd:
        while True:
            self._limit()
            before, states = states, step(states)
            if states == before:
                return states

    def _limit(self) -> None:
        self.manager.make_room()
        work = self._forward.work + self._back.work
        if self.manager.nodes > self._most or work > limits.COMPLETION_PARTS:
            raise MemoryError

    # --- from rest to rest

    def _run(self) -> tuple[Bdd, Bdd]:
        """Return all starts of steps, and all states at rest, that the controller reaches."""
        at_rest = self.states & ~self._moving
        starts = new = self.encoding.initial
        rests = self._false
        while new != self._false:
            before, rests = rests, self._forward.of(rests | self._completed(new), at_rest)
            found = [self._after(steps, rests & ~before) for steps in self._inputs.values()]
            new = self.manager.union(found) & ~starts
            starts = starts | new
        return starts, rests

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
        return self._backward(self._rests & self.encoding.marked, self._rests, self._leading)

    def _backward(self, rests: Bdd, within: Bdd, leading: Callable[[Bdd], Bdd]) -> Bdd:
        """Return ``rests`` and the states at rest ``within`` from which steps lead there.

        ``leading`` gives the states from which a step ends in some states at rest.
        """

        def step(found: Bdd) -> Bdd:
            into = leading(found)
            for steps in self._inputs.values():
                targets = into & ~found if len(steps) == 1 else into
                found = found | (self._before(steps, targets) & within)
            return self._back.of(found, within)

        return self._closure(self._back.of(rests, within), step)

    def _missed(self) -> tuple[tuple[PlantState, ...], int] | None:
        """Return the chain to a step that ends where something must remain possible and is not."""
        for number, goal in enumerate(self.plant.goals):
            there, along, origin = (self.encoding.holds(expr) for expr in goal.conditions)
            there = there & self.states

            way = partial(self._on_the_way, there=there, along=along)
            reaching = self._backward(self._rests & there, self._rests & along, way)
            chain = self._chain(self._leading(self._rests & origin & ~reaching))
            if chain is not None:
                return chain, number
        return None

    def _on_the_way(self, rests: Bdd, there: Bdd, along: Bdd) -> Bdd:
        """Return the states from which a step passes through ``there``, or ends in ``rests``, and
        until then through states ``along`` only, be it within a round."""
        return self._closure(
            there | rests,
            lambda found: found | (self._before_round(found, (there, along)) & self.states & along),
        )

    def _longest(self) -> int:
        """Return a bound on the internal transitions of a step: rounds times transitions."""
        rounds, left = 0, self._starts & self._moving
        while left != self._false:
            left = self._round(left) & self._moving
            rounds += 1
            self._limit()
        return rounds * len(self._taus)

    # --- any order

    def _differing(self) -> tuple[tuple[PlantState, ...], PlantState, PlantState] | None:
        """Return the chain to a step that can end in two states, and both, if there is one."""
        ends = self.states & ~self._moving
        written = {variable for event in self._taus_of_plant() for variable in event.writes}
        for variable in sorted(written):
            seen = self._false
            for index in range(self.plant.variables[variable].size):
                here = self.encoding.value(variable, index)
                to = self._closure(ends & here, self._any_before)
                chain = self._chain(to & seen & self._starts)
                if chain is not None:
                    found = self._closure(self.encoding.state(chain[-1]), self._any_after) & ends
                    least = self.encoding.least
                    return chain, least(found & ~here), least(found & here)
                seen = seen | to
        return None

    def _any_before(self, states: Bdd) -> Bdd:
        for tau in self._taus:
            for move in tau:
                states = states | self.engine.relations.preimage(move.disjunct, states)
        return states

    def _any_after(self, states: Bdd) -> Bdd:
        for tau in self._taus:
            for move in tau:
                states = states | self.engine.relations.image(move.disjunct, states)
        return states

    # --- chains

    def _chain(self, starts: Bdd) -> tuple[PlantState, ...] | None:
        """Return a chain (:class:`Runs`) to one of ``starts``; None if none is reached."""
        if starts & self._starts == self._false:
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
