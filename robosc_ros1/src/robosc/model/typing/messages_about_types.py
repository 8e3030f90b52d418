"""Texts of the messages about types."""

from __future__ import annotations

from robosc.expr import tree, types
from robosc.language.operators import BINARY
from robosc.model.typing import compatibility, value_word
from robosc.model.typing.expected import ExpectedType
from robosc.remedies import Change, Hint, Remedy, write
from robosc.syntax.nodes import BinaryNode, ExprNode, LiteralNode


def _of_three(node: ExprNode, place: str) -> str | None:
    """The hint for ``a < x < b``, if a node is a comparison that is compared; else None."""
    orders = {f"'{o.spelling}'": o.spelling for o in BINARY.values() if o.is_comparison}
    if place not in orders or not isinstance(node, BinaryNode):
        return None
    if not BINARY[node.operator].is_comparison:
        return None
    middle = node.right.span.text
    return f"write {node.span.text} and {middle} {orders[place]} …"


VALUE_PLACES = (
    "'value' can be used in enum rules, in requirements on commands and their data, and after"
    " 'on request', 'on response', 'on feedback' and an action's 'on error'"
)


def alternatives(meanings: list[tree.Expr]) -> str:
    """The types of a name's meanings as text: ``a state (a boolean) or a value of Way``."""
    return " or ".join(dict.fromkeys(_in_words(m) for m in meanings))


def _in_words(meaning: tree.Expr) -> str:
    if isinstance(meaning, tree.StateRef):
        return "a state (a boolean)"
    return compatibility.describe(meaning.type)


def _unquoted(value: object, expected: ExpectedType) -> str | None:
    """A number or boolean that is written in quotes; None for everything else."""
    if not isinstance(value, str):
        return None
    if value in ("true", "false") and expected.accepts(types.BooleanType()):
        return value
    is_number = value.replace(".", "", 1).removeprefix("-").isdecimal()
    return value if is_number and expected.accepts(types.DoubleType()) else None


def hint_for(node: ExprNode, given: types.Type, expected: ExpectedType, place: str) -> Hint | None:
    """The remedy for an expression whose type does not fit its place; None if there is no usual."""
    if isinstance(expected.type, types.DurationType):
        return "write a number with a unit: 500 ms, 0.5 s, 2 min or 1 h"
    if isinstance(expected.type, types.IntegerType) and isinstance(given, types.DoubleType):
        return "a double is never converted to an integer implicitly"
    if isinstance(given, types.ObjectType):
        fitting = [name for name, type_ in given.properties if expected.accepts(type_)]
        if len(fitting) == 1:  # of std_msgs/Float32, for one
            return write(f"{node.span.text}.{fitting[0]}")
    if (comparison := _of_three(node, place)) is not None:
        return comparison
    if isinstance(node, LiteralNode) and (unquoted := _unquoted(node.value, expected)):
        return write(unquoted, ", without quotes")
    if place == "'=>'":
        return "'=>' means 'implies': write >= to compare"
    literal = place == value_word.RULE and isinstance(node, LiteralNode)
    if not literal:
        return None
    meant = f"value = {node.span.text}"
    return Remedy(f"write: {meant}", Change.REPLACE, (meant,))
