"""Candidate meanings of names in expressions, among which the expected type then selects."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from robosc import dotted, source
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.tree import (
    REASON,
    Expr,
    Literal,
    ParameterRef,
    PhaseRef,
    ReasonRef,
    StateRef,
    VariableRef,
)
from robosc.expr.types import ArrayType, EnumType, ObjectType, Type
from robosc.expr.undefined_data import none_of
from robosc.language.events import active_names, named_phases
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.names.occurrences import Declaration, Symbol, SymbolKind
from robosc.model.names.report_unknown import NameFaults, last_name
from robosc.model.names.scope import FileScope
from robosc.model.names.tables import RETRIES, CommunicationInfo, Instance, SymbolTable
from robosc.model.names.value_scope import ValueScope
from robosc.syntax.nodes import Access, BinaryNode, FunctionNode, Name, StateNode, ValueNode

_WHOLE = (ArrayType, ObjectType)


class RosConstant(NamedTuple):
    """``package/Type.NAME``: a constant of the definition of a ROS type."""

    package: Name
    type: Name
    name: Name
    span: source.Span


class Meanings:
    """The meanings of names at one place; they are recorded for editors.

    ``reasons`` is the type of ``reason``, where an error has one.
    """

    def __init__(
        self,
        report: Report,
        types: TypeTable,
        symbols: SymbolTable | None,
        reasons: EnumType | None = None,
    ) -> None:
        self._report = report
        self._reasons = reasons
        self._types = types
        self._symbols = symbols
        self._faults = NameFaults(report, types, symbols)
        self._named: IdentityCache[tuple[ValueNode | StateNode, str]] = IdentityCache()

    def of(self, access: Access) -> list[Expr] | None:
        """All meanings of a name; None if an error was reported already."""
        meanings: list[Expr] | None = self._state_of_path(access)
        match access.path:
            case _ if meanings:
                pass
            case ():
                meanings = self._bare(access)
            case (Name() as member,):
                meanings = self._qualified(access, member)
            case (Name() as member, Name() as phase):
                meanings = self._phase_of_member(access, member, phase)
                meanings = meanings or self._value_of_library_enum(access, member, phase)
                library = self._types.libraries.get(access.root.text)
                if not meanings and library and member.text in library.scope.interfaces:
                    return self._interface_constant(access, member, library.scope, phase)
                if not meanings:
                    self._faults.no_parts(access)
                    return None
            case _:
                self._faults.no_parts(access)
                meanings = None
        if meanings:
            self.record(access, meanings[0])  # replaced if another meaning is selected
        elif access.path:
            self._types.scope.names.use(access.root, self._declaration(access.root.text))
        return meanings

    def function(self, access: Access) -> tuple[FunctionNode, ValueScope] | None:
        """The function of a name, and the scope that declares it; None if there is none."""
        root = access.root.text
        match access.path:
            case ():
                declared = self._types.values.function(root)
            case (Name(text=name),):
                component = self._symbols.component(root) if self._symbols else None
                library = self._types.libraries.get(root)
                scope = component.types.values if component else library and library.values
                node = scope.functions.get(name) if scope else None
                declared = (node, scope) if node is not None and scope else None
            case _:
                return None
        if declared is not None:
            self._use(access, declared[0], declared[1].owner)
        return declared

    def whole_of(self, access: Access) -> tuple[VariableRef | Literal | ParameterRef, int] | None:
        """The object or array of which an access is a part, and how many of its members name it."""
        if not access.path:
            return None
        first, name = access.path[0], access.root.text
        constant = self._constant_whole(access)
        if constant is not None:
            return constant
        if self._symbols is None:
            return None
        own = self._symbols.own
        if own is not None and isinstance(own.variables.get(name), _WHOLE):
            return self._whole(own, Access(access.root, (), span=access.root.span)), 0
        component = self._symbols.component(name)
        if component is None or not isinstance(first, Name) or len(access.path) == 1:
            return None
        if not isinstance(component.variables.get(first.text), _WHOLE):
            return None
        return self._whole(component, Access(access.root, (first,), span=access.span)), 1

    def _constant_whole(self, access: Access) -> tuple[Literal | ParameterRef, int] | None:
        """The constant or parameter of which an access is a part, and how many of its members name
        it."""
        named = self._types.values.find(access.root.text)
        members = 0
        if named is None and len(access.path) > 1 and isinstance(access.path[0], Name):
            member = self._value_of(access.root.text, access.path[0].text)
            named = None if member is None else (*member, access.root.text)
            members = 1
        if named is None or not isinstance(named[1], Literal | ParameterRef):
            return None
        if not isinstance(named[1].type, _WHOLE):
            return None
        meaning = self._value(access, named[0], named[1], named[2])
        assert isinstance(meaning, Literal | ParameterRef)
        self.record(replace(access, path=access.path[:members]), meaning)
        return meaning, members

    def _whole(self, component: Instance, access: Access) -> VariableRef:
        name = last_name(access)
        type_ = component.variables[name]
        assert type_ is not None
        variable = VariableRef(component.name, name, type_, access.span)
        self.record(access, variable)
        return variable

    def record(self, access: Access, meaning: Expr) -> None:
        """Record the meaning of a name for editors."""
        named = self._named.known(meaning)
        if named is not None:
            self._use(access, *named)
            return
        if isinstance(meaning, Literal):
            if isinstance(meaning.type, EnumType):
                self._types.record_value(access, meaning.type)
            return
        if isinstance(meaning, ReasonRef):
            words = ", ".join(self._reasons.values) if self._reasons else ""
            self._types.scope.names.note(access.root, Symbol(SymbolKind.INCOMING, "reason", words))
            return
        assert self._symbols is not None
        names, owner, last = self._types.scope.names, self._symbols.own, access.root
        if not isinstance(meaning, VariableRef) or meaning.variable.endswith(f" {RETRIES}"):
            return  # the phase of a communication; what a path of states means is recorded already
        if access.path and isinstance(access.path[0], Name):
            owner, last = self._symbols.component(access.root.text), access.path[0]
            names.use(access.root, owner.declaration if owner is not None else None)
        assert owner is not None
        names.use(last, owner.variable_nodes.get(last.text), owner.name)

    def _record_communication(self, access: Access, info: CommunicationInfo) -> None:
        names, last = self._types.scope.names, access.root
        if len(access.path) > 1 and isinstance(access.path[0], Name):
            last = access.path[0]
            names.use(access.root, info.instance.declaration)
        names.use(last, info.node, info.instance.name)

    def _use(self, access: Access, node: Declaration, owner: str) -> None:
        """Record the name of a declaration, and of the component or library that stands before."""
        names = self._types.scope.names
        names.use(_last(access), node, owner)
        if access.path:
            library = self._types.libraries.get(access.root.text)
            owner_node = self._declaration(access.root.text)
            if owner_node is None and library is not None:
                owner_node = library.scope.node
            names.use(access.root, owner_node)

    def _declaration(self, name: str) -> Declaration | None:
        """The component or datatype of a name, which may stand before a dot."""
        component = self._symbols.declaration(name) if self._symbols is not None else None
        return component or self._types.scope.datatypes.get(name)

    def _bare(self, access: Access) -> list[Expr] | None:
        name = access.root.text
        own = self._symbols.own if self._symbols else None
        meanings = self._members(own, name, access.span) if own is not None else []
        value = self._types.values.find(name)
        if meanings is None or (value is not None and value[1] is None):
            return None
        if value is not None and value[1] is not None:
            meanings.append(self._value(access, value[0], value[1], value[2]))
        if name == "reason" and self._reasons is not None:
            meanings.append(ReasonRef(REASON, self._reasons, access.span))
        return [*meanings, *(Literal(name, e, access.span) for e in self._types.enums_with(name))]

    def _qualified(self, access: Access, member: Name) -> list[Expr] | None:
        root, name = access.root.text, member.text
        symbols = self._symbols
        component = symbols.component(root) if symbols else None
        meanings = self._members(component, name, access.span) if component is not None else []
        if meanings is None:
            return None
        enum = self._types.enum(root)
        if enum is not None and name in enum.values:
            meanings.append(Literal(name, enum, access.span))
        value = self._value_of(root, name)
        if value is not None and value[1] is None:
            return None
        if value is not None and value[1] is not None:
            meanings.append(self._value(access, value[0], value[1], root))
        if not meanings and symbols is not None:
            known = symbols.communications(root)
            meanings = self._phase(access, known[0] if len(known) == 1 else None, member)
        if not meanings and self._is_constant(root, name):
            return self._interface_constant(access, access.root, self._types.scope, member)
        if meanings:
            return meanings
        if (symbols and symbols.is_broken(root)) or self._types.scope.is_unresolved(name):
            return None
        if component is not None or enum is not None:
            self._faults.unknown_member(access, member)
            return None
        return []

    def _value_of(self, root: str, name: str) -> tuple[ValueNode, Expr | None] | None:
        """The constant or condition of a component or a library."""
        component = self._symbols.component(root) if self._symbols else None
        if component is not None:
            return component.types.values.own(name)
        library = self._types.libraries.get(root)
        return None if library is None else library.values.own(name)

    def _value(self, access: Access, node: ValueNode, meaning: Expr, owner: str) -> Expr:
        """A copy of a named value's meaning, with the span of the access."""
        copy = replace(meaning, span=access.span)
        self._named.of(copy, lambda _: (node, owner))
        return copy

    def _is_constant(self, root: str, name: str) -> bool:
        """Whether ``root.name`` is a constant of an interface, not a part of a communication."""
        if root not in self._types.scope.interfaces:
            return False
        taken = self._symbols is not None and self._symbols.communications(root)
        return not taken or self._types.has_constant(root, name)

    def ros_constant(self, node: BinaryNode) -> RosConstant | None:
        """``package/Type.NAME``, which parses as a division; None if it is a division."""
        package = node.left
        if isinstance(package, BinaryNode) and package.operator == "/":
            package = package.left  # package/msg/Type.NAME
        match node.operator, package, node.right:
            case "/", Access(root=name, path=()), Access(root=type_, path=(Name() as member,)):
                if self._is_package(name):
                    return RosConstant(name, type_, member, node.span)
        return None

    def _is_package(self, name: Name) -> bool:
        """Whether a name is that of a ROS package, and of no variable or state."""
        own = self._symbols.own if self._symbols else None
        if own is not None and (name.text in own.variables or name.text in own.states):
            return False
        packages = self._types.type_declarations.ros.definitions.packages
        return packages.find(name.text) is not None

    def _members(self, component: Instance, name: str, span: source.Span) -> list[Expr] | None:
        """The variable and the state of a name; None if the variable's type has an error."""
        meanings: list[Expr] = []
        if name in component.variables:
            type_ = component.variables[name]
            if type_ is None:
                return None
            meanings.append(VariableRef(component.name, name, type_, span))
        state = component.state(name)
        return meanings if state is None else [*meanings, self._in_state(component, state, span)]

    def _in_state(self, component: Instance, path: str, span: source.Span) -> Expr:
        """The condition that a component is in a state, or in one of those in it."""
        leaves = tuple(component.leaves(path))
        condition = StateRef(component.name, path, span, () if leaves == (path,) else leaves)
        self._named.of(condition, lambda _: (component.states[path], component.name))
        return condition

    def _state_of_path(self, access: Access) -> list[Expr]:
        """``docking.near`` or ``Base.docking.near``: a state in a state; empty if it is none."""
        names = [access.root, *(step for step in access.path if isinstance(step, Name))]
        if self._symbols is None or len(names) != 1 + len(access.path):
            return []
        owner = self._symbols.component(access.root.text)
        for component, steps in ((owner, names[1:]), (self._symbols.own, names)):
            path = ".".join(step.text for step in steps)
            if component is None or len(steps) < 2:
                continue
            use = self._types.scope.names.use
            performing = component.of_performing(path, access.span)
            state = component.state(dotted.around(path) if performing else path)
            if state is None:
                continue
            use(access.root, component.declaration if component is owner else None)
            inside = state
            for step in reversed(steps[:-1] if performing else steps):
                use(step, component.states[inside], component.name)
                inside = dotted.around(inside)
            return [performing or self._in_state(component, state, access.span)]
        return []

    def _phase_of_member(self, access: Access, member: Name, phase: Name) -> list[Expr]:
        """``Arm.grab.busy``: the phase of a communication with a qualified name."""
        component = self._symbols.component(access.root.text) if self._symbols else None
        info = component.communications.get(member.text) if component else None
        return self._phase(access, info, phase)

    def _interface_constant(
        self, access: Access, interface: Name, scope: FileScope, member: Name
    ) -> list[Expr] | None:
        """``interface.NAME`` or ``Library.interface.NAME``: a constant of a real definition."""
        found = self._types.interface_constant(interface, scope, member, access.span)
        return None if found is None else [found]

    def _value_of_library_enum(self, access: Access, datatype: Name, value: Name) -> list[Expr]:
        """``Library.Enum.value``: the value of a library's enum."""
        library = self._types.libraries.get(access.root.text)
        enum = None if library is None else library.known(datatype.text)
        if not isinstance(enum, EnumType) or value.text not in enum.values:
            return []
        return [Literal(value.text, enum, access.span)]

    def _phase(self, access: Access, info: CommunicationInfo | None, phase: Name) -> list[Expr]:
        """``grab.busy``, ``grab.idle``, ``scan.fresh``, ``scan.silent`` or ``scan.heard``; empty if
        it is none."""
        if info is not None and phase.text == "heard" and info.sort.may_be_heard:
            return self._heard(access, info)
        phases = None if info is None else info.phases
        if info is None or phases is None:
            return []
        self._record_communication(access, info)
        if phase.text not in phases.names:
            return []
        if phase.text in phases.active:
            within = named_phases(phases.names, phase.text)
            return [PhaseRef(info.key, phase.text, access.span, within)]
        others = (
            PhaseRef(info.key, name, access.span, named_phases(phases.names, name))
            for name in active_names(phases.names)
        )
        return [none_of(others, access.span)]

    def _heard(self, access: Access, info: CommunicationInfo) -> list[Expr]:
        """The condition that a message has arrived."""
        if self._symbols is not None and self._symbols.component_table.closed and not info.heard:
            return []  # the robot has no memory of it
        info.heard = True
        self._record_communication(access, info)
        within = ("fresh", "silent") if info.has_timeout else ()
        return [PhaseRef(info.key, "heard", access.span, within)]

    def out_of_sight(self, access: Access, types: list[Type], known: list[Expr]) -> list[Expr]:
        """The name as a value of enums among ``types`` that are not in scope."""
        name = last_name(access)
        seen = {m.type for m in known if isinstance(m, Literal)}
        values: list[Expr] = []
        for type_ in types:
            if not isinstance(type_, EnumType) or name not in type_.values or type_ in seen:
                continue
            if access.path and access.root.text != type_.name:
                continue
            seen.add(type_)
            values.append(Literal(name, type_, access.span))
        return values


def _last(access: Access) -> Name:
    """The last member of an access that is a name, or its root."""
    return next((p for p in reversed(access.path) if isinstance(p, Name)), access.root)
