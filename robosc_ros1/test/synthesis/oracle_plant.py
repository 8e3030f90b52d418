"""The plant as the oracle reads it: what an event does in a state, and all that can be reached."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from synthesis.oracle_events import (
    AGREED,
    Event,
    Occurrence,
    OracleEvents,
    OracleState,
    first_phase,
)
from synthesis.oracle_values import Impossible, OutOfRange, UndefinedValue

from robosc.expr.types import IntegerType
from robosc.language.events import EventKind, command_key
from robosc.model import automata
from robosc.model.entities import Component


@dataclass(frozen=True)
class Transition:
    source: OracleState
    occurrence: Occurrence
    target: OracleState


class OraclePlant(OracleEvents):
    """The plant of a robot, by exhaustive search."""

    def step(self, state: OracleState, occurrence: Occurrence) -> OracleState:
        """The state after an occurrence; raises Impossible or OutOfRange."""
        after: dict[tuple[str, str], Any] = {}
        event = occurrence.event
        if event.kind is EventKind.TAU:
            self._step_tau(state, event, after)
        elif event.kind is EventKind.AFTER:
            self._step_after(state, occurrence, after)
        else:
            self._step_phase(state, event, after)
            concerned = self.concerned(event)
            for component in concerned:
                self._step_component(component, state, occurrence, after)
            if event.kind is EventKind.CALL and not any(
                self._taken(component, state, occurrence) for component in concerned
            ):
                raise Impossible
        changed = list(state)
        for slot, value in after.items():
            changed[self.where[slot]] = value
        for lasting in self.robot.lasting:  # one behind those that it reads
            if not self.holds(lasting.condition, tuple(changed)):
                changed[self.where["at", lasting.name]] = "waiting"
        return tuple(changed)

    def _step_tau(self, state: OracleState, event: Event, after: dict[Any, Any]) -> None:
        behaviour = self.robot.component(event.key).behaviour
        component = self.robot.component(event.key)
        here = self.get(state, "at", event.key)
        present = next(s for s in behaviour.states if s.name == here)
        around = (
            o.taus
            for o in behaviour.composites
            if present.name.startswith((f"{o.name}.", f"{o.name} "))
        )
        for tau in (*behaviour.taus, *(tau for taus in around for tau in taus), *present.taus):
            if tau.index != event.index or not (tau.guard is None or self.holds(tau.guard, state)):
                continue
            self._assign(component, [tau], state, Occurrence(event), after)
            changes = any(state[self.where[slot]] != value for slot, value in after.items())
            if tau.assignments and not changes:
                raise Impossible
            return
        raise Impossible

    def _step_after(
        self, state: OracleState, occurrence: Occurrence, after: dict[Any, Any]
    ) -> None:
        """Time passes whenever it is waited for: the component must be there, the guard hold."""
        component = self.robot.component(occurrence.event.key)
        here = self.get(state, "at", component.name)
        present = next(s for s in component.behaviour.states if s.name == here)
        around = [
            o
            for o in component.behaviour.composites
            if here.startswith((f"{o.name}.", f"{o.name} "))
        ]
        for waiting in (a for place in (present, *around) for a in place.afters):
            if waiting.index != occurrence.event.index:
                continue
            if waiting.guard is None or self.holds(waiting.guard, state):
                self._assign(component, [waiting], state, occurrence, after)
                return
        raise Impossible

    def _step_phase(self, state: OracleState, event: Event, after: dict[Any, Any]) -> None:
        first = first_phase(self.robot.communications[event.key])
        if first is None:
            return
        phase = self.get(state, "phase", event.key)
        if first in ("silent", "unheard"):
            if event.kind is EventKind.TIMEOUT and phase != "fresh":
                raise Impossible
            timed = self.robot.communications[event.key].timeout is not None
            arrived = "fresh" if timed else "heard"
            after["phase", event.key] = arrived if event.kind is EventKind.RESPONSE else "silent"
            return
        if event.kind in (EventKind.REQUEST, EventKind.CALL):
            follows = {"idle": "busy"}
            if self.robot.communications[event.key].goals == "replace":
                follows["busy"] = "busy"
        elif event.kind in (EventKind.FEEDBACK, EventKind.PROGRESS):
            follows = {"busy": "busy"}
        elif event.kind is EventKind.RECALL:
            follows = {"busy": "ending"}
        elif event.kind is EventKind.CANCEL:
            follows = {"busy": "cancelling"}
        elif event.kind is EventKind.CANCELLED:
            follows = {"cancelling": "idle"}
        else:
            follows = {"busy": "idle", "cancelling": "idle", "ending": "idle"}
        if phase not in follows:
            raise Impossible
        after["phase", event.key] = follows[phase]

    def _performs_with_others(self, component: Component, command: str) -> bool:
        """Whether a component is one of several that perform a command: it blocks it nowhere."""
        performing = [
            c.name
            for c in self.automata
            if any(outer.performs == command for outer in c.behaviour.composites)  # type: ignore[union-attr]
        ]
        return len(performing) > 1 and component.name in performing

    def _step_component(
        self,
        component: Component,
        state: OracleState,
        occurrence: Occurrence,
        after: dict[Any, Any],
    ) -> None:
        taken = self._taken(component, state, occurrence)
        if not taken:
            event = occurrence.event
            command = command_key(event.key, event.kind)
            if event.kind in AGREED and not self._performs_with_others(component, command):
                raise Impossible
            return
        levels = self._transitions_for(
            component, self.get(state, "at", component.name), occurrence.event
        )
        assert all(
            sum(any(t is one for one in level) for t in taken) <= 1 for level in levels
        )  # guards exclude each other
        self._assign(component, taken, state, occurrence, after)

    def _assign(
        self,
        component: Component,
        taken: list[automata.Transition],
        state: OracleState,
        occurrence: Occurrence,
        after: dict[Any, Any],
    ) -> None:
        if taken[-1].goto is not None:
            after["at", component.name] = taken[-1].goto
        deciding = {a.variable: a for transition in taken for a in transition.assignments}
        for assignment in deciding.values():
            key = f"{component.name}.{assignment.variable}"
            if key not in self.synthesis_variables:
                continue
            try:
                value = self.value(assignment.value, state, occurrence)
            except UndefinedValue:
                continue
            match self.variables[key].type:
                case IntegerType(bounds=(low, high)):
                    if not low <= value <= high:
                        raise OutOfRange
            after["var", key] = value

    def marked(self, state: OracleState) -> bool:
        for (what, name), value in zip(self.slots, state, strict=True):
            if what == "phase" and value in ("busy", "cancelling", "ending"):
                return False
            if what == "at":
                behaviour = self.robot.component(name).behaviour
                if not next(s for s in behaviour.states if s.name == value).marked:
                    return False
        return True

    @cached_property
    def plant(self) -> tuple[list[OracleState], list[Transition]]:
        """Everything that can be reached without any requirement."""
        return self._explore(lambda state, event, target: True)

    def has_at_most(self, count: int) -> bool:
        """Whether so many states can be reached, found out by looking at no more."""
        found = set(self.initials)

        def allowed(state: OracleState, event: Event, target: OracleState) -> bool:
            found.add(target)
            return len(found) <= count

        self._explore(allowed)
        return len(found) <= count

    def _explore(self, allowed: Any) -> tuple[list[OracleState], list[Transition]]:
        """What can be reached by steps that are ``allowed``, and these steps."""
        states = dict.fromkeys(self.initials)
        transitions = []
        queue = deque(self.initials)
        while queue:
            state = queue.popleft()
            for occurrence, target in self.successors(state):
                if not allowed(state, occurrence.event, target):
                    continue
                transitions.append(Transition(state, occurrence, target))
                if target not in states:
                    states[target] = None
                    queue.append(target)
        return list(states), transitions

    @cached_property
    def _all_occurrences(self) -> list[Occurrence]:
        return [o for event in self.events for o in self.occurrences(event)]

    def successors(self, state: OracleState) -> list[tuple[Occurrence, OracleState]]:
        if state in self._found:
            return self._found[state]
        found = self._found[state] = []
        for occurrence in self._all_occurrences:
            try:
                target = self.step(state, occurrence)
                if not self.is_excluded(state, occurrence, target):
                    found.append((occurrence, target))
            except OutOfRange:
                # Where it leads is no state, so nothing is assumed of it.
                excluded = self.is_excluded(state, occurrence, state)
                if not occurrence.event.controllable and not excluded:
                    self._leaving.add(state)
            except Impossible:
                pass
        return found

    def leaves_a_range(self, state: OracleState) -> bool:
        """Whether an uncontrollable event would take a variable out of its range."""
        self.successors(state)
        return state in self._leaving
