"""Playing and following robots whose models declare parameters."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from simulate.players import session

from robosc.runtime.core.recorder import Entry
from robosc.runtime.core.telemetry import event_document
from robosc.simulate.faults import InvalidLine
from robosc.simulate.replay import replay
from robosc.simulate.start import machine_maker
from robosc.supervisor import Supervisor

ROBOT = """robot Cart {
    parameter least: double = 0.2
    parameter gear: integer(1..3) = 2
    component Battery {
        outgoing message power with type: double
        behaviour {
            variable charge: double = 0.5
            initial marked state watching { on response from power do charge := value }
        }
    }
    component Motor { incoming message drive with type: double }
    requirement drive needs Battery.charge > least and gear > 1
    provide drive with least * gear
}
"""


@pytest.fixture(scope="module")
def cart() -> Supervisor:
    return supervisor_of(ROBOT)


def enabled(machine: Any) -> list[str]:
    return [c.event.name for c in machine.commands() if c.enabled]


@pytest.mark.parametrize("execute", [False, True])
def test_parameters_decide_and_are_sent(cart: Supervisor, execute: bool) -> None:
    make = machine_maker(cart, execute=execute)
    (drive,) = make({}).commands()
    assert (drive.enabled, drive.data) == (True, {"data": 0.4})
    assert enabled(make({"least": 0.7})) == []
    assert enabled(make({"gear": 1})) == []
    (drive,) = make({"least": 0.25, "gear": 3}).commands()
    assert (drive.enabled, drive.data) == (True, {"data": 0.75})


def test_single_events_know_what_comes_of_a_number(cart: Supervisor) -> None:
    player = session(cart, parameters={"least": 0.7})
    for line, allowed in (("power.response 0.8", True), ("power.response 0.6", False)):
        player.do(line)
        assert bool(enabled(player.machine)) == allowed


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"gear": 4}, "parameter ~gear must be an integer of at most 3, not 4"),
        ({"least": "much"}, "parameter ~least must be a number, not 'much'"),
        ({"laest": 0.3}, "did you mean ~least?"),
        ({"rate": 5.0}, "use --execute"),
    ],
)
def test_a_wrong_parameter_is_refused(cart: Supervisor, given: dict[str, Any], told: str) -> None:
    with pytest.raises(InvalidLine, match=told.replace("?", r"\?")):
        machine_maker(cart, execute=False)(given)


@pytest.mark.parametrize(
    ("told", "departs"),
    [
        ({"least": 0.7, "gear": 3}, "none"),
        ({"least": 0.7, "gear": 2}, "the model sends"),
        ({"least": 0.9, "gear": 3}, "requirement drive needs"),
        ({}, "the model sends"),
    ],
)
def test_a_log_tells_the_parameters_of_its_run(
    cart: Supervisor, tmp_path: Path, told: dict[str, Any], departs: str
) -> None:
    player = session(cart, execute=True, parameters={"least": 0.7, "gear": 3})
    happenings = [*player.latest, *player.do("power 0.8").happenings]
    events = [
        event_document(Entry(n, h.time, h.kind, h.name, h.index, h.value, h.outcome, h.detail))
        for n, h in enumerate(happenings, 1)
    ]
    assert [e["event"]["name"] for e in events] == ["power", "drive"]
    events[0]["parameters"] = told
    log = tmp_path / "cart.jsonl"
    log.write_text("\n".join(map(json.dumps, events)))
    found = replay(cart, str(log))
    reasons = [departure.reason for departure in found.departures] or ["none"]
    assert reasons[0].startswith(departs)


def test_a_parameter_that_is_typed_keeps_its_signs() -> None:
    robot = """robot R {
        parameter badge: string = ""
        component Radio { incoming message say with type: string }
        provide say with badge
    }"""
    player = session(supervisor_of(robot))
    for line, badge in (
        ('set badge "a=b  c"', "a=b  c"),
        ('set badge="x"', "x"),
        ("set badge = plain", "plain"),
    ):
        player.do(line)
        (say,) = player.machine.commands()
        assert say.data == {"data": badge}
