"""Which commands would go on with the last value of a message that has fallen silent."""

from __future__ import annotations

import pytest
from model_text import faults

from robosc.model.resolve import load
from robosc.source import Source

STALE = [("stale-data", "Eye.free")]


def told(
    message: str = "",
    reaction: str = "on response from scan do free := value",
    requirement: str = "go needs Eye.free",
    more: str = "",
) -> list[tuple[str, str]]:
    """The warning, for a robot whose command rests on what a sensor said."""
    found = faults(f"""
    component Eye {{
        outgoing message scan with {message} type: boolean
        outgoing message button with type: none
        behaviour {{
            variable free: boolean
            {reaction}
            initial marked state on {{ on response from button goto on }}
        }}
    }}
    component Base {{ incoming message go with type: none }}
    requirement {requirement}
    {more}
    """)
    return [f for f in found if f[0] == "stale-data"]


def test_a_requirement_on_data_of_a_message_without_timeout_is_told() -> None:
    assert told() == STALE


def test_a_timeout_mends_it() -> None:
    assert told(message="timeout: 1 s,") == []


@pytest.mark.parametrize(
    "more",
    [
        "component Ear { outgoing message ping with timeout: 1 s, type: none }"
        " requirement go needs ping.fresh",
        "component Ear { outgoing message ping with timeout: 1 s, type: none }"
        " condition safe = !ping.silent requirement go needs safe",
    ],
)
def test_any_freshness_that_the_command_needs_mends_it(more: str) -> None:
    assert told(more=more) == []


def test_data_of_the_command_count_like_its_requirements() -> None:
    text = """
    component Eye {
        outgoing message scan with type: double
        behaviour {
            variable speed: double
            initial marked state on { on response from scan do speed := value }
        }
    }
    component Base { incoming message go with type: double }
    provide go with Eye.speed
    """
    assert ("stale-data", "Eye.speed") in faults(text)
    mended = text + "component Ear { outgoing message ping with timeout: 1 s, type: none } "
    assert ("stale-data", "Eye.speed") in faults(mended)
    assert ("stale-data", "Eye.speed") not in faults(mended + "requirement go needs ping.fresh")


@pytest.mark.parametrize(
    "reaction",
    [
        "on response from button do free := true",
        "on response from scan if value do free := true on response from scan if !value do free := false",
        "on response from scan do free := value on request to go do free := false",
    ],
)
def test_events_and_what_others_set_as_well_do_not_count(reaction: str) -> None:
    assert told(reaction=reaction) == []


def test_each_message_is_told_once_with_all_commands() -> None:
    more = (
        "component Arm { incoming message halt with type: none } requirement halt needs !Eye.free"
    )
    assert told(more=more) == STALE


@pytest.mark.parametrize(("others", "end"), [("b", ", and so does b"), ("b c", ", and so do b, c")])
def test_the_other_commands_are_told_in_one_sentence(others: str, end: str) -> None:
    commands = ["a", *others.split()]
    text = f"""robot R {{
        component Eye {{
            outgoing message scan with type: boolean
            behaviour {{
                variable free: boolean
                initial marked state on {{ on response from scan do free := value }}
            }}
        }}
        component Base {{ {" ".join(f"incoming message {c} with type: none" for c in commands)} }}
        requirement {{ {", ".join(commands)} }} needs Eye.free
    }}"""
    _, diagnostics = load(Source("m.rscd", text))
    (found,) = (d for d in diagnostics if d.code == "stale-data")
    assert found.message.endswith(f"if scan falls silent{end}")


def test_copies_are_told_once() -> None:
    text = """
    component Eye[1..3] {
        outgoing message scan with identifier: "/scan{index}", type: boolean
        behaviour {
            variable free: boolean
            initial marked state on { on response from scan do free := value }
        }
    }
    component Base[1..3] { incoming message go with identifier: "/go{index}", type: none }
    for i in 1..3 { requirement Base[i].go needs Eye[i].free }
    """
    assert [f[1] for f in faults(text) if f[0] == "stale-data"] == ["Eye[i].free"]


ORDERS = """
    component Desk {
        outgoing message order with type: double
        outgoing message again with type: none
        behaviour {
            variable place: double
            on response from order do place := value goto waiting
            %s
            initial marked state content {}
            marked state waiting { on request to go goto content }
        }
    }
    component Base {
        incoming message go with type: double
    }
    provide go with Desk.place
    stop with go
"""


def test_an_order_that_is_used_up_is_no_stale_value() -> None:
    assert faults(ORDERS % "") == []


def test_an_order_that_is_repeated_without_a_message_is_one() -> None:
    again = "on response from again goto waiting"
    assert ("stale-data", "Desk.place") in faults(ORDERS % again)
