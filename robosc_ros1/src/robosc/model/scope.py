"""What one file declares: its tables of names, and which parts of it the parser had to give up.

A syntax error can swallow declarations. Names that were declared in swallowed text are *lost*:
references to them are silent, since the syntax error was reported already.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

from robosc.errors import Diagnostic, Note, Severity
from robosc.model.report import Report
from robosc.source import Source, Span
from robosc.syntax.nodes import (
    ComponentNode,
    EnumNode,
    FileNode,
    ImportNode,
    InterfaceNode,
    Name,
    ObjectNode,
)

__all__ = ["FileScope", "is_escaped", "report_duplicate"]


@dataclass
class FileScope:
    """The declarations of one robot or library by name; the first of two equal names wins."""

    source: Source
    node: FileNode
    faults: tuple[Span, ...] = ()
    components: dict[str, ComponentNode | ImportNode] = field(default_factory=dict)
    datatypes: dict[str, ObjectNode | EnumNode] = field(default_factory=dict)
    interfaces: dict[str, InterfaceNode] = field(default_factory=dict)
    used_datatypes: set[str] = field(default_factory=set)
    used_interfaces: set[str] = field(default_factory=set)

    @classmethod
    def of(
        cls, source: Source, node: FileNode, syntax: tuple[Diagnostic, ...], report: Report
    ) -> FileScope:
        faults = tuple(d.span for d in syntax if d.severity is Severity.ERROR)
        scope = cls(source, node, faults)
        for item in node.declarations:
            match item:
                case ComponentNode() | ImportNode():
                    _declare(scope.components, item.name, item, "component", report)
                case ObjectNode() | EnumNode():
                    _declare(scope.datatypes, item.name, item, "datatype", report)
                case InterfaceNode():
                    _declare(scope.interfaces, item.name, item, "interface", report)
        return scope

    @property
    def origin(self) -> str:
        return self.node.name.text

    def is_lost(self, name: str) -> bool:
        """Whether a name without declaration may have had one in text that did not parse."""
        return name in self.node.broken

    def is_damaged(self, span: Span) -> bool:
        """Whether a part of this range did not parse, so that what it lacks proves nothing."""
        return any(f.start <= span.end and f.end >= span.start for f in self.faults)


def is_escaped(name: Name) -> bool:
    """Whether the user wrote ``^name``."""
    return name.span.text.startswith("^")


def report_duplicate(what: str, second: Name, first: Span, report: Report) -> None:
    report.add(
        "duplicate-name",
        second.span,
        f"another {what} is called '{second.text}' already",
        "give one of them another name",
        [Note("the first one is here", first)],
    )


_Declaration = TypeVar(
    "_Declaration", ComponentNode | ImportNode, ObjectNode | EnumNode, InterfaceNode
)


def _declare(
    table: dict[str, _Declaration], name: Name, item: _Declaration, what: str, report: Report
) -> None:
    if name.text in table:
        report_duplicate(what, name, table[name.text].name.span, report)
    else:
        table[name.text] = item
