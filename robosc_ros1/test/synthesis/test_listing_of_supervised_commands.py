"""What is listed of a command of another controller names the data with which it is allowed."""

from __future__ import annotations

import json

from emit.generated_code import supervisor_of

from robosc.synthesis.documents import explore_json
from robosc.synthesis.explore import explore

ROBOT = """
robot Any {
    component S {
        incoming message move with type: double
        incoming message turn with type: double
        behaviour {
            initial marked state slow { on request to move if value > 0.5 goto fast }
            marked state fast { on request to move if value <= 0.5 goto slow }
        }
    }
    requirement move needs value <= 1.0
    requirement turn needs value <= 1.0 and value >= 0.0
}
"""


def test_no_data_of_a_restricted_command_are_any() -> None:
    document = json.loads("".join(explore_json(explore(supervisor_of(ROBOT, supervises=True)))))
    events = [t["event"] for t in document["transitions"]]
    assert events and all(event["value"] is not None for event in events)
    assert not any("any" in transition for transition in document["transitions"])
