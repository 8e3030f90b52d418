"""Queries on a controlled system, independent of the engine that computed it.

A query is a condition over the state, as an expression: where an event is possible in the plant
(:func:`possible`), where the requirements also hold (:func:`allowed`), where the supervisor enables
it (:func:`enabled`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator, Sequence
from itertools import pairwise
from typing import Protocol

from robosc.errors import StateSpaceError
from robosc.expr.tree import FALSE, TRUE, Binary, Expr, Literal, StateRef
from robosc.expr.types import BooleanType
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import (
    Edge,
    Event,
    LocalAutomaton,
    PhaseStep,
    Plant,
    PlantState,
    VariableKind,
)
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.step import Values
from robosc.runtime.core.places import place_of
from robosc.supervisor import Guard, Step
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.faults import FaultSearch
from robosc.synthesis.time_limit import ExplanationTime


@dataclass(frozen=True, slots=True)
class Runs:
    """Counterexamples to the properties of run to completion; None where a property holds.

    A counterexample is the chain of states in which run-to-completion steps start: the initial
    state, then the state after each further event. ``livelock``: the last step ends in a cycle.
    ``differing``: it may end in either of two states, depending on the order of the internal
    transitions. ``stuck``: from the state in which it ends no marked state at rest can be reached.
    ``missed``: what must remain possible cannot be reached from there; with the index of that in
    ``Plant.goals``. ``longest`` bounds the number of internal transitions of a step; None if there
    is no bound.
    """

    livelock: tuple[PlantState, ...] | None
    differing: tuple[tuple[PlantState, ...], PlantState, PlantState] | None
    stuck: tuple[PlantState, ...] | None
    longest: int | None
    missed: tuple[tuple[PlantState, ...], int] | None = None

    @property
    def fails(self) -> bool:
        return any((self.livelock, self.differing, self.stuck, self.missed))


def inputs(plant: Plant) -> list[tuple[int, ...]]:
    """Return the inputs and commands of a controller as groups of event numbers.

    One message that several communications receive is one group, in source order; any other event
    is a group of its own. Internal transitions are in none.
    """
    found: dict[Hashable, list[int]] = defaultdict(list)
    communications = plant.robot.communications
    for number, event in enumerate(plant.events):
        if event.kind is EventKind.TAU:
            continue
        is_message = event.kind is EventKind.RESPONSE and (
            communications[event.key].kind is Kind.OUTGOING
        )
        found[communications[event.key].ros_name if is_message else number].append(number)
    return [tuple(numbers) for numbers in found.values()]


class NumberedSteps(Protocol):
    """Some states under a supervisor, and the steps that lead from them, as numbers."""

    @property
    def states(self) -> Sequence[PlantState]: ...

    def number(self, state: PlantState) -> int:
        """Return the number of a state under the supervisor: its place among ``states``."""

    def after(self, number: int) -> Sequence[tuple[int, int]]:
        """Return the steps from a state: numbers of an event and of a state to which it leads.

        They are in the order of events."""


class System(Protocol):
    """A plant under its supervisor, as engines present it for explanations and warnings."""

    @property
    def plant(self) -> Plant: ...

    @property
    def time(self) -> ExplanationTime:
        """How long explanations of it may take."""

    @property
    def nodes(self) -> int:
        """The nodes of the decision diagrams that it holds."""

    @property
    def faults(self) -> FaultSearch:
        """Where the states are that are bad by themselves."""

    @property
    def steps(self) -> NumberedSteps:
        """The steps under control."""

    def nearest(self, condition: Expr) -> tuple[PlantState, ...] | None:
        """Return a short controlled path from an initial state to one with the condition.

        Both ends are included; None if the controlled system has no such state. Where looking for
        a path would take too long, or the time for explanations is over, it is that state alone,
        which is no initial state then.
        """

    def reaches(self, condition: Expr) -> bool:
        """Whether the controlled system has a state with the condition."""

    def plant_reaches(self, condition: Expr) -> bool | None:
        """Whether the plant without its requirements reaches a state with the condition.

        None: deciding it would take too long.
        """

    def is_good(self, state: PlantState) -> bool:
        """Whether a state is in the supremal safe, controllable and nonblocking set.

        Defined only for states that the plant under its requirements can reach.
        """

    def lost_start(self) -> PlantState:
        """Return an initial state that is not good; call it only if there is one."""

    def longest_completion(self) -> int | None:
        """Return the length of the longest sequence of internal transitions, in any order.

        None: it is unbounded, or computing it would take too long.
        """

    def runs(self, exactly: bool) -> Runs | None:
        """Return what fails of the controller's run to completion.

        ``exactly``: the longest step is the longest that is reached. None: computing it would take
        too long.
        """


def in_phase(plant: Plant, step: PhaseStep) -> Expr:
    """Return the condition that the communication is in a phase in which the event is possible."""
    variable = plant.variables[step.variable]
    if len(step.sources) == variable.size:
        return TRUE
    return disjunction(map(variable.phase, step.sources))


def possible(plant: Plant, event: Event) -> Expr:
    """Return the condition under which a controllable event is possible in the plant."""
    parts: list[Expr] = []
    if event.phase is not None:
        parts.append(in_phase(plant, event.phase))
    for automaton in event.automata:
        taken = [(edge, taken_where(plant, automaton, edge)) for edge in automaton.edges]
        cases = [conjunction([*where, *stays_in_range(plant, edge)]) for edge, where in taken]
        if not automaton.blocking:
            cases.append(conjunction(negation(conjunction(where)) for _, where in taken))
        parts.append(disjunction(cases))
    return conjunction(parts)


def taken_where(plant: Plant, automaton: LocalAutomaton, edge: Edge) -> list[Expr]:
    """Return the conditions under which an edge is taken: its location, no earlier edge, guard."""
    variable = plant.variables[automaton.variable]
    match variable.kind:
        case VariableKind.LOCATION:
            here: Expr = StateRef(automaton.component, str(variable.values[edge.source]))
        case VariableKind.PHASE:
            here = variable.phase(edge.source)
        case _:
            here = TRUE
    found = [here]
    for other in automaton.edges:
        if other is edge:
            break
        if other.source == edge.source:
            found.append(FALSE if other.guard is None else negation(other.guard))
    return found if edge.guard is None else [*found, edge.guard]


def location_name(plant: Plant, variable: int, place: int) -> str:
    """Return the state of a location, given by the index of a value of its state variable."""
    return place_of(str(plant.variables[variable].values[place]))


def stays_in_range(plant: Plant, edge: Edge) -> Iterator[Binary]:
    """Yield the conditions under which the edge's updates stay in their ranges."""
    for variable, expr in edge.updates:
        values = plant.variables[variable].values
        if isinstance(values, range):
            for operator, bound in (("<=", values[-1]), (">=", values[0])):
                yield Binary(operator, expr, Literal(bound, expr.type), BooleanType())


