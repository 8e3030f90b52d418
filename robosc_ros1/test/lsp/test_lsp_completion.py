"""What is offered at a place, in a model that is whole but for what is being typed there."""

from __future__ import annotations

from pathlib import Path

import pytest
from lsp_support import cursor, open_text

from robosc.lsp.analysis import Desk
from robosc.lsp.completion import complete
from robosc.model.ros.definitions import Interface

MODEL = """\
robot R {
    component Eye {
        outgoing message seen with identifier: "/seen", type: Sight
        outgoing message shape with type: Shape links shape
        behaviour {
            variable last: Sight = nothing
            variable bright: boolean = false
            initial marked state open {
                on response from seen do last := value
            }
            state shut {}
        }
    }
    component Wheel {
        incoming message drive with type: Twist links twist
        action turn with request: none, response: none, feedback: none links turn
    }
    requirement drive needs Eye.open
    provide drive with { linear: { x: 0.5 } } if Eye.bright
    datatype object Twist { linear: Vector }
    datatype object Vector { x: double }
    datatype object Shape { orientation: Turn }
    datatype object Turn { w: double }
    datatype enum Sight from double to {
        value > 1 -> far
        default -> nothing
    }
    interface twist use Twist from geometry_msgs
    interface shape use Pose from geometry_msgs
    interface turn use Turn from some_package
}
"""


def offered(tmp_path: Path, old: str, new: str) -> list[str]:
    """The labels at the mark in ``new``, typed in place of ``old``."""
    desk = Desk()
    path = tmp_path / "model.rscd"
    open_text(desk, path, MODEL)
    assert old in MODEL
    text, offset = cursor(MODEL.replace(old, new, 1))
    open_text(desk, path, text)
    return [candidate.label for candidate in complete(desk, str(path), offset)]


REQUIREMENT = "requirement drive needs Eye.open"
REACTION = "on response from seen do last := value"


@pytest.mark.parametrize(
    ("old", "new", "first"),
    [
        (REQUIREMENT, "requirement |", ["drive", "turn"]),
        (REQUIREMENT, "requirement dr|", ["drive", "turn"]),
        (REQUIREMENT, "requirement drive |", ["disables", "needs"]),
        (REQUIREMENT, "requirement drive needs Eye.|", ["bright", "last", "open", "shut"]),
        (REQUIREMENT, "requirement drive needs Eye.last = |", ["far", "nothing"]),
        (REQUIREMENT, "requirement { drive, | } needs Eye.open", ["drive", "turn"]),
        (REQUIREMENT, "requirement Eye.open disables |", ["drive", "turn"]),
        (REQUIREMENT, "interface x use Twist from |", ["geometry_msgs"]),
        (REACTION, "on request |", ["to"]),
        (REACTION, "on response from |", ["seen", "shape", "turn"]),
        (REACTION, "on feedback from |", ["turn"]),
        (REACTION, "on response from seen goto |", ["open", "shut"]),
        (REACTION, "on response from seen do |", ["bright", "last"]),
        (REACTION, "on response from seen do last := |", ["far", "nothing", "value"]),
        (REACTION, "on response from seen if value = |", ["far", "nothing", "value"]),
        (REACTION, "on response from shape if value.|", ["orientation"]),
        (REACTION, "on response from shape if value.orientation.|", ["w"]),
        (REACTION, "on response from seen |", ["do", "goto", "if"]),
        ("variable bright: boolean = false", "variable bright: |", ["Sight"]),
        ("variable bright: boolean = false", "variable bright: boolean = |", ["false", "true"]),
        ("type: Twist links twist", "type: Twist links |", ["shape", "turn", "twist"]),
        ("feedback: none links turn", "|", ["feedback:"]),
        ("provide drive with { linear", "provide |\n    provide drive with { linear", ["drive"]),
        ("provide drive with {", "provide drive |", ["with"]),
        ("{ linear: { x: 0.5 } }", "{ | }", ["linear"]),
        ("{ x: 0.5 }", "{ | }", ["x"]),
        ("{ x: 0.5 }", "|", ["{ }"]),
        ("value > 1 -> far", "value > 1 -> |", ["far", "nothing"]),
        ("component Wheel {", "component Wheel {\n |", ["action", "behaviour"]),
        ("robot R {", "robot R {\n |", ["component", "datatype enum", "datatype object"]),
        ("robot R {", "// |\nrobot R {", []),
        ('"/seen"', '"/se|"', []),
    ],
)
def test_what_comes_first(tmp_path: Path, old: str, new: str, first: list[str]) -> None:
    found = offered(tmp_path, old, new)
    assert found[: len(first)] == first or (not first and not found)
    assert first or not found


def test_outgoing_messages_are_no_commands(tmp_path: Path) -> None:
    assert "seen" not in offered(tmp_path, REQUIREMENT, "requirement |")


def test_fields_of_the_real_message(tmp_path: Path) -> None:
    definitions = Desk().definitions(str(tmp_path / "model.rscd"))
    if not isinstance(definitions.message("geometry_msgs", "Twist"), Interface):
        pytest.skip("geometry_msgs is not installed")
    assert offered(tmp_path, "{ x: double }", "{ x: double | }") == ["y", "z"]
    found = offered(tmp_path, "interface turn use Turn", "interface turn use |")
    assert {"Twist", "Bool", "SetBool"} <= set(found)


def test_libraries_and_their_components(tmp_path: Path) -> None:
    (tmp_path / "base.rscd").write_text("library Base { component Arm {} component Leg {} }")
    assert offered(tmp_path, "robot R {", "robot R {\n component A from |") == ["Base"]
    found = offered(tmp_path, "robot R {", "robot R {\n component A from Base import |")
    assert found[:2] == ["Arm", "Leg"]
