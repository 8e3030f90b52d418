"""The value of an event: its type, whether it may be missing, and the parts that are read."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from robosc.expr import traversal, tree, types
from robosc.language.events import EventKind
from robosc.model.entities import Robot
from robosc.plant.automaton import Event
from robosc.plant.logic import exact


def is_optional(robot: Robot, event: Event) -> bool:
    """Whether an event that brings a value may come without it."""
    communication = robot.communications.get(event.key)
    sort = None if communication is None else communication.sort.event(event.kind)
    return sort is not None and sort.optional


def value_type(robot: Robot, event: Event) -> types.Type:
    """Return the type of an event's value; ``none`` if it is never read, and optional or what
    another controller sends."""
    if event.kind.of_component:
        return types.NoneType()
    unread = is_optional(robot, event) or event.kind.sent
    if unread and not value_parts(robot, event):
        return types.NoneType()
    return robot.communications[event.key].value_type(event.kind)


def value_parts(robot: Robot, event: Event) -> dict[tuple[str | int, ...], types.Type]:
    """Return the parts of an event's value, with their types, that transitions read for any
    variable, and requirements on what another controller sends; of an answer also those that are
    read where it is refused, which makes it an error."""
    readers: list[tree.Expr] = []
    if robot.supervises and event.kind is EventKind.REQUEST:
        readers += (robot.requirements[number].condition for number in event.requirements)
        if event.key in robot.corrected:
            for provide in robot.provides:
                if provide.communication == event.key:
                    readers += provide.expressions
    automata = (event.whole or event).automata
    for edge in (edge for automaton in automata for edge in automaton.edges):
        readers += (assignment.value for assignment in edge.assignments)
        readers += [exact(edge.guard)] if edge.guard is not None else []
    if event.kind is EventKind.RESPONSE and robot.communications[event.key].expect is not None:
        for _, transition in robot.transitions:
            if (transition.event, transition.communication) == (EventKind.ERROR, event.key):
                readers += transition.expressions
    parts = values_read(readers)
    return {path: p.type for path, p in parts.items() if not isinstance(p, tree.ReasonRef)}


def parts_taken(robot: Robot, event: Event) -> Collection[tuple[str | int, ...]]:
    """Return the parts of an event's value that are taken from its message: of an object those that
    are read, of any other type the whole, which is converted and checked in any case."""
    type_ = value_type(robot, event)
    if isinstance(type_, types.NoneType):
        return ()
    return value_parts(robot, event) if isinstance(type_, types.ObjectType) else ((),)


def values_read(exprs: Iterable[tree.Expr]) -> dict[tuple[str | int, ...], tree.ValueRef]:
    """Return the parts of an event's value that expressions read, by path, in their order."""
    found: dict[tuple[str | int, ...], tree.ValueRef] = {}
    for expr in exprs:
        for part in traversal.walk(expr):
            if isinstance(part, tree.ValueRef):
                found.setdefault(part.path, part)
    return found
