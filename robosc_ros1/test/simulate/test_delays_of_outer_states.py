"""A delay in a state with states in it counts from the entry of that state, on the virtual clock."""

from __future__ import annotations

import random

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, session

from robosc.simulate.script.session import Session

MODEL = """
robot Porter {
    component Base {
        outgoing message step with type: none
        outgoing message again with type: none
        outgoing message near with type: none
        outgoing message away with type: none
        outgoing message back with type: none
        behaviour {
            variable lapses: integer(0..9)
            on response from back goto docking
            initial marked state idle {}
            marked state docking {
                on response from again goto docking
                on response from near goto near
                on response from away goto idle
                after 1950 ms if lapses < 9 do lapses := lapses + 1
                initial state near {
                    on response from step goto moving
                    after 2950 ms goto moving
                }
                state moving { on response from step goto near }
            }
        }
    }
}
"""


@pytest.fixture
def player() -> Session:
    return session(supervisor_of(MODEL), execute=True)


def test_moves_inside_do_not_restart_it(player: Session) -> None:
    play(player, "back", "wait 1", "step", "wait 0.5", "near", "wait 0.4", "expect Base.lapses = 0")
    play(player, "wait 0.2", "expect Base.lapses = 1 and Base.near", "wait 5")
    play(player, "expect Base.lapses = 1 and Base.moving")  # once per entry


@pytest.mark.parametrize("entering", ["again", "back"])
def test_a_goto_that_names_it_restarts_it(player: Session, entering: str) -> None:
    play(player, "back", "step", "wait 1.9", entering, "wait 1.9", "expect Base.lapses = 0")
    play(player, "wait 0.2", "expect Base.lapses = 1")


def test_leaving_it_stops_it(player: Session) -> None:
    play(player, "back", "wait 1.9", "away", "wait 5", "expect Base.lapses = 0 and Base.idle")
    play(player, "back", "wait 1.9", "expect Base.lapses = 0", "wait 0.2", "expect Base.lapses = 1")


def test_random_runs_agree_with_a_count_by_hand() -> None:
    """The time since the last entry of each state decides alone."""
    for seed in range(6):
        draw = random.Random(seed)
        player = session(supervisor_of(MODEL), execute=True)
        here, lapses, entered, moved, done, time = "idle", 0, 0, 0, False, 0
        for _ in range(60):
            word = draw.choice(("step", "again", "near", "away", "back", "wait", "wait"))
            if word == "wait":
                passed = draw.randrange(1, 20)  # tenths of a second
                until = time + passed
                while time < until:
                    time += 1
                    if here == "near" and time - moved == 30:
                        here = "moving"
                    if here != "idle" and not done and time - entered == 20:
                        done, lapses = True, min(9, lapses + 1)
                play(player, f"wait {passed / 10}")
            else:
                play(player, word)
                inside = here != "idle"
                if word == "step" and inside:
                    here = "moving" if here == "near" else "near"
                    moved = time
                elif word == "near" and inside:
                    here, moved = "near", time
                elif (word == "again" and inside) or word == "back":
                    here, moved, entered, done = "near", time, time, False
                elif word == "away" and inside:
                    here = "idle"
            state = here if here == "idle" else f"docking.{here}"
            play(player, f"expect Base.{state} and Base.lapses = {lapses}")
