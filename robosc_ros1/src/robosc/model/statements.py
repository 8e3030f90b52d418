"""Requirements and provided data."""

from __future__ import annotations

import re
from collections.abc import Sequence
from graphlib import CycleError, TopologicalSorter
from itertools import product

from robosc.errors import Note
from robosc.model.communications import resolve_communication
from robosc.model.datatypes import TypeTable
from robosc.model.durations import duration_fields
from robosc.model.entities import (
    Data,
    DataArray,
    DataObject,
    Kind,
    Preference,
    Provide,
    Requirement,
)
from robosc.model.expected import BOOLEAN, ExpectedType, expected_type
from robosc.model.expr import Binary, Call, Literal
from robosc.model.expressions import Typer, no_value
from robosc.model.presence import condition_on_data
from robosc.model.report import Report
from robosc.model.ros.links import Binder
from robosc.model.ros.types import DURATIONS, TIMES
from robosc.model.scope import report_duplicate
from robosc.model.tables import CommunicationInfo, SymbolTable
from robosc.model.types import (
    ArrayType,
    DoubleType,
    DurationType,
    IntegerType,
    NoneType,
    ObjectType,
    Type,
)
from robosc.model.values import check_range, coerce, describe
from robosc.runtime.values import NOW
from robosc.source import Span
from robosc.syntax.nodes import (
    Access,
    ArrayNode,
    CallNode,
    DataNode,
    DataObjectNode,
    DurationNode,
    LiteralNode,
    PreferNode,
    ProvideNode,
    RequirementNode,
)

__all__ = ["StatementResolver", "check_preferences"]

_COMMENT_OR_STRING = re.compile(
    r"""//[^\n]*|/\*.*?\*/|("(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')""", re.DOTALL
)


