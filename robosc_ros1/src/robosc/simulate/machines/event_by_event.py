"""Single events: the supervised system, one event at a time, none of them the controller's choice.

What is possible is what ``robosc explore`` lists. Data-only variables, which no state of the plant
has, are kept beside it.
"""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from robosc import errors, limits
from robosc.expr import evaluation, traversal, tree, types, undefined_data
from robosc.language import events, operators
from robosc.plant import acceptance, event_values, model_text
from robosc.plant.automaton import Edge, Event, EventParameter, Plant, PlantState, VariableKind
from robosc.plant.conjuncts import Conjunct, conjuncts
from robosc.plant.data.classes import Classes
from robosc.plant.data.terms import value_of
from robosc.plant.step import (
    Values,
    Verdict,
    holds,
    is_true,
    lookup,
    outcome,
    taken_edge,
    valuations,
)
from robosc.runtime.core.places import told_with_stage
from robosc.runtime.core.reasons import UNEXPLAINED, failure_text
from robosc.runtime.core.values import Undefined, widen
from robosc.simulate.faults import InvalidLine, Refused
from robosc.simulate.machines import machine
from robosc.simulate.machines.machine import Reason
from robosc.simulate.machines.state import SystemState, sent_data, state_of
from robosc.simulate.values import event_data
from robosc.supervisor import Guard, Step, Supervisor
from robosc.synthesis.compiled_steps import CompiledEvent, Stepper
from robosc.synthesis.controlled_system import tau_values
from robosc.synthesis.formatting import short_step_text, step_text

# Why the supervisor does not enable a command, in a state of the plant.


def reasons(
    supervisor: Supervisor, guard: Guard, state: PlantState, data: SystemState
) -> tuple[Reason, ...]:
    """Everything that stands in the way of a controllable event; empty if it is enabled.

    ``data`` is the same state with the values of its data, as far as they are known.
    """
    plant = supervisor.plant
    event = guard.event
    found = list(_from_plant(supervisor, event, state))
    if holds(plant, guard.expr, state):
        return tuple(found)
    if event.kind is events.EventKind.CANCEL and not (
        event.requirement is not None and holds(plant, event.requirement, state)
    ):
        return tuple(found or _kept(supervisor, event))
    violated = list(_violated(supervisor, event, state, data))
    if violated or found:
        return (*found, *violated)
    return (Reason("synthesis", _explained(supervisor, event)),)


def _kept(supervisor: Supervisor, event: Event) -> Iterator[Reason]:
    """An action is cancelled only for a requirement that is violated."""
    for index in event.requirements:
        requirement = supervisor.plant.robot.requirements[index]
        yield Reason(
            "requirement", f"this requirement holds: {requirement.text}", requirement.span.place
        )
    if not event.requirements:
        yield Reason("requirement", "no requirement is a reason to cancel it")


def _from_plant(supervisor: Supervisor, event: Event, state: PlantState) -> Iterator[Reason]:
    plant = supervisor.plant
    if event.phase is not None and state[event.phase.variable] not in event.phase.sources:
        phase = plant.variables[event.phase.variable].values[state[event.phase.variable]]
        yield Reason("phase", f"it is {phase}")
    # Whether the plant can do it does not hang on what the environment makes of it.
    values = next(valuations(event))
    after = outcome(plant, event, values, state)
    if after is Verdict.OUT_OF_RANGE:
        yield Reason("range", "a variable would leave its range")
    elif after is Verdict.IMPOSSIBLE:
        look = lookup(plant, event, values, state)
        for automaton in event.automata:
            if automaton.blocking and taken_edge(automaton, state, look) is None:
                where = str(plant.variables[automaton.variable].values[state[automaton.variable]])
                text = f"blocked by {automaton.component} in {told_with_stage(where)}"
                yield Reason("synchronisation", text)


def _violated(
    supervisor: Supervisor, event: Event, state: PlantState, data: SystemState
) -> Iterator[Reason]:
    if not event.kind.sent:
        return
    plant = supervisor.plant
    for index in event.requirements:
        requirement = plant.robot.requirements[index]
        if not _may_hold(plant, event, plant.view.met(requirement), state):
            because = [
                failure_text(part.failure, _known_value(part, data), part.limits)
                for part in conjuncts(requirement, plant.robot)
                if _may_hold(plant, event, plant.view.expression(part.unmet), state)
            ]
            told = [text for text in because if text]
            yield Reason("requirement", requirement.text, requirement.span.place, told)


