"""How the engine executes a controller: order, rate, calls, deadlines, suspension."""

from __future__ import annotations

import math
import threading
from typing import Any

import pytest
from runtime.lamp_robot import ARM, GO, HALT, LAMP, SENSOR, LampController
from runtime.played_engine import Played

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import INACTIVE
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.values import Undefined


def test_what_is_allowed_at_first_is_sent_at_once() -> None:
    assert Played().begin() == [HALT, LAMP, ARM]


def test_an_edge_is_served_at_once_and_repeated_at_the_rate() -> None:
    played = Played(rate=10.0)
    played.begin()
    played.port.time += 0.03
    assert played.see(50)[:1] == [GO]
    assert played.see(60) == []
    assert played.wait(0.0999) == []
    assert played.wait(0.0002) == [GO]
    assert len(played.wait(1.0)) == 10


def test_data_are_those_of_the_moment_of_sending() -> None:
    played = Played()
    played.begin()
    played.engine.post(SENSOR, "response", 20)
    played.engine.post(SENSOR, "response", 50)
    played.engine.cycle()
    assert (GO, {"data": 5.0}) in played.port.sent


def test_a_guard_that_falls_and_rises_within_one_batch_is_an_edge() -> None:
    played = Played()
    played.begin()
    played.see(50)
    played.engine.post(SENSOR, "response", 5)
    played.engine.post(SENSOR, "response", 50)
    played.engine.cycle()
    assert played.port.take() == [GO]


def test_a_command_that_stops_being_allowed_before_its_turn_is_not_sent() -> None:
    played = Played()
    played.begin()
    played.engine.post(SENSOR, "response", 50)
    played.engine.post(SENSOR, "response", 5)
    played.engine.cycle()
    assert GO not in played.port.take()


def test_a_service_that_completes_is_called_again_at_the_rate_not_at_once() -> None:
    played = Played(rate=10.0)
    played.begin()
    played.port.time = 0.01
    assert LAMP not in played.end(LAMP)
    assert LAMP not in played.wait(0.08)
    assert LAMP in played.wait(0.02)


def test_a_long_call_is_followed_on_the_next_beat() -> None:
    played = Played(rate=10.0)
    played.begin()
    played.wait(3.03)
    assert played.end(LAMP) == []
    assert LAMP not in played.wait(0.069)
    assert LAMP in played.wait(0.002)


def test_an_action_that_mirrors_its_phase_is_not_started_again_at_once() -> None:
    played = Played(rate=10.0)
    played.begin()
    played.port.time = 0.01
    assert played.end(ARM) == []
    assert ARM not in played.wait(0.08)
    assert ARM in played.wait(0.02)


def test_a_request_ends_once_however_often_it_is_answered() -> None:
    played = Played()
    played.begin()
    token = played.port.tokens[LAMP]
    for kind in ("response", "response", "error"):
        played.engine.report(LAMP, token, kind, "x")
    played.engine.cycle()
    assert played.counter("late") == 2
    assert played.counter("errors") == 0


def test_a_call_without_answer_becomes_one_error_at_its_deadline() -> None:
    played = Played(timeout={LAMP: 2.0})
    played.begin()
    token = played.port.tokens[LAMP]
    played.wait(1.99)
    assert played.counter("errors") == 0
    played.wait(0.02)
    assert played.counter("errors") == 1
    assert (LAMP, token) in played.port.abandoned


def test_a_silent_server_is_lost() -> None:
    played = Played(server_lost_after=5.0)
    played.begin()
    played.engine.report(ARM, played.port.tokens[ARM], "accepted")
    played.port.silent = 0.2
    played.wait(20.0)
    assert played.counter("errors") == 3  # the lamp alone, which nobody answers
    played.port.silent = 6.0
    played.wait(5.0)
    lost = [e for e in played.engine.recorder.take() if e.name == "reach" and e.kind == "error"]
    assert lost[0].detail is not None
    assert lost[0].detail.startswith("server lost")


@pytest.mark.parametrize(
    ("order", "expected"),
    [("rotate", [HALT, LAMP, HALT, LAMP]), ("declared", [HALT, LAMP, HALT, LAMP])],
)
def test_due_commands_are_sent_once_each_in_order(order: str, expected: list[str]) -> None:
    played = Played(order=order)
    played.port.broken = set()
    sent = [key for key in played.begin() if key != ARM]
    played.end(LAMP)
    sent += [key for key in played.wait(0.1) if key != ARM]
    assert sent == expected


def test_the_command_sent_last_goes_to_the_end() -> None:
    played = Played(order="rotate")
    played.begin()
    played.see(50)
    played.port.time += 0.05
    played.see(5)  # halt and reach by an edge: now the lamp was sent longest ago
    played.end(LAMP)
    played.port.time += 1.0
    played.engine.cycle()
    assert played.port.take() == [LAMP, HALT]


def test_random_order_is_reproducible() -> None:
    def run(seed: int) -> list[str]:
        played = Played(order="random", seed=seed)
        sent = played.begin()
        for _ in range(20):
            sent += played.end(LAMP)
            sent += played.wait(0.1)
        return sent

    assert run(1) == run(1)
    assert len({tuple(run(seed)) for seed in range(5)}) > 1


def test_time_that_jumps_back_does_not_stop_the_pace() -> None:
    played = Played(rate=10.0)
    played.port.time = 1000.0
    played.begin()
    played.port.time = 3.0
    assert HALT in played.wait(0.11)


