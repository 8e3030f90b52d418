"""Integers have no bounds in a model; beyond the doubles they are infinities where doubles are."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from emit.generated_code import controller_class, supervisor_of

from robosc.cli import main
from robosc.runtime.core.telemetry import dump

MODEL = """
robot Growing {
    interface number use Float64 from std_msgs
    component P {
        outgoing message tick with type: none
        incoming message whole with type: integer
        incoming message half with type: double links number
        incoming message same with type: double links number
        behaviour {
            variable x: integer = -2
            variable y: double
            variable z: double
            initial marked state s { on response from tick do x := x * x * x, y := x, z := x + 0.5 }
        }
    }
    provide whole with P.x
    provide half with P.x * 0.5 + P.y + P.z
    provide same with P.x
}
"""
GROWTH = 10  # steps; -2 to the power of 3^10 has 17,776 digits


def test_a_generated_controller_goes_on() -> None:
    make, _ = controller_class(supervisor_of(MODEL))
    controller = make()
    (tick,) = controller.INPUTS
    for _ in range(GROWTH):
        tick.apply(controller, None)
    data = {c.key: c.data(controller) for c in controller.COMMANDS}
    assert data["P.whole"] == {"data": (-2) ** 3**GROWTH}, "kept exactly"
    assert data["P.half"] == data["P.same"] == {"data": -math.inf}
    assert json.loads(dump(controller.variables())) == {
        "P.x": "-Infinity", "P.y": "-Infinity", "P.z": "-Infinity"
    }  # fmt: skip


@pytest.mark.parametrize("options", [(), ("--execute",)])
def test_the_simulator_goes_on(
    options: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "growing.rscd").write_text(MODEL)
    (tmp_path / "script").write_text("tick\n" * GROWTH)
    arguments = [str(tmp_path / "growing.rscd"), "--script", str(tmp_path / "script"), *options]
    assert main(["simulate", "--json", *arguments]) == 0
    last = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert last["state"]["variables"] == {
        "P.x": "-Infinity", "P.y": "-Infinity", "P.z": "-Infinity"
    }  # fmt: skip
    assert main(["simulate", *arguments]) == 0
