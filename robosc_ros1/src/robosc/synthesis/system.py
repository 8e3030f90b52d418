"""What reports ask of a controlled system, whichever engine computed it.

Questions are conditions over the state, as expressions: where the plant can do an event
(:func:`possible`), where requirements allow it (:func:`allowed`), where the supervisor does
(:func:`enabled`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

from robosc.errors import StateSpaceError
from robosc.ir.automaton import Edge, Event, LocalAutomaton, PhaseStep, Plant, PlantState
from robosc.ir.formulas import conjunction, disjunction, negation
from robosc.ir.step import Values
from robosc.model.entities import EventKind, Kind
from robosc.model.expr import FALSE, TRUE, Binary, Expr, Literal, PhaseRef, StateRef
from robosc.model.types import BooleanType, IntegerType
from robosc.supervisor import Guard, Step
from robosc.synthesis.stepper import Stepper

__all__ = [
    "Runs",
    "System",
    "allowed",
    "enabled",
    "in_phase",
    "inputs",
    "make_step",
    "possible",
    "steps_of",
    "tau_values",
]


@dataclass(frozen=True, slots=True)
class Runs:
    """What becomes of a controller's runs to completion; None where nothing is wrong.

    Each is given by a chain of states in which completions start: the initial state, and after each
    completion what one event leads to. ``livelock``: the last completion ends in a cycle.
    ``differing``: where it ends depends on the order, and may be either of two states. ``stuck``:
    no marked state at rest can be reached from where it ends. ``longest`` bounds the number of
    internal transitions of a completion; None if there is no bound.
    """

    livelock: tuple[PlantState, ...] | None
    differing: tuple[tuple[PlantState, ...], PlantState, PlantState] | None
    stuck: tuple[PlantState, ...] | None
    longest: int | None


def inputs(plant: Plant) -> list[tuple[int, ...]]:
    """What happens to a controller from outside or at its command, as numbers of events: those of
    all communications of one message, in source order, else one event. No internal transitions."""
    found: dict[Hashable, list[int]] = defaultdict(list)
    communications = plant.robot.communications
    for number, event in enumerate(plant.events):
        if event.kind is EventKind.TAU:
            continue
        is_message = event.kind is EventKind.RESPONSE and (
            communications[event.key].kind is Kind.OUTGOING
        )
        found[communications[event.key].identifier if is_message else number].append(number)
    return [tuple(numbers) for numbers in found.values()]


class System(Protocol):
    """A plant under its supervisor."""

    @property
    def plant(self) -> Plant: ...

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        """A shortest path, under control, from an initial state to one where the condition holds.

        Both ends included; None if there is no such state in the controlled system.
        """

    def plant_reaches(self, condition: Expr) -> bool | None:
        """Whether the plant, requirements apart, reaches a state with the condition.

        None: that would be too much work to find out.
        """

    def is_good(self, state: PlantState) -> bool:
        """Whether a state need not be avoided.

        Asked only of states that the plant under its requirements can reach.
        """

    def lost_start(self) -> PlantState:
        """An initial state that cannot be kept; asked only if there is one."""

    def longest_completion(self) -> int | None:
        """The most internal transitions that can follow one another, in any order.

        None: there is no end, or it would be too much work to find out.
        """

    def runs(self) -> Runs | None:
        """What becomes of the controller's runs to completion.

        None: it would be too much work to find out.
        """


def in_phase(plant: Plant, step: PhaseStep) -> Expr:
    """Whether a communication is in a phase in which the event is possible."""
    if len(step.sources) > 1:
        return TRUE
    variable = plant.variables[step.variable]
    active = PhaseRef(variable.name, str(variable.values[1]))
    return active if step.sources == (1,) else negation(active)


def possible(plant: Plant, event: Event) -> Expr:
    """Where the plant can do a controllable event."""
    parts: list[Expr] = []
    if event.phase is not None:
        parts.append(in_phase(plant, event.phase))
    for automaton in event.automata:
        cases: list[Expr] = []
        fails: dict[int, list[Expr]] = {}
        for edge in automaton.edges:
            before = fails.setdefault(edge.source, [])
            here = StateRef(automaton.component, _location(plant, automaton.variable, edge.source))
            guard = [] if edge.guard is None else [edge.guard]
            cases.append(conjunction([here, *before, *guard, *_inside(plant, edge)]))
            before.append(FALSE if edge.guard is None else negation(edge.guard))
        if not automaton.blocking:
            cases.append(_stays(plant, automaton, fails))
        parts.append(disjunction(cases))
    return conjunction(parts)


def _stays(plant: Plant, automaton: LocalAutomaton, fails: dict[int, list[Expr]]) -> Expr:
    """Where no edge of an automaton is taken."""
    stays: list[Expr] = []
    for place, conditions in fails.items():
        location = _location(plant, automaton.variable, place)
        elsewhere = negation(StateRef(automaton.component, location))
        stays.append(disjunction([elsewhere, conjunction(conditions)]))
    return conjunction(stays)


def _location(plant: Plant, variable: int, place: int) -> str:
    return str(plant.variables[variable].values[place])


def _inside(plant: Plant, edge: Edge) -> Iterator[Expr]:
    """That the edge's updates keep to the ranges."""
    for variable, expr in edge.updates:
        values = plant.variables[variable].values
        if isinstance(values, range):
            low = Literal(values[0], IntegerType())
            high = Literal(values[-1], IntegerType())
            yield Binary(">=", expr, low, BooleanType())
            yield Binary("<=", expr, high, BooleanType())


def allowed(plant: Plant, event: Event) -> Expr:
    """Where the plant under its requirements can do a controllable event."""
    return conjunction([TRUE if event.requirement is None else event.requirement,
                        possible(plant, event)])  # fmt: skip


def enabled(plant: Plant, guard: Guard) -> Expr:
    """Where the supervisor lets a controllable event happen."""
    return conjunction([guard.expr, possible(plant, guard.event)])


def steps_of(stepper: Stepper, states: Sequence[PlantState]) -> tuple[Step, ...]:
    """The events along a path of the plant under its requirements, the first that fit."""
    return tuple(_step_between(stepper, before, after) for before, after in pairwise(states))


def _step_between(stepper: Stepper, before: PlantState, after: PlantState) -> Step:
    plant = stepper.plant
    changed = {variable for variable, old in enumerate(before) if after[variable] != old}
    sampled = False
    # A command about which the environment decides may be refused though it could lead there.
    order = sorted(enumerate(plant.events), key=lambda item: _branches(item[1]))
    for number, event in order:
        if changed <= plant.writes[number]:
            compiled = stepper.compiled(number, event.requirement)
            values = compiled.leading(before, after)
            if values is not None:
                return make_step(plant, event, values, before, after)
            sampled = sampled or compiled.is_sampled
    assert sampled, "the states do not follow each other"
    raise StateSpaceError(
        "a message has too many parts that are compared to determine which of them lead to a state:"
        " compare fewer of them in one message, or convert them by an enum"
    )


def _branches(event: Event) -> bool:
    return event.controllable and bool(event.parameters)


def make_step(
    plant: Plant, event: Event, values: Values, before: PlantState, after: PlantState
) -> Step:
    """One step of a trace; a tau's value says from where to where."""
    if event.kind.of_component:
        values = tau_values(plant, event, before, after)
    return Step(event, values)


def tau_values(plant: Plant, event: Event, before: PlantState, after: PlantState) -> Values:
    """The value of a tau: ``("from->to",)``."""
    variable = event.automata[0].variable
    source, target = (_location(plant, variable, state[variable]) for state in (before, after))
    return (f"{source}->{target}",)
