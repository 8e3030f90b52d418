"""Which states are initial where that depends on the copy: ``initial state a if index = 1``."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from robosc.expr.evaluation import constant
from robosc.model.diagnostics import Report
from robosc.model.names.tables import Instance
from robosc.model.typing.expected import BOOLEAN
from robosc.model.typing.expressions import Typer
from robosc.model.typing.value_word import no_value
from robosc.syntax.nodes import BehaviourNode, ComponentNode, StateNode

_Node = TypeVar("_Node", ComponentNode, BehaviourNode, StateNode)


def with_initial_states(instance: Instance, report: Report) -> ComponentNode:
    """Return the component with states that are initial where their conditions hold."""
    return _resolved(instance.node, instance, report)


def _resolved(node: _Node, instance: Instance, report: Report) -> _Node:
    items = tuple(
        _resolved(item, instance, report) if isinstance(item, BehaviourNode | StateNode) else item
        for item in node.items
    )
    same = all(a is b for a, b in zip(items, node.items, strict=True))
    changed = node if same else replace(node, items=items)
    if isinstance(changed, StateNode) and changed.when is not None:
        return replace(changed, initial=_holds(changed, instance, report), when=None)
    return changed


def _holds(node: StateNode, instance: Instance, report: Report) -> bool:
    assert node.when is not None
    typer = Typer(report, instance.types, None, no_value("where a state is initial has no 'value'"))
    found = typer.check(node.when, BOOLEAN, "where a state is initial")
    value = None if found is None else constant(found)
    if found is not None and value is None:
        report.add(
            "initial-not-constant",
            node.when.span,
            f"where '{node.name.text}' is initial must be known before the robot runs",
            "read the index and constants only",
        )
    return bool(value)
