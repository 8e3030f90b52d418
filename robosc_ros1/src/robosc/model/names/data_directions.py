"""The data types of a communication's node by direction, and its kind."""

from __future__ import annotations

from robosc.language.events import COMMUNICATIONS, Direction, Kind
from robosc.syntax.nodes import (
    CommunicationNode,
    MessageNode,
    ServedActionNode,
    ServedServiceNode,
    ServiceNode,
    TypeNode,
)


def kind_of(node: CommunicationNode) -> Kind:
    """Return the kind of communication that a node declares."""
    match node:
        case MessageNode(direction="incoming"):
            return Kind.INCOMING
        case MessageNode():
            return Kind.OUTGOING
        case ServedActionNode():
            return Kind.SERVED_ACTION
        case ServedServiceNode():
            return Kind.SERVED_SERVICE
        case ServiceNode():
            return Kind.SERVICE
    return Kind.ACTION


def types_of(node: CommunicationNode) -> dict[Direction, TypeNode]:
    """Return the types in the order in which a ROS definition has them."""
    parts = COMMUNICATIONS[kind_of(node)].parts
    if isinstance(node, MessageNode):
        return dict.fromkeys(parts, node.type)
    return {part: getattr(node, part) for part in parts}
