"""The declarations of one file by name, and the parts of it that could not be parsed.

The parser skips declarations with syntax errors. Names that may have been declared in skipped text
are *unresolved*: references to them are not reported, since the syntax error was.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeVar

from robosc.errors import Diagnostic, Note, Severity
from robosc.language.keywords import Role, words_of
from robosc.model.diagnostics import Report
from robosc.model.names.occurrences import NameRecorder, Symbol, SymbolKind
from robosc.source import Source, Span
from robosc.syntax import nodes

_Declaration = TypeVar(
    "_Declaration",
    nodes.ComponentNode | nodes.ImportNode,
    nodes.ObjectNode | nodes.EnumNode,
    nodes.InterfaceNode,
)


_NAMED_BY = re.compile(
    r"\b(action|component|condition|constant|enum|function|incoming|initial|interface|marked"
    r"|message|object|outgoing|parameter|service|state|transform|variable)"
    r"(?:\s+(?:with|from|use))?\s*\Z",
    re.ASCII,
)
"""The keyword of a declaration whose name is missing, right before the fault."""
_BEFORE = {"incoming": "message", "outgoing": "message", "initial": "state", "marked": "state"}
"""Words before such a keyword, which may be missing as well."""
_TYPE_ALONE = re.compile(rf"(?<!:)\s\b(?:{'|'.join(words_of(Role.TYPE))})\s*:=", re.ASCII)
"""The type of a variable in the place of its name: ``double := 1``."""


@dataclass
class FileScope:
    """The declarations of one robot or library by name; the first of two equal names wins."""

    source: Source
    node: nodes.FileNode
    faults: tuple[Span, ...] = ()
    nameless: frozenset[str] = frozenset()
    """Keywords of declarations whose name is missing: any unknown name may be theirs."""
    components: dict[str, nodes.ComponentNode | nodes.ImportNode] = field(default_factory=dict)
    datatypes: dict[str, nodes.ObjectNode | nodes.EnumNode] = field(default_factory=dict)
    interfaces: dict[str, nodes.InterfaceNode] = field(default_factory=dict)
    duplicates: list[
        nodes.ComponentNode
        | nodes.ImportNode
        | nodes.ObjectNode
        | nodes.EnumNode
        | nodes.InterfaceNode
    ] = field(default_factory=list)
    """Declarations whose name is taken: nothing can refer to them, but they are checked, too."""
    unresolved: set[str] = field(default_factory=set)
    used_datatypes: set[str] = field(default_factory=set)
    used_interfaces: set[str] = field(default_factory=set)
    names: NameRecorder = field(default_factory=NameRecorder)

    @classmethod
    def of(
        cls, source: Source, node: nodes.FileNode, syntax: tuple[Diagnostic, ...], report: Report
    ) -> FileScope:
        """The scope of a parsed file; ``syntax`` are the diagnostics of the parser."""
        faults = tuple(d.span for d in syntax if d.severity is Severity.ERROR)
        before = (_NAMED_BY.search(source.text, max(0, f.start - 200), f.start) for f in faults)
        nameless = {_BEFORE.get(match[1], match[1]) for match in before if match}
        if any(_TYPE_ALONE.search(source.line(fault.line)) for fault in faults):
            nameless.add("variable")
        scope = cls(source, node, faults, frozenset(nameless))
        scope.names.declare(node)
        for item in node.declarations:
            match item:
                case nodes.ComponentNode() | nodes.ImportNode():
                    scope._declare(scope.components, item, "component", report)
                case nodes.ObjectNode() | nodes.EnumNode():
                    scope._declare(scope.datatypes, item, "datatype", report)
                case nodes.InterfaceNode():
                    scope._declare(scope.interfaces, item, "interface", report)
                    scope._note_ros_type(item)
        return scope

    def _declare(
        self, table: dict[str, _Declaration], item: _Declaration, what: str, report: Report
    ) -> None:
        name = item.name.text
        self.names.declare(item)
        if name in table:
            report_duplicate(what, item.name, table[name].name.span, report)
            self.duplicates.append(item)
            self.mark_unresolved(item)
        else:
            table[name] = item

    def _note_ros_type(self, node: nodes.InterfaceNode) -> None:
        package, type_ = node.package, node.type
        self.names.note(type_, Symbol(SymbolKind.ROS_TYPE, type_.text, package.text))
        self.names.note(package, Symbol(SymbolKind.ROS_PACKAGE, package.text))

    @property
    def origin(self) -> str:
        return self.node.name.text

    def is_unresolved(self, name: str, *keywords: str) -> bool:
        """Whether a name without declaration may be declared in text that was left out.

        Such text did not parse, or declares something a second time. ``keywords`` are those of the
        declarations that the name may refer to.
        """
        unresolved = name in self.node.broken or name in self.unresolved
        return unresolved or not self.nameless.isdisjoint(keywords)

    def mark_unresolved(self, node: nodes.DeclarationNode | nodes.BehaviourNode) -> None:
        """Make the names unresolved that are declared in a duplicate declaration."""
        self.unresolved.update(_declared(node))

    def is_cut_short(self, span: Span) -> bool:
        """Whether the text right behind a span did not parse, and may belong to it."""
        return span.source is self.source and any(
            span.end <= f.start and not self.source.text[span.end : f.start].strip()
            for f in self.faults
        )

    def is_damaged(self, span: Span) -> bool:
        """Whether a part of a span did not parse, so that nothing can be reported as missing."""
        return span.source is self.source and any(
            f.start <= span.end and f.end >= span.start for f in self.faults
        )


def _declared(node: nodes.DeclarationNode | nodes.BehaviourNode | nodes.StateNode) -> Iterator[str]:
    """The names that are declared within a declaration, apart from its own."""
    match node:
        case nodes.ComponentNode(items=items):
            for item in items:
                if isinstance(item, nodes.BehaviourNode):
                    yield from _declared(item)
                elif not isinstance(
                    item,
                    nodes.RequirementNode
                    | nodes.PossibleNode
                    | nodes.RequirementsNode
                    | nodes.AssumeNode
                    | nodes.ProvideNode
                    | nodes.PreferNode,
                ):
                    yield item.name.text
        case nodes.BehaviourNode(items=items):
            for part in items:
                if isinstance(part, nodes.StateNode | nodes.VariableNode):
                    yield part.name.text
        case nodes.ObjectNode(properties=properties):
            yield from (prop.name.text for prop in properties)
        case nodes.EnumNode(rules=rules):
            yield from (rule.value.text for rule in rules)


def report_duplicate(what: str, second: nodes.Name, first: Span, report: Report) -> None:
    """Report a name that is declared a second time; ``what`` is its kind in words."""
    report.add(
        "duplicate-name",
        second.span,
        f"another {what} is already called '{second.text}'",
        "give one of them another name",
        [Note("the first one is here", first)],
    )
