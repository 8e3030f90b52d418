"""The state as messages of standard types, for tools that plot topics."""

from __future__ import annotations

import pytest
from emit.generated_code import controller_class, supervisor_of

from robosc.emit.package.model_document import model_document
from robosc.runtime.core.telemetry import ValueTopics, topic_of

MODEL = """
robot Depot {
    interface scan use Scan from depot_interfaces
    datatype enum Light from integer to { value > 5 -> bright default -> dark }
    datatype object Point { x: double }
    datatype object Scan {
        ranges: array(double)
        on: boolean
        at: Point
    }
    component Wheel[1..2] {
        outgoing message turns with type: integer
        behaviour {
            variable count: integer
            initial marked state still { on response from turns do count := value goto turning }
            state turning { on response from turns do count := value goto still }
        }
    }
    component Eye {
        outgoing message light with type: Light
        outgoing message scan with type: Scan links scan
        behaviour {
            variable seen: Light = dark
            variable ranges: array(double)
            variable on: boolean
            variable at: Point
            variable near: double
            initial marked state open {
                on response from light do seen := value
                on response from scan
                    do ranges := value.ranges, on := value.on, at := value.at, near := value.at.x
            }
        }
    }
}
"""


def test_each_value_has_its_type() -> None:
    supervisor = supervisor_of(MODEL)
    controller = controller_class(supervisor)[0]()
    topics = ValueTopics(model_document(supervisor, "depot.rscd"))
    controller.wheel_2_count = -7
    assert "Eye/ranges" not in [m.topic for m in topics.messages(controller)]  # not heard yet
    controller.eye_ranges = [0.5, 2]
    found = {m.topic: (m.type, m.data) for m in topics.messages(controller)}
    assert found == {
        "wheel_1": ("Int32", 0),
        "wheel_2": ("Int32", 0),
        "wheel_1/count": ("Int64", 0),
        "wheel_2/count": ("Int64", -7),
        "Eye": ("Int32", 0),
        "Eye/seen": ("String", "dark"),
        "Eye/ranges": ("Float64MultiArray", [0.5, 2.0]),
        "Eye/on": ("Bool", False),
        "Eye/near": ("Float64", 0.0),
    }


def test_integers_that_no_message_can_have_are_left_out() -> None:
    supervisor = supervisor_of(MODEL)
    controller = controller_class(supervisor)[0]()
    topics = ValueTopics(model_document(supervisor, "depot.rscd"))
    controller.wheel_1_count = 2**63
    assert "wheel_1/count" not in [m.topic for m in topics.messages(controller)]


@pytest.mark.parametrize(
    ("name", "topic"),
    [("Heater", "Heater"), ("Sensor.degrees", "Sensor/degrees"), ("Dock[3].n", "dock_3/n")],
)
def test_topics(name: str, topic: str) -> None:
    assert topic_of(name) == topic
