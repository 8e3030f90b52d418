"""``reason`` in ``on error from``: why a service or an action failed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from model.model_text import faults
from runtime.lamp_robot import PlayedPort
from simulate.players import play, session

from robosc.language.events import EventKind, Kind
from robosc.language.reasons import REASONS, reasons_of
from robosc.plant.automaton import VariableKind
from robosc.plant.step import Verdict, outcome, valuations
from robosc.runtime.core import calls
from robosc.runtime.core.calls import Failure
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import Settings
from robosc.supervisor import Supervisor
from robosc.synthesis.verify.verification import verify

ROBOT = """
robot Hand {
    interface grip use Grip from some_msgs
    interface store use Store from some_msgs
    datatype object Grip { held: boolean }
    datatype object Stored { success: boolean }
    component Hand {
        action grip with identifier: "/grip", request: none, response: Grip, feedback: none
            links grip
        service store with expect: value.success, request: none, response: Stored links store
        behaviour {
            variable safe: boolean = true
            variable dropped: boolean
            variable full: boolean
            initial marked state open {
                on error from grip if reason in { absent, rejected } do safe := true
                on error from grip if reason = failed and value.held do safe := false
                on error from grip if reason = failed and !value.held do dropped := true
                on error from grip else do safe := false
            }
            on error from store do full := reason = refused
        }
    }
    requirement grip needs Hand.safe and !Hand.dropped
    requirement store needs !Hand.full and Hand.safe
}
"""


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(ROBOT)


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_the_engines_agree(engine: str) -> None:
    found = supervisor_of(ROBOT, engine=engine)
    assert verify(found).verified


def errors(supervisor: Supervisor, name: str) -> dict[str, set[tuple[Any, ...]]]:
    """The reasons and values of errors that the plant can do, by phase."""
    plant = supervisor.plant
    key = f"Hand.{name}"
    index = plant.variable_index[VariableKind.PHASE, key]
    (event,) = (e for e in plant.events if e.identity[:2] == (EventKind.ERROR, key))
    found: dict[str, set[tuple[Any, ...]]] = {}
    for number, phase in enumerate(plant.variables[index].values):
        state = tuple(number if n == index else v for n, v in enumerate(plant.initial))
        for values in valuations(event):
            if outcome(plant, event, values, state) is not Verdict.IMPOSSIBLE:
                found.setdefault(str(phase), set()).add(tuple(values))
    return found


def test_the_reasons_that_an_action_can_have(supervisor: Supervisor) -> None:
    found = errors(supervisor, "grip")
    empty = {"absent", "rejected", "timeout", "lost"}
    some = {("failed", held) for held in (True, False, None)}
    assert found["busy"] == {*some, *((word, None) for word in empty)}
    assert found["cancelling"] == {*some, ("lost", None)}
    assert set(found) == {"busy", "cancelling"}


def test_the_reasons_that_a_service_can_have(supervisor: Supervisor) -> None:
    found = errors(supervisor, "store")
    assert found == {"busy": {("failed",), ("absent",), ("refused",), ("timeout",)}}


class Played:
    """The generated controller, executed."""

    def __init__(self, supervisor: Supervisor) -> None:
        self.port = PlayedPort()
        self.controller = controller_class(supervisor)[0]()
        settings = Settings(timeout={"Hand.grip": 2.0}, server_lost_after=5.0)
        self.engine = controller_engine(
            self.controller, self.port, settings, lambda: self.port.time
        )
        self.engine.begin()
        self.engine.cycle()

    def told(self) -> list[tuple[str, str | None]]:
        self.engine.cycle()
        events = self.engine.recorder.take()
        return [(e.name, e.reason) for e in events if e.kind == "error"]

    def end(self, key: str, payload: Any, kind: str = "error") -> list[tuple[str, str | None]]:
        self.engine.report(key, self.port.tokens[key], kind, payload)
        return self.told()


@pytest.mark.parametrize("word", ["absent", "rejected", "failed", "timeout", "lost"])
def test_guards_read_the_reason(supervisor: Supervisor, word: str) -> None:
    played = Played(supervisor)
    result = SimpleNamespace(held=True) if word == "failed" else None
    assert played.end("Hand.grip", Failure("why", result, word)) == [("grip", word)]
    assert played.controller.hand_safe is (word in ("absent", "rejected"))


def test_an_answer_that_is_not_expected_is_refused(supervisor: Supervisor) -> None:
    played = Played(supervisor)
    assert played.end("Hand.store", SimpleNamespace(success=False), "response") == [
        ("store", "refused")
    ]
    assert played.controller.hand_full
    played = Played(supervisor)
    assert played.end("Hand.store", "it broke") == [("store", "failed")]
    assert not played.controller.hand_full


def test_a_deadline_is_the_reason_whatever_came_of_it(supervisor: Supervisor) -> None:
    played = Played(supervisor)
    played.port.time = 2.1
    assert played.told() == []
    payload = Failure("preempted", SimpleNamespace(held=True))
    assert played.end("Hand.grip", payload, "cancelled") == [("grip", "timeout")]
    assert (played.controller.hand_safe, played.controller.hand_dropped) == (False, False)


def test_a_simulated_error_has_the_reason_that_is_written(supervisor: Supervisor) -> None:
    for execute in (False, True):
        player = session(supervisor, execute=execute)
        lines = () if execute else ("grip.request",)
        play(player, *lines, "grip.error reason: rejected", "expect grip.idle and Hand.safe")
        player = session(supervisor, execute=execute)
        play(player, *lines, "grip.error held: true, reason: failed", "expect !Hand.safe")
        player = session(supervisor, execute=execute)
        play(player, *lines, "grip.error held: false", "expect Hand.dropped and Hand.safe")


def test_the_words_are_the_same_at_run_time() -> None:
    assert {reason.word for reason in REASONS} == {
        calls.FAILED, calls.ABSENT, calls.REJECTED, calls.REFUSED, calls.TIMEOUT, calls.LOST
    }  # fmt: skip
    assert reasons_of(Kind.OUTGOING) == ()


HEAD = """
    interface l use L from p
    datatype enum Why from integer to { value = 1 -> broken default -> other }
    component A {
        service s with request: none, response: none links l
        action a with request: none, response: none, feedback: none links l
        behaviour { variable lost: boolean variable why: Why initial marked state open { %s } }
    }
"""


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("on error from a if reason = lost goto open", []),
        ("on error from s, a if reason = timeout goto open", [("syntax", ",")]),
        ("on error from { s, a } if reason = timeout goto open", []),
        ("on error from s if reason = lost goto open", [("type-mismatch", "lost")]),
        ("on error from a if reason = gone goto open", [("unknown-name", "gone")]),
        ("on response from a if reason = lost goto open", [("unknown-name", "reason")]),
        ("on error from a if reason goto open", [("type-mismatch", "reason")]),
        ("on error from a do why := reason", [("type-mismatch", "reason")]),
        ("on error from a if reason = broken goto open", [("type-mismatch", "broken")]),
    ],
)
def test_where_a_reason_stands(line: str, found: list[tuple[str, str]]) -> None:
    told = [f for f in faults(HEAD % line) if f[0] not in ("package-not-found", "unused-variable")]
    assert [f for f in told if not f[0].startswith("unused")] == found


def test_a_variable_of_that_name_is_told_apart_by_its_type() -> None:
    text = (HEAD % "on error from a if reason = 3 or reason = lost goto open").replace(
        "variable lost: boolean", "variable reason: integer(0..3)"
    )
    assert [f for f in faults(text) if not f[0].startswith(("unused", "package"))] == []
