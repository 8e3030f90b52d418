"""Who works on the engine's state: its own thread, or whoever brings a message while that rests."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from runtime.lamp_robot import SENSOR, LampController, PlayedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.inbox import EngineQueue
from robosc.runtime.core.model import Input
from robosc.runtime.core.settings import Settings
from robosc.runtime.judge.supervising import supervisor_engine


class RealTimePort(PlayedPort):
    def now(self) -> float:
        return time.monotonic()


@contextmanager
def running(controller: LampController, **settings: Any) -> Iterator[Engine[Any]]:
    engine = controller_engine(controller, RealTimePort(), Settings(**settings))
    thread = threading.Thread(target=engine.run, daemon=True)
    thread.start()
    try:
        yield engine
    finally:
        engine.close()
        thread.join(60)
    assert not thread.is_alive()


def await_that(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 60
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.001)


def handled_by(controller: LampController) -> list[threading.Thread]:
    """The threads in which messages of the sensor are handled from now on."""
    threads: list[threading.Thread] = []
    read = Input(SENSOR, "response", lambda _, __: threads.append(threading.current_thread()),
                 lambda _, __: None, ())  # fmt: skip
    controller.INPUTS = (read, *LampController.INPUTS[1:])
    return threads


def test_a_message_is_handled_by_the_thread_that_brings_it_while_the_engine_rests() -> None:
    controller = LampController()
    threads = handled_by(controller)
    with running(controller) as engine:
        post = engine.poster([SENSOR])

        def at_once() -> bool:
            post(None)
            return threads[-1:] == [threading.current_thread()]

        await_that(at_once)


def test_all_that_waits_at_once_is_handled() -> None:
    """More than the engine takes in one go, and nothing after it that would wake the engine."""
    engine = supervisor_engine(LampController(), RealTimePort())  # it sends nothing by itself
    handled: list[int] = []
    for number in range(350):
        engine.invoke(lambda number=number: handled.append(number))  # type: ignore[misc]
    thread = threading.Thread(target=engine.run, daemon=True)
    thread.start()
    await_that(lambda: len(handled) == 350)
    assert handled == [*range(350)]
    engine.close()
    thread.join(60)


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("hasty")
def test_what_waits_is_never_overtaken() -> None:
    """Messages of two topics and functions, from several threads, while deadlines pass."""
    controller = LampController()
    seen: list[tuple[int, int]] = []
    at_work: list[int] = []
    together: list[list[int]] = []

    def handle(_: Any, message: tuple[int, int]) -> None:
        at_work.append(threading.get_ident())
        seen.append(message)
        if len(at_work) > 1:
            together.append(list(at_work))
        at_work.pop()

    heard = Input(SENSOR, "response", handle, lambda _, __: None, ("clear",))
    controller.INPUTS = (heard, *LampController.INPUTS[1:])
    count, bringers = 600, 3
    with running(controller, rate=1000.0) as engine:
        one, both = engine.poster([SENSOR]), engine.poster([SENSOR, SENSOR])

        def bring(me: int) -> None:
            for number in range(count):
                if number % 3 == 0:
                    one((me, number))
                elif number % 3 == 1:
                    both((me, number))
                else:
                    engine.invoke(lambda at=number: handle(None, (me, at)))  # type: ignore[misc]

        threads = [threading.Thread(target=bring, args=(me,)) for me in range(bringers)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
        found: list[dict[str, Any]] = []
        engine.invoke(lambda: found.append(engine.snapshot()))
        await_that(lambda: bool(found))
    assert (found[0]["stopped"], found[0]["counters"]["dropped"], together) == (None, 0, [])
    expected = [number for number in range(count) for _ in range(2 if number % 3 == 1 else 1)]
    for me in range(bringers):
        assert [number for bringer, number in seen if bringer == me] == expected


def test_a_closed_engine_handles_nothing_more() -> None:
    controller = LampController()
    threads = handled_by(controller)
    with running(controller) as engine:
        post = engine.poster([SENSOR])
    post(None)
    assert (threads, engine.snapshot()["backlog"]) == ([], 1)


def test_nobody_handles_anything_before_the_engine_begins() -> None:
    controller = LampController()
    threads = handled_by(controller)
    engine = controller_engine(controller, PlayedPort())
    engine.poster([SENSOR])(None)
    assert threads == []
    engine.begin()
    engine.cycle()
    assert threads == [threading.current_thread()]


@pytest.mark.parametrize(("patience", "due", "woken"), [(None, 0.0, True), (60.0, 0.0, True),
                                                        (60.0, 61.0, False), (60.0, None, False)])  # fmt: skip
def test_the_engine_is_woken_for_what_is_due_before_it_would_wake(
    patience: float | None, due: float | None, woken: bool
) -> None:
    turns = EngineQueue(time.monotonic)
    awake = threading.Event()

    def rest() -> None:
        turns.wait(patience)
        awake.set()

    thread = threading.Thread(target=rest, daemon=True)
    thread.start()
    await_that(turns.begin)
    turns.wake_within(due)
    turns.end()
    if not woken:
        await_that(turns.begin)  # it still rests
        turns.end()
        turns.wake()
    assert awake.wait(60)
