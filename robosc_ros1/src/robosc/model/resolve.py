"""From the text of a model to the resolved, typed :class:`Robot`.

:func:`load` is the façade. The order of work for one file, a robot or a library: parse; tables of
names; data types; the declarations of all components, imports included; their behaviour; last
requirements and data, and the checks of the whole model (:mod:`robosc.model.file_resolver`). Each
step continues after errors, and what depends on an unknown type or name is not reported, so that
one run reports every error, and each once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from robosc import limits, remedies
from robosc.errors import Diagnostic, Note, Severity, at_most, has_errors, sort_diagnostics
from robosc.lazy_dataclasses import dataclass
from robosc.model import entities, file_resolver
from robosc.model.declarations.type_declarations import TypeDeclarations
from robosc.model.diagnostics import Report, first_of
from robosc.model.libraries import LibraryFinder, Reader, Search
from robosc.model.names.copies import write_out
from robosc.model.names.scope import FileScope
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.object_types import RosTypes
from robosc.source import Source
from robosc.syntax import nodes, parser


def load(
    source: Source | str | Path,
    library_path: Sequence[str] = (),
    definitions: MessageDefinitions | None = None,
    *,
    strict: bool = False,
    supervises: bool = False,
) -> tuple[entities.Robot | None, tuple[Diagnostic, ...]]:
    """The robot in a model file, and the diagnostics of the file.

    ``source`` is a path or a text already read; ``library_path`` are further folders for libraries;
    ``definitions`` finds ROS messages (by default as ROS does, and around the model: see
    :mod:`robosc.model.ros.packages`). ``strict`` makes a definition that is not installed an error;
    ``supervises``: another controller sends the commands.
    The robot is None if there are errors, and for a library, which is checked, too.

    Raises:
        UsageError: the file cannot be read.
    """
    if not isinstance(source, Source):
        text, unreadable = parser.read_source(str(source))
        if text is None:
            return None, unreadable
        source = text
    if definitions is None:
        definitions = MessageDefinitions.for_model(Path(source.path))
    found = read(source, library_path, definitions, strict=strict, supervises=supervises)
    return found.robot, found.diagnostics


def read(
    source: Source,
    library_path: Sequence[str],
    definitions: MessageDefinitions,
    *,
    strict: bool = False,
    supervises: bool = False,
    reader: Reader = parser.read_source,
) -> ReadResult:
    """As :func:`load`, with symbol tables and libraries, for tools that look up names.

    ``reader`` reads libraries: that of an editor returns texts that are not saved yet.
    """
    return _Loader(library_path, definitions, strict, supervises, reader).read(source)


@dataclass(frozen=True)
class ResolvedFile:
    """One file and its diagnostics. ``contents`` is None if nothing of it could be parsed."""

    contents: file_resolver.FileContents | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def is_sound(self) -> bool:
        return self.contents is not None and not has_errors(self.diagnostics)


@dataclass(frozen=True)
class ReadResult:
    """The result of :func:`read`; ``libraries`` are all that the file needs, by name."""

    robot: entities.Robot | None
    diagnostics: tuple[Diagnostic, ...]
    contents: file_resolver.FileContents | None
    libraries: Mapping[str, ResolvedFile]


class _Loader:
    """One run: resolves a file and, through its imports, libraries."""

    def __init__(
        self,
        library_path: Sequence[str],
        definitions: MessageDefinitions,
        strict: bool,
        supervises: bool,
        reader: Reader,
    ) -> None:
        self._definitions = definitions
        self._reader = reader
        self._finder = LibraryFinder(library_path, definitions.packages.library_folders, reader)
        self._strict = strict
        self._supervises = supervises
        self._type_declarations = TypeDeclarations(ros=RosTypes(definitions))
        self._libraries: dict[str, ResolvedFile] = {}
        self._paths: dict[str, dict[str, str]] = {}
        self._robot: str | None = None
        self._open: list[str] = []

    def read(self, source: Source) -> ReadResult:
        file = self._file(source)
        diagnostics = list(file.diagnostics)
        for library in self._libraries.values():
            # Warnings about a library are for its author, who gets them by checking the library.
            diagnostics += [d for d in library.diagnostics if d.severity is Severity.ERROR]
        ordered = tuple(at_most(sort_diagnostics(diagnostics), limits.ERRORS))
        robot = None if file.contents is None or has_errors(ordered) else file.contents.robot
        if file.contents is not None and file.contents.scope.node.kind == "library":
            robot = None
        if robot is not None:
            found = (library.contents for _, library in sorted(self._libraries.items()))
            libraries = (contents.scope.source for contents in found if contents is not None)
            robot = replace(robot, sources=(source, *libraries))
        return ReadResult(robot, ordered, file.contents, self._libraries)

    def _file(self, source: Source) -> ResolvedFile:
        report = Report(self._strict)
        node, syntax = parser.parse(source)
        if node is not None:
            node = write_out(node, report)
        report.extend(syntax)
        if node is None:
            return ResolvedFile(None, report.diagnostics)
        scope = FileScope.of(source, node, syntax, report)
        for name in node.mentions:
            scope.names.use(name, scope.components.get(name.text))
        if node.kind == "robot" and not self._open:
            self._robot = scope.origin
        self._open.append(scope.origin)
        resolver = file_resolver.FileResolver(
            scope,
            self._type_declarations,
            self._definitions,
            self._library,
            report,
            self._supervises,
        )
        contents = resolver.resolve()
        self._open.pop()
        kept = tuple(d for d in report.diagnostics if d in syntax or not scope.is_cut_short(d.span))
        return ResolvedFile(contents, kept)

    def _library(
        self, library: nodes.Name, scope: FileScope, report: Report, *, imported: bool = True
    ) -> file_resolver.FileContents | None:
        """The library of a name; None after an error, here or in the library.

        Not ``imported``: the name may be another thing, so that nothing is wrong if there is none.
        """
        name = library.text
        if not imported and name in (self._robot, *self._open):
            return None
        search = self._finder.find(name, scope.source.path)
        if not imported and not search.files:
            return None
        file = self._opened(library, search, scope, report)
        if file is None or not file.is_sound:
            scope.unresolved.add(name)
            return None
        return file.contents

    def _opened(
        self, library: nodes.Name, search: Search, scope: FileScope, report: Report
    ) -> ResolvedFile | None:
        """The file of a library; None after an error about its name."""
        name = library.text
        if not self._may_open(library, report):
            return None
        if not search.files:
            meant = report.suggest(name, self._finder.names(scope.source.path))
            looked = f"looked in: {first_of(search.folders)}\nadd a folder with --library-path"
            report.add(
                "library-not-found",
                library.span,
                f"there is no library '{name}'",
                remedies.followed(meant, looked),
            )
            return None
        # Importers in different folders may find different files for one name.
        paths = {**self._paths.get(name, {}), **search.files}
        if len(paths) > 1:
            report.add(
                "library-clash",
                library.span,
                f"library '{name}' is found several times, with different content",
                "keep one of: " + first_of(paths.values()),
            )
            return None
        if name not in self._libraries:
            (path,) = paths.values()
            self._paths[name] = paths
            self._libraries[name] = self._read_library(path, library)
        return self._libraries[name]

    def _may_open(self, library: nodes.Name, report: Report) -> bool:
        name = library.text
        if name == self._robot:
            report.add(
                "library-clash",
                library.span,
                f"the library has the name of the robot, '{name}'",
                "rename one of them",
            )
        elif name in self._open:
            cycle = " -> ".join([*self._open[self._open.index(name) :], name])
            report.add(
                "import-cycle",
                library.span,
                f"library {name} imports itself: {cycle}",
                "move what they share to a library of its own",
            )
        elif len(self._open) > limits.IMPORTS:
            report.add(
                "too-deep",
                library.span,
                f"libraries import libraries more than {limits.IMPORTS} levels deep",
            )
        else:
            return True
        return False

    def _read_library(self, path: str, library: nodes.Name) -> ResolvedFile:
        source, unreadable = self._reader(path)
        file = ResolvedFile(None, unreadable)
        if source is not None:
            file = self._file(source)
        errors = [d for d in sort_diagnostics(file.diagnostics) if d.severity is Severity.ERROR]
        if errors:
            note = Note("the library is imported here", library.span)
            first = replace(errors[0], notes=(*errors[0].notes, note))
            file = replace(file, diagnostics=(first, *errors[1:]))
        return file
