"""The libraries that come with robosc: imported in one line, and no obstacle to those of users."""

from __future__ import annotations

from pathlib import Path

import pytest
from emit.generated_code import controller_class
from simulate.players import play, session

from robosc.errors import render_all
from robosc.model.resolve import load
from robosc.plant.build import lower
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize

ROBOT = """
robot R {
    component Emergency from EStop import Button
    component Base from Velocity import Base with most: 0.4
    component Stick {
        outgoing message stick with timeout: 1 s, type: double
        behaviour {
            variable speed: double
            initial marked state on { on response from stick do speed := value }
        }
    }
    component Lamp { incoming message blink with type: none }
    requirement drive needs stick.fresh
    provide drive with { linear: { x: Velocity.limited(Stick.speed, Base.most) } }
    stop with Emergency.halt
}
"""


def supervisor(text: str, folder: Path) -> Supervisor:
    robot, diagnostics = load(Source(str(folder / "model.rscd"), text))
    assert robot is not None, render_all(diagnostics)
    assert {d.code for d in diagnostics} <= {"package-not-found", "unused-variable"}
    return synthesize(lower(robot))


def test_nothing_but_halt_is_sent_until_the_button_is_released(tmp_path: Path) -> None:
    player = session(supervisor(ROBOT, tmp_path))
    play(player, "stick 1.0", "expect disabled drive", "expect disabled blink")
    play(player, "expect enabled Emergency.halt", "estop false", "expect enabled drive")
    play(player, "expect enabled blink", "expect disabled Emergency.halt", "estop.timeout")
    play(player, "expect disabled drive", "expect disabled blink", "expect enabled Emergency.halt")


@pytest.mark.parametrize("stops", ["estop true", "estop.timeout"])
def test_a_button_that_is_released_or_back_moves_nothing(stops: str, tmp_path: Path) -> None:
    """Somebody must ask for the reset, while it is released: earlier requests do not count."""
    player = session(supervisor(ROBOT, tmp_path))
    play(player, "stick 1.0", "estop false", "reset", stops, "expect disabled drive")
    play(player, "reset", "expect disabled drive", "estop false", "expect disabled drive")
    play(player, "expect disabled blink", "expect enabled Emergency.halt")
    play(player, "reset", "expect enabled drive", "expect enabled blink")
    play(player, "expect disabled Emergency.halt")


def test_a_button_that_is_pressed_at_the_start_needs_the_reset(tmp_path: Path) -> None:
    player = session(supervisor(ROBOT, tmp_path))
    play(player, "stick 1.0", "estop true", "estop false", "expect disabled drive")
    play(player, "reset", "expect enabled drive")


@pytest.mark.parametrize(
    ("call", "value"),
    [
        ("Velocity.limited(0.7, Base.most)", 0.4),
        ("Velocity.limited(-2, 1.5)", -1.5),
        ("Velocity.ramped(1.0, 0.2, 0.1)", 0.2 + 0.1),
        ("Velocity.ramped(-1.0, 0.25, 0.25)", 0.0),
        ("Velocity.ramped(0.3, 0.25, 0.25)", 0.3),
        ("Velocity.stoppable(0.5, 1.0)", 1.0),
        ("Velocity.stoppable(-0.5, 1.0)", 0.0),
    ],
)
def test_functions_of_velocities(call: str, value: float, tmp_path: Path) -> None:
    text = ROBOT.replace("Velocity.limited(Stick.speed, Base.most)", call)
    controller = controller_class(supervisor(text, tmp_path))[0]()
    assert controller.data_for_drive()["linear"]["x"] == pytest.approx(value)


def test_a_library_of_the_user_goes_before(tmp_path: Path) -> None:
    (tmp_path / "mine.rscd").write_text(
        "library EStop { component Button { outgoing message estop with type: boolean } }"
    )
    robot, _ = load(
        Source(str(tmp_path / "m.rscd"), "robot R { component B from EStop import Button }")
    )
    assert robot is not None and list(robot.communications) == ["B.estop"]
