"""States and events of a robot as the oracle reads them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

from synthesis.oracle_values import Path, Samples, UndefinedValue, evaluate, values_of

from robosc.expr.traversal import walk
from robosc.expr.tree import (
    Expr,
    ParameterRef,
    PhaseRef,
    StateRef,
    ValueRef,
    VariableRef,
)
from robosc.language.events import EventKind, Kind
from robosc.model.automata import Transition, Variable
from robosc.model.entities import Assumption, Communication, Component, Robot

OracleState = tuple[Any, ...]

KINDS = {
    Kind.OUTGOING: (EventKind.RESPONSE,),
    Kind.INCOMING: (EventKind.REQUEST,),
    Kind.SERVED_SERVICE: (EventKind.CALL, EventKind.ANSWER, EventKind.REFUSAL),
    Kind.SERVED_ACTION: (
        EventKind.CALL,
        EventKind.ANSWER,
        EventKind.PROGRESS,
        EventKind.REFUSAL,
        EventKind.RECALL,
    ),
    Kind.SERVICE: (EventKind.REQUEST, EventKind.RESPONSE, EventKind.ERROR),
    Kind.ACTION: (
        EventKind.REQUEST,
        EventKind.RESPONSE,
        EventKind.FEEDBACK,
        EventKind.ERROR,
        EventKind.CANCEL,
        EventKind.CANCELLED,
    ),
}
ANSWERS = (EventKind.ANSWER, EventKind.REFUSAL, EventKind.PROGRESS)
AGREED = (EventKind.REQUEST, *ANSWERS)
"""What all components must agree on that mention it."""
CONTROLLABLE = (*AGREED, EventKind.CANCEL, EventKind.TAU)


@dataclass(frozen=True)
class Event:
    """``key`` is the communication's, or the component of a tau (``index`` counts from 1)."""

    kind: EventKind
    key: str
    index: int = 0

    @property
    def controllable(self) -> bool:
        return self.kind in CONTROLLABLE


@dataclass(frozen=True)
class Occurrence:
    """One event with one value: ``values`` are the taken parts of it, in order."""

    event: Event
    values: tuple[tuple[Path, Any], ...] = ()


def _stays(transition: Transition, place: str) -> bool:
    """Whether a transition of a state may lead into that state."""
    goto = transition.goto
    return goto is None or goto == place or goto.startswith((f"{place}.", f"{place} "))


def is_for(transition: Transition, event: Event) -> bool:
    return transition.event is event.kind and transition.communication == event.key


def _counting(
    levels: Sequence[list[Transition]], decided: set[str] | None
) -> Iterator[tuple[Transition, set[str]]]:
    """What of the levels, from the innermost, may be taken, with the variables decided before.

    ``decided`` is None where none of an inner level is taken for sure; else only what goes nowhere
    goes with that one.
    """
    if not levels:
        return
    here = [t for t in levels[0] if decided is None or t.goto is None]
    for transition in here:
        yield transition, decided or set()
    if all(t.guard is not None for t in here):
        yield from _counting(levels[1:], decided)
        return
    for transition in here:
        more = {a.variable for a in transition.assignments}
        yield from _counting(levels[1:], more | (decided or set()))


def first_phase(communication: Communication) -> str | None:
    """The phase in which a communication begins; None: it has no phases."""
    if communication.kind not in (Kind.INCOMING, Kind.OUTGOING):
        return "idle"
    if communication.kind is Kind.OUTGOING and communication.timeout is not None:
        return "unheard" if communication.heard else "silent"
    if communication.heard:
        return "unheard"
    return None


