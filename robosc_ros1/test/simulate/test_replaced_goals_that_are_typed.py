"""Goals that replace others, in a simulation: what is typed ends the latest one."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, sent, session

ROVER = """robot Rover {
    component Rover {
        action roam with goals: replace, request: Spot, response: none, feedback: none links roam
        outgoing message spot with type: double
        behaviour {
            variable target: double = 0.0
            on response from spot do target := value
            initial marked state parked { transition if spot.heard goto roaming }
            state roaming performs roam with { x: target } then goto arrived
            marked state arrived {}
        }
    }
    datatype object Spot { x: double }
    interface roam use Roam from some_rover_msgs
}
"""


@pytest.mark.parametrize("end", ["roam.response", "roam.error"])
def test_a_goal_that_replaced_another_one_can_end(end: str) -> None:
    player = session(supervisor_of(ROVER), execute=True)
    assert sent(play(player, "spot 1.0")) == ["roam"]
    for place in ("2.0", "3.0"):
        play(player, "wait 0.2")
        assert sent(play(player, f"spot {place}")) == ["roam"]
    play(player, "expect roam.busy", end)
    play(player, "expect roam.idle")
    play(player, f"expect Rover.{'arrived' if end == 'roam.response' else 'roaming.due'}")


def test_so_it_is_behind_a_supervisor() -> None:
    player = session(supervisor_of(ROVER, supervises=True), execute=True)
    play(player, "spot 1.0", "roam.request", "roam.request", "expect roam.busy")
    play(player, "roam.response", "expect roam.idle")
