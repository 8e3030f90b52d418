"""References to a symbol in all model files, and its renaming."""

from __future__ import annotations

import re
from collections.abc import Mapping

from robosc.language.functions import AGGREGATES, FUNCTIONS, GEOMETRY
from robosc.language.keywords import KEYWORDS, RESERVED, UNITS
from robosc.lsp.actions import Edit
from robosc.lsp.analysis import Analysis, Workspace
from robosc.model.names.occurrences import Occurrence, Symbol, SymbolKind
from robosc.names import is_identifier
from robosc.source import Source

_PLAIN = frozenset(SymbolKind) - {SymbolKind.PROPERTY, SymbolKind.LIBRARY}
"""Symbols whose names only have to differ from others in models."""

_MEANINGFUL = frozenset({*KEYWORDS, *UNITS, *FUNCTIONS, *GEOMETRY, *AGGREGATES, "not"})
"""Words of the language, in lower case as all of them are."""


class RenameError(Exception):
    """Why a name cannot be given, for the user."""


def may_be_renamed(symbol: Symbol) -> bool:
    return symbol.declared is not None


def references(
    workspace: Workspace, path: str, symbol: Symbol, *, declaration: bool = True
) -> Mapping[str, list[Occurrence]]:
    """Where a symbol is named, by file, in reading order."""
    found: dict[str, list[Occurrence]] = {}
    for file, analysis in workspace.related(path).items():
        here = [o for o in analysis.index.of(symbol) if declaration or not o.declaration]
        if here:
            found[file] = here
    return found


def rename(workspace: Workspace, path: str, symbol: Symbol, name: str) -> Mapping[str, list[Edit]]:
    """The edits of each file that give a symbol another name.

    Raises RenameError if the name is none, or would mean something else somewhere.
    """
    name = name.removeprefix("^")
    if not is_identifier(name):
        raise RenameError(f"'{name}' is not a name: letters, digits and '_', no digit first")
    if not may_be_renamed(symbol):
        raise RenameError("this name is not given by a model")
    found = references(workspace, path, symbol)
    spellings = (f"^{name}",) if name in RESERVED else (name, f"^{name}")
    if symbol.kind in _PLAIN and _is_new(workspace, path, name):
        return {file: [Edit(o.span, name) for o in here] for file, here in found.items()}
    for spelling in spellings:
        edits = {file: [Edit(o.span, spelling) for o in here] for file, here in found.items()}
        if _is_harmless(workspace, edits):
            return edits
    if symbol.kind is SymbolKind.PROPERTY:
        raise RenameError(f"'{symbol.name}' is named by the ROS definition, or '{name}' is taken")
    raise RenameError(f"'{name}' would clash with another name, or change what a name means")


def _is_new(workspace: Workspace, path: str, name: str) -> bool:
    """Whether a name is certainly free: no model knows the word, in upper or lower case.

    Then nobody needs to read all files with the new name in them to find a clash.
    """
    if not re.fullmatch(r"[A-Za-z]+(_?[A-Za-z]+)*", name) or name.casefold() in _MEANINGFUL:
        return False
    if workspace.definitions(path).packages.find(name) is not None:
        return False
    texts: list[str] = []
    for analysis in workspace.related(path).values():
        texts.append(analysis.source.text)
        libraries = (library.contents for library in analysis.reading.libraries.values())
        texts += [found.scope.source.text for found in libraries if found is not None]
    word = re.compile(rf"(?<![A-Za-z0-9_]){name}(?![A-Za-z0-9_])", re.IGNORECASE)
    return not any(word.search(text) for text in texts)


def _is_harmless(workspace: Workspace, edits: Mapping[str, list[Edit]]) -> bool:
    """Whether all files mean the same with the new name: no new fault, and as many uses of it.

    The files are read with their edits, libraries and those that import them together.
    """
    trial = Workspace(workspace.library_path, workspace.strict, workspace.folders)
    for file in {*workspace.open, *edits}:
        source = workspace.source(file)
        if source is not None:
            trial.put(file, applied(source, edits.get(file, [])))
    for file, changes in edits.items():
        before, after = workspace.analysis(file), trial.analysis(file)
        if before is None or after is None:
            return False
        occurrence = after.index.at(changes[0].span.start)
        if (
            occurrence is None
            or len(list(after.index.of(occurrence.symbol))) != len(changes)
            or len(after.index.occurrences) != len(before.index.occurrences)
            or _faults(before) != _faults(after)
        ):
            return False
    return True


def _faults(analysis: Analysis) -> list[str]:
    return sorted(d.code for d in analysis.diagnostics)


def applied(source: Source, edits: list[Edit]) -> str:
    """The text with edits that do not overlap."""
    text = source.text
    for edit in sorted(edits, key=lambda e: e.span.start, reverse=True):
        text = text[: edit.span.start] + edit.text + text[edit.span.end :]
    return text
