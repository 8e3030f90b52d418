"""Actions that cancel themselves: by their request, their feedback, or what they achieve."""

from __future__ import annotations

import pytest
from plants import supervisor_of

MODEL = """
    component Gripper {
        outgoing message weight with timeout: 2 s, type: double
        outgoing message stop with type: boolean
        action grab with request: none, response: none, feedback: integer(0..9) links link
        behaviour {
            variable holding: boolean
            variable grabbed: boolean
            variable stopped: boolean
            variable progress: integer(0..9)
            on response from weight do holding := value > 0.5, grabbed := value > 0.7
            on response from stop do stopped := value
            on response from grab do holding := true
            on feedback from grab do progress := value
            initial marked state still { on request to grab goto moving }
            state moving {
                on response from grab goto still
                on error from grab goto still
                on cancel from grab goto still
            }
        }
    }
    requirement grab needs
"""


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
@pytest.mark.parametrize(
    ("condition", "why"),
    [
        ("Gripper.still", "its own request makes it false: after grab.request, grab is"),
        ("grab.idle", "its own request makes it false: after grab.request, grab is"),
        ("Gripper.progress < 5", "its own feedback makes it false: after grab.request, grab.feed"),
        ("!Gripper.holding", "weight may say that it is false just because grab succeeds: after"),
        ("!Gripper.grabbed", "weight may say that it is false just because grab succeeds: after"),
        ("!Gripper.stopped", ""),
        ("Gripper.still or Gripper.moving", ""),
        ("weight.fresh", ""),
        ("Gripper.still to start", ""),
        ("!Gripper.holding to start", ""),
    ],
)
def test_what_the_action_makes_false(engine: str, condition: str, why: str) -> None:
    found = [
        diagnostic.message.partition(" to cancel grab, and ")[2]
        for diagnostic in supervisor_of(f"{MODEL} {condition}", engine).diagnostics
        if diagnostic.code == "self-cancelling"
    ]
    assert [text[: len(why)] for text in found] == ([why] if why else [])
