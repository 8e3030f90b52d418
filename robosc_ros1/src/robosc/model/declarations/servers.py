"""Servers: several communications may be with one, and it does one thing at a time.

A requirement that nobody writes says so: a request needs the others of its server to be idle. It
is like those that end with ``to start``: it is no reason to cancel anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce

from robosc.errors import listing
from robosc.expr.tree import Binary, Expr, PhaseRef, Unary
from robosc.expr.types import BooleanType
from robosc.language.events import Kind
from robosc.model.entities import Communication, Requirement, Robot


def with_one_request_per_server(robot: Robot) -> Robot:
    """Return the robot with a requirement on each request of a server that has several.

    Identifiers that differ only by a slash at their beginning are one.
    """
    servers: dict[tuple[Kind, str], list[Communication]] = {}
    for communication in robot.communications.values():
        if communication.kind in (Kind.SERVICE, Kind.ACTION):
            name = communication.identifier.removeprefix("/")
            servers.setdefault((communication.kind, name), []).append(communication)
    added = [r for together in servers.values() for r in _requirements(robot, together)]
    return replace(robot, requirements=(*robot.requirements, *added))


def _requirements(robot: Robot, together: Sequence[Communication]) -> Iterator[Requirement]:
    names = robot.display_names
    for one in together if len(together) > 1 else ():
        others = [other for other in together if other is not one]
        idle = listing([f"{names[other.key]}.idle" for other in others])
        yield Requirement(
            "needs",
            (one.key,),
            reduce(_and, map(_is_idle, others)),
            f"{one.identifier} is one server: {names[one.key]} needs {idle} to start",
            to_start=True,
            implied=True,
            span=one.span,
        )


def _is_idle(communication: Communication) -> Expr:
    assert communication.phases is not None
    phases = [PhaseRef(communication.key, phase) for phase in communication.phases.active]
    away: list[Expr] = [Unary("!", phase, BooleanType()) for phase in phases]
    return reduce(_and, away)


def _and(left: Expr, right: Expr) -> Expr:
    return Binary("and", left, right, BooleanType())
