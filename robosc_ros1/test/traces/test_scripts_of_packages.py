"""The scripts of a package's test: the controller passes them, and faulty controllers do not."""

from __future__ import annotations

import io
import re
import struct
from pathlib import Path

import pytest
from emit.generated_code import controller_source
from emit.mutants import mutants
from emit.scripted_controllers import faults_of, scripts_of, tells_apart
from ros_support import EXAMPLES, run_robosc

from robosc import pipeline
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.plant.build import lower
from robosc.simulate.machines.execute import Execution
from robosc.simulate.machines.machine import Happening
from robosc.simulate.script.run import follow_script
from robosc.simulate.script.session import Session
from robosc.simulate.start import machine_maker
from robosc.simulate.values.message_fields import KnownFields
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize
from robosc.traces import unreachable
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import Steps
from robosc.traces.scripts import choose, script

PLAYED = ("courier", "door", "drone", "kobuki", "navigation", "order", "two_robots")


def model_of(name: str) -> Path:
    return EXAMPLES / name / f"{Path(name).name}.rscd"


def supervisor_of(name: str) -> Supervisor:
    return pipeline.synthesize(pipeline.load(model_of(name)).robot)


def demand_passes(supervisor: Supervisor, text: str) -> None:
    """Raise an error if the generated controller does not do what a script expects."""
    out, messages = io.StringIO(), io.StringIO()
    session = Session(machine_maker(supervisor, execute=True))
    done = follow_script(session, text.splitlines(), "run", out, messages, False)
    assert (done.exit_code, messages.getvalue()) == (0, "")


@pytest.mark.parametrize("name", PLAYED)
def test_the_generated_controller_passes(name: str) -> None:
    """Expectations are those of the plant, so this compares the two."""
    supervisor = supervisor_of(name)
    for text in scripts_of(supervisor):
        demand_passes(supervisor, text)


LONG = """
robot Long {
    component Base {
        outgoing message start with timeout: 1 s, type: none
        incoming message go with type: none
        incoming message blink with rate: 20 Hz, type: none
        behaviour {
            initial marked state idle { on response from start goto moving }
            state moving {
                on request to go
                after 90 s goto resting
                after 10 min goto idle
            }
            state resting {
                on response from start goto blinking
                after 3 min goto idle
            }
            state blinking { on request to blink after 2 min goto idle }
        }
    }
    stop with nothing
}
"""


