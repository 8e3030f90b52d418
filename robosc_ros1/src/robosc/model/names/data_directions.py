"""The data types of a communication's node by direction, and its kind."""

from __future__ import annotations

from robosc.language import events
from robosc.syntax import nodes


def kind_of(node: nodes.CommunicationNode) -> events.Kind:
    """Return the kind of communication that a node declares."""
    match node:
        case nodes.MessageNode(direction="incoming"):
            return events.Kind.INCOMING
        case nodes.MessageNode():
            return events.Kind.OUTGOING
        case nodes.ServedActionNode():
            return events.Kind.SERVED_ACTION
        case nodes.ServedServiceNode():
            return events.Kind.SERVED_SERVICE
        case nodes.ServiceNode():
            return events.Kind.SERVICE
    return events.Kind.ACTION


def types_of(node: nodes.CommunicationNode) -> dict[events.Direction, nodes.TypeNode]:
    """Return the types in the order in which a ROS definition has them."""
    parts = events.COMMUNICATIONS[kind_of(node)].parts
    if isinstance(node, nodes.MessageNode):
        return dict.fromkeys(parts, node.type)
    return {part: getattr(node, part) for part in parts}
