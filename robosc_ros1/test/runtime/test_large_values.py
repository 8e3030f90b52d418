"""Documents stay small and valid, and are made without looking through large values."""

from __future__ import annotations

import array
import random
import re
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy
import pytest
from runtime.lamp_robot import PlayedPort
from runtime.schemas import validate
from runtime.test_reports import Heard, report_at_last

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.model import Communication, Controller, Input
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.shortening import Shortener
from robosc.runtime.core.telemetry import Reporter, dump
from robosc.runtime.core.values import not_finite

NAN, INFINITY = float("nan"), float("inf")
LARGEST = 64_000
"""Bytes of a document."""


@pytest.mark.parametrize(
    ("value", "short"),
    [
        ([1.0, 2.5], [1.0, 2.5]),
        ([0.31] + [2.0] * 358 + [12.0], "360 numbers, 0.31 … 12.0"),
        (tuple(range(17)), "17 numbers, 0 … 16"),
        ([NAN, -INFINITY, *range(20)], "22 numbers, -inf … 19"),
        ([NAN] * 20, "20 numbers, all NaN"),
        ([2**70] * 20, "20 numbers, 1.18059e+21 … 1.18059e+21"),
        (b"\0" * 5_000_000, "5,000,000 numbers"),
        (array.array("B", b"abc" * 10), "30 numbers, 97 … 99"),
        (numpy.arange(20), "20 numbers, 0 … 19"),
        (numpy.float32([0.5] * 20), "20 numbers, 0.5 … 0.5"),
        (numpy.zeros((20, 3)), "20 arrays"),
        ([[1.0]] * 20, "20 arrays"),
        (["a"] * 20, "20 strings"),
        ([True] * 20, "20 booleans"),
        ([{"x": 1}] * 20, "20 objects"),
        ("s" * 1_000_000, "s" * 75 + "… (1,000,000 characters)"),
        ({"a": {"b": [0] * 17}, "c": None}, {"a": {"b": "17 numbers, 0 … 0"}, "c": None}),
        (SimpleNamespace(x=[1] * 3, y="t"), {"x": [1, 1, 1], "y": "t"}),
        ([], []),
        (NAN, "NaN"),
    ],
)
def test_short_forms(value: Any, short: Any) -> None:
    shorten = Shortener()
    assert shorten(value) == short
    text = str(short)
    assert shorten.whole == not_shortened(text)


def not_shortened(text: str) -> bool:
    words = ("numbers", "arrays", "strings", "booleans", "objects", "characters")
    return not any(word in text for word in words)


class Untouchable(list[Any]):
    """Too many elements to look at all of them."""

    def __iter__(self) -> NoReturn:
        raise AssertionError("all elements are looked at")


class Bytes(array.array):  # type: ignore[type-arg]
    """As a picture comes in ROS 2."""

    def __iter__(self) -> NoReturn:
        raise AssertionError("all elements are looked at")


def test_whether_a_picture_is_finite_is_known_without_looking_at_it() -> None:
    assert not_finite({"data": Bytes("B", bytes(50))}) is None


@pytest.mark.parametrize("kind", ["f", "d"])
def test_the_first_number_that_is_not_finite_is_found(kind: str) -> None:
    numbers = array.array(kind, [1.0] * 50)
    assert not_finite({"ranges": numbers}) is None
    numbers[7] = INFINITY
    for values in (numbers, list(numbers), [0, *numbers[1:]]):
        assert not_finite({"ranges": values}) == "ranges[7] is inf"


def drawn(chance: random.Random, depth: int) -> Any:
    """A large value of any shape."""
    kind = chance.randrange(8 if depth else 5)
    size = chance.choice([0, 3, 15, 17, 1500])
    if kind == 0:
        return chance.choice([1.5, NAN, 2**80, True, None, "é" * size])
    if kind == 1:
        return Untouchable([0.5] * 3000)
    if kind == 2:
        return bytes(size)
    if kind == 3:
        return '"' * chance.choice([1, 1_000_000])
    if kind == 4:
        return [chance.random() for _ in range(size)]
    parts = [drawn(chance, depth - 1) for _ in range(min(size, 17))]
    if kind == 5:
        return parts * (100 if size > 17 else 1)
    fields = {f"field_{number}": part for number, part in enumerate(parts)}
    return fields if kind == 6 else SimpleNamespace(**fields)


class Holder(Controller):
    """Stores whole messages, in many variables."""

    ROBOT, SOURCE, STEP_BOUND = "Holder", "holder.rscd", 1
    COMMANDS = TAUS = REQUIREMENTS = ()

    def __init__(self, variables: int) -> None:
        self.undefined = {}
        self.size = variables
        for number in range(variables):
            setattr(self, f"held_{number}", None)

    def components(self) -> dict[str, str]:
        return {"Holder": "on"}

    def variables(self) -> dict[str, Any]:
        return {f"Holder.v{n}": getattr(self, f"held_{n}") for n in range(self.size)}

    def read(self, message: Any) -> Any:
        return message

    def store(self, value: Any) -> None:
        for number in range(self.size):
            setattr(self, f"held_{number}", value)

    COMMUNICATIONS = (Communication("Holder.take", "take", "outgoing"),)
    INPUTS = (Input("Holder.take", "response", read, store, ("held_0",)),)


@pytest.mark.parametrize("variables", [1, 20, 1000])
@pytest.mark.parametrize("seed", range(6))
def test_documents_are_small_and_valid(seed: int, variables: int) -> None:
    value = drawn(random.Random(seed), 3)
    texts = []
    for _ in range(2):  # the same again
        engine = controller_engine(Holder(variables), PlayedPort())
        engine.begin()
        for _ in range(10):
            engine.post("Holder.take", "response", value)
        engine.cycle()
        engine.close()
        engine.cycle()
        heard = Heard()
        reporter = Reporter(engine, heard, {})
        report_at_last(reporter, engine)
        state = heard.states[-1]
        for document, schema in ((state, "state"), *((event, "event") for event in heard.told)):
            validate(document, schema)
            text = dump(document)
            assert len(text.encode()) <= LARGEST
            texts.append(re.sub(r'"(begun|time)":[0-9.]+', "", text))
    half = len(texts) // 2
    assert half == 11
    assert texts[:half] == texts[half:]


def test_values_are_whole_only_for_subscribers_of_who_asked_for_them() -> None:
    picture = SimpleNamespace(data=[7] * 1000)

    class Listened(Heard):
        listens = False

        def wants_state(self) -> bool:
            return self.listens

    shown = {}
    for whole, listens in ((False, False), (False, True), (True, False), (True, True)):
        heard = Listened(listening=listens)
        heard.listens = listens
        engine = controller_engine(Holder(1), PlayedPort(), Settings(whole_values=whole))
        reporter = Reporter(engine, heard, {})
        engine.begin()
        engine.post("Holder.take", "response", picture)
        engine.cycle()
        engine.close()
        engine.cycle()
        report_at_last(reporter, engine)
        heard.wait(lambda heard=heard: heard.states and heard.levels)
        state = heard.states[-1]
        shown[whole, listens] = state["variables"]["Holder.v0"]["data"]
        (latest,) = state["latest"]
        assert (latest["event"]["value"]["data"] == [7] * 1000) == (whole and listens)
        assert len(heard.levels[-1][2]["Holder.v0"]) < 200, "diagnostics are always short"
    short = "1,000 numbers, 7 … 7"
    assert shown == {
        (False, False): short, (False, True): short, (True, False): short,
        (True, True): [7] * 1000,
    }  # fmt: skip
