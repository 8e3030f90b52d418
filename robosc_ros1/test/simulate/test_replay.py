"""``robosc replay``: a run's event log against the model it was generated from."""

from __future__ import annotations

import json
import math
import random
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from hypothesis import given, settings
from hypothesis import strategies as st
from random_models import random_model
from ros_support import Completed, await_condition
from runtime.lamp_robot import PlayedPort
from simulate.players import MODEL, SEVERAL_TYPES, line_follower, session

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.interfaces import Outlet
from robosc.runtime.core.recorder import Entry
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import EventLog, Reporter, dump, event_document
from robosc.simulate.machines.machine import Happening
from robosc.simulate.machines.state import make_controller
from robosc.simulate.replay import replay
from robosc.simulate.script.session import Session
from robosc.supervisor import Supervisor

Robosc = Callable[..., Completed]


def lines_of(happenings: Sequence[Happening]) -> list[str]:
    """As the runtime's reporter writes them."""
    return [
        dump(event_document(Entry(number, h.time, h.kind, h.name, h.index, h.value, h.outcome,
                                  h.detail)))
        for number, h in enumerate(happenings, 1)
    ]  # fmt: skip


def run_of(player: Session, *lines: str) -> list[Happening]:
    """All that the engine noted from its beginning on."""
    happenings = list(player.latest)
    for line in lines:
        happenings += player.do(line).happenings
    return happenings


def write(path: Path, lines: Sequence[str]) -> str:
    EventLog(str(path), 10**9, 3).write(list(lines))
    return str(path)


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return line_follower()


@pytest.fixture
def log(supervisor: Supervisor) -> list[str]:
    """A run that grabs something, and drives on."""
    player = session(supervisor, execute=True)
    return lines_of(
        run_of(player, "random 60 11", "distance 0.2", "correction 3", "distance 0.5", "wait 1")
    )


def test_a_run_follows_its_model(robosc: Robosc, tmp_path: Path, log: list[str]) -> None:
    done = robosc("replay", str(MODEL), write(tmp_path / "events.log", log))
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"LineFollower: 1 run, {len(log)} events: follows the model\n"
    done = robosc("replay", str(MODEL), write(tmp_path / "begun.log", log[:1]))
    assert done.stdout == "LineFollower: 1 run, 1 event: follows the model\n"


def test_a_log_and_a_script_from_a_pipe(robosc: Robosc, tmp_path: Path, log: list[str]) -> None:
    # Not the files of such a name.
    for name in ("-", "-.1"):
        (tmp_path / name).write_text("nonsense", encoding="utf-8")

    done = robosc("replay", str(MODEL), "-", stdin="\n".join(log))
    assert (done.returncode, done.stderr) == (0, "")
    assert "follows the model" in done.stdout
    script = "distance free\nexpect DistanceSensor.current = free\n"
    done = robosc("simulate", str(MODEL), "--script", "-", stdin=script)
    assert (done.returncode, done.stderr) == (0, "")
    assert "1 of 1" in done.stdout


def test_a_log_whose_last_event_filled_a_file(
    robosc: Robosc, tmp_path: Path, log: list[str]
) -> None:
    path = tmp_path / "events.log"
    EventLog(str(path), 1, len(log)).write(log)  # each event fills one
    assert not path.exists()
    done = robosc("replay", str(MODEL), str(path))
    assert done.stdout == f"LineFollower: 1 run, {len(log)} events: follows the model\n"


def test_several_runs_and_rotated_files(
    robosc: Robosc, tmp_path: Path, log: list[str], supervisor: Supervisor
) -> None:
    write(tmp_path / "events.log.2", log[:10])
    write(tmp_path / "events.log.1", [*log[10:], *log[:7]])
    write(tmp_path / "events.log.old", ["nothing"])
    done = robosc("replay", write(tmp_path / "events.log", log[7:]), str(MODEL), "--json")
    assert done.returncode == 0
    found = json.loads(done.stdout)
    assert (found["runs"], found["events"], found["departures"]) == (2, 2 * len(log), [])


def changed(log: list[str], number: int, **event: Any) -> list[str]:
    """The log with another event in one place."""
    document = json.loads(log[number])
    document["event"] |= event
    return [*log[:number], json.dumps(document), *log[number + 1 :]]


def find(log: list[str], name: str, kind: str = "request") -> int:
    """Where such an event stands last."""
    events = [json.loads(line)["event"] for line in log]
    return max(n for n, e in enumerate(events) if (e["name"], e["kind"]) == (name, kind))


