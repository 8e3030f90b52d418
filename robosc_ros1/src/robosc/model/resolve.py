"""From model text to the resolved, typed :class:`Robot`.

:func:`load` is the façade. The order of work for one file, a robot or a library alike: parse;
tables of names; data types; the outside of all components, imports included; then their behaviour;
last requirements and data, and the rules about the whole. Each step goes on past errors, and an
unknown type or name is silent in all that depends on it, so that one run tells all faults and each
once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from robosc.errors import Diagnostic, Note, Severity, has_errors, sort_diagnostics
from robosc.model.behaviour import BehaviourResolver
from robosc.model.check import Model, check_case, check_topics, check_unused, select_state_variables
from robosc.model.components import (
    bind,
    check_interfaces,
    check_local_names,
    check_prefix,
    declare,
    join,
)
from robosc.model.datatypes import TypeDeclarations, TypeTable
from robosc.model.entities import Component, Provide, Requirement, Robot
from robosc.model.expr import Expr
from robosc.model.expressions import BOOLEAN, RULE, Incoming, Typer
from robosc.model.indexes import check_indexes
from robosc.model.libraries import LibraryFinder, Reader
from robosc.model.overlap import check_overlaps
from robosc.model.report import Muted, Report, listing
from robosc.model.rosbind import Binder
from robosc.model.rosmsg import MessageDefinitions
from robosc.model.scope import FileScope
from robosc.model.statements import StatementResolver
from robosc.model.tables import ComponentTable, ImportedSymbolTable, Instance, SymbolTable
from robosc.model.types import EnumType, Type
from robosc.source import Source
from robosc.syntax.nodes import (
    BehaviourNode,
    ComponentNode,
    ExprNode,
    ImportNode,
    ProvideNode,
    RequirementNode,
)
from robosc.syntax.parser import parse, read_source

__all__ = ["Reading", "ResolvedFile", "load", "read"]


def load(
    source: Source | str | Path,
    library_path: Sequence[str] = (),
    definitions: MessageDefinitions | None = None,
    *,
    strict: bool = False,
) -> tuple[Robot | None, tuple[Diagnostic, ...]]:
    """The robot in a model file, and everything that is to be said about the file.

    ``source`` is a path or a text already read; ``library_path`` are further folders for libraries;
    ``definitions`` are where ROS messages are looked up (by default as ROS does, and around the
    model: see :mod:`robosc.model.rosmsg`). ``strict`` makes a definition that is not installed an
    error. The robot is None if there are errors, and for a library, which is checked all the same.
    Raises UsageError if the file cannot be read.
    """
    if not isinstance(source, Source):
        text, unreadable = read_source(str(source))
        if text is None:
            return None, unreadable
        source = text
    if definitions is None:
        definitions = MessageDefinitions.for_model(Path(source.path))
    found = read(source, library_path, definitions, strict=strict)
    return found.robot, found.diagnostics


def read(
    source: Source,
    library_path: Sequence[str],
    definitions: MessageDefinitions,
    *,
    strict: bool = False,
    reader: Reader = read_source,
) -> Reading:
    """As :func:`load`, with all that was found out on the way, for tools that look up names.

    ``reader`` reads libraries; an editor has texts that are not saved.
    """
    loader = _Loader(library_path, definitions, strict, reader)
    robot, diagnostics = loader.load(source)
    return Reading(robot, diagnostics, loader.main, loader.libraries)


@dataclass
class ResolvedFile:
    """One resolved file. A library with errors has no table of components."""

    scope: FileScope | None
    types: TypeTable | None
    component_table: ComponentTable | None
    model: Model | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def is_sound(self) -> bool:
        return self.component_table is not None and not has_errors(self.diagnostics)


@dataclass(frozen=True)
class Reading:
    """What :func:`read` has found; ``libraries`` by name, those that the file's imports need."""

    robot: Robot | None
    diagnostics: tuple[Diagnostic, ...]
    file: ResolvedFile
    libraries: Mapping[str, ResolvedFile]


