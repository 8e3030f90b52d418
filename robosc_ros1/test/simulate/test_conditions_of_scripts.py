"""A condition that a person types is read as the same text in a requirement of the model is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from emit.generated_code import supervisor_of
from model.model_text import resolve
from ros_support import EXAMPLES
from simulate.players import play, session

from robosc.expr.traversal import walk
from robosc.expr.tree import ParameterRef
from robosc.model.declarations.parameters import with_parameters
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.simulate.faults import InvalidLine
from robosc.simulate.script.expectations import condition
from robosc.source import Source
from robosc.syntax.nodes import RequirementNode
from robosc.syntax.parser import parse

LIBRARY = """library Sensors {
    datatype enum Way from integer to { value < 3 -> far default -> near }
    constant close: integer = 2
    parameter gain: double = 0.5
    component Eye {
        parameter least: double = 0.2
        constant most: integer = 7
        outgoing message way with identifier: "way", timeout: 1 s, type: integer
        behaviour {
            variable way: Way
            variable raw: integer
            initial marked state on { on response from way do way := Way(value), raw := value }
        }
    }
}
"""
ROBOT = """robot Names {
    datatype enum Gear from integer to { value > 1 -> near default -> park }
    constant low: integer = 1
    parameter limit: double = 4.5
    condition blocked = Left.way = Sensors.Way.near or Left.raw > limit
    component Left from Sensors import Eye with prefix: "left"
    component Right from Sensors import Eye with prefix: "right", least: 0.4
    component Box {
        condition full = count(s.full for s in Slot) > low
        outgoing message gear with type: integer
        behaviour {
            variable gear: Gear
            variable last: integer(0..9)
            on response from gear do gear := Gear(value)
            initial marked state still {}
        }
    }
    component Slot[1..3] {
        outgoing message fill with type: none
        behaviour {
            initial marked state empty { on response from fill goto full }
            marked state full {}
        }
    }
    component Base { incoming message go with type: none }
    requirement go needs %s
}
"""
CONDITIONS = [
    "blocked",
    "!blocked and Box.full",
    "Left.way = Sensors.Way.near",
    "Left.way = near and Box.gear = near",
    "Box.gear = Gear.near",
    "Left.raw > limit * Sensors.gain",
    "Left.raw = Sensors.close or Left.raw > Left.most",
    "Right.raw > Right.least and Left.raw > Left.least",
    "Box.still and Slot[2].full",
    "any(s.empty for s in Slot[2..3])",
    "Left.way.fresh",
    "Left.raw in { low, 3, Sensors.close }",
    "abs(Left.raw) > low => round(Left.raw / limit) = 2",
    "Left.raw / Right.raw > 1.5 else blocked",
]


def named(tmp_path: Path, text: str = "blocked") -> Robot:
    (tmp_path / "Sensors.rscd").write_text(LIBRARY)
    robot, diagnostics = load(Source(str(tmp_path / "names.rscd"), ROBOT % text))
    assert robot is not None, diagnostics
    return robot


@pytest.mark.parametrize("text", CONDITIONS)
def test_every_name_of_a_requirement_has_its_meaning(tmp_path: Path, text: str) -> None:
    robot = named(tmp_path, text)
    assert condition(text, robot) == robot.requirements[0].condition


def examples() -> Iterator[tuple[str, str]]:
    """Path of an example, and a condition of it as a person would type it."""
    for path in sorted(EXAMPLES.rglob("*.rscd")):
        tree, _ = parse(Source(str(path), path.read_text()))
        for item in tree.declarations if tree is not None else ():
            # What a command carries is known only when it is sent.
            if isinstance(item, RequirementNode) and "value." not in item.condition.span.text:
                yield str(path), " ".join(item.condition.span.text.split())


def test_requirements_of_the_examples_can_be_typed() -> None:
    found = list(examples())
    robots = {path: load(path)[0] for path in {path for path, _ in found}}
    assert len(found) > 30
    for path, text in found:
        robot = robots[path]
        if robot is not None and "//" not in text:
            assert condition(text, robot) in [r.condition for r in robot.requirements], (path, text)


def test_parameters_are_what_was_set(tmp_path: Path) -> None:
    robot = with_parameters(named(tmp_path), {"limit": 9.0})
    found = walk(condition("blocked", robot))
    assert [p.parameter.default for p in found if isinstance(p, ParameterRef)] == [9.0]


@pytest.mark.parametrize("execute", [False, True])
def test_scripts_name_conditions_and_parameters(execute: bool) -> None:
    cart = supervisor_of("""robot Cart {
        parameter least: double = 0.2
        condition fit = Battery.charge > least
        component Battery {
            outgoing message power with type: double
            behaviour {
                variable charge: double = 0.5
                initial marked state watching { on response from power do charge := value }
            }
        }
        component Motor { incoming message drive with type: none }
        requirement drive needs fit
    }""")
    player = session(cart, execute=execute, parameters={"least": 0.7})
    play(player, "expect !fit and Battery.charge < least", "power 0.8", "expect fit")
    if not execute:
        play(player, "restart", "goto fit", "expect fit and Battery.charge > least")


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("bloked", "did you mean 'blocked'"),
        ("Sensors.far", "write far or Sensors.Way.far"),
        ("Left.lest > 1", "no variable or state 'lest'"),
        ("limit", "needs a boolean"),
        ("Slot[4].full", r"there is no Slot\[4\]"),
        ("value > 1", "a condition on states has no received value"),
    ],
)
def test_faults_name_what_there_is(tmp_path: Path, text: str, fault: str) -> None:
    with pytest.raises(InvalidLine, match=fault):
        condition(text, named(tmp_path))


def test_a_faulty_condition_leaves_the_model_without_fault() -> None:
    robot = resolve("component A { behaviour { initial marked state on {} } }")
    with pytest.raises(InvalidLine):
        condition("A.off", robot)
    assert condition("A.on", robot) == condition("(A.on)", robot)
