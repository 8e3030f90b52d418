"""What the robot is assumed not to do, as conditions on the state before an event.

A response or feedback that an assumption excludes is not in the plant. So each event concerned gets
one more automaton: it has one state, and takes the event only where the assumptions allow it. The
engines need no notion of it.

``assume always e`` is about the state after the event; it is brought before the event.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from robosc.expr import tree, types
from robosc.expr.traversal import reads_value, within
from robosc.expr.undefined_data import known_condition
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Assumption, Communication, Robot
from robosc.plant import logic, preconditions

EXCLUDED = (EventKind.RESPONSE, EventKind.FEEDBACK)
"""The events that are assumed away; those of time, of failures and of calls never are."""


@dataclass(frozen=True)
class Restriction:
    """An assumption, as the condition before an event under which the event keeps to it."""

    assumption: Assumption
    condition: tree.Expr


Restrictions: TypeAlias = Mapping[tuple[EventKind, str], Sequence[Restriction]]
"""By kind and communication, what is assumed of an event; without those of which nothing is."""


def restrictions(robot: Robot) -> Restrictions:
    """Return what is assumed of the events of the robot, without what they always keep to."""
    restricted = {
        (kind, communication.key): tuple(_restrictions_of(robot, communication, kind))
        for communication in robot.communications.values()
        for kind in EXCLUDED
        if communication.sort.event(kind) is not None
    }
    return {event: assumed for event, assumed in restricted.items() if assumed}


def conditions_of_states(robot: Robot) -> Iterator[tuple[tree.Expr, int]]:
    """The conditions of the assumptions that are about states, each with its index."""
    for index, assumption in enumerate(robot.assumptions):
        if assumption.communication is None:
            yield known_condition(assumption.condition), index


def _restrictions_of(
    robot: Robot, communication: Communication, kind: EventKind
) -> Iterator[Restriction]:
    for assumption in robot.assumptions:
        if assumption.communication == communication.key:
            concerned = kind in events_of(assumption, robot)
            condition = known_condition(assumption.condition) if concerned else tree.TRUE
        elif assumption.communication is not None:
            continue
        else:
            condition = _lasting(robot, communication, kind, known_condition(assumption.condition))
        if condition != tree.TRUE:
            yield Restriction(assumption, condition)


def events_of(assumption: Assumption, robot: Robot) -> tuple[EventKind, ...]:
    """The events that an assumption is about: those of all communications, or of one.

    One that reads ``value`` is about the response, and about feedback of the same type.
    """
    if assumption.communication is None:
        return EXCLUDED
    communication = robot.communications[assumption.communication]
    alike = communication.response == communication.feedback
    every = alike or not reads_value(assumption.condition)
    found = EXCLUDED if every else (EventKind.RESPONSE,)
    return tuple(kind for kind in found if communication.sort.event(kind) is not None)


def _lasting(
    robot: Robot, communication: Communication, kind: EventKind, condition: tree.Expr
) -> tree.Expr:
    """The condition before an event under which a condition still holds after it, if it did."""
    cases = preconditions.cases_of(robot, communication, kind)
    after = preconditions.after_event(condition, cases)
    if after == condition or (lasting := logic.simplified(known_condition(after))) == tree.TRUE:
        return tree.TRUE
    # An event that leaves a range leads to no state, so that nothing is assumed of it.
    leaving = (expr for found in cases.values() for case in found for expr in _leaving(case, robot))
    return logic.disjunction([logic.negation(condition), lasting, *leaving])


def _leaving(case: preconditions.EventCase, robot: Robot) -> Iterator[tree.Expr]:
    """Yield when a variable leaves its range."""
    for key, value in case.assigned.items():
        variable = robot.variables[key]
        type_ = variable.type
        if variable.in_state and isinstance(type_, types.IntegerType) and not within(value, type_):
            assert type_.bounds is not None
            sides = zip(("<", ">"), type_.bounds, strict=True)
            outside = [
                tree.Binary(op, value, tree.Literal(b, value.type), types.BooleanType())
                for op, b in sides
            ]
            yield logic.conjunction([case.condition, logic.disjunction(outside)])


def joined(assumed: Sequence[Restriction]) -> tree.Expr:
    """The condition under which an event keeps to all that is assumed of it."""
    return logic.conjunction(restriction.condition for restriction in assumed)
