"""``value`` in requirements on commands: what they carry, by the provide statements."""

from __future__ import annotations

from pathlib import Path

import pytest
from model.model_text import faults, resolve

from robosc.expr.tree import Holds
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.packages import Packages
from robosc.plant.model_text import to_dsl
from robosc.source import Source

ROBOT = """
datatype object Two { a: double b: array(double) }
interface two use Two from some_robot_msgs
component Stick {
    outgoing message stick with timeout: 1 s, type: double
    outgoing message route with timeout: 1 s, type: Two links two
    behaviour {
        variable speed: double
        variable way: Two
        initial marked state still { on response from stick do speed := value goto turned }
        marked state turned {
            on response from stick do speed := value goto still
            on response from route do way := value
        }
    }
}
component Base {
    incoming message move with type: double
    incoming message lamp with type: boolean
    incoming message both with type: Two links two
    incoming message halt with type: none
}
"""
PROVIDED = """
provide move with Stick.speed if Stick.turned
provide move with 0.2
provide lamp with Stick.turned
provide both with { a: Stick.speed, b: [1.0, Stick.speed] }
"""


def requirements(text: str, provided: str = PROVIDED) -> list[tuple[str, str, bool]]:
    """Text, condition and whether it is no reason to cancel, of each requirement."""
    robot = resolve(f"{ROBOT} {provided} {text}")
    for requirement in robot.requirements:
        assert requirement.kind == "needs" or not requirement.on_data
    return [(r.text, to_dsl(r.condition, robot), r.to_start) for r in robot.requirements]


def conditions(text: str, provided: str = PROVIDED) -> list[str]:
    return [condition for _, condition, _ in requirements(text, provided)]


def test_the_first_provide_that_holds_gives_the_data() -> None:
    assert conditions("requirement move needs value < 0.5") == [
        "Stick.turned and Stick.speed < 0.5 or !Stick.turned"
    ]


def test_where_no_provide_holds_the_defaults_of_the_message_are_judged() -> None:
    provided = "provide move with Stick.speed if Stick.turned"
    assert conditions("requirement move needs value < 0.5", provided) == [
        "Stick.turned and Stick.speed < 0.5 or !Stick.turned"
    ]
    assert conditions("requirement move needs value > 0.5", provided) == [
        "Stick.turned and Stick.speed > 0.5"
    ]
    assert conditions("requirement value >= 0.5 disables move", "") == ["true"]


def packages_with(tmp_path: Path, definition: str) -> Packages:
    """A package ``poses`` of ROS 2 with a message ``Turn``."""
    (folder := tmp_path / "poses" / "msg").mkdir(parents=True)
    (folder.parent / "package.xml").write_text(
        "<package format='3'><name>poses</name><version>1.0.0</version><description>-</description>"
        "<maintainer email='a@b.org'>A</maintainer><license>MIT</license>"
        "<export><build_type>ament_cmake</build_type></export></package>"
    )
    (folder / "Turn.msg").write_text(definition)
    return Packages.for_model(tmp_path / "robot.rscd", {"ROS_PACKAGE_PATH": str(tmp_path)})


def test_what_a_provide_leaves_out_has_its_default(tmp_path: Path) -> None:
    packages = packages_with(tmp_path, "float64 x\nfloat64 w 1.0 # no turn\nfloat64[] far\n")
    text = """
        component Base { incoming message turn with type: poses/Turn }
        provide turn with { far: [2.0] }
        requirement turn needs value.w = 1.0
        requirement turn needs value.x > 0.0
        requirement turn needs value.far[0] > 1.0
    """
    robot = resolve(text, MessageDefinitions(packages))
    assert [to_dsl(r.condition, robot) for r in robot.requirements] == ["true", "false", "true"]


ARRAYS = "float64[] any\nfloat64[3] three\nfloat64[] given [1.5, 2.5]\nfloat64[2] both [0.5, 4.0]\n"


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        ("value.three[2] >= 0.0", "true"),
        ("value.three[2] > 0.0", "false"),
        ("value.given[1] = 2.5", "true"),
        ("value.both[0] > 1.0", "false"),
        ("length(value.any) = 0", "true"),
        ("length(value.given) = 2", "true"),
        ("length(value.three) = 3", "true"),
        ("length(value.both) < 2", "false"),
        ("any(x > 3.0 for x in value.both)", "any(x > 3.0 for x in [0.5, 4.0])"),
    ],
)
def test_an_array_that_is_left_out_is_as_ros_makes_it(
    tmp_path: Path, condition: str, expected: str
) -> None:
    text = f"""
        component Base {{ incoming message turn with type: poses/Turn }}
        provide turn with {{}}
        requirement turn needs {condition}
    """
    robot = resolve(text, MessageDefinitions(packages_with(tmp_path, ARRAYS)))
    assert [to_dsl(r.condition, robot) for r in robot.requirements] == [expected]


@pytest.mark.parametrize("part", ["any[0]", "three[3]", "given[2]"])
def test_an_element_that_an_array_left_out_does_not_have_is_refused(
    tmp_path: Path, part: str
) -> None:
    """It passed as 0, though what is sent has no such element."""
    text = f"""
        component Base {{ incoming message turn with type: poses/Turn }}
        provide turn with {{}}
        requirement turn needs value.{part} >= 0.0
    """
    found = faults(text, MessageDefinitions(packages_with(tmp_path, ARRAYS)))
    assert found == [("data-not-given", f"value.{part}")]


