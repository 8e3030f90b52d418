"""Communications with one name in ROS are one server, of which one at most is under way."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, session

from robosc.model.declarations.servers import shared_servers
from robosc.model.resolve import load
from robosc.plant.automaton import VariableKind
from robosc.plant.build import lower
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import explore
from robosc.synthesis.verify.verification import verify

ROBOT = """
robot Walker {
    interface goal use Go from some_msgs
    interface switch use SetBool from std_srvs
    component Base {
        outgoing message tired with type: boolean
        action go with identifier: "/navigate", request: none, response: none, feedback: none
            links goal
        action home with identifier: "%s", request: none, response: none, feedback: none links goal
        service on with identifier: "/power", request: none, response: none links switch
        service off with identifier: "/power", request: none, response: none links switch
        service other with identifier: "/lamp", request: none, response: none links switch
        behaviour {
            variable is_tired: boolean
            on response from tired do is_tired := value
            initial marked state there {}
        }
    }
    requirement go needs !Base.is_tired
}
"""
ONE = "/navigate is one server: go needs home.idle to start"


def under_way(supervisor: Supervisor) -> set[frozenset[str]]:
    """Which communications are under way together in the states under control."""
    variables = supervisor.plant.variables
    return {
        frozenset(
            variable.name.partition(".")[2]
            for variable, index in zip(variables, state, strict=True)
            if variable.kind is VariableKind.PHASE and index
        )
        for state in explore(supervisor).states
    }


@pytest.mark.parametrize(
    ("one", "other"), [("/go", "go"), ("~go", "~/go"), ("go", "go"), ("~/a/go", "~a/go")]
)
def test_names_are_compared_as_ros_takes_them(one: str, other: str) -> None:
    text = (ROBOT % other).replace('"/navigate"', f'"{one}"', 1)
    robot = supervisor_of(text).plant.robot
    assert [[c.name for c in together] for together in shared_servers(robot)] == [
        ["go", "home"],
        ["on", "off"],
    ]


@pytest.mark.slow
def test_a_server_of_very_many() -> None:
    """The conditions are no deeper than later stages can follow."""
    text = """
        interface switch use SetBool from std_srvs
        component Station[1..300] {
            service on with identifier: "/power", request: none, response: none links switch
        }
    """
    robot, diagnostics = load(Source("m.rscd", f"robot Many {{ {text} }}"))
    assert robot is not None and not diagnostics
    assert len(lower(robot).events) == 900


@pytest.mark.parametrize("identifier", ["/navigate", "navigate"])
def test_one_of_a_server_waits_for_the_other(identifier: str) -> None:
    supervisor = supervisor_of(ROBOT % identifier)
    texts = [r.text for r in supervisor.plant.robot.requirements]
    assert texts == [
        "requirement go needs !Base.is_tired",
        ONE,
        f"{identifier} is one server: home needs go.idle to start",
        "/power is one server: on needs off.idle to start",
        "/power is one server: off needs on.idle to start",
    ]
    found = under_way(supervisor)
    assert not any({"go", "home"} <= names or {"on", "off"} <= names for names in found)
    assert any({"home", "on", "other"} <= names for names in found)
    assert verify(supervisor).verified
    # No warning tells of requirements that nobody has written, and none of them cancels anything.
    assert not [d for d in supervisor.diagnostics if "one server" in d.message]
    player = session(supervisor)
    play(player, "home.request", "expect disabled go.request", "expect disabled home.cancel")
    play(player, "home.response", "go.request", "tired true", "go.cancel")
    # It is still there until its server says so.
    play(player, "expect go.cancelling", "expect disabled home.request")
    play(player, "go.cancelled", "expect enabled home.request")


def test_other_names_are_other_servers() -> None:
    supervisor = supervisor_of(ROBOT % "/home")
    assert [r.text for r in supervisor.plant.robot.requirements if "/navigate" in r.text] == []
    assert any({"go", "home"} <= names for names in under_way(supervisor))


def test_a_name_that_is_not_given_is_that_of_the_communication() -> None:
    text = (
        (ROBOT % "/navigate")
        .replace('"/navigate"', '"/x"', 1)
        .replace('home with identifier: "/navigate", ', "x with ")
    )
    texts = [r.text for r in supervisor_of(text).plant.robot.requirements]
    assert "/x is one server: go needs x.idle to start" in texts


def test_what_forbids_a_command_is_told() -> None:
    player = session(supervisor_of(ROBOT % "/navigate"))
    play(player, "home.request")
    assert ONE in play(player, "why go.request").text
