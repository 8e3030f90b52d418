"""What the word value means at a place, and the place of an enum's rule."""

from __future__ import annotations

from dataclasses import dataclass

from robosc.model.scope import is_escaped
from robosc.model.types import Type
from robosc.syntax.nodes import Access

__all__ = ["Incoming", "RULE", "is_value", "no_value"]

RULE = "the condition of a rule"
"""The place that an enum's rule is."""


@dataclass(frozen=True)
class Incoming:
    """What ``value`` means at a place: a type, or None with the reason why it means nothing.

    ``known`` is False where its type has an error: then whatever reads it is silent. ``optional``
    says that it may not have come.
    """

    type: Type | None
    reason: str = ""
    known: bool = True
    optional: bool = False


def no_value(reason: str) -> Incoming:
    return Incoming(None, reason)


def is_value(access: Access) -> bool:
    return access.root.text == "value" and not is_escaped(access.root)
