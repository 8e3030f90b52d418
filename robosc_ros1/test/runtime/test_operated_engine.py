"""An operator holds, releases and steps commands; what is forbidden stays so."""

from __future__ import annotations

import pytest
from runtime.lamp_robot import ARM, GO, HALT, LAMP
from runtime.played_engine import Played
from runtime.test_shadow_engine import Shadowed
from runtime.test_supervisor_engine import Bench

from robosc.runtime.core.engine import HELD

CLEAR, BLOCKED = 20.0, 5.0


def order(played: Played, word: str) -> list[str]:
    played.engine.operate(word)
    played.engine.cycle()
    return played.port.take()


def told(played: Played) -> list[tuple[str, str]]:
    entries = played.engine.recorder.take()
    return [(e.value, e.outcome) for e in entries if e.kind == "operator"]


def test_held_commands_are_not_sent_until_they_are_released() -> None:
    played = Played()
    played.controller.lamp_allowed = False
    played.begin()
    assert played.see(CLEAR) == [GO]
    assert order(played, "hold") == []
    assert played.see(BLOCKED) == played.see(CLEAR) == played.wait(1.0) == []
    assert played.controller.clear
    assert order(played, "release") == [GO]
    assert told(played) == [("hold", "operated"), ("release", "operated")]


def test_holding_stops_the_robot_and_cancels_its_goals() -> None:
    played = Played(stop_command=HALT)
    played.controller.lamp_allowed = False
    assert ARM in played.begin()
    assert order(played, "hold") == [HALT]
    assert played.port.cancelled == [(ARM, played.port.tokens[ARM])]


def test_steps_perform_one_command_that_is_allowed_in_turn() -> None:
    played = Played()
    played.begin()
    played.see(CLEAR)
    order(played, "hold")
    played.end(LAMP)
    steps = [order(played, "step") for _ in range(4)]
    assert all(len(sent) == 1 for sent in steps)
    assert {sent[0] for sent in steps} == {GO, LAMP}
    assert played.wait(1.0) == []
    played.see(BLOCKED)
    assert GO not in order(played, "step")


def test_a_step_without_a_command_that_is_allowed_is_refused() -> None:
    played = Played()
    played.controller.lamp_allowed = False
    played.controller.can_halt = lambda: False  # type: ignore[method-assign]
    played.begin()
    order(played, "hold")
    played.controller.arm = "stopping"
    played.engine.parts.scheduler.commands[1].allowed = lambda: False
    assert order(played, "step") == []
    assert told(played)[-1] == ("step", "refused")
    assert played.wait(1.0) == []


def test_a_step_is_no_use_of_what_cannot_be_sent() -> None:
    played = Played()
    played.begin()
    played.see(CLEAR)
    order(played, "hold")
    played.end(LAMP)
    played.port.broken = {GO}
    for _ in range(3):
        assert order(played, "step") == [LAMP]
        played.end(LAMP)
    played.controller.lamp_allowed = False
    told(played)
    assert order(played, "step") == []
    assert told(played) == [("step", "refused")]


@pytest.mark.parametrize("word", ["release", "step", "dance"])
def test_orders_that_mean_nothing_change_nothing(word: str) -> None:
    played = Played()
    played.begin()
    sent = order(played, word)
    assert (sent, played.engine.stopped) == ([], None)


def test_a_safe_stop_ends_what_is_held_for_good() -> None:
    played = Played()
    played.begin()
    order(played, "hold")
    played.engine.stop("because")
    assert order(played, "release") == order(played, "step") == []
    assert played.engine.stopped == "because"
    assert played.wait(1.0) == []


def test_a_supervisor_blocks_while_it_is_held_and_lets_one_step_pass() -> None:
    bench = Bench()
    bench.sense(CLEAR)
    bench.guard.operate("hold")
    assert bench.offer("fast") == []
    bench.guard.operate("step")
    assert bench.offer("fast") == [(GO, "fast")]
    assert bench.offer("fast") == []
    bench.guard.operate("release")
    assert bench.offer("fast") == [(GO, "fast")]


def test_nothing_gets_past_the_supervisor_by_a_step() -> None:
    bench = Bench()
    bench.sense(BLOCKED)
    bench.guard.operate("hold")
    bench.guard.operate("step")
    assert bench.offer("fast") == []
    bench.sense(CLEAR)
    assert bench.guard.stopped == HELD
    assert bench.offer("fast") == [(GO, "fast")]


def test_who_holds_a_robot_that_is_held_is_told_and_one_release_does_not_free_it() -> None:
    played = Played()
    played.controller.lamp_allowed = False
    played.begin()
    played.see(CLEAR)
    order(played, "hold")
    order(played, "hold")
    assert any("held 2 times" in text for _, text in played.port.logs)
    assert order(played, "release") == []
    told = played.engine.recorder.take()[-1]
    assert told.detail == "others hold it, too: one more release ends that"
    assert played.engine.stopped == HELD
    assert order(played, "release") == [GO]


def test_holding_again_cancels_what_was_let_through() -> None:
    played = Played(stop_command=HALT)
    played.controller.lamp_allowed = False
    played.begin()
    order(played, "hold")
    played.end(ARM, "cancelled", "over")
    while ARM not in order(played, "step"):
        pass
    token = played.port.tokens[ARM]
    assert order(played, "hold") == [HALT]
    assert played.port.cancelled[-1] == (ARM, token)


def test_a_step_that_nothing_has_used_ends_when_the_supervisor_is_held_again() -> None:
    bench = Bench()
    bench.sense(CLEAR)
    for word in ("hold", "step", "hold"):
        bench.guard.operate(word)
    assert bench.offer("fast") == []


def test_what_an_operator_holds_a_manager_does_not_free() -> None:
    played = Played()
    played.begin()
    played.see(CLEAR)
    order(played, "hold")
    played.engine.suspend()
    played.engine.cycle()
    assert played.engine.resume()
    played.engine.cycle()
    assert (played.engine.stopped, played.wait(1.0)) == (HELD, [])


def test_a_node_that_is_not_active_is_held_once_it_is() -> None:
    """Who holds a robot must not see it move because a manager activates the node."""
    played = Played()
    played.begin()
    played.engine.suspend()
    played.engine.cycle()
    assert order(played, "release") == [], "nobody holds it"
    order(played, "hold")
    played.see(CLEAR)
    assert played.engine.resume()
    played.engine.cycle()
    assert (played.engine.stopped, played.wait(1.0)) == (HELD, [])
    played.engine.suspend()
    played.engine.cycle()
    assert order(played, "release") == []
    assert played.engine.resume()
    played.engine.cycle()
    assert (played.engine.stopped, GO in played.wait(1.0)) == (None, True)


def test_nodes_that_send_nothing_refuse_orders() -> None:
    bench = Shadowed()
    bench.begin()
    for word in ("hold", "step", "release"):
        bench.shadow.operate(word)
        bench.shadow.cycle()
    entries = [e for e in bench.shadow.recorder.take() if e.kind == "operator"]
    assert [(e.outcome, e.detail) for e in entries] == [("refused", "this node sends nothing")] * 3
    assert bench.shadow.stopped is None
