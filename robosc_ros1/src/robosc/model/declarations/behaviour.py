"""Resolution of a component's behaviour: its variables, states and transitions, typed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from robosc.errors import Note
from robosc.expr.evaluation import constant
from robosc.expr.presence import condition_on_data
from robosc.expr.tree import Expr, is_constant_data
from robosc.expr.types import ArrayType, DoubleType, EnumType, ObjectType, Type, Value
from robosc.language.events import EventKind
from robosc.model.checks.behaviour_rules import (
    NamedTransition,
    check_events,
    check_hiding,
    check_initial,
    check_repeated_events,
    check_staying,
    internal_with_else,
    report_unavailable,
    with_else,
)
from robosc.model.checks.reach import check_reach
from robosc.model.diagnostics import Report
from robosc.model.entities import (
    After,
    Assignment,
    Behaviour,
    CompositeState,
    ResultTransition,
    State,
    Tau,
    Variable,
)
from robosc.model.names.groups import GroupResolver
from robosc.model.names.tables import CommunicationInfo, Instance, SymbolTable, path_of
from robosc.model.names.targets import Targets
from robosc.model.typing.compatibility import check_range, coerce, default_value, describe
from robosc.model.typing.durations import DURATION, is_long_enough
from robosc.model.typing.expected import ANY, BOOLEAN, expected_type
from robosc.model.typing.expressions import Typer
from robosc.model.typing.incoming import Incoming, is_value, no_value
from robosc.source import Span
from robosc.syntax.nodes import (
    Access,
    AfterNode,
    AssignmentNode,
    BehaviourNode,
    ElseNode,
    ExprNode,
    Name,
    ResultTransitionNode,
    StateNode,
    TauNode,
    VariableNode,
)


class BehaviourResolver:
    """Resolves the behaviour of one component; ``_is_sound`` is False after an error."""

    def __init__(self, instance: Instance, symbols: SymbolTable, report: Report) -> None:
        self._instance = instance
        self._symbols = symbols
        self._report = report
        self._taus = 0
        self._afters = 0
        self._inside = ""
        """The path of the state in which a transition stands."""
        self._levels: dict[int, _Level] = {}
        self._composites: dict[str, CompositeState] = {}
        self._event_spans: dict[tuple[int, EventKind], Span] = {}
        self._rest: set[tuple[int, EventKind]] = set()
        """The offsets and events of transitions with ``else``."""
        self._is_sound = True

    def resolve(self, node: BehaviourNode) -> Behaviour:
        """The behaviour without the parts that have errors."""
        declared = self._instance.variable_nodes.values()
        variables = [v for v in map(self._variable, declared) if v is not None]
        transitions, taus, _ = self._level(node, "")
        behaviour = Behaviour(
            tuple(variables),
            tuple(self._states(node, "", ())),
            transitions,
            taus,
            tuple(self._composites.values()),
            span=node.span,
        )
        self._check_states(node, behaviour)
        return behaviour

    # --- variables -------------------------------------------------------------------------------

    def _variable(self, node: VariableNode) -> Variable | None:
        name, type_ = node.name, self._instance.variables[node.name.text]
        starts_empty = node.initial is None and isinstance(type_, ArrayType | ObjectType)
        initial = None if type_ is None or starts_empty else self._initial(node, type_)
        if type_ is None or (initial is None and not starts_empty):
            self._is_sound = False
            return None
        return Variable(name.text, self._instance.name, type_, initial, False, span=name.span)

    def _initial(self, node: VariableNode, type_: Type) -> Value | None:
        if node.initial is None:
            return default_value(type_)
        if isinstance(type_, ArrayType | ObjectType):
            self._report.add(
                "variable-type",
                node.initial.span,
                f"'{node.name.text}' cannot have an initial value: it is {describe(type_)}",
                "it holds nothing until something is assigned to it",
            )
            return None
        typer = Typer(
            self._report,
            self._instance.types,
            None,
            no_value("an initial value cannot depend on a received value"),
        )
        place = f"variable '{node.name.text}'"
        if isinstance(node.initial, Access) and self._reads_something(node.initial, type_):
            return None
        expr = typer.check(node.initial, expected_type(type_), place)
        if expr is None:
            return None
        value = constant(expr)
        if value is None:
            self._report.add(
                "initial-not-constant",
                node.initial.span,
                f"the initial value of '{node.name.text}' must be a finite constant",
            )
            return None
        check_range(expr, type_, f"'{node.name.text}'", self._report)
        return float(value) if isinstance(type_, DoubleType) else value

    def _reads_something(self, access: Access, type_: Type) -> bool:
        """Report an initial value that names a variable or state; whether it does."""
        own = self._instance
        name = access.root.text
        if isinstance(type_, EnumType) and name in type_.values and not access.path:
            return False
        component = self._symbols.component(name) if access.path else own
        if component is None:
            return False
        last = access.path[-1] if access.path else access.root
        text = last.text if isinstance(last, Name) else ""
        if text not in component.variables and text not in component.states:
            return False
        self._report.add(
            "initial-not-constant",
            access.span,
            "an initial value must be a constant, it cannot read a variable or state",
        )
        return True

    # --- states and transitions ------------------------------------------------------------------

    def _level(self, node: BehaviourNode | StateNode, path: str) -> _Level:
        """Resolve what stands in a state, or beside all states, and in the states in it."""
        named: list[NamedTransition] = []
        taus: list[tuple[Tau, TauNode]] = []
        afters: list[After | None] = []
        inner: dict[int, _Level] = {}
        for item in node.items:
            self._inside = path
            match item:
                case StateNode():
                    inner[id(item)] = self._level(item, path_of(item, path))
                case ResultTransitionNode():
                    named += self._results(item)
                case TauNode():
                    taus.append((self._tau(item), item))
                case AfterNode():
                    afters.append(self._after(item))
        self._levels |= inner
        state = node if isinstance(node, StateNode) else None
        check_events(self._instance, self._report, named, state)
        own = internal_with_else(taus, state, self._report)
        if state is not None and state.states and afters:
            self._report.add(
                "misplaced",
                next(item for item in node.items if isinstance(item, AfterNode)).span,
                f"'after' is for states without states in them, and '{path}' has some",
                "write it in each state that is to end so",
            )
        return with_else(named), own, tuple(after for after in afters if after is not None)

    def _states(
        self, node: BehaviourNode | StateNode, path: str, around: tuple[CompositeState, ...]
    ) -> Iterator[State]:
        """The states without states in them that stand in a node, in source order."""
        for item in node.items:
            if not isinstance(item, StateNode):
                continue
            name = path_of(item, path)
            if self._instance.states.get(name) is not item:
                continue
            transitions, taus, afters = self._levels[id(item)]
            span = item.name.span
            if item.states:
                outer = CompositeState(name, transitions, taus, span=span)
                self._composites[name] = outer
                yield from self._states(item, name, (outer, *around))
                continue
            levels = [self._instance.states[state.name] for state in around]
            marked = item.marked
            begins = item.initial
            for level in levels:
                marked = marked or (begins and level.marked)
                begins = begins and level.initial
            yield State(name, begins, marked, transitions, taus, afters, around, span=span)

    def _tau(self, node: TauNode) -> Tau:
        self._taus += 1
        incoming = no_value("an internal transition carries no value")
        guard = self._guard(node.guard, incoming)
        assignments = self._assignments(node.assignments, incoming)
        goto = self._goto(node.goto)
        name = self._instance.name
        taken = ResultTransition(EventKind.TAU, name, guard, assignments, goto, span=node.span)
        return Tau(self._taus, taken)

    def _after(self, node: AfterNode) -> After | None:
        self._afters += 1
        incoming = no_value("'after' carries no value")
        delay = self._typer(incoming).check(node.duration, DURATION, "'after'")
        if delay and not is_long_enough(delay, "'after'", node.duration.span, self._report):
            delay = None
        guard = self._guard(node.guard, incoming)
        assignments = self._assignments(node.assignments, incoming)
        goto = self._goto(node.goto)
        if delay is None:
            self._is_sound = False
            return None
        name = self._instance.name
        happening = ResultTransition(
            EventKind.AFTER, name, guard, assignments, goto, span=node.span
        )
        return After(self._afters, delay, happening)

    def _results(self, node: ResultTransitionNode) -> list[NamedTransition]:
        """One transition for each event of each communication that has it."""
        scope = self._instance.types.scope
        groups = GroupResolver(self._symbols, scope, self._report)
        listed, whole = groups.listed(node.communications)
        self._is_sound &= whole
        goto = self._goto(node.goto)
        found: list[NamedTransition] = []
        for name in check_repeated_events(node.events, self._report):
            event = EventKind(name.text)
            self._event_spans[node.span.start, event] = name.span
            having = [(access, info) for access, info in listed if event in info.events]
            for access, info in having:
                guard, assignments = self._clauses(node, _incoming(event, info))
                transition = ResultTransition(
                    event, info.key, guard, assignments, goto, span=node.span
                )
                found.append(NamedTransition(transition, name, access, node.guard))
                if isinstance(node.guard, ElseNode):
                    self._rest.add((node.span.start, event))
            if not having:
                self._clauses(node, Incoming(None, known=False))  # for their own errors
                self._is_sound = False
                if listed:
                    report_unavailable(event, name, [info for _, info in listed], self._report)
        return found

    def _clauses(
        self, node: ResultTransitionNode, incoming: Incoming
    ) -> tuple[Expr | None, tuple[Assignment, ...]]:
        return self._guard(node.guard, incoming), self._assignments(node.assignments, incoming)

    def _typer(self, incoming: Incoming) -> Typer:
        return Typer(self._report, self._instance.types, self._symbols, incoming)

    def _guard(self, node: ExprNode | ElseNode | None, incoming: Incoming) -> Expr | None:
        if node is None or isinstance(node, ElseNode):
            return None
        guard = self._typer(incoming).check(node, BOOLEAN, "a guard")
        if guard is None:
            self._is_sound = False
            return None
        return condition_on_data(guard)

    def _goto(self, goto: Name | Access | None) -> str | None:
        """The state in which a ``goto`` ends: of a state with states in it, the initial one."""
        if goto is None:
            return None
        own, scope = self._instance, self._instance.types.scope
        steps = [goto] if isinstance(goto, Name) else [goto.root, *_names(goto)]
        path = own.nearest_state(".".join(step.text for step in steps), self._inside)
        if path is not None:
            parts = path.split(".")
            for length, step in enumerate(steps, 1 + len(parts) - len(steps)):
                scope.names.use(step, own.states[".".join(parts[:length])], own.name)
            return own.first_leaf(path)
        self._is_sound = False
        if not scope.is_unresolved(steps[-1].text, "state"):
            self._report.add(
                "unknown-state",
                goto.span,
                f"{own.name} has no state '{goto.span.text}'",
                self._report.suggest(goto.span.text, own.states, "its states"),
            )
        return None

    # --- assignments -----------------------------------------------------------------------------

    def _assignments(
        self, nodes: Sequence[AssignmentNode], incoming: Incoming
    ) -> tuple[Assignment, ...]:
        targets = Targets(self._instance, self._symbols, self._report)
        found: list[Assignment] = []
        seen: dict[str, Span] = {}
        for node in nodes:
            target = targets.resolve(node.target)
            if target is not None and target in seen:
                self._report.add(
                    "duplicate-assignment",
                    node.target.span,
                    f"'{target}' is assigned twice at the same time",
                    "assignments of one transition happen at once",
                    [Note("the first one is here", seen[target])],
                )
                self._is_sound = False
            elif target is not None:
                seen[target] = node.target.span
            assignment = self._assignment(node, target, incoming)
            if assignment is None:
                self._is_sound = False
            else:
                found.append(assignment)
        return tuple(found)

    def _assignment(
        self, node: AssignmentNode, target: str | None, incoming: Incoming
    ) -> Assignment | None:
        type_ = self._instance.variables.get(target) if target is not None else None
        typer = self._typer(incoming)
        if target is None or type_ is None:
            # The value is typed for its own errors, although the variable's type is unknown.
            if not (isinstance(node.value, Access) and not is_value(node.value)):
                typer.check(node.value, ANY, "an assignment")
            return None
        value = typer.check(node.value, expected_type(type_), f"variable '{target}'")
        if value is None:
            return None
        if is_constant_data(value) and _has_enum(type_):
            message = f"a constant with a value of an enum cannot be assigned to '{target}'"
            hint = "a variable holds what the enum converts; read the constant where it is needed"
            self._report.add("not-assignable", node.value.span, message, hint)
            return None
        check_range(value, type_, f"'{target}'", self._report)
        return Assignment(target, coerce(value, type_), span=node.span)

    def _check_states(self, node: BehaviourNode, behaviour: Behaviour) -> None:
        if self._instance.types.scope.is_damaged(node.span):
            self._is_sound = False
            return
        states = [s for s in node.items if isinstance(s, StateNode)]
        sound = check_initial(self._instance, self._report, states, None)
        for composite in self._composites:
            around = self._instance.states[composite]
            sound &= check_initial(self._instance, self._report, around.states, around)
        check_staying(self._instance, behaviour, self._report)
        check_hiding(behaviour, self._event_spans, self._rest, self._report)
        if sound and self._is_sound:
            start = [s.name for s in behaviour.states if s.initial]
            check_reach(self._instance, behaviour, start, self._report)


_Level: TypeAlias = tuple[tuple[ResultTransition, ...], tuple[Tau, ...], tuple[After, ...]]
"""The transitions of a state, or of all states."""


def _names(access: Access) -> Iterator[Name]:
    return (step for step in access.path if isinstance(step, Name))


def _has_enum(type_: Type) -> bool:
    """Whether an array or object has a part of an enum."""
    match type_:
        case ArrayType(element=element):
            return isinstance(element, EnumType) or _has_enum(element)
        case ObjectType(properties=properties):
            return any(isinstance(t, EnumType) or _has_enum(t) for _, t in properties)
    return False


def _incoming(event: EventKind, info: CommunicationInfo) -> Incoming:
    found = info.sort.event(event)
    if found is None or found.brings is None:
        return no_value(f"'on {event.value}' carries no value")
    type_ = info.brought(event)
    return Incoming(type_, known=type_ is not None, optional=found.optional)
