"""Typing of operators, assignments, ranges and initial values."""

from __future__ import annotations

import pytest
from model_text import behaviour_of, faults, resolve

from robosc.expr.tree import Binary, Literal
from robosc.expr.types import DoubleType, IntegerType

PLAN = """
component P {
    outgoing message i with type: integer(0..9)
    outgoing message b with type: boolean
    behaviour {
        variable n: integer(0..9)
        variable d: double
        variable t: string
        variable f: boolean
        initial marked state s { %s }
    }
}
"""


def with_transition(text: str) -> str:
    return PLAN % text


@pytest.mark.parametrize(
    ("expression", "wrong"),
    [
        ("n", "n"),
        ("n and f", "n"),
        ("f or n + 1", "n + 1"),
        ("f => t", "t"),
        ("!n", "n"),
        ("n < f", "f"),
        ("t >= 3", "t"),
        ("n = t", "t"),
        ("n = true", "n"),
        ("f != 1", "f"),
        ('t = "a" + 1', "1"),
        ("-f = 1", "f"),
        ("1", "1"),
    ],
)
def test_a_wrong_operand_is_marked(expression: str, wrong: str) -> None:
    found = faults(with_transition(f"transition if {expression}"))
    assert ("type-mismatch", wrong) in found
    assert len([code for code, _ in found if not code.startswith("unused")]) == 1


@pytest.mark.parametrize(
    "expression",
    ["n = 1.0 and n < 2.5", "f = (n = 3)", "n / 2 > 0.3", "f => f => !f", "n != -1 * n + 2"],
)
def test_a_right_expression_passes(expression: str) -> None:
    resolve(with_transition(f"transition if {expression}"))


def test_division_is_a_double_and_other_arithmetic_follows_its_sides() -> None:
    robot = resolve(with_transition("transition if n / 2 = n * 2 or n + 0.5 = 1"))
    guard = behaviour_of(robot, "P").states[0].taus[0].guard
    assert isinstance(guard, Binary)
    first, second = guard.left, guard.right
    assert isinstance(first, Binary) and isinstance(second, Binary)
    assert first.left.type == DoubleType()
    assert first.right.type == IntegerType()
    assert second.left.type == DoubleType()


def test_an_integer_widens_to_a_double_and_not_back() -> None:
    robot = resolve(with_transition("on response from i do d := value, n := value"))
    assignments = behaviour_of(robot, "P").states[0].transitions[0].assignments
    assert [a.variable for a in assignments] == ["d", "n"]
    assert faults(with_transition("on response from b do n := 2.0"))[-1] == ("type-mismatch", "2.0")


def test_an_integer_literal_for_a_double_becomes_one() -> None:
    robot = resolve(with_transition("on response from b do d := 3"))
    value = behaviour_of(robot, "P").states[0].transitions[0].assignments[0].value
    assert value == Literal(3.0, DoubleType())


@pytest.mark.parametrize(
    ("declaration", "value"),
    [
        ("boolean", False),
        ("integer", 0),
        ("integer(-5..5)", 0),
        ("integer(3..5)", 3),
        ("integer(-5..-2)", -2),
        ("double", 0.0),
        ("string", ""),
        ("double = 1", 1.0),
        ("double = -1", -1.0),
        ("integer(-5..5) = -5", -5),
        ("integer = 2 * 3 - 10", -4),
        ("double = 1 / 4", 0.25),
        ("Mode", "other"),
        ("Mode = first", "first"),
        ("Mode = Mode.first", "first"),
    ],
)
def test_initial_values(declaration: str, value: object) -> None:
    robot = resolve(
        f"component P {{ behaviour {{ variable x: {declaration} initial marked state s {{}} }} }}\n"
        "datatype enum Mode from integer to { value > 1 -> first default -> other }"
    )
    (variable,) = behaviour_of(robot, "P").variables
    assert variable.initial == value
    assert type(variable.initial) is type(value)


def test_a_constant_outside_its_range_is_an_error_and_a_computed_value_is_not() -> None:
    assert faults(with_transition("on response from b do n := 10"))[-1] == ("out-of-range", "10")
    resolve(with_transition("on response from b do n := n + 10"))


def test_deep_and_long_expressions_are_typed() -> None:
    resolve(with_transition("transition if " + "(" * 150 + "f" + ")" * 150))
    resolve(with_transition("transition if " + " and ".join(["f"] * 150)))


def test_value_has_the_type_of_the_event_and_parts() -> None:
    robot = resolve(
        """
        component P {
            action go with request: none, response: Result, feedback: double links go
            behaviour {
                variable name: string
                variable first: double
                variable far: double
                initial marked state s {
                    on response from go do name := value.inner.name, first := value.inner.list[2].x
                    on feedback from go do far := value
                }
            }
        }
        datatype object Result { inner: Inner }
        datatype object Inner { name: string list: array(Point) }
        datatype object Point { x: double }
        interface go use Go from p
        """
    )
    first, second = behaviour_of(robot, "P").states[0].transitions
    assert first.assignments[1].value.path == ("inner", "list", 2, "x")  # type: ignore[union-attr]
    assert second.assignments[0].value.type == DoubleType()


def test_a_part_that_does_not_exist_is_marked() -> None:
    text = """
    component P {
        outgoing message m with type: E
        outgoing message l with type: F
    }
    datatype enum E from array(double) to { value[0].x > 1 -> a value.x > 1 -> b default -> c }
    datatype enum F from O to {
        value[0] > 1 -> a
        value.list > 1 -> b
        value.lst[0] > 1 -> c
        default -> d
    }
    datatype object O { list: array(double) }
    """
    assert [f for f in faults(text) if f[0] in ("unknown-member", "type-mismatch")] == [
        ("unknown-member", "x"),
        ("unknown-member", "x"),
        ("unknown-member", "value[0]"),
        ("type-mismatch", "value.list"),
        ("unknown-member", "lst"),
    ]


@pytest.mark.parametrize("order", [1, -1])
def test_datatypes_nested_without_end_are_refused(order: int) -> None:
    chain = [f"datatype object A{i} {{ x: A{i + 1} }}" for i in range(1000)]
    chain.append("datatype object A1000 { x: double }")
    text = "\n".join(chain[::order])
    found = faults("component P { outgoing message m with type: A0 links l }\n" + text)
    assert "too-deep" in [code for code, _ in found]


def test_rules_and_the_default_may_share_a_value() -> None:
    text = """
    component P {{ outgoing message m with type: E }}
    datatype enum E from integer to {{ value < 0 -> bad value > 9 -> {} default -> bad }}
    """
    assert "duplicate-name" not in [code for code, _ in faults(text.format("good"))]
    assert "duplicate-name" not in [code for code, _ in faults(text.format("bad"))]
