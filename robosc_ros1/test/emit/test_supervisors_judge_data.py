"""A generated supervisor judges what another controller sends, and corrects it; its test follows."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.scripted_controllers import class_of, scripts_of, tells_apart

from robosc.plant.model_text import to_dsl

ROBOT = """
    datatype object Drive { speed: double turn: double gear: integer ranges: array(double) }
    interface drives use Drive from some_robot_msgs
    component Scanner {
        outgoing message near with identifier: "/near", timeout: 0.5 s, type: boolean
        behaviour {
            variable close: boolean
            on response from near do close := value
            initial marked state watching {}
        }
    }
    component Motor {
        incoming message move with identifier: "/move", type: Drive links drives
        incoming message beep with identifier: "/beep", type: integer
        incoming message lamp with identifier: "/lamp", type: boolean
        behaviour {
            variable last: double
            initial marked state slow {
                on request to move if value.speed > 0.2 do last := value.turn goto fast
                on request to move if !(value.speed > 0.2) do last := value.turn
            }
            marked state fast {
                on request to move if value.speed <= 0.2 goto slow
                on request to move if !(value.speed <= 0.2)
            }
        }
    }
"""
JUDGED = (
    ROBOT
    + """
    requirement move needs near.fresh and value.speed <= 0.5
    requirement move needs value.speed > 0.2 => !Scanner.close
    requirement value.gear = 3 disables move
    requirement move needs value.ranges[1] < 9.0
    requirement lamp needs value => Motor.slow
    requirement move needs Motor.last < 5.0 or value.turn < value.speed
"""
)
CORRECTED = (
    ROBOT
    + """
    provide move with { speed: 0.0, turn: 0.0 } if Scanner.close and value.gear = 0
    provide move with { speed: min(value.speed, 0.4), turn: value.turn * 0.5 }
    provide beep with max(value, 1)
    requirement move needs near.fresh
    requirement move needs value.turn <= 0.0 or Motor.fast
    requirement beep needs value < 5
"""
)


def supervisor(text: str, engine: str = "auto") -> Any:
    return supervisor_of(f"robot Cart {{ {text} }}", engine=engine, supervises=True)


@pytest.mark.parametrize("model", [JUDGED, CORRECTED], ids=["judged", "corrected"])
def test_the_packages_test_finds_faults(model: str) -> None:
    made = supervisor(model)
    source, scripts = controller_source(made), scripts_of(made)
    assert tells_apart(made, scripts, source) == []
    assert "expect sent move.request" in "".join(scripts)
    assert "expect blocked because requirement move" in "".join(scripts)
    faults = [
        ('value["speed"] <= 0.5', 'value["speed"] <= 0.7'),
        ('value["gear"] != 3', "True"),
        ('least(value["speed"], 0.4)', 'least(value["speed"], 0.7)'),
        ("greatest(value, 1)", "greatest(value, 2)"),
        ("value < 5", "value < 6"),
        ('self.motor_last = value["turn"]', "pass"),
    ]
    found = 0
    for right, wrong in faults:
        if right in source:
            found += 1
            assert tells_apart(made, scripts, source.replace(right, wrong)), right
    assert found == (3 if "corrected_move" not in source else 4)


def test_undefined_data_are_refused() -> None:
    controller = class_of(controller_source(supervisor(JUDGED)))()
    (row,) = (c for c in controller.COMMANDS if c.key == "Motor.move")
    controller.near_fresh = True  # type: ignore[attr-defined]
    assert row.read is not None

    def allowed(**fields: Any) -> bool:
        message = SimpleNamespace(**{"speed": 0.1, "turn": 0.0, "gear": 1, **fields})
        return row.guard(controller, row.read(controller, message))  # type: ignore[misc]

    assert allowed(ranges=[0.0, 8.0])
    assert not allowed(ranges=[0.0])
    assert not allowed(ranges=[0.0, 9.0])
    assert not allowed(ranges=[0.0, 8.0], speed=float("nan"))


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_each_case_of_the_data_is_an_event(engine: str) -> None:
    made = supervisor(JUDGED.replace("requirement move needs value.ranges[1] < 9.0", ""), engine)
    lamp = {
        g.event.data[()]: (to_dsl(g.expr, made.plant.robot), g.status)
        for g in made.guards
        if g.event.name == "lamp"
    }
    assert lamp == {False: ("true", "as required"), True: ("Motor.slow", "as required")}
    assert len([g for g in made.guards if g.event.name == "beep"]) == 1
    moves = [g for g in made.guards if g.event.name == "move"]
    # Three classes of the speed and that of NaN; two of the gear; whether turn < speed; and two of
    # the turn, which becomes that of Motor.last.
    assert len(moves) == 4 * 2 * 2 * 2


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_data_after_which_nothing_leads_back_are_refused(engine: str) -> None:
    """The requirement keeps the brake from being released with these data, so it is never set."""
    text = """
        component Brake {
            incoming message brake with type: integer
            behaviour {
                initial marked state loose {
                    on request to brake if value > 5 goto stuck
                    on request to brake if value <= 5
                }
                state stuck { on request to brake if value < 0 goto loose }
            }
        }
        requirement brake needs value >= 0
    """
    made = supervisor(text, engine)
    allowed = {to_dsl(g.expr, made.plant.robot) for g in made.guards if g.event.data[()] > 5}
    assert allowed == {"false"}
    (explained,) = made.explanations
    assert "brake.request(value > 5)" in explained.reason
    source = controller_source(made)
    controller = class_of(source)()
    (row,) = controller.COMMANDS
    assert [row.guard(controller, number) for number in (-1, 0, 5, 6)] == [False, True, True, False]
