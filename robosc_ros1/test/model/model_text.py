"""Short ways from a text to its robot or its diagnostics; no message definitions unless given."""

from __future__ import annotations

from robosc.errors import render_all
from robosc.model.automata import Behaviour
from robosc.model.entities import Robot
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.source import Source

__all__ = ["behaviour_of", "faults", "resolve"]


def resolve(text: str, definitions: MessageDefinitions | None = None) -> Robot:
    """The robot; any error fails the test with its text."""
    robot, diagnostics = load(
        Source("model.rscd", f"robot Test {{\n{text}\n}}\n"),
        definitions=definitions or MessageDefinitions(),
    )
    assert robot is not None, render_all(diagnostics)
    return robot


def faults(text: str, definitions: MessageDefinitions | None = None) -> list[tuple[str, str]]:
    """Code and marked text of each diagnostic, in reading order."""
    _, diagnostics = load(
        Source("model.rscd", f"robot Test {{\n{text}\n}}\n"),
        definitions=definitions or MessageDefinitions(),
    )
    return [(d.code, d.span.text) for d in diagnostics]


def behaviour_of(robot: Robot, component: str) -> Behaviour:
    behaviour = robot.component(component).behaviour
    return behaviour