def test_a_command_that_was_not_allowed(robosc: Robosc, tmp_path: Path, log: list[str]) -> None:
    number = find(log, "move")
    done = robosc(
        "replay", write(tmp_path / "events.log", changed(log, number, name="stop")), str(MODEL)
    )
    assert done.returncode == 1
    first, last = done.stdout.splitlines()
    place = f"{tmp_path / 'events.log'}:{number + 1}: event {number + 1}, stop.request"
    assert first.startswith(f"{place}, leaves the model: requirement stop needs")
    assert "line_follower.rscd:" in first
    assert last.endswith("leaves the model")


@pytest.mark.parametrize(
    ("event", "reason"),
    [
        ({"value": {"linear": {"x": 9.0}, "angular": {"z": 0.0}}}, "the model sends {"),
        ({"name": "lift"}, "the model has no lift.request"),
        ({"kind": "error", "name": "set_light_state"}, "not under way"),
        ({"kind": "tau", "name": "Motor", "index": 1, "value": "a->b"}, "no such step"),
    ],
)
def test_other_ways_to_leave(
    event: dict[str, Any], reason: str, tmp_path: Path, log: list[str], supervisor: Supervisor
) -> None:
    path = write(tmp_path / "events.log", changed(log, find(log, "move"), **event))
    if event.get("kind") == "error":
        quiet = session(supervisor, execute=True)
        run = lines_of(run_of(quiet, "set_light_state.response", "distance free", "wait 0.1"))
        path = write(tmp_path / "quiet.log", changed(run, find(run, "move"), **event))
    (departure,) = replay(supervisor, path).departures
    assert reason in departure.reason


def test_own_steps_that_were_left_out(tmp_path: Path) -> None:
    supervisor = supervisor_of(SEVERAL_TYPES)
    player = session(supervisor, execute=True)
    run = run_of(player, "level 3", "level 2", "pose position.side: left, tags[0]: 1", "level 9")
    assert replay(supervisor, write(tmp_path / "all.log", lines_of(run))).exit_code == 0
    without = lines_of([h for h in run if h.kind != "tau"])
    (departure,) = replay(supervisor, write(tmp_path / "some.log", without)).departures
    assert departure.reason == "Sensor had to take its transition quiet->loud before"


def test_mismatches_are_counted_and_not_applied(tmp_path: Path) -> None:
    supervisor = supervisor_of(SEVERAL_TYPES)
    run = run_of(session(supervisor, execute=True), "level 9", "level 1")
    found = replay(supervisor, write(tmp_path / "events.log", lines_of(run)))
    assert (found.exit_code, found.mismatches) == (0, 1)


def test_only_the_stop_command_may_be_sent_guard_or_not(
    tmp_path: Path, supervisor: Supervisor
) -> None:
    run = lines_of(run_of(session(supervisor, execute=True), "distance free"))
    stop = json.loads(run[find(run, "stop")]) | {"number": len(run) + 1}
    (departure,) = replay(
        supervisor, write(tmp_path / "a.log", [*run, json.dumps(stop)])
    ).departures
    assert departure.reason.startswith("requirement stop needs")
    stop["detail"] = "stop command"
    assert replay(supervisor, write(tmp_path / "b.log", [*run, json.dumps(stop)])).exit_code == 0


def test_nothing_is_commanded_after_a_safe_stop(tmp_path: Path, supervisor: Supervisor) -> None:
    run = run_of(session(supervisor, execute=True), "distance free", "wait 0.1")
    at = max(n for n, h in enumerate(run) if h.name == "move")
    halt = Happening("stop", "", outcome="stopped", detail="enough", time=1.0)
    (departure,) = replay(
        supervisor, write(tmp_path / "events.log", lines_of([*run[:at], halt, *run[at:]]))
    ).departures
    assert (departure.event, departure.reason) == (
        "move.request", "the controller had made a safe stop",
    )  # fmt: skip


def test_events_that_are_missing(robosc: Robosc, tmp_path: Path, log: list[str]) -> None:
    path = write(tmp_path / "events.log", [*log[:4], *log[6:], *log])
    done = robosc("replay", path, str(MODEL))
    assert done.returncode == 2
    assert f"{path}:5: events 5 to 6 are missing" in done.stdout
    assert "2 runs" in done.stdout
    later = robosc("replay", write(tmp_path / "later.log", log[3:]), str(MODEL))
    assert later.returncode == 2
    assert "events 1 to 3 are missing" in later.stdout


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "holds no events"),
        pytest.param(b" " * (2**24 + 1), "no event has more than 16 MB", id="no lines"),
        (b"\n\n", "holds no events"),
        (b"no json", "events.log:1: this is not an event of a log"),
        (b'{"version": 1}', "this is not an event of a log"),
        (b"[" * 100000, "this is not an event of a log"),
        (b'{"version": 2, "number": 1}', "this is not an event of a log"),
        (b"\xff\xfe", "this is not an event of a log"),
    ],
)
def test_what_is_no_log(content: bytes, message: str, robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "events.log").write_bytes(content)
    done = robosc("replay", "events.log", str(MODEL))
    assert done.returncode == 2
    assert message in done.stderr


