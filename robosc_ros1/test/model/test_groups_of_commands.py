"""``all``, components and what is left out stand for the commands that they have."""

from __future__ import annotations

import pytest
from model.model_text import faults, resolve

ROBOT = """
component EStop {
    outgoing message button with timeout: 1 s, type: boolean
    behaviour {
        variable pressed: boolean = true
        initial marked state on { on response from button do pressed := value }
    }
}
interface act use Test from actionlib
component Base {
    incoming message drive with type: none
    incoming message halt with type: none
    action dock with request: none, response: none, feedback: none links act
}
component Arm[1..3] {
    incoming message lift with identifier: "/lift{index}", type: none
    incoming message drop with identifier: "/drop{index}", type: none
}
"""
BASE = ["Base.drive", "Base.halt", "Base.dock"]
ARMS = [[f"Arm[{i}].lift", f"Arm[{i}].drop"] for i in (1, 2, 3)]
ALL = [*BASE, *ARMS[0], *ARMS[1], *ARMS[2]]
NEEDS = "needs !EStop.pressed"

GROUPS = {
    "all": ALL,
    "all except halt": [key for key in ALL if key != "Base.halt"],
    "all except { halt, dock }": [key for key in ALL if key not in ("Base.halt", "Base.dock")],
    "all except Arm": BASE,
    "all except Arm[2]": [*BASE, *ARMS[0], *ARMS[2]],
    # What is left out of the exception is in it.
    "all except Arm except Arm[1]": [*BASE, *ARMS[0]],
    "all except { Base, Arm } except { halt, Arm[3].lift }": ["Base.halt", "Arm[3].lift"],
    "Base": BASE,
    "Base except drive": ["Base.halt", "Base.dock"],
    "Arm": [*ARMS[0], *ARMS[1], *ARMS[2]],
    "Arm[2]": ARMS[1],
    "{ Arm[1], drive }": [*ARMS[0], "Base.drive"],
    "{ Base, drive, Arm[1].lift } except Base.dock": ["Base.drive", "Base.halt", "Arm[1].lift"],
    "halt": ["Base.halt"],
}


@pytest.mark.parametrize("group", GROUPS)
def test_groups_of_requirements(group: str) -> None:
    for statement in (f"{group} {NEEDS}", f"EStop.pressed disables {group}"):
        robot = resolve(f"{ROBOT} requirement {statement}")
        (requirement,) = robot.requirements
        assert list(requirement.communications) == GROUPS[group]
        assert requirement.text == f"requirement {statement}"
        keys = ", ".join(GROUPS[group])
        one_by_one = resolve(f"{ROBOT} requirement {{ {keys} }} {NEEDS}")
        assert one_by_one.requirements[0].communications == requirement.communications


@pytest.mark.parametrize("group", GROUPS)
def test_groups_of_preferences(group: str) -> None:
    ping = "component Lamp { incoming message ping with type: none }"
    after = resolve(f"{ROBOT} {ping} prefer ping over {group}").preferences[0]
    assert [key for key in after.over if key != "Lamp.ping"] == GROUPS[group]
    assert "Lamp.ping" not in after.over
    before = resolve(f"{ROBOT} {ping} prefer {group} over all").preferences[0]
    assert [key for key in before.preferred if key != "Lamp.ping"] == GROUPS[group]
    assert set(before.preferred).isdisjoint(before.over)
    assert {*before.preferred, *before.over} == {*ALL, "Lamp.ping"}


def test_groups_in_copies_of_statements() -> None:
    robot = resolve(
        f"{ROBOT} for i in 1..2 {{ requirement Arm[i + 1] except Arm[i + 1].drop {NEEDS} }}"
    )
    assert [r.communications for r in robot.requirements] == [("Arm[2].lift",), ("Arm[3].lift",)]


def test_all_is_a_name_where_it_is_escaped_and_a_function_before_parentheses() -> None:
    lamp = "component Lamp { incoming message ^all with type: none }"
    (named,) = resolve(f"{ROBOT} {lamp} requirement ^all {NEEDS}").requirements
    assert named.communications == ("Lamp.all",)
    (asked,) = resolve(f"{ROBOT} requirement all(x for x in [EStop.on]) disables halt").requirements
    assert asked.communications == ("Base.halt",)


def test_a_name_of_both_is_the_communication() -> None:
    both = "component drive2 { incoming message drive2 with type: none"
    both += " incoming message other with type: none }"
    (named,) = resolve(f"{both} component A {{ behaviour {{ initial marked state s {{}} }} }}"
                       " requirement drive2 needs A.s").requirements  # fmt: skip
    assert named.communications == ("drive2.drive2",)


@pytest.mark.parametrize(
    ("statement", "fault"),
    [
        (f"requirement EStop {NEEDS}", ("unknown-communication", "EStop")),
        (f"requirement all except all {NEEDS}", ("unknown-communication", "except all")),
        (f"requirement halt except Base {NEEDS}", ("unknown-communication", "except Base")),
        (f"requirement all except hlat {NEEDS}", ("unknown-communication", "hlat")),
        (f"requirement all except button {NEEDS}", ("requirement-on-outgoing", "button")),
        (f"requirement Arm[7] {NEEDS}", ("bad-index", "Arm[7]")),
        ("prefer all over halt", ("preference-cycle", "prefer all over halt")),
        (f"requirement {{ halt, halt }} {NEEDS}", ("repeated-communication", "halt")),
        ("requirement EStop.pressed except halt disables drive", ("syntax", "except halt")),
        ("provide all with {}", ("unknown-communication", "all")),
    ],
)
def test_faults_of_groups(statement: str, fault: tuple[str, str]) -> None:
    assert fault in faults(f"{ROBOT} {statement}")
