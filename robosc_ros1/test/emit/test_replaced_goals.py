"""A goal with ``goals: replace`` may replace the one that is busy, from the plant to the engine."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from runtime.lamp_robot import PlayedPort
from runtime.test_supervisor_engine import GuardedPort

from robosc.emit.package.config import declared_communications
from robosc.runtime.core.calls import REJECTED, Failure
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import read
from robosc.runtime.judge.supervising import supervisor_engine

MODEL = """
robot Rover {
    component Base {
        outgoing message wish with identifier: "/wish", type: integer(0..9)
        outgoing message allow with identifier: "/allow", type: boolean
        action go with goals: replace, request: integer, response: none, feedback: none links go_to
        incoming message beep with identifier: "/beep", type: none
        behaviour {
            variable place: integer(0..9) = 0
            variable allowed: boolean = true
            variable failed: integer(0..5) = 0
            on response from wish do place := value
            on response from allow do allowed := value
            on error from go if reason = rejected do failed := 1
            on error from go if reason = timeout do failed := 2
            on error from go if reason = failed do failed := 3
            on error from go if reason = lost do failed := 4
            initial marked state only {}
        }
    }
    interface go_to use Go from rover_msgs
    provide go with Base.place
    requirement go needs Base.allowed
    prefer go over beep
}
"""
PERFORMED = MODEL.replace("provide go with Base.place", "").replace(
    "only {}", "only performs go with place then goto only"
)
KEY = "Base.go"


class Played:
    """The controller of the model on a port, whose server answers as the test says."""

    def __init__(self, model: str = MODEL) -> None:
        supervisor = supervisor_of(model)
        settings, _ = read(declared_communications(supervisor.plant.robot), {})
        self.port = PlayedPort()
        self.steady = 0.0
        controller = controller_class(supervisor)[0]()
        self.engine = controller_engine(controller, self.port, settings, lambda: self.steady)
        self.engine.begin()
        self.engine.cycle()

    @property
    def phase(self) -> str:
        (own,) = (c for c in self.engine.controller.COMMUNICATIONS if c.key == KEY)
        return self.engine.controller.phase(own)

    @property
    def failed(self) -> int:
        return int(self.engine.controller.variables()["Base.failed"])

    def goals(self) -> list[int]:
        """The goals that were sent since the last call."""
        found = [data for key, data in self.port.sent if key == KEY]
        self.port.sent.clear()
        return [next(iter(data.values())) for data in found]

    def cancelled(self) -> list[int]:
        """The tokens of the goals that were cancelled since the last call."""
        found = [token for _, token in self.port.cancelled]
        self.port.cancelled.clear()
        return found

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.port.time += 0.05
            self.steady += 0.05
            self.engine.cycle()

    def hear(self, name: str, value: Any) -> None:
        self.engine.poster([f"Base.{name}"])(SimpleNamespace(data=value))
        self.engine.cycle()

    def report(self, token: int, kind: str, payload: Any = None) -> None:
        self.engine.report(KEY, token, kind, payload)
        self.engine.cycle()

    def replaced(self) -> tuple[int, int]:
        """Have a goal accepted and replaced; return the tokens of both."""
        first = self.port.tokens[KEY]
        self.report(first, "accepted")
        self.wait(0.2)
        self.hear("wish", 7)
        assert self.goals() == [0, 7]
        assert (self.phase, self.cancelled()) == ("busy", [])
        return first, self.port.tokens[KEY]


def test_in_the_plant_a_busy_action_takes_a_request_a_cancelling_one_does_not() -> None:
    (request,) = (
        e for e in supervisor_of(MODEL).plant.events if (e.kind.word, e.name) == ("request", "go")
    )
    assert request.phase is not None
    assert (request.phase.sources, request.phase.target) == ((0, 1), 1)


@pytest.mark.parametrize("model", [MODEL, PERFORMED])
def test_only_other_data_replace_a_goal_at_most_at_its_rate(model: str) -> None:
    played = Played(model)
    assert played.goals() == [0]
    played.wait(5.0)
    assert played.goals() == []
    played.hear("wish", 3)
    played.hear("wish", 4)  # before the next beat of the goal that was sent at once
    assert played.goals() == [3]
    played.wait(0.2)
    assert played.goals() == [4]


def test_a_goal_that_is_to_be_replaced_holds_back_nothing() -> None:
    played = Played()
    assert "Base.beep" in played.port.take()


def test_the_goal_before_is_to_end_when_the_new_one_is_accepted() -> None:
    played = Played()
    first, second = played.replaced()
    played.report(second, "accepted")
    assert played.cancelled() == [first]
    played.report(first, "cancelled", "preempted")
    assert played.phase == "busy"
    played.report(second, "response", SimpleNamespace())
    assert (played.phase, played.failed) == ("idle", 0)


def test_it_is_busy_until_both_have_ended() -> None:
    played = Played()
    first, second = played.replaced()
    played.report(second, "accepted")
    played.report(second, "response", SimpleNamespace())
    played.wait(20.0)
    assert played.phase == "busy"
    played.report(first, "response", SimpleNamespace())
    assert (played.phase, played.failed) == ("idle", 0)


def test_if_the_new_goal_is_rejected_the_one_before_is_cancelled_too() -> None:
    """One error tells both; as something was begun, it does not say rejected."""
    played = Played()
    first, second = played.replaced()
    played.report(second, "error", Failure("rejected", None, REJECTED))
    assert (played.phase, played.failed, played.cancelled()) == ("busy", 0, [first])
    played.report(first, "cancelled", "preempted")
    assert (played.phase, played.failed) == ("idle", 3)
    ends = [e for e in played.engine.recorder.take() if e.kind == "error"]
    assert [e.detail for e in ends] == ["rejected; the goal before it was cancelled"]


def test_if_the_new_goal_is_not_answered_both_are_cancelled() -> None:
    played = Played()
    first, second = played.replaced()
    played.wait(5.2)
    assert sorted(played.cancelled()) == [first, second]
    played.wait(5.2)
    assert (played.phase, played.cancelled()) == ("busy", [first])
    played.report(first, "cancelled", "preempted")
    assert (played.phase, played.failed) == ("idle", 2)


def test_a_cancel_is_for_all_goals() -> None:
    played = Played()
    first, second = played.replaced()
    played.hear("allow", False)
    assert (played.phase, sorted(played.cancelled())) == ("cancelling", [first, second])
    played.hear("wish", 2)
    played.report(second, "cancelled", "preempted")
    assert (played.phase, played.goals()) == ("cancelling", [])
    played.report(first, "cancelled", "preempted")
    assert played.phase == "idle"


def test_a_replacing_goal_that_cannot_be_sent_ends_the_one_before() -> None:
    played = Played()
    first = played.port.tokens[KEY]
    played.report(first, "accepted")
    played.wait(0.2)
    played.port.broken = {KEY}
    played.hear("wish", 7)
    assert (played.phase, played.cancelled()) == ("busy", [first])
    played.report(first, "cancelled", "preempted")
    assert (played.phase, played.failed) == ("idle", 3)


def test_the_loss_of_the_server_ends_all() -> None:
    played = Played()
    first, second = played.replaced()
    played.report(second, "accepted")
    played.report(second, "response", SimpleNamespace())
    played.port.gone = True
    played.wait(0.3)
    kinds = [e.kind for e in played.engine.recorder.take() if e.name == "go"]
    assert kinds == ["request", "request", "response"]
    assert [token for _, token in played.port.abandoned] == [first]


def test_nothing_is_requested_while_the_end_of_the_goal_before_is_awaited() -> None:
    played = Played()
    first, second = played.replaced()
    played.report(second, "error", Failure("rejected", None, REJECTED))
    played.hear("wish", 9)
    played.wait(1.0)
    assert (played.phase, played.goals()) == ("busy", [])
    played.report(first, "response", SimpleNamespace())
    assert (played.phase, played.failed) == ("idle", 3)
    played.wait(0.2)
    assert played.goals() == [9]


def test_a_supervisor_tells_how_a_goal_ended_before_the_next_one_takes_its_place() -> None:
    """The controller may send another one before those have ended that the goal replaced."""
    supervisor = supervisor_of(MODEL, supervises=True)
    settings, _ = read(declared_communications(supervisor.plant.robot), {})
    port = GuardedPort()
    guard = supervisor_engine(controller_class(supervisor)[0](), port, settings, lambda: 0.0)
    guard.begin()
    answers: list[tuple[int, str, Any]] = []

    def request(number: int) -> None:
        answer = lambda kind, what: answers.append((number, kind, what))  # noqa: E731
        guard.role.request(KEY, SimpleNamespace(data=number), number, answer)
        guard.cycle()

    def report(token: int, kind: str, payload: Any = None) -> None:
        guard.report(KEY, token, kind, payload)
        guard.cycle()

    request(1)
    first = port.tokens[KEY]
    request(2)
    report(port.tokens[KEY], "error", "no answer in time")
    assert answers == [(1, "passed", None), (2, "passed", None)]
    request(3)
    assert answers[2:] == [(2, "error", "no answer in time"), (3, "passed", None)]
    report(first, "cancelled", "preempted")
    report(port.tokens[KEY], "error", "aborted")
    assert answers[4:] == [(3, "error", "aborted")]
