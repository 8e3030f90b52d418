"""The data types of a communication's node by direction, and its kind."""

from __future__ import annotations

from robosc.language import events
from robosc.syntax import nodes

_KINDS = {
    nodes.ServiceNode: events.Kind.SERVICE,
    nodes.ActionNode: events.Kind.ACTION,
    nodes.ServedServiceNode: events.Kind.SERVED_SERVICE,
    nodes.ServedActionNode: events.Kind.SERVED_ACTION,
}


def kind_of(node: nodes.CommunicationNode) -> events.Kind:
    """Return the kind of communication that a node declares."""
    if isinstance(node, nodes.MessageNode):
        return events.Kind(f"{node.direction} message")
    return _KINDS[type(node)]


def types_of(node: nodes.CommunicationNode) -> dict[events.Direction, nodes.TypeNode]:
    """Return the types in the order in which a ROS definition has them."""
    parts = events.COMMUNICATIONS[kind_of(node)].parts
    if isinstance(node, nodes.MessageNode):
        return dict.fromkeys(parts, node.type)
    return {part: getattr(node, part) for part in parts}
