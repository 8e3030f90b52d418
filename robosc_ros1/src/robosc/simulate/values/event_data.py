"""What an event carries: from what was typed, or came as JSON, to the parts that the model reads.

A *raw* value is a literal, or for an object a dict of literals by path (``pose.x``, ``ranges[0]``).
Where the model has an enum, both the enum's value and what it converts from may be written.
A *given* value has every part that the model reads, by path; ``()`` is the path of a whole one.
What the plant takes as free, a test of data, may be chosen beside it: ``0.4, "A.x < A.y": true``.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Mapping
from itertools import product
from types import SimpleNamespace
from typing import Any, TypeAlias, cast

from robosc.errors import listing
from robosc.expr import evaluation, tree, types
from robosc.expr.traversal import path_text
from robosc.model.entities import Robot
from robosc.model.typing.compatibility import describe
from robosc.plant.automaton import Event
from robosc.plant.data.terms import type_of_part
from robosc.plant.event_values import is_optional, value_parts, value_type
from robosc.plant.step import Values, missing_together
from robosc.runtime.core.values import Undefined, jsonable
from robosc.simulate.faults import InvalidLine
from robosc.simulate.values.literals import Path, Raw, literal_text
from robosc.simulate.values.typed_values import (
    assembled,
    default_part,
    raw_parts,
    typed_value,
    within_whole,
)

Given: TypeAlias = Mapping[Path, types.Value | None]


def by_path(event: Event, values: Values) -> dict[Path, types.Value | None]:
    """Values of the event's parameters by their paths."""
    return {p.path: value for p, value in zip(event.parameters, values, strict=True)}


def parameter_values(event: Event, given: Given) -> Values:
    """The parts that decide; None for those that are missing, and for tests, which are no parts."""
    return tuple(
        None if is_test(p.path) else part_given(given, p.path, p.type) for p in event.parameters
    )


# --- reading -------------------------------------------------------------------------------------


def complete(robot: Robot, event: Event, raw: Raw, label: str) -> Given:
    """The parts that the model reads, from what was written.

    What decides the next state must be there. What only goes into data that is sent may be left
    out: it is then false, 0 or empty, and an array's element is missing. An optional value may be
    missing altogether.

    Raises:
        InvalidLine: a part is not what the model says it is.
    """
    tests = {}
    if isinstance(raw, dict):
        fails = any(p.path == tree.REASON for p in event.parameters)
        tests = {n: part for n, part in raw.items() if n[:1] == '"' or (fails and n == _REASON)}
    if tests and isinstance(raw, dict):
        others = {name: part for name, part in raw.items() if name not in tests}
        left = others.get("", others or None)
        return {**complete(robot, event, left, label), **dict(_chosen(event, tests, label))}
    type_ = value_type(robot, event)
    if isinstance(type_, types.NoneType):
        if raw is not None:
            raise InvalidLine(f"{label} carries no value")
        return {}
    if is_optional(robot, event) and _has_nothing(raw):
        return dict.fromkeys(value_parts(robot, event))
    if not isinstance(type_, types.ObjectType):
        if raw is None:
            if event.parameters:
                raise InvalidLine(f"{label} needs a value: {hint(robot, event)}")
            return {(): default_part(type_)}
        return {(): typed_value(type_, raw, label)}
    return _complete_object(robot, event, type_, raw, label)


def _chosen(
    event: Event, tests: Mapping[str, Raw], label: str
) -> Iterator[tuple[Path, types.Value | None]]:
    """The outcomes of tests, by the paths that the plant gives them."""
    known = {_test_text(p.path): p for p in event.parameters if p.test or is_test(p.path)}
    for name, raw in tests.items():
        if name not in known:
            names = listing(list(known), "or") if known else "none"
            raise InvalidLine(f"{label} does not ask for {name}; its tests are {names}")
        parameter = known[name]
        missing = raw is None and None in parameter.values
        yield parameter.path, None if missing else typed_value(parameter.type, raw, name)


def is_test(path: Path) -> bool:
    """Whether a path is the name of a test, or of a choice of the environment."""
    return any(isinstance(step, str) and not step.isidentifier() for step in path)


_REASON = "reason"
"""What is written for the reason of an error."""


def _test_text(path: Path) -> str:
    return _REASON if path == tree.REASON else literal_text(str(path[0]), quoted=True)


