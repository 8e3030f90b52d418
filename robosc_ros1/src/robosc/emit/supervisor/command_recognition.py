"""What a supervisor needs to know of the messages that it lets pass: which command each one means.

Where one topic carries several commands, a message has only its data to say which it means. A
command whose provide statements all give constants (a stop: all speeds 0) means just these
messages, every other field at its default; so does the command of ``stop with`` that has none, at
all defaults: this is what the stop sends. Of the other commands on the topic, one may mean all the
rest; if there are more, those without provide statements mean the message with all defaults, and
the others must have a field that each of them gives constant values, no value twice.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from robosc.errors import ModelError, Note
from robosc.expr import evaluation, traversal
from robosc.expr.tree import Binary, Expr, Literal, Unary
from robosc.expr.types import ArrayType, ObjectType, Value
from robosc.language.events import Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model import diagnostics, entities

Path = tuple[str, ...]
Constants = Mapping[Path, Value]


@dataclass(frozen=True)
class CommandMatch:
    """How messages that mean one command are known.

    ``exact`` are the data of all of them, as the template writes them; ``field`` is the path of a
    field and the values that it has in them. Neither: whatever means no other command.
    """

    key: str
    exact: tuple[Mapping[str, object], ...] = ()
    field: tuple[Path, tuple[Value, ...]] | None = None


@dataclass(frozen=True)
class _Provided:
    """The constant fields of one provide statement, and whether all of its fields are."""

    constants: Constants
    complete: bool


def command_matches(
    robot: entities.Robot, servers: bool = True
) -> dict[tuple[str, str], tuple[CommandMatch, ...]]:
    """By topic and type (``package/Type``), in model order. ``servers``: requests are passed on,
    too.

    Raises:
        ModelError: messages of one topic cannot be distinguished by data, or the robot sends on
            it, too; or two services or actions have one name.
    """
    report = diagnostics.Report()
    topics: dict[tuple[str, str], list[entities.Communication]] = {}
    for communication in robot.communications.values():
        if communication.kind is Kind.INCOMING:
            binding = communication.binding
            place = (communication.ros_name, f"{binding.package}/{binding.type}")
            topics.setdefault(place, []).append(communication)
    found: dict[tuple[str, str], tuple[CommandMatch, ...]] = {}
    _check_directions(robot, report)
    if servers:
        _check_servers(robot, report)
    for (_, type_), messages in topics.items():
        place = messages[0].identifier, type_
        if len(messages) == 1:
            found[place] = (CommandMatch(messages[0].key),)
        else:
            found[place] = tuple(_told_apart(messages, robot, report))
    if report.has_errors:
        raise ModelError(report.diagnostics)
    return found


def _check_directions(robot: entities.Robot, report: diagnostics.Report) -> None:
    """A topic that both robot and supervisor publish would send each message back for ever."""
    sent = {c.ros_name: c for c in robot.communications.values() if c.kind is Kind.OUTGOING}
    for message in robot.communications.values():
        other = sent.get(message.ros_name)
        if message.kind is Kind.INCOMING and other is not None:
            report.add(
                "topic-both-ways",
                message.span,
                f"robot and controller both send on the topic '{message.identifier}'",
                "give them a topic each",
                [Note("the robot sends on it here", other.span)],
            )


def _check_servers(robot: entities.Robot, report: diagnostics.Report) -> None:
    """To the controller, a supervisor is one server where the robot is one."""
    names = robot.display_names
    servers: dict[tuple[Kind, str], entities.Communication] = {}
    for one in robot.communications.values():
        other = servers.setdefault((one.kind, one.ros_name), one)
        if one.kind in (Kind.SERVICE, Kind.ACTION) and other is not one:
            report.add(
                "commands-alike",
                one.span,
                f"a supervisor cannot distinguish '{names[one.key]}' from '{names[other.key]}':"
                f" both are requests of the {one.kind.value} '{one.identifier}'",
                f"declare the {one.kind.value} once, or give one of them a name of its own",
                [Note(f"the other {one.kind.value} is here", other.span)],
            )


def _told_apart(
    messages: Sequence[entities.Communication], robot: entities.Robot, report: diagnostics.Report
) -> Iterator[CommandMatch]:
    provided = {m.key: list(_provided(m, robot)) for m in messages}
    corrected = [m for m in messages if m.key in robot.corrected]
    if corrected:
        yield from _beside_corrected(messages, corrected, provided, robot, report)
        return
    if provided.get(robot.stop or "") == []:
        provided[robot.stop or ""] = [_Provided({}, True)]  # else what is too fast would mean it
    without = [m for m in messages if not provided[m.key]]
    exact = [m for m in messages if m not in without and all(p.complete for p in provided[m.key])]
    if len(exact) + 1 < len(messages):
        # One alone could mean the rest; of several, these carry the defaults, as ``with {}`` does.
        provided |= {m.key: [_Provided({}, True)] for m in without}
        exact += without
    others = [m for m in messages if m not in exact]
    seen: dict[tuple[tuple[Path, Value], ...], entities.Communication] = {}
    for message in exact:
        for part in provided[message.key]:
            content = tuple(sorted((p, v) for p, v in part.constants.items() if v not in (0, "")))
            other = seen.setdefault(content, message)
            if other is not message:
                _refuse(message, other, "they can carry the same data", robot, report)
        yield CommandMatch(message.key, exact=tuple(_nested(p) for p in provided[message.key]))
    if len(others) == 1:
        yield CommandMatch(others[0].key)
    elif others:
        yield from _by_field(others, provided, robot, report)


def _beside_corrected(
    messages: Sequence[entities.Communication],
    corrected: Sequence[entities.Communication],
    provided: Mapping[str, list[_Provided]],
    robot: entities.Robot,
    report: diagnostics.Report,
) -> Iterator[CommandMatch]:
    """Messages beside one that is corrected, which takes what no constants of another match."""
    for message in messages:
        if message is corrected[0]:
            yield CommandMatch(message.key)
        elif message in corrected:
            _refuse(message, corrected[0], "both are corrected", robot, report)
        elif all(part.complete for part in provided[message.key]):
            parts = provided[message.key] or [_Provided({}, True)]
            yield CommandMatch(message.key, exact=tuple(map(_nested, parts)))
        else:
            reason = "only constants tell a message from one that is corrected"
            _refuse(message, corrected[0], reason, robot, report)


def _by_field(
    messages: Sequence[entities.Communication],
    provided: Mapping[str, list[_Provided]],
    robot: entities.Robot,
    report: diagnostics.Report,
) -> Iterator[CommandMatch]:
    """Messages with changing data, by a field that is constant in all of them."""
    for path in dict.fromkeys(
        p for m in messages for part in provided[m.key] for p in part.constants
    ):
        values = {m.key: {part.constants.get(path) for part in provided[m.key]} for m in messages}
        every = [v for found in values.values() for v in found]
        if None not in every and all(values.values()) and len(set(every)) == len(every):
            for message in messages:
                kept = dict.fromkeys(part.constants[path] for part in provided[message.key])
                yield CommandMatch(message.key, field=(path, tuple(kept)))
            return
    reason = "no field has a different constant in the data of each"
    _refuse(messages[1], messages[0], reason, robot, report)


def _refuse(
    message: entities.Communication,
    other: entities.Communication,
    reason: str,
    robot: entities.Robot,
    report: diagnostics.Report,
) -> None:
    names = robot.display_names
    report.add(
        "commands-alike",
        message.span,
        f"a supervisor cannot distinguish '{names[message.key]}' from '{names[other.key]}'"
        f" on the topic '{message.identifier}': {reason}",
        "provide constant data for one of them, or give it a topic of its own",
        [Note("the other message is here", other.span)],
    )


# --- what provide statements say -----------------------------------------------------------------


def _provided(message: entities.Communication, robot: entities.Robot) -> Iterator[_Provided]:
    for provide in robot.provides:
        if provide.communication == message.key:
            fields = list(leaves(provide.data, message))
            known = {path: _constant(e) for path, e in fields if e is not None and _is_constant(e)}
            # What is no number is equal to nothing that comes.
            constants = {path: value for path, value in known.items() if value == value}
            yield _Provided(constants, len(constants) == len(fields))


def leaves(
    data: entities.Data, message: entities.Communication, path: Path = ()
) -> Iterator[tuple[Path, Expr | None]]:
    """Yield the expressions for all fields of a message, by path; None for what is no constant to
    compare with as a whole."""
    if isinstance(data, entities.DataObject):
        for name, part in data.fields:
            yield from leaves(part, message, (*path, name))
    elif isinstance(data, entities.DataArray) or isinstance(data.type, ArrayType | ObjectType):
        yield path, None
    else:
        yield path or (message.binding.request_field or "",), data


def _is_constant(expr: Expr) -> bool:
    return all(isinstance(part, Literal | Unary | Binary) for part in traversal.walk(expr))


def _constant(expr: Expr) -> Value:
    return evaluation.evaluate(expr, lambda leaf: None)


def _nested(part: _Provided) -> Mapping[str, object]:
    tree: dict[str, object] = {}
    for path, value in part.constants.items():
        inner = tree
        for name in path[:-1]:
            below = inner.setdefault(name, {})
            assert isinstance(below, dict)
            inner = below
        inner[path[-1]] = value
    return tree
