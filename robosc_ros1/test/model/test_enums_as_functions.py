"""Enums that convert anywhere, and their rules."""

from __future__ import annotations

import pytest
from model_text import behaviour_of, faults, resolve

from robosc.expr.evaluation import evaluate
from robosc.expr.tree import Expr, ValueRef
from robosc.plant.model_text import to_dsl

MODEL = """
constant far: double = 2
datatype enum Way from double to {
    value > far -> free value = -1 -> free value > 0.5 -> tight default -> blocked
}
datatype enum Side from Point to { value.x > value.more[1] -> left default -> right }
datatype object Point { x: double more: array(double) }
datatype object Cloud { front: double point: Point n: integer }
interface cloud use Cloud from example_msgs
component P {
    incoming message go with type: double
    outgoing message cloud with type: Cloud links cloud
    behaviour {
        variable way: Way
        variable side: Side
        variable number: double
        initial marked state s { on response from cloud do %s }
    }
}
requirement go needs %s
"""


def text(assignment: str = "way := Way(value.front)", needed: str = "P.way = free") -> str:
    return MODEL % (assignment, needed)


def assigned(assignment: str) -> Expr:
    behaviour = behaviour_of(resolve(text(assignment)), "P")
    return behaviour.states[0].transitions[0].assignments[0].value


def value_of(expr: Expr, parts: dict[tuple[str | int, ...], object]) -> object:
    def look(leaf: object) -> object:
        assert isinstance(leaf, ValueRef)
        return parts[leaf.path]

    return evaluate(expr, look)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("front", "way"), [(3.0, "free"), (-1.0, "free"), (1.0, "tight"), (0.0, "blocked")]
)
def test_an_enum_converts_a_part_of_a_message(front: float, way: str) -> None:
    assert value_of(assigned("way := Way(value.front)"), {("front",): front}) == way


@pytest.mark.parametrize(
    ("point", "side"),
    [
        ({"x": 1.0, "more": [0.0, 0.5]}, "left"),
        ({"x": 0.0, "more": [0.0, 0.5]}, "right"),
        ({"x": 1.0, "more": [0.0]}, "right"),  # an element that did not come matches no rule
    ],
)
def test_an_enum_converts_an_object(point: dict[str, object], side: str) -> None:
    assert value_of(assigned("side := Side(value.point)"), {("point",): point}) == side


def test_a_conversion_is_written_as_a_call() -> None:
    robot = resolve(text(needed="Way(P.number) in {free, tight}"))
    found = to_dsl(robot.requirements[0].condition, robot)
    assert found == "Way(P.number) = free or Way(P.number) = tight"


@pytest.mark.parametrize(
    ("model", "fault"),
    [
        (text("way := Way(value.point)"), ("type-mismatch", "value.point")),
        (text("way := Way(value.front, 1)"), ("type-mismatch", "Way(value.front, 1)")),
        (text("way := Side(value.point)"), ("type-mismatch", "Side(value.point)")),
        (text("way := Wey(value.front)"), ("unknown-name", "Wey")),
        (text(needed="Way(P.number) = left"), ("type-mismatch", "left")),
    ],
)
def test_a_wrong_conversion_is_marked(model: str, fault: tuple[str, str]) -> None:
    left_out = ("unused", "package", "unread")
    assert [f for f in faults(model) if not f[0].startswith(left_out)] == [fault]


def test_the_rule_of_an_enum_may_call_one_that_is_declared_further_down() -> None:
    rule, called = "{ Level(value.x) = low -> down default -> up }", "enum Level from double"
    first = f"datatype enum Trend from Point to {rule}"
    then = f"datatype {called} to {{ value > 1 -> high default -> low }}"
    more = "requirement go needs Trend(P.point) = up"
    declared = text().replace("variable number", "variable point: Point variable number")
    forward, backward = (faults(declared + a + b + more) for a, b in ((first, then), (then, first)))
    assert forward == backward
    assert not {"unknown-name", "type-mismatch"}.intersection(code for code, _ in forward)


def test_enums_that_call_each_other_in_their_rules_are_refused() -> None:
    one = "datatype enum One from double to { Two(value) = b -> a default -> c }"
    two = "datatype enum Two from double to { One(value) = a -> b default -> d }"
    assert ("unknown-name", "One") in faults(text() + one + two)