def allowed(plant: Plant, event: Event) -> Expr:
    """Return the condition under which an event is possible and the requirements allow it."""
    return conjunction([event.requirement or TRUE, possible(plant, event)])


def enabled(plant: Plant, guard: Guard) -> Expr:
    """Return the condition under which the supervisor enables a controllable event."""
    return conjunction([guard.expr, possible(plant, guard.event)])


def steps_of(stepper: Stepper, states: Sequence[PlantState]) -> tuple[Step, ...]:
    """Return the events along a path of the plant under its requirements, the first that fit.

    Raises:
        StateSpaceError: an event has too many values to find the one that leads on.
    """
    return tuple(_step_between(stepper, before, after) for before, after in pairwise(states))


def _step_between(stepper: Stepper, before: PlantState, after: PlantState) -> Step:
    step = found_step(stepper, before, after)
    assert step is not None, "the states do not follow each other"
    return step


def found_step(stepper: Stepper, before: PlantState, after: PlantState) -> Step | None:
    """Return the first event of the plant under its requirements that leads from one state to
    another; None if there is none.

    Raises:
        StateSpaceError: an event has too many values to find out.
    """
    plant = stepper.plant
    changed = {variable for variable, old in enumerate(before) if after[variable] != old}
    sampled = False
    for number in stepper.writing[min(changed)] if changed else stepper.order:
        event = plant.events[number]
        if changed <= event.writes:
            compiled = stepper.compiled(number, event.requirement)
            values = compiled.leading(before, after)
            if values is not None:
                return make_step(plant, event, values, before, after)
            sampled = sampled or compiled.is_sampled
    if not sampled:
        return None
    raise StateSpaceError(
        "too many parts of a message are compared to find the values that lead to a state:"
        " compare fewer of them in one message, or convert them by an enum"
    )


def make_step(
    plant: Plant, event: Event, values: Values, before: PlantState, after: PlantState
) -> Step:
    """Return one step of a trace; a tau's value is its source and target location."""
    if event.kind.of_component:
        values = tau_values(plant, event, before, after)
    return Step(event, values)


def tau_values(plant: Plant, event: Event, before: PlantState, after: PlantState) -> Values:
    """Return the value of a tau in a trace: ``("from->to",)``."""
    variable = event.automata[0].variable
    source, target = (location_name(plant, variable, state[variable]) for state in (before, after))
    return (f"{source}->{target}",)
