"""Texts of the messages about types."""

from __future__ import annotations

from robosc.language.operators import BINARY
from robosc.model.compatibility import describe
from robosc.model.expr import Expr, StateRef
from robosc.syntax.nodes import BinaryNode, ExprNode


def of_three(node: ExprNode, place: str) -> str | None:
    """The hint for ``a < x < b``, if a node is a comparison that is compared; else None."""
    orders = {f"'{o.spelling}'": o.spelling for o in BINARY.values() if o.is_comparison}
    if place not in orders or not isinstance(node, BinaryNode):
        return None
    if not BINARY[node.operator].is_comparison:
        return None
    middle = node.right.span.text
    return f"write {node.span.text} and {middle} {orders[place]} …"


VALUE_PLACES = (
    "'value' can be used in enum rules, in requirements on commands, and after 'on response',"
    " 'on feedback' and an action's 'on error'"
)


def alternatives(meanings: list[Expr]) -> str:
    """The types of a name's meanings as text: ``a state (a boolean) or a value of Way``."""
    return " or ".join(dict.fromkeys(_in_words(m) for m in meanings))


def _in_words(meaning: Expr) -> str:
    if isinstance(meaning, StateRef):
        return "a state (a boolean)"
    return describe(meaning.type)
