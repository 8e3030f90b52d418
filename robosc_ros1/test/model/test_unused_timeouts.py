"""Which timeouts of messages change nothing."""

from __future__ import annotations

import pytest
from model_text import faults

UNUSED = [("unused-timeout", "1 s")]


def told(eye: str = "", robot: str = "", name: str = "Eye") -> list[tuple[str, str]]:
    """The warning, for a robot that hears a message with a timeout."""
    found = faults(f"""
    component {name} {{
        outgoing message scan with timeout: 1 s, type: none
        behaviour {{ {eye} initial marked state on {{}} }}
    }}
    component Base {{ incoming message go with type: none }}
    {robot}
    """)
    return [f for f in found if f[0] == "unused-timeout"]


def test_a_timeout_that_nothing_notices_is_told() -> None:
    assert told() == UNUSED
    assert told(eye="on response from scan goto on") == UNUSED


@pytest.mark.parametrize(
    "robot",
    [
        "requirement go needs scan.fresh",
        "requirement scan.silent disables go",
        "condition dark = scan.silent requirement dark disables go",
        "provide go with {} if scan.fresh",
    ],
)
def test_whatever_reads_the_freshness_uses_it(robot: str) -> None:
    assert told(robot=robot) == []


def test_a_transition_on_it_uses_it() -> None:
    assert told(eye="on timeout from scan goto on") == []


def test_a_condition_that_nothing_reads_does_not_use_it() -> None:
    assert told(robot="condition dark = scan.silent") == UNUSED


def test_copies_are_told_once_and_one_of_them_is_enough() -> None:
    assert told(name="Eye[1..3]") == UNUSED
    assert told(name="Eye[1..3]", robot="requirement go needs Eye[2].scan.fresh") == []


def test_the_timeout_of_a_service_is_its_deadline() -> None:
    assert (
        told(
            robot="""
        interface empty use Empty from std_srvs
        component Lamp { service blink with timeout: 2 s, request: none, response: none links empty }
    """
        )
        == UNUSED
    )
