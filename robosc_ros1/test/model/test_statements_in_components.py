"""Requirements, preferences and provided data in components mean what they mean in the robot."""

from __future__ import annotations

from pathlib import Path

import pytest
from model.model_text import faults, resolve

from robosc.errors import render_all
from robosc.model.entities import Requirement, Robot
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions

ROBOT = """
component Base {
    incoming message drive with type: double
    incoming message halt with type: none
}
component Arm {
    incoming message lift with type: double
    outgoing message top with type: boolean
    behaviour {
        variable high: boolean
        initial marked state ready {
            on response from top do high := value
            on request to lift goto moving
        }
        marked state moving { on response from top goto ready }
    }
    parameter height: double = 0.5
    condition low = !high
    INSIDE
}
stop with halt
"""

SAME = {
    "lift needs low": "Arm.lift needs Arm.low",
    "lift needs ready and !high": "lift needs Arm.ready and !Arm.high",
    "lift needs Arm.ready": "lift needs Arm.ready",
    "moving disables Base": "Arm.moving disables Base",
    "all except Arm needs ready": "all except Arm needs Arm.ready",
    "drive needs low to start": "drive needs Arm.low to start",
    "never high and moving": "never Arm.high and Arm.moving",
    "always ready or moving": "always Arm.ready or Arm.moving",
}


def essence(requirement: Requirement) -> tuple[object, ...]:
    return (
        requirement.kind,
        requirement.communications,
        requirement.condition,
        requirement.to_start,
    )


def with_inside(inside: str, outside: str = "") -> Robot:
    return resolve(ROBOT.replace("INSIDE", inside) + outside)


@pytest.mark.parametrize("inside", SAME)
def test_a_requirement_reads_the_names_of_its_component(inside: str) -> None:
    (found,) = with_inside(f"requirement {inside}").requirements
    (expected,) = with_inside("", f"requirement {SAME[inside]}").requirements
    assert essence(found) == essence(expected)


def test_preferences_and_data_read_the_names_of_their_component() -> None:
    inside = with_inside("prefer lift over Base provide lift with height if low")
    outside = with_inside("", "prefer lift over Base provide Arm.lift with Arm.height if !Arm.high")
    assert inside.preferences == outside.preferences
    assert inside.provides == outside.provides


def test_statements_of_the_robot_come_before_those_of_its_components() -> None:
    robot = with_inside(
        "requirement lift needs low provide lift with 0.1",
        "requirement drive needs Arm.ready provide lift with 0.2 if Arm.high",
    )
    assert [r.communications for r in robot.requirements] == [("Base.drive",), ("Arm.lift",)]
    assert [p.condition is None for p in robot.provides] == [False, True]


@pytest.mark.parametrize(
    ("inside", "code"),
    [
        ("requirement lift needs lo", "unknown-name"),
        ("requirement top needs low", "requirement-on-outgoing"),
        ("requirement lift needs height", "type-mismatch"),
        ("provide top with true", "provide-for-outgoing"),
        ("provide lift with low", "type-mismatch"),
        ("prefer lift over top", "preference-on-outgoing"),
        ("prefer lift over drive prefer drive over lift", "preference-cycle"),
        ("requirement all except all needs low", "unknown-communication"),
    ],
)
def test_faults_are_those_of_statements_in_the_robot(inside: str, code: str) -> None:
    assert code in [found for found, _ in faults(ROBOT.replace("INSIDE", inside))]


STATION = """
component Base { incoming message halt with type: none }
component Station[1..3] {
    incoming message go with identifier: "/go{index}", type: none
    outgoing message busy with identifier: "/busy{index}", type: boolean
    behaviour {
        variable full: boolean
        initial marked state on { on response from busy do full := value }
    }
    INSIDE
}
"""


@pytest.mark.parametrize(
    ("inside", "each"),
    [
        ("requirement go needs !full", "Station[i].go needs !Station[i].full"),
        ("requirement Station needs !Station.full", "Station[i] needs !Station[i].full"),
        ("requirement all except Station needs on", "all except Station[i] needs Station[i].on"),
        ("requirement go needs Station[2].full", "Station[i].go needs Station[2].full"),
        (
            "requirement go needs count(s.full for s in Station) < index",
            "Station[i].go needs count(s.full for s in Station) < i",
        ),
    ],
)
def test_in_a_copy_the_bare_name_is_the_copy_itself(inside: str, each: str) -> None:
    found = resolve(STATION.replace("INSIDE", inside)).requirements
    outside = f"for i in 1..3 {{ requirement {each} }}"
    expected = resolve(STATION.replace("INSIDE", "") + outside).requirements
    assert list(map(essence, found)) == list(map(essence, expected))
    assert [r.text.endswith(f"(index = {i})") for i, r in enumerate(found, 1)] == [True] * 3


SITE = """library Site {
    component EStop {
        outgoing message button with identifier: "estop", timeout: 1 s, type: boolean
        behaviour {
            variable pressed: boolean = true
            initial marked state watching { on response from button do pressed := value }
        }
        condition released = button.fresh and !pressed
        requirement all except EStop needs EStop.released
        requirement EStop.pressed or button.silent disables all
    }
    component Lamp {
        incoming message on with identifier: "on", type: double
        parameter level: double = 0.5
        provide on with level
        requirement on needs EStop.released
    }
}
"""


def imported(tmp_path: Path, text: str) -> tuple[Robot, str]:
    (tmp_path / "site.rscd").write_text(SITE)
    model = tmp_path / "model.rscd"
    model.write_text(f"robot R {{\n{text}\n}}\n")
    robot, found = load(str(model), (), MessageDefinitions.for_model(model, {}))
    assert robot is not None, render_all(found)
    return robot, render_all(found)


def test_a_library_with_statements_is_free_of_faults(tmp_path: Path) -> None:
    library = tmp_path / "site.rscd"
    library.write_text(SITE)
    assert load(str(library), (), MessageDefinitions.for_model(library, {})) == (None, ())


def test_statements_come_with_the_import_under_its_name(tmp_path: Path) -> None:
    robot, _ = imported(
        tmp_path,
        """component Stop from Site import EStop
        component Left from Site import Lamp with prefix: "/left", level: 0.2
        component Base { incoming message drive with type: none }""",
    )
    first, second, third = robot.requirements
    assert first.communications == second.communications == ("Left.on", "Base.drive")
    assert third.communications == ("Left.on",)
    for requirement in robot.requirements:
        assert "Stop" in repr(requirement.condition)
        assert "EStop" not in repr(requirement.condition)
    assert [p.communication for p in robot.provides] == ["Left.on"]


def test_a_group_may_be_empty_in_a_robot_that_imports_it(tmp_path: Path) -> None:
    robot, _ = imported(tmp_path, "component Stop from Site import EStop")
    assert robot.requirements == ()


def test_an_imported_command_without_stop_is_told_at_its_import(tmp_path: Path) -> None:
    _, told = imported(
        tmp_path, "component EStop from Site import EStop component Lamp from Site import Lamp"
    )
    assert "model.rscd:2" in told
    assert "warning[no-stop]: when the node ends, the robot goes on with the last on" in told
