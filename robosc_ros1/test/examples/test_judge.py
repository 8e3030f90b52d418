"""The observer of the line follower tells right from wrong, with messages in flight."""

from __future__ import annotations

import math

import pytest

from line_follower.judge import RULES, Judge

FREE, OBSTRUCTED = 3.0, 0.2


@pytest.fixture
def judge() -> Judge:
    """A judge with a tolerance of 0.1 s to whom the way is free since second 1."""
    judge = Judge(0.1, silence=math.inf)
    judge.distance(1.0, FREE)
    return judge


def violated(judge: Judge) -> set[str]:
    judge.settle(math.inf)
    return {rule for rule, count in judge.violations.items() if count}


def test_moving_on_a_free_way_is_right(judge: Judge) -> None:
    judge.velocity(2.0, 0.4, 0.0)
    assert violated(judge) == set()


def test_moving_towards_an_obstacle_is_wrong_after_the_tolerance(judge: Judge) -> None:
    judge.distance(2.0, OBSTRUCTED)
    judge.velocity(2.05, 0.4, 0.0)  # was on its way when the obstacle came
    assert violated(judge) == set()
    judge.velocity(2.3, 0.4, 0.0)
    assert violated(judge) == {"move needs a free way"}


def test_a_command_may_come_before_the_news_that_allows_it(judge: Judge) -> None:
    judge.distance(2.0, OBSTRUCTED)
    judge.velocity(3.0, 0.4, 0.0)
    judge.settle(3.0)
    judge.distance(3.05, FREE)
    assert violated(judge) == set()


def test_moving_while_grabbing_is_wrong_until_the_grab_has_ended(judge: Judge) -> None:
    judge.distance(2.0, OBSTRUCTED)
    judge.velocity(2.0, 0.0, 0.0)
    judge.grab(3.0)
    judge.grab_ended(5.0)
    judge.distance(5.5, FREE)
    judge.velocity(6.0, 0.4, 0.0)
    assert violated(judge) == set()
    judge.grab(6.0)
    judge.velocity(7.0, 0.4, 0.0)
    assert "move needs an idle grabber" in violated(judge)


def test_stopping_needs_a_reason(judge: Judge) -> None:
    judge.velocity(2.0, 0.0, 0.0)
    assert violated(judge) == {"stop needs a reason"}


def test_stopping_before_the_first_measurement_is_right() -> None:
    judge = Judge(0.1, silence=math.inf)
    judge.velocity(1.0, 0.0, 0.0)
    judge.distance(5.0, FREE)
    assert violated(judge) == set()


def test_silence_is_a_reason_to_stop_and_forbids_to_move() -> None:
    judge = Judge(0.1)
    judge.distance(1.0, FREE)
    judge.velocity(1.4, 0.4, 0.0)
    judge.line(1.45, True)
    judge.velocity(1.55, 0.4, 0.0)  # was on its way when the silence began
    judge.velocity(1.7, 0.0, 0.0)
    judge.distance(2.0, FREE)
    judge.velocity(2.3, 0.4, 0.0)
    assert violated(judge) == set()
    judge.velocity(2.7, 0.4, 0.0)
    assert violated(judge) == {"move needs measurements"}


def test_grabbing_needs_an_obstacle_and_a_halted_robot(judge: Judge) -> None:
    judge.velocity(2.0, 0.4, 0.0)
    judge.grab(3.0)
    assert violated(judge) == {"grab needs an obstacle", "grab needs a halted robot"}


def test_light_follows_the_line_and_is_switched_only_to_change_it(judge: Judge) -> None:
    judge.line(2.0, False)
    judge.light(2.01, True)
    judge.line(3.0, True)
    judge.light(3.01, False)
    assert violated(judge) == set()
    judge.light(4.0, False)
    assert violated(judge) == {"light is switched to change it"}
    judge.light(5.0, True)
    assert violated(judge) == {"light is switched to change it", "light shows the line"}


def test_running_into_an_obstacle_is_counted(judge: Judge) -> None:
    judge.bump(2.0)
    judge.bump(3.0)
    assert violated(judge) == {"nothing is touched"}
    assert judge.violations["nothing is touched"] == 2


def test_how_late_the_observer_was_about_that_time_is_added_to_the_tolerance(judge: Judge) -> None:
    judge.late(4.5, 0.3)
    judge.velocity(5.0, 0.0, 0.0)
    judge.distance(5.35, OBSTRUCTED)  # the reason came before, but was heard later
    assert violated(judge) == set()
    judge.distance(6.0, FREE)
    judge.velocity(7.0, 0.0, 0.0)
    judge.distance(7.35, OBSTRUCTED)
    assert violated(judge) == {"stop needs a reason"}


def test_what_is_told_of_lateness_is_what_was_added(judge: Judge) -> None:
    judge.late(4.5, 30.0)
    judge.velocity(5.0, 0.0, 0.0)
    judge.distance(6.0 + judge.tolerance + 0.01, OBSTRUCTED)
    assert violated(judge) == {"stop needs a reason"}
    assert judge.latest == 1.0


def test_history_is_forgotten(judge: Judge) -> None:
    for second in range(2, 1000):
        judge.distance(second, FREE if second % 2 else OBSTRUCTED)
        judge.velocity(second, 0.4 if second % 2 else 0.0, 0.0)
        judge.late(second, 0.01)
        judge.settle(second)
    assert len(judge._history) < 10
    assert len(judge._late) < 10
    assert violated(judge) == set()


def test_every_rule_can_be_broken() -> None:
    """Each rule is named by one of the tests above; a rule that is forgotten here fails."""
    judge = Judge(0.0)
    judge.distance(1.5, OBSTRUCTED)
    judge.velocity(1.6, 0.4, 0.0)
    judge.velocity(2.0, 0.4, 0.0)
    judge.grab(3.0)
    judge.velocity(4.0, 0.4, 0.0)
    judge.grab_ended(5.0)
    judge.distance(6.0, FREE)
    judge.velocity(6.2, 0.0, 0.0)
    judge.grab(8.0)
    judge.line(9.0, True)
    judge.light(10.0, True)
    judge.light(11.0, True)
    judge.bump(12.0)
    assert violated(judge) == set(RULES)
