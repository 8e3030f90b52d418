"""Which commands would go on with the last value of a message that comes and says nothing."""

from __future__ import annotations

import pytest
from model_text import faults

from robosc.model.resolve import load
from robosc.source import Source

CODE = "undefined-data"
OTHERS = ("package-not-found", "unused-variable", "unused-timeout", "no-stop")


def told(
    value: str,
    *,
    type_: str = "double",
    requirement: str = "go needs Eye.found > 0.4",
    guard: str = "",
    more: str = "",
) -> list[str]:
    """What is marked, for a robot whose command rests on what an assignment found in a scan."""
    found = faults(f"""
    datatype object Mark {{ x: double id: integer }}
    datatype object Scan {{
        ranges: array(double) marks: array(Mark) step: double name: string
    }}
    interface laser use Scan from nowhere_msgs
    component Eye {{
        outgoing message scan with timeout: 1 s, type: Scan links laser
        behaviour {{
            variable found: {type_}
            initial marked state on {{ on response from scan {guard} do found := {value} }}
        }}
    }}
    component Base {{ incoming message go with type: none }}
    requirement {requirement}
    {more}
    """)
    assert {code for code, _ in found} <= {CODE, *OTHERS}, found
    return [text for code, text in found if code == CODE]


FINDS_NOTHING = [
    "value.ranges[0]",
    "value.ranges[-1]",
    "value.marks[2].x",
    "value.ranges[round(value.step)]",
    "min(r for r in value.ranges)",
    "max(r for r in value.ranges[-30..30] if r > 0.1)",
    "1.0 / value.step",
    "abs(value.ranges[0]) + 1.0",
    "hypot(value.step, value.ranges[3])",
]


@pytest.mark.parametrize("value", FINDS_NOTHING)
def test_what_may_find_nothing_is_told(value: str) -> None:
    assert told(value) == [value]
    assert told(f"({value}) else 0.0") == []
    assert told(value, requirement="go needs scan.fresh") == []


@pytest.mark.parametrize(
    "value",
    [
        "value.step",
        "value.step / 2.0",
        "length(value.ranges) / 3",
        "sum(r for r in value.ranges)",
        "sum((r / value.step) for r in value.ranges)",
        "min(r for r in value.ranges) else value.step",
    ],
)
def test_what_is_always_there_is_not_told(value: str) -> None:
    assert told(value) == []


BLOCKED = "go needs !Eye.found"
CLEAR = "go needs Eye.found"


@pytest.mark.parametrize(
    ("value", "of_blocked", "of_clear"),
    [
        # Of nothing, 'any' is false and 'all' is true: what lets the command happen is told.
        ("any(r < 0.5 for r in value.ranges[-30..30])", True, False),
        ("all(r > 0.5 for r in value.ranges[-30..30])", False, True),
        ("!any(r < 0.5 for r in value.ranges[-30..30] if r > 0.1)", False, True),
        ("value.step < 1 or any(r < 0.5 for r in value.ranges[-30..30])", True, False),
        ("value.step < 1 and all(r > 0.5 for r in value.ranges[0..9])", False, True),
        # A comparison of nothing leaves the variable as it was.
        ("min(r for r in value.ranges) < 0.5", True, True),
        ("value.ranges[0] < 0.5 or value.ranges[1] < 0.5", True, True),
        # The model says itself what holds of nothing.
        ("min(r for r in value.ranges) < 0.5 else true", False, False),
        ("(min(r for r in value.ranges) else 0.0) < 0.5", False, False),
        ("length(value.ranges) = 0 or any(r < 0.5 for r in value.ranges[-30..30])", False, False),
        ("!(defined(value.ranges[0]) and value.ranges[0] > 0.5)", False, False),
        # An empty list of things that were seen is data.
        ("any(m.id = 3 for m in value.marks)", False, False),
    ],
)
def test_conditions_are_told_where_nothing_lets_the_command_happen(
    value: str, of_blocked: bool, of_clear: bool
) -> None:
    for requirement, expected in ((BLOCKED, of_blocked), (CLEAR, of_clear)):
        found = told(value, type_="boolean", requirement=requirement)
        assert found == ([value] if expected else []), requirement


@pytest.mark.parametrize(
    ("rules", "wanted", "expected"),
    [
        ("any(r < 0.5 for r in value.ranges[0..9]) -> near default -> far", "far", True),
        ("any(r < 0.5 for r in value.ranges[0..9]) -> near default -> far", "near", False),
        ("min(r for r in value.ranges) < 0.5 -> near default -> far", "far", True),
        ("min(r for r in value.ranges) > 0.5 -> far default -> near", "far", False),
        ("value.ranges[0] < 0.5 -> near default -> far", "far", True),
        ("all(r > 0.5 for r in value.ranges[0..9]) -> far default -> near", "far", True),
        ("(min(r for r in value.ranges) else 0.0) < 0.5 -> near default -> far", "far", False),
        ("length(value.ranges) < 9 -> near value.step > 2 -> far default -> near", "far", False),
    ],
)
@pytest.mark.parametrize("value", ["value", "Way(value)"])
def test_enums_are_told_where_nothing_lets_the_command_happen(
    rules: str, wanted: str, expected: bool, value: str
) -> None:
    found = faults(f"""
    datatype object Scan {{ ranges: array(double) step: double }}
    interface laser use Scan from nowhere_msgs
    datatype enum Way from Scan to {{ {rules} }}
    component Eye {{
        outgoing message scan with timeout: 1 s, type: {"Way" if value == "value" else "Scan"}
            links laser
        behaviour {{
            variable way: Way
            initial marked state on {{ on response from scan do way := {value} }}
        }}
    }}
    component Base {{ incoming message go with type: none }}
    requirement go needs scan.fresh and Eye.way = {wanted}
    """)
    assert [text for code, text in found if code == CODE] == ([value] if expected else [])


