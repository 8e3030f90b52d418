"""Conditions as users write them: the outer state instead of all in it, and that a message was
heard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce

from robosc.expr.traversal import operands, with_operands
from robosc.expr.tree import Binary, Expr, Operation, PhaseRef, StateRef, Unary
from robosc.expr.types import BooleanType
from robosc.model.entities import Robot

_Inside = Mapping[str, Sequence[tuple[str, frozenset[str]]]]
"""By component, its states with several states in them, the largest first, and what is in them."""


def with_composites(expr: Expr, robot: Robot) -> Expr:
    """Return a condition that names an outer state where it lists all states in it; for texts."""
    inside: dict[str, list[tuple[str, frozenset[str]]]] = {}
    for component in robot.components:
        if component.behaviour is not None and component.behaviour.composites:
            states = component.behaviour.states
            found = [
                (outer, frozenset(state.name for state in states if state.is_in(outer.name)))
                for outer in component.behaviour.composites
            ]
            several = [(o.name, leaves) for o, leaves in found if len(leaves) > 1 or o.performs]
            inside[component.name] = sorted(several, key=lambda item: -len(item[1]))
    heard = any(c.heard and c.timeout is not None for c in robot.communications.values())
    return _named(expr, inside) if inside or heard else expr


def _named(expr: Expr, inside: _Inside) -> Expr:
    if isinstance(expr, Binary) and expr.operator in ("and", "or"):
        operator = expr.operator
        parts = [_named(part, inside) for part in operands(expr, operator)]
        joined = _joined(parts, operator == "and", inside)
        joined = _heard(joined, operator == "and")
        return reduce(lambda left, right: Binary(operator, left, right, BooleanType()), joined)
    if isinstance(expr, Operation):
        return with_operands(expr, tuple(_named(part, inside) for part in expr.operands))
    return expr


def _joined(parts: list[Expr], negated: bool, inside: _Inside) -> list[Expr]:
    """The parts of a conjunction of negations, or of a disjunction, with outer states in it."""
    for component, outer_states in inside.items():
        for outer, leaves in outer_states:
            listed = {
                number: part.state
                for number, whole in enumerate(parts)
                if isinstance(part := _state(whole, negated), StateRef)
                and part.component == component
                and part.state in leaves
            }
            if leaves == frozenset(listed.values()):
                first = next(iter(listed))
                state: Expr = StateRef(component, outer)
                parts[first] = Unary("!", state, BooleanType()) if negated else state
                parts = [p for n, p in enumerate(parts) if n == first or n not in listed]
    return parts


def _heard(parts: list[Expr], negated: bool) -> list[Expr]:
    """The parts with *heard* instead of *fresh* and *silent* of one message."""
    phases = {
        (leaf.communication, leaf.phase): number
        for number, whole in enumerate(parts)
        if isinstance(leaf := _state(whole, negated), PhaseRef)
    }
    for (key, phase), first in phases.items():
        if phase == "fresh" and (key, "silent") in phases:
            heard: Expr = PhaseRef(key, "heard")
            parts[first] = Unary("!", heard, BooleanType()) if negated else heard
            parts[phases[key, "silent"]] = parts[first]
    return list(dict.fromkeys(parts))


def _state(expr: Expr, negated: bool) -> Expr | None:
    """The operand of a negation, or the expression itself."""
    if not negated:
        return expr
    return expr.operand if isinstance(expr, Unary) and expr.operator == "!" else None
