"""What becomes of the commands of another controller, and which messages mean them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from robosc.emit.supervisor.command_recognition import CommandMatch, command_matches
from robosc.language.events import EventKind, Kind
from robosc.model.entities import Robot
from robosc.runtime.values import Undefined
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import Carried, ExactStep, State, Steps


@dataclass(frozen=True)
class Attempt:
    """What becomes of a command: the state ``after`` it, which it changes only if it happens;
    ``set_fields`` are those that a correction sets, by path; ``reasons`` are why it is not allowed,
    as a node tells them (None: that cannot be told)."""

    is_allowed: bool
    after: State
    cases: frozenset[Case]
    set_fields: Mapping[str, Any]
    reasons: tuple[str, ...] | None


def attempted(
    steps: Steps, coverage: Coverage, step: ExactStep, state: State, sent: Carried
) -> Attempt | None:
    """What becomes of a command that carries ``sent``; None if it is no attempt worth showing: the
    end of what has not begun, or a goal that takes the place of another one."""
    try:
        made, fields = steps.made(step, state, sent)
    except Undefined:
        return Attempt(False, state, frozenset(), {}, None)
    is_allowed = coverage.allows(step, state, made)
    if step.event.kind is not EventKind.REQUEST:
        if not is_allowed:
            return None
    elif _kind(steps, step) is Kind.ACTION and step.phase and state[step.phase] != "idle":
        return None
    changes = bool(fields) and steps.follows
    after = step.after(state, sent if changes else made)
    cases = coverage.of_state_of(step, state, made)
    if is_allowed and after is not None and not changes:
        cases |= coverage.of_step(step, state, made, after)
        return Attempt(True, after, frozenset(cases), fields, None)
    reasons = coverage.reasons(step, state, made)
    if is_allowed:
        reasons = None  # of which a monitor tells that it would have been corrected
    if not steps.follows or after is None:
        after = state
    return Attempt(False, after, frozenset(cases), {}, reasons)


def _kind(steps: Steps, step: ExactStep) -> Kind:
    return steps.robot.communications[step.event.key].kind


Meanings = Mapping[str, tuple[Mapping[str, Any], Mapping[str, tuple[Any, ...]], bool]]
"""By key of a command on a shared topic: the fields of a message that means it, by path; which
values some of them may have, or must not have if the last one is false."""


def meanings(robot: Robot) -> Meanings:
    """The messages that mean commands whose topic has several.

    Raises:
        ModelError: their messages cannot be distinguished.
    """
    found: dict[str, tuple[Mapping[str, Any], Mapping[str, tuple[Any, ...]], bool]] = {}
    for matches in command_matches(robot, servers=False).values():
        exact = [leaf for m in matches for data in m.exact for leaf in [dict(_leaves(data))]]
        for match in matches if len(matches) > 1 else ():
            found[match.key] = _meaning(robot, match, exact)
    return found


def _meaning(
    robot: Robot, match: CommandMatch, exact: Iterable[Mapping[str, Any]]
) -> tuple[Mapping[str, Any], Mapping[str, tuple[Any, ...]], bool]:
    if match.exact:
        own = dict(_leaves(match.exact[0]))
        return own, {path: (value,) for path, value in own.items()}, True
    if match.field is not None:
        path = ".".join(match.field[0])
        return {path: match.field[1][0]}, {path: match.field[1]}, True
    path = next((p for data in exact for p in data), "")
    others = tuple(data.get(path, 0) for data in exact)
    return {path: _another(others)} if path else {}, {path: others}, False


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
