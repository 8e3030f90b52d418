"""Values of events that nobody typed: drawn at random, or filled up around what decides."""

from __future__ import annotations

import random
from typing import cast

from robosc.expr import types
from robosc.expr.traversal import path_text
from robosc.model.entities import Robot
from robosc.plant.automaton import Event
from robosc.plant.event_values import is_optional, value_type
from robosc.simulate.faults import InvalidLine
from robosc.simulate.values.event_data import Given, complete, is_test, outer_parts
from robosc.simulate.values.literals import Raw
from robosc.simulate.values.typed_values import within_whole


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
