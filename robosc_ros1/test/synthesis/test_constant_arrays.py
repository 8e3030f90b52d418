"""Arrays that the model fixes, read by conditions and assignments over what is finite."""

from __future__ import annotations

import pytest
from plants import guard_text, supervisor_of

ENGINES = pytest.mark.parametrize("engine", ["explicit", "bdd"])

SWITCH = """
parameter gear: integer(0..2) = 1
datatype enum Speed from integer to { value > 1 -> fast default -> slow }
constant levels: array(integer) = [1, 2, 3]
constant steps: array(integer(0..3)) = [1, 2]
constant speeds: array(Speed) = [slow, fast]
component Switch {
    incoming message go with type: none
    outgoing message turned with type: integer(0..3)
    behaviour {
        variable n: integer(0..3)
        variable m: integer(0..3)
        variable far: boolean
        on response from turned %s
        initial marked state low { transition goto high }
        marked state high { transition goto low }
    }
}
"""

CONDITIONS = [
    ("any(x > 2 for x in levels)", "true"),
    ("count(x for x in [true, true, true]) >= 1", "true"),
    ("min(x for x in levels if x > 3) > 3", "false"),
    ("all(Switch.low for x in [1, 2])", "Switch.low"),
    ("any(Switch.n = x for x in [1, 3])", "Switch.n = 1 or Switch.n = 3"),
    ("max(x for x in levels if x > Switch.n) = 3", "Switch.n != 3"),
    ("length(levels) = Switch.n", "Switch.n = 3"),
    ("levels[Switch.n] = 2", "Switch.n = 1"),
    ("!(levels[Switch.n] = 2)", "Switch.n = 0 or Switch.n = 2"),
    ("defined(levels[Switch.n])", "Switch.n != 3"),
    ("speeds[Switch.n] = fast", "Switch.n = 1"),
    ("Speed(levels[Switch.n]) = slow", "Switch.n = 0"),
    ("levels[gear] = Switch.n", "Switch.n = gear + 1"),
]


@ENGINES
@pytest.mark.parametrize(("condition", "same"), CONDITIONS, ids=[c for c, _ in CONDITIONS])
def test_a_condition_holds_where_it_does_element_by_element(
    engine: str, condition: str, same: str
) -> None:
    needs = SWITCH % "do n := value" + "requirement go needs "
    texts = (condition, same, f"({condition}) or ({same})")
    allowed = [supervisor_of(needs + text, engine).controlled_transitions for text in texts]
    assert len(set(allowed)) == 1


@ENGINES
@pytest.mark.parametrize(
    ("transition", "same"),
    [
        ("if levels[value] = 2 do n := 1", "if value = 1 do n := 1"),
        ("if !(levels[value] = 2) do n := 1", "if value = 0 or value = 2 do n := 1"),
        ("if !(levels[n] = 2) do n := value", "if n = 0 or n = 2 do n := value"),
        ("do far := levels[value] = 2", "if value < 3 do far := value = 1"),
        ("do far := levels[n] = 2, n := value", "do far := n = 1 or n = 3 and far, n := value"),
    ],
)
def test_an_element_that_is_not_there_changes_nothing(
    engine: str, transition: str, same: str
) -> None:
    needs = "requirement go needs Switch.far and Switch.n > 0"
    found, expected = (supervisor_of(SWITCH % one + needs, engine) for one in (transition, same))
    assert found.plant_states == expected.plant_states
    assert found.controlled_transitions == expected.controlled_transitions
    guards = (guard_text(supervisor, "go.request") for supervisor in (found, expected))
    assert len(set(guards)) == 1


@ENGINES
@pytest.mark.parametrize("taken", ["steps[m]", "steps[value]", "-(-steps[m])"])
def test_an_element_that_is_assigned_is_any_of_the_array_or_none(engine: str, taken: str) -> None:
    text = SWITCH % f"do n := {taken}, m := value" + "requirement go needs Switch.n > Switch.m"
    supervisor = supervisor_of(text, engine)
    assert supervisor.plant_states == 4 * 4 * 2
    assert guard_text(supervisor, "go.request") == ("Switch.n > Switch.m", "as required")


def test_a_condition_with_too_many_cases_is_free() -> None:
    wide = SWITCH.replace(
        "integer(0..3)\n        variable far", "integer(0..9999)\n        variable far"
    )
    text = (
        wide % "do n := value" + "requirement go needs any(x > Switch.n + Switch.m for x in levels)"
    )
    supervisor = supervisor_of(text)
    condition = "any(x > Switch.n + Switch.m for x in [1, 2, 3])"
    assert guard_text(supervisor, "go.request") == (condition, "as required")
    assert supervisor.plant.view.free.keys() == {condition}
