"""The check for events that nobody would miss: a message without timeout that forbids a command.

While the link to its sender is cut such a message is lost, or comes when the link is back, and
until then the command goes on. Whether the message changes a state or a variable, directly or by an
internal transition that follows from it, makes no difference. A message that only allows commands
is not told: without it the robot does less. Nor is one that leads a component from one command to
another one: that is an order.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from robosc import errors, remedies
from robosc.expr.traversal import walk
from robosc.expr.tree import Binary, Expr, Literal, PhaseRef, StateRef, Unary, VariableRef
from robosc.language import events
from robosc.model.automata import Behaviour, State, Transition
from robosc.model.diagnostics import Report
from robosc.model.entities import Communication, Robot

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
        if commands:
            names = [robot.display_names[key] for key in commands]
            report.add("stale-event", message.span, *_texts(message.name, names))


def _texts(message: str, commands: list[str]) -> tuple[str, remedies.Remedy]:
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
    for name, behaviour in _behaviours(robot):
        for place, taken in behaviour.placed:
            sources = [state for state in behaviour.states if state.is_in(place)]
            if taken.event is events.EventKind.TAU and taken.guard is not None:
                internal.append((name, sources, taken))
            elif taken.event is events.EventKind.RESPONSE and taken.communication == message.key:
                effect.add(name, sources, taken)
    grown = bool(effect.moves or effect.values)
    while grown:
        grown = False
        for name, sources, taken in internal:
            assert taken.guard is not None
            if _may_fail(robot, taken.guard, False, effect):
                grown |= effect.add(name, sources, taken)
    return effect


def _behaviours(robot: Robot) -> Iterator[tuple[str, Behaviour]]:
    for component in robot.components:
        if component.behaviour is not None:
            yield component.name, component.behaviour


# --- what commands depend on ----------------------------------------------------------------------


def _conditions(robot: Robot) -> dict[str, list[tuple[Expr, bool]]]:
    """What each restricted command asks for, each with what it must come to."""
    found: dict[str, list[tuple[Expr, bool]]] = {}
    for requirement in robot.requirements:
        if not requirement.implied:
            for key in requirement.communications:
                found.setdefault(key, []).append((requirement.condition, not requirement.forbids))
    for name, behaviour in _behaviours(robot):
        enabling = _enabling(behaviour)
        others = {s for key, states in enabling.items() if key != robot.stop for s in states}
        for key, states in enabling.items():
            if name not in robot.together.get(key, ()):
                ref = StateRef(name, "", within=tuple({*states, *others}))
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