def test_closing_cancels_goals_and_sends_the_stop_command() -> None:
    played = Played(stop_command=HALT)
    played.engine.close()
    thread = threading.Thread(target=played.engine.run)
    thread.start()
    thread.join(60)
    assert not thread.is_alive()
    assert played.port.take()[-1] == HALT


def test_inputs_wake_the_engine() -> None:
    played = Played()
    sent = threading.Event()
    send = played.port.send

    def note(key: str, data: object) -> None:
        send(key, data)
        if key == GO:
            sent.set()

    played.port.send = note  # type: ignore[method-assign]
    thread = threading.Thread(target=played.engine.run, daemon=True)
    thread.start()
    played.engine.post(SENSOR, "response", 50)
    assert sent.wait(60)
    played.engine.close()
    thread.join(60)
    assert not thread.is_alive()


def test_the_snapshot_is_not_touched_by_later_events() -> None:
    played = Played()
    played.begin()
    snapshot = played.engine.snapshot()
    played.see(50)
    assert snapshot["controller"].variables()["Sensor.clear"] is False


def test_a_deadline_in_a_thousand_centuries_is_waited_for() -> None:
    never = 1e15
    played = Played(timeout={LAMP: never, ARM: never})
    played.begin()
    played.engine.stop("enough")  # nothing but the deadlines is left to wait for
    played.engine.cycle()
    thread = threading.Thread(target=played.engine.run, daemon=True)
    thread.start()
    played.engine.close()
    thread.join(60)
    assert not thread.is_alive()
    assert played.engine.time_to_deadline() <= threading.TIMEOUT_MAX  # type: ignore[operator]


@pytest.mark.parametrize(("refuse", "sent"), [(True, 0), (False, 1)])
def test_a_number_that_is_not_finite_is_not_sent(refuse: bool, sent: int) -> None:
    played = Played()
    endless = LampController.COMMANDS[0]._replace(data=lambda _: {"x": {"y": [1.0, math.inf]}})
    played.controller.COMMANDS = (endless, *LampController.COMMANDS[1:])
    settings = Settings(refuse_not_finite=refuse)
    played.engine = controller_engine(played.controller, played.port, settings)
    played.begin()
    assert played.see(50).count(GO) == sent
    assert played.counter("failed") == 1 - sent
    failed = [e.detail for e in played.engine.recorder.take() if e.outcome == "failed"]
    assert failed == (["x.y[1] is inf"] if refuse else [])


def undefined(_: object) -> object:
    raise Undefined


@pytest.mark.parametrize("ending", ["stop", "suspend", "close"])
@pytest.mark.parametrize(
    ("data", "sent", "said"),
    [
        (lambda _: {"x": {"y": [1.5, math.nan]}, "on": True},
         {"x": {"y": [1.5, 0.0]}, "on": True}, "x.y[1] is nan"),
        (lambda _: {"x": (-math.inf, 2)}, {"x": [0.0, 2]}, "x[0] is -inf"),
        (undefined, {}, "its data have not arrived yet"),
        (lambda _: {"x": 1.5}, {"x": 1.5}, None),
    ],
)  # fmt: skip
def test_the_stop_command_is_sent_whatever_its_data(
    ending: str, data: Any, sent: object, said: str | None
) -> None:
    played = Played()
    played.controller.COMMANDS = tuple(
        row._replace(data=data) if row.key == HALT else row for row in LampController.COMMANDS
    )
    played.engine = controller_engine(played.controller, played.port, Settings(stop_command=HALT))
    played.begin()
    played.see(50)
    found = []
    played.port.send = lambda key, data: found.append((key, data))  # type: ignore[method-assign]
    getattr(played.engine, ending)(*(["enough"] if ending == "stop" else []))
    played.engine.cycle()
    assert found == [(HALT, sent)]
    texts = [text for _, text in played.port.logs if "defaults" in text]
    assert texts == ([] if said is None else [f"halt is sent with defaults: {said}"])


def test_a_suspended_engine_follows_and_commands_again_when_resumed() -> None:
    played = Played(stop_command=HALT)
    assert played.begin() == [HALT, LAMP, ARM]
    played.engine.suspend()
    played.engine.cycle()
    assert (played.port.take(), played.port.cancelled) == ([HALT], [(ARM, 2)])
    assert played.engine.stopped == INACTIVE
    assert played.see(50) == []
    assert played.controller.clear
    assert played.wait(3.0) == []
    assert played.engine.resume()
    played.engine.cycle()
    assert GO in played.port.take()
    assert played.engine.stopped is None


def test_a_safe_stop_of_a_suspended_engine_is_final_and_commands_nothing() -> None:
    """Others may command the robot while the engine is not active."""
    played = Played(stop_command=HALT)
    played.begin()
    played.engine.suspend()
    played.engine.cycle()
    played.port.take()
    played.engine.stop("broken")
    played.engine.cycle()
    assert (played.engine.stopped, played.port.take()) == ("broken", [])
    assert not played.engine.resume()
    assert played.see(50) == []


def test_only_a_suspended_engine_can_be_resumed() -> None:
    played = Played()
    played.begin()
    played.engine.stop("enough")
    played.engine.cycle()
    played.engine.suspend()
    assert not played.engine.resume()
    played.engine.cycle()
    assert played.engine.stopped == "enough"
