"""``initial state a if index = 1``: in which copies a state is initial."""

from __future__ import annotations

import pytest
from model.model_text import behaviour_of, faults, resolve

GATE = """
constant first: integer = 1
component Gate[1..3] {
    incoming message open with identifier: "/gate_{index}/open", type: none
    behaviour {
        initial marked state closed if FIRST { on request to open goto inner }
        initial state opened if SECOND { on request to open goto closed }
        marked state inner {
            initial state low if index < 3 { on request to open goto high }
            initial marked state high if index = 3 { on request to open goto low }
        }
    }
}
"""


def gate(first: str, second: str) -> str:
    return GATE.replace("FIRST", first).replace("SECOND", second)


@pytest.mark.parametrize(
    ("first", "second", "initial"),
    [
        ("index = 1", "index > 1", ["closed", "opened", "opened"]),
        ("index = first or index = 3", "index = 2", ["closed", "opened", "closed"]),
        ("index % 2 = 0", "index % 2 = 1", ["opened", "closed", "opened"]),
        ("true", "false", ["closed"] * 3),
    ],
)
def test_each_copy_begins_where_it_says(first: str, second: str, initial: list[str]) -> None:
    robot = resolve(gate(first, second))
    found = [
        [s.name for s in behaviour_of(robot, f"Gate[{n}]").states if s.initial] for n in (1, 2, 3)
    ]
    assert found == [[name] for name in initial]


def test_states_in_states_as_well() -> None:
    robot = resolve(gate("index = 1", "index > 1"))
    for number, inner in ((1, "inner.low"), (2, "inner.low"), (3, "inner.high")):
        targets = {t.goto for t in behaviour_of(robot, f"Gate[{number}]").all_transitions}
        others = {"inner.low", "inner.high"} - {inner}
        # Only from within the other one is reached: whoever enters begins in the initial one.
        (entered,) = {
            t.goto
            for t in behaviour_of(robot, f"Gate[{number}]").all_transitions
            if t.named == "inner"
        }
        assert entered == inner
        assert others <= targets


@pytest.mark.parametrize(
    ("first", "second", "code"),
    [
        ("index = 1", "index > 2", "no-initial-state"),
        ("index < 3", "index > 1", "several-initial-states"),
        ("Gate[1].opened", "true", "unknown-name"),
        ("index", "true", "type-mismatch"),
        ("number = 1", "true", "unknown-name"),
    ],
)
def test_exactly_one_in_each_copy_and_known_before(first: str, second: str, code: str) -> None:
    assert code in [found for found, _ in faults(gate(first, second))]


def test_only_initial_states_have_a_condition() -> None:
    text = gate("index = 1", "index > 1").replace("initial state opened", "state opened")
    assert ("syntax", "index > 1") in faults(text)
