"""Conditions that must have held for some time, as a controller follows them."""

from __future__ import annotations

from robosc.emit.controller.naming import place
from robosc.emit.controller.python import Attributes
from robosc.emit.controller.template_data import LastingView
from robosc.model.entities import Robot


def lasting_views(robot: Robot, attributes: Attributes) -> tuple[LastingView, ...]:
    """The lasting conditions of a robot, in model order."""
    return tuple(
        LastingView(
            one.name,
            place(one.span),
            attributes.lasting[one.name],
            attributes.text(one.condition),
            attributes.locations[one.name],
            attributes.entries[one.name],
        )
        for one in robot.lasting
    )
