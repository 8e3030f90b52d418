"""pyparsing's methods by their names in version 3, also for version 2.4, which Ubuntu 22.04 has.

Version 2.4 calls them ``setName`` and so on; version 3.3 warns where it is called by these names.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import pyparsing
from pyparsing import ParserElement

_Element = TypeVar("_Element", bound=ParserElement)
_PREVIOUS = not hasattr(ParserElement, "set_name")


def _streamline_each_element_once() -> None:
    """Let version 2.4 prepare elements as version 3 does.

    It would prepare an element again for each place that uses it: exponentially often, where rules
    that are used twice use others twice.
    """

    def once(streamline: Callable[[Any], Any]) -> Callable[[Any], Any]:
        return lambda element: element if element.streamlined else streamline(element)

    kinds = [k for k in vars(pyparsing).values() if isinstance(k, type)]
    for kind in kinds:
        if issubclass(kind, ParserElement) and "streamline" in vars(kind):
            setattr(kind, "streamline", once(kind.streamline))  # noqa: B010 - as mypy takes it


if _PREVIOUS:
    _streamline_each_element_once()


def set_name(element: _Element, name: str) -> _Element:
    """Return the element, which messages call by this name."""
    (element.setName if _PREVIOUS else element.set_name)(name)
    return element


def leave_whitespace(element: _Element) -> _Element:
    """Return the element, which then skips nothing before what it matches."""
    (element.leaveWhitespace if _PREVIOUS else element.leave_whitespace)()
    return element


def set_parse_action(element: _Element, action: Callable[..., Any]) -> _Element:
    """Return the element, whose match the action then replaces by its result."""
    (element.setParseAction if _PREVIOUS else element.set_parse_action)(action)
    return element


def parse_string(element: ParserElement, text: str) -> Any:
    """Return what the element matches at the beginning of the text."""
    return (element.parseString if _PREVIOUS else element.parse_string)(text)
