"""Conditions on states and phases: with as few names as the model has for them, or written out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from robosc.expr import quantified, traversal, tree
from robosc.language.events import named_phases
from robosc.model.entities import Communication, Robot


def in_states(robot: Robot, component: str, names: Sequence[str]) -> list[tree.StateRef]:
    """Conditions of which one holds where a component is in one of some states.

    An outer state stands for all states in it, the largest first.
    """
    found = {name: tree.StateRef(component, name) for name in names}
    behaviours = (c.behaviour for c in robot.components if c.name == component)
    behaviour = next(behaviours, None)  # a lasting condition has none
    for outer, within in behaviour.inside.items() if behaviour else ():
        if all(name in found and not found[name].within for name in within):
            found |= dict.fromkeys(within, tree.StateRef(component, outer, within=within))
    return list(dict.fromkeys(found.values()))


def in_phases(communication: Communication, names: Sequence[str]) -> list[tree.PhaseRef]:
    """Conditions of which one holds where a communication is in one of some phases."""
    several: dict[str, tuple[str, ...]] = (
        {"heard": ("fresh", "silent")} if communication.heard else {}
    )
    if communication.phases is not None and (
        busy := named_phases(communication.phases.names, "busy")
    ):
        several["busy"] = busy
    for name, within in several.items():
        if {*within} <= {*names}:
            others = [tree.PhaseRef(communication.key, n) for n in names if n not in within]
            return [tree.PhaseRef(communication.key, name, within=within), *others]
    return [tree.PhaseRef(communication.key, name) for name in names]


def each_place(ref: tree.StateRef | tree.PhaseRef) -> list[tree.StateRef] | list[tree.PhaseRef]:
    """The conditions of which one holds where a state or a phase with others in it does."""
    if isinstance(ref, tree.StateRef):
        return [replace(ref, state=name, within=()) for name in ref.places]
    return [replace(ref, phase=name, within=()) for name in ref.places]


def written_out(expr: tree.Expr) -> tree.Expr:
    """A condition in which states and phases that have others in them are these."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        if isinstance(node, tree.StateRef | tree.PhaseRef) and node.within:
            return quantified.chain("or", each_place(node), node.span)
        return node

    return traversal.rewritten(expr, leaf)
