"""What of a requirement does not hold: a part is told if, and only if, the requirement is violated."""

from __future__ import annotations

import math
import random
import re
import struct
from pathlib import Path
from typing import Any

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.scripted_controllers import class_of
from random_models import random_model
from ros_support import EXAMPLES

from robosc import pipeline
from robosc.runtime.core.reasons import violated
from robosc.runtime.core.values import Undefined

MODELS = [m for m in sorted(EXAMPLES.rglob("*.rscd")) if re.search(r"^robot ", m.read_text(), re.M)]
NUMBERS = [-1.0, 0.0, 0.05, 0.15, 0.3, 0.5, 1.0, 5.0, 100.0, math.inf, math.nan]


def arbitrary(value: Any, chance: random.Random, words: list[str]) -> Any:
    """Another value of the same type; one that is no state of the plant will do, too."""
    if isinstance(value, bool):
        return chance.random() < 0.5
    if isinstance(value, int):
        return chance.randint(-1, 4)
    if isinstance(value, float):
        return chance.choice(NUMBERS)
    if isinstance(value, str):
        return chance.choice([value, *words])
    return value


def told_as_violated(source: str, seed: int) -> int:
    """How many violated requirements were seen whose parts are told."""
    chance = random.Random(seed)
    controller = class_of(source)()
    initial = dict(vars(controller))
    words = [value for value in initial.values() if isinstance(value, str)]
    found = 0
    for _ in range(200):
        vars(controller).update((n, arbitrary(v, chance, words)) for n, v in initial.items())
        for requirement in controller.REQUIREMENTS:
            if requirement.failures is None:
                continue
            try:
                holds = requirement.holds(controller)
                failures = list(requirement.failures(controller))
            except Undefined:
                continue
            assert bool(failures) is not holds, (requirement.text, vars(controller))
            found += not holds
    return found


@pytest.mark.parametrize("model", MODELS, ids=lambda path: path.stem)
def test_examples(model: Path) -> None:
    robot = pipeline.load(model).robot
    if robot.supervises:
        return  # there failures depend on what another controller sends
    source = controller_source(pipeline.synthesize(robot), model.name)
    assert told_as_violated(source, 1) > 0 or "failures=" not in source


@pytest.mark.parametrize("seed", range(20))
def test_random_robots(seed: int) -> None:
    source = controller_source(supervisor_of(random_model(random.Random(seed))))
    assert told_as_violated(source, seed) >= 0


ROBOT = """
robot Rover {
    component Laser {
        outgoing message scan with identifier: "/scan", timeout: 1 s, type: double
        behaviour {
            variable front: double
            initial marked state on { on response from scan do front := value }
        }
    }
    component Wheel[1..2] {
        outgoing message slip with identifier: "/slip", type: boolean
        behaviour {
            variable slipping: boolean
            initial marked state on { on response from slip do slipping := value }
        }
    }
    component Base {
        incoming message drive with identifier: "/drive", type: none
        incoming message turn with identifier: "/turn", type: none
    }
    parameter near: double = 0.4
    requirement drive needs scan.fresh and Laser.front > near
    requirement any(w.slipping for w in Wheel) disables drive
    requirement turn needs scan.fresh
}
"""


def test_text() -> None:
    controller = class_of(controller_source(supervisor_of(ROBOT)))()
    controller.laser_front = 0.3875
    controller.wheel_2_slipping = True
    because = {
        command.key: [reason.get("because") for reason in violated(controller, command)]
        for command in controller.COMMANDS
    }
    assert because == {
        "Base.drive": [
            [
                "scan.fresh is false",
                "Laser.front > near is false (Laser.front is 0.3875, near is 0.4)",
            ],
            ["Wheel[2].slipping is true"],
        ],
        "Base.turn": [None],
    }


CARTS = """
robot Carts {
    component Laser { outgoing message scan with timeout: 1 s, type: none }
    component Cart[1..2] {
        service dock with identifier: "/dock", request: none, response: none links trigger
        action reach with identifier: "/reach", type: move_base_msgs/MoveBase
        incoming message move with identifier: "/move", type: none
        incoming message halt with identifier: "/halt", type: none
        requirement move needs dock.idle and !(reach.busy or scan.silent)
        requirement dock.busy or !scan.silent disables halt
        requirement dock needs scan.heard
        requirement reach needs scan.heard
    }
    interface trigger use Trigger from std_srvs
}
"""


def test_phases_are_told_by_the_names_that_the_model_has() -> None:
    controller = class_of(controller_source(supervisor_of(CARTS)))()
    for name in ("cart_2_dock_busy", "cart_2_reach_busy", "scan_fresh"):
        assert getattr(controller, name) is False
    because = {}
    for is_busy in (False, True):
        vars(controller).update(
            cart_2_dock_busy=is_busy, cart_2_reach_busy=is_busy, scan_fresh=is_busy
        )
        for command in controller.COMMANDS:
            if command.key in ("Cart[2].move", "Cart[2].halt"):
                told = [reason.get("because") for reason in violated(controller, command)]
                because[command.key, is_busy] = told
    assert because == {
        ("Cart[2].move", False): [["scan.silent is true"]],
        ("Cart[2].move", True): [["Cart[2].dock.idle is false", "Cart[2].reach.busy is true"]],
        ("Cart[2].halt", False): [],
        ("Cart[2].halt", True): [["Cart[2].dock.busy is true", "scan.silent is false"]],
    }


LIMITED = """robot R {
    parameter fastest: double = 0.3
    constant slow: double = 0.3
    component S {
        outgoing message x with type: double
        behaviour {
            variable x: double
            initial marked state on_ { on response from x do x := value }
        }
    }
    component M { incoming message go with type: none }
    requirement go needs S.x <= LIMIT
}"""


@pytest.mark.parametrize("limit", ["0.3", "slow", "fastest"])
def test_a_value_that_is_nearly_the_limit_is_told_as_another_one(limit: str) -> None:
    """As a field of 32 bits has it, 0.3 is more."""
    controller = class_of(controller_source(supervisor_of(LIMITED.replace("LIMIT", limit))))()
    (command,) = controller.COMMANDS
    for value, told in (
        (struct.unpack("f", struct.pack("f", 0.3))[0], "0.300000012"),
        (0.4, "0.4"),
    ):
        vars(controller)["s_x"] = value
        ((because, *_),) = (reason["because"] for reason in violated(controller, command))
        assert because.startswith(f"S.x is {told}"), because
