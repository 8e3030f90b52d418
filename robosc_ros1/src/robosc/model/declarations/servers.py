"""Servers: several communications may be with one, and it does one thing at a time.

A requirement that nobody writes says so: a request needs the others of its server to be idle. It
is like those that end with ``to start``: it is no reason to cancel anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from robosc.errors import listing
from robosc.expr import tree, types
from robosc.expr.quantified import chain
from robosc.language.events import EventKind, Kind
from robosc.model.entities import Communication, Provide, Requirement, Robot


def shared_servers(robot: Robot) -> list[list[Communication]]:
    """Return the services and actions that have their name in common with others, by server."""
    servers: dict[tuple[Kind, str], list[Communication]] = {}
    for one in robot.communications.values():
        if one.kind in (Kind.SERVICE, Kind.ACTION):
            servers.setdefault((one.kind, one.ros_name), []).append(one)
    return [together for together in servers.values() if len(together) > 1]


def with_one_request_per_server(robot: Robot) -> Robot:
    """Return the robot with a requirement on each request of a server that has several."""
    added = [r for together in shared_servers(robot) for r in _requirements(robot, together)]
    return replace(robot, requirements=(*robot.requirements, *added))


def with_feedback_where_provided(robot: Robot) -> Robot:
    """Return the robot with a requirement on each feedback that it gives: one of its provide
    statements says what. Feedback that a state performs is given where that state says so.
    """
    provided: dict[str, list[Provide]] = {}
    for provide in robot.provides:
        command = robot.commands.get(provide.communication)
        if command is None or command.key in robot.performed:
            continue
        if command.kind is EventKind.PROGRESS:
            provided.setdefault(provide.communication, []).append(provide)
    added = (_provided(robot, key, provides) for key, provides in provided.items())
    return replace(robot, requirements=(*robot.requirements, *(r for r in added if r is not None)))


def _provided(robot: Robot, key: str, provides: Sequence[Provide]) -> Requirement | None:
    conditions = [p.condition for p in provides if p.condition is not None]
    if len(conditions) < len(provides):
        return None
    text = f"{robot.display_names[key]} needs one of its provide statements to hold"
    condition = chain("or", conditions)
    return Requirement("needs", (key,), condition, text, implied=True, span=provides[0].span)


def _requirements(robot: Robot, together: Sequence[Communication]) -> Iterator[Requirement]:
    names = robot.display_names
    idle = [(one, _is_idle(one), f"{names[one.key]}.idle") for one in together]
    for one in together:
        others = [(condition, text) for other, condition, text in idle if other is not one]
        yield Requirement(
            "needs",
            (one.key,),
            chain("and", [condition for condition, _ in others]),
            f"{one.identifier} is one server: {names[one.key]} needs"
            f" {listing(text for _, text in others)} to start",
            to_start=True,
            implied=True,
            span=one.span,
        )


def _is_idle(communication: Communication) -> tree.Expr:
    assert communication.phases is not None
    phases = (tree.PhaseRef(communication.key, phase) for phase in communication.phases.active)
    return chain("and", [tree.Unary("!", phase, types.BooleanType()) for phase in phases])
