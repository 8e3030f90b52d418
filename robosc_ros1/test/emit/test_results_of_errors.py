"""Actions whose errors bring a result: at every stage, with the result and without."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from emit.scripted_controllers import faults_of
from emit.test_cif import check_data
from runtime.lamp_robot import PlayedPort
from simulate.players import play, session

from robosc.model.resolve import load
from robosc.runtime.core.calls import Failure
from robosc.runtime.core.commanding import controller_engine
from robosc.simulate.replay import replay
from robosc.source import Source

MODEL = """\
robot Courier {
    component Base {
        action navigate with request: none, response: Result, feedback: none links nav
        outgoing message battery with type: double
        incoming message beep with type: none
        behaviour {
            variable tries: integer(0..2)
            variable last: integer
            variable length: integer
            variable charge: double = 1.0
            on response from battery do charge := value
            on error from navigate goto idle
            initial marked state idle {
                on request to navigate goto going
            }
            state going {
                on response from navigate do tries := 0 goto idle
                on error from navigate if value.code = 3 or value.left[1] > 9
                    do last := value.code, length := length(value.left) goto blocked
                on cancelled from navigate goto idle
            }
            marked state blocked {
                on response from battery do tries := 0 goto idle
            }
        }
    }
    requirement navigate needs Base.charge > 0.3
    requirement beep needs Base.last = 3
    datatype object Result { code: integer(0..9) left: array(double) }
    interface nav use Navigate from nowhere_msgs
}
"""


def test_where_errors_bring_a_value() -> None:
    def faults(old: str, new: str) -> list[str]:
        assert old in MODEL
        _, diagnostics = load(Source("model.rscd", MODEL.replace(old, new)))
        return [d.message for d in diagnostics if d.severity.value == "error"]

    assert faults("code = 3", "code = 4") == []
    assert faults("code = 3", "kode = 3") == ["Result has no property 'kode'"]
    assert faults("response: Result,", "response: none,")[0] == "this event carries no value"
    service = "service navigate with request: none, response: Result links nav"
    assert faults(
        "action navigate with request: none, response: Result, feedback: none links nav", service
    )[0] == "'on error' of a service carries a value only where it has 'expect:'"  # fmt: skip


def test_the_remedy_is_for_when_no_result_comes() -> None:
    faulty = MODEL.replace("            on error from navigate goto idle\n", "")
    supervisor = supervisor_of(faulty)
    guard = next(g for g in supervisor.guards if g.event.name == "navigate")
    assert guard.status == "never"
    (reason,) = {e.remedy for e in supervisor.explanations if e.remedy is not None}
    assert reason == "add 'on error from navigate else goto idle' in state going of Base"
    line = "            on error from navigate else goto idle\n"
    mended = supervisor_of(faulty.replace("goto blocked\n", f"goto blocked\n{line}"))
    assert next(g for g in mended.guards if g.event.name == "navigate").status == "as required"
    assert "hidden-transition" not in {d.code for d in load(Source("model.rscd", MODEL))[1]}


def test_single_events_with_a_result_and_without() -> None:
    supervisor = supervisor_of(MODEL)
    for value, state in (("code: 3, left: [1.0]", "blocked"), ("code: 4, left[1]: 9.5", "blocked"),
                         ("code: 4", "idle"), ("missing", "idle"), ("", "idle")):  # fmt: skip
        player = session(supervisor)
        play(player, "navigate.request", f"navigate.error {value}")
        play(player, f"expect Base.{state}")  # raises if that does not hold


@pytest.fixture
def engine() -> Any:
    make, _ = controller_class(supervisor_of(MODEL))
    port = PlayedPort()
    engine = controller_engine(make(), port, steady=lambda: port.time)
    engine.begin()
    engine.cycle()
    assert port.take() == ["Base.navigate"]
    return engine


def fail(engine: Any, result: Any) -> Any:
    """End the goal in an error; its events."""
    token = engine._port.tokens["Base.navigate"]
    engine.report("Base.navigate", token, "error", Failure("aborted", result))
    engine.cycle()
    return [event for event in engine.recorder.take() if event.kind == "error"]


def test_the_engine_takes_the_result_of_an_error(engine: Any) -> None:
    (event,) = fail(engine, SimpleNamespace(code=3, left=[1.0, 2.0]))
    assert (event.value["code"], event.value["left[1]"], event.detail) == (3, 2.0, "aborted")
    assert engine.controller.variables()["Base.length"] == 2
    assert engine.controller.components() == {"Base": "blocked"}


def test_without_a_result_nothing_is_read(engine: Any) -> None:
    (event,) = fail(engine, None)
    assert set(event.value.values()) == {None}
    assert engine.controller.components()["Base"] != "blocked"
    assert engine.stopped is None


@pytest.mark.parametrize("code", [12, "three"])
def test_an_unusable_result_counts_as_none(engine: Any, code: object) -> None:
    events = fail(engine, SimpleNamespace(code=code, left=[]))
    assert [e.outcome for e in events] == ["mismatch", "applied"]
    assert engine.stopped is None


def test_a_run_with_such_errors_follows_its_model(tmp_path: Path) -> None:
    supervisor = supervisor_of(MODEL)
    player = session(supervisor, execute=True)
    happenings = list(player.latest)
    for line in ("navigate.error code: 4, left: [1.0]", "wait 1", "navigate.error", "random 40 1"):
        happenings += player.do(line).happenings
    log = tmp_path / "events.log"
    documents: list[dict[str, Any]] = [
        {
            "version": 1,
            "number": number,
            "event": {"kind": h.kind, "name": h.name, "value": h.value},
            "outcome": h.outcome,
        }
        for number, h in enumerate(happenings, 1)
    ]
    log.write_text("\n".join(map(json.dumps, documents)), encoding="utf-8")
    found = replay(supervisor, str(log))
    assert (found.departures, found.missing, found.events) == ((), (), len(happenings))
    values = [d["event"]["value"] for d in documents if d["event"]["kind"] == "error"]
    assert {"code": 4, "left[1]": None, "left": [1.0]} in values
    assert {"code": None, "left[1]": None, "left": None} in values


def test_the_test_of_the_package_follows_the_results_of_errors() -> None:
    supervisor = supervisor_of(MODEL)
    assert faults_of(supervisor) == []
    assert faults_of(supervisor, '["code"]) == 3', '["code"]) == 4') != []


def test_cif_has_an_event_for_no_result() -> None:
    check_data(MODEL)
