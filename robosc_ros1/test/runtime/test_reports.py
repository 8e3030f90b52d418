"""What a controller tells of itself: documents by their schemas, reasons, logs, diagnostics."""

from __future__ import annotations

import json
import math
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from runtime.lamp_robot import SENSOR, LampController, PlayedPort
from runtime.schemas import validate
from runtime.test_order_of_commands import PreferringController

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import Engine
from robosc.runtime.core.interfaces import Outlet
from robosc.runtime.core.model import Controller, Parameter
from robosc.runtime.core.reasons import failure_text, reason_text
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import (
    EventLog,
    Reporter,
    dump,
    event_document,
    state_document,
)


class Heard(Outlet):
    """Keeps all that is published, and lets a test wait for it."""

    def __init__(self, listening: bool = True) -> None:
        self.states: list[dict[str, Any]] = []
        self.told: list[dict[str, Any]] = []
        self.levels: list[tuple[int, str, dict[str, str]]] = []
        self.legacies: list[dict[str, Any]] = []
        self.listening = listening
        self.changed = threading.Condition()

    def state(self, text: str) -> None:
        with self.changed:
            self.states.append(json.loads(text))
            self.changed.notify_all()

    def events(self, texts: list[str]) -> None:
        with self.changed:
            self.told += [json.loads(text) for text in texts]
            self.changed.notify_all()

    def wants_events(self) -> bool:
        return self.listening

    def legacy(self, text: str) -> None:
        self.legacies.append(json.loads(text))

    def diagnostics(self, level: int, message: str, values: list[tuple[str, str]]) -> None:
        with self.changed:
            self.levels.append((level, message, dict(values)))
            self.changed.notify_all()

    def wait(self, condition: Any) -> None:
        with self.changed:
            assert self.changed.wait_for(condition, 20)


def state_of(engine: Engine[Any]) -> dict[str, Any]:
    entries = [event_document(e) for e in engine.recorder.take()]
    document = json.loads(dump(state_document(engine.snapshot(), entries[-10:])))
    validate(document, "state")
    return document  # type: ignore[no-any-return]


def reasons(document: dict[str, Any], kind: str, name: str) -> list[tuple[str, str]]:
    (command,) = (
        c for c in document["commands"] if (c["event"]["kind"], c["event"]["name"]) == (kind, name)
    )
    assert command["enabled"] == (not command["blocked_by"])
    return [(reason["kind"], reason["text"]) for reason in command["blocked_by"]]


def test_the_state_tells_why_commands_are_not_enabled() -> None:
    engine = controller_engine(LampController(), PlayedPort())
    engine.begin()
    document = state_of(engine)
    assert reasons(document, "request", "go") == [("requirement", "go needs clear")]
    assert reasons(document, "request", "halt") == []
    assert reasons(document, "cancel", "reach") == [("phase", "it is idle")]
    engine.cycle()
    document = state_of(engine)
    assert reasons(document, "cancel", "reach") == [
        ("requirement", "this requirement holds: reach needs blocked")
    ]
    assert reasons(document, "request", "light") == [("phase", "it is busy")]
    assert ("phase", "it is busy") in reasons(document, "request", "reach")
    assert ("synchronisation", "blocked by Arm in reaching") in reasons(
        document, "request", "reach"
    )
    assert document["communications"] == {"light": "busy", "reach": "busy"}


def test_the_state_tells_which_preferred_command_is_sent_instead() -> None:
    """Only where both are enabled; a call that is under way holds back nothing."""
    engine = controller_engine(PreferringController(), PlayedPort())
    engine.begin()
    for value, waiting in ((0, []), (50, ["go"]), (0, [])):
        engine.post(SENSOR, "response", value)
        engine.cycle()
        waits = {c["event"]["name"]: c["waits_for"] for c in state_of(engine)["commands"]}
        assert waits == {"go": [], "halt": waiting}


def test_the_whole_condition_of_synchronisation_decides() -> None:
    """Else a command that is never sent for a fault in it would be shown as enabled."""
    controller = LampController()
    command = controller.COMMANDS[3]._replace(synchronisation=lambda state: False)
    controller.COMMANDS = (*controller.COMMANDS[:3], command, *controller.COMMANDS[4:])
    document = state_of(controller_engine(controller, PlayedPort()))
    assert ("range", "a variable would leave its range") in reasons(document, "request", "reach")


def test_what_synthesis_forbids_has_its_reason() -> None:
    controller = LampController()
    controller.lamp_allowed = False
    command = controller.COMMANDS[2]._replace(reason="the lamp would burn out")
    controller.COMMANDS = (*controller.COMMANDS[:2], command, *controller.COMMANDS[3:])
    document = state_of(controller_engine(controller, PlayedPort()))
    assert reasons(document, "request", "light") == [("synthesis", "the lamp would burn out")]


