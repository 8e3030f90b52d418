"""Requirements; see ``clauses.py``."""

from __future__ import annotations

import pytest
from synthesis.clauses import controlled, same
from synthesis.subject import SUBJECTS, Subject

pytestmark = pytest.mark.parametrize("subject", SUBJECTS, ids=lambda s: s.__name__)


DOOR = """
    component Door {
        outgoing message opened with type: none
        outgoing message closed with type: none
        incoming message go with type: none
        incoming message wait with type: none
        behaviour {
            initial marked state shut { on response from opened goto open }
            marked state open { on response from closed goto shut }
        }
    }
"""


@pytest.mark.parametrize(
    "requirement",
    ["go needs Door.shut", "{go} needs !Door.open", "Door.open disables go"],
)
def test_needs_and_disables(subject: type[Subject], requirement: str) -> None:
    same(
        [
            line
            for line in controlled(subject, f"{DOOR} requirement {requirement}")
            if "request" in line
        ],
        """
        shut --go.request--> shut
        shut --wait.request--> shut
        open --wait.request--> open
        """,
    )


def test_requirement_on_a_set_of_communications(subject: type[Subject]) -> None:
    same(
        [
            line
            for line in controlled(subject, f"{DOOR} requirement Door.open disables {{go, wait}}")
            if "request" in line
        ],
        """
        shut --go.request--> shut
        shut --wait.request--> shut
        """,
    )


GUARDED_ACTION = """
    component Door {
        outgoing message opened with type: none
        outgoing message closed with type: none
        action a with request: none, response: none, feedback: none links link
        behaviour {
            initial marked state shut { on response from opened goto open }
            marked state open { on response from closed goto shut }
        }
    }
"""


def commands(found: list[str]) -> list[str]:
    return [line for line in found if ".request" in line or ".cancel-" in line]


def test_cancel_is_allowed_exactly_where_a_requirement_is_violated(
    subject: type[Subject],
) -> None:
    text = GUARDED_ACTION + "requirement a needs Door.shut"
    same(
        commands(controlled(subject, text)),
        """
        shut idle --a.request--> shut busy
        open busy --a.cancel--> open cancelling
        """,
    )


@pytest.mark.parametrize("requirement", ["a needs Door.shut", "Door.open disables {a}"])
def test_a_requirement_to_start_is_no_reason_to_cancel(
    subject: type[Subject], requirement: str
) -> None:
    text = f"{GUARDED_ACTION} requirement {requirement} to start"
    same(commands(controlled(subject, text)), "shut idle --a.request--> shut busy")
    other = f"{text} requirement a needs Door.open"
    same(commands(controlled(subject, other)), "")
    both = f"{text} requirement a needs Door.shut or a.busy"
    same(commands(controlled(subject, both)), "shut idle --a.request--> shut busy")
    cancelled = f"{text} requirement a needs Door.shut"
    same(
        commands(controlled(subject, cancelled)),
        """
        shut idle --a.request--> shut busy
        open busy --a.cancel--> open cancelling
        """,
    )


def test_one_of_several_requirements_is_enough_for_a_cancel(subject: type[Subject]) -> None:
    text = GUARDED_ACTION + "requirement a needs Door.shut requirement Door.shut disables a"
    same(
        commands(controlled(subject, text)),
        "",
    )
    other = GUARDED_ACTION + "requirement a needs Door.shut requirement a needs true"
    assert "open busy --a.cancel--> open cancelling" in controlled(subject, other)


@pytest.mark.parametrize("requirement", ["never Door.open", "always Door.shut"])
def test_state_requirement_that_cannot_be_kept_leaves_nothing(
    subject: type[Subject], requirement: str
) -> None:
    assert controlled(subject, f"{DOOR} requirement {requirement}") == []


def test_state_requirement_forbids_what_leads_to_it_unpreventably(
    subject: type[Subject],
) -> None:
    text = """
        component Arm {
            incoming message lift with type: none
            incoming message drop with type: none
            outgoing message slip with type: none
            behaviour {
                initial marked state low { on request to lift goto mid }
                marked state mid {
                    on request to lift goto high
                    on request to drop goto low
                    on response from slip goto low
                }
                marked state high { on response from slip goto fallen }
                marked state fallen {}
            }
        }
        requirement never Arm.fallen
    """
    same(
        controlled(subject, text),
        """
        low --lift.request--> mid
        low --slip.response--> low
        mid --drop.request--> low
        mid --slip.response--> low
        """,
    )