def _may_hold(plant: Plant, event: Event, condition: tree.Expr, state: PlantState) -> bool:
    """Whether a condition holds in a state, of data with one of the values that they have in this
    case of the event; of what the plant does not know of them, it does not.
    """
    parts = {parameter.path for parameter in event.parameters}
    if not all(path in parts for path in event_values.values_read([condition])):
        return False
    return any(
        is_true(condition, lookup(plant, event, values, state)) for values in valuations(event)
    )


def _known_value(part: Conjunct, data: SystemState) -> dict[str, types.Value]:
    """The values that a part compares, if its data are all known, and do not hold either.

    Of a test, a single event may have chosen what it came to, without any value.
    """
    try:
        values = {name: evaluation.evaluate(expr, data.look) for name, expr in part.values.items()}
        return values if is_true(part.unmet, data.look) else {}
    except Undefined:
        return {}


def _explained(supervisor: Supervisor, event: Event) -> str:
    found = [e.reason for e in supervisor.explanations if e.event == event]
    return errors.listing(found) if found else UNEXPLAINED


_Moment = tuple[PlantState, Mapping[str, types.Value | None]]


class SingleEvents:
    """A :class:`~robosc.simulate.machines.machine.Machine` of the supervised system."""

    time = None
    stopped = None
    beginning: Sequence[machine.Happening] = ()

    def __init__(self, supervisor: Supervisor) -> None:
        self.supervisor = supervisor
        self._stepper = Stepper(supervisor.plant)
        self._numbers = {event.identity: n for n, event in enumerate(self.plant.events)}
        self._guards = {guard.event.identity: guard for guard in supervisor.guards}
        self._controlled: dict[int, CompiledEvent] = {}
        self._data = {
            key: variable
            for key, variable in self.plant.robot.variables.items()
            if not variable.in_state or types.domain(variable.type) is None
        }
        self._past: list[_Moment] = []
        self.restart()

    @property
    def plant(self) -> Plant:
        return self.supervisor.plant

    @property
    def typeable(self) -> Sequence[Event]:
        return self.plant.events

    @property
    def plant_state(self) -> PlantState:
        return self._now[0]

    @property
    def state(self) -> SystemState:
        return state_of(self.plant, *self._now)

    def restart(self) -> None:
        self._now: _Moment = (
            self.plant.initial,
            {key: variable.initial for key, variable in self._data.items()},
        )
        self._past.clear()

    def undo(self, count: int) -> None:
        if count:
            self._now = self._past[-count]
            del self._past[-count:]

    # --- what can happen -------------------------------------------------------------------------

    def _under_control(self, event: Event) -> CompiledEvent:
        number = self._numbers[event.identity]
        if number not in self._controlled:
            guard = self._guards.get(event.identity)
            condition = None if guard is None else guard.expr
            self._controlled[number] = self._stepper.compiled(number, condition)
        return self._controlled[number]

    def _target(self, event: Event, values: Values) -> PlantState | None:
        """Where an event leads under control; None if it cannot happen."""
        one = replace(self._under_control(event), values=[values])
        return next((after for _, after in one.targets(self.plant_state)), None)

    def can(self, event: Event, given: event_data.Given | None) -> bool:
        if given is not None:
            values = self._values(event, given)
            event = _case_of(self._cases(event), values)
            return _known(event, values) and self._target(event, values) is not None
        if event.known:
            return any(map(self._happens, self._cases(event)))
        return self._happens(event)

    def _cases(self, event: Event) -> Sequence[Event]:
        """The events for all data of a request that another controller sends."""
        return [e for e in self.plant.events if e.whole is event.whole] if event.known else [event]

    def _happens(self, event: Event) -> bool:
        """Whether an event can happen, with some value."""
        phase = acceptance.phase_of(event)
        if phase is not None and self.plant_state[phase.variable] not in phase.sources:
            return False  # whatever its value, and these may be very many
        return any(True for _ in self._under_control(event).targets(self.plant_state))

    def choices(self) -> list[machine.Choice]:
        found = []
        for event in self.plant.events:
            if not machine.is_typed(self.plant.robot, event):
                possible = self._under_control(event).targets(self.plant_state)
                found += [self._choice(event, values, after) for values, after in possible]
            elif self.can(event, None):
                found.append(
                    machine.Choice(
                        event, None, machine.label(event), event_data.hint(self.plant.robot, event)
                    )
                )
        return found

    def _choice(self, event: Event, values: Values, after: PlantState) -> machine.Choice:
        given = event_data.by_path(event, values)
        if event.kind.of_component:
            (path,) = tau_values(self.plant, event, self.plant_state, after)
            return machine.Choice(event, {}, f"{machine.label(event)} ({path})")
        if any(p.labels is not None or p.test is not None for p in event.parameters):
            step = Step(event, values)
            return machine.Choice(event, given, step_text(step), short=short_step_text(step))
        return machine.Choice(event, given, machine.typed_text(event, given))

    def commands(self) -> list[machine.CommandState]:
        state = self.state
        commands = [
            machine.CommandState(
                event,
                reasons(self.supervisor, guard, self.plant_state, state),
                self._sent(event, state),
            )
            for event in self.plant.events
            if (guard := self._guards.get(event.identity)) is not None
        ]
        return machine.with_preferences(commands, self.plant.robot, self.state.phases)

    def _sent(self, event: Event, state: SystemState) -> dict[str, Any] | None:
        """What a request carries now; None for other events."""
        is_request = event.kind.sent and not self.plant.robot.supervises
        return sent_data(self.plant.robot, event.command, state) if is_request else None

    def _lookup(self, given: event_data.Given) -> Callable[[tree.Leaf], types.Value | None]:
        """What leaves of expressions are now, and with the value of an event."""
        state = self.state
        return lambda leaf: (
            event_data.part_given(given, leaf.path, leaf.type)
            if isinstance(leaf, tree.ValueRef)
            else state.look(leaf)
        )

    def _values(self, event: Event, given: event_data.Given) -> Values:
        """The value of each parameter; tests come to what the data say, unless they are given."""
        look = self._lookup(given)

        def value(parameter: EventParameter) -> types.Value | None:
            if parameter.path in given:
                return given[parameter.path]
            if parameter.test is None:  # a part of what was given as a whole, or nothing was
                whole = any(parameter.path[: len(path)] == path for path in given)
                whole &= not event_data.is_test(parameter.path)
                return (
                    event_data.part_given(given, parameter.path, parameter.type)
                    if whole
                    else parameter.values[0]
                )
            try:
                return value_of(parameter.test, look)
            except Undefined:
                return None

        return tuple(value(parameter) for parameter in event.parameters)

    # --- what happens ----------------------------------------------------------------------------

    def fire(self, event: Event, given: event_data.Given) -> list[machine.Happening]:
        values = self._values(event, given)
        event = _case_of(self._cases(event), values)
        before, data = self._now
        if not _known(event, values):
            raise Refused(
                f"{machine.label(event)} cannot carry {event_data.given_text(given)}: outside its"
                " range"
            )
        after = self._target(event, values)
        if after is None:
            raise Refused(f"{machine.label(event)} cannot happen now: {self._why_not(event)}")
        value = event_data.given_json(given)
        if event.kind.of_component:
            (value,) = tau_values(self.plant, event, before, after)
        elif event.kind.sent and not self.plant.robot.supervises:
            value = self._sent(event, self.state)
        assigned = dict(self._assigned(event, {**event_data.by_path(event, values), **given}))
        self._past.append(self._now)
        self._now = after, {**data, **assigned}
        number = event.index if event.kind.of_component else 0
        return [
            machine.Happening(
                event.kind.word, event.name, value, number, controllable=event.controllable
            )
        ]

    def _why_not(self, event: Event) -> str:
        guard = self._guards.get(event.identity)
        if guard is None:
            phase = acceptance.phase_of(event)
            if phase is None:
                return "no state allows it"
            if self.plant_state[phase.variable] in phase.sources:
                return "no component takes it"
            return f"it is {self.state.phases[event.key]}"
        return "; ".join(map(str, reasons(self.supervisor, guard, self.plant_state, self.state)))

    def _assigned(self, event: Event, given: event_data.Given) -> Iterator[tuple[str, types.Value]]:
        """What the event does to data: the right-hand sides see the state before."""
        look = self._lookup(given)
        for automaton in acceptance.components_of(event.whole or event):
            edge = taken_edge(automaton, self.plant_state, look)
            if edge is not None:
                yield from self._data_of(automaton.component, edge, look)

    def _data_of(
        self, component: str, edge: Edge, look: Callable[[tree.Leaf], types.Value | None]
    ) -> Iterator[tuple[str, types.Value]]:
        for assignment in edge.assignments:
            variable = self._data.get(f"{component}.{assignment.variable}")
            if variable is None:
                continue
            try:
                value = evaluation.evaluate(assignment.value, look)
            except Undefined:
                continue  # an array was too short: the variable stays as it was
            match variable.type:
                case types.IntegerType(bounds=(low, high)) if not low <= value <= high:  # type: ignore[operator]
                    continue
                case types.DoubleType():
                    value = widen(value)
            yield variable.key, value

    def wait(self, seconds: float) -> list[machine.Happening]:
        raise InvalidLine("time does not matter for single events: wait needs --execute")

    # --- where to --------------------------------------------------------------------------------

    def path(self, condition: tree.Expr) -> list[tuple[Event, event_data.Given]] | None:
        # The graph is made while it is searched, and the search ends at the first hit.
        test = self._stepper.test(self._of_the_plant(condition))
        start = self.plant_state
        if test(start):
            return []
        ways = self._stepper.controlled(self.supervisor.guards)
        came: dict[PlantState, tuple[PlantState, int, Values] | None] = {start: None}
        queue = deque([start])
        tried = 0
        while queue:
            state = queue.popleft()
            for way in ways:
                for values, target in way.some_targets(state):
                    tried += 1
                    if tried > limits.PATH_EVENTS:
                        raise Refused(f"no path was found by trying {limits.PATH_EVENTS:,} events")
                    if target in came:
                        continue
                    came[target] = state, way.number, values
                    if test(target):
                        return self._trace(came, target)
                    queue.append(target)
                    if len(came) > limits.PATH_STATES:
                        raise Refused(f"no path was found within {limits.PATH_STATES:,} states")
        if sampled := [self.plant.events[way.number] for way in ways if way.is_sampled]:
            names = ", ".join(map(machine.label, sampled))
            raise Refused(f"no path was found; not all values of {names} were tried")
        return None

    def _of_the_plant(self, condition: tree.Expr) -> tree.Expr:
        """The condition over states of the plant, which knows data by what the model asks of them.

        Raises:
            InvalidLine: the plant does not determine where it holds.
        """
        found = self.plant.view.expression(undefined_data.condition_on_data(condition))
        for part in traversal.walk(found):
            known = True
            match part:
                case tree.VariableRef(component=component, variable=name):
                    known = (VariableKind.DATA, f"{component}.{name}") in self.plant.variable_index
                case tree.TestRef(name=name):
                    known = (VariableKind.TEST, name) in self.plant.variable_index
                case tree.Binary(operator=operator) if operator in operators.MIRRORED:
                    known = self._tells_apart(part)
            if not known:
                text = model_text.to_dsl(part, self.plant.robot)
                raise InvalidLine(
                    "a path can be found only to what decides about commands, not to data:"
                    f" '{text}' does not decide"
                )
        return found

    def _tells_apart(self, comparison: tree.Binary) -> bool:
        """Whether the plant knows where a comparison of data with a constant holds."""
        operator, term, constant = comparison.operator, comparison.left, comparison.right
        if isinstance(term, tree.Literal):
            operator, term, constant = operators.MIRRORED[operator], constant, term
        index = self.plant.variable_index
        match term:
            case tree.VariableRef(component=component, variable=name):
                found = index.get((VariableKind.DATA, f"{component}.{name}"))
            case tree.TestRef(name=name):
                found = index.get((VariableKind.TEST, name))
            case _:
                return True
        classes = None if found is None else self.plant.variables[found].values
        if not isinstance(classes, Classes) or not isinstance(constant, tree.Literal):
            return found is not None
        return classes.tell(operator, constant.value)

    def _trace(
        self, came: Mapping[PlantState, tuple[PlantState, int, Values] | None], end: PlantState
    ) -> list[tuple[Event, event_data.Given]]:
        trace: list[tuple[Event, event_data.Given]] = []
        step = came[end]
        while step is not None:
            before, number, values = step
            event = self.plant.events[number]
            trace.append((event, self._filled(event, values)))
            step = came[before]
        return trace[::-1]

    def _filled(self, event: Event, values: Values) -> event_data.Given:
        """A value of the plant with the parts that only data reads."""
        return event_data.completed(
            self.plant.robot, event, event_data.by_path(event, values), machine.label(event)
        )

    def draw(self, rng: random.Random) -> tuple[Event, event_data.Given] | None:
        able = [event for event in self.plant.events if self._happens(event)]
        if not able:
            return None
        event = rng.choice(able)
        values = next(self._drawn(event, rng))
        given = event_data.completed(
            self.plant.robot, event, event_data.by_path(event, values), machine.label(event), rng
        )
        return event, given

    def _drawn(self, event: Event, rng: random.Random) -> Iterator[Values]:
        """Values with which an event can happen; there are some."""
        for _ in range(_DRAWS):
            values = machine.draw_values(event, rng)
            if self._target(event, values) is not None:
                yield values
        # Few of very many values are possible: all of these, in order.
        yield from (values for values, _ in self._under_control(event).targets(self.plant_state))


_DRAWS = 100
"""Values that are drawn before one is searched."""


def _case_of(cases: Sequence[Event], values: Values) -> Event:
    """The one for these values; the first if they are in no range."""
    return next((event for event in cases if _known(event, values)), cases[0])


def _known(event: Event, values: Values) -> bool:
    """Whether the values are among those that the parameters can have."""
    return all(
        value in parameter.values for value, parameter in zip(values, event.parameters, strict=True)
    )
