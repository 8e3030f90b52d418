"""Values of the model's types from what was typed, or came as JSON.

The value of an enum is its name, but within an object or an array that is kept as a whole it is
what the enum converts from: such a whole is kept as it was received, and converted where it is
read.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, cast

from robosc.errors import listing
from robosc.expr import evaluation, traversal, tree, types
from robosc.model.typing.compatibility import default_value, describe
from robosc.plant.data.terms import type_of_part
from robosc.simulate.faults import InvalidLine
from robosc.simulate.values.literals import Path, Raw, literal_text, path_in

_NUMBERS = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}


def typed_value(type_: types.Type, raw: Raw, what: str) -> types.Value:
    """A raw value as one of the type; an enum converts what is none of its values.

    Raises:
        InvalidLine: it is none; the message calls it ``what``.
    """
    match type_:
        case types.EnumType():
            name = raw.removeprefix(f"{type_.name}.") if isinstance(raw, str) else None
            return str(name) if name in type_.values else _by_rules(type_, raw, what)
        case types.BooleanType() if isinstance(raw, bool):
            return raw
        case types.IntegerType() if isinstance(raw, int) and not isinstance(raw, bool):
            return raw
        case types.DoubleType() if isinstance(raw, int | float) and not isinstance(raw, bool):
            return _double(raw, what)
        case types.DoubleType() if isinstance(raw, str) and raw in _NUMBERS:
            return _NUMBERS[raw]
        case types.StringType() if isinstance(raw, str):
            return raw
        case types.ArrayType(element=element) if isinstance(raw, list | tuple):
            items: Any = [_member(element, item, f"an element of {what}") for item in raw]
            return cast(types.Value, items)
        case types.ObjectType(properties=properties) if isinstance(raw, dict):
            for name in raw:
                if type_.property(name) is None:
                    raise InvalidLine(f"{what} has no part '{name}'")
            return _object(
                {
                    name: _member(inner, raw[name], what) if name in raw else _default(inner)
                    for name, inner in properties
                }
            )
    shown = "an object" if isinstance(raw, dict) else literal_text(raw)
    raise InvalidLine(f"{what} is {describe(type_)}, not {shown}")


def assembled(type_: types.Type, path: Path, parts: Mapping[Path, Raw], what: str) -> types.Value:
    """A part as a whole, from what was written of its members; the others are as by default."""
    if path in parts:
        return _member(type_, parts[path], what)
    if isinstance(type_, types.ArrayType):
        depth = len(path)
        given = [p[depth] for p, raw in parts.items() if p[:depth] == path and raw is not None]
        last = max((step for step in given if isinstance(step, int)), default=-1)
        elements: Any = [
            assembled(type_.element, (*path, i), parts, f"{what}[{i}]") for i in range(last + 1)
        ]
        return cast(types.Value, elements)
    if isinstance(type_, types.ObjectType):
        return _object(
            {
                name: assembled(inner, (*path, name), parts, f"{what}.{name}")
                for name, inner in type_.properties
            }
        )
    return _default(type_)


def raw_parts(raw: Mapping[str, Raw], type_: types.Type, label: str) -> dict[Path, Raw]:
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


def default_part(type_: types.Type) -> types.Value:
    """What a part is that was not given; of an array, nothing came."""
    return (
        _default(type_)
        if isinstance(type_, types.ArrayType | types.ObjectType)
        else default_value(type_)
    )


def within_whole(type_: types.Type) -> types.Type:
    """The type of a member of an object or an array: an enum has not converted it yet."""
    return within_whole(type_.source) if isinstance(type_, types.EnumType) else type_


def _object(parts: Mapping[str, types.Value]) -> types.Value:
    return cast(types.Value, SimpleNamespace(**parts))


def _default(type_: types.Type) -> types.Value:
    match within_whole(type_):
        case types.ArrayType():
            return cast(types.Value, [])
        case types.ObjectType(properties=properties):
            return _object({name: _default(inner) for name, inner in properties})
        case other:
            return default_value(other)


def _member(type_: types.Type, raw: Raw, what: str) -> types.Value:
    """A value within an object or an array."""
    if isinstance(type_, types.EnumType) and isinstance(raw, str):
        name = raw.removeprefix(f"{type_.name}.")
        if name in type_.values:
            return _source_of(type_, name, what)
    return typed_value(within_whole(type_), raw, what)


def _source_of(enum: types.EnumType, name: str, what: str) -> types.Value:
    """Some value that an enum converts to a value of its own."""
    constants = {
        part.value: None
        for rule in enum.rules
        for part in traversal.walk(tree.condition_of(rule))
        if isinstance(part, tree.Literal)
    }
    candidates: list[Any] = [False, True, "", *constants]
    numbers = sorted(c for c in constants if isinstance(c, int | float) and c == c)
    if numbers:
        between = [low + (high - low) // 2 for low, high in pairwise(numbers)]
        between += [(low + high) / 2 for low, high in pairwise(numbers)]
        candidates += [numbers[0] - 1, *between, numbers[-1] + 1]
    source = within_whole(enum)
    for candidate in candidates:
        try:
            value = typed_value(source, candidate, what)
        except InvalidLine:
            continue
        if evaluation.converted(enum, value) == name:
            return value
    raise InvalidLine(f"write {what} as {describe(source)} from which {name} is converted")


def _by_rules(enum: types.EnumType, raw: Raw, what: str) -> types.Value:
    source = enum.source
    if isinstance(source, types.ObjectType) and isinstance(raw, dict):
        return evaluation.converted(enum, assembled(source, (), raw_parts(raw, source, what), what))
    try:
        value = _member(source, raw, what)
    except InvalidLine:
        names = listing(enum.values, "or")
        raise InvalidLine(f"{what} is {names}, or {describe(source)} to convert") from None
    return evaluation.converted(enum, value)


def _double(raw: int | float, what: str) -> float:
    try:
        return float(raw)
    except OverflowError:
        raise InvalidLine(f"{what} is too large for a double") from None
