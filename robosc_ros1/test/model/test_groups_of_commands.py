"""``all``, components and what is left out stand for the commands that they have."""

from __future__ import annotations

import pytest
from model.model_text import behaviour_of, faults, resolve

from robosc.language.events import EventKind
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.source import Source
from robosc.syntax.formatting.format import format_text

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


@pytest.mark.parametrize("group", GROUPS)
def test_groups_of_transitions(group: str) -> None:
    """Each event of each command that has it, in the order of the group."""
    watch = (
        "component Watch {{ behaviour {{ variable n: boolean initial marked state s {{ {} }} }} }}"
    )
    text = f"{ROBOT} {watch.format(f'on request to {group} do n := true')}"
    (state,) = behaviour_of(resolve(text), "Watch").states
    assert [t.communication for t in state.transitions] == GROUPS[group]
    having = [key for key in GROUPS[group] if key == "Base.dock"]
    text = f"{ROBOT} {watch.format(f'on error, cancel from {group} do n := true')}"
    if having:
        (state,) = behaviour_of(resolve(text), "Watch").states
        found = [(t.event, t.communication) for t in state.transitions]
        assert found == [(EventKind.ERROR, "Base.dock"), (EventKind.CANCEL, "Base.dock")]
    else:
        assert ("event-not-available", "error") in faults(text)


def test_an_outgoing_message_is_named_beside_a_group() -> None:
    watch = """
    component Watch { behaviour {
        variable last: boolean
        initial marked state s { on response from { button, Base } except drive do last := true }
    } }
    """
    (state,) = behaviour_of(resolve(f"{ROBOT} {watch}"), "Watch").states
    assert [t.communication for t in state.transitions] == ["EStop.button", "Base.dock"]


def test_the_own_component_is_a_group_and_each_of_several_means_itself() -> None:
    watch = """
    component Lamp[1..2] {
        incoming message on with identifier: "/on{index}", type: none
        incoming message off with identifier: "/off{index}", type: none
        behaviour {
            variable last: boolean
            initial marked state s { on request to Lamp except on do last := true }
        }
    }
    """
    robot = resolve(f"{ROBOT} {watch}")
    for n in (1, 2):
        (state,) = behaviour_of(robot, f"Lamp[{n}]").states
        assert [t.communication for t in state.transitions] == [f"Lamp[{n}].off"]


def test_the_layout_of_groups_in_transitions() -> None:
    text = (
        "robot R{component P{behaviour{on error  from all except{Base,drive}except halt goto a}}}"
    )
    layout = "on error from all except { Base, drive } except halt goto a\n"
    assert layout in format_text(Source("m", text))


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


def test_a_cycle_is_told_in_names_that_can_be_written() -> None:
    """Those of copies and of answers, which have no name of their own alone."""
    _, found = load(
        Source(
            "model.rscd",
            """robot R {
                interface link use Work from some_package
                component Arm[1..2] {
                    incoming message lift with identifier: "/lift{index}", type: none
                }
                component Desk {
                    outgoing service task with request: none, response: none links link
                    behaviour {
                        initial marked state a { on request from task goto b }
                        state b { on response to task goto a }
                    }
                }
                prefer Arm[1].lift over Arm[2].lift
                prefer Arm[2].lift over task
                prefer task over Arm[1].lift
            }""",
        ),
        definitions=MessageDefinitions(),
    )
    (cycle,) = (d.message for d in found if d.code == "preference-cycle")
    told = cycle.removeprefix("each of these is preferred to the next: ").split(" over ")
    assert told[0] == told[-1]
    assert set(told) == {"Arm[1].lift", "Arm[2].lift", "task"}
