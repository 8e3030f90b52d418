"""The table of attributes: what stands behind the ``with`` of a communication.

Each attribute is a field of the node of its communication, by the same name.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

__all__ = ["ATTRIBUTES", "Attribute", "Value", "attributes_of"]


class Value(Enum):
    """What the value of an attribute is."""

    STRING = "a string"
    DURATION = "a duration"
    TYPE = "a type"


@dataclass(frozen=True, slots=True)
class Attribute:
    """``name: value`` of some kinds of communication; a required one stands in all of them.

    ``meaning`` continues a sentence: "as a label, …".
    """

    name: str
    value: Value
    communications: tuple[str, ...]
    required: bool
    meaning: str


_MESSAGES = ("incoming", "outgoing")
_CALLS = ("service", "action")

ATTRIBUTES = (
    Attribute("identifier", Value.STRING, (*_MESSAGES, *_CALLS), False,
              "the name of the topic, service or action in ROS"),
    Attribute("timeout", Value.DURATION, ("outgoing", *_CALLS), False,
              "the time after which a message is silent, or the deadline of a service or action"),
    Attribute("type", Value.TYPE, _MESSAGES, True, "the type of a message"),
    Attribute("request", Value.TYPE, _CALLS, True, "the type of what is sent"),
    Attribute("response", Value.TYPE, _CALLS, True, "the type of what comes back"),
    Attribute("feedback", Value.TYPE, ("action",), True, "the type of what is reported"),
)  # fmt: skip
"""All of them, in the order in which they stand."""


def attributes_of(communication: str) -> tuple[Attribute, ...]:
    """The attributes of ``incoming`` or ``outgoing`` messages, ``service`` or ``action``."""
    return tuple(a for a in ATTRIBUTES if communication in a.communications)