NUMBERS_BY_NAME = """\
robot Names {
    datatype enum Size from double to { value > 9 -> Infinity default -> NaN }
    component Sensor {
        outgoing message size with type: Size
        outgoing message word with type: string
        outgoing message weight with type: double
        outgoing message level with type: integer(0..3)
        incoming message say with type: string
        incoming message weigh with type: double
        behaviour {
            variable size: Size
            variable word: string
            variable weight: double
            variable level: integer(0..3)
            on response from size do size := value
            on response from word do word := value
            on response from weight do weight := value
            on response from level do level := value
            initial marked state only {}
        }
    }
    requirement say needs Sensor.size = Infinity
    requirement weigh needs Sensor.level > 0
    provide say with Sensor.word
    provide weigh with Sensor.weight
}
"""


def test_texts_that_look_like_numbers_stay_texts(tmp_path: Path) -> None:
    supervisor = supervisor_of(NUMBERS_BY_NAME)
    player = session(supervisor, execute=True)
    run = run_of(player, 'word "NaN"', "size Infinity", "weight NaN", "level 1", "wait 0.2")
    path = write(tmp_path / "events.log", lines_of(run))
    said = [h.value for h in run if h.name in ("say", "weigh")]
    assert {"data": "NaN"} in said  # a text
    assert any(isinstance(v["data"], float) and math.isnan(v["data"]) for v in said)
    assert replay(supervisor, path).departures == ()


@pytest.mark.parametrize(
    ("event", "reason"),
    [
        ({"name": "level", "value": 4}, "its value cannot be 4: it carries an integer(0..3)"),
        ({"name": "level", "value": True}, "it carries an integer(0..3)"),
        ({"name": "level", "value": 1.0}, "it carries an integer(0..3)"),
        ({"name": "weight", "value": "heavy"}, "it carries a double"),
        ({"name": "weight", "value": "nan"}, "it carries a double"),
        ({"name": "size", "value": "big"}, "it carries a value of Size"),
        ({"name": "word", "value": 3}, "it carries a string"),
    ],
)
def test_values_that_the_model_does_not_carry(
    event: dict[str, Any], reason: str, tmp_path: Path
) -> None:
    supervisor = supervisor_of(NUMBERS_BY_NAME)
    run = lines_of(run_of(session(supervisor, execute=True), "level 1"))
    path = write(tmp_path / "events.log", changed(run, find(run, "level", "response"), **event))
    (departure,) = replay(supervisor, path).departures
    assert reason in departure.reason


def test_parts_that_the_model_does_not_have(tmp_path: Path) -> None:
    supervisor = supervisor_of(SEVERAL_TYPES)
    run = lines_of(run_of(session(supervisor, execute=True), "pose position.side: left"))
    for value in ({"position.x": 1.0}, [1], None, "left"):
        path = tmp_path / "events.log"
        path.unlink(missing_ok=True)
        write(path, changed(run, find(run, "pose", "response"), value=value))
        (departure,) = replay(supervisor, str(path)).departures
        assert "it has the parts position.side, tags[0], position.x" in departure.reason


def test_a_line_that_was_cut_off_is_left_out(
    tmp_path: Path, log: list[str], supervisor: Supervisor
) -> None:
    path = tmp_path / "events.log"
    write(path, log[:20])
    with path.open("a") as file:
        file.write(log[20][:30])
    assert replay(supervisor, str(path)).exit_code == 0
    write(path, log)  # the next run of the node
    found = replay(supervisor, str(path))
    assert (found.exit_code, found.runs, found.events) == (0, 2, 20 + len(log))
    path.write_text("\n".join([*log[:20], log[20][:30], *log[21:]]) + "\n")
    assert "events 21 to 21 are missing" in replay(supervisor, str(path)).missing[0]
    path.write_text("\n".join([*log[:20], log[0][:30] + "\xfc", *log[1:]]) + "\n")
    found = replay(supervisor, str(path))
    assert (found.runs, len(found.missing)) == (2, 1)
    assert "events 1 to 1 are missing" in found.missing[0]


def test_a_log_that_cannot_be_read(robosc: Robosc) -> None:
    for name in ("nowhere/events.log", "."):
        done = robosc("replay", name, str(MODEL))
        assert done.returncode == 2
        assert f"cannot read {name}" in done.stderr


