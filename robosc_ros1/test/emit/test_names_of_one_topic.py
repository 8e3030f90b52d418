"""Identifiers that differ by a leading slash alone are one topic, and its messages one input."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of

from robosc.emit.package import ros1_target, ros2_target
from robosc.synthesis.controlled_system import inputs

MODEL = """
robot Rover {
    component Base {
        outgoing message pressed with identifier: "/bumper", type: boolean
        outgoing message touched with identifier: "bumper", type: boolean
        incoming message go with identifier: "/drive", type: boolean
        incoming message halt with identifier: "drive", type: boolean
        behaviour {
            variable hit: boolean = false
            initial marked state only {
                on response from { pressed, touched } do hit := value
                on request to { go, halt }
            }
        }
    }
    requirement go needs !Base.hit
    requirement halt needs Base.hit
    provide go with true
    provide halt with false
}
"""


@pytest.mark.parametrize("emit", [ros1_target.emit, ros2_target.emit])
@pytest.mark.parametrize("mode", ["controller", "supervisor"])
def test_one_subscription_has_both(emit: object, mode: str) -> None:
    supervisor = supervisor_of(MODEL)
    package = emit(supervisor, "rover", mode=mode)  # type: ignore[operator]
    node = next(file.content for path, file in package.files.items() if path.endswith("/node.py"))
    ends = 1 if mode == "controller" else 2  # a supervisor is between robot and controller
    assert node.count("bumper") == node.count("drive") == ends, node
    assert "pressed" in node and "touched" in node


def test_one_message_is_one_input() -> None:
    plant = supervisor_of(MODEL).plant
    names = [{plant.events[number].name for number in group} for group in inputs(plant)]
    assert {"pressed", "touched"} in names
