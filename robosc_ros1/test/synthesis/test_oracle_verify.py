"""The independent checker finds what is wrong with a supervisor, and nothing in a right one."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import pytest
import ros_support
from random_models import random_model
from synthesis.oracle import Oracle
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.errors import StateSpaceError
from robosc.expr.tree import FALSE, TRUE, Expr
from robosc.language.events import EventKind
from robosc.supervisor import Supervisor
from robosc.synthesis.documents import step_document
from robosc.synthesis.verify import verification
from robosc.synthesis.verify.verification import verify
from robosc.synthesis.verify.verify_report import VerifyReport, verify_document

pytestmark = pytest.mark.slow

ARM = """
robot Arm {
    component Arm {
        incoming message lift with type: none
        incoming message drop with type: none
        outgoing message slip with type: integer(1..2)
        behaviour {
            variable height: integer(0..4)
            initial marked state up {
                on request to lift do height := height + 1
                on request to drop if height > 0 do height := height - 1
                on response from slip if height > 2 do height := height - value goto down
            }
            state down { on request to lift if height = 2 goto up }
        }
    }
    requirement drop needs Arm.height != 2
    requirement never Arm.height = 4
}
"""


def supervisor_of(text: str) -> Supervisor:
    return pipeline.synthesize(robot_of(text), "explicit")


def with_guard(supervisor: Supervisor, name: str, expr: Expr) -> Supervisor:
    """The same supervisor with the guard of one request replaced."""
    guards = [
        replace(guard, expr=expr)
        if guard.event.name == name and guard.event.kind is EventKind.REQUEST
        else guard
        for guard in supervisor.guards
    ]
    return replace(supervisor, guards=tuple(guards))


def failing(report: VerifyReport) -> dict[str, str | None]:
    return {check.name: check.detail for check in report.checks if not check.holds}


def trace(report: VerifyReport, name: str) -> list[str]:
    check = next(check for check in report.checks if check.name == name)
    return [f"{step.event.name}{list(step.values) or ''}" for step in check.trace]


def test_right_supervisor_is_verified() -> None:
    supervisor = supervisor_of(ARM)
    report = verify(supervisor)
    assert failing(report) == {}
    assert report.verified
    assert report.states == supervisor.controlled_states
    assert report.transitions == supervisor.controlled_transitions
    assert [check.name for check in report.checks] == [
        "safe",
        "controllable",
        "nonblocking",
        "maximally permissive",
        "controlled states",
        "controlled transitions",
        "plant states",
    ]


def test_state_requirement_that_fails_is_unsafe() -> None:
    report = verify(with_guard(supervisor_of(ARM), "lift", TRUE))
    assert failing(report)["safe"] == "'requirement never Arm.height = 4' fails"
    assert trace(report, "safe") == ["lift"] * 4


def test_request_against_a_requirement_is_unsafe() -> None:
    report = verify(with_guard(supervisor_of(ARM), "drop", TRUE))
    assert failing(report)["safe"] == "the request of drop violates a requirement"
    assert trace(report, "safe") == ["lift", "lift", "drop"]


def test_range_left_by_an_uncontrollable_event_is_unsafe() -> None:
    text = """
        robot Buffer {
            interface link use Thing from some_robot_msgs
            component Buffer {
                service fill with request: none, response: none links link
                incoming message take with type: none
                behaviour {
                    variable n: integer(0..1)
                    on response from fill do n := n + 1
                    on request to take do n := n - 1
                    initial marked state only {}
                }
            }
            requirement always Buffer.n >= 0
        }
    """
    right = supervisor_of(text)
    assert failing(verify(right)) == {}
    report = verify(with_guard(right, "fill", TRUE))
    assert failing(report)["safe"] == ("the response of fill may take a variable out of its range")
    assert trace(report, "safe") == ["fill", "fill", "fill"]


def test_state_without_a_way_to_a_marked_one_is_blocking() -> None:
    text = """
        robot Trap {
            component Trap {
                incoming message enter with type: none
                incoming message leave with type: none
                behaviour {
                    initial marked state outside { on request to enter goto inside }
                    state inside { on request to leave goto outside }
                }
            }
        }
    """
    report = verify(with_guard(supervisor_of(text), "leave", FALSE))
    assert failing(report)["nonblocking"] == "no marked state can be reached any more"
    assert trace(report, "nonblocking") == ["enter"]


def test_event_forbidden_without_need_is_not_maximally_permissive() -> None:
    report = verify(with_guard(supervisor_of(ARM), "lift", FALSE))
    found = failing(report)
    assert set(found) == {
        "maximally permissive",
        "controlled states",
        "controlled transitions",
    }
    assert found["maximally permissive"] == "the request of lift is forbidden unnecessarily"
    assert trace(report, "maximally permissive") == ["lift"]


def test_missing_guard_is_told() -> None:
    supervisor = supervisor_of(ARM)
    report = verify(replace(supervisor, guards=supervisor.guards[1:]))
    assert failing(report)["controllable"] == "the request of lift has no guard"


def test_guard_on_an_uncontrollable_event_is_told() -> None:
    supervisor = supervisor_of(ARM)
    slip = next(e for e in supervisor.plant.events if not e.controllable)
    extra = replace(supervisor.guards[0], event=slip)
    report = verify(replace(supervisor, guards=(*supervisor.guards, extra)))
    assert failing(report)["controllable"] == "the response of slip cannot be forbidden"


def test_wrong_counts_are_told() -> None:
    supervisor = supervisor_of(ARM)
    wrong = replace(supervisor, plant_states=supervisor.plant_states + 1)
    assert list(failing(verify(wrong))) == ["plant states"]


def test_empty_supervisor_is_verified_only_where_nothing_can_be_kept() -> None:
    hopeless = supervisor_of(ARM.replace("Arm.height = 4", "Arm.up"))
    assert hopeless.empty
    assert verify(hopeless).verified
    lazy = replace(supervisor_of(ARM), empty=True, controlled_states=0, controlled_transitions=0)
    assert list(failing(verify(lazy))) == ["maximally permissive"]


def test_search_stops_at_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verification, "usable", lambda: False)
    supervisor = supervisor_of(ARM)
    assert verify(supervisor, limit=supervisor.plant_states).verified
    with pytest.raises(StateSpaceError, match="3 states"):
        verify(supervisor, limit=3)


def test_document() -> None:
    supervisor = with_guard(supervisor_of(ARM), "lift", FALSE)
    document = verify_document(verify(supervisor), step_document)
    assert document["version"] == 1
    assert document["robot"] == "Arm"
    assert document["verified"] is False
    assert document["properties"] == dict(supervisor.properties)
    assert {
        "name": "maximally permissive",
        "holds": False,
        "detail": "the request of lift is forbidden unnecessarily",
        "trace": [{"kind": "request", "name": "lift", "value": None}],
    } in document["checks"]


EXAMPLES = sorted(
    path for path in Path(ros_support.EXAMPLES).rglob("*.rscd") if path.parent.name != "libraries"
)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_supervisor_of_each_example_is_verified(path: Path) -> None:
    assert failing(verify(pipeline.synthesize(pipeline.load(path).robot))) == {}


def test_every_wrong_guard_is_found() -> None:
    """Random robots: a guard that is wrong in some controlled state makes the verdict fail."""
    wrong = 0
    for seed in range(36):
        robot = robot_of(random_model(random.Random(seed), 1))
        supervisor, oracle = pipeline.synthesize(robot, "explicit"), Oracle(robot)
        if supervisor.empty:
            continue
        for position, guard in enumerate(supervisor.guards):
            for constant in (TRUE, FALSE):
                guards = list(supervisor.guards)
                guards[position] = replace(guard, expr=constant)
                changed = replace(supervisor, guards=tuple(guards))
                differs = any(
                    (event in oracle.enabled(state)) != (constant == TRUE)
                    for state in oracle.controlled[0]
                    for event in oracle.possible(state)
                    if (event.kind, event.key, event.index)
                    == (guard.event.kind, guard.event.key, guard.event.index)
                )
                wrong += differs
                assert verify(changed).verified == (not differs)
    assert wrong > 30
