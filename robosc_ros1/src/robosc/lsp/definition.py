"""Where what a name stands for is declared: in this file, in a library, in a ROS definition."""

from __future__ import annotations

from robosc.lsp.analysis import Analysis
from robosc.lsp.interfaces import definition_file, field_place
from robosc.model.file_resolver import FileContents
from robosc.model.names.occurrences import Occurrence, Symbol, SymbolKind
from robosc.source import Span


def definition_of(analysis: Analysis, occurrence: Occurrence) -> Span | None:
    """A declaration itself leads on: an import to the library, a property to the real field."""
    symbol = occurrence.symbol
    if symbol.kind is SymbolKind.ROS_TYPE:
        file = definition_file(analysis.definitions, symbol.owner, symbol.name)
        return field_place(file, 0, "") if file is not None else None
    if symbol.kind is SymbolKind.ROS_PACKAGE:
        home = analysis.definitions.packages.find(symbol.name)
        manifest = home / "package.xml" if home is not None else None
        return field_place(manifest, 0, "") if manifest and manifest.is_file() else None
    if symbol.declared is None and symbol.kind in (SymbolKind.PROPERTY, SymbolKind.ROS_CONSTANT):
        return _field_of(analysis, symbol.owner, symbol.name)
    if occurrence.declaration and analysis.contents is not None:
        further = _further(analysis, symbol, analysis.contents)
        if further is not None:
            return further
    return symbol.declared


def _further(analysis: Analysis, symbol: Symbol, contents: FileContents) -> Span | None:
    if symbol.kind is SymbolKind.COMPONENT:
        instance = contents.instances.get(symbol.name)
        if instance is not None and instance.imported is not None:
            return instance.node.name.span
    if symbol.kind is SymbolKind.PROPERTY:
        return _field(analysis, symbol.owner, symbol.name)
    if symbol.kind is SymbolKind.OBJECT:
        return _field(analysis, symbol.name, "")
    if symbol.kind is SymbolKind.INTERFACE:
        node = contents.scope.interfaces.get(symbol.name)
        if node is not None:
            file = definition_file(analysis.definitions, node.package.text, node.type.text)
            return field_place(file, 0, "") if file is not None else None
    return None


_PARTS = {"Request": 0, "Goal": 0, "Response": 1, "Result": 1, "Feedback": 2}


def _field(analysis: Analysis, object_: str, name: str) -> Span | None:
    carrier = analysis.carriers.get(object_)
    return _field_of(analysis, carrier.name, name) if carrier is not None else None


def _field_of(analysis: Analysis, definition: str, name: str) -> Span | None:
    """Where a field or constant of ``package/Type``, or of a part of it, is defined."""
    package, _, type_ = definition.partition("/")
    candidates = [(type_, 0)]
    candidates += [(type_.removesuffix(s), p) for s, p in _PARTS.items() if type_.endswith(s)]
    for stem, part in candidates:
        file = definition_file(analysis.definitions, package, stem)
        if file is not None:
            return field_place(file, part, name)
    return None
