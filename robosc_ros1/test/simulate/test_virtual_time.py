"""Time on the virtual clock: silence, waiting, preferences, and logs of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, sent, session
from simulate.test_replay import lines_of, run_of, write

from robosc.simulate.replay import replay
from robosc.simulate.script.documents import command_document
from robosc.simulate.script.render import Style, happenings_text, session_text

WATCH = """robot Watch {
    component Front {
        outgoing message free with timeout: 500 ms, type: boolean
        behaviour {
            variable clear: boolean
            on response from free do clear := value
            initial marked state watching { on timeout from free goto blind }
            marked state blind {
                on response from free goto watching
                after 2 s if !clear goto watching
            }
        }
    }
    component Base {
        incoming message drive with type: none
        incoming message halt with type: none
    }
    requirement drive needs free.fresh and Front.clear
    prefer drive over halt
}
"""


def test_silence_ends_what_needs_a_fresh_message() -> None:
    player = session(supervisor_of(WATCH), execute=True)
    play(player, "expect free.silent", "expect disabled drive", "free true", "expect enabled drive")
    assert set(sent(play(player, "wait 0.4"))) == {"drive"}
    done = play(player, "wait 0.2")
    assert ("timeout", "free", 0.5) in [(h.kind, h.name, h.time) for h in done.happenings]
    play(player, "expect free.silent", "expect Front.blind", "expect disabled drive")
    assert set(sent(play(player, "wait 1"))) == {"halt"}


def test_a_transition_after_a_delay_is_told_as_in_a_trace() -> None:
    player = session(supervisor_of(WATCH), execute=True)
    play(player, "free false", "wait 0.6", "expect Front.blind")
    told = happenings_text(play(player, "wait 2").happenings, Style(False))
    assert "    2.500 s    Front: blind->watching\n" in told


@pytest.mark.parametrize("execute", [False, True])
def test_what_waits_for_a_preferred_command_is_told(execute: bool) -> None:
    player = session(supervisor_of(WATCH), execute=execute)
    assert "now: enabled\n" in play(player, "why halt").text
    play(player, "free true")
    commands = {c.event.name: c for c in player.machine.commands()}
    assert (commands["halt"].waits_for, commands["drive"].waits_for) == (("drive",), ())
    assert command_document(commands["halt"])["waits_for"] == ["drive"]
    text = play(player, "why halt").text
    assert "now: enabled, but drive is preferred and sent" in text
    shown = "\n".join([session_text(player, Style(False))])
    assert ("halt.request  waits for drive" in shown) is execute


def test_each_message_starts_the_time_anew() -> None:
    player = session(supervisor_of(WATCH), execute=True)
    for _ in range(5):
        play(player, "free true", "wait 0.4", "expect free.fresh")


def test_a_transition_waits_for_its_time_and_its_guard() -> None:
    player = session(supervisor_of(WATCH), execute=True)
    play(player, "free false", "wait 2.4", "expect Front.blind")
    done = play(player, "wait 0.2")
    assert [(h.name, h.index, h.value, h.time) for h in done.happenings if h.kind == "after"] == [
        ("Front", 1, "blind->watching", pytest.approx(2.5, abs=1e-9))
    ]
    play(player, "free true", "wait 10", "expect Front.blind")


def test_time_is_a_choice_in_single_events() -> None:
    player = session(supervisor_of(WATCH))
    play(player, "free false", "free.timeout", "expect Front.blind", "Front.after1")
    play(player, "expect Front.watching", "expect free.silent")


def test_a_log_with_time_follows_its_model(tmp_path: Path) -> None:
    supervisor = supervisor_of(WATCH)
    player = session(supervisor, execute=True)
    log = lines_of(run_of(player, "free false", "wait 3", "free true", "wait 1"))
    assert any('"after"' in line for line in log) and any('"timeout"' in line for line in log)
    found = replay(supervisor, write(tmp_path / "events.log", log))
    assert (found.departures, found.missing) == ((), ())


def test_what_another_delay_makes_ready_comes_before_a_command() -> None:
    model = """robot Chain {
        component A { behaviour {
            initial marked state a0 { after 1 s goto a1 } marked state a1 {}
        } }
        component B {
            incoming message drive with type: none
            behaviour {
                initial marked state b0 { after 0.5 s if A.a1 goto b1 } marked state b1 {}
            }
        }
        requirement drive needs A.a1 and B.b0
    }"""
    player = session(supervisor_of(model), execute=True)
    assert sent(play(player, "wait 1.01")) == []
    play(player, "expect B.b1")


def test_what_a_missed_deadline_makes_ready_comes_before_a_command() -> None:
    model = """robot Patience {
        interface power use SetBool from std_srvs
        datatype object Wish { ^data: boolean }
        datatype object Answer { success: boolean }
        component Switch {
            service flip with timeout: 3 s, request: Wish, response: Answer links power
        }
        component C {
            incoming message drive with type: none
            behaviour {
                initial marked state waiting { after 1 s if flip.idle goto done }
                marked state done {}
            }
        }
        provide flip with { ^data: true }
        requirement drive needs C.waiting and flip.idle
        requirement flip needs C.waiting
    }"""
    player = session(supervisor_of(model), execute=True)
    play(player, "wait 2", "expect C.waiting", "expect flip.busy")
    assert sent(play(player, "wait 1.01")) == []
    play(player, "expect C.done")


BOAT = """robot Boat {
    component Depth {
        outgoing message depth with timeout: 1 s, max_age: 200 ms, type: sensor_msgs/Range
        behaviour {
            variable below: double
            initial marked state sounding { on response from depth do below := value.range }
        }
    }
    component Engine { incoming message ahead with type: none }
    requirement ahead needs depth.fresh and Depth.below > 2.0
}
"""


@pytest.mark.parametrize("supervises", [False, True])
def test_what_is_typed_is_as_young_as_the_model_asks(supervises: bool) -> None:
    player = session(supervisor_of(BOAT, supervises=supervises), execute=True)
    play(player, "expect disabled ahead", "depth range: 3.5", "expect depth.fresh")
    play(player, "expect enabled ahead", "wait 1.1", "expect depth.silent", "expect disabled ahead")


BEATS = """
robot Beats {
    component Base {
        outgoing message alive with timeout: 1 s, type: none
        incoming message go with rate: 5 Hz, type: none
        incoming message halt with rate: 5 Hz, type: none
    }
    requirement go needs alive.fresh
    requirement halt needs alive.silent
}
"""


def test_five_periods_and_a_silence_of_their_length_come_at_once() -> None:
    """A sum of periods is rounded, so that ``go`` was sent once more: no node does that."""
    player = session(supervisor_of(BEATS), execute=True)
    for start in range(10):
        play(player, f"wait {0.1 + start / 7:.6f}")
        done = play(player, "alive", "wait 1")
        sent = [h.name for h in done.happenings if h.kind in ("request", "timeout")]
        assert sent == ["go"] * 4 + ["alive", "halt"], start
