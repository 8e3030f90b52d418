"""Playing a robot whose decisions compare numbers: classes in single events, exact data when run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, sent, session
from simulate.test_replay import lines_of, run_of, write

from robosc.runtime.core.values import jsonable
from robosc.simulate.faults import InvalidLine
from robosc.simulate.replay import replay
from robosc.simulate.script.render import Style, session_text
from robosc.supervisor import Supervisor

MODEL = """
robot R {
    component Battery {
        outgoing message battery with type: double
        behaviour {
            variable charge: double = 1.0
            variable last: double
            initial marked state ok {
                on response from battery do charge := value, last := charge
            }
        }
    }
    component Base {
        incoming message drive with type: double
        incoming message step with type: none
        behaviour {
            variable n: integer
            initial marked state s { on request to step do n := n + 1 }
        }
    }
    requirement drive needs Battery.charge > 0.2 and Battery.charge < Battery.last
    requirement step needs Base.n < 2
    provide drive with Battery.charge
}
"""


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(MODEL)


def test_classes_and_tests_are_the_choices_of_single_events(supervisor: Supervisor) -> None:
    player = session(supervisor)
    assert [choice.text for choice in player.machine.choices()] == [
        "battery.response(!(value > 0.2), value < Battery.charge)",
        "battery.response(!(value > 0.2), !(value < Battery.charge))",
        "battery.response(value > 0.2, value < Battery.charge)",
        "battery.response(value > 0.2, !(value < Battery.charge))",
        "step.request(Base.n + 1 < 2)",
        "step.request(Base.n + 1 >= 2)",
    ]


def test_what_is_typed_decides_about_tests(supervisor: Supervisor) -> None:
    player = session(supervisor)
    play(player, "battery 0.5")
    drive = next(c for c in player.machine.commands() if c.event.name == "drive")
    assert drive.enabled
    assert list((drive.data or {}).values()) == [0.5]
    play(player, "battery 0.6")
    assert not next(c for c in player.machine.commands() if c.event.name == "drive").enabled
    assert player.machine.state.variables["Battery.charge"] == 0.6


def test_a_chosen_outcome_decides_whatever_the_data_are(supervisor: Supervisor) -> None:
    player = session(supervisor)
    play(player, "6")
    step = next(c for c in player.machine.commands() if c.event.name == "step")
    assert [reason.kind for reason in step.reasons] == ["requirement"]


def test_running_keeps_numbers_exactly(supervisor: Supervisor) -> None:
    player = session(supervisor, execute=True)
    assert sent(play(player, "battery 0.25")) == ["drive"]
    assert sent(play(player, "battery 0.2500000001")) == []
    assert sent(play(player, "battery 0.2")) == []
    assert player.machine.state.variables == {
        "Battery.charge": 0.2,
        "Battery.last": 0.2500000001,
        "Base.n": 1,
    }


def test_goto_leads_to_what_the_model_asks_of_data(supervisor: Supervisor) -> None:
    player = session(supervisor)
    done = play(player, "goto Battery.charge > 0.2 and Battery.charge < Battery.last")
    assert len(done.happenings) == 1
    play(player, "expect enabled drive")
    play(player, "goto !(Battery.charge > 0.2) and Base.n >= 2", "expect disabled step")
    assert play(player, "goto !(0.2 < Battery.charge)").text == "it holds already"


@pytest.mark.parametrize("condition", ["Battery.charge > 0.5", "Base.n < Battery.charge"])
def test_goto_knows_nothing_else_of_data(supervisor: Supervisor, condition: str) -> None:
    player = session(supervisor)
    with pytest.raises(
        InvalidLine, match="a path can be found only to what decides about commands"
    ):
        player.do(f"goto {condition}")


OBJECTS = """
robot Courier {
    interface links use Place from nowhere_msgs
    datatype object Place { x: double name: string }
    component Operator {
        outgoing message place with type: Place links links
        behaviour {
            variable goal: Place
            initial marked state on { on response from place do goal := value }
        }
    }
    component Base { incoming message drive with type: Place links links }
    requirement drive needs Operator.goal.x > 0.5
    provide drive with Operator.goal
}
"""


@pytest.mark.parametrize("execute", [False, True])
def test_objects_are_given_by_their_parts(execute: bool) -> None:
    player = session(supervisor_of(OBJECTS), execute=execute)
    play(player, "expect disabled drive", 'place x: 0.75, name: "shelf"', "expect enabled drive")
    play(player, "expect Operator.goal.x = 0.75", 'expect Operator.goal.name = "shelf"')
    command = next(c for c in player.machine.commands() if c.event.name == "drive")
    assert jsonable(command.data) == {"x": 0.75, "name": "shelf"}
    play(player, "place x: 0.25", "expect disabled drive", 'expect Operator.goal.name = ""')


def test_a_saved_script_with_objects_can_be_played_again() -> None:
    first = session(supervisor_of(OBJECTS))
    play(first, 'place x: 0.75, name: "shelf"', "drive")
    second = session(supervisor_of(OBJECTS))
    play(second, *(line for line in first.script().splitlines() if not line.startswith("#")))
    assert second.machine.state == first.machine.state


def test_goto_an_object() -> None:
    player = session(supervisor_of(OBJECTS))
    assert len(play(player, "goto Operator.goal.x > 0.5").happenings) == 1
    play(player, "expect enabled drive")


def test_a_log_with_objects_is_followed(tmp_path: Path) -> None:
    supervisor = supervisor_of(OBJECTS)
    player = session(supervisor, execute=True)
    log = lines_of(run_of(player, 'place x: 0.75, name: "shelf"', "wait 0.2", "place x: 0.25"))
    found = replay(supervisor, write(tmp_path / "events.log", log))
    assert (found.departures, found.missing) == ((), ())
    assert found.events > 4


def test_long_data_are_cut_short_in_the_state() -> None:
    player = session(supervisor_of(OBJECTS))
    assert "goal = nothing" in session_text(player, Style())
    play(player, f'place x: 0.75, name: "{"x" * 90}"')
    (line,) = (t for t in session_text(player, Style()).splitlines() if "goal" in t)
    assert line.endswith("xxx…") and len(line) < 100


FREE = """
robot R {
    component Gauge {
        outgoing message level with type: double
        incoming message fill with type: none
        behaviour {
            variable present: double
            variable before: double
            variable label: string
            initial marked state watching {
                on response from level if !isnan(value)
                    do before := present, present := value, label := label + "x"
            }
        }
    }
    requirement fill needs Gauge.present < Gauge.before or Gauge.label = "b"
}
"""


FREE_PART = """
robot R {
    interface link use Thing from some_msgs
    datatype object Goal { x: double }
    component Op {
        outgoing message target with type: Goal links link
        incoming message mark with type: none
        incoming message go with type: none
        behaviour {
            variable goal: Goal
            variable far: boolean
            initial marked state s {
                on response from target do goal := value
                on request to mark do far := goal.x * 2 > 0.5
            }
        }
    }
    requirement go needs Op.far
}
"""
KNOWN_PART = FREE_PART.replace("goal.x * 2", "goal.x")


ITEMS = """
robot R {
    interface link use Thing from some_msgs
    datatype object Scan { items: array(double) }
    component Op {
        outgoing message scan with type: Scan links link
        incoming message go with type: none
        behaviour {
            variable seen: array(double)
            initial marked state s {
                on response from scan do seen := value.items
            }
        }
    }
    requirement go needs Op.seen[1] > 0.5
}
"""


@pytest.mark.parametrize("seed", range(10))
def test_what_is_drawn_is_of_the_class_that_was_drawn(seed: int) -> None:
    """Of what is stored as a whole, too, of which the plant knows parts only."""
    for model, holds in (
        (KNOWN_PART, lambda values: values["Op.goal"].x > 0.5),
        (ITEMS, lambda values: len(values["Op.seen"]) > 1 and values["Op.seen"][1] > 0.5),
    ):
        player = session(supervisor_of(model))
        play(player, f"random 5 {seed}")
        state = player.machine.state
        if all(value is not None for value in state.variables.values()):
            (known,) = (t for name, t in state.tests.items() if name[0] != "!" and "> 0.5" in name)
            assert known == holds(state.variables), model


@pytest.mark.parametrize("model", [MODEL, FREE, FREE_PART, KNOWN_PART])
def test_saved_runs_with_chosen_tests_can_be_played(model: str, tmp_path: Path) -> None:
    player = session(supervisor_of(model))
    play(player, "1 0.5" if model is FREE else "2", "random 20 3")
    play(player, f"save {tmp_path / 'run.sim'}")
    again = session(supervisor_of(model))
    play(again, f"play {tmp_path / 'run.sim'}")  # its expectations hold
    assert again.machine.state == player.machine.state
    assert again.script() == player.script()


def test_what_is_drawn_lies_in_the_class_that_is_drawn() -> None:
    player = session(supervisor_of(KNOWN_PART))
    for seed in range(10):
        play(player, f"random 1 {seed}")
        state = player.machine.state
        goal = state.variables["Op.goal"]
        assert state.tests["Op.goal.x > 0.5"] == (goal is not None and goal.x > 0.5)


def test_a_test_is_chosen_by_its_name() -> None:
    player = session(supervisor_of(FREE))
    play(player, 'level 2.5, "compare(value, Gauge.present)": -1, "isnan(value)": false')
    play(player, "expect Gauge.present = 2.5", "expect enabled fill")
    with pytest.raises(InvalidLine, match='does not ask for "x < 2"; its tests are "compare'):
        play(player, 'level 2.5, "x < 2": true')
    with pytest.raises(InvalidLine, match="is a boolean, not 3"):
        play(player, 'level 2.5, "isnan(value)": 3')


def test_replay_names_the_classes_of_exact_values(supervisor: Supervisor, tmp_path: Path) -> None:
    def reason(*events: dict[str, object]) -> str:
        lines = [
            json.dumps({"version": 1, "number": n, "event": event, "outcome": "applied"})
            for n, event in enumerate(events, 1)
        ]
        (tmp_path / "run.log").write_text("\n".join(lines), encoding="utf-8")
        (departure,) = replay(supervisor, str(tmp_path / "run.log")).departures
        return f"{departure.event}: {departure.reason}"

    heard: dict[str, object] = {"kind": "response", "name": "battery", "value": 0.15}
    drive: dict[str, object] = {"kind": "request", "name": "drive", "value": {"data": 0.15}}
    found = reason(heard, drive)
    assert found.startswith("drive.request: requirement drive needs Battery.charge > 0.2")
    assert found.endswith("; Battery.charge = 0.15: !(Battery.charge > 0.2)")
    assert reason({**heard, "value": "none"}) == (
        'battery.response: its value cannot be "none": it carries a double'
    )


def test_replay_names_the_class_of_what_cannot_have_come(tmp_path: Path) -> None:
    text = """
    robot R {
        interface link use Measure from some_msgs
        datatype object Depth { depth: double }
        component Probe {
            service measure with request: none, response: Depth links link
            behaviour {
                initial marked state s { on response from measure if value.depth > 0.5 goto t }
                marked state t {}
            }
        }
    }"""
    event = {"kind": "response", "name": "measure", "value": {"depth": 0.15}}
    line = {"version": 1, "number": 1, "event": event, "outcome": "applied"}
    (tmp_path / "run.log").write_text(json.dumps(line), encoding="utf-8")
    (departure,) = replay(supervisor_of(text), str(tmp_path / "run.log")).departures
    assert departure.event == "measure.response(depth = 0.15: !(depth > 0.5))"
