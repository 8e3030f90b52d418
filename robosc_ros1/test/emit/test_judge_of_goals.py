"""The test of a package follows each goal by itself: it finds ends that are not those of the goal.

The controller is right; what is faulty is the part that sends its goals and reports what becomes of
them, which is planted here.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from emit.judged_controllers import Robot, judged, judging_model

from robosc.runtime.calls import Failure

MODEL = """
robot Rover {
    component Base {
        outgoing message wish with identifier: "/wish", type: boolean
        action go with identifier: "/go",
            request: Goal,
            response: Found,
            feedback: none links go_to
        action back with identifier: "/go",
            request: Goal,
            response: Found,
            feedback: none links go_to
        behaviour {
            variable wanted: boolean = true
            variable found: integer(0..9) = 0
            on response from wish do wanted := value
            on response from go do found := value.count
            on cancelled from go do found := 9
            initial marked state only {}
        }
    }
    interface go_to use Go from rover_msgs
    datatype object Found {
        count: integer(0..9)
    }
    datatype object Goal {
        home: boolean
    }
    provide go with { home: false }
    provide back with { home: true }
    requirement go needs Base.wanted
    requirement back needs !Base.wanted
}
"""
GO, BACK = "Base.go", "Base.back"


@pytest.fixture(scope="module")
def judging(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    with judging_model(tmp_path_factory.mktemp("goals"), MODEL) as both:
        yield both


class Hasty(Robot):
    """A cancelled goal counts as over at once."""

    engine: Any

    def act(self, engine: Any, step: Any, phase: dict[str, str]) -> None:
        self.engine = engine
        super().act(engine, step, phase)

    def cancel(self, key: str, token: int) -> None:
        super().cancel(key, token)
        self.engine.report(key, token, "cancelled", "preempted")


class Blind(Robot):
    """Whatever a cancelled goal came to, it counts as cancelled."""

    def _answer(self, engine: Any, key: str, kind: str, message: Any) -> None:
        def report(key: str, token: int, kind: str, payload: Any) -> None:
            if kind != "feedback" and token in self.withdrawn:
                kind, payload = "cancelled", Failure("preempted")
            engine.report(key, token, kind, payload)

        super()._answer(SimpleNamespace(report=report), key, kind, message)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("fault", "complaint"),
    [
        (Hasty, "while a goal runs"),
        (Blind, "whose goal ended as: response"),
    ],
)
def test_an_end_that_is_not_that_of_the_goal_is_found(
    judging: tuple[Any, str], fault: type[Robot], complaint: str
) -> None:
    judge, source = judging
    faults = judged(judge, source, kind=fault).faults
    assert any(complaint in text for text in faults), faults


@pytest.mark.usefixtures("judging")
def test_no_goal_may_come_to_a_server_while_another_runs() -> None:
    runs = importlib.import_module("goals").Goals()
    runs.begin(GO, 1, [GO, BACK])
    runs.end(GO, 1, "response")
    runs.begin(BACK, 2, [GO, BACK])
    assert runs.faults == []
    runs.begin(GO, 3, [GO, BACK])
    assert runs.faults == [f"a goal of {GO} came while one of {BACK} ran"]
