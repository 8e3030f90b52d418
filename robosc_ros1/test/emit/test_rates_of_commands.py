"""How often commands are sent: at the rate that the model says, or once."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from runtime.lamp_robot import PlayedPort

from robosc.emit.package.config import declared_communications
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import read

MODEL = """
robot House {
    component Lamp {
        incoming message light with identifier: "/light", rate: once, type: integer
        incoming message beat with rate: 20 Hz, identifier: "/beat", type: none
        service store with rate: once, request: integer, response: none links store_it
        outgoing message key with identifier: "/key", type: integer(0..9)
        outgoing message door with identifier: "/door", type: boolean
        behaviour {
            variable level: integer(0..9) = 0
            variable open: boolean = false
            on response from key do level := value
            on response from door do open := value
            initial marked state only {}
        }
    }
    component Bell {
        incoming message ring with identifier: "/ring", rate: once, type: none
        behaviour {
            initial marked state ringing performs ring then goto ringing
        }
    }
    interface store_it use Store from house_msgs
    provide light with Lamp.level
    provide store with Lamp.level
    requirement light needs !Lamp.open
    requirement store needs !Lamp.open
}
"""


class Played:
    """The controller of the model on a port; ``sent`` has what it sent, by name."""

    def __init__(self, **given: float) -> None:
        supervisor = supervisor_of(MODEL)
        communications = declared_communications(supervisor.plant.robot)
        rates = {name.replace("_", "/"): value for name, value in given.items()}
        settings, _ = read(communications, rates)
        self.port = PlayedPort()
        self.engine = controller_engine(controller_class(supervisor)[0](), self.port, settings)
        self.engine.begin()
        self.engine.cycle()

    def sent(self, name: str) -> list[Any]:
        """What the port got since the last call; a basic type is a field of its message."""
        found = [data for key, data in self.port.sent if key.endswith(f".{name}")]
        self.port.sent.clear()
        return [next(iter(data.values())) if data else None for data in found]

    def wait(self, seconds: float) -> None:
        end = self.port.time + seconds
        while self.port.time < end - 1e-9:
            self.port.time = min(end, self.port.time + 0.01)
            self.engine.cycle()

    def hear(self, name: str, value: Any) -> None:
        self.engine.poster([f"Lamp.{name}"])(SimpleNamespace(data=value))
        self.engine.cycle()

    def end(self, kind: str) -> None:
        payload = SimpleNamespace() if kind == "response" else "broken"
        self.engine.report("Lamp.store", self.port.tokens["Lamp.store"], kind, payload)
        self.engine.cycle()


def test_once_is_when_it_becomes_allowed() -> None:
    played = Played()
    assert played.sent("light") == [0]
    played.wait(5.0)
    assert played.sent("light") == []
    played.hear("door", True)
    played.hear("door", False)
    assert played.sent("light") == [0]


def test_once_is_also_when_the_data_have_changed_at_most_at_its_rate() -> None:
    played = Played(rate_light=2.0)
    played.sent("light")
    played.hear("key", 3)
    played.hear("key", 4)
    played.wait(0.4)
    assert played.sent("light") == []
    played.wait(0.2)
    assert played.sent("light") == [4]
    played.wait(3.0)
    played.hear("key", 4)
    assert played.sent("light") == []
    played.hear("key", 5)
    assert played.sent("light") == [5]


def test_data_that_change_back_before_they_are_due_are_not_sent() -> None:
    played = Played(rate_light=1.0)
    played.sent("light")
    played.hear("key", 3)
    played.hear("key", 0)
    played.wait(3.0)
    assert played.sent("light") == []


@pytest.mark.parametrize(("end", "again"), [("response", []), ("error", [0])])
def test_only_an_error_makes_a_request_due_again_on_its_beat(end: str, again: list[int]) -> None:
    played = Played(rate_store=1.0)
    assert played.sent("store") == [0]
    played.end(end)
    played.wait(0.9)
    assert played.sent("store") == []
    played.wait(0.2)
    assert played.sent("store") == again


def test_a_state_that_performs_a_command_sends_it_whenever_it_begins() -> None:
    played = Played()
    played.wait(1.0)
    assert 9 <= len(played.sent("ring")) <= 11


@pytest.mark.parametrize(("given", "most"), [({}, 20), ({"rate_beat": 5.0}, 5)])
def test_the_rate_of_a_command_is_that_of_the_model_or_the_parameter(
    given: dict[str, float], most: int
) -> None:
    played = Played(**given)
    played.sent("beat")
    played.wait(1.0)
    assert most - 1 <= len(played.sent("beat")) <= most
