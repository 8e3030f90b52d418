"""The meaning of the word ``value`` at some place of a model."""

from __future__ import annotations

from robosc.expr.types import EnumType, NoneType, StringType, Type
from robosc.language.events import Kind
from robosc.language.reasons import reasons_of
from robosc.lazy_dataclasses import dataclass
from robosc.syntax.nodes import Access

RULE = "the condition of a rule"
"""The text for the place of an enum rule's condition in messages."""
EXPECTATION = "'expect:'"
"""The text for what must hold of an answer."""


@dataclass(frozen=True)
class Incoming:
    """The type of ``value`` at a place, or None with the reason why there is no value.

    ``known`` is False if its type has an error: then reading it is not reported. ``optional`` says
    that the event may come without a value. ``reasons`` are the words that ``reason`` may be there.
    """

    type: Type | None
    reason: str = ""
    known: bool = True
    optional: bool = False
    reasons: EnumType | None = None


def reasons_type(kind: Kind) -> EnumType | None:
    """The type of ``reason`` in the errors of a kind of communication; None if it has none."""
    words = reasons_of(kind)
    return EnumType("reason", kind.value, StringType(), words, words[0], ()) if words else None


def no_value(reason: str) -> Incoming:
    """A place without a value; the reason is a message for the user."""
    return Incoming(None, reason)


def response_of(name: str, type_: Type | None) -> Incoming:
    """The response of a communication; None: its type has an error."""
    if isinstance(type_, NoneType):
        return no_value(f"the response of {name} carries no value")
    return Incoming(type_, known=type_ is not None)


def is_value(access: Access) -> bool:
    """Whether an access reads the word ``value``, or a part of it."""
    return access.root.text == "value" and not access.root.escaped
