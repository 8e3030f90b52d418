"""Elements of an array or parts of an object that is typed as a whole."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, session

MODEL = """
robot R {
    interface link use Report from some_msgs
    datatype object Report { position: array(double) place: Place }
    datatype object Place { x: double }
    component A {
        outgoing message joints with type: Report links link
        incoming message far with type: none
        incoming message near with type: Place links link
        behaviour {
            variable q: array(double)
            variable place: Place
            variable x: double
            variable y: double
            initial marked state s {
                on response from joints
                    do q := value.position, x := value.position[2], place := value.place,
                        y := value.place.x
            }
        }
    }
    requirement far needs A.x > 0.5 and A.q[1] > 0.5 and A.y > 1
    provide near with A.place
}
"""


@pytest.mark.parametrize("execute", [False, True])
def test_what_a_whole_holds_is_there(execute: bool) -> None:
    player = session(supervisor_of(MODEL), execute=execute)
    play(player, "joints position: [1.0, 2.0, 3.0], place.x: 4.0")
    play(player, "expect A.x = 3.0", "expect A.q[1] > 0.5", "expect A.y = 4.0")
    play(player, "joints position: [0.5], place.x: 0.0")
    play(player, "expect A.x = 3.0", "expect !defined(A.q[1])", "expect A.y = 0.0")


@pytest.mark.parametrize("execute", [False, True])
def test_what_is_drawn_is_one_value(execute: bool) -> None:
    player = session(supervisor_of(MODEL), execute=execute)
    for seed in range(20):
        play(player, f"random 1 {seed}")
        state = player.machine.state.variables
        if state["A.place"] is not None:
            assert state["A.place"].x == state["A.y"]