class _Loader:
    """One run: the file asked for and, through its imports, libraries."""

    def __init__(
        self,
        library_path: Sequence[str],
        definitions: MessageDefinitions,
        strict: bool,
        reader: Reader,
    ) -> None:
        self._definitions = definitions
        self._reader = reader
        self._finder = LibraryFinder(library_path, definitions.library_folders, reader)
        self.main = ResolvedFile(None, None, None, None, ())
        self._strict = strict
        self._type_declarations = TypeDeclarations()
        self._libraries: dict[str, ResolvedFile] = {}
        self._paths: dict[str, dict[str, str]] = {}
        self._robot: str | None = None
        self._open: list[str] = []

    def load(self, source: Source) -> tuple[Robot | None, tuple[Diagnostic, ...]]:
        file = self.main = self._file(source)
        diagnostics = list(file.diagnostics)
        for library in self._libraries.values():
            # What a library's author should know is told when the library itself is checked.
            diagnostics += [d for d in library.diagnostics if d.severity is Severity.ERROR]
        ordered = _told(sort_diagnostics(diagnostics))
        scope = file.scope
        if scope is None or file.model is None or scope.node.kind != "robot":
            return None, ordered
        if has_errors(ordered):
            return None, ordered
        node, model = scope.node, file.model
        robot = Robot(
            node.name.text,
            model.components,
            model.requirements,
            model.provides,
            span=node.name.span,
        )
        return robot, ordered

    def _file(self, source: Source) -> ResolvedFile:
        report = Report(self._strict)
        node, syntax = parse(source)
        report.extend(syntax)
        if node is None:
            return ResolvedFile(None, None, None, None, report.diagnostics)
        scope = FileScope.of(source, node, syntax, report)
        if node.kind == "robot" and not self._open:
            self._robot = scope.origin
        self._open.append(scope.origin)
        resolver = _FileResolver(self, scope, report)
        model = resolver.resolve()
        self._open.pop()
        told = tuple(d for d in report.diagnostics if d in syntax or not scope.is_cut_short(d.span))
        return ResolvedFile(scope, resolver.types, resolver.component_table, model, told)

    @property
    def libraries(self) -> Mapping[str, ResolvedFile]:
        return self._libraries

    @property
    def type_declarations(self) -> TypeDeclarations:
        return self._type_declarations

    @property
    def definitions(self) -> MessageDefinitions:
        return self._definitions

    def library(self, node: ImportNode, scope: FileScope, report: Report) -> ResolvedFile | None:
        """The library that an import names; None after an error, here or in the library."""
        name = node.library.text
        if not self._may_open(node, report):
            return None
        search = self._finder.find(name, scope.source.path)
        if not search.files:
            meant = report.suggest(name, self._finder.names(scope.source.path))
            looked = f"looked in: {listing(search.folders)}\nadd a folder with --library-path"
            report.add(
                "library-not-found",
                node.library.span,
                f"there is no library '{name}'",
                f"{meant}\n{looked}" if meant else looked,
            )
            return None
        # What one importer finds, another in another folder may find elsewhere.
        paths = {**self._paths.get(name, {}), **search.files}
        if len(paths) > 1:
            report.add(
                "library-clash",
                node.library.span,
                f"library '{name}' is found several times, with different content",
                "keep one of: " + listing(paths.values()),
            )
            return None
        if name not in self._libraries:
            (path,) = paths.values()
            self._paths[name] = paths
            self._libraries[name] = self._read_library(path, node)
        file = self._libraries[name]
        return file if file.is_sound else None

    def _may_open(self, node: ImportNode, report: Report) -> bool:
        name = node.library.text
        if name == self._robot:
            report.add(
                "library-clash",
                node.library.span,
                f"the library has the name of the robot, '{name}'",
                "rename one of them",
            )
        elif name in self._open:
            cycle = " -> ".join([*self._open[self._open.index(name) :], name])
            report.add(
                "import-cycle",
                node.library.span,
                f"library {name} imports itself: {cycle}",
                "move what they share to a library of its own",
            )
        elif len(self._open) > _DEEPEST_IMPORT:
            report.add(
                "too-deep",
                node.library.span,
                f"libraries import libraries more than {_DEEPEST_IMPORT} levels deep",
            )
        else:
            return True
        return False

    def _read_library(self, path: str, node: ImportNode) -> ResolvedFile:
        source, unreadable = self._reader(path)
        file = ResolvedFile(None, None, None, None, unreadable)
        if source is not None:
            file = self._file(source)
        errors = [d for d in sort_diagnostics(file.diagnostics) if d.severity is Severity.ERROR]
        if errors:
            note = Note("the library is imported here", node.library.span)
            first = replace(errors[0], notes=(*errors[0].notes, note))
            file = replace(file, diagnostics=(first, *errors[1:]))
        return file


def _told(found: list[Diagnostic]) -> tuple[Diagnostic, ...]:
    """As many errors as anybody would read, and all warnings on the way."""
    errors = [n for n, d in enumerate(found) if d.severity is Severity.ERROR]
    if len(errors) > _MOST_ERRORS:
        first = errors[_MOST_ERRORS]
        message = f"there are more than {_MOST_ERRORS} errors: the others are not shown"
        span = found[first].span
        found[first:] = [Diagnostic(Severity.ERROR, "too-many-errors", message, span)]
    return tuple(found)


_MOST_ERRORS = 1000
_DEEPEST_IMPORT = 20