def test_a_wait_brings_no_more_than_a_node_does_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The player of a package turns the clock once for each wait, however long that is."""

    def wait(self: Execution, seconds: float) -> list[Happening]:
        self._clock.time += seconds + 1e-9
        self._engine.cycle()
        return self._happened()

    robot, _ = load(Source("long.rscd", LONG))
    assert robot is not None
    supervisor = synthesize(lower(robot))
    scripts = scripts_of(supervisor)
    assert any("expect Base.resting" in text and "wait 180" in text for text in scripts)
    monkeypatch.setattr(Execution, "wait", wait)
    for text in scripts:
        demand_passes(supervisor, text)


NARROW = """
robot Narrow {
    component Tank {
        outgoing message level with timeout: 5 s, type: double
        incoming message fill with type: double
        incoming message note with rate: once, type: string
        behaviour {
            variable left: double = 1.0
            initial marked state on_ { on response from level do left := value }
        }
    }
    requirement fill needs level.fresh and Tank.left > 0.3
    requirement note needs level.fresh and Tank.left < 0.2
    provide fill with sqrt(Tank.left - 0.3)
    provide note with "left: " + string(Tank.left)
    stop with nothing
}
"""


def test_data_are_expected_as_they_come_of_fields_of_32_bits() -> None:
    """Those of a number as it is typed may be others, by far beside a root or in a text."""

    def arriving(number: re.Match[str]) -> str:
        return str(*struct.unpack("<f", struct.pack("<f", float(number[0]))))

    robot, _ = load(Source("narrow.rscd", NARROW))
    assert robot is not None
    supervisor = synthesize(lower(robot))
    texts = [
        script(supervisor, run, "run")
        for run in choose(supervisor, KnownFields(robot, MessageDefinitions())).runs
    ]
    assert any("expect sent note.request" in text for text in texts)
    assert any("expect sent fill.request" in text for text in texts)
    for text in texts:
        arrived = re.sub(r"(?<=^level.response )[-.0-9e]+", arriving, text, flags=re.MULTILINE)
        demand_passes(supervisor, arrived)


@pytest.mark.parametrize(("name", "mode"), [("navigation", "controller"), ("door", "monitor")])
def test_every_process_chooses_the_same_runs(name: str, mode: str, tmp_path: Path) -> None:
    """Also where sets have another order."""
    chosen = []
    for seed in ("1", "2"):
        words = ("generate", str(model_of(name)), "--target", "ros1", "--mode", mode)
        folder = tmp_path / seed
        done = run_robosc((*words, "--output", str(folder)), tmp_path, {"PYTHONHASHSEED": seed})
        assert done.returncode == 0, done.stderr
        files = sorted(folder.glob("*/test/scripts/*.sim"))
        chosen.append([file.read_text(encoding="utf-8") for file in files])
    assert chosen[0]
    assert chosen[0] == chosen[1]


@pytest.mark.parametrize("name", PLAYED)
def test_what_is_proved_unreachable_is_not_shown(name: str) -> None:
    """The plant, under its supervisor, and the runs are two ways to the same."""
    for guards in (False, True):
        robot = pipeline.load(model_of(name), pipeline.Options(supervises=guards)).robot
        traces = choose(pipeline.synthesize(robot))
        excluded = unreachable.Unreachable(traces.coverage)
        assert not traces.shown & excluded.whatever_numbers_are()
        assert not traces.shown & excluded.with_numbers(traces.cases)


def test_the_same_is_proved_of_many_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are looked at one by one, or by what they have in common."""
    pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")
    robots = [
        pipeline.load(model_of(name), pipeline.Options(supervises=guards)).robot
        for name in PLAYED
        for guards in (False, True)
    ]
    coverages = [Coverage(Steps(pipeline.synthesize(robot))) for robot in robots]

    def proved() -> list[frozenset[Case]]:
        return [unreachable.Unreachable(c).whatever_numbers_are() for c in coverages]

    one_by_one = proved()
    monkeypatch.setattr(unreachable, "STATES", 0)
    assert proved() == one_by_one
    assert any(one_by_one)


ARM = """robot Cell {
    component Arm {
        action pick with request: none, response: none, feedback: none links empty
        behaviour {
            initial marked state ready performs pick then goto ready {
                retry 2 times else goto tired
            }
            marked state tired {}
        }
    }
    LAMPS
    interface empty use Work from some_package
}"""
LAMP = """
    component Lamp0 {
        service switch0 with request: none, response: none links empty
        outgoing message seen0 with type: boolean
        behaviour {
            variable dark: boolean
            on response from seen0 do dark := value
            initial marked state off { on request to switch0 goto turning }
            state turning {
                on response from switch0 goto lit
                on error from switch0 goto off
            }
            state lit { on request to switch0 goto ending }
            state ending {
                on response from switch0 goto off
                on error from switch0 goto lit
            }
        }
    }
    requirement switch0 needs (Lamp0.dark and Lamp0.off) or (!Lamp0.dark and Lamp0.lit)
"""


def test_what_a_component_does_late_is_shown_beside_many_others() -> None:
    """The third error in a row is one of the few things that are new among many combinations."""
    lamps = "".join(LAMP.replace("0", str(number)) for number in range(4))
    robot, found = load(Source("model.rscd", ARM.replace("LAMPS", lamps)))
    assert robot is not None, found
    traces = choose(synthesize(lower(robot)))
    assert traces.cases.keys() == traces.shown | traces.proved
    assert [text for case, text in traces.cases.items() if case in traces.shown and "tired" in text]


