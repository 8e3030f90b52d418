"""Resolution of one file, a robot or a library: its declarations and statements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, Protocol, TypeVar

from robosc.expr import tree, undefined_data
from robosc.expr.tree import Expr
from robosc.expr.types import EnumType, Type
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata, diagnostics, entities
from robosc.model.checks import command_data, exclusive, freshness, stopping, unused, used_fields
from robosc.model.checks.undefined_data import check_indexes, check_undefined_data
from robosc.model.declarations import components, named_values, parameters, servers, state_variables
from robosc.model.declarations.behaviour import BehaviourResolver
from robosc.model.declarations.components import (
    bind,
    check_interfaces,
    check_local_names,
    check_prefix,
    declare,
    join,
)
from robosc.model.declarations.datatypes import Given, TypeTable
from robosc.model.declarations.performing import find_performed, performed_data, with_performed
from robosc.model.declarations.statements import StatementResolver, Statements, check_preferences
from robosc.model.declarations.type_declarations import TypeDeclarations
from robosc.model.diagnostics import OfImport, Report
from robosc.model.names import copies, tables
from robosc.model.names.scope import FileScope, report_duplicate
from robosc.model.names.value_scope import ValueScope
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.links import Binder
from robosc.model.typing.declared_functions import FunctionTyper
from robosc.model.typing.expected import BOOLEAN
from robosc.model.typing.expressions import Typer
from robosc.model.typing.value_word import RULE, Incoming, no_value
from robosc.syntax import nodes

# The names before a dot that a file itself does not declare: they may be those of libraries.


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


# Typing of conditions that a person or a script asks of a resolved robot.  They are read as
# the model's own requirements are, with the same names: ``blocked and Sensor.way =
# Lib.Way.free``.


def conditions_over(types: TypeTable, table: tables.ComponentTable) -> entities.ConditionReader:
    """A reader with the names of a file in which everything is declared."""

    def read(node: nodes.ExprNode, report: diagnostics.Report) -> tree.Expr | None:
        expanded = copies.over_copies(node, table.copies, report)
        if report.has_errors:
            return None
        incoming = no_value("a condition on states has no received value")
        typer = Typer(report, types.reporting_to(report), tables.SymbolTable(table), incoming)
        found = typer.check(expanded, BOOLEAN, "a condition")
        return None if found is None else undefined_data.condition_on_data(found)

    return read


_Entity = TypeVar("_Entity")


@dataclass(frozen=True)
class FileContents:
    """The resolved declarations of a file without those in error, and its symbol tables."""

    scope: FileScope
    types: TypeTable
    component_table: tables.ComponentTable
    robot: entities.Robot

    @property
    def instances(self) -> Mapping[str, tables.Instance]:
        return self.component_table.instances


class FindLibrary(Protocol):
    """Returns the library of a name; None after a reported error, or if it is not ``imported`` and
    there is none."""

    def __call__(
        self, library: nodes.Name, scope: FileScope, report: Report, *, imported: bool = True
    ) -> FileContents | None: ...


class FileResolver:
    """Resolves the declarations and statements of one file."""

    def __init__(
        self,
        scope: FileScope,
        type_declarations: TypeDeclarations,
        definitions: MessageDefinitions,
        find_library: FindLibrary,
        report: Report,
        supervises: bool = False,
    ) -> None:
        self._type_declarations = type_declarations
        self._find_library = find_library
        self._scope = scope
        self._report = report
        self._supervises = supervises
        self.component_table = tables.ComponentTable()
        self.types = TypeTable(scope, type_declarations, report, self._rule_condition)
        self._binder = Binder(definitions, type_declarations, report)

    def resolve(self) -> FileContents:
        """The contents of the file; to be called once."""
        self._find_libraries()
        self._declare_values()
        robot = self._robot()
        self._scope.names.close()
        if self._scope.node.kind == "robot":
            parameters.check_parameters(robot, self._report)
        return FileContents(self._scope, self.types, self.component_table, robot)

    def _values(self) -> Iterator[ValueScope]:
        """The named values of the file, of its components, and of the libraries that it needs."""
        yield self.types.values
        for instance in self.component_table.instances.values():
            yield instance.types.values
        for table in self.types.all_libraries.values():
            yield table.values

    def _robot(self) -> entities.Robot:
        self.types.resolve_all()
        check_interfaces(self._scope.interfaces, self._report)
        for node in self._scope.components.values():
            self._add_component(node)
        for instance in self.component_table.instances.values():
            self._bind(instance)
        self.component_table.index_communications()
        for instance in self.component_table.instances.values():
            self._find_performed(instance)
        if self._scope.node.kind == "robot":
            check_local_names(self.component_table, self._report)
        components = tuple(self._component(i) for i in self.component_table.instances.values())
        self._check_duplicates()
        self._binder.check_unlinked(self._scope.interfaces.values())
        self.types.values.resolve()
        robot = self._with_statements(components)
        robot = self._with_heard(robot)
        usage = used_fields.Usage(robot)
        self._binder.report_unknown_fields(usage)
        robot = state_variables.select_state_variables(robot, self._report)
        enums = [t for t in map(self.types.known, self._scope.datatypes) if isinstance(t, EnumType)]
        lengths = {**self._type_declarations.ros.lengths, **self._binder.lengths}
        check_indexes(robot.components, enums, lengths, self._report)
        unused.check_case(self._scope, self.component_table, self._report)
        unused.check_topics(self.component_table, self._report)
        library = self._scope.node.kind == "library"
        broken = self.component_table.broken or self._scope.unresolved
        whole = not self._report.has_errors and not broken
        if library or not whole:
            exclusive.check_overlaps(robot.components, self._report, library=library)
        if whole:
            freshness.check_freshness(robot, self._report, library=library)
            stopping.check_cancels(robot.components, robot.communications, self._report)
            check_undefined_data(robot, lengths, self._scope.source, self._report)
            if not library:
                stopping.check_stop(robot, self._report)
                stopping.check_answers(robot, usage, self._report)
                stopping.check_served(robot, self._binder.sent, self._report)
            unused.check_unused(
                self._scope,
                self.types.values,
                self.component_table,
                robot,
                self._type_declarations,
                self._report,
            )
        return robot

    def _with_heard(self, robot: entities.Robot) -> entities.Robot:
        """The robot with the messages of which something asks whether they have arrived."""
        self.component_table.closed = True
        heard = {
            info.key
            for instance in self.component_table.instances.values()
            for info in instance.communications.values()
            if info.heard
        }

        def told(component: entities.Component) -> entities.Component:
            own = tuple(replace(c, heard=c.key in heard) for c in component.communications)
            return replace(component, communications=own)

        return replace(robot, components=tuple(map(told, robot.components))) if heard else robot

    def _find_libraries(self) -> None:
        """Read the imported libraries, before the constants and enum rules that may name them."""
        for node in self._scope.components.values():
            if isinstance(node, nodes.ImportNode):
                library = self._find_library(node.library, self._scope, self._report)
                if library is not None:
                    self.types.libraries[node.library.text] = library.types
        for name in qualifiers(self._scope.node.written or self._scope.node):
            if name.text not in self.types.libraries and not self._scope.is_unresolved(name.text):
                library = self._find_library(name, self._scope, self._report, imported=False)
                if library is not None:
                    self.types.libraries[name.text] = library.types

    def _declare_values(self) -> None:
        values = self.types.values
        node = self._scope.node
        values.typed = named_values.NamedValueTyper(
            self.types,
            self._report,
            lambda: tables.SymbolTable(self.component_table),
            node.name.text if node.kind == "library" else "",
        )
        values.typer = FunctionTyper(self.types, self._report)
        values.declare(self._scope.node.declarations, self._scope, self._report)

    def _own_values(self, instance: tables.Instance, report: Report) -> None:
        """Declare the named values of a component in a scope within that of its file."""
        file = instance.types.values
        values = ValueScope(instance.name, file.outer if file.owner else file)
        file_types = instance.types
        instance.types = file_types.inside(values, {})
        values.typed = named_values.NamedValueTyper(
            instance.types, report, lambda: self._symbols(instance), instance.name
        )
        values.typer = FunctionTyper(instance.types, report)
        values.declare(instance.node.items, instance.types.scope, report)
        if instance.imported is not None:
            arguments = self._arguments(instance.imported, values)
            instance.types.given = {**file_types.given, **arguments}

    def _arguments(self, node: nodes.ImportNode, values: ValueScope) -> dict[str, Given]:
        """The constants and parameters that an import sets."""
        given: dict[str, Given] = {}
        for argument in node.arguments:
            name = argument.name.text
            declared = values.node(name)
            if name in given:
                first = given[name].node.name.span
                report_duplicate("argument", argument.name, first, self._report)
            elif isinstance(declared, nodes.ConstantNode | nodes.ParameterNode):
                given[name] = Given(argument, self.types, self._report)
                self._scope.names.use(argument.name, declared, node.component.text)
            else:
                self._report.add(
                    "unknown-member",
                    argument.name.span,
                    f"{node.component.text} has no constant or parameter '{name}'",
                    self._report.suggest(name, values.settable),
                )
        return given

    def _rule_condition(self, types: TypeTable, node: nodes.ExprNode, source: Type) -> Expr | None:
        return Typer(self._report, types, None, Incoming(source)).check(node, BOOLEAN, RULE)

    # --- components ------------------------------------------------------------------------------

    def _add_component(self, node: nodes.ComponentNode | nodes.ImportNode) -> None:
        if isinstance(node, nodes.ComponentNode):
            instance = self._declared(node)
        else:
            found = self._imported(node)
            if found is None:
                self.component_table.broken.add(node.name.text)
                return
            instance = found
            self._declare(instance)
        self.component_table.add(instance)

    def _declared(self, node: nodes.ComponentNode) -> tables.Instance:
        """A component of this file, with what it declares."""
        instance = tables.Instance(node.name.text, node, self.types)
        self._declare(instance)
        return instance

    def _declare(self, instance: tables.Instance) -> None:
        report = self._report_of(instance)
        self._own_values(instance, report)
        instance.node = components.with_initial_states(instance, report)
        declare(instance, report)

    def _report_of(self, instance: tables.Instance) -> Report:
        imported = instance.imported
        return self._report if imported is None else OfImport(self._report, imported.component.span)

    def _bind(self, instance: tables.Instance) -> None:
        symbols = self._symbols(instance)
        for info in instance.communications.values():
            bind(info, symbols, self._binder, self._report)

    def _find_performed(self, instance: tables.Instance) -> None:
        find_performed(instance, self._symbols(instance), self._report_of(instance))

    def _check_duplicates(self) -> None:
        """Resolve duplicate components and behaviours, only to report the faults in them."""
        for instance in list(self.component_table.instances.values()):
            for behaviour in () if instance.imported else instance.duplicate_behaviours:
                outside = [i for i in instance.node.items if not isinstance(i, nodes.BehaviourNode)]
                self._check_aside(replace(instance.node, items=(*outside, behaviour)))
        for node in self._scope.duplicates:
            if isinstance(node, nodes.ComponentNode):
                self._check_aside(node)

    def _check_aside(self, node: nodes.ComponentNode) -> None:
        instance = self._declared(node)
        self._bind(instance)
        self._find_performed(instance)
        self._component(instance)
        self._add_statements(instance, Statements())

    def _imported(self, node: nodes.ImportNode) -> tables.Instance | None:
        prefix = check_prefix(node.prefix, self._report) if node.prefix is not None else ""
        library = self._find_library(node.library, self._scope, self._report)
        if library is None:
            return None
        self._scope.names.use(node.library, library.scope.node)
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
        self._scope.names.use(node.component, original.declaration)
        chain = prefix
        if prefix is not None and original.prefix != "":
            chain = None if original.prefix is None else join(prefix, original.prefix)
        instance = tables.Instance(node.name.text, original.node, original.types, chain, node)
        instance.original = original
        instance.library = library.component_table
        return instance

    def _component(self, instance: tables.Instance) -> entities.Component:
        symbols = self._symbols(instance)
        report = self._report_of(instance)
        instance.types.values.resolve()
        behaviour = automata.Behaviour(span=instance.node.name.span)
        if instance.behaviour is not None:
            behaviour = BehaviourResolver(instance, symbols, report).resolve(instance.behaviour)
        imported = instance.imported
        return entities.Component(
            instance.name,
            _sound(info.entity for info in instance.communications.values()),
            behaviour,
            imported.library.text if imported is not None else None,
            instance.declaration.copy,
            span=instance.declaration.name.span,
        )

    def _symbols(self, instance: tables.Instance) -> tables.SymbolTable:
        if instance.library is None or instance.original is None:
            return tables.SymbolTable(self.component_table, instance)
        return tables.ImportedSymbolTable(
            self.component_table, instance, instance.library, instance.original, self._report
        )

    # --- statements ------------------------------------------------------------------------------

    def _with_statements(self, components: tuple[entities.Component, ...]) -> entities.Robot:
        resolver = StatementResolver(
            tables.SymbolTable(self.component_table), self.types, self._binder, self._report
        )
        node = self._scope.node
        found = Statements()
        found.add(node.declarations, resolver)
        for instance in self.component_table.instances.values():
            self._add_statements(instance, found)
        stops = [item for item in node.declarations if isinstance(item, nodes.StopNode)]
        robot = entities.Robot(
            node.name.text,
            components,
            found.on_commands() if node.kind == "robot" else tuple(found.requirements),
            (*found.performed, *found.provides),
            tuple(found.preferences),
            tuple(p for values in self._values() for p in values.parameters),
            resolver.stop(stops),
            tuple(found.goals),
            tuple(found.assumptions),
            goes_on=resolver.stops_with_nothing(stops),
            conditions=conditions_over(self.types, self.component_table),
            span=node.name.span,
        )
        check_preferences(robot, self._report)
        # Who imports a library may provide the data of its commands.
        if node.kind == "library":
            return robot
        robot = servers.with_feedback_where_provided(servers.with_one_request_per_server(robot))
        conditions = tuple(one for values in self._values() for one in values.lasting)
        robot = servers.with_lasting(with_performed(robot), conditions)
        return command_data.with_command_data(
            robot, self._report, self._binder.sent.field_of, self._supervises
        )

    def _add_statements(self, instance: tables.Instance, statements: Statements) -> None:
        """Resolve the statements of a component, which sees names as its behaviour does."""
        report = self._report_of(instance)
        symbols = self._symbols(instance)
        resolver = StatementResolver(symbols, instance.types, self._binder, report)
        owner = instance.name if instance.imported is not None else ""
        statements.add(instance.node.items, resolver, owner)
        statements.performed += performed_data(instance, resolver)


def _sound(found: Iterable[_Entity | None]) -> tuple[_Entity, ...]:
    """The entities without those that have errors, for which None stands."""
    return tuple(entity for entity in found if entity is not None)
