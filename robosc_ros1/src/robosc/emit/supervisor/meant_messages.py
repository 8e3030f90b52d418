"""Messages that mean commands whose topic has several, for who sends them in a test."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from robosc.emit.supervisor.command_recognition import CommandMatch, command_matches, leaves
from robosc.expr.types import BooleanType, DoubleType, IntegerType, StringType, Type
from robosc.model.entities import Robot

_DEFAULTS: dict[type[Type], Any] = {
    BooleanType: False,
    IntegerType: 0,
    DoubleType: 0.0,
    StringType: "",
}
Meanings = Mapping[str, tuple[Mapping[str, Any], Mapping[str, tuple[Any, ...]], bool]]
"""By key of a command on a shared topic: the fields of a message that means it, by path; which
values some of them may have, or must not have if the last one is false."""


def meanings(robot: Robot, servers: bool = False) -> Meanings:
    """The messages that mean commands whose topic has several; ``servers`` is as in
    :func:`.command_recognition.command_matches`.

    Raises:
        ModelError: their messages cannot be distinguished.
    """
    found: dict[str, tuple[Mapping[str, Any], Mapping[str, tuple[Any, ...]], bool]] = {}
    for matches in command_matches(robot, servers).values():
        exact = [leaf for m in matches for data in m.exact for leaf in [dict(_leaves(data))]]
        for match in matches if len(matches) > 1 else ():
            found[match.key] = _meaning(robot, match, exact)
    return found


def meant(robot: Robot) -> dict[str, dict[str, Any]]:
    """The fields of a message that means a command, by its key and by path."""
    return {key: dict(fields) for key, (fields, _, _) in meanings(robot).items() if fields}


def _meaning(
    robot: Robot, match: CommandMatch, exact: Iterable[Mapping[str, Any]]
) -> tuple[Mapping[str, Any], Mapping[str, tuple[Any, ...]], bool]:
    if match.exact:
        own = dict(_leaves(match.exact[0]))
        return own, {path: (value,) for path, value in own.items()}, True
    if match.field is not None:
        path = ".".join(match.field[0])
        return {path: match.field[1][0]}, {path: match.field[1]}, True
    given = dict(_given(robot, match.key))
    path = next((p for data in exact for p in data), next(iter(given), ""))
    others = tuple(data.get(path, given.get(path, 0)) for data in exact)
    return {path: _another(others)} if path else {}, {path: others}, False


def _given(robot: Robot, key: str) -> Iterator[tuple[str, Any]]:
    """The fields that provide statements give a command, with their defaults."""
    for provide in robot.provides:
        if provide.communication == key:
            for path, expr in leaves(provide.data, robot.communications[key]):
                if expr is not None and type(expr.type) in _DEFAULTS:
                    yield ".".join(path), _DEFAULTS[type(expr.type)]


def _another(values: tuple[Any, ...]) -> Any:
    """A value that is none of these."""
    if isinstance(values[0], bool):
        return not values[0]
    if isinstance(values[0], str):
        return "".join(map(str, values)) + "other"
    return max(abs(value) for value in values) + type(values[0])(1)


def is_meant(meanings: Meanings, key: str, raw: Any) -> bool:
    """Whether a message with raw data, beside those that mean a command, still means it."""
    if key not in meanings:
        return True
    _, values, is_one = meanings[key]
    parts = raw if isinstance(raw, dict) else {} if raw is None else {"data": raw}
    return all((parts[p] in values[p]) is is_one for p in parts if p in values)


def _leaves(data: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in data.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{path}{name}.")
        else:
            yield path + name, value
