"""The shadow of a controller: it tells what the controller sends, and sends nothing."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from runtime.lamp_robot import ARM, GO, HALT, LAMP, SENSOR, LampController, PlayedPort
from runtime.played_engine import Played
from runtime.test_monitor_engine import BLOCKED, CLEAR, DRIVE, SilentPort

from robosc.runtime.core.calls import Failure
from robosc.runtime.core.settings import Settings
from robosc.runtime.judge.monitoring import monitor_engine
from robosc.runtime.judge.shadowing import Shadow

Told = tuple[str, str, Any]


class Shadowed:
    """A shadow that hears what the test says."""

    def __init__(self, **more: Any) -> None:
        self.port = SilentPort()
        self.controller = LampController()
        self.shadow = monitor_engine(
            self.controller, self.port, Settings(shadow=True, **more), lambda: self.port.time
        )

    def begin(self) -> list[Told]:
        self.shadow.begin()
        self.shadow.cycle()
        return self.withheld()

    def hear(self, distance: float) -> list[Told]:
        self.shadow.poster([SENSOR])(distance)
        self.shadow.cycle()
        return self.withheld()

    def see(self, key: str, kind: str = "request", data: Any = None) -> list[Told]:
        """A command of another node."""
        if key in (GO, HALT):
            self.shadow.role.offer("/drive", DRIVE, data["data"] if data else 0)
        else:
            self.shadow.role.see(key, kind)
        self.shadow.cycle()
        return self.withheld()

    def wait(self, seconds: float) -> list[Told]:
        end = self.port.time + seconds
        while True:
            patience = self.shadow.time_to_deadline()
            if patience is None or self.port.time + patience > end:
                break
            self.port.time += max(patience, 1e-6)  # sums of times are not exact
            self.shadow.cycle()
        self.port.time = end
        return self.withheld()

    def withheld(self) -> list[Told]:
        self.shadow.recorder.settle()
        entries = self.shadow.recorder.take()
        self.outcomes = Counter(e.outcome for e in entries)
        return [(e.name, e.kind, e.value) for e in entries if e.outcome == "withheld"]


@pytest.fixture
def bench() -> Shadowed:
    return Shadowed()


def test_what_would_be_sent_is_told_with_its_data_and_repeated(bench: Shadowed) -> None:
    bench.begin()
    assert bench.hear(CLEAR) == [("go", "request", {"data": CLEAR / 10})]
    assert bench.wait(1.05) == [("go", "request", {"data": CLEAR / 10})] * 10
    assert bench.hear(BLOCKED)[0] == ("halt", "request", None)
    assert bench.port.sent == []


def test_a_command_that_would_change_the_state_is_told_once(bench: Shadowed) -> None:
    assert ("light", "request", None) in bench.begin()
    assert "light" not in [name for name, _, _ in bench.wait(1.0)]
    bench.see(LAMP)
    bench.shadow.role.answer(LAMP, "response", "on")
    bench.shadow.cycle()
    assert bench.controller.lamp_busy is False
    assert ("light", "request", None) in bench.wait(0.2)


def test_the_state_follows_what_is_really_sent(bench: Shadowed) -> None:
    bench.begin()
    bench.hear(BLOCKED)
    assert bench.controller.arm == "idle"
    bench.see(ARM)
    assert bench.controller.arm == "reaching"
    assert ("reach", "cancel", None) in bench.hear(CLEAR)
    assert bench.controller.arm == "reaching"


def test_a_state_that_the_controller_avoids_decides_nothing(bench: Shadowed) -> None:
    bench.begin()
    bench.hear(BLOCKED)
    bench.controller.can_go = lambda: True  # type: ignore[method-assign]
    withheld = bench.shadow.role._withholding = Shadow(bench.shadow.parts)
    withheld.begin()
    assert "go" not in [name for name, _, _ in bench.wait(0.5)]


def test_data_that_cannot_be_sent_are_told_as_a_failure(bench: Shadowed) -> None:
    bench.begin()
    bench.hear(CLEAR)
    bench.controller.speed = float("nan")
    assert "go" not in [name for name, _, _ in bench.wait(0.1)]
    assert bench.outcomes["failed"] == 1


def test_nothing_is_sent_whatever_happens(bench: Shadowed) -> None:
    bench = Shadowed(stop_command=HALT, on_mismatch="stop", exit_on_stop=True)
    bench.begin()
    bench.hear(1000.0)
    bench.see(ARM)
    bench.shadow.stop("because")
    bench.wait(1.0)
    bench.shadow.close()
    bench.shadow.cycle()
    assert (bench.port.sent, bench.port.cancelled, bench.port.exits) == ([], [], [])


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(st.sampled_from(["clear", "blocked", "beat", "lamp", "arm", "arm fails"]), max_size=20)
)
def test_it_tells_what_the_controller_sends(steps: list[str]) -> None:
    """The same model as a controller, whose commands the shadow sees, and that as an oracle."""
    real, bench = Played(), Shadowed()
    sent: list[Any] = []
    _note(real.port, sent)
    told = bench.begin()
    real.begin()
    told += _seen(bench, sent)
    for number, step in enumerate(steps):
        assert Counter(map(str, told)) == Counter(str(_told(one)) for one in sent)
        sent.clear()
        for engine in (bench.shadow, real.engine):
            _happen(engine, real, step)
        if step == "beat":
            bench.port.time = real.port.time = real.port.time + 0.11
        bench.shadow.cycle()
        told = bench.withheld()
        real.engine.cycle()
        told += _seen(bench, sent)
        assert bench.controller.__dict__ == real.controller.__dict__, (number, step)


def _note(port: PlayedPort, sent: list[Any]) -> None:
    send, cancel = port.send, port.cancel

    def noted(key: str, data: Any) -> None:
        sent.append((key, "request", data))
        send(key, data)

    def cancelled(key: str, token: int) -> None:
        sent.append((key, "cancel", None))
        cancel(key, token)

    port.send, port.cancel = noted, cancelled  # type: ignore[method-assign]


def _told(one: Any) -> Told:
    key, kind, data = one
    return key.split(".")[1], kind, data


def _seen(bench: Shadowed, sent: list[Any]) -> list[Told]:
    return [told for one in sent for told in bench.see(*one)]


def _happen(engine: Any, real: Played, step: str) -> None:
    """What the robot does, as either of them hears it."""
    if step in ("clear", "blocked"):
        engine.post(SENSOR, "response", CLEAR if step == "clear" else BLOCKED)
    elif step != "beat":
        key = LAMP if step == "lamp" else ARM
        kind, payload = ("error", Failure("broken")) if step == "arm fails" else ("response", "on")
        if not (real.controller.lamp_busy if key == LAMP else real.controller.arm != "idle"):
            return
        if engine is real.engine:
            engine.report(key, real.port.tokens[key], kind, payload)
        else:
            engine.role.answer(key, kind, payload)


def test_what_could_not_be_sent_is_told_as_failed(bench: Shadowed) -> None:
    def check(key: str, kind: str, data: Any) -> None:
        if data:
            raise OverflowError("it does not fit")

    bench.port.check = check  # type: ignore[method-assign]
    bench.begin()
    assert "go" not in [name for name, _, _ in bench.hear(CLEAR)]
    assert bench.outcomes["failed"] == 1
