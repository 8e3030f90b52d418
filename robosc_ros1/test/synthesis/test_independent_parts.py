"""Robots of independent parts, which are solved apart: nothing of the result may differ."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import count, islice

import pytest
import steep_families
from families import switches
from random_models import random_model
from synthesis.differential import differences
from synthesis.oracle import Oracle
from synthesis.plants import plant_of, supervisor_of
from synthesis.subject import robot_of

from robosc.model.entities import Robot
from robosc.plant.build import lower
from robosc.supervisor import Supervisor
from robosc.synthesis import compute, decomposition, synthesize

CLOCK = (
    "component Clock { outgoing message tick with type: none behaviour {"
    " initial marked state a { on response from tick goto b }"
    " state b { transition goto c } marked state c { transition goto a } } }"
)


@pytest.fixture
def apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small robots are taken apart as well, into parts as small as can be."""
    monkeypatch.setattr(compute, "_WHOLE", 0)
    monkeypatch.setattr(compute, "_TOGETHER", 0)


def robots(first: int) -> Iterator[Robot]:
    """Some random robots of several parts."""
    found = (robot_of(random_model(random.Random(s), 1 + s % 3)) for s in count(first))
    return islice((r for r in found if len(decomposition.independent_parts(lower(r), 0)) > 1), 5)


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "first"), [("explicit", 900), ("bdd", 930)])
@pytest.mark.usefixtures("apart")
def test_random_robots_are_as_the_oracle_has_them(engine: str, first: int) -> None:
    for robot in robots(first):
        assert differences(robot, Oracle(robot), engine) == [], robot.name


@pytest.mark.slow
def test_random_robots_are_explained_as_in_one_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    plants = [lower(robot) for robot in robots(1000)]
    whole = [_told(synthesize(plant, "explicit")) for plant in plants]
    monkeypatch.setattr(compute, "_WHOLE", 0)
    monkeypatch.setattr(compute, "_TOGETHER", 0)
    assert [_told(synthesize(plant, "explicit")) for plant in plants] == whole


def _told(found: Supervisor) -> object:
    """All that a user reads but for traces, of which several can be the shortest."""
    if found.empty:
        return "empty"
    return (
        [(guard.event, guard.status) for guard in found.guards],
        [(e.event, e.remedy, len(e.trace)) for e in found.explanations],
        found.properties,
        sorted((d.code, d.severity.value, d.span.line, d.span.column) for d in found.diagnostics),
    )


@pytest.mark.parametrize("engine", ["explicit", "auto"])
def test_unrelated_components_multiply(engine: str) -> None:
    found = supervisor_of(steep_families.unrelated(60), engine)
    one = supervisor_of(steep_families.unrelated(1), engine)
    assert found.plant_states == one.plant_states**60
    assert found.controlled_states == one.controlled_states**60
    assert (
        found.controlled_transitions == 60 * one.controlled_transitions * one.controlled_states**59
    )
    assert [guard.event for guard in found.guards] == [
        e for e in found.plant.events if e.controllable
    ]
    assert [e.event for e in found.explanations] == [guard.event for guard in found.guards]


def test_one_part_without_a_controller_leaves_nothing(apart: None) -> None:
    found = supervisor_of(
        "component A { incoming message go with type: none behaviour {"
        " initial marked state s { on request to go goto s } } }"
        + switches(2)
        + "requirement never S0.x and S1.x"
    )
    assert found.empty
    assert [guard.status for guard in found.guards] == ["never"]
    assert (found.plant_states, found.controlled_states, found.controlled_transitions) == (4, 0, 0)
    assert [d.code for d in found.diagnostics] == ["empty-supervisor"]


def test_the_step_bound_is_that_of_all_parts(apart: None) -> None:
    text = CLOCK + CLOCK.replace("Clock", "Other").replace("tick", "tock")
    assert len(decomposition.independent_parts(plant_of(text), 0)) == 2
    assert supervisor_of(text).step_bound == 4
    assert dict(supervisor_of(text).properties)["bounded response"]


@pytest.mark.parametrize(
    "question",
    [
        "prefer go0 over go1",
        "requirement go0 needs B1.up",
        "requirement B1.up disables { go0 }",
        "requirement always B0.up or !B1.up",
        "provide go0 with 1 if B1.up provide go0 with 2",
    ],
)
def test_what_speaks_of_two_components_keeps_them_together(question: str) -> None:
    text = "".join(
        f"component B{i} {{ incoming message go{i} with type: integer"
        f" outgoing message came{i} with type: boolean behaviour {{ variable up: boolean"
        f" initial marked state s {{ on response from came{i} do up := value }} }} }} "
        for i in range(2)
    )
    assert len(decomposition.independent_parts(plant_of(text), 0)) == 2
    assert len(decomposition.independent_parts(plant_of(text + question), 0)) == 1


def test_communications_of_one_message_stay_together() -> None:
    text = "".join(
        f'component B{i} {{ outgoing message came{i} with identifier: "/came", type: none'
        " behaviour {"
        f" initial marked state a {{ on response from came{i} goto b }} marked state b {{}} }} }} "
        for i in range(2)
    )
    assert len(decomposition.independent_parts(plant_of(text), 0)) == 1


def test_commands_to_one_topic_stay_together() -> None:
    text = "".join(
        f'component B{i} {{ incoming message go{i} with identifier: "/go", type: none behaviour {{'
        f" initial marked state a {{ on request to go{i} goto b }} marked state b {{}} }} }} "
        for i in range(2)
    )
    assert len(decomposition.independent_parts(plant_of(text), 0)) == 1
