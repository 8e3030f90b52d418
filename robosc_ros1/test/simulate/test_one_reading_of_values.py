"""What is typed in the simulator or stands in a script means what the node reads in a message.

The node's side is the generated ``read`` of each input and of each command that another controller
sends; the other side reads the same values as JSON. Random models.
"""

from __future__ import annotations

import random
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from quick import quick_first
from random_models import random_model

from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    IntegerType,
    NoneType,
    ObjectType,
    Type,
)
from robosc.plant.automaton import Event, Plant
from robosc.plant.event_values import value_type
from robosc.runtime.core.model import Controller
from robosc.runtime.core.values import Mismatch, jsonable
from robosc.simulate.machines.execute import read_given
from robosc.simulate.machines.machine import label
from robosc.simulate.machines.state import make_controller
from robosc.simulate.values.event_data import complete
from robosc.simulate.values.typed_values import within_whole

NUMBERS = (-3.0, -1.5, 0.0, 1.0, 2.5, 7.0, float("inf"), float("nan"))


def some(type_: Type, rng: random.Random) -> Any:
    """A value of ROS for it, as JSON."""
    match within_whole(type_):
        case BooleanType():
            return rng.random() < 0.5
        case IntegerType():
            return rng.randint(-4, 4)
        case DoubleType():
            return rng.choice(NUMBERS)
        case ArrayType(element=element):
            return [some(element, rng) for _ in range(rng.randint(0, 3))]
        case ObjectType(properties=properties):
            return {name: some(inner, rng) for name, inner in properties}
    return rng.choice(("none", "two words", ""))


def message(value: Any) -> Any:
    """The message that carries it; a value without fields is its ``data``."""
    return _part(value if isinstance(value, dict) else {"data": value})


def _part(value: Any) -> Any:
    if isinstance(value, list):
        return [_part(element) for element in value]
    if not isinstance(value, dict):
        return value
    made = type("Message", (), {"__slots__": tuple(value)})()
    for name, part in value.items():
        setattr(made, name, _part(part))
    return made


def read(row: Any, controller: Controller, message: Any) -> Any:
    """What a row reads; the text of what it refuses."""
    try:
        return jsonable(row.read(controller, message))
    except Mismatch as mismatch:
        return str(mismatch)


def rows(controller: Controller, plant: Plant) -> list[tuple[Event, Any]]:
    """The events that carry a value, with what reads it."""
    events = {(e.key, e.kind.word): e for e in plant.events}
    found = [*controller.INPUTS, *controller.COMMANDS]
    pairs = [(events[row.key, row.kind], row) for row in found if row.read is not None]
    return [p for p in pairs if not isinstance(value_type(plant.robot, p[0]), NoneType)]


@pytest.mark.parametrize("seed", quick_first(range(60), 20))
@pytest.mark.parametrize("supervises", [False, True])
def test_of_random_models(seed: int, supervises: bool) -> None:
    rng = random.Random(seed)
    text = random_model(rng, 1 + seed % 3, served=bool(seed % 2))
    supervisor = supervisor_of(text, supervises=supervises)
    plant = supervisor.plant
    node, player = make_controller(supervisor), make_controller(supervisor)
    read_given(player, plant)
    for (event, of_node), (_, of_player) in zip(
        rows(node, plant), rows(player, plant), strict=True
    ):
        for _ in range(20):
            value = some(value_type(plant.robot, event), rng)
            given = complete(plant.robot, event, value, label(event))
            expected = read(of_node, node, message(value))
            assert read(of_player, player, given) == expected, (event, value)