def _has_nothing(raw: Raw) -> bool:
    return raw is None or (isinstance(raw, dict) and all(part is None for part in raw.values()))


def _complete_object(
    robot: Robot, event: Event, type_: types.ObjectType, raw: Raw, label: str
) -> Given:
    if raw is not None and not isinstance(raw, dict):
        raise InvalidLine(f"{label} carries {describe(type_)}: write its parts, x: 0.4, y: 2")
    fields = raw_parts(raw or {}, type_, label)
    for whole, path in product(fields, fields):
        within = whole == path[: len(whole)] != path
        if within and _written({whole: fields[whole]}, path) != fields[path]:
            raise InvalidLine(
                f"{path_text(path)} of {label} is not what {path_text(whole)} has there"
            )
    needed = {parameter.path for parameter in event.parameters}
    given: dict[Path, types.Value | None] = {}
    for path, part in value_parts(robot, event).items():
        name = f"{path_text(path)} of {label}"
        written = _written(fields, path)
        if written is not None:
            given[path] = typed_value(part, written, name)
        elif _is_element(path) and not any(p[: len(path)] == path != p for p in fields):
            given[path] = None
        elif isinstance(part, types.ArrayType | types.ObjectType) and path not in fields:
            given[path] = assembled(part, path, fields, name)
        elif path in needed:
            raise InvalidLine(f"{name} needs a value: {_choices(part)}")
        else:
            given[path] = default_part(part)
    if robot.supervises and event.kind.sent:
        given.update(_passed_on(type_, fields, given, label))
    values = parameter_values(event, given)
    for i, j in missing_together(event):
        if values[i] is None and values[j] is not None:
            first, second = (path_text(event.parameters[n].path) for n in (i, j))
            raise InvalidLine(f"{second} of {label} cannot be there where {first} is missing")
    return given


def _passed_on(
    type_: types.ObjectType, fields: Mapping[Path, Raw], given: Given, label: str
) -> Iterator[tuple[Path, types.Value]]:
    """The parts of what another controller sends that nothing reads: they are sent as they are."""
    for path, raw in fields.items():
        part = type_of_part(type_, path)
        known = any(path[: len(other)] == other or other[: len(path)] == path for other in given)
        if part is not None and raw is not None and not known:
            yield path, typed_value(part, raw, f"{path_text(path)} of {label}")


def _is_element(path: Path) -> bool:
    """Whether it is in an element of an array, which may be missing."""
    return any(isinstance(step, int) for step in path)


def _written(fields: Mapping[Path, Raw], path: Path) -> Raw:
    """What was written for a part, or within a whole; None if nothing was."""
    longest = max((p for p in fields if path[: len(p)] == p), key=len, default=path)
    raw = fields.get(longest)
    for step in path[len(longest) :]:
        if isinstance(raw, dict) and isinstance(step, str):
            raw = raw.get(step)
        elif isinstance(raw, list) and isinstance(step, int) and step < len(raw):
            raw = raw[step]
        else:
            return None
    return raw


def outer_parts(
    robot: Robot, event: Event, decided: Collection[Path] = ()
) -> dict[Path, types.Type]:
    """The parts that are read and hold none that are decided, but what lies within another one."""
    outer: dict[Path, types.Type] = {}
    for path, part in sorted(value_parts(robot, event).items(), key=lambda item: len(item[0])):
        within = any(path[: len(other)] == other for other in outer)
        if not within and not any(path == other[: len(path)] for other in decided):
            outer[path] = part
    return outer


# --- words ---------------------------------------------------------------------------------------


def hint(robot: Robot, event: Event) -> str:
    """What may be written as the event's value; empty if it carries none."""
    reason = next((p.type for p in event.parameters if p.path == tree.REASON), None)
    also = "" if reason is None else f"{_REASON}: {_words(reason)}"
    type_ = value_type(robot, event)
    if isinstance(type_, types.NoneType):
        return also
    choices = _choices(type_)
    if isinstance(type_, types.ObjectType):
        choices = ", ".join(
            f"{path_text(path)}: {_choices(part)}" if path else _choices(part)
            for path, part in outer_parts(robot, event).items()
        )
    choices = f"{choices}, or missing" if is_optional(robot, event) else choices
    return f"{choices}; {also}" if also else choices


def _words(type_: types.Type) -> str:
    return listing(type_.values, "or") if isinstance(type_, types.EnumType) else str(type_)


