"""Constants, parameters and named conditions of a file or a component."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import cast

from robosc.model.datatypes import TypeTable
from robosc.model.durations import duration_fields
from robosc.model.evaluation import constant
from robosc.model.expected import BOOLEAN, expected_type
from robosc.model.expr import Expr, Literal, ParameterRef, RosParameter
from robosc.model.expressions import Typer, no_value
from robosc.model.report import Report
from robosc.model.ros.types import DURATIONS
from robosc.model.tables import SymbolTable
from robosc.model.types import (
    ArrayType,
    DurationType,
    EnumType,
    ObjectType,
    Type,
    Value,
)
from robosc.model.values import check_range, coerce, describe, is_basic
from robosc.syntax.nodes import (
    ArrayNode,
    ConditionNode,
    ConstantNode,
    DataNode,
    DataObjectNode,
    DurationNode,
    ParameterNode,
    ValueNode,
)

__all__ = ["NamedValueTyper"]


@dataclass
class NamedValueTyper:
    """Types the values that a file or a component names, each when it is first asked for.

    What they mean stands in the place of their names from then on: later stages know no names.
    ``owner`` is the component or library whose name stands before that of a parameter.
    """

    types: TypeTable
    report: Report
    symbols: Callable[[], SymbolTable]
    owner: str = ""
    _open: list[str] = field(default_factory=list)

    def __call__(self, node: ValueNode) -> Expr | None:
        """The meaning of the name that a node declares; None after a reported error."""
        name = node.name.text
        if name in self._open:
            self.report.add("initial-not-constant", node.name.span, f"'{name}' is told by itself")
            return None
        self._open.append(name)
        try:
            match node:
                case ConditionNode():
                    reason = "a named condition is about the state, not about what comes in"
                    typer = Typer(self.report, self.types, self.symbols(), no_value(reason))
                    return typer.check(node.value, BOOLEAN, f"condition '{name}'")
                case ConstantNode():
                    return self._literal(node, f"constant '{name}'")
                case ParameterNode():
                    return self._parameter(node, f"parameter '{name}'")
        finally:
            self._open.remove(name)

    def _parameter(self, node: ParameterNode, what: str) -> ParameterRef | None:
        default = self._literal(node, what)
        if default is None:
            return None
        key = f"{self.owner}.{node.name.text}" if self.owner else node.name.text
        parameter = RosParameter(key, default.type, default.value, span=node.name.span)
        return ParameterRef(parameter, node.name.span)

    def _literal(self, node: ConstantNode | ParameterNode, what: str) -> Literal | None:
        """What is declared, or what the import of the component sets in its place."""
        type_ = self.types.of_value(node.type)
        if type_ is None or not self._is_possible(node, type_, what):
            return None
        given = self.types.values.given.get(node.name.text)
        if given is None:
            value = _constant(node.value, type_, what, self.types, self.report)
        else:
            value = _constant(given.node.value, type_, what, given.types, given.report)
        return None if value is None else Literal(value, type_, node.name.span)

    def _is_possible(self, node: ConstantNode | ParameterNode, type_: Type, what: str) -> bool:
        if is_basic(type_) or isinstance(type_, EnumType | DurationType):
            return True
        if isinstance(node, ConstantNode) and isinstance(type_, ArrayType | ObjectType):
            return True
        self.report.add(
            "variable-type",
            node.type.span,
            f"{what} cannot be {describe(type_)}",
            "use string, boolean, integer, double, duration or an enum",
        )
        return False


def _constant(
    node: DataNode, type_: Type, what: str, types: TypeTable, report: Report
) -> Value | None:
    """The value of a constant expression; None after a reported error.

    That of an object is a dict, that of an array a tuple, as provided data have them.
    """
    match node, type_:
        case DataObjectNode(), ObjectType():
            return _object(node, type_, what, types, report)
        case ArrayNode(elements=elements), ArrayType(element=element):
            parts = [
                _constant(e, element, f"an element of {what}", types, report) for e in elements
            ]
            return None if None in parts else cast(Value, tuple(parts))
        case DurationNode(), ObjectType(name=name) if name in DURATIONS:
            return cast(Value, duration_fields(node, name))
    if isinstance(node, DataObjectNode):
        message = f"{what} needs {describe(type_)}, this is an object"
        report.add("type-mismatch", node.span, message)
        return None
    word = what.partition(" ")[0]
    typer = Typer(report, types, None, no_value(f"a {word} cannot depend on what comes in"))
    expr = typer.check(node, expected_type(type_), what)
    if expr is None:
        return None
    value = constant(expr)
    if value is None:
        message = f"the value of {what} must be a finite constant"
        report.add("initial-not-constant", node.span, message)
        return None
    check_range(expr, type_, what, report)
    literal = coerce(Literal(value, type_, node.span), type_)
    assert isinstance(literal, Literal)
    return literal.value


def _object(
    node: DataObjectNode, type_: ObjectType, what: str, types: TypeTable, report: Report
) -> Value | None:
    """The values of the properties that are named, the others keep their defaults."""
    found: dict[str, Value | None] = {}
    for given in node.fields:
        name = given.name.text
        inner = type_.property(name)
        types.record_property(given.name, type_)
        if name in found or inner is None:
            code, words = ("duplicate-name", "is given twice") if name in found else (
                "unknown-property", f"is no property of {type_.name}"
            )  # fmt: skip
            known = [n for n, _ in type_.properties]
            hint = None if name in found else report.suggest(name, known, "its properties")
            report.add(code, given.name.span, f"'{name}' {words}", hint)
            return None
        found[name] = _constant(given.value, inner, f"property '{name}'", types, report)
    return None if None in found.values() else cast(Value, found)
