"""What an event carries: from what was typed, or came as JSON, to the parts that the model reads.

A *raw* value is a literal, or for an object a dict of literals by path (``pose.x``, ``ranges[0]``).
Where the model has an enum, both the enum's value and what it converts from may be written.
A *given* value has every part that the model reads, by path; ``()`` is the path of a whole one.
What the plant takes as free, a test of data, may be chosen beside it: ``0.4, "A.x < A.y": true``.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from itertools import product
from types import SimpleNamespace
from typing import Any, TypeAlias, cast

from robosc.errors import listing
from robosc.ir.automaton import Event, is_optional, value_parts, value_type
from robosc.ir.finite.terms import type_of_part
from robosc.ir.formulas import Leaf
from robosc.ir.step import Values, is_true, missing_together
from robosc.model.compatibility import default_value, describe
from robosc.model.entities import Robot
from robosc.model.evaluation import part_of_value
from robosc.model.expr import ValueRef, condition_of
from robosc.model.traversal import path_text
from robosc.model.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
    Value,
)
from robosc.runtime.values import Undefined, jsonable
from robosc.simulate.faults import InvalidLine
from robosc.simulate.literals import Path, Raw, literal_text, path_in

__all__ = [
    "Given",
    "Path",
    "by_path",
    "complete",
    "given_json",
    "given_text",
    "hint",
    "parameter_values",
    "is_test",
    "outer_parts",
    "part_given",
]

Given: TypeAlias = Mapping[Path, Value | None]
_NUMBERS = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}


def by_path(event: Event, values: Values) -> dict[Path, Value | None]:
    """Values of the event's parameters by their paths."""
    return {p.path: value for p, value in zip(event.parameters, values, strict=True)}


def parameter_values(event: Event, given: Given) -> Values:
    """The parts that decide; None for those that are missing, and for tests, which are no parts."""
    return tuple(None if is_test(p.path) else part_given(given, p.path) for p in event.parameters)


# --- reading -------------------------------------------------------------------------------------


def complete(robot: Robot, event: Event, raw: Raw, label: str) -> Given:
    """The parts that the model reads, from what was written.

    What decides the next state must be there. What only goes into data that is sent may be left
    out: it is then false, 0 or empty, and an array's element is missing. An optional value may be
    missing altogether.

    Raises:
        InvalidLine: a part is not what the model says it is.
    """
    if isinstance(raw, dict) and any(name[:1] == '"' for name in raw):
        tests = {name: raw[name] for name in raw if name[:1] == '"'}
        others = {name: part for name, part in raw.items() if name not in tests}
        left = others.get("", others or None)
        return {**complete(robot, event, left, label), **dict(_chosen(event, tests, label))}
    type_ = value_type(robot, event)
    if isinstance(type_, NoneType):
        if raw is not None:
            raise InvalidLine(f"{label} carries no value")
        return {}
    if is_optional(robot, event) and _has_nothing(raw):
        return dict.fromkeys(value_parts(event))
    if not isinstance(type_, ObjectType):
        if raw is None:
            if event.parameters:
                raise InvalidLine(f"{label} needs a value: {hint(robot, event)}")
            return {(): _default(type_)}
        return {(): _converted(type_, raw, label)}
    return _complete_object(event, type_, raw, label)


def _chosen(
    event: Event, tests: Mapping[str, Raw], label: str
) -> Iterator[tuple[Path, Value | None]]:
    """The outcomes of tests, by the paths that the plant gives them."""
    known = {_test_text(p.path): p for p in event.parameters if p.test or is_test(p.path)}
    for name, raw in tests.items():
        if name not in known:
            names = listing(list(known), "or") if known else "none"
            raise InvalidLine(f"{label} does not ask for {name}; its tests are {names}")
        parameter = known[name]
        missing = raw is None and None in parameter.values
        yield parameter.path, None if missing else _converted(parameter.type, raw, name)


def is_test(path: Path) -> bool:
    """Whether a path is the name of a test, or of a choice of the environment."""
    return any(isinstance(step, str) and not step.isidentifier() for step in path)


def _test_text(path: Path) -> str:
    return literal_text(str(path[0]), quoted=True)


def _has_nothing(raw: Raw) -> bool:
    return raw is None or (isinstance(raw, dict) and all(part is None for part in raw.values()))


