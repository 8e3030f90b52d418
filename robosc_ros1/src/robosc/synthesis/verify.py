"""A second opinion on a supervisor: its guards, taken as data, held against the plant.

The engines compute with arrays or decision diagrams over the whole product space; this module walks
the states one by one, in plain Python, and shares no code with them. It shows that the guards of a
:class:`~robosc.supervisor.Supervisor` keep the controlled system

- *safe*: no requirement violated, no state requirement failing, no range left;
- *controllable*: nothing that the plant does by itself is forbidden, or leads out of what was shown
  to be safe;
- *nonblocking*: from each reachable state a marked one is reachable;
- *maximally permissive*: each step that a guard forbids and a requirement allows leads to a state
  that no supervisor could keep (it can be forced into an unsafe or a blocking one);
- and that the *counts* of the supervisor are those of the search.

The supremal controllable and nonblocking behaviour is that of Ramadge & Wonham, "Supervisory
control of a class of discrete event processes", SIAM J. Control Optim. 25(1), 1987.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Final, TypeAlias

from robosc.errors import StateSpaceError
from robosc.ir.automaton import AxisKind, Edge, Event, Participant, Plant, PlantState
from robosc.ir.expr import Leaf, Undefined, evaluate
from robosc.model.entities import EventKind
from robosc.model.expr import Expr, PhaseRef, StateRef, ValueRef, VariableRef, walk
from robosc.model.types import Value
from robosc.supervisor import Step, Supervisor

__all__ = ["DEFAULT_LIMIT", "Check", "VerifyReport", "verify", "verify_document"]

DEFAULT_LIMIT: Final = 1_000_000


@dataclass(frozen=True, slots=True)
class Check:
    """One property: ``detail`` says in a sentence what fails, ``trace`` leads there."""

    name: str
    holds: bool
    detail: str | None = None
    trace: tuple[Step, ...] = ()


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """What was found; ``states`` and ``transitions`` are those under the guards."""

    robot: str
    checks: tuple[Check, ...]
    states: int
    transitions: int

    @property
    def verified(self) -> bool:
        return all(check.holds for check in self.checks)


def verify(supervisor: Supervisor, limit: int = DEFAULT_LIMIT) -> VerifyReport:
    """Prove a supervisor's properties by exhaustive search, or find where they fail.

    Raises:
        StateSpaceError: more than ``limit`` states would have to be visited.
    """
    return _Verifier(supervisor, limit).report()


def verify_document(report: VerifyReport, event: Callable[[Step], object]) -> dict[str, object]:
    """``verify --json``, version 1; ``event`` writes one step as ``explore --json`` does."""
    return {
        "version": 1,
        "robot": report.robot,
        "verified": report.verified,
        "states": report.states,
        "transitions": report.transitions,
        "checks": [
            {
                "name": check.name,
                "holds": check.holds,
                "detail": check.detail,
                "trace": [event(step) for step in check.trace],
            }
            for check in report.checks
        ],
    }


# --- the plant, one state at a time --------------------------------------------------------------

_ESCAPES: Final = -1  # in place of a target: an assignment leaves its range

_Values: TypeAlias = tuple[Value | None, ...]
_Moves: TypeAlias = tuple[tuple[int, PlantState | None], ...]


class _Condition:
    """A condition over the state, evaluated once per combination of what it reads."""

    def __init__(self, plant: Plant, expr: Expr) -> None:
        self._plant = plant
        self._expr = expr
        self._axes = sorted(_axes_of(plant, expr))
        self._known: dict[PlantState, bool] = {}

    def __call__(self, state: PlantState) -> bool:
        key = tuple([state[axis] for axis in self._axes])
        found = self._known.get(key)
        if found is None:
            found = _holds(self._plant, self._expr, state, {})
            self._known[key] = found
        return found


class _EventMoves:
    """What one event does: for each value it may carry, the new values of the axes it touches.

    Computed once per combination of the axes that the event reads or writes.
    """

    def __init__(self, plant: Plant, event: Event) -> None:
        self.event = event
        self.valuations: list[_Values] = list(product(*(p.values for p in event.parameters)))
        self._plant = plant
        self._axes = sorted(_touched(plant, event))
        self._known: dict[PlantState, _Moves] = {}

    def __call__(self, state: PlantState) -> Iterator[tuple[int, PlantState | None]]:
        """Number of the valuation and the state after it; None where a range would be left."""
        key = tuple([state[axis] for axis in self._axes])
        moves = self._known.get(key)
        if moves is None:
            moves = self._known[key] = tuple(self._local(state))
        for number, changed in moves:
            if changed is None:
                yield number, None
            else:
                after = list(state)
                for axis, value in zip(self._axes, changed, strict=True):
                    after[axis] = value
                yield number, tuple(after)

    def _local(self, state: PlantState) -> Iterator[tuple[int, PlantState | None]]:
        for number, values in enumerate(self.valuations):
            after = self._after(state, values)
            if after == "impossible":
                continue
            if after == "escapes":
                yield number, None
            else:
                yield number, tuple([after[axis] for axis in self._axes])  # type: ignore[misc]

    def _after(self, state: PlantState, values: _Values) -> list[int] | str:
        after = list(state)
        phase = self.event.phase
        if phase is not None:
            if state[phase.axis] != phase.source:
                return "impossible"
            after[phase.axis] = phase.target
        parameters = dict(zip((p.path for p in self.event.parameters), values, strict=True))
        escapes = False
        for participant in self.event.participants:
            edge = self._edge(participant, state, parameters)
            if edge is None:
                if participant.blocking:
                    return "impossible"
                continue
            after[participant.axis] = edge.target
            escapes |= not self._assign(edge, state, parameters, after)
        return "escapes" if escapes else after

    def _edge(
        self, participant: Participant, state: PlantState, parameters: _Parameters
    ) -> Edge | None:
        for edge in participant.edges:
            if edge.source == state[participant.axis] and (
                edge.guard is None or _holds(self._plant, edge.guard, state, parameters)
            ):
                return edge
        return None

    def _assign(
        self, edge: Edge, state: PlantState, parameters: _Parameters, after: list[int]
    ) -> bool:
        """Whether all assignments stay in their ranges; an undefined one changes nothing."""
        for axis, expr in edge.updates:
            try:
                value = evaluate(expr, _lookup(self._plant, state, parameters))
            except Undefined:
                continue
            values = self._plant.axes[axis].values
            if value not in values:
                return False
            after[axis] = values.index(value)
        return True


_Parameters: TypeAlias = dict[tuple[str | int, ...], Value | None]


def _lookup(
    plant: Plant, state: PlantState, parameters: _Parameters
) -> Callable[[Leaf], Value | None]:
    def look(leaf: Leaf) -> Value | None:
        if isinstance(leaf, ValueRef):
            return parameters[leaf.path]
        axis = _axis_of(plant, leaf)
        value = plant.axes[axis].values[state[axis]]
        if isinstance(leaf, StateRef):
            return value == leaf.state
        return value == "busy" if isinstance(leaf, PhaseRef) else value

    return look


def _axis_of(plant: Plant, leaf: VariableRef | StateRef | PhaseRef) -> int:
    match leaf:
        case VariableRef(component=component, variable=variable):
            return plant.axis_index[AxisKind.VARIABLE, f"{component}.{variable}"]
        case StateRef(component=component):
            return plant.axis_index[AxisKind.LOCATION, component]
    return plant.axis_index[AxisKind.PHASE, leaf.communication]


def _axes_of(plant: Plant, expr: Expr) -> set[int]:
    return {
        _axis_of(plant, part)
        for part in walk(expr)
        if isinstance(part, VariableRef | StateRef | PhaseRef)
    }


def _touched(plant: Plant, event: Event) -> set[int]:
    axes = set() if event.phase is None else {event.phase.axis}
    for participant in event.participants:
        axes.add(participant.axis)
        for edge in participant.edges:
            if edge.guard is not None:
                axes |= _axes_of(plant, edge.guard)
            for axis, expr in edge.updates:
                axes |= {axis} | _axes_of(plant, expr)
    return axes


def _holds(plant: Plant, expr: Expr, state: PlantState, parameters: _Parameters) -> bool:
    """Whether a condition holds; one that reads an element that did not come does not."""
    try:
        return bool(evaluate(expr, _lookup(plant, state, parameters)))
    except Undefined:
        return False


# --- graphs --------------------------------------------------------------------------------------


@dataclass
class _Graph:
    """States found from the initial one, numbered in the order of discovery, with all their steps.

    Step ``i`` leads from ``sources[i]`` to ``targets[i]`` (or is ``_ESCAPES``) by event
    ``events[i]`` with valuation ``values[i]``. ``parents`` is the step that found each state.
    """

    states: list[PlantState]
    number: dict[PlantState, int]
    sources: array[int] = field(default_factory=lambda: array("l"))
    targets: array[int] = field(default_factory=lambda: array("l"))
    events: array[int] = field(default_factory=lambda: array("l"))
    values: array[int] = field(default_factory=lambda: array("l"))
    parents: array[int] = field(default_factory=lambda: array("l", [-1]))

    def add(self, source: int, target: PlantState | None, event: int, values: int) -> None:
        if target is None:
            number = _ESCAPES
        else:
            number = self.number.setdefault(target, len(self.states))
            if number == len(self.states):
                self.states.append(target)
                self.parents.append(len(self.sources))
        self.sources.append(source)
        self.targets.append(number)
        self.events.append(event)
        self.values.append(values)

    def predecessors(self) -> Callable[[int], Sequence[int]]:
        """A function that gives the steps into a state."""
        starts = array("l", bytes(array("l").itemsize * (len(self.states) + 2)))
        for target in self.targets:
            if target != _ESCAPES:
                starts[target + 2] += 1
        for state in range(2, len(starts)):
            starts[state] += starts[state - 1]
        steps = array("l", bytes(array("l").itemsize * starts[-1]))
        for step, target in enumerate(self.targets):
            if target != _ESCAPES:
                steps[starts[target + 1]] = step
                starts[target + 1] += 1
        return lambda state: steps[starts[state] : starts[state + 1]]


_Allow: TypeAlias = Callable[[int, PlantState], bool]


class _Verifier:
    """One run: conditions and moves are remembered from search to search."""

    def __init__(self, supervisor: Supervisor, limit: int) -> None:
        plant = supervisor.plant
        self._supervisor = supervisor
        self._plant = plant
        self._limit = limit
        self._moves = [_EventMoves(plant, event) for event in plant.events]
        self._required = [
            None if event.requirement is None else _Condition(plant, event.requirement)
            for event in plant.events
        ]
        self._invariants = [(_Condition(plant, expr), index) for expr, index in plant.invariants]
        guards = {_identity(guard.event): guard.expr for guard in supervisor.guards}
        self._guards = [
            _Condition(plant, guards[_identity(event)]) if _identity(event) in guards else None
            for event in plant.events
        ]

    def report(self) -> VerifyReport:
        controllable = self._check_controllable()
        permitted = self._explore(self._is_permitted, self._is_unsafe)
        keepable = self._keepable(permitted)
        if self._supervisor.empty:
            checks = [controllable, self._check_empty(keepable[0] == 1), *self._check_counts(0, 0)]
            return VerifyReport(self._plant.robot.name, tuple(checks), 0, 0)
        controlled = self._explore(self._is_enabled)
        checks = [
            self._check_safe(controlled),
            controllable,
            self._check_nonblocking(controlled),
            self._check_permissive(controlled, permitted, keepable),
            *self._check_counts(len(controlled.states), len(controlled.sources)),
        ]
        name = self._plant.robot.name
        return VerifyReport(name, tuple(checks), len(controlled.states), len(controlled.sources))

    # --- what may happen -------------------------------------------------------------------------

    def _is_permitted(self, event: int, state: PlantState) -> bool:
        required = self._required[event]
        return required is None or required(state)

    def _is_enabled(self, event: int, state: PlantState) -> bool:
        guard = self._guards[event]
        return not self._plant.events[event].controllable or (guard is not None and guard(state))

    def _failing(self, state: PlantState) -> str | None:
        """Why a state is unsafe in itself, None if it is not."""
        for holds, index in self._invariants:
            if not holds(state):
                return f"'{self._plant.robot.requirements[index].text}' fails"
        for moves in self._moves:
            if not moves.event.controllable and any(after is None for _, after in moves(state)):
                return f"the {_text(moves.event)} may take a variable out of its range"
        return None

    def _is_unsafe(self, state: PlantState) -> bool:
        return self._failing(state) is not None

    def _explore(
        self, allow: _Allow, final: Callable[[PlantState], bool] = lambda state: False
    ) -> _Graph:
        """All that can be reached by allowed events; ``final`` states are not left."""
        initial = self._plant.initial
        graph = _Graph([initial], {initial: 0})
        here = 0
        while here < len(graph.states):
            if len(graph.states) > self._limit:
                raise StateSpaceError(f"verification stops at {self._limit} states; there are more")
            state = graph.states[here]
            if not final(state):
                for event, moves in enumerate(self._moves):
                    if allow(event, state):
                        for values, after in moves(state):
                            if after is not None or not moves.event.controllable:
                                graph.add(here, after, event, values)
            here += 1
        return graph

    def _keepable(self, permitted: _Graph) -> bytearray:
        """Which states some supervisor can keep safe and nonblocking: 1, the others 0.

        Starting from the unsafe states, lose in turn what uncontrollable events lead to lost ones,
        and what cannot reach a marked state through kept ones, until nothing more is lost.
        """
        into = permitted.predecessors()
        uncontrollable = [not event.controllable for event in self._plant.events]
        kept = bytearray(b"\1" * len(permitted.states))
        fresh = [n for n, state in enumerate(permitted.states) if self._is_unsafe(state)]
        while True:
            for state in fresh:
                kept[state] = 0
            while fresh:
                for step in into(fresh.pop()):
                    source = permitted.sources[step]
                    if kept[source] and uncontrollable[permitted.events[step]]:
                        kept[source] = 0
                        fresh.append(source)
            fresh = self._blocked(permitted, into, kept)
            if not fresh:
                return kept

    def _blocked(
        self, graph: _Graph, into: Callable[[int], Sequence[int]], kept: bytearray
    ) -> list[int]:
        """Kept states from which no marked one can be reached through kept ones."""
        reaching = bytearray(len(kept))
        todo = []
        for number, state in enumerate(graph.states):
            if kept[number] and self._plant.is_marked(state):
                reaching[number] = 1
                todo.append(number)
        while todo:
            for step in into(todo.pop()):
                source = graph.sources[step]
                if kept[source] and not reaching[source]:
                    reaching[source] = 1
                    todo.append(source)
        return [n for n in range(len(kept)) if kept[n] and not reaching[n]]

    # --- the properties --------------------------------------------------------------------------

    def _check_controllable(self) -> Check:
        """One guard per controllable event and none on any other is all that it takes.

        What uncontrollable events do is followed in every search, so nothing can hide there.
        """
        for event, guard in zip(self._plant.events, self._guards, strict=True):
            if event.controllable and guard is None:
                return Check("controllable", False, f"the {_text(event)} has no guard")
            if not event.controllable and guard is not None:
                return Check("controllable", False, f"the {_text(event)} cannot be forbidden")
        return Check("controllable", True)

    def _check_safe(self, controlled: _Graph) -> Check:
        for number, state in enumerate(controlled.states):
            failing = self._failing(state)
            if failing is not None:
                return Check("safe", False, failing, self._trace(controlled, number))
        for step, index in enumerate(controlled.events):
            source = controlled.sources[step]
            if not self._is_permitted(index, controlled.states[source]):
                detail = f"the {_text(self._plant.events[index])} happens against a requirement"
                trace = (*self._trace(controlled, source), self._step(controlled, step))
                return Check("safe", False, detail, trace)
        return Check("safe", True)

    def _check_nonblocking(self, controlled: _Graph) -> Check:
        everything = bytearray(b"\1" * len(controlled.states))
        blocked = self._blocked(controlled, controlled.predecessors(), everything)
        if not blocked:
            return Check("nonblocking", True)
        detail = "no marked state can be reached any more"
        return Check("nonblocking", False, detail, self._trace(controlled, min(blocked)))

    def _check_permissive(
        self, controlled: _Graph, permitted: _Graph, keepable: bytearray
    ) -> Check:
        for number, state in enumerate(controlled.states):
            for event, moves in enumerate(self._moves):
                if self._is_enabled(event, state) or not self._is_permitted(event, state):
                    continue
                for values, after in moves(state):
                    target = None if after is None else permitted.number.get(after)
                    if after is not None and target is not None and keepable[target]:
                        detail = f"the {_text(moves.event)} is forbidden without need"
                        step = self._made(event, values, state, after)
                        trace = (*self._trace(controlled, number), step)
                        return Check("maximally permissive", False, detail, trace)
        return Check("maximally permissive", True)

    def _check_empty(self, keepable: bool) -> Check:
        if keepable:
            detail = "the supervisor is empty although the initial state can be kept"
            return Check("maximally permissive", False, detail)
        return Check("maximally permissive", True)

    def _check_counts(self, states: int, transitions: int) -> Iterable[Check]:
        told = self._supervisor
        figures = [
            ("controlled states", told.controlled_states, states),
            ("controlled transitions", told.controlled_transitions, transitions),
        ]
        if told.plant_states <= self._limit:
            plant = self._explore(lambda event, state: True)
            figures.append(("plant states", told.plant_states, len(plant.states)))
        for name, claimed, found in figures:
            detail = None if claimed == found else f"{claimed} were counted, there are {found}"
            yield Check(name, claimed == found, detail)

    # --- traces ----------------------------------------------------------------------------------

    def _trace(self, graph: _Graph, state: int) -> tuple[Step, ...]:
        """A shortest way from the initial state."""
        steps = []
        while graph.parents[state] >= 0:
            step = graph.parents[state]
            steps.append(self._step(graph, step))
            state = graph.sources[step]
        return tuple(reversed(steps))

    def _step(self, graph: _Graph, step: int) -> Step:
        target = graph.targets[step]
        source = graph.states[graph.sources[step]]
        after = source if target == _ESCAPES else graph.states[target]
        return self._made(graph.events[step], graph.values[step], source, after)

    def _made(self, index: int, values: int, source: PlantState, after: PlantState) -> Step:
        event = self._plant.events[index]
        if event.kind is EventKind.TAU:
            axis = self._plant.axis_index[AxisKind.LOCATION, event.key]
            names = self._plant.axes[axis].values
            return Step(event, (f"{names[source[axis]]}->{names[after[axis]]}",))
        return Step(event, self._moves[index].valuations[values])


def _identity(event: Event) -> tuple[EventKind, str, int]:
    return event.kind, event.key, event.index


def _text(event: Event) -> str:
    if event.kind is EventKind.TAU:
        return f"transition {event.index} of {event.name}"
    return f"{event.kind.value} of {event.name}"
