"""The table of kinds: how editors show each kind of name, declaration and completion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Shown(NamedTuple):
    """How one kind is shown; a field is empty where the kind does not occur.

    ``symbol`` and ``item`` are members of the protocol's ``SymbolKind`` and ``CompletionItemKind``,
    ``token`` is a type of semantic tokens.
    """

    symbol: str
    item: str
    token: str


KINDS: Mapping[str, Shown] = {
    "robot": Shown("Module", "", "namespace"),
    "library": Shown("Module", "Module", "namespace"),
    "component": Shown("Class", "Class", "class"),
    "communication": Shown("Event", "Event", "event"),
    "state": Shown("EnumMember", "EnumMember", "enumMember"),
    "variable": Shown("Variable", "Variable", "variable"),
    "object": Shown("Struct", "Struct", "struct"),
    "property": Shown("Property", "Property", "property"),
    "enum": Shown("Enum", "Enum", "enum"),
    "enum value": Shown("EnumMember", "EnumMember", "enumMember"),
    "interface": Shown("Interface", "Interface", "interface"),
    "constant": Shown("Constant", "Constant", "variable"),
    "parameter": Shown("Constant", "Constant", "variable"),
    "condition": Shown("Boolean", "Variable", "variable"),
    "function": Shown("Function", "Function", "function"),
    "ROS type": Shown("", "Interface", "type"),
    "ROS package": Shown("", "Module", "namespace"),
    "ROS constant": Shown("", "", "enumMember"),
    "value": Shown("", "Variable", "parameter"),
    "requirement": Shown("Boolean", "", ""),
    "provide": Shown("Constructor", "", ""),
    "prefer": Shown("Operator", "", ""),
    "stop": Shown("Event", "", ""),
    "for": Shown("Array", "", ""),
    "keyword": Shown("", "Keyword", ""),
    "snippet": Shown("", "Snippet", ""),
}
"""The kinds of names (see ``SymbolKind``), of other declarations, and of other completions."""
