"""States that perform a command, as states with states in them: their stages.

``due``: the request may be sent. ``performing``: it was sent, and is not done; a message, and an
answer to a call of the robot, are done when they are sent. ``waiting``: the time between an error
and the next try, where ``retry`` says ``every``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field, replace

from robosc import dotted, errors, source
from robosc.expr import quantified, tree, undefined_data
from robosc.expr.quantified import chain
from robosc.expr.tree import Binary, Expr, Literal, PhaseRef, StateRef, Unary, VariableRef
from robosc.expr.types import BooleanType, IntegerType
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata
from robosc.model.automata import Transition
from robosc.model.checks.behaviour_rules import NamedTransition
from robosc.model.declarations.statements import StatementResolver
from robosc.model.declarations.transitions import TransitionResolver
from robosc.model.diagnostics import Report
from robosc.model.entities import Provide, Requirement, Robot
from robosc.model.names.communications import GroupResolver
from robosc.model.names.tables import (
    PERFORMING,
    RETRIES,
    WAITING,
    CommunicationInfo,
    Instance,
    SymbolTable,
)
from robosc.runtime.core.places import DUE
from robosc.syntax import nodes
from robosc.syntax.nodes import PerformsNode, RetryNode

_BOOLEAN = BooleanType()


@dataclass(frozen=True)
class Retries:
    """The variable that counts the errors in a row of a state that performs a command.

    The count is kept in the states ``scope``, and begins anew where the state is entered otherwise:
    by what goes to ``restart``. Elsewhere it is 0.
    """

    variable: automata.Variable
    scope: tuple[str, ...]
    restart: str | None = None

    def zero(self, span: source.Span) -> automata.Assignment:
        """The assignment with which the count begins anew."""
        return automata.Assignment(self.variable.name, Literal(0, self.variable.type), span=span)

    def keeps(self, goto: str | None) -> bool:
        """Whether the count goes on in a state."""
        return goto is None or any(automata.is_in(goto, kept) for kept in self.scope)

    def begins_anew(self, place: str | None, taken: automata.Transition) -> bool:
        """Whether a transition, which stands in a place, begins the count anew."""
        if taken.goto is None or any(a.variable == self.variable.name for a in taken.assignments):
            return False
        if not self.keeps(taken.goto):
            return place is None or any(
                automata.is_in(place, kept) or automata.is_in(kept, place) for kept in self.scope
            )
        if self.restart is None or not automata.is_in(taken.goto, self.restart):
            return False
        own = self.scope[0]
        if place is None:
            return len(self.scope) == 1
        return automata.is_in(place, own) and taken.named == own


@dataclass
class Performing:
    """A state that performs a command, while it is unfolded: what its clauses say.

    ``done``, ``again`` and ``given_up`` are what happens when the command is done, when it is tried
    again after an error, and after the last error.
    """

    path: str
    node: PerformsNode
    command: CommunicationInfo
    done: automata.Transition
    again: automata.Transition | None = None
    given_up: automata.Transition | None = None
    wait: automata.Transition | None = None
    retries: Retries | None = None
    own: list[automata.Transition] = field(default_factory=list)
    """The transitions in its braces for events of the command."""

    def within(self, outer: automata.CompositeState) -> automata.CompositeState:
        """The state around its stages, with what it performs."""
        meanwhile = self.node.meanwhile is not None
        return replace(outer, performs=self.command.key, meanwhile=meanwhile)

    def states(
        self, outer: automata.State, around: tuple[automata.CompositeState, ...]
    ) -> Iterator[automata.State]:
        """The stages; ``outer`` says where the whole state begins, and whether it is marked."""
        request = self._with(self.command.command, [self._sent()])
        yield replace(outer, name=f"{self.path} {DUE}", transitions=tuple(request), around=around)
        if self.command.is_awaited:
            found = self._with(EventKind.RESPONSE, [self._anew(self.done)])
            found += self._with(EventKind.ERROR, list(self._errors()))
            if self._has(EventKind.CANCELLED):
                found += self._with(EventKind.CANCELLED, [self._goes(EventKind.CANCELLED, DUE)])
            for kind in (EventKind.FEEDBACK, EventKind.CANCEL):
                found += self._with(kind, [])
            if self.command.replaces:
                found += self._with(EventKind.REQUEST, [self._stays(EventKind.REQUEST)])
            name = f"{self.path} {PERFORMING}"
            yield replace(
                outer, name=name, initial=False, marked=False, transitions=tuple(found),
                around=around,
            )  # fmt: skip
        if self.wait is not None:
            name = f"{self.path} {WAITING}"
            yield replace(outer, name=name, initial=False, transitions=(self.wait,), around=around)

    def _has(self, kind: EventKind) -> bool:
        return kind in self.command.events

    def _sent(self) -> automata.Transition:
        return self._goes(EventKind.REQUEST, PERFORMING) if self.command.is_awaited else self.done

    def _goes(self, kind: EventKind, stage: str) -> automata.Transition:
        goto = f"{self.path} {stage}"
        return automata.Transition(kind, self.command.key, None, (), goto, span=self.node.span)

    def _stays(self, kind: EventKind) -> automata.Transition:
        return automata.Transition(kind, self.command.key, None, (), None, span=self.node.span)

    def _anew(self, taken: automata.Transition) -> automata.Transition:
        if self.retries is None:
            return taken
        return replace(taken, assignments=(*taken.assignments, self.retries.zero(taken.span)))

    def _errors(self) -> Iterator[automata.Transition]:
        """What follows an error: one of a cancelled goal is none of those that are counted."""
        back = self._goes(EventKind.ERROR, DUE)
        if self.again is None:
            yield back
            return
        again, span = self.again, self.again.span
        if self.wait is not None:
            again = replace(again, goto=f"{self.path} {WAITING}", named=None)
        plain: list[Expr] = []
        if self._has(EventKind.CANCELLED):
            cancelling: Expr = PhaseRef(self.command.key, "cancelling", span)
            yield replace(back, guard=cancelling, span=span)
            plain = [Unary("!", cancelling, _BOOLEAN, span)]
        if self.retries is None or self.given_up is None:
            yield replace(again, guard=_all(plain, span))
            return
        count = self.retries.variable
        assert isinstance(count.type, IntegerType) and count.type.bounds is not None
        read = VariableRef(count.component, count.name, count.type, span)
        last = Literal(count.type.bounds[1], count.type, span)
        more = Binary("+", read, Literal(1, count.type, span), IntegerType(), span)
        fewer = Binary("<", read, last, _BOOLEAN, span)
        counted = automata.Assignment(count.name, more, span=span)
        if not self.retries.keeps(again.goto):
            counted = self.retries.zero(span)
        yield replace(again, guard=_all([*plain, fewer], span), assignments=(counted,))
        none_left = Binary("=", read, last, _BOOLEAN, span)
        yield self._anew(replace(self.given_up, guard=_all([*plain, none_left], span)))

    def _with(
        self, kind: EventKind, performed: Sequence[automata.Transition]
    ) -> list[automata.Transition]:
        """What the state does on an event of its command, with what stands in its braces.

        A transition there without ``goto`` goes along, one with ``goto`` replaces what the state
        does by itself.
        """
        found: list[automata.Transition] = []
        before: list[Expr] = []
        for own in (_known(t) for t in self.own if t.event is kind):
            if own.goto is not None or not performed:
                found.append(self._anew(own) if kind is EventKind.RESPONSE else own)
            else:
                found += (_together(own, other) for other in performed)
            if own.guard is None:
                return found
            before.append(own.guard)
        rest = [_opposite(condition) for condition in before]
        for other in performed:
            guards = [*rest, *(() if other.guard is None else (other.guard,))]
            found.append(replace(other, guard=_all(guards, other.span)))
        return found


def _known(transition: automata.Transition) -> automata.Transition:
    """A transition whose guard is never undefined, so that its opposite is exactly the rest."""
    if transition.guard is None:
        return transition
    return replace(transition, guard=undefined_data.known_condition(transition.guard))


def _together(own: automata.Transition, performed: automata.Transition) -> automata.Transition:
    """Two transitions that are taken as one, with the assignments of both."""
    guards = [guard for guard in (own.guard, performed.guard) if guard is not None]
    assigned = {a.variable for a in own.assignments}
    others = (a for a in performed.assignments if a.variable not in assigned)
    return replace(
        performed,
        guard=_all(guards, own.span),
        assignments=(*own.assignments, *others),
        span=own.span,
    )


def _opposite(condition: Expr) -> Expr:
    if isinstance(condition, Unary) and condition.operator == "!":
        return condition.operand
    assert condition.span is not None
    return Unary("!", condition, _BOOLEAN, condition.span)


def _all(guards: Sequence[Expr], span: source.Span) -> Expr | None:
    return chain("and", guards, span) if guards else None


# --- the count of errors --------------------------------------------------------------------------


def count_of(path: str, node: RetryNode, instance: Instance, via: str | None) -> Retries | None:
    """The count of the errors of a state; None if it tries again for ever.

    ``via`` is the state to which it goes before it tries again.
    """
    if node.times is None:
        return None
    type_ = IntegerType((0, int(node.times.value)))
    variable = automata.Variable(
        f"{path} {RETRIES}", instance.name, type_, 0, False, span=node.span
    )
    outer = dotted.around(path)
    if outer:
        return Retries(variable, (outer,))
    return Retries(variable, (path,) if via is None else (path, via), path)


def with_counts(behaviour: automata.Behaviour, counts: Sequence[Retries]) -> automata.Behaviour:
    """The behaviour with counts that begin anew where their states are left, or entered anew."""
    if not counts:
        return behaviour

    def of(place: str | None, taken: automata.Transition) -> automata.Transition:
        zeros = tuple(c.zero(taken.span) for c in counts if c.begins_anew(place, taken))
        return replace(taken, assignments=(*taken.assignments, *zeros)) if zeros else taken

    changed = behaviour.changed(lambda place, found: tuple(of(place, taken) for taken in found))
    variables = (*behaviour.variables, *(count.variable for count in counts))
    return replace(changed, variables=variables)


# --- where it is performed ------------------------------------------------------------------------


def with_performed(robot: Robot) -> Robot:
    """The robot with requirements on the commands that are performed, which also wait for others.

    If several components perform a command, its request needs one in which it is due. A goal is
    cancelled where no state has it under way.
    """
    added: list[Requirement] = []
    for key in robot.performed:
        if key not in robot.commands:
            continue  # its declaration has an error
        communication = robot.commands[key].communication
        if key in robot.together:
            stages = _asking_stages(robot, key)
            added.append(_needed(robot, key, stages, "is performed in", to_start=True))
        if communication.kind is Kind.ACTION:
            added.append(_needed(robot, key, (PERFORMING,), "goes on in", to_cancel=True))
    robot = replace(robot, requirements=(*robot.requirements, *added))
    return _with_one_at_a_time(robot)


def _with_one_at_a_time(robot: Robot) -> Robot:
    """The robot with requirements on what its states ask for: a component that performs several
    actions has one under way, unless ``meanwhile`` is said.
    """
    asking: dict[tuple[str, str], list[Expr]] = {}
    free = set(robot.together)
    for component in robot.components:
        composites = component.behaviour.composites
        performing = [o for o in composites if o.performs and _is_awaited(robot, o.performs)]
        free.update(o.performs for o in performing if o.performs and o.meanwhile)
        for outer in (o for o in performing if not o.meanwhile):
            for other in dict.fromkeys(o.performs for o in performing):
                assert outer.performs is not None and other is not None
                if _waits_for(robot, outer.performs, other):
                    stages = _asking_stages(robot, outer.performs)
                    asks = [StateRef(component.name, f"{outer.name} {stage}") for stage in stages]
                    asking.setdefault((outer.performs, other), []).extend(asks)
    added = [
        _waiting(robot, key, other, phase, asks if key in free else ())
        for (key, other), asks in asking.items()
        for phase in _UNDER_WAY
    ]
    return replace(robot, requirements=(*robot.requirements, *added))


_UNDER_WAY = {"busy": "which is under way", "cancelling": "which is being cancelled"}


def _is_awaited(robot: Robot, key: str) -> bool:
    """Whether a command is the request of a service or an action, whose declaration is sound."""
    asked = robot.communications.get(key)
    return asked is not None and asked.kind in (Kind.SERVICE, Kind.ACTION)


def _waits_for(robot: Robot, key: str, other: str) -> bool:
    """Whether a command waits for another one: for an action of another server, since one server
    does one thing at a time anyway."""
    one, two = robot.communications[key], robot.communications[other]
    return two.kind is Kind.ACTION and (one.kind, one.ros_name) != (two.kind, two.ros_name)


def _asking_stages(robot: Robot, key: str) -> Sequence[str]:
    """The stages of a state that performs a command in which it may be requested."""
    replaces = robot.commands[key].communication.goals is not None
    return (DUE, PERFORMING) if replaces else (DUE,)


def _waiting(robot: Robot, key: str, other: str, phase: str, asks: Sequence[Expr]) -> Requirement:
    """The requirement that a command waits while another one is in a phase; ``asks`` are the states
    in which it does, none stands for all."""
    span = robot.communications[key].span
    parts: list[Expr] = [chain("or", asks)] if asks else []
    names = robot.display_names
    return Requirement(
        "disables",
        (key,),
        chain("and", [*parts, PhaseRef(other, phase, span)], span),
        f"{names[key]} waits for {names[other]}, {_UNDER_WAY[phase]}",
        to_start=True,
        implied=True,
        span=span,
    )


def _needed(
    robot: Robot,
    key: str,
    stages: Sequence[str],
    what: str,
    *,
    to_start: bool = False,
    to_cancel: bool = False,
) -> Requirement:
    places = robot.performed[key]
    names = errors.listing((f"{component}.{path}" for component, path in places), "or")
    return Requirement(
        "needs",
        (key,),
        chain("or", [StateRef(c, f"{path} {stage}") for c, path in places for stage in stages]),
        f"{robot.display_names[key]} {what} {names}",
        to_start,
        to_cancel=to_cancel,
        implied=True,
        span=robot.commands[key].communication.span,
    )


# Resolution of what states perform: the command, what follows, and what happens after errors.


def find_performed(instance: Instance, symbols: SymbolTable, report: Report) -> None:
    """Resolve the commands that the states of a component perform."""
    groups = GroupResolver(symbols, instance.types.scope, report)
    for path, state in instance.states.items():
        if state.performs is None:
            continue
        access = state.performs.communication
        command = groups.command(access, "performs-outgoing", "no state can perform it", given=True)
        if command is not None:
            instance.performed[path] = command
        for inner in state.states[:1]:
            report.add(
                "states-in-performing",
                inner.name.span,
                f"state '{path}' performs '{access.span.text}', so that no states stand in it",
                "let a state in another one perform it: put this state, and what it performs, into"
                " a state around both",
            )


def performed_data(instance: Instance, resolver: StatementResolver) -> Iterator[Provide]:
    """The data behind ``performs``: those of the command where the state may send it."""
    for path, command in instance.performed.items():
        node = instance.states[path].performs
        assert node is not None
        if node.data is None:
            continue
        statement = nodes.ProvideNode(node.communication, node.data, None, span=node.data.span)
        for provide in resolver.provides(statement):
            stages = (DUE, PERFORMING) if command.replaces else (DUE,)
            sends = [tree.StateRef(instance.name, f"{path} {stage}", node.span) for stage in stages]
            condition = quantified.chain("or", sends, node.span)
            yield replace(provide, communication=command.key, condition=condition)


class PerformingResolver:
    """Resolves the clauses of states that perform, of one component."""

    def __init__(self, instance: Instance, transitions: TransitionResolver, report: Report) -> None:
        self._instance = instance
        self._transitions = transitions
        self._report = report
        self.counts: list[Retries] = []

    def resolve(
        self,
        state: nodes.StateNode,
        path: str,
        own: Sequence[Transition],
        retries: Sequence[nodes.RetryNode],
    ) -> Performing | None:
        """What a state performs; None after an error in its command.

        ``own`` are the transitions in its braces for events of the command.
        """
        node, command = state.performs, self._instance.performed.get(path)
        if node is None or command is None:
            return None
        ends = EventKind.RESPONSE if command.is_awaited else command.command
        done = self._outcome(ends, command, path, node)
        performing = Performing(path, node, command, done, own=list(own))
        spans = self._transitions.event_spans
        for kind in command.events:
            spans.setdefault((node.span.start, kind), node.communication.span)
        for other in retries[1:]:
            note = errors.Note("the first one is here", retries[0].span)
            self._misplaced(other, f"state '{path}' has a 'retry' already", "join them", [note])
        if retries:
            self._retry(performing, retries[0])
        return performing

    def check_retries(self, retries: Iterable[nodes.RetryNode]) -> None:
        """Report each ``retry`` in a state that performs nothing."""
        for node in retries:
            self._misplaced(
                node,
                "'retry' stands in a state that performs a service or an action",
                "write 'performs' and the name of the command behind the name of the state",
            )

    def check_requests(self, named: Iterable[NamedTransition], path: str) -> None:
        """Report what is said about a request, outside of the states that perform it."""
        for new in named:
            transition = new.transition
            if transition.event is not EventKind.REQUEST:
                continue
            key = transition.communication
            places = [p for p, command in self._instance.performed.items() if command.key == key]
            if not places or (path in places and transition.goto is None):
                continue
            name = new.communication.span.text
            if path in places:
                message = f"'goto' stands behind 'then': the state is left when {name} is done"
                hint = "leave out 'goto' here: the state is the same while its command is under way"
            else:
                message = f"{name} is performed in state '{places[0]}': only that state requests it"
                hint = f"let this state perform it: performs {name} then …"
            self._report.add("performed-elsewhere", new.event.span, message, hint)

    def _outcome(
        self,
        event: EventKind,
        command: CommunicationInfo,
        path: str,
        node: nodes.PerformsNode | nodes.RetryNode,
    ) -> Transition:
        """What ``then`` or ``else`` of a node says; without ``goto`` the state begins anew."""
        clauses = node.finally_ if isinstance(node, nodes.RetryNode) else node
        assert clauses is not None
        effect = self._transitions.effect(event, command, clauses)
        transition = replace(effect, span=node.span)
        if transition.goto:
            return transition
        return replace(transition, goto=f"{path} {DUE}", named=path)

    def _retry(self, performing: Performing, node: nodes.RetryNode) -> None:
        command = performing.command
        if not command.is_awaited:
            what = "an answer" if command.sort.served else "a message"
            self._misplaced(
                node,
                f"{command.name} is {what}, which is done when it is sent: it has no errors",
                "leave out 'retry'",
            )
            return
        if (node.times is None) != (node.finally_ is None):
            missing = "'else', and what follows then" if node.finally_ is None else "'times'"
            text = f"'{'times' if node.times else 'else'}' of 'retry' needs {missing}"
            self._misplaced(node, text, "write: retry 2 times else goto failed")
            return
        self._transitions.event_spans[node.span.start, EventKind.ERROR] = node.span
        again = self._transitions.goes(EventKind.ERROR, command.key, node)
        via = again.named or again.goto
        if via in (None, performing.path):  # the state itself goes on: it is not entered anew
            via, again = None, replace(again, goto=f"{performing.path} {DUE}", named=None)
        performing.retries = count_of(performing.path, node, self._instance, via)
        if performing.retries is not None:
            self.counts.append(performing.retries)
        performing.again = again
        if node.every is not None:
            performing.wait = self._wait(node, again)
        if node.finally_ is not None:
            performing.given_up = self._outcome(EventKind.ERROR, command, performing.path, node)

    def _wait(self, node: nodes.RetryNode, again: Transition) -> Transition | None:
        assert node.every is not None
        taken = replace(again, event=EventKind.AFTER, communication=self._instance.name)
        return self._transitions.waits(node.every, "'every'", taken)

    def _misplaced(
        self, node: nodes.RetryNode, message: str, hint: str, notes: Sequence[errors.Note] = ()
    ) -> None:
        self._report.add("misplaced-retry", node.span, message, hint, notes)


def own_transitions(
    named: Iterable[Transition], command: CommunicationInfo
) -> tuple[list[Transition], tuple[Transition, ...]]:
    """The transitions of a place for events of a command, and the others.

    Of an answer, only its being sent is one: the robot may cancel its call meanwhile.
    """
    own: list[Transition] = []
    others: list[Transition] = []
    for transition in named:
        is_own = transition.communication == command.whole_key and (
            not command.sort.served or transition.event is command.command
        )
        (own if is_own else others).append(transition)
    return own, tuple(others)
