"""What one message of several communications does, and which of several commands goes first."""

from __future__ import annotations

import random
from typing import Any

import pytest
from runtime.lamp_robot import ARM, GO, HALT, LAMP, SENSOR, LampController, PlayedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.model import Command, Communication, Controller, Input
from robosc.runtime.core.settings import Settings

AHEAD, ASTERN, FORWARD, BACKWARD = "Bow.ahead", "Stern.astern", "Motor.forward", "Motor.backward"


class TurnController(Controller):
    """Two conversions of one signed number; each command needs its own sign and not the other."""

    def __init__(self) -> None:
        self.undefined = {}
        self.ahead = self.astern = False

    def read(self, message: Any) -> Any:
        return message

    def on_ahead(self, value: Any) -> None:
        self.ahead = value > 0

    def on_astern(self, value: Any) -> None:
        self.astern = value < 0

    def can_forward(self) -> bool:
        return not self.astern

    def can_backward(self) -> bool:
        return not self.ahead

    COMMUNICATIONS = (
        Communication(AHEAD, "ahead", "outgoing"),
        Communication(ASTERN, "astern", "outgoing"),
        Communication(FORWARD, "forward", "incoming"),
        Communication(BACKWARD, "backward", "incoming"),
    )
    INPUTS = (
        Input(AHEAD, "response", read, on_ahead, ("ahead",)),
        Input(ASTERN, "response", read, on_astern, ("astern",)),
    )
    COMMANDS = (
        Command(FORWARD, "request", can_forward, None, None, None, ("astern",), (), ()),
        Command(BACKWARD, "request", can_backward, None, None, None, ("ahead",), (), ()),
    )
    TAUS = ()


def test_a_message_of_two_communications_is_one_input() -> None:
    port = PlayedPort()
    engine = controller_engine(TurnController(), port, Settings(rate=1000.0))
    engine.begin()
    post = engine.poster([AHEAD, ASTERN])
    post(1)
    engine.cycle()
    port.take()
    chance = random.Random(1)
    for _ in range(2_000):
        value = chance.choice([-1, 1])
        post(value)
        engine.cycle()
        assert set(port.take()) <= {FORWARD if value > 0 else BACKWARD}
        port.time += 0.001
    assert engine.recorder.counters["inputs"] == 4_002


class PreferringController(LampController):
    """The lamp's own robot, which may always halt, but rather goes."""

    def may_halt(self) -> bool:
        return True

    COMMANDS = (
        LampController.COMMANDS[0],
        Command(HALT, "request", may_halt, None, None, None, (), (), (), yields_to=(0,)),
    )


@pytest.mark.parametrize("order", ["rotate", "declared", "random"])
def test_a_command_waits_while_another_one_is_preferred(order: str) -> None:
    port = PlayedPort()
    engine = controller_engine(PreferringController(), port, Settings(order=order))
    engine.begin()
    engine.cycle()
    assert port.take() == [HALT]
    engine.post(SENSOR, "response", 50)
    engine.cycle()
    assert port.take() == [GO]
    for _ in range(20):
        port.time += 0.05
        engine.cycle()
    assert set(port.take()) == {GO}
    engine.post(SENSOR, "response", 1)
    engine.cycle()
    assert port.take() == [HALT], "it has become allowed, so it is due at once"


@pytest.mark.parametrize("order", ["rotate", "declared", "random"])
def test_cancels_go_before_requests(order: str) -> None:
    port = PlayedPort()
    engine = controller_engine(LampController(), port, Settings(order=order, seed=3))
    engine.begin()
    engine.cycle()
    assert ARM in port.take()
    engine.report(LAMP, port.tokens[LAMP], "response", "lit")
    port.time += 0.05
    engine.cycle()
    engine.post(SENSOR, "response", 50)
    port.time += 0.06
    engine.recorder.take()
    engine.cycle()
    done = [(e.kind, e.name) for e in engine.recorder.take() if e.kind in ("request", "cancel")]
    assert done[0] == ("cancel", "reach")
    assert ("request", "go") in done


def test_a_rate_of_its_own() -> None:
    port = PlayedPort()
    engine = controller_engine(LampController(), port, Settings(rate=10.0, rates={HALT: 2.0}))
    engine.begin()
    sent = []
    for _ in range(200):
        engine.cycle()
        sent += port.take()
        port.time += 0.01
    assert 4 <= sent.count(HALT) <= 5
