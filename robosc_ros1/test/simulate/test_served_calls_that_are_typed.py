"""Calls of what the controller serves, and their cancels, as they are typed."""

from __future__ import annotations

import pytest
from emit.golden_packages import GOLDEN
from simulate.players import play, session

from robosc import pipeline
from robosc.simulate.faults import Refused
from robosc.simulate.script.session import Session

GOAL = "mission.request x: [2.0]"


@pytest.fixture
def player() -> Session:
    model = GOLDEN / "models" / "missions.rscd"
    return session(pipeline.supervise(pipeline.load(model).robot), execute=True)


def test_a_cancel_waits_for_the_answer_of_the_controller(player: Session) -> None:
    play(player, GOAL, "expect mission.busy")
    done = play(player, "mission.cancel")
    assert [h.kind for h in done.happenings if h.name == "mission"] == ["cancel", "error"]
    play(player, "expect mission.idle and Missions.free")


def test_only_a_goal_that_waits_can_be_cancelled(player: Session) -> None:
    with pytest.raises(Refused, match=r"mission.cancel cannot happen now: mission is idle"):
        play(player, "mission.cancel")
    play(player, "mission.request x: [-1.0]", "expect mission.idle")  # it is refused
    with pytest.raises(Refused):
        play(player, "mission.cancel")


def test_a_cancel_is_of_the_goal_that_was_accepted(player: Session) -> None:
    """Not of the one that was refused meanwhile, which was typed last."""
    play(player, GOAL, GOAL, "mission.cancel", "expect mission.idle and Missions.free")


def test_a_cancel_can_be_undone(player: Session) -> None:
    play(player, GOAL, "mission.cancel", "undo", "expect mission.busy")
    play(player, "mission.cancel", "expect mission.idle")
