"""Servers: several communications may be with one, and it does one thing at a time.

A requirement that nobody writes says so: a request needs the others of its server to be idle. It
is like those that end with ``to start``: it is no reason to cancel anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from robosc.errors import listing
from robosc.expr import tree, types
from robosc.expr.quantified import chain
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, PhaseRef, StateRef, VariableRef
from robosc.expr.undefined_data import known_condition
from robosc.language.events import EventKind, Kind
from robosc.model.automata import HOLDING, RESTING, Behaviour, Lasting, State, Transition
from robosc.model.entities import Communication, Component, Provide, Requirement, Robot


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


# Conditions that must have held for some time, as components without a text in the model.
#
# Such a component rests until its condition has held for the delay, and then holds. It goes back to
# rest by every event after which the condition does not hold; the plant adds that, for it is no
# transition of one communication.


def with_lasting(robot: Robot, found: Sequence[Lasting]) -> Robot:
    """The robot with a component for each of these conditions.

    While a message with a timeout is silent, by whose response a variable is assigned that a
    condition reads, the condition counts as false.
    """
    lasting = tuple(
        replace(one, condition=chain("and", [*_fresh(robot, one), known_condition(one.condition)]))
        for one in _in_order({one.name: one for one in found})
    )
    components = (*robot.components, *map(_component, lasting))
    return replace(robot, components=components, lasting=lasting) if lasting else robot


def _in_order(by_name: Mapping[str, Lasting]) -> Iterator[Lasting]:
    """Yield each condition once, behind those that it reads."""
    met: set[str] = set()

    def visit(name: str) -> Iterator[Lasting]:
        if name in by_name and name not in met:
            met.add(name)
            for leaf in walk(by_name[name].condition):
                if isinstance(leaf, StateRef):
                    yield from visit(leaf.component)
            yield by_name[name]

    for name in by_name:
        yield from visit(name)


def _fresh(robot: Robot, lasting: Lasting) -> Iterator[Expr]:
    read = {leaf.key for leaf in walk(lasting.condition) if isinstance(leaf, VariableRef)}
    assigning = {
        transition.communication
        for component, transition in robot.transitions
        if transition.event is EventKind.RESPONSE
        and any(f"{component.name}.{a.variable}" in read for a in transition.assignments)
    }
    for key, communication in robot.communications.items():
        if key in assigning and communication.kind is Kind.OUTGOING and communication.timeout:
            yield PhaseRef(key, "fresh")


def _component(lasting: Lasting) -> Component:
    name, span = lasting.name, lasting.span
    over = Transition(
        EventKind.AFTER, name, lasting.condition, (), HOLDING, None, 1, lasting.delay, span=span
    )
    states = (
        State(RESTING, True, True, (over,), span=span),
        State(HOLDING, False, True, (), span=span),
    )
    behaviour = Behaviour((), states, (), span=span)
    return Component(name, (), behaviour, None, span=span)
