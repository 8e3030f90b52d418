"""A second reading of the semantics, slow and plain: what the engines are compared with.

It starts from the resolved model (``robosc.model``) and shares no code with ``robosc.ir`` or the
engines. A state is a tuple of plain values, one per *slot*: ``("at", component)``,
``("var", "Component.variable")``, ``("phase", communication)``, ``("parameter", name)``. Everything else is dictionaries,
sets and loops that say what the language's documents say, in their order.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from typing import Any

from robosc.model.entities import (
    Communication,
    Component,
    EventKind,
    Kind,
    ResultTransition,
    Robot,
    State,
    Variable,
)
from robosc.model.expr import (
    Aggregate,
    Binary,
    Call,
    Convert,
    ElementRef,
    Expr,
    Literal,
    ParameterRef,
    PhaseRef,
    StateRef,
    Unary,
    ValueRef,
    VariableRef,
)
from robosc.model.traversal import walk
from robosc.model.types import ArrayType, BooleanType, EnumType, IntegerType, ObjectType, Type

OracleState = tuple[Any, ...]
Path = tuple[str | int, ...]
Samples = Mapping[Type, Sequence[Any]]

KINDS = {
    Kind.OUTGOING: (EventKind.RESPONSE,),
    Kind.INCOMING: (EventKind.REQUEST,),
    Kind.SERVICE: (EventKind.REQUEST, EventKind.RESPONSE, EventKind.ERROR),
    Kind.ACTION: (
        EventKind.REQUEST,
        EventKind.RESPONSE,
        EventKind.FEEDBACK,
        EventKind.ERROR,
        EventKind.CANCEL,
    ),
}
CONTROLLABLE = (EventKind.REQUEST, EventKind.CANCEL, EventKind.TAU)


class UndefinedValue(Exception):
    """An array was shorter than an index that an expression uses."""


class OutOfRange(Exception):
    """An assignment leaves the range of its variable."""


class Impossible(Exception):
    """The plant cannot do the event in this state."""


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


@dataclass(frozen=True)
class Transition:
    source: OracleState
    occurrence: Occurrence
    target: OracleState


def evaluate(expr: Expr, read: Any) -> Any:
    """The value of an expression; ``read`` gives that of a reference, or raises UndefinedValue."""
    match expr:
        case Literal(value=value):
            return value
        case VariableRef() | StateRef() | PhaseRef() | ParameterRef() | ValueRef() | ElementRef():
            return read(expr)
        case Unary(operator="!", operand=operand):
            return not evaluate(operand, read)
        case Unary(operator="-", operand=operand):
            return -evaluate(operand, read)
        case Binary(operator="and", left=left, right=right):
            return evaluate(left, read) and evaluate(right, read)
        case Binary(operator="or", left=left, right=right):
            return evaluate(left, read) or evaluate(right, read)
        case Binary(operator="=>", left=left, right=right):
            return not evaluate(left, read) or evaluate(right, read)
        case Binary(operator=operator, left=left, right=right):
            return apply(operator, evaluate(left, read), evaluate(right, read))
        case Convert(argument=argument, type=enum):
            return convert(enum, evaluate(argument, read))
        case Call(operator="length", operands=(array,)):
            return len(evaluate(array, read))
        case Aggregate():
            return aggregate(expr, read)
    raise TypeError(expr)


def aggregate(expr: Aggregate, read: Any) -> Any:
    """What goes through an array: of elements for which something is undefined, nothing counts."""
    found = []
    for item in evaluate(expr.array, read):
        inside = partial(_element, expr.variable, item, read)
        with suppress(UndefinedValue):
            if expr.condition is None or evaluate(expr.condition, inside):
                found.append(evaluate(expr.element, inside))
    match expr.operator:
        case "any":
            return any(found)
        case "all":
            return all(found)
        case "count":
            return sum(1 for result in found if result)
        case "sum":
            return sum(found)
    if not found:
        raise UndefinedValue
    if any(number != number for number in found):
        return math.nan
    return min(found) if expr.operator == "min" else max(found)


def _element(variable: str, item: Any, read: Any, part: Expr) -> Any:
    """A reference inside of an aggregate over plain numbers."""
    if isinstance(part, ElementRef) and part.variable == variable:
        assert part.path == ()
        return item
    return read(part)


def convert(enum: EnumType, value: Any) -> str:
    """The value of the first rule that holds, or the default."""
    for rule in enum.rules:
        with suppress(UndefinedValue):
            if evaluate(rule.condition, lambda part: value):
                return rule.value
    return enum.default


def apply(operator: str, left: Any, right: Any) -> Any:
    match operator:
        case "=":
            return left == right
        case "!=":
            return left != right
        case "<":
            return left < right
        case "<=":
            return left <= right
        case ">":
            return left > right
        case ">=":
            return left >= right
        case "+":
            return left + right
        case "-":
            return left - right
        case "*":
            return left * right
        case "/":
            return divide(float(left), float(right))
        case "%":
            return remainder(left, right)
    raise ValueError(operator)


def remainder(left: Any, right: Any) -> Any:
    """What is left of a division downwards; an integer is not divided by 0."""
    if right == 0:
        return left if isinstance(left, int) and isinstance(right, int) else math.nan
    return left - right * (left // right) if isinstance(left, int) else left % right


def divide(left: float, right: float) -> float:
    """IEEE 754 division."""
    if right != 0:
        return left / right
    if left == 0 or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)


def values_of(type_: Type, path: Path, samples: Samples) -> list[Any]:
    """All values at a path of an incoming value; None last where an array may be too short.

    Of a type that is not finite, those of ``samples``.
    """
    through_array = False
    for step in path:
        match type_:
            case ObjectType():
                assert isinstance(step, str)
                found = type_.property(step)
                assert found is not None
                type_ = found
            case ArrayType(element=element):
                through_array = True
                type_ = element
            case _:
                raise TypeError(f"{step} of {type_}")
    match type_:
        case BooleanType():
            values: list[Any] = [False, True]
        case IntegerType(bounds=(low, high)):
            values = list(range(low, high + 1))
        case EnumType(values=names):
            values = list(names)
        case _:
            values = list(samples[type_])
    return [*values, None] if through_array else values


def _is_for(transition: ResultTransition, event: Event) -> bool:
    return transition.event is event.kind and transition.communication == event.key


def first_phase(communication: Communication) -> str | None:
    """The phase in which a communication begins; None: it has no phases."""
    if communication.kind in (Kind.SERVICE, Kind.ACTION):
        return "idle"
    if communication.kind is Kind.OUTGOING and communication.timeout is not None:
        return "silent"
    return None


class Oracle:
    """The plant of a robot, and its supervisor, by exhaustive search."""

    def __init__(self, robot: Robot, samples: Samples | None = None) -> None:
        """``samples`` are the numbers and strings that stand for all, by type."""
        self.robot = robot
        self.samples: Samples = samples or {}
        self.automata: list[Component] = [c for c in robot.components if c.behaviour is not None]
        self.synthesis_variables = self._synthesis_variables()
        self.slots: list[tuple[str, str]] = []
        for component in robot.components:
            if component.behaviour is not None:
                self.slots.append(("at", component.name))
                for variable in component.behaviour.variables:
                    if variable.key in self.synthesis_variables:
                        self.slots.append(("var", variable.key))
            for communication in component.communications:
                if first_phase(communication) is not None:
                    self.slots.append(("phase", communication.key))
        self._found: dict[OracleState, list[tuple[Occurrence, OracleState]]] = {}
        self.slots += [("parameter", parameter.key) for parameter in robot.parameters]
        self.where = {slot: i for i, slot in enumerate(self.slots)}

    # --- what takes part ---------------------------------------------------------------------

    @cached_property
    def variables(self) -> dict[str, Variable]:
        return {v.key: v for c in self.automata for v in c.behaviour.variables}  # type: ignore[union-attr]

    @cached_property
    def all_transitions(self) -> list[tuple[str, ResultTransition]]:
        """Every result transition with its component, as written."""
        found = []
        for component in self.automata:
            behaviour = component.behaviour
            assert behaviour is not None
            written = list(behaviour.transitions)
            for state in behaviour.states:
                written.extend(state.transitions)
                written.extend(waiting.transition for waiting in state.afters)
            found.extend((component.name, transition) for transition in written)
        return found

    def _synthesis_variables(self) -> set[str]:
        """Read by a guard, a requirement or a provide condition, or on the way to such a one."""
        robot = self.robot
        conditions: list[Expr] = [r.condition for r in robot.requirements]
        conditions += [p.condition for p in robot.provides if p.condition is not None]
        conditions += [t.guard for _, t in self.all_transitions if t.guard is not None]
        for component in self.automata:
            behaviour = component.behaviour
            assert behaviour is not None
            taus = list(behaviour.taus)
            for state in behaviour.states:
                taus.extend(state.taus)
            conditions += [tau.guard for tau in taus if tau.guard is not None]
        found = {read for condition in conditions for read in _variables_in(condition)}
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
                events += [Event(kind, communication.key) for kind in KINDS[communication.kind]]
                if first_phase(communication) == "silent":
                    events.append(Event(EventKind.TIMEOUT, communication.key))
            if component.behaviour is not None:
                taus = list(component.behaviour.taus)
                for state in component.behaviour.states:
                    taus.extend(state.taus)
                for tau in sorted(taus, key=lambda tau: tau.index):
                    events.append(Event(EventKind.TAU, component.name, tau.index))
                waiting = [a for state in component.behaviour.states for a in state.afters]
                for after in sorted(waiting, key=lambda after: after.index):
                    events.append(Event(EventKind.AFTER, component.name, after.index))
        return events

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
        if not paths:
            return [Occurrence(event)]
        type_ = self.robot.communications[event.key].value_type(event.kind)
        choices = [
            [(path, value) for value in values_of(type_, path, self.samples)] for path in paths
        ]
        nothing = [Occurrence(event, tuple((path, None) for path in paths))]
        found = [Occurrence(event, values) for values in product(*choices) if _possible(values)]
        return found + (nothing if event.kind is EventKind.ERROR else [])

    def _effective(
        self, component: Component, event: Event
    ) -> list[tuple[ResultTransition, set[str]]]:
        """What of the transitions counts in at least one state, in the order of the states.

        With each, the variables on which one of the state decides.
        """
        assert component.behaviour is not None
        found: list[tuple[ResultTransition, set[str]]] = []
        for state in component.behaviour.states:
            own = [t for t in state.transitions if _is_for(t, event)]
            common = [t for t in component.behaviour.transitions if _is_for(t, event)]
            found += [(t, set()) for t in own]
            if not own or (
                event.kind is not EventKind.REQUEST and all(t.guard is not None for t in own)
            ):
                found += [(t, set()) for t in common]
            elif event.kind is not EventKind.REQUEST:
                # One of the state is taken for sure, and only what goes nowhere goes with it.
                for first in own:
                    decided = {a.variable for a in first.assignments}
                    found += [(t, decided) for t in common if t.goto is None]
        return found

    def _taken(
        self, component: Component, present: State, state: OracleState, occurrence: Occurrence
    ) -> list[ResultTransition]:
        """The transitions that a component takes, the one that decides on a variable last."""

        def holding(transitions: tuple[ResultTransition, ...]) -> list[ResultTransition]:
            return [
                t
                for t in transitions
                if _is_for(t, occurrence.event)
                and (t.guard is None or self.holds(t.guard, state, occurrence))
            ]

        assert component.behaviour is not None
        own, common = holding(present.transitions), holding(component.behaviour.transitions)
        if occurrence.event.kind is EventKind.REQUEST:
            mentioned = any(_is_for(t, occurrence.event) for t in present.transitions)
            return own if mentioned else common
        return [*(t for t in common if t.goto is None), *own] if own else common

    # --- the plant ---------------------------------------------------------------------------

    @cached_property
    def initials(self) -> list[OracleState]:
        """One for each combination of values of the parameters, which never change."""
        types = {parameter.key: parameter.type for parameter in self.robot.parameters}
        values: list[list[Any]] = []
        for what, name in self.slots:
            if what == "at":
                behaviour = self.robot.component(name).behaviour
                assert behaviour is not None
                values.append([next(s.name for s in behaviour.states if s.initial)])
            elif what == "var":
                values.append([self.variables[name].initial])
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
                case StateRef(component=component, state=name):
                    return self.get(state, "at", component) == name
                case PhaseRef(communication=key):
                    return self.get(state, "phase", key) in ("busy", "fresh")
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

    def step(self, state: OracleState, occurrence: Occurrence) -> OracleState:
        """The state after an occurrence; raises Impossible or OutOfRange."""
        after = dict(zip(self.slots, state, strict=True))
        event = occurrence.event
        if event.kind is EventKind.TAU:
            self._step_tau(state, event, after)
        elif event.kind is EventKind.AFTER:
            self._step_after(state, occurrence, after)
        else:
            self._step_phase(state, event, after)
            for component in self.automata:
                self._step_component(component, state, occurrence, after)
        return tuple(after[slot] for slot in self.slots)

    def _step_tau(self, state: OracleState, event: Event, after: dict[Any, Any]) -> None:
        behaviour = self.robot.component(event.key).behaviour
        assert behaviour is not None
        here = self.get(state, "at", event.key)
        present = next(s for s in behaviour.states if s.name == here)
        for tau in (*behaviour.taus, *present.taus):
            if tau.index == event.index and (tau.guard is None or self.holds(tau.guard, state)):
                if tau.goto is not None:
                    after["at", event.key] = tau.goto
                return
        raise Impossible

    def _step_after(
        self, state: OracleState, occurrence: Occurrence, after: dict[Any, Any]
    ) -> None:
        """Time passes whenever it is waited for: the component must be there, the guard hold."""
        component = self.robot.component(occurrence.event.key)
        assert component.behaviour is not None
        here = self.get(state, "at", component.name)
        present = next(s for s in component.behaviour.states if s.name == here)
        for waiting in present.afters:
            transition = waiting.transition
            if waiting.index != occurrence.event.index:
                continue
            if transition.guard is None or self.holds(transition.guard, state):
                self._assign(component, [transition], state, occurrence, after)
                return
        raise Impossible

    def _step_phase(self, state: OracleState, event: Event, after: dict[Any, Any]) -> None:
        first = first_phase(self.robot.communications[event.key])
        if first is None:
            return
        phase = self.get(state, "phase", event.key)
        if first == "silent":
            if event.kind is EventKind.TIMEOUT and phase == "silent":
                raise Impossible
            after["phase", event.key] = "fresh" if event.kind is EventKind.RESPONSE else "silent"
            return
        if phase != ("idle" if event.kind is EventKind.REQUEST else "busy"):
            raise Impossible
        busy = event.kind in (EventKind.REQUEST, EventKind.FEEDBACK)
        after["phase", event.key] = "busy" if busy else "idle"

    def _step_component(
        self,
        component: Component,
        state: OracleState,
        occurrence: Occurrence,
        after: dict[Any, Any],
    ) -> None:
        behaviour = component.behaviour
        assert behaviour is not None
        event = occurrence.event
        here = self.get(state, "at", component.name)
        present = next(s for s in behaviour.states if s.name == here)
        taken = self._taken(component, present, state, occurrence)
        if not taken:
            mentions = any(
                name == component.name
                and transition.event is EventKind.REQUEST
                and transition.communication == event.key
                for name, transition in self.all_transitions
            )
            if event.kind is EventKind.REQUEST and mentions:
                raise Impossible
            return
        assert len(taken) <= 2  # guards on one level exclude each other
        self._assign(component, taken, state, occurrence, after)

    def _assign(
        self,
        component: Component,
        taken: list[ResultTransition],
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
            if what == "phase" and value == "busy":
                return False
            if what == "at":
                behaviour = self.robot.component(name).behaviour
                assert behaviour is not None
                if not next(s for s in behaviour.states if s.name == value).marked:
                    return False
        return True

    @cached_property
    def plant(self) -> tuple[list[OracleState], list[Transition]]:
        """Everything that can be reached without any requirement."""
        return self._explore(lambda state, event: True)

    def _explore(self, allowed: Any) -> tuple[list[OracleState], list[Transition]]:
        states = dict.fromkeys(self.initials)
        transitions = []
        queue = deque(self.initials)
        while queue:
            state = queue.popleft()
            for occurrence, target in self.successors(state):
                if not allowed(state, occurrence.event):
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
            with suppress(Impossible, OutOfRange):
                found.append((occurrence, self.step(state, occurrence)))
        return found

    # --- requirements and supervisor ---------------------------------------------------------

    def required(self, state: OracleState, event: Event) -> bool:
        """What the requirements on communications say about an event in a state."""
        if event.kind not in (EventKind.REQUEST, EventKind.CANCEL):
            return True
        kept = []
        for requirement in self.robot.requirements:
            if event.key in requirement.communications:
                condition = self.holds(requirement.condition, state)
                kept.append(condition if requirement.kind == "needs" else not condition)
        return all(kept) if event.kind is EventKind.REQUEST else not all(kept)

    def unsafe(self, state: OracleState) -> bool:
        """A state requirement fails, or an uncontrollable event would leave a range."""
        for requirement in self.robot.requirements:
            if requirement.kind == "never" and self.holds(requirement.condition, state):
                return True
            if requirement.kind == "always" and not self.holds(requirement.condition, state):
                return True
        for occurrence in self._all_occurrences:
            if occurrence.event.controllable:
                continue
            try:
                self.step(state, occurrence)
            except OutOfRange:
                return True
            except Impossible:
                pass
        return False

    @cached_property
    def kept(self) -> set[OracleState]:
        """The greatest set of states that is safe, controllable and nonblocking in itself.

        The largest set X of plant states without unsafe ones such that uncontrollable events stay
        in X and each state of X reaches a marked one of X, through X, by allowed events.
        """
        states, transitions = self.plant
        allowed = [t for t in transitions if self.required(t.source, t.occurrence.event)]
        keep = {state for state in states if not self.unsafe(state)}
        while True:
            smaller = set(keep)
            for t in transitions:
                if not t.occurrence.event.controllable and t.target not in keep:
                    smaller.discard(t.source)
            reaching = {state for state in keep if self.marked(state)}
            while True:
                more = {
                    t.source
                    for t in allowed
                    if t.source in keep and t.target in reaching and t.source not in reaching
                }
                if not more:
                    break
                reaching |= more
            smaller &= reaching
            if smaller == keep:
                return keep
            keep = smaller

    @property
    def empty(self) -> bool:
        return not self.kept.issuperset(self.initials)

    @cached_property
    def controlled(self) -> tuple[list[OracleState], list[Transition]]:
        """What can be reached under the supervisor; nothing at all if it is empty."""
        if self.empty:
            return [], []
        states = dict.fromkeys(self.initials)
        transitions = []
        queue = deque(self.initials)
        while queue:
            state = queue.popleft()
            for occurrence, target in self.successors(state):
                if occurrence.event.controllable and not (
                    self.required(state, occurrence.event) and target in self.kept
                ):
                    continue
                transitions.append(Transition(state, occurrence, target))
                if target not in states:
                    states[target] = None
                    queue.append(target)
        return list(states), transitions

    def possible(self, state: OracleState) -> set[Event]:
        """Controllable events that the plant can do."""
        return {o.event for o, _ in self.successors(state) if o.event.controllable}

    def enabled(self, state: OracleState) -> set[Event]:
        """Controllable events that the supervisor allows."""
        return {
            occurrence.event
            for occurrence, target in self.successors(state)
            if occurrence.event.controllable
            and self.required(state, occurrence.event)
            and target in self.kept
        }

    def status(self, event: Event) -> str:
        """How the supervisor's guard of an event compares with its requirements."""
        states, _ = self.controlled
        if not any(event in self.enabled(state) for state in states):
            return "never"
        for state in states:
            asked_for = event in self.possible(state) and self.required(state, event)
            if asked_for and event not in self.enabled(state):
                return "restricted"
        return "as required"

    # --- execution ---------------------------------------------------------------------------

    def after(self, state: OracleState, events: list[Event]) -> list[OracleState]:
        """Where enabled events lead to: each uncontrollable one with each of its values."""
        return [
            target
            for occurrence, target in self.successors(state)
            if occurrence.event in events
            and (not occurrence.event.controllable or occurrence.event in self.enabled(state))
        ]

    def moves(self, state: OracleState, taus: list[Event]) -> list[OracleState]:
        """Where internal transitions lead to; the controller does not take one that changes nothing."""
        return [target for target in self.after(state, taus) if target != state]

    def settle(self, state: OracleState) -> list[OracleState] | None:
        """The states that the controller's internal transitions go through, None if they never end.

        All enabled taus in source order, each at most once, and again until none was enabled.
        """
        path = [state]
        seen = set()
        while path[-1] not in seen:
            seen.add(path[-1])
            before = len(path)
            for tau in self.taus:
                path += self.moves(path[-1], [tau])
            if len(path) == before:
                return path
        return None

    @cached_property
    def taus(self) -> list[Event]:
        return [event for event in self.events if event.kind is EventKind.TAU]

    def properties(self) -> dict[str, bool]:
        """The controller properties: of one that settles after each event before the next.

        ``acyclic`` tells that no order of internal transitions goes round, so that confluence is a question.
        """
        others = [event for event in self.events if event not in self.taus]
        settled: dict[OracleState, OracleState | None] = {}
        edges: dict[OracleState, set[OracleState]] = {}
        starts = list(self.initials)
        while starts:
            start = starts.pop()
            if start in settled:
                continue
            path = self.settle(start)
            settled[start] = None if path is None else path[-1]
            if path is not None and path[-1] not in edges:
                starts += self.after(path[-1], self.sent(path[-1], others))
                edges[path[-1]] = set()
        for rest in edges:
            ends = {settled[start] for start in self.after(rest, self.sent(rest, others))}
            edges[rest] = {end for end in ends if end is not None}
        bounded = None not in settled.values()
        reaching = {rest for rest in edges if self.marked(rest)}
        while any(ends & reaching and rest not in reaching for rest, ends in edges.items()):
            reaching |= {rest for rest, ends in edges.items() if ends & reaching}
        return {
            "bounded response": bounded,
            "confluence": all(len(self._ends(start)) < 2 for start in settled),
            "nonblocking under control": bounded and reaching == set(edges),
            "acyclic": not any(self._goes_round(start) for start in settled),
        }

    def sent(self, state: OracleState, events: list[Event]) -> list[Event]:
        """The events without the requests that another one is preferred to, now."""
        enabled = {e.key for e in self.enabled(state) if e.kind is EventKind.REQUEST}

        def held_back(event: Event) -> bool:
            return event.kind is EventKind.REQUEST and any(
                event.key in preference.over and enabled & set(preference.preferred)
                for preference in self.robot.preferences
            )

        return [event for event in events if not held_back(event)]

    def _wake(self, start: OracleState) -> set[OracleState]:
        """All that internal transitions in any order lead to."""
        found, todo = {start}, [start]
        while todo:
            for target in self.moves(todo.pop(), self.taus):
                if target not in found:
                    found.add(target)
                    todo.append(target)
        return found

    def _ends(self, start: OracleState) -> set[OracleState]:
        return {state for state in self._wake(start) if not self.moves(state, self.taus)}

    def _goes_round(self, start: OracleState) -> bool:
        left = self._wake(start)
        while True:
            ends = {s for s in left if not set(self.moves(s, self.taus)) & left}
            if not ends:
                return bool(left)
            left -= ends

    # --- documents ---------------------------------------------------------------------------

    def document(self, plant: bool = False) -> dict[str, Any]:
        """The transition system in the shape of ``explore --json``."""
        states, transitions = self.plant if plant else self.controlled
        number = {state: i for i, state in enumerate(states)}
        return {
            "version": 1,
            "robot": self.robot.name,
            "initial": 0,
            "states": [self._state_document(number[s], s) for s in states],
            "transitions": [
                {
                    "source": number[t.source],
                    "event": self.event_document(t.source, t.occurrence),
                    "controllable": t.occurrence.event.controllable,
                    "target": number[t.target],
                }
                for t in transitions
            ],
        }

    def _state_document(self, number: int, state: OracleState) -> dict[str, Any]:
        def those(what: str) -> dict[str, Any]:
            return {n: v for (w, n), v in zip(self.slots, state, strict=True) if w == what}

        return {
            "id": number,
            "components": those("at"),
            "variables": those("var"),
            "communications": {
                self.name(Event(EventKind.REQUEST, key)): phase
                for key, phase in those("phase").items()
            },
            "marked": self.marked(state),
        }

    def event_document(self, state: OracleState, occurrence: Occurrence) -> dict[str, Any]:
        event = occurrence.event
        if event.kind in (EventKind.TAU, EventKind.AFTER):
            here = self.get(state, "at", event.key)
            after = dict(zip(self.slots, self.step(state, occurrence), strict=True))
            there = after["at", event.key]
            return {
                "kind": event.kind.value,
                "name": event.key,
                "value": f"{here}->{there}",
                "index": event.index,
            }
        value: Any = None
        if occurrence.values:
            if [path for path, _ in occurrence.values] == [()]:
                value = occurrence.values[0][1]
            else:
                value = {path_text(path): v for path, v in occurrence.values}
        return {"kind": event.kind.value, "name": self.name(event), "value": value}

    def name(self, event: Event) -> str:
        """The bare name of a communication, qualified only where several have it."""
        if event.kind in (EventKind.TAU, EventKind.AFTER):
            return event.key
        communications: list[Communication] = list(self.robot.communications.values())
        bare = event.key.split(".")[1]
        same = [c for c in communications if c.name == bare]
        return bare if len(same) == 1 else event.key


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


def path_text(path: Path) -> str:
    """``position.x``, ``items[0].kind``."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text
