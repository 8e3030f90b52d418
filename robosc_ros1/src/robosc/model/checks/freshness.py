"""The check for stale data: commands that use the last value of a message that may be silent.

Only data can be stale: a message that changes states is an event. A command that consumes the
message (the variable's component enables it only when the message has come, and its request leads
to a state in which it is disabled) is sent once for each message, and so never with stale data.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import partial

from robosc import errors, remedies, source
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import reads_value, walk_all
from robosc.expr.tree import Expr, PhaseRef, StateRef, VariableRef
from robosc.language.events import EventKind, Kind, command_key
from robosc.model import automata, diagnostics, entities
from robosc.model.checks.stale_events import check_stale_events

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
            if message is not None and behaviour and not _uses_up(behaviour, command, message.key):
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
        if provide.condition is not None:
            found[provide.communication].append(provide.condition)
        found[provide.communication] += entities.data_expressions(provide.data)
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
