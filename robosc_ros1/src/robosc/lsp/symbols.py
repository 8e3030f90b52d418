"""What a name can mean, with the place where that is declared."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from robosc.source import Span

__all__ = ["Occurrence", "Symbol", "SymbolKind"]


class SymbolKind(Enum):
    ROBOT = "robot"
    LIBRARY = "library"
    COMPONENT = "component"
    COMMUNICATION = "communication"
    STATE = "state"
    VARIABLE = "variable"
    OBJECT = "object"
    PROPERTY = "property"
    ENUM = "enum"
    VALUE = "enum value"
    INTERFACE = "interface"
    ROS_TYPE = "ROS type"
    ROS_PACKAGE = "ROS package"
    INCOMING = "value"


@dataclass(frozen=True, slots=True)
class Symbol:
    """Something that has a name. ``owner`` is the component, datatype or ROS package it is part of.

    ``declared`` is the name in its declaration, in this file or a library; None for what is not
    declared in a model. ``whole`` is the declaration, ``detail`` what it is in a few words. Symbols
    are equal if they are declared at one place.
    """

    kind: SymbolKind
    name: str
    owner: str = ""
    declared: Span | None = field(default=None, compare=False)
    whole: Span | None = field(default=None, compare=False, repr=False)
    detail: str = field(default="", compare=False)

    @property
    def key(self) -> tuple[str, str, int] | None:
        """Tells what is declared in models apart, whichever file refers to it."""
        if self.declared is None:
            return None
        return self.kind.value, self.declared.source.path, self.declared.start


@dataclass(frozen=True, slots=True)
class Occurrence:
    """A name in a text; ``escaped`` as it was written with ``^``."""

    span: Span
    symbol: Symbol
    declaration: bool = False
    write: bool = False

    @property
    def escaped(self) -> bool:
        return self.span.text.startswith("^")
