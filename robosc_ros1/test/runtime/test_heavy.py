"""Heavy messages: what waits of a topic is bounded, keeps its order, and its newest is handled."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runtime.lamp_robot import SENSOR, LampController, PlayedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.functions import greatest_of, least_of
from robosc.runtime.core.heavy import BYTES, COUNT, LIGHT, HeavyTopic
from robosc.runtime.core.values import Undefined


class Stage:
    """A heavy topic whose engine is slow: it handles a message when the test says so."""

    def __init__(self) -> None:
        self.converting = threading.Semaphore(0)
        self.handled: list[Any] = []
        self.lost = 0
        self.alive = self.most_alive = 0
        self.lock = threading.Lock()
        self.topic = HeavyTopic(self._convert, self._post, self._put, self._lose, lambda: 7.0)

    def _convert(self, data: Any) -> Any:
        self.converting.acquire()
        with self.lock:
            self.alive += 1
            self.most_alive = max(self.most_alive, self.alive)
        return data

    def _post(self, message: Any, arrival: float | None) -> None:
        self.handled.append((message, arrival))

    def _put(self, function: Any) -> None:
        with self.lock:
            self.alive = 0
        function()

    def _lose(self, count: int) -> None:
        self.lost += count

    def finish(self, count: int) -> None:
        """Let so many conversions go on, and wait until all was handled."""
        done = threading.Event()
        self.topic.when_handled(done.set)
        for _ in range(count):
            self.converting.release()
        assert done.wait(30)


def test_a_light_message_is_posted_at_once_in_the_thread_that_took_it() -> None:
    stage = Stage()
    assert stage.topic.is_light(LIGHT) and not stage.topic.is_light(LIGHT + 1)
    stage.topic.take("light", 10, is_raw=False)
    assert stage.handled == [("light", None)]
    assert not stage.topic.is_busy


def test_a_light_one_does_not_overtake_a_heavy_one() -> None:
    stage = Stage()
    stage.topic.take("heavy", LIGHT + 1, is_raw=True)
    assert stage.topic.is_busy and not stage.topic.is_light(1)
    stage.topic.take("light", 10, is_raw=False)
    assert stage.handled == []
    stage.finish(1)
    # With the time at which they came.
    assert stage.handled == [("heavy", 7.0), ("light", 7.0)]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(1, 3 * BYTES // 2), min_size=1, max_size=30))
def test_what_waits_is_bounded_and_the_newest_is_handled(weights: list[int]) -> None:
    stage = Stage()
    for number, weight in enumerate(weights):
        stage.topic.take(number, weight, is_raw=True)
        waiting = [item.weight for item in stage.topic._waiting]
        assert sum(waiting) <= BYTES or len(waiting) == 1
        assert len(waiting) <= COUNT
    stage.finish(len(weights))
    numbers = [number for number, _ in stage.handled]
    assert numbers == sorted(numbers)
    assert numbers[-1] == len(weights) - 1
    assert len(numbers) + stage.lost == len(weights)
    assert stage.most_alive == 1  # one after the other, each when that before was handled


def test_bytes_of_another_type_are_lost_and_the_next_are_read() -> None:
    posted: list[Any] = []
    lost: list[int] = []
    topic = HeavyTopic(int, lambda m, _: posted.append(m), lambda f: f(), lost.append)
    topic.take("no number", BYTES, is_raw=True)
    done = threading.Event()
    topic.when_handled(done.set)
    assert done.wait(30)
    topic.take("3", LIGHT + 1, is_raw=True)
    done.clear()
    topic.when_handled(done.set)
    assert done.wait(30)
    assert (posted, lost) == ([3], [1])


def test_other_topics_are_handled_while_one_is_converted() -> None:
    """An emergency stop comes while the cloud is read."""
    port, reading = PlayedPort(), threading.Event()
    go_on, controller = threading.Event(), LampController()

    def convert(data: bytes) -> float:
        reading.set()
        assert go_on.wait(30)
        return float(len(data))

    engine = controller_engine(controller, port, steady=lambda: port.time)
    engine.begin()
    heavy = engine.heavy([SENSOR], convert)
    heavy.take(b" " * 20, LIGHT + 1, is_raw=True)
    assert reading.wait(30)
    assert engine.intake.awaits(SENSOR)  # so that no silence is told of it
    seen: list[str] = []
    engine.invoke(lambda: seen.append("handled"))
    engine.cycle()
    assert seen == ["handled"] and not controller.clear
    go_on.set()
    done = threading.Event()
    heavy.when_handled(done.set)
    while not done.wait(0.01):
        engine.cycle()
    assert controller.clear


@given(st.lists(st.one_of(st.floats(), st.integers(-(2**80), 2**80)), max_size=8))
def test_the_least_and_the_greatest_leave_out_what_is_no_number(numbers: list[float]) -> None:
    known = [number for number in numbers if number == number]
    if not known:
        for function in (least_of, greatest_of):
            with pytest.raises(Undefined):
                function(numbers)
        return
    assert (least_of(numbers), greatest_of(numbers)) == (min(known), max(known))


@pytest.mark.parametrize("numbers", [[2**2000, 1.0], [float("inf"), float("-inf"), float("nan")]])
def test_numbers_without_a_sum(numbers: list[float]) -> None:
    known = [number for number in numbers if number == number]
    assert (least_of(numbers), greatest_of(numbers)) == (min(known), max(known))
