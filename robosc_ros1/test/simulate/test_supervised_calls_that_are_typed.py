"""Calls of the robot through a supervisor, and the answers of the controller, as they are typed."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from emit.golden_packages import model_path
from simulate.players import play

from robosc.simulate.faults import Refused
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker


def player(model: str) -> Session:
    path = model_path(model)
    supervisor = supervisor_of(path.read_text("utf-8"), str(path), supervises=True)
    return Session(machine_maker(supervisor, execute=True))


def test_an_answer_waits_until_it_is_allowed() -> None:
    orders = player("orders")
    play(orders, "order.request data: true", "expect order.busy")
    done = play(orders, "order.response")
    assert [(h.kind, h.outcome) for h in done.happenings] == [("response", "blocked")]
    assert "requirement order needs Door.open" in (done.happenings[0].detail or "")
    done = play(orders, "door true")
    assert [(h.name, h.kind, h.outcome) for h in done.happenings] == [
        ("door", "response", "applied"),
        ("order", "response", "applied"),
    ]
    play(orders, "expect order.idle")


def test_the_controller_may_take_its_time() -> None:
    """It is there, so no deadline ends a call that it has taken, as none does in the node."""
    orders = player("orders")
    play(orders, "order.request data: true", "door true")
    assert not play(orders, "wait 60").happenings
    play(orders, "expect order.busy", "order.response", "expect order.idle")


def test_an_error_and_a_cancel() -> None:
    missions = player("missions")
    play(missions, "mission.request x: [2.0]", "mission.feedback", "mission.cancel")
    play(missions, "expect mission.ending", "mission.error", "expect mission.idle")


def test_what_nobody_waits_for_is_refused() -> None:
    orders = player("orders")
    with pytest.raises(Refused, match=r"order\.response cannot happen now: order is idle"):
        play(orders, "order.response")
    play(orders, "order.request data: true", "order.response")  # held back until the door is open
    with pytest.raises(Refused, match=r"order\.response cannot happen now: order is answered"):
        play(orders, "order.response")
