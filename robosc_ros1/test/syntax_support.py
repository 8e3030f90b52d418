"""Short ways to read model text in tests and to look at the trees."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from typing import Any

from robosc.errors import Diagnostic, render_all
from robosc.source import Source
from robosc.syntax.nodes import (
    Access,
    ArrayTypeNode,
    BasicTypeNode,
    BinaryNode,
    ExprNode,
    FileNode,
    LiteralNode,
    Name,
    NamedTypeNode,
    RequirementNode,
    StringNode,
    UnaryNode,
)
from robosc.syntax.parser import parse

__all__ = ["declarations", "expression", "faults", "mistaken", "parsed", "read", "shown", "told"]


def read(text: str) -> tuple[FileNode | None, tuple[Diagnostic, ...]]:
    return parse(Source("model.rscd", text))


def parsed(text: str) -> FileNode:
    """The tree of a text without faults."""
    tree, diagnostics = read(text)
    assert not diagnostics, render_all(diagnostics)
    assert tree is not None
    return tree


def declarations(text: str) -> list[str]:
    """What a robot with these declarations holds, one short line each."""
    return [shown(node) for node in parsed(f"robot R {{\n{text}\n}}").declarations]


def expression(text: str) -> ExprNode:
    (requirement,) = parsed(f"robot R {{ requirement always {text}\n}}").declarations
    assert isinstance(requirement, RequirementNode)
    return requirement.condition


def faults(text: str) -> str:
    """All messages, as a user sees them."""
    return render_all(read(text)[1])


def shown(node: Any) -> str:
    """A node without its spans, expressions with all parentheses."""
    match node:
        case None:
            return "-"
        case NamedTypeNode(name=name, library=Name(text=library)):
            return f"{library}.{shown(name)}"
        case Name(text=text) | NamedTypeNode(name=Name(text=text)):
            return str(text)
        case Access(root=root, path=path, index=index):
            return (
                root.text
                + (f"[{shown(index)}]" if index else "")
                + "".join(f"[{p}]" if isinstance(p, int) else f".{p.text}" for p in path)
            )
        case LiteralNode(value=value):
            return repr(value)
        case StringNode(text=text):
            return repr(text)
        case UnaryNode(operator=operator, operand=operand):
            return f"({operator}{shown(operand)})"
        case BinaryNode(operator=operator, left=left, right=right):
            return f"({shown(left)} {operator} {shown(right)})"
        case BasicTypeNode(name=name, bounds=None):
            return str(name)
        case BasicTypeNode(name=name, bounds=(low, high)):
            return f"{name}({low}..{high})"
        case ArrayTypeNode(element=element):
            return f"array({shown(element)})"
        case tuple():
            return f"[{', '.join(map(shown, node))}]"
        case _ if is_dataclass(node):
            shown_fields = [f for f in fields(node) if f.compare]
            while shown_fields and getattr(node, shown_fields[-1].name) == shown_fields[-1].default:
                shown_fields.pop()
            parts = [shown(getattr(node, f.name)) for f in shown_fields]
            return f"{type(node).__name__.removesuffix('Node')}({', '.join(parts)})"
    return str(node)


def mistaken(text: str, right: str, wrong: str) -> str:
    """A text with one mistake in it."""
    assert right in text
    return text.replace(right, wrong, 1)


def told(diagnostics: Iterable[Diagnostic]) -> list[tuple[str, str | None]]:
    """The text that each diagnostic marks, and its hint."""
    return [(one.span.text, None if one.hint is None else str(one.hint)) for one in diagnostics]