def test_commands_may_depend_through_other_variables_guards_and_data() -> None:
    value = "value.ranges[0]"
    copy = """
    component Mind {
        outgoing message tick with type: none
        behaviour {
            variable last: double
            on response from tick do last := Eye.found
            initial marked state on {%s}
        }
    }
    component Arm { incoming message lift with type: double }
    """
    for there, statement in (
        (" transition if last > 1 goto on ", ""),
        ("", "provide lift with Mind.last"),
        ("", "provide lift with 1.0 if Mind.last > 2"),
        ("", "requirement never Mind.last > 3"),
    ):
        assert told(value, requirement="go needs scan.fresh", more=copy % there + statement) == [
            value
        ]


@pytest.mark.parametrize("guard", ["if length(value.ranges) > 5", "if defined(value.ranges[0])"])
def test_a_guard_may_say_what_there_must_be(guard: str) -> None:
    assert told("value.ranges[0]", guard=guard) == []


def test_arrays_of_fixed_length_have_their_elements() -> None:
    _, found = load(
        Source(
            "fixed.rscd",
            """robot Fixed {
            component Eye {
                outgoing message odom with timeout: 1 s, type: nav_msgs/Odometry
                outgoing message joy with timeout: 1 s, type: sensor_msgs/Joy
                behaviour {
                    variable spread: double
                    variable stick: double
                    initial marked state on {
                        on response from odom do spread := value.pose.covariance[0]
                        on response from joy do stick := value.axes[0]
                    }
                }
            }
            component Base { incoming message go with type: none }
            requirement go needs Eye.spread < 1 and Eye.stick > 0
            }""",
        )
    )
    assert [d.span.text for d in found if d.code == CODE] == ["value.axes[0]"]


def provided(statement: str, condition: str = "") -> list[str]:
    """What is marked in data that a command is sent with."""
    found = faults(
        f"""
    datatype object Scan {{ ranges: array(double) }}
    interface laser use Scan from nowhere_msgs
    component Eye {{
        outgoing message scan with timeout: 1 s, type: Scan links laser
        behaviour {{
            variable ranges: array(double)
            variable step: double
            initial marked state on {{
                on response from scan {condition}
                    do ranges := value.ranges, step := value.ranges[0] else 1.0
            }}
        }}
    }}
    component Base {{
        incoming message go with type: double
        incoming message point with type: Scan links laser
    }}
    requirement {{ go, point }} needs scan.fresh
    {statement}
    """
    )
    return [place for code, place in found if code == CODE]


@pytest.mark.parametrize(
    ("statement", "places"),
    [
        ("provide go with Eye.ranges[1]", ["Eye.ranges[1]"]),
        ("provide go with 2 * Eye.ranges[1]", ["2 * Eye.ranges[1]"]),
        (
            "provide go with min(r for r in Eye.ranges)",
            ["min(r for r in Eye.ranges)"],
        ),
        ("provide go with 1 / Eye.step", ["1 / Eye.step"]),
        (
            "provide point with { ranges: [Eye.step, Eye.ranges[0]] }",
            ["Eye.ranges[0]"],
        ),
        ("provide go with Eye.ranges[1] else 0.0", []),
        ("provide go with 1 / max(Eye.step, 0.01)", []),
        ("provide go with 1 / 2", []),
        ("provide go with Eye.step", []),
        ("provide go with Eye.ranges[1] if defined(Eye.ranges[1])", []),
        ("provide point with { ranges: Eye.ranges }", []),
    ],
)
def test_data_that_are_sent(statement: str, places: list[str]) -> None:
    assert provided(statement) == places


def test_what_a_guard_asks_for_is_there() -> None:
    statement = "provide go with Eye.ranges[1]"
    assert provided(statement, "if length(value.ranges) > 1") == [statement.split()[-1]]
    assert provided(statement, "if !defined(ranges[1])") == []


@pytest.mark.parametrize(
    ("data", "type_", "hint"),
    [
        ("places[Base.next].x", "double", "say what is sent then: … else VALUE"),
        (
            "places[Base.next]",
            "Mark",
            "say what is sent then, field by field: { x: places[Base.next].x else VALUE, … }",
        ),
    ],
)
def test_the_hint_fits_what_is_sent(data: str, type_: str, hint: str) -> None:
    """An object has no value that can be written behind 'else'."""
    _, diagnostics = load(
        Source("model.rscd", f"""robot Guard {{
            datatype object Mark {{ x: double y: double }}
            parameter places: array(Mark) = [{{ x: 1.0, y: 2.0 }}]
            interface mark use Mark from nowhere_msgs
            component Base {{
                incoming message go with type: {type_} {"links mark" * (type_ == "Mark")}
                behaviour {{
                    variable next: integer
                    initial marked state on {{ on request to go do next := next + 1 }}
                }}
            }}
            provide go with {data}
            stop with nothing
        }}""")
    )  # fmt: skip
    assert [d.hint for d in diagnostics if d.code == CODE] == [hint]