def _choices(type_: types.Type) -> str:
    match type_:
        case types.BooleanType():
            return "true or false"
        case types.IntegerType(bounds=(low, high)):
            return f"{low}..{high}"
        case types.EnumType(values=values, source=source):
            return f"{listing(values, 'or')} ({source})"
    return str(type_)


def given_text(given: Given) -> str:
    """``free``; ``x: 1.0, kind: free``; empty for no value."""
    tests = {path: value for path, value in given.items() if is_test(path)}
    chosen = [f"{_test_text(path)}: {literal_text(value)}" for path, value in tests.items()]
    if () in given and not _is_object(given[()]):
        return ", ".join([literal_text(given[()]), *chosen])
    parts = {path: value for path, value in given.items() if path not in tests}
    flat = {leaf: v for path, value in parts.items() for leaf, v in _leaves(path, value)}
    texts = [f"{path_text(path)}: {literal_text(v)}" for path, v in flat.items()]
    return ", ".join([*texts, *chosen])


def _is_object(value: Any) -> bool:
    return isinstance(value, SimpleNamespace)


def _leaves(path: Path, value: types.Value | None) -> Iterator[tuple[Path, types.Value | None]]:
    """The members of an object, down to those that are none."""
    if not _is_object(value):
        yield path, value
        return
    for name, inner in vars(value).items():
        yield from _leaves((*path, name), inner)


def part_given(given: Given, path: Path, type_: types.Type) -> types.Value | None:
    """A part that came by itself, or with a whole; None if it is not there."""
    if path in given:
        return given[path]
    for length in range(len(path) - 1, -1, -1):
        whole = given.get(path[:length])
        if whole is not None:
            try:
                part = evaluation.part_of_value(whole, path[length:])
            except Undefined:
                return None
            return evaluation.converted(type_, part) if isinstance(type_, types.EnumType) else part
        if path[:length] in given:
            return None
    return None


def given_json(given: Given) -> Any:
    """As in the documents of a running controller: a literal, parts by path, or None."""
    if not given:
        return None
    if () in given and not _is_object(given[()]):
        return jsonable(given[()])
    names = ((_REASON if path == tree.REASON else path_text(path), v) for path, v in given.items())
    return {name: jsonable(value) for name, value in names}


# Values of events that nobody typed: drawn at random, or filled up around what decides.


def random_raw(robot: Robot, event: Event, rng: random.Random) -> Raw:
    """Some value that the event can carry."""
    type_ = value_type(robot, event)
    if isinstance(type_, types.NoneType) or (is_optional(robot, event) and rng.random() < 0.5):
        return None
    if not isinstance(type_, types.ObjectType):
        return _random(type_, rng)
    return {path_text(path): _random(part, rng) for path, part in outer_parts(robot, event).items()}


def completed(
    robot: Robot, event: Event, decided: Given, label: str, rng: random.Random | None = None
) -> Given:
    """All parts that the model reads where those that decide are known, and tests.

    The others are drawn, or as by default without ``rng``; wholes are made of their parts.
    """
    parts = {path: cast(Raw, value) for path, value in decided.items() if not is_test(path)}
    raw: Raw = None
    if () in parts:
        raw = parts[()]
    elif parts:
        raw = {path_text(path): value for path, value in parts.items()}
        if rng is not None:
            raw.update(
                (path_text(p), _random(part, rng))
                for p, part in outer_parts(robot, event, parts).items()
            )
    elif rng is not None:
        raw = random_raw(robot, event, rng)
    try:
        return {**complete(robot, event, raw, label), **decided}
    except InvalidLine:
        return decided  # what only tests read is not needed


def _random(type_: types.Type, rng: random.Random) -> Raw:
    match type_:
        case types.ArrayType(element=element):
            return [_random(within_whole(element), rng) for _ in range(rng.randint(0, 5))]
        case types.ObjectType(properties=properties):
            return {name: _random(within_whole(inner), rng) for name, inner in properties}
        case types.BooleanType():
            return rng.random() < 0.5
        case types.IntegerType(bounds=bounds):
            return rng.randint(*(bounds or (-100, 100)))
        case types.DoubleType():
            return round(rng.uniform(-100.0, 100.0), 2)
        case types.EnumType(values=values):
            return rng.choice(values)
    return rng.choice(("a", "b"))
