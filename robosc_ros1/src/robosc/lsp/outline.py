"""The shape of a file: its outline, and the ranges that can be folded."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

from robosc.language.attributes import TRANSFORM
from robosc.language.tokens import tokenize
from robosc.lazy_dataclasses import dataclass
from robosc.lsp.analysis import Analysis, Workspace
from robosc.model.names.occurrences import kind_of
from robosc.source import Source, Span
from robosc.syntax import nodes

_Node: TypeAlias = (
    nodes.DeclarationNode
    | nodes.CommunicationNode
    | nodes.PropertyNode
    | nodes.EnumRuleNode
    | nodes.VariableNode
    | nodes.StateNode
)


@dataclass(frozen=True, slots=True)
class OutlineItem:
    """``name`` is the range of the name, within ``whole``."""

    label: str
    kind: str
    detail: str
    whole: Span
    name: Span
    children: tuple[OutlineItem, ...] = ()

    @property
    def is_named(self) -> bool:
        """Whether it declares its label."""
        return self.kind not in ("requirement", "provide", "prefer", "stop", "for")


@dataclass(frozen=True, slots=True)
class Fold:
    """First and last line, from 1."""

    first: int
    last: int
    comment: bool = False


@dataclass(frozen=True, slots=True)
class Found:
    """An entry of an outline, and the name of the entry that it stands in."""

    item: OutlineItem
    inside: str


def symbols(workspace: Workspace, query: str) -> list[Found]:
    """What has a name in the models of a workspace, by letters that the name has in this order."""
    letters = re.compile(".*".join(map(re.escape, query)), re.IGNORECASE | re.DOTALL)
    found: list[Found] = []
    for root in (*workspace.open, *(f"{folder}/" for folder in workspace.folders)):
        for analysis in workspace.related(root).values():
            found += [Found(i, inside) for i, inside in _flat(outline(analysis)) if i.is_named]
    unique = {(f.item.name.source.path, f.item.name.start): f for f in found}
    return [f for f in unique.values() if letters.search(f.item.label)]


def _flat(items: Iterable[OutlineItem], inside: str = "") -> Iterator[tuple[OutlineItem, str]]:
    for item in items:
        yield item, inside
        yield from _flat(item.children, item.label)


def outline(analysis: Analysis) -> tuple[OutlineItem, ...]:
    """The declarations of a file as a tree; empty if nothing could be read."""
    if analysis.contents is None:
        return ()
    node: nodes.FileNode = analysis.contents.scope.node
    node = node.written or node
    return (_named(node, node.kind, "", node.declarations),)


def _item(node: _Node) -> OutlineItem:
    match node:
        case nodes.ComponentNode():
            return _named(node, "component", "component", _members(node))
        case nodes.ImportNode():
            return _named(node, "component", f"{node.component.text} from {node.library.text}")
        case nodes.ObjectNode():
            return _named(node, "object", "object", node.properties)
        case nodes.EnumNode():
            return _named(node, "enum", "enum", node.rules)
        case nodes.EnumRuleNode(value=value):
            return OutlineItem(value.text, "enum value", "", node.span, value.span)
        case (
            nodes.PropertyNode()
            | nodes.VariableNode()
            | nodes.ConstantNode()
            | nodes.ParameterNode()
        ):
            return _named(node, _TYPED[type(node)], node.type.span.text)
        case nodes.ConditionNode():
            return _named(node, "condition", "condition")
        case nodes.FunctionNode():
            return _named(node, "function", node.type.span.text)
        case nodes.InterfaceNode():
            return _named(node, "interface", f"{node.package.text}/{node.type.text}")
        case nodes.TransformNode():
            return _named(node, "communication", TRANSFORM)
        case nodes.MessageNode():
            return _named(node, "communication", f"{node.direction} message")
        case nodes.ServiceNode() | nodes.ActionNode():
            return _named(node, "communication", kind_of(node).value)
        case nodes.StateNode():
            words = ["initial"] * node.initial + ["marked"] * node.marked
            if node.performs is not None:
                words.append(f"performs {node.performs.communication.span.text}")
            return _named(node, "state", " ".join(words), node.states)
        case nodes.RequirementsNode(title=title):
            children = tuple(map(_item, node.statements))
            return OutlineItem(
                title.text, "requirement", "requirement", node.span, title.span, children
            )
        case nodes.RequirementNode() | nodes.PossibleNode() | nodes.AssumeNode():
            label = " ".join(node.span.text.split()).removeprefix("requirement ")
            return OutlineItem(label, "requirement", "requirement", node.span, node.span)
        case nodes.ProvideNode(communication=name):
            return OutlineItem(name.span.text, "provide", "provide", node.span, name.span)
        case nodes.PreferNode():
            label = " ".join(node.span.text.split())
            return OutlineItem(label, "prefer", "prefer", node.span, node.span)
        case nodes.StopNode(communication=name):
            return OutlineItem(name.span.text, "stop", "stop", node.span, name.span)
        case nodes.ForNode():
            label = f"for {node.variable.text} in {node.indexes.span.text}"
            children = tuple(map(_item, node.statements))
            return OutlineItem(label, "for", "for", node.span, node.variable.span, children)


_TYPED = {
    nodes.PropertyNode: "property", nodes.VariableNode: "variable", nodes.ConstantNode: "constant",
    nodes.ParameterNode: "parameter",
}  # fmt: skip


def _named(node: Any, kind: str, detail: str, inside: Iterable[_Node] = ()) -> OutlineItem:
    """The entry of a node with a name."""
    children = tuple(map(_item, inside))
    return OutlineItem(node.name.text, kind, detail, node.span, node.name.span, children)


def _members(node: nodes.ComponentNode) -> Iterator[_Node]:
    """The declarations of a component, and the variables and states of its behaviour."""
    for item in node.items:
        if isinstance(item, nodes.BehaviourNode):
            yield from (
                i for i in item.items if isinstance(i, nodes.VariableNode | nodes.StateNode)
            )
        else:
            yield item


def folds(source: Source) -> list[Fold]:
    """Blocks in braces and comments that are longer than a line, whatever the model's state."""
    tokens = tokenize(source)
    found: list[Fold] = []
    opened: list[int] = []
    for kind, offset in zip(tokens.kinds, tokens.starts, strict=True):
        if kind == "{":
            opened.append(source.position(offset)[0])
        elif kind == "}" and opened:
            first, last = opened.pop(), source.position(offset)[0] - 1
            if last > first:
                found.append(Fold(first, last))
    start = end = 0
    for comment in tokens.comments:
        first, last = source.position(comment.start)[0], source.position(comment.end)[0]
        own = not source.line(first)[: source.position(comment.start)[1] - 1].strip()
        if own and first == end + 1 and start:
            end = last
            continue
        if end > start:
            found.append(Fold(start, end, comment=True))
        start, end = (first, last) if own else (0, 0)
    if end > start:
        found.append(Fold(start, end, comment=True))
    return found


# The table of kinds: how editors show each kind of name, declaration and completion.


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
