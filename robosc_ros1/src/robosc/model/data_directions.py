"""The data types of a communication's node by direction, and its kind."""

from __future__ import annotations

from robosc.language.events import Direction, Kind
from robosc.syntax.nodes import CommunicationNode, MessageNode, ServiceNode, TypeNode

__all__ = ["kind_of", "types_of"]


def kind_of(node: CommunicationNode) -> Kind:
    """The kind of communication that a node declares."""
    match node:
        case MessageNode(direction="incoming"):
            return Kind.INCOMING
        case MessageNode():
            return Kind.OUTGOING
        case ServiceNode():
            return Kind.SERVICE
    return Kind.ACTION


def types_of(node: CommunicationNode) -> dict[Direction, TypeNode]:
    """The types in the order in which a ROS definition has them."""
    match node:
        case MessageNode(direction="incoming"):
            return {"request": node.type}
        case MessageNode():
            return {"response": node.type}
        case ServiceNode():
            return {"request": node.request, "response": node.response}
    return {"request": node.request, "response": node.response, "feedback": node.feedback}
