"""Steps of the controlled plant on exact data, compiled to functions.

A state is a dict: component to the name of its location, ``Component.variable`` to its value, and
``~key`` to the phase of a communication. An event reads what it carries from a dict by path.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import compress
from operator import is_not, itemgetter
from types import MappingProxyType
from typing import Any, Generic, TypeAlias, TypeVar

from robosc.emit.controller.guard_methods import whole_guards
from robosc.expr.evaluation import as_read, evaluate, part_of_value, scalar_of
from robosc.expr.traversal import all_names, path_text, walk
from robosc.expr.tree import (
    REASON,
    Aggregate,
    Binary,
    Call,
    Convert,
    ElementRef,
    Expr,
    Holds,
    Leaf,
    Literal,
    Made,
    ParameterRef,
    Part,
    PhaseRef,
    StateRef,
    Unary,
    ValueRef,
    VariableRef,
)
from robosc.expr.types import DoubleType, IntegerType
from robosc.language.events import EventKind
from robosc.language.reasons import REFUSED
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Data, DataArray, DataObject, Provide, data_expressions
from robosc.plant.acceptance import resets_of
from robosc.plant.automaton import Event, LocalAutomaton, VariableKind
from robosc.plant.event_values import value_parts
from robosc.plant.logic import exact
from robosc.runtime.core.values import Undefined, widen
from robosc.simulate.faults import InvalidLine
from robosc.simulate.values.message_fields import Fields, parts_of
from robosc.supervisor import Supervisor

T = TypeVar("T")
State: TypeAlias = dict[str, Any]
"""Never changed: an event makes another one."""
Carried: TypeAlias = Mapping[Any, Any]
"""What an event carries: each part that the model reads, by path; None where it is missing."""
Function: TypeAlias = Callable[[State, Carried], Any]

NOTHING: Carried = {}


class Unknown(dict[Any, Any]):
    """What an event carries, of which only these parts are known."""

    def get(self, key: Any, default: Any = None) -> Any:
        return self[key]


UNKNOWN = Unknown()
"""Stands for anything that an event may carry."""
LATE: Carried = {(): None, REASON: "timeout"}
"""What an error carries that time has caused."""


def function(expr: Expr) -> Function:
    """The expression as a function of a state and of what an event carries.

    It raises Undefined where :func:`robosc.expr.evaluation.evaluate` does.
    """
    match expr:
        case Literal(value=value):
            return lambda s, v: value
        case ParameterRef(parameter=parameter):
            return lambda s, v: parameter.default
        case StateRef(component=name, places=places):
            return lambda s, v: s[name] in places
        case PhaseRef(communication=key, places=places):
            phase = f"~{key}"
            return lambda s, v: s[phase] in places
        case VariableRef(key=key):
            return lambda s, v: _need(s[key])
        case ValueRef(path=path):
            return lambda s, v: _need(v.get(path))
        case ElementRef(variable=variable, path=path, carried=read):
            return lambda s, v: as_read(part_of_value(v[variable], path), read)
        case Binary() if expr.operation.is_lazy:
            left, right, row = function(expr.left), function(expr.right), expr.operation
            return lambda s, v: row.decided if left(s, v) is row.decider else right(s, v)
        case Unary() | Binary() | Call() | Part() | Made() if _is_plain(expr):
            operands, scalar = [function(o) for o in expr.operands], scalar_of(expr)
            if len(operands) == 2:
                first, second = operands
                return lambda s, v: scalar(first(s, v), second(s, v))
            return lambda s, v: scalar(*[operand(s, v) for operand in operands])
    return of_carried(expr, lambda s, v: evaluate(expr, _lookup(s, v)))


def of_carried(expr: Expr, found: Callable[[State, Carried], T]) -> Callable[[State, Carried], T]:
    """The same function of an expression, which is computed once for each thing that is carried if
    the expression reads nothing else: of a long array that takes long."""
    parts = list(walk(expr))
    bound = {part.variable for part in parts if isinstance(part, Aggregate)}
    inner = {part.variable for part in parts if isinstance(part, ElementRef)}
    takes_long = bound or any(isinstance(part, Convert) for part in parts)
    if keys_read([expr]) or not takes_long or inner - bound:
        return found
    known: dict[int, tuple[Carried, T | Undefined]] = {}

    def remembering(s: State, v: Carried) -> T:
        one = known.get(id(v))
        if one is None or one[0] is not v:
            if len(known) >= REMEMBERED:
                known.clear()
            try:
                one = v, found(s, v)
            except Undefined as error:
                one = v, error
            known[id(v)] = one
        if isinstance(one[1], Undefined):
            raise Undefined
        return one[1]

    return remembering


def _is_plain(expr: Expr) -> bool:
    """Whether all operands are always evaluated, with nothing bound in them."""
    return not any(
        isinstance(part, Aggregate | Holds) or (isinstance(part, Call) and part.operator == "else")
        for part in walk(expr)
    )


def _need(value: Any) -> Any:
    if value is None:
        raise Undefined
    return value


def _lookup(state: State, carried: Carried) -> Callable[[Leaf], Any]:
    def look(leaf: Leaf) -> Any:
        match leaf:
            case ValueRef(path=path):
                return carried.get(path)
            case VariableRef(key=key):
                return state[key]
            case StateRef(component=name, places=places):
                return state[name] in places
            case PhaseRef(communication=key, places=places):
                return state[f"~{key}"] in places
        raise AssertionError("the plant's tests were replaced by what they test")

    return look


def keys_read(exprs: Iterable[Expr]) -> set[str]:
    """The keys of a state that expressions read."""
    found = set()
    for part in (part for expr in exprs for part in walk(exact(expr))):
        match part:
            case StateRef(component=key) | VariableRef(key=key):
                found.add(key)
            case PhaseRef(communication=key):
                found.add(f"~{key}")
    return found


def holds(condition: Function, state: State, carried: Carried = NOTHING) -> bool:
    """Whether a condition is defined and true."""
    try:
        return condition(state, carried) is True
    except Undefined:
        return False


def possible_values(condition: Function, state: State, carried: Carried) -> tuple[bool, ...]:
    """What a condition may come to, where not all is known."""
    try:
        return (holds(condition, state, carried),)
    except KeyError:
        return (True, False)


@dataclass(frozen=True)
class ExactEdge:
    """An edge of a component, compiled.

    ``name`` is its line as the model tells it, and where it leads if it leaves its location.
    ``assigned`` are variables with their new values, their types, and whether they are in the state
    of the plant: those that are not stay as they are where a value leaves their range. ``made`` are
    the values as expressions.
    """

    name: tuple[str, str]
    guard: Function | None
    condition: Expr | None
    assigned: tuple[tuple[str, Function, Any, bool], ...]
    made: tuple[Expr, ...]
    target: str
    entered: frozenset[str]
    """The states, also those with states in them, whose delays begin or end with it."""

    def is_open(self, state: State, carried: Carried) -> bool:
        """Whether its guard holds."""
        return self.guard is None or holds(self.guard, state, carried)


@dataclass(frozen=True)
class Partner:
    """A component on an event, compiled: its edges by the location that they leave."""

    component: str
    place: str
    blocking: bool
    edges: Mapping[str, Sequence[ExactEdge]]

    @property
    def begun(self) -> str:
        """Where a state tells by what a component with delays has entered its location."""
        return f"@{self.place}"

    def edge(self, state: State, carried: Carried) -> ExactEdge | None:
        for edge in self.edges.get(state[self.place], ()):
            if edge.is_open(state, carried):
                return edge
        return None

    def may_take(self, state: State, carried: Carried) -> set[bool]:
        """Whether it takes an edge; both, where that is not known."""
        found: set[bool] = set()
        for edge in self.edges.get(state[self.place], ()):
            guard = edge.guard
            values = (True,) if guard is None else possible_values(guard, state, carried)
            found.update(value for value in values if value)
            if False not in values:
                return found
        return found | {False}


class LastOf(Generic[T]):
    """A function of a state, which is asked of the same one again and again."""

    def __init__(self, function: Callable[[State], T]) -> None:
        self._function = function
        self._state: State | None = None
        self._found: list[T] = []
        """Empty: it is undefined."""

    def __call__(self, state: State) -> T:
        if state is not self._state:
            self._state, self._found = state, []
            self._found.append(self._function(state))
        elif not self._found:
            raise Undefined
        return self._found[0]


REMEMBERED = 5000
"""So many results of a function are remembered."""


def remembering(function: Callable[[State], T], reads: Sequence[str]) -> Callable[[State], T]:
    """The same function, which is computed once for the same values of what it reads."""
    values_of: Callable[[State], Any] = itemgetter(*reads) if reads else lambda state: ()
    found: dict[Any, T] = {}

    def remembered(state: State) -> T:
        values = values_of(state)
        try:
            return found[values]
        except KeyError:
            if len(found) >= REMEMBERED:
                found.clear()
            result = found[values] = function(state)
            return result
        except TypeError:  # what an array or an object holds
            return function(state)

    return remembered


class Results(Generic[T]):
    """The results of many functions of a state, each with the keys that it reads.

    From one state to the next, only those are looked at that read what has become another value: of
    a large model an input concerns a few components. And each is computed once for the same values.
    """

    def __init__(self, functions: Iterable[tuple[Callable[[State], T], Iterable[str]]]) -> None:
        pairs = [(function, tuple(dict.fromkeys(reads))) for function, reads in functions]
        self._functions = [remembering(function, reads) for function, reads in pairs]
        self._readers: dict[str, list[int]] = {}
        for number, (_, reads) in enumerate(pairs):
            for key in reads:
                self._readers.setdefault(key, []).append(number)
        self._keys = tuple(self._readers)
        self._values: tuple[Any, ...] = ()
        self._results: list[T] = []

    def __call__(self, state: State) -> list[T]:
        """The results, in order; the list is changed by the next call."""
        values = itemgetter(*self._keys, *self._keys[:1])(state) if self._keys else ()
        results, self._results = self._results, []  # in case that a function fails
        if not results:
            results = [function(state) for function in self._functions]
        else:
            changed = compress(self._keys, map(is_not, values, self._values))
            for number in {n for key in changed for n in self._readers[key]}:
                results[number] = self._functions[number](state)
        self._values, self._results = values, results
        return results


@dataclass(frozen=True, eq=False)
class ExactStep:
    """An event, compiled. ``guard`` is what the supervisor demands of a command; ``reads`` are the
    keys of a state that decide whether it can happen."""

    event: Event
    number: int
    phase: str | None
    sources: tuple[str, ...]
    target: str
    partners: tuple[Partner, ...]
    guard: Function | None
    provides: tuple[tuple[Function | None, Provide, Function], ...]
    carries: bool
    reads: frozenset[str]

    def in_phase(self, state: State) -> bool:
        return self.phase is None or state[self.phase] in self.sources

    def replaces(self, state: State) -> bool:
        """Whether it is a goal that takes the place of the one that runs."""
        return self.may_replace and self.phase is not None and state[self.phase] == "busy"

    @property
    def may_replace(self) -> bool:
        """Whether it is a goal that may take the place of another one."""
        return self.event.kind is EventKind.REQUEST and "busy" in self.sources

    def blocked_by(self, state: State, carried: Carried) -> list[Partner]:
        return [p for p in self.partners if p.blocking and p.edge(state, carried) is None]

    def after(self, state: State, carried: Carried = NOTHING) -> State | None:
        """The state after the event; None if it cannot happen."""
        if not self.in_phase(state):
            return None
        found = dict(state)
        if self.phase is not None:
            found[self.phase] = self.target
        for partner in self.partners:
            edge = partner.edge(state, carried)
            if edge is None:
                if partner.blocking:
                    return None
                continue
            found[partner.place] = edge.target
            if edge.entered and partner.begun in state:
                found[partner.begun] = (self.number, *edge.name)
            for key, value, type_, decides in edge.assigned:
                try:
                    new = value(state, carried)
                except Undefined:
                    continue
                bounds = type_.bounds if isinstance(type_, IntegerType) else None
                if bounds is not None and not bounds[0] <= new <= bounds[1]:
                    if decides:
                        return None
                    continue
                found[key] = widen(new) if isinstance(type_, DoubleType) else new
        return found

    @cached_property
    def provided(self) -> Callable[[State], tuple[Provide | None, Any]]:
        """The provide statement that gives the data of a command in a state, with the data.

        Raises Undefined if some of them have not arrived yet, or are not finite.
        """

        def provided(state: State) -> tuple[Provide | None, Any]:
            for condition, provide, data in self.provides:
                if condition is None or holds(condition, state):
                    return provide, data(state, NOTHING)
            return None, None

        # Equal numbers are not always the same data: -0.0 and 0.0.
        return LastOf(provided) if self.read_by_data else remembering(provided, ())

    @cached_property
    def read_by_data(self) -> tuple[str, ...]:
        """The variables that say which data are sent."""
        given = ((p.condition, *data_expressions(p.data)) for _, p, _ in self.provides)
        return tuple(keys_read(part for parts in given for part in parts if part is not None))

    @cached_property
    def allowed(self) -> LastOf[bool]:
        """Whether a command can be sent in a state."""

        def allowed(state: State) -> bool:
            if self.guard is not None and not holds(self.guard, state):
                return False
            return self.has_data(state) and self.after(state, self.carried(state)) is not None

        return LastOf(allowed)

    @cached_property
    def has_data(self) -> Callable[[State], bool]:
        """Whether there are data to send."""

        def has_data(state: State) -> bool:
            try:
                self.provided(state)
            except Undefined:
                return False
            return True

        return remembering(has_data, self.read_by_data)

    def carried(self, state: State) -> Carried:
        """What a command carries in a state, as far as the model reads it. Raises Undefined."""
        if self.provides and self.carries:
            return dict(parts_of(self.provided(state)[1]))
        if not self.has_data(state):
            raise Undefined
        return NOTHING


def refused(parts: Carried) -> Carried:
    """What an answer carries as an error."""
    return {**parts, REASON: REFUSED}


def _data(data: Data) -> Function:
    """Provided data as nested dicts, lists and values."""
    if isinstance(data, DataObject):
        fields = [(name, _data(part)) for name, part in data.fields]
        return lambda s, v: {name: part(s, v) for name, part in fields}
    if isinstance(data, DataArray):
        elements = [_data(part) for part in data.elements]
        return lambda s, v: [part(s, v) for part in elements]
    value = function(data)

    def finite(state: State, carried: Carried) -> Any:
        found = value(state, carried)
        if isinstance(found, float) and not math.isfinite(found):
            raise Undefined
        return found

    return finite


class Steps:
    """All events of a supervised plant, compiled.

    ``mute`` are the keys of services that cannot tell that they have failed; ``rates`` are
    parameters of the node. ``follows``: what is forbidden happens, as for a monitor; ``unjudged``
    are the keys of what that cannot hear or judge; ``fields`` are those of messages.
    ``judges_states``: requirements on states are judged, as by a monitor that hears all.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        mute: Collection[str] = (),
        rates: Mapping[str, float] = MappingProxyType({}),
        follows: bool = False,
        unjudged: Collection[str] = (),
        fields: Fields | None = None,
        judges_states: bool = False,
    ) -> None:
        self.supervisor = supervisor
        self.fields = Fields() if fields is None else fields
        self.mute = frozenset(mute)
        self.rates = rates
        self.follows = follows
        self.unjudged = frozenset(unjudged)
        self.plant = supervisor.plant
        self.robot = self.plant.robot
        invariants = self.plant.invariants if judges_states else ()
        self.on_states = {n: function(exact(met)) for met, n in invariants}
        self.guards = {g.event.identity: g for g in whole_guards(supervisor)}
        wholes = {(e.whole or e).identity: e.whole or e for e in self.plant.events}
        self.steps = [self._step(n, e) for n, e in enumerate(wholes.values())]
        self.by_event = {step.event.identity: step for step in self.steps}
        self.taus = [s for s in self.steps if s.event.kind is EventKind.TAU]
        commands = [
            s for s in self.steps if s.event.controllable and s.event.kind is not EventKind.TAU
        ]
        self.commands = sorted(commands, key=lambda s: s.event.kind is not EventKind.CANCEL)
        sent = [step for step in commands if step.event.kind.sent]
        self._sent = {(step.event.key, step.event.kind.word): step.event for step in sent}
        requests = {step.event.command: step for step in sent}
        self.preferred = {
            key: [requests[other] for other in others if other in requests]
            for key, others in ({} if self.guards_others else self.robot.yields_to).items()
        }
        self._corrections = {
            key: [
                (
                    None if p.condition is None else function(exact(p.condition)),
                    p,
                    _data(p.data),
                )
                for p in self.robot.provides
                if p.communication == key
            ]
            for key in self.robot.corrected
        }

    def _step(self, number: int, event: Event) -> ExactStep:
        guard = self.guards.get(event.identity)
        phase = event.phase
        variables = self.plant.variables
        values = () if phase is None else variables[phase.variable].values
        partners = tuple(self._partner(a, resets_of(event)) for a in event.automata)
        provides = [
            p
            for p in self.robot.provides
            if not self.robot.supervises
            if event.kind.given and p.communication == event.command
        ]
        edges = [e for p in partners for several in p.edges.values() for e in several]
        read = [part for edge in edges for part in (edge.condition, *edge.made)]
        read += [part for p in provides for part in (p.condition, *data_expressions(p.data))]
        read += [] if guard is None else [guard.expr]
        name = None if phase is None else f"~{variables[phase.variable].name}"
        return ExactStep(
            event,
            number,
            name,
            () if phase is None else tuple(str(values[i]) for i in phase.sources),
            "" if phase is None else str(values[phase.target]),
            partners,
            None if guard is None else function(exact(guard.expr)),
            tuple(
                (
                    None if p.condition is None else function(p.condition),
                    p,
                    self._fitting(event, _data(p.data)),
                )
                for p in provides
            ),
            bool(event.parameters or value_parts(self.robot, event)) if event.kind.sent else False,
            frozenset(
                keys_read(part for part in read if part is not None)
                | {p.place for p in partners}
                | ({name} if name else set())
            ),
        )

    def _partner(self, automaton: LocalAutomaton, resets: Sequence[LocalAutomaton]) -> Partner:
        variable = self.plant.variables[automaton.variable]
        name = f"~{variable.name}" if variable.kind is VariableKind.PHASE else variable.name
        edges: dict[str, list[ExactEdge]] = {}
        for edge in automaton.edges:
            source, target = (str(variable.values[n]) for n in (edge.source, edge.target))
            found = edges.setdefault(source, [])
            condition = None if edge.guard is None else exact(edge.guard)
            keys = [(f"{automaton.component}.{a.variable}", a.value) for a in edge.assignments]
            found.append(
                ExactEdge(
                    (edge.span.told_from(self.robot.span), "" if source == target else target),
                    None if condition is None else function(condition),
                    condition,
                    tuple((k, function(v), *self._kind(k)) for k, v in keys),
                    tuple(v for _, v in keys),
                    target,
                    frozenset((*edge.outer, *((source, target) if edge.enters else ()))),
                )
            )
        return Partner(automaton.component, name, automaton.blocking, edges)

    def _kind(self, key: str) -> tuple[Any, bool]:
        variable = self.robot.variables[key]
        return variable.type, variable.in_state

    @property
    def initial(self) -> State:
        """The initial state, before any internal transition."""
        found: State = {k: variable.initial for k, variable in self.robot.variables.items()}
        for variable, index in zip(self.plant.variables, self.plant.initial, strict=True):
            if variable.kind is VariableKind.PHASE:
                found[f"~{variable.name}"] = str(variable.values[index])
            elif variable.kind in (VariableKind.LOCATION, VariableKind.ASSUMPTION):
                found[variable.name] = str(variable.values[index])
        delayed = (s.partners[0] for s in self.steps if s.event.kind is EventKind.AFTER)
        return found | {partner.begun: None for partner in delayed}

    @property
    def guards_others(self) -> bool:
        """Whether another controller sends the commands."""
        return self.robot.supervises

    @property
    def inputs(self) -> list[ExactStep]:
        """What comes from outside: the robot's events, and the commands of another controller."""
        if not self.guards_others:
            return [s for s in self.steps if not s.event.controllable]
        found = [s for s in self.steps if not s.event.controllable]
        found = [s for s in found if not (self.follows and self._is_mute(s))]
        return [s for s in (*found, *self.commands) if s.event.key not in self.unjudged]

    def violated(self, state: State) -> list[int]:
        """The requirements on states, by number, that do not hold."""
        return [n for n, met in self.on_states.items() if not holds(met, state)]

    def correcting(self) -> set[str]:
        """The variables that decide what becomes of the commands of another controller."""
        provides = [p for p in self.robot.provides if p.communication in self.robot.corrected]
        found = [e for p in provides for e in data_expressions(p.data)]
        found += [p.condition for p in provides if p.condition is not None]
        return {leaf.key for e in found for leaf in walk(e) if isinstance(leaf, VariableRef)}

    def provides_of(self, step: ExactStep) -> list[Provide]:
        """What provides the data of a command, or corrects what another controller sends."""
        of_others = self._corrections.get(step.event.key, ()) if step.event.kind.sent else ()
        return [p for _, p, _ in (of_others if self.guards_others else step.provides)]

    def made(
        self, step: ExactStep, state: State, sent: Carried, turned: int | None = None
    ) -> tuple[Carried, dict[str, Any]]:
        """What a supervisor makes of what a command carries, and the fields that it changes, by
        path; if the condition of the correction ``turned``, a number, came to the contrary.

        Raises:
            Undefined: what a correction reads is not there.
        """
        for number, (condition, _, data) in enumerate(self._corrections.get(step.event.key, ())):
            is_met = condition is None or holds(condition, state, sent)
            if is_met is not (number == turned):
                fields = {
                    path: value
                    for path, value in parts_of(data(state, sent))
                    if all_names(path) and not isinstance(value, dict)
                    if sent.get(path, type(value)()) != value
                }
                return {**sent, **fields}, {path_text(p): v for p, v in fields.items()}
        return sent, {}

    def demand_fitting(self, key: str, kind: str, data: Any) -> None:
        """Demand that the data of a command, by its key and kind, fit into the fields of its
        message.

        Raises:
            Undefined: they do not, so that they cannot be sent.
        """
        try:
            self.fields.demand_fitting(self._sent[key, kind], data)
        except InvalidLine as problem:
            raise Undefined from problem

    def _fitting(self, event: Event, data: Function) -> Function:
        """The data of a command, which raises Undefined also if they do not fit."""
        if not event.kind.sent:
            return data

        def fitting(state: State, carried: Carried) -> Any:
            found = data(state, carried)
            self.demand_fitting(event.key, event.kind.word, found)
            return found

        return fitting

    def reads_data(self, step: ExactStep) -> bool:
        """Whether what a command carries decides whether it is allowed."""
        demands = [self.robot.requirements[n].condition for n in step.event.requirements]
        guard = self.guards.get(step.event.identity)
        demands += [] if guard is None else [guard.expr]
        leaves = (leaf for one in demands for leaf in walk(exact(one)))
        return step.event.key in self.robot.corrected or any(
            isinstance(leaf, ValueRef) for leaf in leaves
        )

    def comes_by_time(self, step: ExactStep) -> bool:
        """Whether time brings an event, and nothing else."""
        return step.event.kind.clocked or self._is_mute(step)

    def _is_mute(self, step: ExactStep) -> bool:
        return step.event.kind is EventKind.ERROR and step.event.key in self.mute

    def told_as(self, step: ExactStep) -> ExactStep | None:
        """The answer as which another controller tells an error, where it has no word for it."""
        if step.event.kind is not EventKind.REFUSAL or step.event.key not in self.mute:
            return None
        return self.by_event.get((EventKind.ANSWER, step.event.key, 0))

    def refusal_of(self, step: ExactStep) -> ExactStep | None:
        """The error as which an answer counts that is not as expected; None: none is expected."""
        event = step.event
        if event.kind is not EventKind.RESPONSE:
            return None
        if self.robot.communications[event.key].expect is None:
            return None
        return self.by_event.get((EventKind.ERROR, event.key, 0))

    def refuses(self, step: ExactStep, state: State) -> bool:
        """Whether a call that cannot happen is one that the controller refuses, and could take."""
        return (
            step.event.kind is EventKind.CALL
            and not self.guards_others
            and state[f"~{step.event.key}"] == "idle"
        )

    def enabled(self, step: ExactStep, state: State) -> bool:
        """Whether a command is allowed, and no enabled command is preferred to it."""
        if not step.allowed(state):
            return False
        others = self.preferred.get(step.event.command, ()) if step.event.kind.sent else ()
        return not any(other.allowed(state) for other in others)

    def completed(self, state: State, limit: int = 64) -> Iterator[tuple[ExactStep, State, State]]:
        """Yield the internal transitions that follow, each with the states before and after; where
        they never end, until a state comes again."""
        passed = [state]
        going_on = True
        while going_on and len(passed) <= limit:
            going_on = False
            may_move = self._may_move(state)
            for number, step in enumerate(self.taus):
                after = step.after(state) if may_move[number] else None
                if after is not None and after != state:
                    yield step, state, after
                    if after in passed:
                        return
                    state, going_on = after, True
                    passed.append(state)
                    may_move = self._may_move(state)

    @cached_property
    def _may_move(self) -> Results[bool]:
        """Whether each internal transition is possible."""

        def may_move(step: ExactStep) -> Callable[[State], bool]:
            guard = step.guard
            return lambda s: (guard is None or holds(guard, s)) and step.after(s) is not None

        return Results((may_move(step), step.reads) for step in self.taus)

    @cached_property
    def _enabled(self) -> Results[bool]:
        """Whether each command is enabled."""

        def enabled(step: ExactStep) -> tuple[Callable[[State], bool], Iterable[str]]:
            others = self.preferred.get(step.event.command, ()) if step.event.kind.sent else ()
            reads = step.reads.union(*(other.reads for other in others))
            return lambda s: self.enabled(step, s), reads

        return Results(map(enabled, self.commands))

    def settled(
        self, state: State, first: ExactStep | None = None
    ) -> Iterator[tuple[ExactStep, State, State]]:
        """Yield all that a controller does by itself in a state, each command once; ``first`` is
        the one whose turn it is."""
        if self.guards_others:
            yield from self.completed(state)
            return
        sent: set[int] = set()
        going_on = True
        commands = list(enumerate(self.commands))
        if first is not None:
            commands.insert(0, (self.commands.index(first), first))
        while going_on:
            going_on = False
            for taken in self.completed(state):
                yield taken
                state = taken[2]
            enabled = self._enabled(state)
            for place, step in commands:
                if not enabled[place] or place in sent:
                    continue
                sent.add(place)
                after = step.after(state, step.carried(state))
                assert after is not None
                yield step, state, after
                state, going_on = after, True
                for taken in self.completed(state):
                    yield taken
                    state = taken[2]
                enabled = self._enabled(state)
