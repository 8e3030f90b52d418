"""``/state`` as the original publishes it, for its tools."""

from __future__ import annotations

from typing import Any

from emit.generated_code import supervisor_of

from robosc.emit.package.model_document import model_document
from robosc.runtime.core.original_state import OriginalState

MODEL = """
robot Cart {
    datatype enum Level from integer to { value > 5 -> high default -> low }
    component Sensor {
        outgoing message level with identifier: "/level", type: Level
        behaviour {
            variable seen: Level
            variable speed: double = 0.5
            variable moving: boolean
            on response from level do seen := value goto near
            initial marked state far { transition if seen = high goto near }
            marked state near { on response from level if value = low goto far }
        }
    }
    component Arm {
        action reach with request: none, response: none, feedback: none links Reach
        service ask with request: none, response: none links Ask
        incoming message beep with type: none
    }
    interface Reach use Reach from arm_msgs
    interface Ask use Ask from arm_msgs
}
"""
TAU = {"next": "near", "id": "component_Sensor_c_tau1_", "type": "tau", "communication": None}
LEVEL = {"id": "message_level_u_response_", "type": "response", "communication": "level"}


def original() -> OriginalState:
    return OriginalState(model_document(supervisor_of(MODEL), "cart.rscd"))


def state(**more: Any) -> dict[str, Any]:
    variables = {"Sensor.seen": "high", "Sensor.speed": 0.5, "Sensor.moving": True}
    return {"components": {"Sensor": "near"}, "variables": variables | more}


def event(kind: str, name: str, outcome: str = "applied", index: int = 0) -> dict[str, Any]:
    return {"event": {"kind": kind, "name": name, "index": index}, "outcome": outcome}


def test_the_layout_is_that_of_the_original() -> None:
    told = original()
    assert told.document(state()) == {
        "current": {
            "Sensor": {
                "state": "near",
                "variables": {"seen": "high", "speed": "0.5", "moving": "true"},
            }
        },
        "transitions": [],
        "definition": {
            "name": "Cart",
            "components": [
                {
                    "name": "Sensor",
                    "messages": ["level"],
                    "services": [],
                    "actions": [],
                    "behaviour": {
                        "variables": ["seen", "speed", "moving"],
                        "states": [
                            {
                                "name": "far",
                                "initial": True,
                                "transitions": [
                                    TAU,
                                    {"next": "near", **LEVEL},
                                ],
                            },
                            {
                                "name": "near",
                                "initial": False,
                                # The transition of the whole automaton is hidden here.
                                "transitions": [{"next": "far", **LEVEL}],
                            },
                        ],
                    },
                },
                {"name": "Arm", "messages": ["beep"], "services": ["ask"], "actions": ["reach"]},
            ],
        },
    }


def test_each_transition_is_told_once() -> None:
    told = original()
    told.take([event("request", "reach"), event("feedback", "reach"), event("cancel", "reach")])
    told.take([event("response", "ask", "mismatch"), event("error", "ask")])
    told.take([event("tau", "Sensor", index=1), event("request", "beep")])
    assert told.document(state())["transitions"] == [
        "action_reach.c_trigger", "action_reach.u_feedback", "action_reach.c_cancel",
        "service_ask.u_error", "component_Sensor.c_tau1", "message_beep.c_trigger",
    ]  # fmt: skip
    assert told.document(state())["transitions"] == []


def test_values_that_are_no_plain_ones_are_not_told() -> None:
    variables = original().document(state(**{"Sensor.speed": {"x": 1.0}}))["current"]["Sensor"]
    assert variables["variables"]["speed"] == "unknown"


def test_timeouts_are_told_beside_the_others() -> None:
    told = original()
    told.take([event("timeout", "level")])
    assert told.document(state())["transitions"] == ["message_level.u_timeout"]
