"""What comes of a call, by the documents that a node tells of it."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest
from emit.generated_code import supervisor_of

from robosc.agents import running
from robosc.agents.calls import CallWatch
from robosc.agents.running import End, Running
from robosc.agents.simulated import Simulated
from robosc.agents.tools import Tool, tools
from robosc.simulate.start import machine_maker
from robosc.view.hub import Hub
from robosc.view.listening import Heard

MODEL = """robot Door {
    interface lock use SetBool from std_srvs
    datatype object Wanted { data: boolean }
    component Door {
        outgoing message free with type: boolean
        incoming message speed with type: double
        service lock with request: Wanted, response: none links lock
        behaviour {
            variable is_free: boolean
            on response from free do is_free := value
            initial marked state open {
                on request to speed
                on request to lock goto busy
            }
            state busy { on request to speed on response, error from lock goto open }
        }
    }
    requirement lock needs Door.is_free
    stop with nothing
}"""


def told(kind: str, name: str, value: Any = None, **more: Any) -> str:
    event = {"kind": kind, "name": name, "value": value}
    more = more if "blocked_by" in more else {"outcome": "applied", **more}
    return json.dumps({"version": 1, "event": event, **more})


class Told:
    """A caller whose node tells these documents before it answers."""

    def __init__(self, hub: Hub, documents: list[str], end: End) -> None:
        self._documents, self._end = documents, end
        self.heard = Heard("/door", hub)

    def publish(self, topic: str, data: Any) -> None:
        for document in self._documents:
            self.heard.blocked(document)
            self.heard.event(document)

    def call(self, name: str, type_: str, data: Any, told: Any) -> End:
        self.publish(name, data)
        return self._end

    goal = call

    def close(self) -> None:
        """Nothing goes on."""


@pytest.fixture(scope="module")
def offered() -> dict[str, Tool]:
    robot = supervisor_of(MODEL, supervises=True).plant.robot
    return {tool.name: tool for tool in tools(robot)}


LIMITED = """robot Limited {
    component Base {
        parameter most: double = 1.0
        incoming message drive with identifier: "/drive", type: double
        behaviour { initial marked state on {} }
    }
    requirement drive needs value <= Base.most
    stop with nothing
}"""


def test_what_if_of_a_node_is_with_its_parameters() -> None:
    supervisor = supervisor_of(LIMITED, supervises=True)
    make = machine_maker(supervisor, execute=True)
    hub = Hub()
    caller = Told(hub, [], ("answered", {}))
    node = Running(caller, hub, make, guarded=True)  # type: ignore[arg-type]
    (drive,) = tools(supervisor.plant.robot)
    state = Simulated(make, {}).state()
    for most, outcome in ((1.0, "blocked"), (3.0, "sent")):
        told_ = {**state, "version": 1, "parameters": {"Base/most": most}}
        caller.heard.state(json.dumps(told_))
        found = node.what_if([(drive, {"value": 2.0})])
        assert found["results"][0]["outcome"] == outcome
        assert "requirement drive needs value <= Base.most" in node.why(drive)


def ask(
    tool: Tool, arguments: dict[str, Any], documents: list[str], end: End = ("answered", {})
) -> dict[str, Any]:
    hub = Hub()
    caller = Told(hub, documents, end)
    node = Running(caller, hub, lambda given: None, guarded=True)  # type: ignore[arg-type, return-value]
    found: dict[str, Any] = node.ask(tool, arguments, CallWatch())
    return found


STRANGE = [
    '{"version": 1, "outcome": "applied", "event": 3}',
    '{"version": 1, "outcome": "applied", "event": {"kind": [], "name": {}}}',
    '{"version": 1, "blocked_by": [], "event": null}',
    "[",
]
PASSED = told("request", "lock", {"data": True})
BLOCKED = told("request", "lock", {"data": True}, blocked_by=[{"kind": "requirement", "text": "R"}])


@pytest.mark.parametrize(
    ("documents", "outcome"),
    [
        ([PASSED, told("response", "lock")], "answered"),
        ([PASSED, told("error", "lock", detail="lost")], "failed"),
        ([BLOCKED], "blocked"),
        ([told("request", "lock", {"data": True}, outcome="refused")], "refused"),
        ([told("request", "lock", {"data": True}, outcome="failed")], "failed"),
        # What others called before, and still hear of, says nothing of this call.
        ([told("response", "lock"), BLOCKED], "blocked"),
        ([told("error", "lock"), PASSED, told("response", "lock")], "answered"),
        ([told("request", "lock", {"data": False}), told("response", "lock"), BLOCKED], "blocked"),
        # What no node tells.
        ([*STRANGE, PASSED, *STRANGE, told("response", "lock")], "answered"),
    ],
)
def test_a_service_that_always_answers(
    offered: dict[str, Tool], documents: list[str], outcome: str
) -> None:
    assert ask(offered["lock"], {"data": True}, documents)["outcome"] == outcome


@pytest.mark.parametrize("documents", [[], [PASSED], [told("response", "lock")]])
def test_nobody_knows_what_a_silent_node_made_of_it(
    offered: dict[str, Tool], documents: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "_VERDICT", 0.0)
    assert ask(offered["lock"], {"data": True}, documents)["outcome"] == "unknown"


@pytest.mark.parametrize("speed", [0.1, 12.5, 1e-8, -3.3e7, 0.0])
def test_a_number_of_32_bits_is_what_was_sent(offered: dict[str, Tool], speed: float) -> None:
    (arrived,) = struct.unpack("f", struct.pack("f", speed))
    document = told("request", "speed", {"value": arrived})
    assert ask(offered["speed"], {"value": speed}, [document])["outcome"] == "sent"


def test_another_number_is_another_s(
    offered: dict[str, Tool], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "_VERDICT", 0.0)
    document = told("request", "speed", {"value": 0.2})
    assert ask(offered["speed"], {"value": 0.1}, [document])["outcome"] == "unknown"
