"""The shape of a file: its outline, and the ranges that can be folded."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from robosc.language.tokens import tokenize
from robosc.lsp.analysis import Analysis, Desk
from robosc.source import Source, Span
from robosc.syntax.nodes import (
    ActionNode,
    BehaviourNode,
    ComponentNode,
    ConditionNode,
    ConstantNode,
    DeclarationNode,
    EnumNode,
    FileNode,
    ForNode,
    ImportNode,
    InterfaceNode,
    MessageNode,
    ObjectNode,
    ParameterNode,
    PreferNode,
    ProvideNode,
    RequirementNode,
    ServiceNode,
    StateNode,
    ValueNode,
    VariableNode,
)

__all__ = ["Found", "OutlineItem", "Fold", "folds", "outline", "symbols"]


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
        return self.kind not in ("requirement", "provide", "prefer", "for")


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


def symbols(desk: Desk, query: str) -> list[Found]:
    """What has a name in the models of a workspace, by letters that the name has in this order."""
    letters = re.compile(".*".join(map(re.escape, query)), re.IGNORECASE | re.DOTALL)
    found: list[Found] = []
    for root in (*desk.open, *(f"{folder}/" for folder in desk.folders)):
        for analysis in desk.related(root).values():
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
    node: FileNode = analysis.contents.scope.node
    node = node.written or node
    children = tuple(_declaration(d) for d in node.declarations)
    return (OutlineItem(node.name.text, node.kind, "", node.span, node.name.span, children),)


def _declaration(node: DeclarationNode) -> OutlineItem:
    match node:
        case ComponentNode():
            children = tuple(_inside(node))
            return OutlineItem(
                node.name.text, "component", "component", node.span, node.name.span, children
            )
        case ImportNode():
            detail = f"{node.component.text} from {node.library.text}"
            return OutlineItem(node.name.text, "component", detail, node.span, node.name.span)
        case RequirementNode():
            label = " ".join(node.span.text.split()).removeprefix("requirement ")
            return OutlineItem(label, "requirement", "requirement", node.span, node.span)
        case ProvideNode():
            name = node.communication
            return OutlineItem(name.span.text, "provide", "provide", node.span, name.span)
        case ObjectNode():
            children = tuple(
                OutlineItem(p.name.text, "property", p.type.span.text, p.span, p.name.span)
                for p in node.properties
            )
            return OutlineItem(
                node.name.text, "object", "object", node.span, node.name.span, children
            )
        case EnumNode():
            children = tuple(
                OutlineItem(r.value.text, "enum value", "", r.span, r.value.span)
                for r in node.rules
            )
            return OutlineItem(node.name.text, "enum", "enum", node.span, node.name.span, children)
        case InterfaceNode():
            detail = f"{node.package.text}/{node.type.text}"
            return OutlineItem(node.name.text, "interface", detail, node.span, node.name.span)
        case ConstantNode() | ParameterNode() | ConditionNode():
            return _value(node)
        case PreferNode():
            label = " ".join(node.span.text.split())
            return OutlineItem(label, "prefer", "prefer", node.span, node.span)
        case ForNode():
            label = f"for {node.variable.text} in {node.indexes.span.text}"
            children = tuple(_declaration(statement) for statement in node.statements)
            return OutlineItem(label, "for", "for", node.span, node.variable.span, children)


def _value(node: ValueNode) -> OutlineItem:
    kind = {ConstantNode: "constant", ParameterNode: "parameter"}.get(type(node), "condition")
    detail = kind if isinstance(node, ConditionNode) else node.type.span.text
    return OutlineItem(node.name.text, kind, detail, node.span, node.name.span)


def _inside(node: ComponentNode) -> Iterator[OutlineItem]:
    for item in node.items:
        match item:
            case MessageNode():
                detail = f"{item.direction} message"
                yield OutlineItem(
                    item.name.text, "communication", detail, item.span, item.name.span
                )
            case ServiceNode():
                yield OutlineItem(
                    item.name.text, "communication", "service", item.span, item.name.span
                )
            case ActionNode():
                yield OutlineItem(
                    item.name.text, "communication", "action", item.span, item.name.span
                )
            case BehaviourNode():
                yield from _behaviour(item)
            case ConstantNode() | ParameterNode() | ConditionNode():
                yield _value(item)


def _behaviour(node: BehaviourNode) -> Iterator[OutlineItem]:
    for item in node.items:
        match item:
            case VariableNode():
                detail = item.type.span.text
                yield OutlineItem(item.name.text, "variable", detail, item.span, item.name.span)
            case StateNode():
                words = ["initial"] * item.initial + ["marked"] * item.marked
                detail = " ".join(words)
                yield OutlineItem(item.name.text, "state", detail, item.span, item.name.span)


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