class StatementResolver:
    """Resolves the statements of a robot over all its components."""

    def __init__(
        self, symbols: SymbolTable, types: TypeTable, binder: Binder, report: Report
    ) -> None:
        self._symbols = symbols
        self._types = types
        self._binder = binder
        self._report = report
        self._typer = Typer(
            report, types, symbols, no_value("nothing comes in where a command is decided on")
        )

    def requirement(self, node: RequirementNode) -> Requirement | None:
        """The requirement; None after an error."""
        keys: list[str] = []
        seen: dict[str, Span] = {}
        whole = True
        for access in node.communications:
            info = self._command(access, "requirement-on-outgoing", _CANNOT_FORBID)
            if info is None:
                whole = False
            elif info.key in seen:
                self._report.add(
                    "repeated-communication",
                    access.span,
                    f"'{access.span.text}' stands twice in this requirement",
                    None,
                    [Note("the first one is here", seen[info.key])],
                )
            else:
                seen[info.key] = access.span
                keys.append(info.key)
        condition = self._typer.check(node.condition, BOOLEAN, "a requirement")
        if condition is None or not whole:
            return None
        text = fold_text(node.span.text) + (f" ({node.place})" if node.place else "")
        condition = condition_on_data(condition)
        return Requirement(node.kind, tuple(keys), condition, text, span=node.span)

    def preference(self, node: PreferNode) -> Preference | None:
        """The preference; None after an error."""
        preferred, over = self._commands(node.preferred), self._commands(node.over)
        if None in preferred or None in over:
            return None
        return Preference(_keys(preferred), _keys(over), span=node.span)

    def _commands(self, accesses: Sequence[Access]) -> list[CommunicationInfo | None]:
        return [self._command(a, "preference-on-outgoing", _CANNOT_PREFER) for a in accesses]

    def provide(self, node: ProvideNode) -> Provide | None:
        """The provide statement; None after an error."""
        info = self._command(node.communication, "provide-for-outgoing", _CANNOT_PROVIDE)
        data = self._data_for(node, info)
        condition = None
        if node.condition is not None:
            condition = self._typer.check(node.condition, BOOLEAN, "the condition")
            if condition is None:
                return None
            condition = condition_on_data(condition)
        if info is None or data is None:
            return None
        if info.entity is not None:
            self._binder.sent.check(data, info.node, info.entity.binding)
        return Provide(info.key, data, condition, span=node.span)

    def _command(self, access: Access, code: str, why: str) -> CommunicationInfo | None:
        info = resolve_communication(access, self._symbols, self._types.scope, self._report)
        if info is not None and info.kind is Kind.OUTGOING:
            self._report.add(code, access.span, f"'{info.name}' is an outgoing message: {why}")
            return None
        return info

    # --- data ------------------------------------------------------------------------------------

    def _data_for(self, node: ProvideNode, info: CommunicationInfo | None) -> Data | None:
        if info is None or info.request is None:
            return None
        if isinstance(info.request, NoneType):
            if node.data == DataObjectNode((), span=node.data.span):
                return DataObject(())
            self._report.add(
                "nothing-to-provide",
                node.data.span,
                f"'{info.name}' carries no data",
                "remove the statement, or give the communication a type",
            )
            return None
        return self._data(node.data, info.request, f"'{info.name}'")

    def _data(self, node: DataNode, type_: Type, place: str) -> Data | None:
        if isinstance(node, DataObjectNode):
            if isinstance(type_, ObjectType):
                return self._object(node, type_)
            self._report.add(
                "type-mismatch",
                _opening(node.span),
                f"{place} needs {describe(type_)}, this is an object",
            )
            return None
        if isinstance(node, ArrayNode):
            if isinstance(type_, ArrayType):
                return self._array(node, type_, place)
            self._report.add(
                "type-mismatch",
                _opening(node.span),
                f"{place} needs {describe(type_)}, this is an array",
            )
            return None
        if isinstance(type_, ObjectType) and isinstance(node, DurationNode):
            return self._duration(node, type_, place)
        if isinstance(type_, ObjectType) and type_.name in TIMES and _is_now(node):
            return Literal(NOW, type_, node.span)
        if isinstance(type_, ObjectType) and type_.name in DURATIONS and isinstance(node, Access):
            return self._named_duration(node, type_, place)
        if isinstance(type_, ArrayType | ObjectType) and not isinstance(node, LiteralNode):
            return self._typer.check(node, expected_type(type_), place)
        if isinstance(type_, ObjectType):
            names = ", ".join(f"{name}: …" for name, _ in type_.properties)
            self._report.add(
                "type-mismatch",
                node.span,
                f"{place} needs {describe(type_)}",
                f"write {{ {names} }}",
            )
            return None
        if isinstance(type_, ArrayType):
            self._report.add(
                "type-mismatch", node.span, f"{place} needs {describe(type_)}", "write [ … ]"
            )
            return None
        expr = self._typer.check(node, expected_type(type_), place)
        if expr is None:
            return None
        check_range(expr, type_, place, self._report)
        return coerce(expr, type_)

    def _array(self, node: ArrayNode, type_: ArrayType, place: str) -> DataArray | None:
        elements = [self._data(e, type_.element, f"an element of {place}") for e in node.elements]
        found = tuple(e for e in elements if e is not None)
        return DataArray(found, span=node.span) if len(found) == len(elements) else None

    def _duration(self, node: DurationNode, type_: ObjectType, place: str) -> DataObject | None:
        """A duration as the message that ROS has for it: whole seconds and nanoseconds."""
        if type_.name not in DURATIONS:
            self._report.add(
                "type-mismatch", node.span, f"{place} needs {describe(type_)}, this is a duration"
            )
            return None
        fields = duration_fields(node, type_.name).items()
        return DataObject(
            tuple((name, Literal(part, IntegerType(), node.span)) for name, part in fields)
        )

    def _named_duration(self, node: Access, type_: ObjectType, place: str) -> Data | None:
        """A constant, a parameter or a variable as the message that ROS has for durations."""

        def accepted(given: Type) -> bool:
            return given == type_ or isinstance(given, DurationType)

        found = self._typer.check(node, ExpectedType(describe(type_), accepted), place)
        if found is None or not isinstance(found.type, DurationType):
            return found
        integer = IntegerType()
        second = Literal(10**9, integer)
        exact = Binary("*", found, Literal(1e9, DoubleType()), DoubleType())
        nanoseconds = Call("round", (exact,), integer, node.span)
        whole = Binary("/", nanoseconds, second, DoubleType())
        rest = Binary("%", nanoseconds, second, integer, node.span)
        parts = Call("floor", (whole,), integer, node.span), rest
        return DataObject(tuple(zip(DURATIONS[type_.name], parts, strict=True)))

    def _object(self, node: DataObjectNode, type_: ObjectType) -> DataObject | None:
        fields: list[tuple[str, Data]] = []
        seen: dict[str, Span] = {}
        whole = True
        for item in node.fields:
            name = item.name.text
            if name in seen:
                report_duplicate("value", item.name, seen[name], self._report)
                whole = False
                continue
            seen[name] = item.name.span
            inner = type_.property(name)
            self._types.record_property(item.name, type_)
            if inner is None:
                self._unknown_property(item.name.text, item.name.span, type_)
                whole = False
                continue
            data = self._data(item.value, inner, f"property '{name}'")
            if data is None:
                whole = False
            else:
                fields.append((name, data))
        return DataObject(tuple(fields)) if whole else None

    def _unknown_property(self, name: str, span: Span, type_: ObjectType) -> None:
        declarations = self._types.type_declarations
        if declarations.may_have(type_, name) or self._types.scope.is_unresolved(name):
            return
        told = self._report.add(
            "unknown-property",
            span,
            f"{type_.name} has no property '{name}'",
            self._report.suggest(name, [n for n, _ in type_.properties], "its properties"),
        )
        declarations.miss(type_, name, told)


def _is_now(node: DataNode) -> bool:
    """Whether this is ``now()``."""
    return isinstance(node, CallNode) and node.span.text.replace(" ", "") == "now()"


def _opening(span: Span) -> Span:
    return Span(span.source, span.start, span.start + 1)


def fold_text(text: str) -> str:
    """Text of the model on one line, without comments; strings stay as they are."""
    plain = _COMMENT_OR_STRING.sub(lambda match: match[1] or " ", text)
    return " ".join(plain.split())


_CANNOT_FORBID = "the controller cannot forbid what the robot sends"
_CANNOT_PREFER = "the controller has no say in when the robot sends it"
_CANNOT_PROVIDE = "the robot sends its data, not the controller"


def _keys(found: Sequence[CommunicationInfo | None]) -> tuple[str, ...]:
    return tuple(info.key for info in found if info is not None)


def check_preferences(preferences: Sequence[Preference], report: Report) -> None:
    """Report commands of which each is preferred to the next, round to the first."""
    below: dict[str, dict[str, Span]] = {}
    for preference in preferences:
        for first, second in product(preference.preferred, preference.over):
            below.setdefault(first, {}).setdefault(second, preference.span)
    try:
        TopologicalSorter(below).prepare()
    except CycleError as error:
        *_, before, last = cycle = error.args[1][::-1]
        names = " over ".join(key.rpartition(".")[2] for key in cycle)
        report.add(
            "preference-cycle",
            below[before][last],
            f"each of these is preferred to the next: {names}",
            "remove one of the preferences",
        )
