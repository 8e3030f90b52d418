"""A component that performs several actions has one under way (docs/language.md, "States that
perform a command")."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from model.test_servers import under_way
from simulate.players import play, session

from robosc.synthesis.verify.verification import verify

ROBOT = """
robot Rover {
    interface goal use Go from some_msgs
    interface switch use SetBool from std_srvs
    component Battery {
        outgoing message low with type: boolean
        behaviour {
            variable is_low: boolean
            initial marked state on { on response from low do is_low := value }
        }
    }
    component Mission {
        action go with identifier: "/go", %s request: none, response: none, feedback: none
            links goal
        action dock with identifier: "%s", request: none, response: none, feedback: none links goal
        service lamp with identifier: "/lamp", request: none, response: none links switch
        incoming message horn with type: none
        behaviour {
            initial marked state driving performs go then goto driving {
                transition if Battery.is_low goto docking
            }
            state docking performs dock %s then goto shining
            state shining performs lamp then goto hooting
            marked state hooting performs horn then goto rest
            marked state rest {}
        }
    }
    %s
}
"""
LEFT = ("low true", "Mission.tau1")
WAITS = ("dock waits for go, which is under way", "dock waits for go, which is being cancelled")


def robot(attribute: str = "", name: str = "/dock", meanwhile: str = "", more: str = "") -> str:
    return ROBOT % (attribute, name, meanwhile, more)


def test_the_next_action_waits_for_the_one_that_was_left() -> None:
    supervisor = supervisor_of(robot())
    assert not any({"go", "dock"} <= names for names in under_way(supervisor))
    assert verify(supervisor).verified
    player = session(supervisor)
    play(player, "go.request", *LEFT, "expect disabled dock.request")
    assert WAITS[0] in play(player, "why dock.request").text
    play(player, "go.cancel", "expect disabled dock.request")
    assert WAITS[1] in play(player, "why dock.request").text
    play(player, "go.cancelled", "dock.request")


@pytest.mark.parametrize("end", ["response", "error", "cancelled"])
def test_however_it_ends(end: str) -> None:
    player = session(supervisor_of(robot()))
    play(player, "go.request", *LEFT, "go.cancel", f"go.{end}")
    play(player, "expect enabled dock.request")


def test_services_wait_and_messages_do_not() -> None:
    texts = [r.text for r in supervisor_of(robot()).plant.robot.requirements]
    waits = {text.partition(",")[0] for text in texts if " waits for " in text}
    assert waits == {
        "go waits for dock",
        "dock waits for go",
        "lamp waits for go",
        "lamp waits for dock",
    }


def test_meanwhile_does_not_wait() -> None:
    supervisor = supervisor_of(robot(meanwhile="meanwhile"))
    assert any({"go", "dock"} <= names for names in under_way(supervisor))
    player = session(supervisor)
    play(player, "go.request", *LEFT, "dock.request")
    play(player, "expect go.busy and dock.busy")


def test_a_goal_that_is_replaced_is_none_of_the_others() -> None:
    player = session(supervisor_of(robot(attribute="goals: replace,")))
    play(player, "go.request", "expect enabled go.request", "go.request")


def test_actions_of_one_server_are_told_once() -> None:
    texts = [r.text for r in supervisor_of(robot(name="/go")).plant.robot.requirements]
    assert not [text for text in texts if text in WAITS]
    assert "/go is one server: dock needs go.idle to start" in texts


def test_what_another_component_performs_is_not_waited_for() -> None:
    other = """
        component Other {
            action arm with request: none, response: none, feedback: none links goal
            behaviour {
                initial marked state moving performs arm then
            }
        }
    """
    supervisor = supervisor_of(robot(more=other))
    assert any({"go", "arm"} <= names for names in under_way(supervisor))


def test_of_several_that_perform_an_action_only_those_wait_that_ask() -> None:
    """The other one performs both as well, but asks for the first one whatever else goes on."""
    other = """
        component Other {
            behaviour {
                initial marked state one performs dock meanwhile then goto two
                marked state two performs go then goto one
            }
        }
    """
    supervisor = supervisor_of(robot(more=other))
    assert verify(supervisor).verified
    assert any({"go", "dock"} <= names for names in under_way(supervisor))
