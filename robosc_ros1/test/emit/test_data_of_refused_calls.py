"""What ``provide c.error`` gives: to errors of the controller, and to calls that it does not take."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from emit.generated_code import controller_class, supervisor_of
from runtime.lamp_robot import PlayedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.settings import Settings
from robosc.runtime.served.waiting_call import WaitingCall

MODEL = """
robot Cart {
    datatype object Wish { data: boolean }
    datatype object Told { success: boolean message: string }
    interface ask use SetBool from std_srvs
    component Orders {
        outgoing service order with request: Wish, response: Told links ask
        outgoing message load with type: integer(0..9)
        behaviour {
            variable load: integer(0..9)
            on response from load do load := value
            initial marked state free { on request from order if value.data goto asked }
            state asked { on error to order if load > 0 goto free }
        }
    }
    provide order.error with { message: "full" } if Orders.load > 5
    provide order.error with { message: "busy" } if Orders.load > 0
}
"""


class Call(WaitingCall):
    def __init__(self) -> None:
        self.told: list[tuple[str, Any]] = []

    def refuse(self, text: str, data: Any = None) -> None:
        self.told.append((text, data))


def test_the_data_are_those_of_the_state_in_which_the_call_ends() -> None:
    model = MODEL.replace("boolean message", "boolean\n message")
    controller = controller_class(supervisor_of(model))[0]()
    engine = controller_engine(controller, PlayedPort(), Settings())
    engine.begin()

    def call(data: bool) -> Call:
        made = Call()
        engine.serve("Orders.order", SimpleNamespace(data=data), made)
        engine.cycle()
        return made

    def load(number: int) -> None:
        engine.post("Orders.load", "response", SimpleNamespace(data=number))
        engine.cycle()

    ((text, data),) = call(False).told  # no statement applies
    assert "order is taken where" in text and data is None
    waiting = call(True)
    assert waiting.told == []
    load(3)
    assert waiting.told == [("order failed: Orders is in asked", {"message": "busy"})]
    load(9)
    assert call(False).told[0][1] == {"message": "full"}


UNUSABLE = """
robot Cart {
    datatype object Wish { speed: double }
    datatype object Told { success: boolean }
    interface ask use Drive from carts
    component Orders {
        outgoing service order with request: Wish, response: Told links ask
        incoming message drive with type: double
        behaviour {
            variable speed: double
            initial marked state free { on request from order do speed := value.speed goto asked }
            state asked { on request to drive goto done }
            state done { on response to order goto free }
        }
    }
    provide drive with Orders.speed
}
"""


def test_a_call_with_a_number_that_cannot_be_sent_is_refused_and_jams_nothing() -> None:
    port = PlayedPort()
    engine = controller_engine(controller_class(supervisor_of(UNUSABLE))[0](), port, Settings())
    engine.begin()
    calls = []
    for number in (float("nan"), float("inf"), 1.0):
        calls.append(Call())
        engine.serve("Orders.order", SimpleNamespace(speed=number), calls[-1])
        engine.cycle()
    refused = [text for call in calls for text, _ in call.told]
    assert refused == [f"its data cannot be used: speed is {number}" for number in ("nan", "inf")]
    assert port.sent == [("Orders.drive", {"data": 1.0})]
