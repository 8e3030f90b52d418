"""``provide halt with {}`` of what carries nothing: a message without fields is sent."""

from __future__ import annotations

from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of

MODEL = """
robot Bare {
    component Base {
        incoming message halt with type: none
        service reset with request: none, response: none links empty
        action home with request: none, response: none, feedback: none links home
        outgoing action visit with request: none, response: none, feedback: none links home
        behaviour {
            initial marked state idle { on request from visit goto busy }
            state busy performs visit with {} then goto idle
        }
    }
    provide { MANY }
    stop with halt
    interface empty use Empty from std_srvs
    interface home use Home from some_base_msgs
}
"""
COMMANDS = ("halt", "reset", "home", "visit.feedback")
TEXT = MODEL.replace("provide { MANY }", "\n".join(f"provide {c} with {{}}" for c in COMMANDS))


@pytest.mark.parametrize("name", ["halt", "reset", "home", "visit"])
def test_nothing_is_set_in_a_message_without_fields(name: str) -> None:
    supervisor = supervisor_of(TEXT)
    make, _ = controller_class(supervisor)
    controller: Any = make()
    controller.base = "busy due"
    rows = [c for c in controller.COMMANDS if c.key == f"Base.{name}" and c.data is not None]
    assert rows
    for row in rows:
        assert row.data(controller) == {}