class OracleEvents:
    """The states of a robot, its events, and what conditions mean in a state."""

    def __init__(self, robot: Robot, samples: Samples | None = None) -> None:
        """``samples`` are the numbers and strings that stand for all, by type."""
        self.robot = robot
        self.samples: Samples = samples or {}
        self.automata: list[Component] = [c for c in robot.components if c.states]
        self.synthesis_variables = self._synthesis_variables()
        self.slots: list[tuple[str, str]] = []
        for component in robot.components:
            if component.states:
                self.slots.append(("at", component.name))
                for variable in component.behaviour.variables:
                    if variable.key in self.synthesis_variables:
                        self.slots.append(("var", variable.key))
            for communication in component.communications:
                if first_phase(communication) is not None:
                    self.slots.append(("phase", communication.key))
        self._found: dict[OracleState, list[tuple[Occurrence, OracleState]]] = {}
        self._leaving: set[OracleState] = set()
        self._concerned: dict[Event, list[Component]] = {}
        self._written: dict[tuple[str, str, Event], tuple[list[Transition], ...]] = {}
        self.slots += [("parameter", parameter.key) for parameter in robot.parameters]
        self.where = {slot: i for i, slot in enumerate(self.slots)}

    # --- what takes part ---------------------------------------------------------------------

    @cached_property
    def variables(self) -> dict[str, Variable]:
        return {v.key: v for c in self.automata for v in c.behaviour.variables}

    @cached_property
    def all_transitions(self) -> list[tuple[str, Transition]]:
        """Every transition with its component, as written."""
        found = []
        for component in self.automata:
            behaviour = component.behaviour
            for place in (behaviour, *behaviour.composites, *behaviour.states):
                found.extend((component.name, transition) for transition in place.transitions)
        return found

    def _synthesis_variables(self) -> set[str]:
        """Read by a guard, a requirement or a provide condition, or on the way to such a one."""
        robot = self.robot
        conditions: list[Expr] = [r.condition for r in robot.requirements]
        conditions += [e for g in robot.goals for e in g.conditions]
        conditions += [a.condition for a in robot.assumptions]
        conditions += [p.condition for p in robot.provides if p.condition is not None]
        conditions += [t.guard for _, t in self.all_transitions if t.guard is not None]
        found = {read for condition in conditions for read in _variables_in(condition)}
        for component in self.automata:
            found |= {
                f"{component.name}.{assignment.variable}"
                for place in (None, *component.behaviour.composites, *component.behaviour.states)
                for tau in (place or component.behaviour).taus
                if place is None or _stays(tau, place.name)
                for assignment in tau.assignments
            }
        while True:
            more = set(found)
            for name, transition in self.all_transitions:
                for assignment in transition.assignments:
                    if f"{name}.{assignment.variable}" in found:
                        more |= _variables_in(assignment.value)
            if more == found:
                return found
            found = more

    @cached_property
    def events(self) -> list[Event]:
        """In model order: each component's communications, then its taus."""
        events = []
        for component in self.robot.components:
            for communication in component.communications:
                own = [Event(kind, communication.key) for kind in KINDS[communication.kind]]
                events += [e for e in own if self._occurs_at_all(e, communication)]
                if communication.kind is Kind.OUTGOING and communication.timeout is not None:
                    events.append(Event(EventKind.TIMEOUT, communication.key))
            if component.behaviour is not None:
                taus = list(component.behaviour.taus)
                for place in (*component.behaviour.composites, *component.behaviour.states):
                    taus.extend(place.taus)
                for tau in sorted(taus, key=lambda tau: tau.index):
                    events.append(Event(EventKind.TAU, component.name, tau.index))
                places = (*component.behaviour.composites, *component.behaviour.states)
                waiting = [a for place in places for a in place.afters]
                for after in sorted(waiting, key=lambda after: after.index):
                    events.append(Event(EventKind.AFTER, component.name, after.index))
        return events

    def _occurs_at_all(self, event: Event, communication: Communication) -> bool:
        """Nobody answers with an error, or ends a goal, of itself; and feedback needs data."""
        if event.kind is EventKind.PROGRESS:
            name = f"{event.key}.feedback"
            return bool(self.concerned(event)) or any(
                p.communication == name for p in self.robot.provides
            )
        ends = event.kind is EventKind.REFUSAL or (
            event.kind is EventKind.ANSWER and communication.kind is Kind.SERVED_ACTION
        )
        return not ends or bool(self.concerned(event))

    def occurrences(self, event: Event) -> list[Occurrence]:
        """The event once per value that some synthesis variable or guard takes."""
        paths: list[Path] = []
        for component in self.automata:
            for transition, written in self._effective(component, event):
                read: list[Expr] = [] if transition.guard is None else [transition.guard]
                read += [
                    assignment.value
                    for assignment in transition.assignments
                    if f"{component.name}.{assignment.variable}" in self.synthesis_variables
                    and assignment.variable not in written
                ]
                for expr in read:
                    for part in walk(expr):
                        if isinstance(part, ValueRef) and part.path not in paths:
                            paths.append(part.path)
        for assumption in self.robot.assumptions:
            if self.is_about(assumption, event):
                read_here = (part for part in walk(assumption.condition))
                paths += dict.fromkeys(
                    part.path
                    for part in read_here
                    if isinstance(part, ValueRef) and part.path not in paths
                )
        if not paths:
            return [Occurrence(event)]
        type_ = self.robot.communications[event.key].value_type(event.kind)
        choices = [
            [(path, value) for value in values_of(type_, path, self.samples)] for path in paths
        ]
        nothing = [Occurrence(event, tuple((path, None) for path in paths))]
        found = [Occurrence(event, values) for values in product(*choices) if _possible(values)]
        return found + (nothing if event.kind is EventKind.ERROR else [])

    def is_about(self, assumption: Assumption, event: Event) -> bool:
        """Whether an assumption names what sends an event, and speaks of it."""
        if assumption.communication != event.key:
            return False
        communication = self.robot.communications[event.key]
        if event.kind is EventKind.FEEDBACK:
            reads = any(isinstance(part, ValueRef) for part in walk(assumption.condition))
            return not reads or communication.feedback == communication.response
        return event.kind is EventKind.RESPONSE

    def is_excluded(self, state: OracleState, occurrence: Occurrence, target: OracleState) -> bool:
        """Whether the robot is assumed not to do this."""
        event = occurrence.event
        if event.kind not in (EventKind.RESPONSE, EventKind.FEEDBACK):
            return False
        for assumption in self.robot.assumptions:
            condition = assumption.condition
            if self.is_about(assumption, event) and not self.holds(condition, state, occurrence):
                return True
            lasting = assumption.communication is None and self.holds(condition, state)
            if lasting and not self.holds(condition, target):
                return True
        return False

    def _effective(self, component: Component, event: Event) -> list[tuple[Transition, set[str]]]:
        """What of the transitions counts in at least one state, in the order of the states.

        With each, the variables on which one of the state decides.
        """
        found: list[tuple[Transition, set[str]]] = []
        for state in component.behaviour.states:
            levels = self._transitions_for(component, state.name, event)
            if event.kind in AGREED:
                found += [(t, set()) for t in next(filter(None, levels), [])]
            else:
                found += _counting(levels, None)
        return found

    def concerned(self, event: Event) -> list[Component]:
        """The components that have a transition for an event, in any of their states."""
        if event not in self._concerned:
            names = {name for name, transition in self.all_transitions if is_for(transition, event)}
            self._concerned[event] = [c for c in self.automata if c.name in names]
        return self._concerned[event]

    def _transitions_for(
        self, component: Component, here: str, event: Event
    ) -> tuple[list[Transition], ...]:
        """The transitions for an event that apply in a state, level by level from the innermost."""
        key = component.name, here, event
        if key not in self._written:
            behaviour = component.behaviour
            places = {
                place.name.replace(" ", "."): place  # the stage of a performing state is last
                for place in (*behaviour.composites, *behaviour.states)
            }
            steps = here.replace(" ", ".").split(".")
            inside = [places[".".join(steps[:n])] for n in range(len(steps), 0, -1)]
            levels = [place.transitions for place in (*inside, behaviour)]
            self._written[key] = tuple([t for t in level if is_for(t, event)] for level in levels)
        return self._written[key]

    def _taken(
        self, component: Component, state: OracleState, occurrence: Occurrence
    ) -> list[Transition]:
        """The transitions that a component takes, the one that decides on a variable last."""

        def holding(transitions: list[Transition]) -> list[Transition]:
            return [
                t for t in transitions if t.guard is None or self.holds(t.guard, state, occurrence)
            ]

        here = self.get(state, "at", component.name)
        levels = self._transitions_for(component, here, occurrence.event)
        if occurrence.event.kind in AGREED:
            return holding(next(filter(None, levels), []))
        taken: list[Transition] = []
        for level in levels:
            # What goes somewhere is hidden, and its guard may read what no occurrence has.
            taken = [*holding([t for t in level if not taken or t.goto is None]), *taken]
        return taken

    # --- the plant ---------------------------------------------------------------------------

    @cached_property
    def initials(self) -> list[OracleState]:
        """One for each combination of values of the parameters, which never change, and of the
        persistent variables: those with the values after ``=`` first."""
        types = {parameter.key: parameter.type for parameter in self.robot.parameters}
        values: list[list[Any]] = []
        for what, name in self.slots:
            if what == "at":
                behaviour = self.robot.component(name).behaviour
                values.append([next(s.name for s in behaviour.states if s.initial)])
            elif what == "var":
                variable = self.variables[name]
                every = values_of(variable.type, (), self.samples) if variable.persistent else []
                values.append(list(dict.fromkeys((variable.initial, *every))))
            elif what == "phase":
                values.append([first_phase(self.robot.communications[name])])
            else:
                found = values_of(types[name], (), self.samples)
                values.append([v for v in found if not isinstance(v, float) or math.isfinite(v)])
        return list(product(*values))

    @property
    def initial(self) -> OracleState:
        """The initial state of a robot without parameters."""
        (state,) = self.initials
        return state

    def get(self, state: OracleState, what: str, name: str) -> Any:
        return state[self.where[what, name]]

    def holds(self, expr: Expr, state: OracleState, occurrence: Occurrence | None = None) -> bool:
        """Whether a condition holds; an undefined one does not."""
        try:
            return bool(self.value(expr, state, occurrence))
        except UndefinedValue:
            return False

    def value(self, expr: Expr, state: OracleState, occurrence: Occurrence | None = None) -> Any:
        def read(part: Expr) -> Any:
            match part:
                case VariableRef(component=component, variable=variable):
                    return self.get(state, "var", f"{component}.{variable}")
                case StateRef(component=component, places=names):
                    return self.get(state, "at", component) in names
                case PhaseRef(communication=key, places=phases):
                    return self.get(state, "phase", key) in phases
                case ParameterRef(parameter=parameter):
                    return self.get(state, "parameter", parameter.key)
                case ValueRef(path=path):
                    assert occurrence is not None
                    found = dict(occurrence.values)[path]
                    if found is None:
                        raise UndefinedValue
                    return found
            raise TypeError(part)

        return evaluate(expr, read)


def _variables_in(expr: Expr) -> set[str]:
    return {f"{p.component}.{p.variable}" for p in walk(expr) if isinstance(p, VariableRef)}


def _possible(values: tuple[tuple[Path, Any], ...]) -> bool:
    """Whether the missing parts fit together: what lies behind a missing index is missing, too.

    Where ``a[1]`` is there, so is ``a[0]``; ``a[0].x`` and ``a[0].y`` are there both or not at all.
    """
    for path, value in values:
        for other_path, other in values:
            if value is None and other is not None and _needs(other_path, path):
                return False
    return True


def _needs(there: Path, missing: Path) -> bool:
    """Whether a part at ``there`` can only be there if the one at ``missing`` is, too."""
    for depth, step in enumerate(missing):
        later = missing[depth + 1 :]
        if isinstance(step, int) and not any(isinstance(s, int) for s in later):
            same_array = len(there) > depth and there[:depth] == missing[:depth]
            return same_array and isinstance(there[depth], int) and there[depth] >= step
    return False
