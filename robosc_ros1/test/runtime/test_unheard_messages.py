"""A message that changes what the node does next is not sent while nobody hears it."""

from __future__ import annotations

from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from runtime.lamp_robot import PlayedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import state_document

MODEL = """
robot Walker {
    component Legs {
        incoming message goal with type: integer
        incoming message lamp with rate: once, type: boolean
        incoming message step with type: none
        incoming message rest with type: none
        outgoing message arrived with type: none
        behaviour {
            variable next: integer
            initial marked state here { on request to goal goto walking }
            marked state walking { on response from arrived do next := next + 1 goto here }
        }
    }
    prefer goal over rest
    provide goal with Legs.next
    provide lamp with true
    stop with goal
}
"""


class Topics(PlayedPort):
    def __init__(self) -> None:
        super().__init__()
        self.heard = {"Legs.step", "Legs.rest"}

    def is_heard(self, key: str) -> bool:
        return key in self.heard


@pytest.fixture
def port() -> Topics:
    return Topics()


@pytest.fixture
def engine(port: Topics) -> Any:
    controller, _ = controller_class(supervisor_of(MODEL))
    engine = controller_engine(controller(), port, Settings(stop_command="goal"), port.now)
    engine.begin()
    engine.cycle()
    return engine


def later(engine: Any, port: Topics) -> set[str]:
    """What is sent within a beat."""
    port.take()
    for _ in range(11):
        port.time += 0.01
        engine.cycle()
    return set(port.take())


def test_it_waits_on_its_beat_until_somebody_hears_it(engine: Any, port: Topics) -> None:
    """What is only repeated goes out, and so does what would yield to it."""
    assert later(engine, port) == {"Legs.step", "Legs.rest"}
    assert engine.parts.controller.components()["Legs"] == "here"
    assert engine.recorder.counters["failed"] > 0
    port.heard |= {"Legs.goal", "Legs.lamp"}
    assert later(engine, port) == {"Legs.step", "Legs.rest", "Legs.goal", "Legs.lamp"}
    assert engine.parts.controller.components()["Legs"] == "walking"
    assert later(engine, port) == {"Legs.step", "Legs.rest"}


def test_the_state_tells_why(engine: Any, port: Topics) -> None:
    later(engine, port)
    document = state_document(engine.snapshot(), [])
    reasons = {c["event"]["name"]: c["blocked_by"] for c in document["commands"]}
    unheard = [{"kind": "data", "text": "nobody subscribes to its topic"}]
    assert reasons == {"goal": unheard, "lamp": unheard, "step": [], "rest": []}


def test_a_stop_that_nobody_hears_has_not_happened(engine: Any, port: Topics) -> None:
    engine.close()
    engine.cycle()
    assert engine.parts.controller.components()["Legs"] == "here"
    assert "nobody subscribes" in port.logs[-1][1]
