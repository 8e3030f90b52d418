"""Cancelled goals: they go on until their server has ended them, in one of several ways."""

from __future__ import annotations

import pytest
from runtime.lamp_robot import ARM
from runtime.played_engine import Played

from robosc.runtime.core.calls import Failure


def phase(played: Played) -> str:
    (row,) = (c for c in played.controller.COMMUNICATIONS if c.key == ARM)
    return played.controller.phase(row)


def ends(played: Played) -> list[tuple[str, str | None]]:
    """The events of the arm since the last call, except its request, with what is told of them."""
    events = [e for e in played.engine.recorder.take() if e.name == "reach"]
    return [(e.kind, e.detail) for e in events if e.kind != "request"]


@pytest.fixture
def played() -> Played:
    """An arm that reaches, for a server that accepted it."""
    made = Played(rate=10.0, goal_timeout={ARM: 30.0}, server_lost_after=5.0)
    made.begin()
    made.end(ARM, "accepted")
    return made


@pytest.fixture
def cancelled(played: Played) -> Played:
    played.see(50)
    assert phase(played) == "cancelling"
    assert played.port.cancelled == [(ARM, played.port.tokens[ARM])]
    assert ends(played) == [("cancel", None)]
    return played


@pytest.mark.parametrize("kind", ["cancelled", "response", "error"])
def test_the_server_says_how_it_ended(cancelled: Played, kind: str) -> None:
    cancelled.end(ARM, kind, Failure("why", "result") if kind != "response" else "result")
    assert ends(cancelled) == [(kind, "why" if kind == "error" else None)]
    assert phase(cancelled) == "idle"
    cancelled.end(ARM, "response")
    assert (ends(cancelled), cancelled.counter("late")) == ([], 1)


def test_nothing_is_requested_until_it_has_ended(cancelled: Played) -> None:
    cancelled.see(5)  # the arm may reach again
    assert ARM not in cancelled.wait(100.0)
    assert ARM not in {key for key, _ in cancelled.port.abandoned}
    assert ARM not in cancelled.end(ARM, "cancelled"), "its end is no reason to begin"
    assert ARM in cancelled.wait(0.1)


def test_feedback_of_a_cancelled_goal_is_no_event(cancelled: Played) -> None:
    cancelled.end(ARM, "feedback", 0.5)
    assert (ends(cancelled), cancelled.counter("late")) == ([], 1)
    assert cancelled.counter("mismatches") == 0


def test_silence_does_not_end_it_but_a_server_that_is_gone_does(cancelled: Played) -> None:
    cancelled.port.silent = 1000.0
    cancelled.wait(1000.0)
    assert (ends(cancelled), phase(cancelled)) == ([], "cancelling")
    cancelled.port.gone = True
    cancelled.wait(0.25)
    assert ends(cancelled) == [("error", "server lost: it is not there any more")]
    assert phase(cancelled) == "idle"


def test_what_others_cancel_is_an_error(played: Played) -> None:
    played.end(ARM, "cancelled", Failure("preempted", "result"))
    assert ends(played) == [("error", "preempted")]


def test_a_goal_that_takes_too_long_is_cancelled_and_then_ends(played: Played) -> None:
    played.wait(29.9)
    assert played.port.cancelled == []
    played.wait(0.2)
    assert played.port.cancelled == [(ARM, played.port.tokens[ARM])]
    assert (ends(played), phase(played)) == ([], "busy")
    played.wait(100.0)
    assert (ends(played), phase(played)) == ([], "busy")
    played.end(ARM, "cancelled", "preempted")
    assert ends(played) == [("error", "deadline exceeded")]


def test_the_log_tells_of_the_deadline_and_of_the_end(played: Played) -> None:
    played.wait(30.1)
    played.end(ARM, "cancelled", "preempted")
    texts = [text for _, text in played.port.logs]
    assert texts[-2:] == [
        "reach is cancelled: deadline exceeded",
        "reach failed: deadline exceeded",
    ]


@pytest.mark.parametrize("kind", ["response", "error"])
def test_how_a_goal_ends_that_took_too_long(played: Played, kind: str) -> None:
    played.wait(30.1)
    played.end(ARM, kind, "aborted")
    assert ends(played) == [(kind, "deadline exceeded" if kind == "error" else None)]


def test_a_cancel_of_a_goal_that_took_too_long_makes_it_a_cancelled_one(played: Played) -> None:
    played.wait(30.1)
    played.see(50)
    played.end(ARM, "cancelled", "preempted")
    assert ends(played) == [("cancel", None), ("cancelled", None)]


def not_accepted() -> Played:
    made = Played(rate=10.0, timeout={ARM: 2.0}, goal_timeout={ARM: 30.0}, server_lost_after=5.0)
    made.begin()
    made.wait(2.1)
    assert made.port.cancelled == [(ARM, made.port.tokens[ARM])]
    assert (ends(made), phase(made)) == ([], "busy")
    return made


def test_a_goal_that_is_not_accepted_ends_when_its_cancel_is_answered() -> None:
    played = not_accepted()
    played.end(ARM, "cancelled", "recalled")
    assert ends(played) == [("error", "no answer in time")]


def test_a_goal_that_is_not_accepted_ends_at_last_without_an_answer() -> None:
    played = not_accepted()
    played.wait(4.8)
    assert ends(played) == []
    played.wait(0.3)
    assert ends(played) == [("error", "no answer in time")]
    assert played.port.abandoned[-1] == (ARM, played.port.cancelled[0][1])


def test_a_goal_that_is_accepted_too_late_goes_on_until_it_ends() -> None:
    played = not_accepted()
    played.end(ARM, "accepted")
    played.wait(100.0)
    assert (ends(played), phase(played)) == ([], "busy")
    played.end(ARM, "cancelled", "preempted")
    assert ends(played) == [("error", "no answer in time")]


def test_the_end_after_a_safe_stop_is_an_error(played: Played) -> None:
    played.engine.stop("enough")
    played.engine.cycle()
    assert played.port.cancelled == [(ARM, played.port.tokens[ARM])]
    played.end(ARM, "cancelled", "preempted")
    assert ends(played) == [("error", "preempted")]
