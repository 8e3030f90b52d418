"""``simulate --execute`` of a supervisor: what it makes of a controller's commands that are typed."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from ros_support import EXAMPLES, Completed
from runtime.schemas import validate
from simulate.players import play, session

from robosc.runtime.core.values import jsonable
from robosc.simulate.machines.machine import Happening, Machine, label
from robosc.simulate.script.render import Style, session_text
from robosc.simulate.start import machine_maker
from robosc.simulate.values.event_data import complete

Robosc = Callable[..., Completed]

LIMITER = EXAMPLES / "gallery" / "limiter" / "limiter.rscd"
CRANE = Path(__file__).parents[1] / "ros1" / "crane.rscd"


def machine_of(model: Path, **given: Any) -> Machine:
    supervisor = supervisor_of(model.read_text(), str(model), supervises=True)
    return machine_maker(supervisor, execute=True)(given)


def fire(machine: Machine, name: str, raw: Any = None) -> list[Happening]:
    event = next(e for e in machine.typeable if label(e) == name)
    return machine.fire(event, complete(machine.plant.robot, event, raw, name))


def told(happenings: list[Happening]) -> list[tuple[str, str, Any, str]]:
    return [(f"{h.name}.{h.kind}", h.outcome, h.value, h.detail or "") for h in happenings]


def test_a_limiter_corrects_and_blocks() -> None:
    machine = machine_of(LIMITER)
    fast = {"linear.x": 1.0, "angular.z": 0.6}
    (blocked,) = fire(machine, "move.request", fast)
    assert (blocked.outcome, blocked.is_command) == ("blocked", True)
    assert "requirement move needs scan.fresh" in (blocked.detail or "")
    scan = {"ranges[0]": 3.0, "range_min": 0.1, "range_max": 10.0}
    fire(machine, "scan.response", scan)
    (corrected,) = told(fire(machine, "move.request", fast))
    assert corrected[1:3] == ("applied", {"linear.x": 0.5, "angular.z": 0.3})
    assert "linear.x 1.0 becomes 0.5, angular.z 0.6 becomes 0.3" in corrected[3]
    assert told(fire(machine, "move.request", {"linear.x": 0.3, "angular.z": 0.1})) == [
        ("move.request", "applied", {"linear.x": 0.3, "angular.z": 0.1}, "")
    ]
    (backwards,) = fire(machine, "move.request", {"linear.x": -0.3})
    assert backwards.outcome == "blocked"
    # What is in effect is ended when it becomes forbidden.
    silent = told(machine.wait(0.4))
    assert [what for what, *_ in silent] == ["scan.timeout", "halt.request"]
    assert fire(machine, "move.request", fast)[0].outcome == "blocked"


def test_goals_calls_and_messages_of_one_field() -> None:
    machine = machine_of(CRANE)
    fire(machine, "limit.response", 2.0)
    (hoist,) = told(fire(machine, "hoist.request", 5.0))
    assert hoist[1:3] == ("applied", 2.0) and "5.0 becomes 2.0" in hoist[3]
    (reach,) = told(fire(machine, "reach.request", {"height": 7}))
    assert reach[1:3] == ("applied", {"height": 2})
    assert machine.state.phases["Hoist.reach"] == "busy"
    (busy,) = fire(machine, "reach.request", {"height": 1})
    assert busy.outcome == "blocked"
    fire(machine, "reach.response")
    assert machine.state.phases["Hoist.reach"] == "idle"
    fire(machine, "limit.response", -1.0)
    (level,) = told(fire(machine, "set_level.request", {"level": -3}))
    assert level[1:3] == ("applied", {"level": 1})
    (refused,) = told(fire(machine, "hoist.request", 5.0))
    assert refused[1] == "blocked" and "becomes -1.0" in refused[3]
    machine.undo(1)
    assert machine.state.phases["Hoist.set_level"] == "busy"


def test_the_one_field_of_a_message_of_ros_is_corrected_by_its_name() -> None:
    machine = machine_of(CRANE)
    (gear,) = told(fire(machine, "gear.request", {"data": 1}))
    assert gear[1:3] == ("applied", {"data": 100})
    assert gear[3].startswith("corrected: data 1 becomes 100")
    assert told(fire(machine, "gear.request", {"data": 0}))[0][1:] == ("applied", {"data": 0}, "")


WHOLES = """
robot K {
    datatype object Speeds { linear: Axes angular: Axes }
    datatype object Axes { x: double z: double }
    interface speeds use Twist from some_msgs
    interface axes use Vector3 from some_msgs
    component Base {
        outgoing message wish with timeout: 1 s, type: Axes links axes
        incoming message drive with type: Speeds links speeds
        incoming message halt with type: Axes links axes
        behaviour {
            variable wished: Axes
            variable all_: Speeds
            variable linear: Axes
            variable halted: Axes
            on response from wish do wished := value
            on request to drive do all_ := value, linear := value.linear
            on request to halt do halted := value
            initial marked state on_ {}
        }
    }
    requirement drive needs wish.fresh and value.linear.x <= 0.5
    provide drive with { linear: Base.wished } if value.linear.x < 0.0
    provide drive with { linear: { x: min(value.linear.x, 0.5) } }
    provide halt with { x: 2.0 }
    stop with halt
}
"""


def test_a_correction_sets_wholes_and_what_lies_in_them() -> None:
    player = session(supervisor_of(WHOLES, supervises=True), execute=True)
    play(player, "set stop_command halt", "wish x: 0.25, z: 0.125")

    def held(name: str) -> Any:
        return jsonable(player.machine.state.variables[f"Base.{name}"])

    play(player, "drive linear.x: 3, linear.z: 1, angular.x: 4", "expect sent drive")
    assert held("linear") == {"x": 0.5, "z": 1.0}
    assert held("all_") == {"linear": {"x": 0.5, "z": 1.0}, "angular": {"x": 4.0, "z": 0.0}}
    (done,) = play(player, "drive linear.x: -3, linear.z: 1").happenings
    assert held("linear") == held("all_")["linear"] == {"x": 0.25, "z": 0.125}
    changes = done.judged["corrected"]["fields"] if done.judged else {}
    assert changes == {
        "linear.x": {"sent": -3.0, "made": 0.25},
        "linear.z": {"sent": 1.0, "made": 0.125},
    }
    play(player, "wait 2", "expect sent halt")
    assert held("halted") == {"x": 2.0, "z": 0.0}


LOCK = """
robot K {
    component Door {
        incoming message lock with type: boolean
        behaviour {
            initial marked state open { on request to lock if value goto locked }
            marked state locked { on request to lock if !value goto open }
        }
    }
    stop with nothing
}
"""


def test_the_menu_has_each_case_of_what_may_be_asked() -> None:
    player = session(supervisor_of(LOCK, supervises=True), execute=True)
    assert [choice.text for choice in player.menu()] == [
        "lock.request(false)",
        "lock.request(true)",
    ]
    shown = session_text(player, Style(False))
    assert "the guarded controller may ask for" in shown


def test_at_random_it_goes_on_and_stops_nowhere() -> None:
    for model in (LIMITER, CRANE):
        machine, rng = machine_of(model), random.Random(3)
        outcomes = set()
        for _ in range(200):
            step = machine.draw(rng)
            assert step is not None
            done = machine.wait(step) if isinstance(step, float) else machine.fire(*step)
            outcomes |= {h.outcome for h in done if h.is_command}
        assert machine.stopped is None and outcomes == {"applied", "blocked"}


@pytest.mark.parametrize("mode", [["--execute"], ["--execute", "--json"]])
def test_scripts(robosc: Robosc, tmp_path: Path, mode: list[str]) -> None:
    script = tmp_path / "limit.txt"
    script.write_text(
        "limit.response 2.0\nhoist.request 5.0\nhoist.request -5.0\nexpect Limit.most = 2.0\n"
    )
    done = robosc("simulate", str(CRANE), "--mode", "supervisor", *mode, "--script", str(script))
    assert done.returncode == 0, done.stdout + done.stderr
    if "--json" in mode:
        for line in done.stdout.splitlines():
            validate(json.loads(line), "simulate")
        last = json.loads(done.stdout.splitlines()[-2])
        assert last["commands"][0]["data"] is None


FIELDS = """
robot K {
    datatype object Speeds { linear: Axes angular: Axes }
    datatype object Axes { x: double z: double }
    interface speeds use Twist from some_msgs
    component Base { incoming message drive with type: Speeds links speeds }
    requirement drive needs value.linear.x <= 0.5
    stop with drive
}
"""


@pytest.mark.parametrize("execute", [False, True])
def test_fields_that_nothing_reads_are_passed_on(execute: bool) -> None:
    player = session(supervisor_of(FIELDS, supervises=True), execute=execute)
    play(player, "expect enabled drive", "drive linear.x: 0.3, angular.z: 0.2")
    play(player, "expect sent drive", "expect data drive linear.x: 0.3, angular.z: 0.2")


def test_a_command_replaces_another_one_of_its_topic() -> None:
    """What is in effect is so on its topic: nothing has to be stopped that another one replaced."""
    text = """robot K {
        component Guard {
            outgoing message clear with type: boolean
            behaviour {
                variable up: boolean
                on response from clear do up := value
                initial marked state watching {}
            }
        }
        component Base {
            incoming message fast with identifier: "/speed", type: double
            incoming message slow with identifier: "/speed", type: double
            incoming message halt with identifier: "/speed", type: double
        }
        provide fast with 1.0
        provide slow with 0.1
        provide halt with 0.0
        requirement fast needs Guard.up
        stop with halt
    }"""
    player = session(supervisor_of(text, supervises=True), execute=True)
    play(player, "clear true", "fast", "clear false", "expect sent halt")
    play(player, "clear true", "fast", "slow", "clear false", "expect sent nothing")


def test_a_correction_beyond_its_field_is_blocked() -> None:
    """As in a node, where the message cannot be packed; a typed array may be left out."""
    model = """
        robot Gears {
            component Base {
                incoming message gear with type: std_msgs/UInt8
                incoming message pose with type: geometry_msgs/PoseWithCovariance
            }
            provide gear with { data: value.data * 20 }
            provide pose with { covariance: [min(v, 1.0) for v in value.covariance] }
            stop with nothing
        }
    """
    machine = machine_maker(supervisor_of(model, supervises=True), execute=True)({})
    (passed,) = told(fire(machine, "gear.request", {"data": 12}))
    assert passed[1:3] == ("applied", {"data": 240})
    (blocked,) = told(fire(machine, "gear.request", {"data": 13}))
    assert (blocked[1], blocked[3]) == ("blocked", "260 does not fit uint8")
    (whole,) = fire(machine, "pose.request", {})
    assert whole.outcome == "applied"


PREFERRING = """robot Cart {
    component Motor {
        incoming message halt with type: none
        incoming message drive with type: none
    }
    prefer halt over drive
    stop with halt
}
"""


@pytest.mark.parametrize("execute", [True, False])
def test_what_another_controller_sends_waits_for_nothing(execute: bool) -> None:
    """It chooses among its commands, whatever the model prefers."""
    supervisor = supervisor_of(PREFERRING, supervises=True)
    machine = machine_maker(supervisor, execute=execute)({})
    assert [c.waits_for for c in machine.commands() if c.enabled] == [(), ()]
    assert told(fire(machine, "drive.request"))[0][:2] == ("drive.request", "applied")
