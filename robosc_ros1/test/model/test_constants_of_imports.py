"""What an import sets counts in all of the component, and the faults that it brings are told."""

from __future__ import annotations

from pathlib import Path

import pytest

from robosc.errors import Diagnostic, render_all
from robosc.model.entities import Robot
from robosc.model.resolve import load

WHEELS = """
library Wheels {
    component Axle {
        constant radius: double = 0.5
        constant gear: integer = 1
        incoming message turn with type: integer
        outgoing message stuck with timeout: 1 s, type: none
        behaviour {
            variable level: integer(0..3) = gear
            on response from stuck do level := gear
            initial marked state small if radius < 1.0 {
                initial state low if gear = 1 { transition if level = 3 goto high }
                initial state high if gear != 1 { transition if level = 0 goto low }
            }
            initial marked state large if radius >= 1.0 and radius < 9.0 {
                on request to turn goto small
            }
        }
        requirement turn needs stuck.fresh and level <= gear
        provide turn with gear
    }
}
"""
VEHICLES = """
library Vehicles { component Rear from Wheels import Axle with prefix: "/rear", gear: 2 }
"""


def read(folder: Path, components: str) -> tuple[Robot | None, tuple[Diagnostic, ...]]:
    (folder / "Wheels.rscd").write_text(WHEELS)
    (folder / "Vehicles.rscd").write_text(VEHICLES)
    model = folder / "cart.rscd"
    model.write_text(f"robot Cart {{\n{components}\nstop with nothing\n}}\n")
    return load(str(model))


def begins(robot: Robot, component: str) -> list[str]:
    return [s.name for s in robot.component(component).behaviour.states if s.initial]


def test_initial_states_read_what_the_import_sets(tmp_path: Path) -> None:
    robot, diagnostics = read(
        tmp_path,
        """
        component Plain from Wheels import Axle with prefix: "/plain"
        component Other from Wheels import Axle with prefix: "/other", gear: 2
        component Wide from Wheels import Axle with prefix: "/wide", radius: 1.0
        component Row[1..2] from Wheels import Axle with prefix: "/row_{index}", radius: index / 2
        component Rear from Vehicles import Rear
        component Last from Vehicles import Rear with prefix: "/last", radius: 2.5
        """,
    )
    assert robot is not None, render_all(diagnostics)
    assert {c.name: begins(robot, c.name) for c in robot.components} == {
        "Plain": ["small.low"],
        "Other": ["small.high"],
        "Wide": ["large"],
        "Row[1]": ["small.low"],
        "Row[2]": ["large"],
        "Rear": ["small.high"],
        "Last": ["large"],
    }


@pytest.mark.parametrize(
    ("given", "faults"),
    [
        ("radius: 9.0", [("no-initial-state", "Axle")]),
        ("gear: 4", [("out-of-range", "gear")] * 2),
    ],
)
def test_faults_that_the_import_brings_are_told(
    tmp_path: Path, given: str, faults: list[tuple[str, str]]
) -> None:
    _, diagnostics = read(tmp_path, f"component Front from Wheels import Axle with {given}")
    assert [(d.code, d.span.text) for d in diagnostics] == faults
    assert all(d.notes[-1].message == "the component is imported here" for d in diagnostics)
