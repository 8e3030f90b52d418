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
    """``name: value`` of some kinds of communication; a required one stands in all of them."""

    name: str
    value: Value
    communications: tuple[str, ...]
    required: bool


_MESSAGES = ("incoming", "outgoing")
_CALLS = ("service", "action")

ATTRIBUTES = (
    Attribute("identifier", Value.STRING, (*_MESSAGES, *_CALLS), required=False),
    Attribute("timeout", Value.DURATION, ("outgoing", *_CALLS), required=False),
    Attribute("type", Value.TYPE, _MESSAGES, required=True),
    Attribute("request", Value.TYPE, _CALLS, required=True),
    Attribute("response", Value.TYPE, _CALLS, required=True),
    Attribute("feedback", Value.TYPE, ("action",), required=True),
)
"""All of them, in the order in which they stand."""


def attributes_of(communication: str) -> tuple[Attribute, ...]:
    """The attributes of ``incoming`` or ``outgoing`` messages, ``service`` or ``action``."""
    return tuple(a for a in ATTRIBUTES if communication in a.communications)
