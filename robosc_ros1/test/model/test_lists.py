"""Conditions over lists: ``count(x for x in [A.busy, !B.on]) < 2``."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import pytest
from model_text import faults, resolve

from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import walk
from robosc.expr.tree import Aggregate, Expr, Leaf, StateRef, VariableRef

LAMPS = "".join(
    f"""
    component {name} {{
        incoming message light{name} with type: none
        outgoing message level{name} with type: integer(0..3)
        behaviour {{
            variable level: integer(0..3) = 0
            initial marked state dark {{ on request to light{name} goto lit }}
            marked state lit {{ on response from level{name} do level := value goto dark }}
        }}
    }}
    """
    for name in "ABC"
)


def condition(text: str) -> Expr:
    (requirement,) = resolve(f"{LAMPS} requirement always {text}").requirements
    return requirement.condition


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("any(x for x in [A.lit, B.lit, C.lit])", lambda n: n > 0),
        ("all(x for x in [A.lit, !B.dark, C.lit])", lambda n: n == 3),
        ("count(x for x in [A.lit, B.lit, C.lit]) < 2", lambda n: n < 2),
        ("count(!x for x in [A.dark, B.dark, C.dark]) <= 2", lambda n: n <= 2),
        ("count(x for x in [A.lit, B.lit, C.lit]) = 2", lambda n: n == 2),
        ("count(x for x in [A.lit, B.lit, C.lit]) != 1", lambda n: n != 1),
        ("count(x for x in [A.lit, B.lit, C.lit]) >= 1", lambda n: n >= 1),
        ("2 < count(x for x in [A.lit, B.lit, C.lit])", lambda n: n > 2),
        ("count(x for x in [A.lit, B.lit, C.lit]) > 4", lambda n: False),
        ("count(x for x in [A.lit, B.lit, C.lit] if A.lit or !A.lit) > 0", lambda n: n > 0),
    ],
)
def test_conditions_in_a_list(text: str, expected: Callable[[int], bool]) -> None:
    found = condition(text)
    assert not any(isinstance(part, Aggregate) for part in walk(found))
    for bits in product((False, True), repeat=3):
        lit = dict(zip("ABC", bits, strict=True))

        def look(leaf: Leaf, lit: dict[str, bool] = lit) -> bool:
            assert isinstance(leaf, StateRef)
            return lit[leaf.component] == (leaf.state == "lit")

        assert evaluate(found, look) == expected(sum(bits)), bits


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sum(x for x in [A.level, B.level, 1]) < 6", lambda a, b: a + b + 1 < 6),
        ("max(x for x in [A.level, B.level]) = 2", lambda a, b: max(a, b) == 2),
        ("min(x + 1 for x in [A.level, B.level]) >= 2", lambda a, b: min(a, b) + 1 >= 2),
        ("count(x > 1 for x in [A.level, B.level]) = 1", lambda a, b: (a > 1) + (b > 1) == 1),
        ("all(x > 0 for x in [A.level, B.level] if x != 2)", lambda a, b: 0 not in (a, b)),
        ("any(x = A.level for x in [1, 2])", lambda a, b: a in (1, 2)),
        ("count(x for x in [true, false]) + A.level < 3", lambda a, b: a < 2),
        ("any(x for x in []) or A.level = 1", lambda a, b: a == 1),
    ],
)
def test_numbers_in_a_list(text: str, expected: Callable[[int, int], bool]) -> None:
    found = condition(text)
    for levels in product(range(4), repeat=2):
        level = dict(zip("AB", levels, strict=True))

        def look(leaf: Leaf, level: dict[str, int] = level) -> int:
            assert isinstance(leaf, VariableRef)
            return level[leaf.component]

        assert evaluate(found, look) == expected(*levels), levels


SCAN = """
datatype object Scan { r: array(double) }
interface scans use Scan from some_robot_msgs
component L {
    outgoing message scan with type: Scan links scans
    behaviour {
        variable r: array(double)
        initial marked state s { on response from scan do r := value.r }
    }
}
"""


@pytest.mark.parametrize(
    ("text", "data", "expected"),
    [
        ("any(x < 1 for x in [L.r[1], L.r[0]])", (0.5,), True),
        ("any(x < 1 for x in [L.r[1], L.r[0]])", (2.0,), False),
        ("all(x < 1 for x in [L.r[1], L.r[0]])", (0.5,), True),
        ("all(x < 1 for x in [L.r[1], L.r[0]])", (0.5, 2.0), False),
        ("count(x < 1 for x in [L.r[1], L.r[0]]) >= 1", (0.5,), True),
        ("count(x < 1 for x in [L.r[1], L.r[0]]) >= 2", (0.5,), False),
    ],
)
def test_what_is_not_there_does_not_count(
    text: str, data: tuple[float, ...], expected: bool
) -> None:
    (requirement,) = resolve(f"{SCAN} requirement always {text}").requirements
    assert evaluate(requirement.condition, lambda leaf: data) == expected


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("count(x for x in [A.lit, B.lit]) < A.level", "not-over-components"),
        ("A.level < count(x for x in [A.lit, B.lit]) + 1", "not-over-components"),
        ("sum(x for x in [A.level, B.level] if x > 1) < 3", "not-over-components"),
        ("count(x for x in [A.lit, B.level]) < 2", "type-mismatch"),
        ("count(x for x in [A.lit, A.lot]) < 2", "unknown-member"),
        ("count(x for x in [A.level, B.level]) < 2", "type-mismatch"),
    ],
)
def test_faults_of_lists_are_told_once(text: str, code: str) -> None:
    found = faults(f"{LAMPS} requirement always {text}")
    assert [c for c, _ in found if c != "unused-variable"] == [code]


def test_lists_stand_in_data_and_in_copies() -> None:
    robot = resolve(
        LAMPS
        + """
        component Cell[1..3] {
            incoming message go with identifier: "/c{index}/go", type: integer
            behaviour { initial marked state off { on request to go goto on_ } marked state on_ {} }
        }
        for i in 1..3 {
            requirement Cell[i].go needs count(x for x in [Cell[i].off, A.lit, B.lit]) >= 2
            provide Cell[i].go with max(x for x in [A.level, B.level, i])
        }
        """
    )
    assert len(robot.requirements) == len(robot.provides) == 3
