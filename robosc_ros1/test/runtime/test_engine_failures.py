"""What the engine does on mismatches, failing calls and messages, and endless transitions."""

from __future__ import annotations

import pytest
from runtime.lamp_robot import ARM, HALT, LAMP, SENSOR, LampController
from runtime.played_engine import Played

from robosc.runtime.core.commanding import controller_engine


def test_values_out_of_range_are_mismatches_and_change_nothing() -> None:
    played = Played()
    played.begin()
    assert played.see(500) == []
    assert played.counter("mismatches") == 1
    assert played.controller.variables()["Motor.speed"] == 0.0


def test_what_repeats_is_logged_once_per_second_with_how_often() -> None:
    played = Played()
    played.begin()
    for _ in range(250):
        played.port.time += 0.01
        played.see(500)
    assert played.counter("mismatches") == 250
    texts = [text for _, text in played.port.logs if "outside" in text]
    assert [text.partition(" (")[2] for text in texts] == [
        "", "99 more since the last report)", "99 more since the last report)",
    ]  # fmt: skip


def test_messages_that_are_not_what_the_model_says_are_mismatches() -> None:
    played = Played()
    played.begin()
    played.engine.post(SENSOR, "response", "far")
    played.engine.cycle()
    assert played.counter("mismatches") == 1
    assert played.engine.stopped is None


def test_an_unusable_response_ends_its_request_as_an_error() -> None:
    played = Played()
    played.begin()
    played.end(LAMP, payload="nonsense")
    assert (played.counter("mismatches"), played.counter("errors")) == (1, 1)
    assert not played.controller.lamp_busy


def test_the_policy_stop_makes_a_safe_stop_of_a_mismatch() -> None:
    played = Played(on_mismatch="stop", stop_command=HALT, exit_on_stop=True)
    played.begin()
    played.see(50)
    token = played.port.tokens[ARM]
    assert played.see(500) == [HALT]
    assert played.engine.stopped == "mismatch: range is 500, outside 0..100"
    assert (ARM, token) in played.port.cancelled
    assert played.port.exits == [1]
    assert played.wait(10.0) == []
    assert played.see(5) == []


def test_a_cycle_of_own_steps_is_a_safe_stop() -> None:
    played = Played()
    played.controller.spin = 1000
    played.begin()
    assert played.engine.stopped is not None
    assert "never end" in played.engine.stopped


def test_an_unforeseen_exception_is_a_safe_stop() -> None:
    played = Played()
    broken = LampController.COMMANDS[0]._replace(guard=lambda _: 1 / 0 > 0)
    played.controller.COMMANDS = (broken,)
    played.engine = controller_engine(played.controller, played.port)
    played.begin()
    assert played.engine.stopped is not None
    assert "ZeroDivisionError" in played.engine.stopped


def test_a_limit_of_memory_is_told_as_the_cause_of_a_safe_stop() -> None:
    """What asks for more than the machine, or ``ulimit -v``, gives."""
    played = Played(stop_command=HALT)
    played.begin()
    played.see(50)
    token = played.port.tokens[ARM]
    played.engine.invoke(lambda: bytearray(2**62))  # type: ignore[arg-type, return-value]
    played.engine.cycle()
    assert played.port.take() == [HALT]
    assert (ARM, token) in played.port.cancelled
    assert played.engine.stopped is not None
    assert "no memory is left, or a limit of it is reached" in played.engine.stopped
    assert any("MemoryError" in text for _, text in played.port.logs)


def test_a_message_that_cannot_be_sent_changes_nothing_and_is_tried_again_at_the_rate() -> None:
    played = Played(rate=10.0)
    played.port.broken = {HALT}
    played.begin()
    assert played.counter("commands") == 2  # the lamp and the arm
    played.wait(0.95)
    assert played.counter("failed") == 10
    assert played.engine.stopped is None


@pytest.mark.parametrize("key", [LAMP, ARM])
def test_a_call_that_cannot_be_started_is_a_request_and_an_error(key: str) -> None:
    played = Played(rate=10.0)
    played.port.broken = {key}
    played.begin()
    played.wait(0.95)
    ends = [
        (e.kind, e.detail)
        for e in played.engine.recorder.take()
        if e.name == {LAMP: "light", ARM: "reach"}[key]
    ]
    assert ends == [("request", None), ("error", "broken")] * 10
    assert played.counter("failed") == 0