class Silent(Outlet):
    """Only the event log is wanted."""

    def state(self, text: str) -> None: ...

    def events(self, texts: list[str]) -> None: ...

    def diagnostics(self, level: int, message: str, values: list[tuple[str, str]]) -> None: ...


class Idle(PlayedPort):
    """Answers nothing; its clock goes with each look at it."""

    def now(self) -> float:
        self.time += 0.001
        return self.time


def test_a_log_that_the_running_engine_wrote(tmp_path: Path, supervisor: Supervisor) -> None:
    """Its own threads, messages as they come from topics, the reporter and its file."""
    path = tmp_path / "events.log"
    port = Idle()
    engine = controller_engine(
        make_controller(supervisor), port, Settings(event_log=str(path)), port.now
    )
    reporter = Reporter(engine, Silent(), {})
    thread = threading.Thread(target=engine.run)
    reporter.start()
    thread.start()
    for number in range(200):
        engine.post("DistanceSensor.distance", "response", SimpleNamespace(data=number % 7 / 10))
        engine.post("LineDetector.correction", "response", SimpleNamespace(data=number / 3))
        engine.post("LineDetector.correction", "response", SimpleNamespace(data=math.nan))
    await_condition(lambda: engine.recorder.counters["inputs"] >= 600, "all inputs")
    engine.close()
    thread.join()
    reporter.close(10)
    found = replay(supervisor, str(path))
    assert (found.departures, found.missing) == ((), ())
    assert found.events == engine.recorder.number > 600


def test_a_stop_breaks_off_steps_that_never_end(tmp_path: Path) -> None:
    supervisor = supervisor_of(
        "robot R { component C { outgoing message m with type: none behaviour {"
        " initial marked state a { transition goto b }"
        " marked state b { transition goto c }"
        " marked state c { transition goto a on response from m } } } }"
    )
    run = run_of(session(supervisor, execute=True), "m")
    assert [h.kind for h in run if h.kind != "tau"] == ["stop", "response"]
    found = replay(supervisor, write(tmp_path / "events.log", lines_of(run)))
    assert (found.departures, found.missing) == ((), ())


@pytest.mark.slow
@settings(max_examples=25)
@given(seed=st.integers(0, 10**6))
def test_runs_of_random_models_follow_them(
    seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    supervisor = supervisor_of(random_model(random.Random(seed), 1 + seed % 3))
    if supervisor.empty:
        return
    player = session(supervisor, execute=True)
    run = run_of(player, f"random 40 {seed}")
    if not run:
        return
    path = write(tmp_path_factory.mktemp("log") / "events.log", lines_of(run))
    assert replay(supervisor, path).departures == ()


PLACES = """robot Courier {
    interface links use Place from nowhere_msgs
    datatype object Place { x: double side: Side gear: integer(0..3) }
    datatype enum Side from integer to { value < 0 -> left default -> other }
    component Operator {
        outgoing message place with type: Place links links
        incoming message go with type: double
        behaviour {
            variable goal: Place
            initial marked state on { on response from place do goal := value }
        }
    }
    requirement go needs Operator.goal.side = left
    provide go with Operator.goal.x
}"""


@pytest.mark.parametrize(
    ("place", "follows"),
    [
        ({"x": 2.0, "side": -1, "gear": 0}, True),
        ({"x": 2.0, "side": -1, "gear": 9, "header": {"seq": 1}}, True),
        ({"x": 2.0, "side": 1, "gear": 0}, False),
        ({"x": 2.0, "gear": 0}, False),
        ({"x": 2.0, "side": -1, "gear": True}, False),
        ([2.0], False),
    ],
)
def test_a_message_that_is_kept_as_a_whole(tmp_path: Path, place: Any, follows: bool) -> None:
    """It is logged as it came: with what enums convert, and with fields that the model lacks."""
    events = (("response", "place", {"": place}), ("request", "go", {"data": 2.0}))
    lines = [
        dump(event_document(Entry(number, 1.0, kind, name, 0, value, "applied", None)))
        for number, (kind, name, value) in enumerate(events, 1)
    ]
    found = replay(supervisor_of(PLACES), write(tmp_path / "events.log", lines))
    assert (found.departures == ()) is follows


def test_a_log_in_which_nothing_happened_is_no_evidence(
    robosc: Robosc, tmp_path: Path, log: list[str]
) -> None:
    """All that the node got was out of place: nothing of the model was seen to be kept."""
    numbered = [json.loads(line) for line in log[:3]]
    for document in numbered:
        document["outcome"] = "mismatch"
    path = write(tmp_path / "events.log", [json.dumps(document) for document in numbered])
    done = robosc("replay", str(MODEL), path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith(
        "nothing could be judged: it has 3 events, but none that happened\n"
    )
