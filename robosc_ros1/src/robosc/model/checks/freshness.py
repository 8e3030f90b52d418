"""The check for stale data: commands that use the last value of a message that may be silent.

Only data can be stale: a message that changes states is an event. A command that consumes the
message (the variable's component enables it only when the message has come, and its request leads
to a state in which it is disabled) is sent once for each message, and so never with stale data.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from robosc import errors, remedies, source
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import reads_value, walk, walk_all
from robosc.expr.tree import Binary, Expr, Literal, PhaseRef, StateRef, Unary, VariableRef
from robosc.language import events
from robosc.language.events import EventKind, Kind, command_key
from robosc.model import automata, diagnostics, entities
from robosc.model.automata import Behaviour, State, Transition
from robosc.model.diagnostics import Report
from robosc.model.entities import Communication, Robot

# The check for events that nobody would miss: a message without timeout that forbids a
# command. While the link to its sender is cut such a message is lost, or comes when the link
# is back, and until then the command goes on. Whether the message changes a state or a
# variable, directly or by an internal transition that follows from it, makes no difference. A
# message that only allows commands is not told: without it the robot does less. Nor is one
# that leads a component from one command to another one: that is an order.


_ANY = object()
"""A value that is not known."""


@dataclass
class _Effect:
    """What a message may change: from which states to which, and to what variables."""

    moves: set[tuple[str, str, str]] = field(default_factory=set)
    values: dict[str, list[object]] = field(default_factory=dict)

    def add(self, component: str, sources: Iterable[State], taken: Transition) -> bool:
        """Add what a transition does in these states; whether that is new."""
        before = len(self.moves), sum(map(len, self.values.values()))
        if taken.goto is not None:
            self.moves |= {(component, s.name, taken.goto) for s in sources if s.name != taken.goto}
        for assignment in taken.assignments:
            literal = isinstance(assignment.value, Literal)
            value = assignment.value.value if isinstance(assignment.value, Literal) else _ANY
            known = self.values.setdefault(f"{component}.{assignment.variable}", [])
            if value not in known and (literal or _ANY not in known):
                known.append(value)
        return before != (len(self.moves), sum(map(len, self.values.values())))


def check_stale_events(robot: Robot, told: Mapping[str, set[str]], report: Report) -> None:
    """Warn of commands that a message without timeout forbids.

    ``told`` are the commands of which ``stale-data`` tells, by the key of the message.
    """
    conditions = _conditions(robot)
    reported = set()  # copies of a message are reported once, if it is of the same commands
    for message in robot.communications.values():
        if message.kind is not events.Kind.OUTGOING or message.timeout is not None:
            continue
        effect = _effect(robot, message)
        commands = [
            key
            for key, wanted in conditions.items()
            if key != robot.stop
            and key not in told.get(message.key, ())
            and any(_may_fail(robot, expr, holds, effect) for expr, holds in wanted)
        ]
        names = tuple(robot.display_names[key] for key in commands)
        if names and (message.span, names) not in reported:
            reported.add((message.span, names))
            name = robot.display_names[message.key]
            report.add("stale-event", message.span, *_event_texts(name, names))


def _event_texts(message: str, commands: Sequence[str]) -> tuple[str, remedies.Remedy]:
    first, *others = commands
    go, them = ("go", "them") if others else ("goes", "it")
    return (
        f"{errors.listing(commands)} {go} on where a message of {message} is lost that forbids"
        f" {them}, as while a link is cut",
        remedies.Remedy(
            f"let {message} be repeated, also by a latched publisher, give it a"
            f" 'timeout: 1 s,' and add 'requirement {first} needs {message}.fresh'"
            + (f", or for {errors.listing(others)}" if others else ""),
            remedies.Change.ADD_FRESHNESS,
            (message, "timeout: 1 s,", *commands),
        ),
    )


# --- what a message does --------------------------------------------------------------------------


def _effect(robot: Robot, message: Communication) -> _Effect:
    """What a message changes, with the internal transitions that may follow from it."""
    effect = _Effect()
    internal: list[tuple[str, list[State], Transition]] = []
    for component in robot.components:
        for place, taken in component.behaviour.placed:
            sources = [state for state in component.states if state.is_in(place)]
            if taken.event is events.EventKind.TAU and taken.guard is not None:
                internal.append((component.name, sources, taken))
            elif taken.event is events.EventKind.RESPONSE and taken.communication == message.key:
                effect.add(component.name, sources, taken)
    grown = bool(effect.moves or effect.values)
    while grown:
        grown = False
        for name, sources, taken in internal:
            assert taken.guard is not None
            if _may_fail(robot, taken.guard, False, effect):
                grown |= effect.add(name, sources, taken)
    return effect


# --- what commands depend on ----------------------------------------------------------------------


def _conditions(robot: Robot) -> dict[str, list[tuple[Expr, bool]]]:
    """What each restricted command asks for, each with what it must come to."""
    found: dict[str, list[tuple[Expr, bool]]] = {}
    for requirement in robot.requirements:
        if not requirement.implied:
            for key in requirement.communications:
                found.setdefault(key, []).append((requirement.condition, not requirement.forbids))
    for component in robot.components:
        enabling = _enabling(component.behaviour)
        others = {s for key, states in enabling.items() if key != robot.stop for s in states}
        for key, states in enabling.items():
            if component.name not in robot.together.get(key, ()):
                ref = StateRef(component.name, "", within=tuple({*states, *others}))
                found.setdefault(key, []).append((ref, True))
    kinds = {key: command.kind for key, command in robot.commands.items()}
    return {key: wanted for key, wanted in found.items() if kinds[key].restricted}


def _enabling(behaviour: Behaviour) -> dict[str, list[str]]:
    """The states in which a component takes a command, of those that it mentions."""
    found: dict[str, list[str]] = {}
    for place, taken in behaviour.placed:
        if taken.event.sent:
            key = events.command_key(taken.communication, taken.event)
            states = (state.name for state in behaviour.states if state.is_in(place))
            found.setdefault(key, []).extend(states)
    return found


def _may_fail(robot: Robot, expr: Expr, wanted: bool, effect: _Effect) -> bool:
    """Whether a message may change a condition that comes to ``wanted`` into one that does not.

    It may if it changes one of the parts in that direction, whatever the others are.
    """
    match expr:
        case Unary(operator="!", operand=operand):
            return _may_fail(robot, operand, not wanted, effect)
        case Binary(operator="and" | "or"):
            return any(_may_fail(robot, o, wanted, effect) for o in expr.operands)
        case Binary(operator="=>"):
            left = _may_fail(robot, expr.left, not wanted, effect)
            return left or _may_fail(robot, expr.right, wanted, effect)
        case StateRef(component=name):
            lasting = next((one for one in robot.lasting if one.name == name), None)
            if lasting is not None:
                return _may_fail(robot, lasting.condition, wanted, effect)
            here = expr.places
            return any(
                (source in here) is wanted and (target in here) is not wanted
                for component, source, target in effect.moves
                if component == name
            )
        case VariableRef():
            return any(
                value is _ANY or value is not wanted for value in effect.values.get(expr.key, ())
            )
        case Binary(operator="=" | "!=", left=VariableRef() as left, right=Literal(value=right)):
            holds = wanted is (expr.operator == "=")
            values = effect.values.get(left.key, ())
            return any(value is _ANY or (value == right) is not holds for value in values)
        case Literal() | PhaseRef():
            return False
    return any(isinstance(leaf, VariableRef) and leaf.key in effect.values for leaf in walk(expr))


_FRESH = ("fresh", "heard")


def check_freshness(robot: entities.Robot, report: diagnostics.Report, *, library: bool) -> None:
    """Warn of commands whose requirements or data read values that may be stale, or, in a robot,
    that would go on if a message is lost.
    """
    communications, names = robot.communications, robot.display_names
    messages = _lasting_messages(robot.components, communications)
    lasting = {one.name: one.condition for one in robot.lasting}
    behaviours = {c.name: c.behaviour for c in robot.components}
    stale: dict[str, dict[str, VariableRef]] = defaultdict(dict)
    told: dict[str, set[str]] = defaultdict(set)
    known: IdentityCache[tuple[bool, tuple[VariableRef, ...]]] = IdentityCache()
    for command, expressions in _read_by_commands(robot).items():
        # Copies share their conditions.
        read = [known.of(expr, partial(_read, lasting=lasting)) for expr in expressions]
        if any(names_freshness for names_freshness, _ in read):
            continue
        for ref in (ref for _, refs in read for ref in refs):
            message = messages.get(ref.key)
            behaviour = behaviours[ref.component]
            if message is not None and not _uses_up(behaviour, command, message.key):
                stale[message.key][names[command]] = ref
                told[message.key].add(command)
                break  # one warning for each command: naming any freshness silences it
    reported: set[source.Span] = set()  # copies of a statement are reported once
    for key, commands in stale.items():
        span = next(iter(commands.values())).span
        if span is not None and span not in reported:
            reported.add(span)
            message = communications[key]
            note = errors.Note(f"{message.name} is declared here", message.span)
            report.add("stale-data", span, *_texts(commands, names[key]), [note])
    if not library:
        check_stale_events(robot, told, report)


def _read_by_commands(robot: entities.Robot) -> dict[str, list[Expr]]:
    """The conditions and data of each command, by its key."""
    found: dict[str, list[Expr]] = defaultdict(list)
    for requirement in robot.requirements:
        for key in requirement.communications:
            found[key].append(requirement.condition)
    for provide in robot.provides:
        if not robot.commands[provide.communication].kind.restricted:
            continue  # nothing keeps an error from being sent
        found[provide.communication] += provide.expressions
    return found


def _read(expr: Expr, lasting: Mapping[str, Expr]) -> tuple[bool, tuple[VariableRef, ...]]:
    """Whether an expression asks for the freshness of a message, and the variables it reads.

    ``lasting`` are the conditions that must have held for some time, by name.
    """
    parts = list(walk_all([expr]))
    for part in parts:
        if isinstance(part, StateRef) and part.component in lasting:
            parts += walk_all([lasting[part.component]])
    names_freshness = any(isinstance(part, PhaseRef) and part.phase in _FRESH for part in parts)
    return names_freshness, tuple(part for part in parts if isinstance(part, VariableRef))


def _texts(commands: Mapping[str, VariableRef], message: str) -> tuple[str, remedies.Remedy]:
    """The message, and the hint with the two edits that mend it for one of the commands."""
    (first, ref), *_ = commands.items()
    others = ", ".join(list(commands)[1:])
    do = "do" if len(commands) > 2 else "does"
    return (
        f"{first} keeps using the last value of {ref.component}.{ref.variable}"
        f" if {message} falls silent" + (f", and so {do} {others}" if others else ""),
        remedies.Remedy(
            f"give {message} a 'timeout: 500 ms,' and add"
            f" 'requirement {first} needs {message}.fresh'"
            + (f", or for {others}" if others else ""),
            remedies.Change.ADD_FRESHNESS,
            (message, "timeout: 500 ms,", *commands),
        ),
    )


def _lasting_messages(
    components: Sequence[entities.Component], communications: Mapping[str, entities.Communication]
) -> dict[str, entities.Communication]:
    """The variables that only messages without timeout assign, each with one such message."""
    found: dict[str, entities.Communication] = {}
    others: set[str] = set()
    for component in components:
        for transition in component.transitions:
            message = communications.get(transition.communication)
            lasting = (
                transition.event is EventKind.RESPONSE
                and message is not None
                and message.kind is Kind.OUTGOING
                and message.timeout is None
            )
            for assignment in transition.assignments:
                key = f"{component.name}.{assignment.variable}"
                if not lasting:
                    others.add(key)
                elif message is not None and reads_value(assignment.value):
                    found.setdefault(key, message)
    return {key: message for key, message in found.items() if key not in others}


def _uses_up(behaviour: automata.Behaviour, command: str, message: str) -> bool:
    """Whether a command is enabled only after the message came, and disabled by its request.

    A request that failed or was cancelled may be repeated.
    """
    targets = {state.name: _targets(behaviour, state.name, command) for state in behaviour.states}
    enabled = {name for name, found in targets.items() if found}
    left = all(
        goto is not None and goto not in enabled for name in enabled for goto in targets[name]
    )
    at_first = any(state.initial and state.name in enabled for state in behaviour.states)
    entries = {(t.event, t.communication) for t in behaviour.all_transitions if t.goto in enabled}
    entries -= {
        (EventKind.RESPONSE, message), (EventKind.ERROR, command), (EventKind.CANCEL, command)
    }  # fmt: skip
    return bool(enabled) and left and not (at_first or entries)


def _targets(behaviour: automata.Behaviour, name: str, command: str) -> list[str | None]:
    """The targets of a command's requests in a state; None is a self-loop."""
    state = next(state for state in behaviour.states if state.name == name)
    levels = (
        [t.goto for t in level if t.event.sent and command_key(t.communication, t.event) == command]
        for level in behaviour.levels(state)
    )
    return next(filter(None, levels), [])