def test_each_part_is_a_requirement_and_those_on_data_are_no_reason_to_cancel() -> None:
    head = "requirement move needs "
    found = requirements(f"{head}stick.fresh and (value < 0.5 or Stick.still)")
    assert [(text, start) for text, _, start in found] == [
        (f"{head}stick.fresh", False),
        (f"{head}value < 0.5 or Stick.still", True),
    ]
    found = requirements("requirement Stick.still or value disables lamp")
    assert found == [
        ("requirement Stick.still disables lamp", "Stick.still", False),
        ("requirement value disables lamp", "!Stick.turned", True),
    ]


def test_a_condition_without_value_stays_one_requirement() -> None:
    text = "requirement move needs stick.fresh and Stick.still"
    assert requirements(text) == [(text, "stick.fresh and Stick.still", False)]


def test_the_members_of_a_group_are_judged_by_their_own_data() -> None:
    provided = "provide move with 0.1 provide lamp with Stick.turned provide halt2 with 0.3 "
    component = "component More { incoming message halt2 with type: double }"
    robot = resolve(ROBOT + component + provided + "requirement {move, halt2} needs value < 0.2")
    assert [(r.communications, to_dsl(r.condition, robot)) for r in robot.requirements] == [
        (("Base.move",), "true"),
        (("More.halt2",), "false"),
    ]


def test_parts_of_what_is_provided() -> None:
    assert conditions("requirement both needs value.a < 1.0 and value.b[1] < 2.0") == [
        "Stick.speed < 1.0",
        "Stick.speed < 2.0",
    ]


@pytest.mark.parametrize("text", ["both needs value.b[3] < 1.0", "value.b[3] < 1.0 disables both"])
def test_undefined_data_are_refused_in_both_forms(text: str) -> None:
    """What holds nothing yet makes the condition false, in place of undefined."""
    provided = "provide both with { a: 0.0, b: Stick.way.b }"
    (requirement,) = resolve(f"{ROBOT} {provided} requirement {text}").requirements
    assert isinstance(requirement.condition, Holds)


def told(text: str) -> list[tuple[str, str]]:
    return [fault for fault in faults(ROBOT + text) if fault[0] != "package-not-found"]


def messages(text: str) -> list[str]:
    _, diagnostics = load(Source("model.rscd", f"robot Test {{ {ROBOT} {PROVIDED} {text} }}"))
    return [d.message for d in diagnostics if d.code != "package-not-found"]


FAULTS = [
    ("requirement halt needs value < 1.0", ("value-not-allowed", "value")),
    ("requirement { move, halt } needs value < 1.0", ("value-not-allowed", "value")),
    ("requirement { move, both } needs value.a < 1.0", ("unknown-member", "a")),
    ("requirement both needs value.c < 1.0", ("unknown-member", "c")),
    ("requirement move needs value", ("type-mismatch", "value")),
    ("requirement never value < 1.0", ("value-not-allowed", "value")),
    ("provide halt with {} if value < 1.0", ("value-not-allowed", "value")),
    ("requirement both needs value.b[2] < 1.0", ("data-not-given", "value.b[2]")),
    ("requirement both needs any(x < 1.0 for x in value.b)", ("data-not-given", "value.b")),
]


@pytest.mark.parametrize(("text", "fault"), FAULTS)
def test_faults(text: str, fault: tuple[str, str]) -> None:
    assert told(PROVIDED + text) == [fault]


def test_the_members_that_carry_nothing_are_named() -> None:
    found = messages("requirement { move, halt } needs value < 1.0")
    assert found == ["'halt' carries no data: there is no 'value'"]


def test_a_member_without_a_part_is_named() -> None:
    (found,) = messages("requirement { both, move } needs value.a < 1.0")
    assert found.endswith("(of 'move')")


def test_defaults_of_a_definition_that_is_not_installed_are_not_known() -> None:
    assert told("requirement both needs value.a < 1.0") == [("data-not-given", "value.a")]


LIBRARY = """library Limits {
    component Limit {
        parameter highest: double = 0.5
        requirement all needs value <= highest
        incoming message own with type: double
    }
}
"""


def test_a_component_of_a_library_limits_what_the_robot_provides(tmp_path: Path) -> None:
    (tmp_path / "Limits.rscd").write_text(LIBRARY)
    path = tmp_path / "robot.rscd"
    path.write_text(
        """robot Test {
            component Limit from Limits import Limit
            component Base { incoming message move with type: double }
            provide move with 0.2
            provide own with 0.3
        }
        """
    )
    robot, diagnostics = load(path)
    assert robot is not None, diagnostics
    assert [(r.communications, to_dsl(r.condition, robot)) for r in robot.requirements] == [
        (("Limit.own",), "0.3 <= Limit.highest"),
        (("Base.move",), "0.2 <= Limit.highest"),
    ]
    assert load(tmp_path / "Limits.rscd")[1] == ()
