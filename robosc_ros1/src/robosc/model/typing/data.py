"""Typing of data: objects, arrays, and the expressions in them."""

from __future__ import annotations

from robosc import errors, source
from robosc.expr import tree
from robosc.expr.types import ArrayType, DoubleType, DurationType, IntegerType, ObjectType, Type
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.entities import Data, DataArray, DataObject
from robosc.model.names.scope import report_duplicate
from robosc.model.ros.object_types import DURATIONS, TIMES
from robosc.model.typing import aggregates, durations, expected, expressions
from robosc.model.typing.compatibility import check_range, coerce, describe
from robosc.runtime.core.values import NOW
from robosc.syntax import nodes


class DataTyper:
    """Types the data of provide statements and constants; ``typer`` types their expressions."""

    def __init__(self, typer: expressions.Typer, types: TypeTable, report: Report) -> None:
        self._typer = typer
        self._types = types
        self._report = report

    def typed(self, node: nodes.DataNode, type_: Type, place: str) -> Data | None:
        """The data of a type; None after a reported error. ``place`` is a text for messages."""
        if not isinstance(node, nodes.DataObjectNode | nodes.ArrayNode) and not _is_made(node):
            return self._expression(node, type_, place)
        match node, type_:
            case nodes.DataObjectNode(), ObjectType():
                return self._object(node, type_)
            case nodes.ArrayNode(), ArrayType():
                return self._array(node, type_, place)
            case nodes.AggregateNode(), ArrayType():
                return self._made(node, type_, place)
        what, hint = "an array", None
        if isinstance(node, nodes.DataObjectNode):
            what = "an object"
            if len(node.fields) == 1 and not isinstance(type_, ArrayType):
                hint = f"write the value alone: {node.fields[0].value.span.text}"
        self._mismatch(_opening(node.span), type_, place, f", this is {what}", hint)
        return None

    def _expression(self, node: nodes.ExprNode, type_: Type, place: str) -> Data | None:
        match type_:
            case ObjectType() if duration := durations.signed_duration(node):
                return self._duration(duration, type_, place)
            case ObjectType(name=name) if name in TIMES and _is_now(node):
                return tree.Literal(NOW, type_, node.span)
            case ObjectType(name=name) if name in DURATIONS and isinstance(node, nodes.Access):
                return self._named_duration(node, type_, place)
            case ArrayType() | ObjectType() if isinstance(node, nodes.LiteralNode):
                form = "[ … ]"
                if isinstance(type_, ObjectType):
                    form = f"{{ {', '.join(f'{name}: …' for name, _ in type_.properties)} }}"
                self._mismatch(node.span, type_, place, hint=f"write {form}")
                return None
        expr = self._typer.check(node, expected.expected_type(type_), place)
        if expr is None:
            return None
        if isinstance(expr, tree.Made):
            return _as_data(expr, node.span)
        check_range(expr, type_, place, self._report)
        return coerce(expr, type_)

    def _mismatch(
        self, span: source.Span, type_: Type, place: str, given: str = "", hint: str | None = None
    ) -> None:
        message = f"{place} needs {describe(type_)}{given}"
        self._report.add("type-mismatch", span, message, hint)

    def _array(self, node: nodes.ArrayNode, type_: ArrayType, place: str) -> DataArray | None:
        elements = [self.typed(e, type_.element, f"an element of {place}") for e in node.elements]
        found = tuple(e for e in elements if e is not None)
        return DataArray(found, span=node.span) if len(found) == len(elements) else None

    def _made(self, node: nodes.AggregateNode, type_: ArrayType, place: str) -> Data | None:
        if isinstance(node.array, nodes.ArrayNode) and aggregates.takes_elements(node):
            return self._array(node.array, type_, place)

        def element() -> tree.Expr | None:
            data = self.typed(node.element, type_.element, f"an element of {place}")
            return None if data is None else as_expression(data, type_.element)

        return self._typer.made(node, element)

    def _duration(
        self, node: nodes.DurationNode, type_: ObjectType, place: str
    ) -> DataObject | None:
        """A literal duration as a message of ROS: whole seconds and nanoseconds."""
        if type_.name not in DURATIONS:
            self._mismatch(node.span, type_, place, ", this is a duration")
            return None
        fields = durations.duration_fields(node, type_.name).items()
        return DataObject(
            tuple((name, tree.Literal(part, IntegerType(), node.span)) for name, part in fields)
        )

    def _named_duration(self, node: nodes.Access, type_: ObjectType, place: str) -> Data | None:
        """A constant, a parameter or a variable as a message of ROS for durations."""

        def accepted(given: Type) -> bool:
            return given == type_ or isinstance(given, DurationType)

        found = self._typer.check(node, expected.ExpectedType(describe(type_), accepted), place)
        if found is None or not isinstance(found.type, DurationType):
            return found
        integer = IntegerType()
        second = tree.Literal(10**9, integer)
        exact = tree.Binary("*", found, tree.Literal(1e9, DoubleType()), DoubleType())
        nanoseconds = tree.Call("round", (exact,), integer, node.span)
        whole = tree.Binary("/", nanoseconds, second, DoubleType())
        rest = tree.Binary("%", nanoseconds, second, integer, node.span)
        parts = tree.Call("floor", (whole,), integer, node.span), rest
        return DataObject(tuple(zip(DURATIONS[type_.name], parts, strict=True)))

    def _object(self, node: nodes.DataObjectNode, type_: ObjectType) -> DataObject | None:
        fields: list[tuple[str, Data]] = []
        seen: dict[str, source.Span] = {}
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
            data = self.typed(item.value, inner, f"property '{name}'")
            if data is None:
                whole = False
            else:
                fields.append((name, data))
        return DataObject(tuple(fields)) if whole else None

    def _unknown_property(self, name: str, span: source.Span, type_: ObjectType) -> None:
        declarations = self._types.type_declarations
        if declarations.may_have(type_, name) or self._types.scope.is_unresolved(name):
            return
        inside = [
            f"{outer}: {{ {name}: … }}"
            for outer, inner in type_.properties
            if isinstance(inner, ObjectType) and inner.property(name) is not None
        ]
        names = [n for n, _ in type_.properties]
        suggested = self._report.suggest(name, names, "its properties")
        hint = f"write {errors.listing(inside, 'or')}" if inside else suggested
        message = f"{type_.name} has no property '{name}'"
        diagnostic = self._report.add("unknown-property", span, message, hint)
        declarations.miss(type_, name, diagnostic)


