"""The table of attributes: the labels after the ``with`` of a communication.

Each attribute is a field of the syntax node of its communication.
"""

from __future__ import annotations

from enum import Enum

from robosc.lazy_dataclasses import dataclass


class Value(Enum):
    """The kind of value that an attribute has."""

    STRING = "a string"
    DURATION = "a duration"
    CONDITION = "a condition"
    RATE = "a rate, such as '20 Hz', or 'once'"
    REPLACE = "'replace'"
    NONE = "'none'"
    TYPE = "a type"


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute, written ``name: value``, and the kinds of communication that have it.

    ``communications`` are the keywords of these kinds; ``required``: each of them must have it.
    ``meaning`` continues the sentence "as a label, …".
    """

    name: str
    value: Value
    communications: tuple[str, ...]
    required: bool
    meaning: str

    @property
    def field(self) -> str:
        """The field of the syntax node: where the name is a word of Python, another one."""
        return {"from": "source", "to": "target"}.get(self.name, self.name)


TRANSFORM = "outgoing transform"
TRANSFORM_TYPE = ("geometry_msgs", "TransformStamped")
_MESSAGES = ("incoming", "outgoing")
_CALLS = ("service", "action")
_SERVED = ("outgoing service", "outgoing action")

ATTRIBUTES = (
    Attribute("identifier", Value.STRING, (*_MESSAGES, *_CALLS, *_SERVED), False,
              "the name of the topic, service or action in ROS"),
    Attribute("from", Value.STRING, (TRANSFORM,), True,
              "the frame in which a transform gives the pose of another one"),
    Attribute("to", Value.STRING, (TRANSFORM,), True,
              "the frame whose pose a transform gives"),
    Attribute("timeout", Value.DURATION, ("outgoing", TRANSFORM, *_CALLS), False,
              "the time after which a message is silent, or the deadline of a service or action"),
    Attribute("max_age", Value.DURATION, ("outgoing", TRANSFORM), False,
              "the age, by the stamp of its header, from which a message counts as not arrived"),
    Attribute("within", Value.DURATION, ("action",), False,
              "the time after which an accepted goal is cancelled"),
    Attribute("expect", Value.CONDITION, _CALLS, False,
              "what must hold of the answer of a service or action; any other answer is an error"),
    Attribute("goals", Value.REPLACE, ("action",), False,
              "`replace`: a goal may be requested while another one is busy, and replaces it"),
    Attribute("rate", Value.RATE, ("incoming", TRANSFORM, *_CALLS, *_SERVED), False,
              "how often a command is sent while it is allowed, or that it is sent `once`; how"
              " often a transform comes at most"),
    Attribute("stop", Value.NONE, ("incoming",), False,
              "`none`: what is sent to its topic moves nothing, so nothing need stop it"),
    Attribute("type", Value.TYPE, _MESSAGES, True, "the type of a message"),
    Attribute("request", Value.TYPE, (*_CALLS, *_SERVED), True, "the type of what is sent"),
    Attribute("response", Value.TYPE, (*_CALLS, *_SERVED), True, "the type of what comes back"),
    Attribute("feedback", Value.TYPE, ("action", "outgoing action"), True,
              "the type of what is reported"),
)  # fmt: skip
"""All attributes, in the order in which messages name them: types stand last in a model."""


def attributes_of(communication: str) -> tuple[Attribute, ...]:
    """Return the attributes of a kind of communication; ``communication`` is its keyword."""
    return tuple(a for a in ATTRIBUTES if communication in a.communications)