def _complete_object(event: Event, type_: ObjectType, raw: Raw, label: str) -> Given:
    if raw is not None and not isinstance(raw, dict):
        raise InvalidLine(f"{label} carries {describe(type_)}: write its parts, x: 0.4, y: 2")
    fields = _by_path(raw or {}, type_, label)
    for whole, path in product(fields, fields):
        within = whole == path[: len(whole)] != path
        if within and _written({whole: fields[whole]}, path) != fields[path]:
            raise InvalidLine(
                f"{path_text(path)} of {label} is not what {path_text(whole)} has there"
            )
    needed = {parameter.path for parameter in event.parameters}
    given: dict[Path, Value | None] = {}
    for path, part in value_parts(event).items():
        name = f"{path_text(path)} of {label}"
        written = _written(fields, path)
        if written is not None:
            given[path] = _converted(part, written, name)
        elif isinstance(part, ArrayType | ObjectType) and path not in fields:
            given[path] = _assembled(part, path, fields, name)
        elif any(isinstance(step, int) for step in path):
            given[path] = None
        elif path in needed:
            raise InvalidLine(f"{name} needs a value: {_choices(part)}")
        else:
            given[path] = _default(part)
    values = parameter_values(event, given)
    for i, j in missing_together(event):
        if values[i] is None and values[j] is not None:
            first, second = (path_text(event.parameters[n].path) for n in (i, j))
            raise InvalidLine(f"{second} of {label} cannot be there where {first} is missing")
    return given


def _written(fields: Mapping[Path, Raw], path: Path) -> Raw:
    """What was written for a part, or within a whole; None if nothing was."""
    found = max((p for p in fields if path[: len(p)] == p), key=len, default=path)
    raw = fields.get(found)
    for step in path[len(found) :]:
        if isinstance(raw, dict) and isinstance(step, str):
            raw = raw.get(step)
        elif isinstance(raw, list) and isinstance(step, int) and step < len(raw):
            raw = raw[step]
        else:
            return None
    return raw


def _assembled(type_: Type, path: Path, fields: Mapping[Path, Raw], what: str) -> Value:
    """A part as a whole, from what was given of its members; the others are as by default."""
    if path in fields:
        return _converted(type_, fields[path], what)
    if isinstance(type_, ArrayType):
        depth = len(path)
        given = [p[depth] for p, raw in fields.items() if p[:depth] == path and raw is not None]
        last = max((step for step in given if isinstance(step, int)), default=-1)
        elements = [
            _assembled(type_.element, (*path, i), fields, f"{what}[{i}]") for i in range(last + 1)
        ]
        return cast(Value, elements)
    if not isinstance(type_, ObjectType):
        return _default(type_)
    parts = {
        name: _assembled(inner, (*path, name), fields, f"{what}.{name}")
        for name, inner in type_.properties
    }
    return cast(Value, SimpleNamespace(**parts))


def _by_path(raw: Mapping[str, Raw], type_: Type, label: str) -> dict[Path, Raw]:
    """Parts by path, each of which the type must have."""
    found: dict[Path, Raw] = {}
    for text, value in raw.items():
        path = path_in(text) if text else ()
        if path is None:
            raise InvalidLine(f"'{text}' is not part of a value: write pose.x or ranges[0]")
        if type_of_part(type_, path) is None:
            raise InvalidLine(f"{label} has no part '{text}'")
        found[path] = value
    return found


def _converted(type_: Type, raw: Raw, what: str) -> Value:
    """A raw value as one of the type; enums apply their rules to what is none of their values."""
    match type_:
        case EnumType():
            name = raw.removeprefix(f"{type_.name}.") if isinstance(raw, str) else None
            if name in type_.values:
                return str(name)
            return _by_rules(type_, raw, what)
        case BooleanType() if isinstance(raw, bool):
            return raw
        case IntegerType() if isinstance(raw, int) and not isinstance(raw, bool):
            return raw
        case DoubleType() if isinstance(raw, int | float) and not isinstance(raw, bool):
            return _double(raw, what)
        case DoubleType() if isinstance(raw, str) and raw in _NUMBERS:
            return _NUMBERS[raw]
        case StringType() if isinstance(raw, str):
            return raw
        case ArrayType(element=element) if isinstance(raw, list | tuple):
            items: Any = [_converted(element, item, f"an element of {what}") for item in raw]
            return cast(Value, items)
        case ObjectType(properties=properties) if isinstance(raw, dict):
            for name in raw:
                if type_.property(name) is None:
                    raise InvalidLine(f"{what} has no part '{name}'")
            parts = {
                name: _converted(inner, raw[name], what) if name in raw else _default(inner)
                for name, inner in properties
            }
            return cast(Value, SimpleNamespace(**parts))
    shown = "an object" if isinstance(raw, dict) else literal_text(raw)
    raise InvalidLine(f"{what} is {describe(type_)}, not {shown}")