def _is_now(node: nodes.ExprNode) -> bool:
    """Whether a node is the call ``now()``."""
    return isinstance(node, nodes.CallNode) and node.span.text.replace(" ", "") == "now()"


def _is_made(node: nodes.DataNode) -> bool:
    return isinstance(node, nodes.AggregateNode) and node.function.text == "["


def _as_data(expr: tree.Expr, span: source.Span) -> Data:
    """What a function makes, as if it were written where the function is called."""
    match expr:
        case tree.Made(type=ArrayType()):
            elements = tuple(_as_data(part, span) for part in expr.operands)
            return DataArray(elements, span=span)
        case tree.Made(names=names):
            parts = (_as_data(part, span) for part in expr.operands)
            return DataObject(tuple(zip(names, parts, strict=True)))
    return expr


def as_expression(data: Data, type_: Type) -> tree.Expr:
    """Data within an array that is made, or that a function returns."""
    match data, type_:
        case DataObject(fields=fields), ObjectType(properties=properties):
            types = dict(properties)
            parts = tuple(as_expression(part, types[name]) for name, part in fields)
            return tree.Made(tuple(name for name, _ in fields), parts, type_)
        case DataArray(elements=elements), ArrayType(element=inner):
            return tree.Made((), tuple(as_expression(part, inner) for part in elements), type_)
    assert not isinstance(data, DataObject | DataArray)
    if isinstance(type_, DoubleType) and isinstance(data.type, IntegerType):
        return tree.Binary("*", data, tree.Literal(1.0, type_), type_, data.span)
    return data


def _opening(span: source.Span) -> source.Span:
    """The span of the opening bracket."""
    return source.Span(span.source, span.start, span.start + 1)
