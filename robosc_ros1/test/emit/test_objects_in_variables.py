"""Variables that are objects or arrays: stored as they came, read in part, sent as a whole."""

from __future__ import annotations

import array
import json
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from emit.scripted_controllers import faults_of
from runtime.lamp_robot import PlayedPort
from runtime.schemas import validate
from simulate.players import session

from robosc.emit.package.model_document import model_document
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.telemetry import dump, event_document, state_document
from robosc.runtime.core.values import NOW, fields_of, jsonable, not_finite
from robosc.simulate.script.documents import done_document

MODEL = """
robot Courier {
    interface links use Place from nowhere_msgs
    datatype object Place { x: double name: string }
    datatype object Order { to: Place weight: double }
    component Operator {
        outgoing message place with type: Place links links
        behaviour {
            variable goal: Place
            initial marked state on { on response from place do goal := value }
        }
    }
    component Base {
        incoming message drive with type: Order links links
        incoming message point with type: Place links links
    }
    requirement drive needs !(Operator.goal.x < 0)
    provide drive with { to: Operator.goal, weight: Operator.goal.x * 2 }
    provide point with Operator.goal
}
"""


class Played:
    """A controller at work, on messages that are given to it."""

    def __init__(self) -> None:
        self.port = PlayedPort()
        made, _ = controller_class(supervisor_of(MODEL))
        self.engine = controller_engine(made(), self.port, steady=lambda: self.port.time)
        self.engine.begin()
        self.engine.cycle()

    def place(self, **fields: Any) -> SimpleNamespace:
        message = SimpleNamespace(**fields)
        self.port.time += 1
        self.engine.post("Operator.place", "response", message)
        self.engine.cycle()
        return message

    def outcomes(self, name: str) -> list[Any]:
        return [(e.outcome, e.value) for e in self.engine.recorder.take() if e.name == name]


def test_nothing_is_sent_before_anything_has_come() -> None:
    played = Played()
    (entry,) = (e for e in played.engine.recorder.take() if e.name == "point")
    assert entry.outcome == "failed"
    assert entry.detail == "some of its data has not arrived yet"
    assert played.engine.recorder.counters["failed"] == 1
    assert state_document(played.engine.snapshot(), [])["variables"] == {"Operator.goal": None}


def test_a_condition_on_what_is_not_there_does_not_hold() -> None:
    played = Played()
    assert not any(e.name == "drive" for e in played.engine.recorder.take())
    played.place(x=1.0, name="shelf")
    assert played.outcomes("drive") != []


def test_what_came_is_sent_as_a_whole_and_in_part() -> None:
    played = Played()
    played.outcomes("")
    message = played.place(x=1.5, name="shelf")
    sent = {e.name: e.value for e in played.engine.recorder.take() if e.outcome == "applied"}
    assert sent["drive"] == {"to": message, "weight": 3.0}
    assert sent["point"] == message
    # Whoever sends it may change it, as rospy numbers headers.
    sent["point"].name = "changed"
    assert message.name == "shelf"


def test_documents_with_objects_follow_their_schemas() -> None:
    played = Played()
    for _ in range(2):
        validate(json.loads(dump(state_document(played.engine.snapshot(), []))), "state")
        for entry in played.engine.recorder.take():
            validate(json.loads(dump(event_document(entry))), "event")
        played.place(x=1.5, name="shelf")
    supervisor = supervisor_of(MODEL)
    validate(json.loads(json.dumps(model_document(supervisor, "model.rscd"))), "model")
    player = session(supervisor)
    for number, line in enumerate(("expect disabled drive", "place x: 0.75", "drive"), 1):
        done = done_document(player, number, player.do(line))
        validate(json.loads(dump(done)), "simulate")


def test_what_came_last_counts() -> None:
    played = Played()
    played.place(x=1.5, name="shelf")
    played.place(x=-1.0, name="door")
    played.outcomes("")
    played.place(x=-2.0, name="gate")
    events = played.engine.recorder.take()
    assert not any(e.name == "drive" for e in events)
    assert [e.value.name for e in events if e.name == "point"] == ["gate"]


def test_the_test_of_the_package_knows_objects() -> None:
    assert faults_of(supervisor_of(MODEL)) == []


def test_arrays_of_any_kind_are_told_and_checked_as_lists() -> None:
    numbers = array.array("d", [0.5, float("inf")])
    assert jsonable({"a": numbers, "b": b"\x01\x02"}) == {"a": [0.5, "Infinity"], "b": [1, 2]}
    assert not_finite(SimpleNamespace(a=array.array("d", [0.5]), b=b"\x01", c="text")) is None
    assert not_finite({"goal": SimpleNamespace(a=numbers)}) == "goal.a[1] is inf"


class Signal:
    """A message of ROS 1 without fields, such as std_msgs/Empty."""

    __slots__ = ()


def test_a_message_without_fields_has_no_parts() -> None:
    assert jsonable({"a": Signal()}) == {"a": {}}
    assert not_finite(Signal()) is None
    assert fields_of(Signal(), ["data"]) == []


def test_a_message_of_another_type_gives_the_fields_that_both_have() -> None:
    data = SimpleNamespace(x=1.0, name="shelf")
    assert fields_of(data, ["_x", "_y"]) == [("x", 1.0)]
    assert fields_of({"x": 2.0}, ["_x"]) == [("x", 2.0)]
    assert fields_of(None, ["_x"]) == []


TIMED = """
robot Timed {
    constant spot: geometry_msgs/Point = { x: 1, y: 2.5 }
    component Base {
        incoming message go with type: geometry_msgs/PoseStamped
    }
    provide go with { header: { stamp: now() }, pose: { position: spot } }
}
"""


@pytest.mark.ros
def test_constants_and_the_time_of_sending_are_sent() -> None:
    made, _ = controller_class(supervisor_of(TIMED))
    data = made().data_for_go()
    assert data == {"header": {"stamp": NOW}, "pose": {"position": {"x": 1.0, "y": 2.5}}}
    assert data["header"]["stamp"] is NOW
    assert json.loads(json.dumps(jsonable(data)))["header"] == {"stamp": "now()"}


def test_a_parameter_makes_nothing_known_of_what_is_not_there() -> None:
    """Whatever the limit, a comparison with an order that has not come does not hold."""
    text = MODEL.replace("!(Operator.goal.x < 0)", "Operator.goal.x < limit").replace(
        "robot Courier {",
        "robot Courier { parameter limit: double = 2.0 requirement point needs Operator.goal.x > 0",
    )
    supervisor = supervisor_of(text)
    (test,) = (v for v in supervisor.plant.variables if "limit" in v.name)
    assert [test.values[i] for i in test.start_indexes] == [False]
    assert "nothing-to-send" not in [d.code for d in supervisor.diagnostics]