@pytest.mark.parametrize("guards", [False, True])
def test_every_command_to_one_of_many_robots_is_shown(guards: bool) -> None:
    """A zone is free once the robot before has said the number of the next one, which is data."""
    robot = pipeline.load(model_of("zones"), pipeline.Options(supervises=guards)).robot
    traces = choose(pipeline.synthesize(robot))
    commands = {case for case in traces.cases if case[0] == "sent"}
    assert len(commands) == 8
    assert commands <= traces.shown


def test_no_run_waits_for_deadlines_that_it_is_not_to_meet() -> None:
    """Nothing brings the end of the delay nearer: a goal goes on, and a service is not answered."""
    text = """robot Waits {
        component A {
            outgoing action task with request: none, response: none, feedback: none links empty
            action go with request: none, response: boolean, feedback: none links empty
            behaviour {
                initial marked state p performs go then goto r.v
                marked state q { initial state u performs task.error then goto u }
                marked state r { after 3 s goto r.u initial state u {} state v {} }
            }
        }
        component B {
            service ask with request: none, response: none links empty
            behaviour { initial marked state p performs ask then goto p }
        }
        interface empty use Work from some_package
    }"""
    passes(text)


def test_what_the_phase_asks_is_no_other_reason() -> None:
    """While a goal runs, go is due nowhere; the guard need not ask for that, and no node tells it."""
    passes(
        """robot Two {
        component A {
            action go with request: none, response: none, feedback: none links empty
            behaviour { initial marked state p performs go then goto p }
        }
        component B {
            outgoing message near with type: none
            behaviour {
                initial marked state rest { on response from near goto r }
                state r performs go then goto rest {
                    on response from near goto rest
                    retry 1 times else goto bad
                }
                marked state bad {}
            }
        }
        requirement never B.bad
        interface empty use Work from some_package
    }"""
    )


def passes(text: str) -> None:
    """The controller of a model passes the scripts of its package."""
    robot, _ = load(Source("model.rscd", text))
    assert robot is not None
    supervisor = synthesize(lower(robot))
    for run in scripts_of(supervisor):
        out, messages = io.StringIO(), io.StringIO()
        session = Session(machine_maker(supervisor, execute=True))
        assert follow_script(session, run.splitlines(), "run", out, messages, False).exit_code == 0


def test_why_something_is_not_shown() -> None:
    """The tries are counted from 0 to 2, so none is above; the robot tells its volts in tenths, so
    that none lie just below a number."""
    supervisor = supervisor_of("navigation")
    traces = choose(supervisor)
    why = {text: traces.why([case]) for case, text in traces.cases.items()}
    above = "navigate.error in Operator (line 26, to waiting): Navigator.tries < 2, just above the "
    assert why[above + "number, alone decides"] == "proved unreachable"
    traces = choose(supervisor_of("kobuki"))
    below = "Base.volts > 13.2, just below the number, alone decides"
    cases = [case for case, text in traces.cases.items() if text.endswith(below)]
    assert cases
    assert re.fullmatch(r"not found in [0-9,]+ inputs", traces.why(cases))


def test_what_numbers_exclude_is_proved() -> None:
    """Where the requirement lets the door turn, one of two numbers is reached already: so what
    provides its data is not asked for those between them."""
    traces = choose(supervisor_of("door"))
    rest = {text for case, text in traces.cases.items() if case not in traces.shown}
    assert rest == {text for case, text in traces.cases.items() if case in traces.proved}
    provide, alone = "turn.request, provide (door.rscd:%d): Sensor.last %s, ", " alone decides"
    assert rest == {
        "turn.request: Motor blocks it",
        provide % (29, "<= 0.01") + "just above the number," + alone,
        provide % (30, ">= 0.99") + "which is false," + alone,
        provide % (30, ">= 0.99") + "just below the number," + alone,
    }


@pytest.mark.parametrize("guards", [False, True])
def test_a_requirement_that_a_guard_says_again_is_shown(guards: bool) -> None:
    """Where synthesis restricts a command further, its guard forbids what a requirement does."""
    robot = pipeline.load(model_of("two_robots"), pipeline.Options(supervises=guards)).robot
    traces = choose(pipeline.synthesize(robot))
    shown = {traces.cases[case] for case in traces.shown}
    alone = "(two_robots.rscd:%d): Robot[1].battery.fresh, which is false, alone decides"
    for line in (76, 10):
        found = {text for text in shown if text.endswith(alone % line)}
        assert any(text.startswith("Robot[1].cross.request") for text in found)


