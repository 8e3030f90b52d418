"""The stages of states that perform commands, as documents tell them outside of the states."""

from __future__ import annotations

from robosc.model.entities import Robot
from robosc.runtime.core.places import stage_of


def told_stages(robot: Robot) -> tuple[str, ...]:
    """``Component.state stage`` for each stage that is told."""
    return tuple(
        f"{component.name}.{state.name}"
        for component in robot.components
        for state in component.states
        if stage_of(state.name)
    )