def test_events_follow_their_schema_whatever_they_carry() -> None:
    engine = controller_engine(LampController(), PlayedPort())
    engine.begin()
    for value in (50, float("nan"), float("inf"), -1, "far"):
        engine.post(SENSOR, "response", value)
    engine.cycle()
    engine.stop("enough")
    engine.cycle()
    latest = [event_document(e) for e in engine.recorder._entries]
    dump(state_document(engine.snapshot(), latest[-10:]))  # fails if anything is not JSON
    documents = [json.loads(dump(event_document(e))) for e in engine.recorder.take()]
    for document in documents:
        validate(document, "event")
    assert {d["outcome"] for d in documents} == {"applied", "mismatch", "stopped"}
    assert [d["number"] for d in documents] == list(range(1, len(documents) + 1))


def run_reporter(
    settings: Settings,
    heard: Heard,
    play: Any,
    controller: Controller | None = None,
    diagnostics_period: float = 1.0,
) -> Engine[Any]:
    engine = controller_engine(controller or LampController(), PlayedPort(), settings)
    reporter = Reporter(engine, heard, {}, diagnostics_period)
    thread = threading.Thread(target=engine.run, daemon=True)
    thread.start()
    reporter.start()
    play(engine)
    engine.close()
    thread.join(60)
    reporter.close(10)
    return engine


def report_at_last(reporter: Reporter, engine: Engine[Any]) -> None:
    """Let a reporter publish the last state of an engine that no thread runs."""
    reporter.start()
    while reporter.is_alive():
        engine.cycle()  # it asks the engine
        reporter.close(0.001)


@pytest.mark.parametrize("place", [{}, {"place": "lamp.rscd:2"}])
@pytest.mark.parametrize("because", [{}, {"because": ["a < 1 is false", "b"]}])
def test_a_reason_on_a_line_has_all_its_parts(place: Any, because: Any) -> None:
    reason = {"kind": "requirement", "text": "go needs clear", **place, **because}
    expected = "go needs clear" + (" (lamp.rscd:2)" if place else "")
    assert reason_text(reason) == expected + (": a < 1 is false, b" if because else "")


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (0.3, "0.3"),
        (float(np.float32(0.3)), "0.300000012"),
        (-float(np.float32(0.3)), "-0.300000012"),
        (0.1 + 0.2, "0.30000000000000004"),
        (float(np.float32(0.35)), "0.35"),
        (1 / 3, "0.333333"),
        (-2.0, "-2"),
        (math.inf, "inf"),
        (math.nan, "nan"),
        (7, "7"),
    ],
)
def test_a_number_beside_a_limit_is_not_told_as_that(value: float, told: str) -> None:
    assert failure_text("", {"value.x": value}, [0.3, 2.0]) == f"value.x is {told}"


def test_every_event_is_published_and_the_last_state_is_the_last() -> None:
    heard = Heard()

    def play(engine: Engine[Any]) -> None:
        for value in [5, 50] * 500:
            engine.post(SENSOR, "response", value)
        heard.wait(lambda: heard.states and heard.states[-1]["counters"]["inputs"] == 1000)

    engine = run_reporter(Settings(state_rate=1000.0), heard, play)
    assert [d["number"] for d in heard.told] == list(range(1, engine.recorder.number + 1))
    assert heard.states[-1]["number"] == engine.recorder.number
    assert heard.states[-1]["variables"]["Motor.speed"] == 5.0


def test_nobody_listens_and_the_state_still_knows_the_latest_events() -> None:
    heard = Heard(listening=False)

    def play(engine: Engine[Any]) -> None:
        engine.post(SENSOR, "response", 50)
        heard.wait(lambda: heard.states and heard.states[-1]["counters"]["inputs"] == 1)

    run_reporter(Settings(), heard, play)
    assert heard.told == []
    assert "range" in {e["event"]["name"] for e in heard.states[-1]["latest"]}


class Broken(Heard):
    def state(self, text: str) -> None:
        raise TypeError("no such text")


def test_a_report_that_cannot_be_made_is_reported() -> None:
    heard = Broken()

    def play(engine: Engine[Any]) -> None:
        heard.wait(lambda: heard.levels)

    run_reporter(Settings(), heard, play)
    assert heard.levels[0] == (2, "cannot report the state: no such text", {})


def test_diagnostics_warn_of_what_is_new_and_are_calm_again() -> None:
    heard = Heard()

    def play(engine: Engine[Any]) -> None:
        engine.post(SENSOR, "response", 500)
        heard.wait(lambda: any(level == 1 for level, _, _ in heard.levels))
        heard.wait(lambda: heard.levels[-1][0] == 0)
        engine.stop("enough")
        heard.wait(lambda: heard.levels[-1][0] == 2)

    run_reporter(Settings(state_rate=100.0), heard, play, diagnostics_period=0.05)
    warning = next(message for level, message, _ in heard.levels if level == 1)
    assert "1 new mismatches" in warning
    assert heard.levels[-1][1] == "safe stop: enough"
    assert heard.levels[-1][2]["mismatches"] == "1"


