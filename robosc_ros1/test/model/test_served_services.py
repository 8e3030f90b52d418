"""Services that the controller serves: names, types and data of what is received and sent."""

from __future__ import annotations

import pytest
from model_text import faults

_BESIDE = ("package-not-found", "unused-datatype")
ORDERS = """
    datatype object Wish {{ n: integer }}
    datatype enum Size from integer to {{ value > 3 -> big default -> small }}
    interface ask use Ask from nowhere_msgs
    component Orders {{
        outgoing service order with request: {request}, response: {response} links ask
        incoming message go with type: none
        behaviour {{
            variable size: {size}
            initial marked state free {{
                on request from order{effect} goto asked
            }}
            state asked {{
                on response to order goto free
                on error to order goto free
            }}
        }}
    }}
    requirement go needs Orders.size {compared}
    {more}
"""


def codes(
    more: str = "",
    request: str = "integer(0..9)",
    response: str = "none",
    size: str = "integer(0..9)",
    effect: str = " do size := value",
    compared: str = "> 1",
) -> list[str]:
    text = ORDERS.format(
        more=more, request=request, response=response, size=size, effect=effect, compared=compared
    )
    return [code for code, _ in faults(text) if code not in _BESIDE]


def test_a_request_has_a_value() -> None:
    assert codes() == []


def test_an_enum_converts_what_is_received() -> None:
    assert codes(request="Size", size="Size", compared="= big") == []
    assert codes(response="Size") == ["enum-sent"]


def test_an_answer_is_given_data() -> None:
    assert codes("provide order with { n: 3 }", response="Wish") == []
    assert codes("provide order.response with { n: 3 }", response="Wish") == []
    assert codes('provide order with { n: "much" }', response="Wish") == ["type-mismatch"]
    assert codes("provide order with { n: 3 }") == ["nothing-to-provide"]
    assert codes("provide order.error with { n: 3 }", response="Wish") == []
    assert codes('provide order.error with { n: "much" }', response="Wish") == ["type-mismatch"]
    assert codes("provide order.error with { n: 3 }") == ["nothing-to-provide"]


def test_requirements_on_an_answer() -> None:
    assert codes("requirement order needs Orders.size > 1") == []
    assert codes("requirement Orders.order.response needs Orders.size > 1") == []
    assert codes("requirement order.error needs Orders.size > 1") == ["error-is-free"]
    assert codes("prefer order over go") == []
    assert codes("prefer go over order.error") == ["error-is-free"]


def test_groups_never_mean_answers() -> None:
    assert codes("requirement all needs order.busy") == []
    assert codes("prefer order over all") == []


def test_its_phases_are_conditions() -> None:
    assert codes("requirement go needs order.busy or order.idle") == []
    assert codes("requirement go needs order.fresh") == ["unknown-name"]


@pytest.mark.parametrize("event", ["cancel", "feedback", "timeout"])
def test_a_service_has_no_other_events(event: str) -> None:
    assert codes(effect=f" do size := value\n on {event} from order") == ["event-not-available"]


def test_an_answer_carries_no_received_value() -> None:
    text = ORDERS.format(
        more="",
        request="none",
        response="none",
        size="integer(0..9)",
        effect=" do size := value",
        compared="> 1",
    )
    assert "value-not-allowed" in [code for code, _ in faults(text)]
