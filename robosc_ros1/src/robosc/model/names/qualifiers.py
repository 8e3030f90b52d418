"""The names before a dot that a file itself does not declare: they may be those of libraries."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from robosc.syntax import nodes

_WORDS = frozenset({"value", "index"})


def qualifiers(node: nodes.FileNode) -> tuple[nodes.Name, ...]:
    """``Geo`` of ``Geo.limit``, ``Geo.twice(x)`` or the type ``Geo.Side``: the first of each."""
    found: dict[str, nodes.Name] = {}
    declared = {item.name.text for item in node.declarations if hasattr(item, "name")}
    declared |= {
        item.name.text for part in _inside(node) for item in part.items if hasattr(item, "name")
    }
    for name in _named(node, frozenset(declared) | _WORDS):
        found.setdefault(name.text, name)
    return tuple(found.values())


def _inside(node: nodes.FileNode) -> Iterator[nodes.ComponentNode | nodes.BehaviourNode]:
    for component in node.declarations:
        if isinstance(component, nodes.ComponentNode):
            yield component
            yield from (item for item in component.items if isinstance(item, nodes.BehaviourNode))


def _named(node: Any, known: frozenset[str]) -> Iterator[nodes.Name]:
    if isinstance(node, tuple):
        for part in node:
            yield from _named(part, known)
        return
    if not is_dataclass(node) or isinstance(node, nodes.Name):
        return
    if isinstance(node, nodes.Access) and node.path and node.root.text not in known:
        yield node.root
    if isinstance(node, nodes.NamedTypeNode) and node.library is not None:
        yield node.library
    if isinstance(node, nodes.AggregateNode):
        known |= {name.text for name in (node.position, node.variable) if name is not None}
    if isinstance(node, nodes.FunctionNode):
        known |= {parameter.name.text for parameter in node.parameters}
    for field in fields(node):
        if field.compare:
            yield from _named(getattr(node, field.name), known)
