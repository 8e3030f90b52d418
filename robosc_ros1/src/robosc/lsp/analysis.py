"""What is known of one state of a document, and the workspace on which open documents lie."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from itertools import islice
from pathlib import Path

from robosc import errors, limits
from robosc.lazy_dataclasses import dataclass
from robosc.lsp.completion.context import Context, Landmarks, context_at
from robosc.lsp.ros_definitions import carriers
from robosc.model import file_resolver, resolve
from robosc.model.libraries import LibraryFinder
from robosc.model.names.occurrences import NameIndex
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import Definition
from robosc.source import MODEL_SUFFIXES, Source
from robosc.syntax.parser import read_source

_LONG = 30_000
"""Characters from which on reading a text takes longer than the pause between two keys."""


READING = threading.Lock()
"""Held while a text is parsed: pyparsing works on one at a time."""


@dataclass(frozen=True)
class Analysis:
    """A text, what reading it has found, and the definitions that it was held against."""

    source: Source
    reading: resolve.ReadResult
    definitions: MessageDefinitions

    @property
    def path(self) -> str:
        return self.source.path

    @property
    def contents(self) -> file_resolver.FileContents | None:
        return self.reading.contents

    @property
    def index(self) -> NameIndex:
        """Every name with its meaning; empty if nothing could be read."""
        return self.contents.scope.names.index if self.contents is not None else NameIndex()

    @cached_property
    def carriers(self) -> Mapping[str, Definition]:
        """The real definition behind each object datatype of this file."""
        return carriers(self.contents, self.definitions) if self.contents is not None else {}

    @property
    def diagnostics(self) -> tuple[errors.Diagnostic, ...]:
        """Those of this file; errors in libraries stand where they are imported."""
        return self.reading.diagnostics


@dataclass
class Workspace:
    """The open documents by path, and what was read for them.

    ``folders`` are the roots of the editor's workspace. ``revision`` grows with each change outside
    of a text that may change what is known of it.
    """

    library_path: Sequence[str] = ()
    strict: bool = False
    folders: list[str] = field(default_factory=list)
    revision: int = 0
    _open: dict[str, Source] = field(default_factory=dict)
    _analyses: dict[str, Analysis] = field(default_factory=dict)
    _earlier: dict[str, Analysis] = field(default_factory=dict)
    _whole: dict[str, Analysis] = field(default_factory=dict)
    _landmarks: dict[str, Landmarks] = field(default_factory=dict)
    _definitions: dict[str, MessageDefinitions] = field(default_factory=dict)

    # --- documents -------------------------------------------------------------------------------

    def put(self, path: str, text: str) -> None:
        """A document is open, and this is its text now."""
        if text.startswith("\ufeff"):
            text = " " + text[1:]  # of equal length, so that places stay what they are
        source = Source(path, text.replace("\r\n", "\n").replace("\r", "\n"))
        known = self._open.get(path)
        if known is not None and known.text == source.text:
            return
        self._open[path] = source
        self._forget_analyses(path, known, source)

    def close(self, path: str) -> None:
        known = self._open.pop(path, None)
        self._forget_analyses(path, known)
        self._whole.pop(path, None)
        self._earlier.pop(path, None)
        self._landmarks.pop(path, None)

    def refresh(self) -> None:
        """Files have changed: libraries and message definitions are looked up anew."""
        self.revision += 1
        self._definitions.clear()
        self._analyses.clear()

    def _forget_analyses(self, path: str, *texts: Source | None) -> None:
        """A library that changes changes what imports it, or could; another robot does not."""
        outdated = self._analyses.pop(path, None)
        if outdated is not None:
            self._earlier[path] = outdated
        if any(source is not None and "library" in source.text for source in texts):
            self.revision += 1
            for other, analysis in list(self._analyses.items()):
                if analysis.reading.libraries or _wants_library(analysis):
                    del self._analyses[other]

    def is_known(self, path: str) -> bool:
        """Whether there is an analysis that still holds."""
        return path in self._analyses

    @property
    def open(self) -> tuple[str, ...]:
        return tuple(self._open)

    def source(self, path: str) -> Source | None:
        """The text of an open document, or of a file."""
        return self._read(path)[0]

    def context(self, path: str, offset: int) -> Context | None:
        """What a place in an open document or a file is part of."""
        source = self.source(path)
        if source is None:
            return None
        return context_at(source, offset, self._landmarks.setdefault(path, Landmarks()))

    # --- what is known of them -------------------------------------------------------------------

    def analysis(self, path: str) -> Analysis | None:
        """What is known of a document or file now; None if it cannot be read."""
        if path not in self._analyses:
            source = self.source(path)
            if source is None:
                return None
            self._remember(self.analyse(source))
        return self._analyses[path]

    def _remember(self, analysis: Analysis) -> None:
        self._analyses[analysis.path] = analysis
        if analysis.contents is not None and not analysis.contents.scope.faults:
            self._whole[analysis.path] = analysis

    def adopt(self, analysis: Analysis, revision: int) -> None:
        """Take an analysis that was begun at a revision, unless something has changed since."""
        if self._open.get(analysis.path) is analysis.source and self.revision == revision:
            self._remember(analysis)

    def recent(self, path: str) -> Analysis | None:
        """As :meth:`analysis`; of a long text what is known of it now, if anything."""
        if path not in self._analyses and self.is_long(path):
            return self._earlier.get(path)
        return self.analysis(path)

    def is_long(self, path: str) -> bool:
        """Whether reading an open document again keeps whoever types waiting."""
        return path in self._open and len(self._open[path].text) > _LONG

    def analyse(self, source: Source) -> Analysis:
        definitions = self.definitions(source.path)
        with READING:
            reading = resolve.read(
                source, self.library_path, definitions, strict=self.strict, reader=self._reader
            )
        return Analysis(source, reading, definitions)

    def whole(self, path: str) -> Analysis | None:
        """The last analysis of a text without errors of syntax: what names there are."""
        return self._whole.get(path)

    def definitions(self, path: str) -> MessageDefinitions:
        """Where the messages of a model are looked up; each is read once until ``refresh``."""
        folder = os.path.dirname(path)  # noqa: PTH120 (a key, not a file)
        if folder not in self._definitions:
            self._definitions[folder] = MessageDefinitions.for_model(Path(path))
        return self._definitions[folder]

    def libraries(self, path: str) -> Sequence[str]:
        """The names of the libraries that a model can import from."""
        finder = LibraryFinder(
            self.library_path, self.definitions(path).packages.library_folders, self._reader
        )
        return finder.names(path)

    def all_files(self, path: str) -> Iterator[str]:
        """Model files that may have to do with one: open ones, beside it, in the workspace."""
        seen: dict[str, str] = {}  # a file that links lead to twice is edited once
        for file in (path, *self._open):
            seen.setdefault(os.path.realpath(file), file)
        for root in (os.path.dirname(path), *self.folders):  # noqa: PTH120
            for file in _model_files(root):
                if len(seen) >= limits.SEARCHED_FILES:
                    break
                seen.setdefault(os.path.realpath(file), file)
        yield from seen.values()

    def related(self, path: str) -> Mapping[str, Analysis]:
        """Those of :meth:`all_files` that can be read, by path."""
        analyses = {file: self.analysis(file) for file in self.all_files(path)}
        return {file: analysis for file, analysis in analyses.items() if analysis is not None}

    def _reader(self, path: str) -> tuple[Source | None, tuple[errors.Diagnostic, ...]]:
        absolute = os.path.abspath(path)  # noqa: PTH100 (links stay)
        known = self._open.get(path) or self._open.get(absolute)
        return (known, ()) if known is not None else read_source(absolute)

    def _read(self, path: str) -> tuple[Source | None, tuple[errors.Diagnostic, ...]]:
        try:
            return self._reader(path)
        except errors.UsageError:
            return None, ()


def _wants_library(analysis: Analysis) -> bool:
    return any(d.code.startswith(("library", "import")) for d in analysis.diagnostics)


def _model_files(root: str) -> Iterator[str]:
    """Below a folder, hidden ones and those of builds left out."""
    for folder, inner, files in islice(os.walk(root), limits.SEARCHED_FOLDERS):
        inner[:] = sorted(
            f for f in inner if not f.startswith(".") and f not in ("build", "devel", "install")
        )
        if folder.count(os.sep) - root.count(os.sep) > 6:
            inner.clear()
        for file in sorted(files):
            if file.endswith(MODEL_SUFFIXES):
                yield os.path.join(folder, file)  # noqa: PTH118