def _default(type_: Type) -> Value:
    """What a part is that was not given; of an array, nothing came."""
    match type_:
        case ArrayType():
            return cast(Value, [])
        case ObjectType(properties=properties):
            parts = {name: _default(inner) for name, inner in properties}
            return cast(Value, SimpleNamespace(**parts))
    return default_value(type_)


def _double(raw: int | float, what: str) -> float:
    try:
        return float(raw)
    except OverflowError:
        raise InvalidLine(f"{what} is too large for a double") from None


def _by_rules(enum: EnumType, raw: Raw, what: str) -> Value:
    source = enum.source
    fields: dict[Path, Raw] = {(): raw}
    if isinstance(source, ObjectType) and isinstance(raw, dict):
        fields = _by_path(raw, source, what)
    else:
        try:
            fields = {(): _converted(source, raw, what)}
        except InvalidLine:
            names = listing(enum.values, "or")
            raise InvalidLine(f"{what} is {names}, or {describe(source)} to convert") from None

    def look(leaf: Leaf) -> Value | None:
        assert isinstance(leaf, ValueRef)
        if leaf.path in fields and fields[leaf.path] is not None:
            return _converted(leaf.type, fields[leaf.path], what)
        array = any(isinstance(step, int) for step in leaf.path)
        return None if array else _default(leaf.type)

    for rule in enum.rules:
        if is_true(condition_of(rule), look):
            return rule.value
    return enum.default


def outer_parts(event: Event, decided: Collection[Path] = ()) -> dict[Path, Type]:
    """The parts that are read and hold none that are decided, but what lies within another one."""
    found: dict[Path, Type] = {}
    for path, part in sorted(value_parts(event).items(), key=lambda item: len(item[0])):
        within = any(path[: len(other)] == other for other in found)
        if not within and not any(path == other[: len(path)] for other in decided):
            found[path] = part
    return found


# --- words ---------------------------------------------------------------------------------------


def hint(robot: Robot, event: Event) -> str:
    """What may be written as the event's value; empty if it carries none."""
    type_ = value_type(robot, event)
    if isinstance(type_, NoneType):
        return ""
    found = _choices(type_)
    if isinstance(type_, ObjectType):
        found = ", ".join(
            f"{path_text(path)}: {_choices(part)}" if path else _choices(part)
            for path, part in outer_parts(event).items()
        )
    return f"{found}, or missing" if is_optional(robot, event) else found


def _choices(type_: Type) -> str:
    match type_:
        case BooleanType():
            return "true or false"
        case IntegerType(bounds=(low, high)):
            return f"{low}..{high}"
        case EnumType(values=values, source=source):
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


def _leaves(path: Path, value: Value | None) -> Iterator[tuple[Path, Value | None]]:
    """The members of an object, down to those that are none."""
    if not _is_object(value):
        yield path, value
        return
    for name, inner in vars(value).items():
        yield from _leaves((*path, name), inner)


def part_given(given: Given, path: Path) -> Value | None:
    """A part that came by itself, or with a whole; None if it is not there."""
    for length in range(len(path), -1, -1):
        if path[:length] in given:
            found: Any = given[path[:length]]
            try:
                return part_of_value(found, path[length:]) if found is not None else None
            except Undefined:
                return None
    return None


def given_json(given: Given) -> Any:
    """As in the documents of a running controller: a literal, parts by path, or None."""
    if not given:
        return None
    if () in given and not _is_object(given[()]):
        return jsonable(given[()])
    return {path_text(path): jsonable(value) for path, value in given.items()}