def test_the_event_log_is_a_line_per_event_and_rotates(tmp_path: Path) -> None:
    log = EventLog(str(tmp_path / "deep" / "events.jsonl"), limit=100, keep=2)
    for number in range(50):
        log.write([json.dumps({"number": number, "text": "x" * 20})])
    files = sorted(p.name for p in (tmp_path / "deep").iterdir())
    assert files == ["events.jsonl.1", "events.jsonl.2"] or files == [
        "events.jsonl", "events.jsonl.1", "events.jsonl.2",
    ]  # fmt: skip
    newest = next(p for p in ("events.jsonl", "events.jsonl.1") if (tmp_path / "deep" / p).exists())
    last = (tmp_path / "deep" / newest).read_text(encoding="utf-8").splitlines()[-1]
    assert json.loads(last)["number"] == 49
    assert all(p.stat().st_size < 200 for p in (tmp_path / "deep").iterdir())


def test_what_is_kept_of_the_log_is_limited(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    for keep in (0, 1, 10**12):  # the last of them means all
        log = EventLog(str(path), limit=10, keep=keep)
        for number in range(5):
            log.write([f"line {number} of {keep}"])
    kept = {p.name: p.read_text() for p in tmp_path.iterdir()}
    assert kept == {
        "events.jsonl.1": "line 4 of 1000000000000\n",
        "events.jsonl.2": "line 3 of 1000000000000\n",
        "events.jsonl.3": "line 2 of 1000000000000\n",
        "events.jsonl.4": "line 1 of 1000000000000\n",
        "events.jsonl.5": "line 0 of 1000000000000\n",
        "events.jsonl.6": "line 4 of 1\n",
    }


def test_two_nodes_do_not_write_one_log(tmp_path: Path) -> None:
    logs = [EventLog(str(tmp_path / "events.jsonl"), limit=10**6, keep=1) for _ in range(2)]
    logs[0].write(["first"])
    with pytest.raises(OSError, match="written by another node"):
        logs[1].write(["second"])
    assert (tmp_path / "events.jsonl").read_text() == "first\n"


@pytest.mark.parametrize("moved", [True, False])
def test_a_log_that_was_moved_or_deleted_is_opened_anew(tmp_path: Path, moved: bool) -> None:
    path = tmp_path / "events.jsonl"
    log = EventLog(str(path), limit=10**6, keep=1)
    log.write(["first"])
    if moved:
        path.rename(tmp_path / "events.jsonl.old")
    else:
        path.unlink()
    log.write(["second"])
    log.write(["third"])
    assert path.read_text() == "second\nthird\n"


def test_a_log_whose_disk_was_full_goes_on_where_there_is_room(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    path.symlink_to("/dev/full")
    log = EventLog(str(path), limit=10**6, keep=1)
    with pytest.raises(OSError, match="No space left"):
        log.write(["first"])
    path.unlink()
    with pytest.raises(OSError, match="No space left"):
        log.write(["second"])  # closing what could not be written
    log.write(["third"])
    assert path.read_text() == "third\n"


def test_a_line_that_was_cut_off_does_not_spoil_the_next(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    path.write_text('whole\n{"vers')
    EventLog(str(path), limit=10**6, keep=1).write(["next \ud800"])
    assert path.read_text() == 'whole\n{"vers\nnext \\ud800\n'


def test_the_reporter_writes_the_log_and_tells_when_it_cannot(tmp_path: Path) -> None:
    def play(engine: Engine[Any]) -> None:
        engine.post(SENSOR, "response", 50)
        heard.wait(lambda: heard.states and heard.states[-1]["counters"]["inputs"] == 1)

    heard = Heard()
    engine = run_reporter(Settings(event_log=str(tmp_path / "log")), heard, play)
    lines = (tmp_path / "log").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)["number"] for line in lines] == list(
        range(1, engine.recorder.number + 1)
    )

    def play_longer(engine: Engine[Any]) -> None:
        play(engine)
        heard.wait(lambda: any("event log" in message for _, message, _ in heard.levels))
        heard.wait(lambda: any("event log" in fault for fault in heard.states[-1]["faults"]))

    heard = Heard()
    (tmp_path / "file").write_text("")
    engine = run_reporter(Settings(event_log=str(tmp_path / "file" / "log")), heard, play_longer)
    logs = [text for _, text in engine._port.logs if "event log" in text]  # type: ignore[attr-defined]
    assert len(logs) == 1


class AdjustableLamp(LampController):
    """With a parameter of the model."""

    PARAMETERS = (
        Parameter("limit", "number", 0.5, "parameter limit of the model", attribute="most"),
    )
    most = 0.5


def test_the_first_event_of_a_log_and_the_state_tell_the_parameters(tmp_path: Path) -> None:
    log = tmp_path / "events.jsonl"
    heard = Heard()
    controller = AdjustableLamp()
    controller.configure({"limit": 0.75})

    def play(engine: Engine[Any]) -> None:
        for value in (50, 60):
            engine.post(SENSOR, "response", value)

    run_reporter(Settings(event_log=str(log)), heard, play, controller)
    events = [json.loads(line) for line in log.read_text().splitlines()]
    for event in events:
        validate(event, "event")
    assert [event.get("parameters") for event in events][:2] == [{"limit": 0.75}, None]
    state = heard.states[-1]
    validate(state, "state")
    assert state["parameters"] == {"limit": 0.75}
