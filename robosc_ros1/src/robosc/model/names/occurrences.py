"""Index of the names of a file: place and symbol of each, recorded while the file is resolved.

The language server uses it for definition, references, renaming, hover and highlighting, so that
editors resolve names exactly as the compiler does.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import field
from enum import Enum
from functools import cached_property
from typing import TypeAlias

from robosc.language import events
from robosc.lazy_dataclasses import dataclass
from robosc.source import Span
from robosc.syntax import nodes

# The data types of a communication's node by direction, and its kind.


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


class SymbolKind(Enum):
    """The kinds of named things; the values are texts for users."""

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
    CONSTANT = "constant"
    PARAMETER = "parameter"
    CONDITION = "condition"
    FUNCTION = "function"
    ROS_TYPE = "ROS type"
    ROS_PACKAGE = "ROS package"
    ROS_CONSTANT = "ROS constant"
    INCOMING = "value"


@dataclass(frozen=True, slots=True)
class Symbol:
    """A named thing. ``owner`` is the component, datatype or ROS package that it is part of.

    ``declared`` is the span of the name in its declaration, in this file or a library; None if no
    model declares it. ``whole`` is the span of the declaration, ``detail`` a short text about it.
    """

    kind: SymbolKind
    name: str
    owner: str = ""
    declared: Span | None = field(default=None, compare=False)
    whole: Span | None = field(default=None, compare=False, repr=False)
    detail: str = field(default="", compare=False)

    @property
    def key(self) -> tuple[str, str, int] | None:
        """Kind, path and offset of the declaration, the same in all files; None without one."""
        if self.declared is None:
            return None
        return self.kind.value, self.declared.source.path, self.declared.start


@dataclass(frozen=True, slots=True)
class Occurrence:
    """A name in a text. ``write`` is True for the target of an assignment."""

    span: Span
    symbol: Symbol
    declaration: bool = False
    write: bool = False


@dataclass(frozen=True)
class NameIndex:
    """The names of one file in reading order."""

    occurrences: tuple[Occurrence, ...] = ()

    @cached_property
    def _starts(self) -> list[int]:
        return [o.span.start for o in self.occurrences]

    def at(self, offset: int) -> Occurrence | None:
        """The name that contains an offset, or ends there if no other one begins."""
        place = bisect_right(self._starts, offset) - 1
        if place < 0:
            return None
        found = self.occurrences[place]
        return found if found.span.end >= offset else None

    def of(self, symbol: Symbol) -> Iterator[Occurrence]:
        """The occurrences of a symbol in this file."""
        key = symbol.key
        for occurrence in self.occurrences:
            other = occurrence.symbol
            if other.key == key if key is not None else other == symbol:
                yield occurrence


_Named: TypeAlias = (
    nodes.FileNode
    | nodes.ComponentNode
    | nodes.ImportNode
    | nodes.CommunicationNode
    | nodes.StateNode
    | nodes.VariableNode
    | nodes.ObjectNode
    | nodes.PropertyNode
    | nodes.EnumNode
    | nodes.InterfaceNode
    | nodes.ValueNode
    | nodes.FunctionNode
)
Declaration: TypeAlias = _Named | nodes.EnumRuleNode


class NameRecorder:
    """Records names while a file is resolved; the last record for a place counts.

    A library's components are resolved again for each import. Its recorder is closed before that,
    so that its names keep the meanings that they have in the library.
    """

    def __init__(self) -> None:
        self._found: dict[int, Occurrence] = {}
        self._symbols: dict[tuple[int, str], Symbol] = {}
        self._used: set[int] = set()
        self._closed = False

    def declare(self, node: Declaration, owner: str = "") -> None:
        """Record the name in a declaration; ``owner`` is the enclosing component or datatype."""
        if not self._closed:
            symbol = self._symbol(node, owner)
            assert symbol.declared is not None
            self._found[symbol.declared.start] = Occurrence(symbol.declared, symbol, True)

    def use(
        self, name: nodes.Name, node: Declaration | None, owner: str = "", *, write: bool = False
    ) -> None:
        """Record a name that refers to a declaration; nothing if that is None."""
        if node is not None and not self._closed:
            self._used.add(id(node))
            copy = node.copy if isinstance(node, nodes.ComponentNode | nodes.ImportNode) else None
            if copy is not None and name.span.text.lstrip("^") != copy.family:
                return  # the variable of an aggregate over components, expanded to one of them
            symbol = self._symbol(node, owner)
            self._found[name.span.start] = Occurrence(name.span, symbol, False, write)

    def note(self, name: nodes.Name, symbol: Symbol) -> None:
        """Record the name of something that no model declares."""
        if not self._closed:
            self._found[name.span.start] = Occurrence(name.span, symbol)

    def is_used(self, node: Declaration) -> bool:
        """Whether anything in the file refers to a declaration."""
        return id(node) in self._used

    def close(self) -> None:
        """Ignore all further names."""
        self._closed = True

    @cached_property
    def index(self) -> NameIndex:
        """All names; only once the recorder is closed."""
        assert self._closed
        return NameIndex(tuple(sorted(self._found.values(), key=lambda o: o.span.start)))

    def _symbol(self, node: Declaration, owner: str) -> Symbol:
        key = id(node), owner
        if key not in self._symbols:
            self._symbols[key] = _symbol_of(node, owner)
        return self._symbols[key]


def _symbol_of(node: Declaration, owner: str) -> Symbol:
    if isinstance(node, nodes.EnumRuleNode):
        name = node.value
        kind, detail = SymbolKind.VALUE, f"value of {owner}"
    else:
        name = node.name
        kind, detail = _kind_and_detail(node)
    return Symbol(kind, name.text, owner, name.span, node.span, detail)


def _kind_and_detail(node: _Named) -> tuple[SymbolKind, str]:
    match node:
        case nodes.FileNode(kind="robot"):
            return SymbolKind.ROBOT, "robot"
        case nodes.FileNode():
            return SymbolKind.LIBRARY, "library"
        case nodes.ComponentNode():
            return SymbolKind.COMPONENT, "component"
        case nodes.ImportNode(library=library, component=component):
            return SymbolKind.COMPONENT, f"component {component.text} of library {library.text}"
        case nodes.MessageNode() | nodes.ServiceNode() | nodes.ActionNode():
            types = " → ".join(type_.span.text for type_ in types_of(node).values())
            return SymbolKind.COMMUNICATION, f"{kind_of(node).value}: {types}"
        case nodes.StateNode():
            words = ["initial"] * node.initial + ["marked"] * node.marked + ["state"]
            if node.performs is not None:
                words.append(f"that performs {node.performs.communication.span.text}")
            return SymbolKind.STATE, " ".join(words)
        case nodes.VariableNode(type=type_):
            return SymbolKind.VARIABLE, f"variable: {type_.span.text}"
        case nodes.ObjectNode():
            return SymbolKind.OBJECT, "datatype object"
        case nodes.PropertyNode(type=type_):
            return SymbolKind.PROPERTY, f"property: {type_.span.text}"
        case nodes.EnumNode(source=source):
            return SymbolKind.ENUM, f"datatype enum from {source.span.text}"
        case nodes.ConstantNode(type=type_):
            return SymbolKind.CONSTANT, f"constant: {type_.span.text}"
        case nodes.ParameterNode(type=type_):
            return SymbolKind.PARAMETER, f"parameter of the node: {type_.span.text}"
        case nodes.ConditionNode(value=value, duration=duration):
            lasting = "" if duration is None else f" for {duration.span.text}"
            return SymbolKind.CONDITION, f"condition = {value.span.text}{lasting}"
        case nodes.FunctionNode():
            return SymbolKind.FUNCTION, " ".join(node.span.text.split())
        case nodes.InterfaceNode(package=package, type=ros_type):
            return SymbolKind.INTERFACE, f"interface: {package.text}/{ros_type.text}"