def test_what_is_refused_where_all_is_heard_is_shown() -> None:
    """Of two arrays, both are empty; that alone decides only while another message is fresh."""
    traces = choose(supervisor_of("order"))
    shown = {traces.cases[case] for case in traces.shown}
    way = "order.request in Way (line 32, to driving.there): "
    assert way + "defined(value.x[0]), which is false, alone decides" in shown


@pytest.mark.parametrize("guards", [False, True])
@pytest.mark.parametrize("name", ["docking", "door", "patrol"])
def test_all_is_shown_or_proved(name: str, guards: bool) -> None:
    """What a supervisor's controller sends is decided by what came before it; one part of a vector
    alone brings exactly a distance; of two guards that exclude each other the second one is not
    asked where the first one holds; a cancel that is not allowed is told so."""
    robot = pipeline.load(model_of(name), pipeline.Options(supervises=guards)).robot
    traces = choose(pipeline.synthesize(robot))
    assert traces.cases.keys() == traces.shown | traces.proved


SHY = """robot Shy {
    component Door {
        service knock with identifier: "/knock", type: std_srvs/Empty
        outgoing message morning with identifier: "/morning", type: std_msgs/Empty

        behaviour {
            variable times: integer(0..2)

            initial marked state quiet {
                on request to knock if times < 2 do times := times + 1 goto waits
                on response from morning do times := 0
            }
            state waits {
                on response, error from knock goto quiet
            }
        }
    }
}
"""


def test_the_guard_of_a_request_is_shown_where_it_alone_blocks() -> None:
    robot, _ = load(Source("shy.rscd", SHY))
    assert robot is not None
    traces = choose(synthesize(lower(robot)))
    shown = {traces.cases[case] for case in traces.shown}
    guard = "knock.request in Door (line 10, to waits): Door.times < 2, "
    for outcome in ("which is true", "which is false", "at the number", "just below the number"):
        assert f"{guard}{outcome}, alone decides" in shown


GALLERY = "gallery/go_to_pose"
FAULTS = {
    "a location left out": (
        "navigation", False,
        'elif self.operator == "served" and not', "elif not",
    ),
    "where a component is not": (
        GALLERY, False, 'elif self.button == "unheard" and not value:', "elif not value:",
    ),
    "part of a condition on elements": (
        "courier", False, 'r_ > value["range_min"] and r_ < value', "r_ < value",
    ),
    "the end of a drive": (GALLERY, False, '= "driving waiting"', '= "driving due"'),
    "what an answer must be": ("navigation", False, '["distance"] < 1.0', '["distance"] < 1.1'),
    "what is refused": ("order", False, "            and self.stop_fresh\n", ""),
    "an object": ("courier", True, 'self.base_goal = value[""]', "pass"),
    "what is told beside other reasons": (
        "drone", True,
        "return self.requirement_1() and self.requirement_2()", "return self.requirement_2()",
    ),
    "a delay that is not ended": (
        "drone", False, "self.position_entries += 1\n        self.state_fresh", "self.state_fresh",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_each_kind_are_found(fault: str) -> None:
    name, guards, right, wrong = FAULTS[fault]
    robot = pipeline.load(model_of(name), pipeline.Options(supervises=guards)).robot
    assert faults_of(pipeline.synthesize(robot), right, wrong)


def test_planted_faults_are_found() -> None:
    supervisor = supervisor_of("door")
    scripts = scripts_of(supervisor)
    source = controller_source(supervisor, "door.rscd")
    assert tells_apart(supervisor, scripts, source) == []
    missed = [
        (m.before, m.after)
        for m in mutants(source)
        if not tells_apart(supervisor, scripts, m.source)
    ]
    # The requirement keeps the door from being turned between the two limits.
    assert missed == [("if self.sensor_last <= 0.01:  # door.rscd:29", "0.062")]