class _FileResolver:
    """Resolves one file over its scope."""

    def __init__(self, loader: _Loader, scope: FileScope, report: Report) -> None:
        self._loader = loader
        self._scope = scope
        self._report = report
        self.component_table = ComponentTable()
        self.types = TypeTable(scope, loader.type_declarations, report, self._rule_condition)
        self._binder = Binder(loader.definitions, loader.type_declarations, report)
        self._muted = Muted()

    def resolve(self) -> Model:
        """The entities of the file that are sound."""
        self.types.resolve_all()
        check_interfaces(self._scope.interfaces, self._report)
        for node in self._scope.components.values():
            self._add_component(node)
        self.component_table.index_communications()
        if self._scope.node.kind == "robot":
            check_local_names(self.component_table, self._report)
        components = tuple(self._component(i) for i in self.component_table.instances.values())
        self._check_duplicates()
        self._binder.check_unlinked(self._scope.interfaces.values())
        requirements, provides = self._statements()
        model = Model(components, requirements, provides)
        model = select_state_variables(model, self.component_table, self._report)
        enums = [t for t in map(self.types.known, self._scope.datatypes) if isinstance(t, EnumType)]
        check_indexes(model.components, enums, self._binder.lengths, self._report)
        check_case(self._scope, self.component_table, self._report)
        check_topics(self.component_table, self._report)
        library = self._scope.node.kind == "library"
        whole = not self._report.has_errors and not self.component_table.broken
        if library or not whole:
            check_overlaps(model.components, self._report, library=library)
        if whole:
            check_unused(
                self._scope,
                self.component_table,
                model,
                self._loader.type_declarations,
                self._report,
            )
        return model

    def _rule_condition(self, types: TypeTable, node: ExprNode, source: Type) -> Expr | None:
        return Typer(self._report, types, None, Incoming(source)).check(node, BOOLEAN, RULE)

    # --- components ------------------------------------------------------------------------------

    def _add_component(self, node: ComponentNode | ImportNode) -> None:
        if isinstance(node, ComponentNode):
            instance = Instance(node.name.text, node, self.types)
            declare(instance, self._report)
        else:
            found = self._imported(node)
            if found is None:
                self.component_table.broken.add(node.name.text)
                return
            instance = found
            declare(instance, self._muted)
        self.component_table.add(instance)
        for info in instance.communications.values():
            bind(info, self._binder, self._report)

    def _check_duplicates(self) -> None:
        """Resolve what has a name, or a place, that is taken, only for the faults in it."""
        for instance in list(self.component_table.instances.values()):
            for behaviour in () if instance.imported else instance.duplicate_behaviours:
                outside = [i for i in instance.node.items if not isinstance(i, BehaviourNode)]
                self._check_aside(replace(instance.node, items=(*outside, behaviour)))
        for node in self._scope.duplicates:
            if isinstance(node, ComponentNode):
                self._check_aside(node)

    def _check_aside(self, node: ComponentNode) -> None:
        instance = Instance(node.name.text, node, self.types)
        declare(instance, self._report)
        for info in instance.communications.values():
            bind(info, self._binder, self._report)
        self._component(instance)

    def _imported(self, node: ImportNode) -> Instance | None:
        prefix = check_prefix(node.prefix, self._report) if node.prefix is not None else ""
        library = self._loader.library(node, self._scope, self._report)
        if library is None:
            return None
        assert library.component_table is not None
        original = library.component_table.instances.get(node.component.text)
        if original is None and node.component.text in library.component_table.broken:
            return None
        if original is None:
            self._report.add(
                "unknown-component",
                node.component.span,
                f"library {node.library.text} has no component '{node.component.text}'",
                self._report.suggest(
                    node.component.text, library.component_table.instances, "its components"
                ),
            )
            return None
        chain = prefix
        if prefix is not None and original.prefix != "":
            chain = None if original.prefix is None else join(prefix, original.prefix)
        instance = Instance(node.name.text, original.node, original.types, chain, node)
        instance.original = original
        instance.library = library.component_table
        return instance

    def _component(self, instance: Instance) -> Component:
        symbols: SymbolTable = SymbolTable(self.component_table, instance)
        report = self._report
        if instance.library is not None and instance.original is not None:
            report = self._muted
            symbols = ImportedSymbolTable(
                self.component_table, instance, instance.library, instance.original, self._report
            )
        behaviour = None
        if instance.behaviour is not None:
            behaviour = BehaviourResolver(instance, symbols, report).resolve(instance.behaviour)
        communications = (c.entity for c in instance.communications.values())
        imported = instance.imported
        return Component(
            instance.name,
            tuple(c for c in communications if c is not None),
            behaviour,
            imported.library.text if imported is not None else None,
            span=(instance.node if imported is None else imported).name.span,
        )

    # --- statements ------------------------------------------------------------------------------

    def _statements(self) -> tuple[tuple[Requirement, ...], tuple[Provide, ...]]:
        resolver = StatementResolver(
            SymbolTable(self.component_table), self.types, self._binder, self._report
        )
        requirements: list[Requirement] = []
        provides: list[Provide] = []
        for node in self._scope.node.declarations:
            match node:
                case RequirementNode():
                    requirement = resolver.requirement(node)
                    if requirement is not None:
                        requirements.append(requirement)
                case ProvideNode():
                    provide = resolver.provide(node)
                    if provide is not None:
                        provides.append(provide)
        return tuple(requirements), tuple(provides)
