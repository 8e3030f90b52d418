"""Typing of the constants, parameters and named conditions of a file or a component."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

from robosc import limits, source
from robosc.expr.evaluation import constant
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.tree import Aggregate, Expr, Literal, ParameterRef, RosParameter, StateRef
from robosc.expr.types import ArrayType, DurationType, EnumType, ObjectType, Type, Value, innermost
from robosc.model.automata import HOLDING, Lasting
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.entities import Data, DataArray, DataObject
from robosc.model.names import scope, tables
from robosc.model.typing.compatibility import coerce, completed, describe, example, is_basic
from robosc.model.typing.data import DataTyper
from robosc.model.typing.durations import DURATION, is_long_enough
from robosc.model.typing.expected import BOOLEAN
from robosc.model.typing.expressions import Typer
from robosc.model.typing.value_word import no_value
from robosc.runtime.core import settings, values
from robosc.syntax import leaves, nodes


@dataclass
class NamedValueTyper:
    """Types the declarations of named values on demand; see :class:`ValueScope`.

    Their meanings replace their names in expressions. ``owner`` is the component or library by
    which the name of a parameter is qualified.
    """

    types: TypeTable
    report: Report
    symbols: Callable[[], tables.SymbolTable]
    owner: str = ""
    _open: list[str] = field(default_factory=list)
    _sizes: IdentityCache[int] = field(default_factory=IdentityCache)

    def __call__(self, node: nodes.ValueNode) -> Expr | None:
        """The expression for which the declared name stands; None after a reported error."""
        name = node.name.text
        if name in self._open:
            self.report.add("initial-not-constant", node.name.span, f"'{name}' depends on itself")
            return None
        self._open.append(name)
        try:
            match node:
                case nodes.ConditionNode():
                    reason = "a named condition is about the state, not about a received value"
                    typer = Typer(self.report, self.types, self.symbols(), no_value(reason))
                    found = typer.check(node.value, BOOLEAN, f"condition '{name}'")
                    bounded = None if found is None else self._bounded(found, node)
                    return self._lasting(bounded, node, typer) if bounded is not None else None
                case nodes.ConstantNode():
                    return self._literal(node, f"constant '{name}'")
                case nodes.ParameterNode():
                    return self._parameter(node, f"parameter '{name}'")
        finally:
            self._open.remove(name)

    def _lasting(self, condition: Expr, node: nodes.ConditionNode, typer: Typer) -> Expr | None:
        """The condition, or where it has held as long as its declaration says."""
        if node.duration is None:
            return condition
        delay = typer.check(node.duration, DURATION, "'for'")
        if delay is None or not is_long_enough(delay, "'for'", node.duration.span, self.report):
            return None
        name = f"{self.owner}.{node.name.text}" if self.owner else node.name.text
        other = self.symbols().declaration(name)
        if other is not None:
            scope.report_duplicate(
                "component or lasting condition", node.name, other.name.span, self.report
            )
            return None
        lasting = Lasting(name, condition, delay, span=node.name.span)
        self.types.values.lasting.append(lasting)
        return StateRef(name, HOLDING, span=node.name.span)

    def _bounded(self, condition: Expr, node: nodes.ConditionNode) -> Expr | None:
        """The condition; None after reporting that it is too large with those that it names."""
        if self._sizes.of(condition, self._size) <= limits.CONDITION_TERMS:
            return condition
        self.report.add(
            "too-deep",
            node.name.span,
            f"with the conditions that it names, '{node.name.text}' has more than"
            f" {limits.CONDITION_TERMS:,} terms",
            "name each condition once, or keep the result in a variable",
        )
        return None

    def _size(self, expr: Expr) -> int:
        operands: tuple[Expr, ...] = getattr(expr, "operands", ())
        return 1 + sum(self._sizes.of(operand, self._size) for operand in operands)

    def _parameter(self, node: nodes.ParameterNode, what: str) -> ParameterRef | None:
        key = f"{self.owner}.{node.name.text}" if self.owner else node.name.text
        place = node.name.span
        if node.value is None and node.name.text not in self.types.given:
            type_ = self.types.of_value(node.type)
            if type_ is None or not self._may_lack_value(node, type_, what):
                return None
            return ParameterRef(RosParameter(key, type_, example(type_), place, True), place)
        default = self._literal(node, what)
        if default is None:
            return None
        whole = completed(default.value, default.type)
        bounds = _bounds_of(node)
        if bounds is not None and not bounds[0] <= default.value <= bounds[1]:  # type: ignore[operator]
            message = f"{default.value} is outside the range of {what}"
            hint = f"it takes {bounds[0]} to {bounds[1]}"
            given = self.types.given.get(node.name.text)
            value = node.value if given is None else given.node
            span = node.span if value is None else value.span
            (self.report if given is None else given.report).add(
                "out-of-range", span, message, hint
            )
            return None
        parameter = RosParameter(key, default.type, whole, place, bounds=bounds)
        return ParameterRef(parameter, place)

    def _may_lack_value(self, node: nodes.ParameterNode, type_: Type, what: str) -> bool:
        if isinstance(type_, ArrayType | ObjectType):
            return self._is_possible(node, type_, what)
        message = f"{what} needs a value: only an array or an object can be left to the start"
        self.report.add("initial-not-constant", node.name.span, message, "add: = VALUE")
        return False

    def _literal(self, node: nodes.ConstantNode | nodes.ParameterNode, what: str) -> Literal | None:
        """The declared value, or the one that the import of the component sets instead."""
        type_ = self.types.of_value(node.type)
        if type_ is None or not self._is_possible(node, type_, what):
            return None
        given = self.types.given.get(node.name.text)
        if given is None:
            assert node.value is not None
            value = _constant(node.value, type_, what, self.types, self.report)
        else:
            value = _constant(given.node.value, type_, what, given.types, given.report)
        if value is None:
            return None
        literal = Literal(value, type_, node.name.span)
        if isinstance(node, nodes.ParameterNode):
            value_node, report = (
                (node.value, self.report) if given is None else (given.node.value, given.report)
            )
            assert value_node is not None
            if not _can_be_given(literal, what, value_node.span, report):
                return None
        return literal

    def _is_possible(
        self, node: nodes.ConstantNode | nodes.ParameterNode, type_: Type, what: str
    ) -> bool:
        if is_basic(type_) or isinstance(type_, EnumType | DurationType):
            return True
        if isinstance(type_, ArrayType | ObjectType):
            plain = all(is_basic(part) for _, part in innermost(type_))
            if plain or isinstance(node, nodes.ConstantNode):
                return True
            message = f"{what} cannot have the values of an enum, or nothing, in it"
            self.report.add("variable-type", node.type.span, message)
            return False
        self.report.add(
            "variable-type",
            node.type.span,
            f"{what} cannot be {describe(type_)}",
            "use string, boolean, integer, double, duration, an enum, an array or an object",
        )
        return False


def _can_be_given(default: Literal, what: str, span: source.Span, report: Report) -> bool:
    """Whether a parameter's default is in range; reports an error if not."""
    value = default.value
    if isinstance(default.type, DurationType):
        return is_long_enough(default, what, span, report)
    if type(value) is not int or settings.LEAST_PARAMETER <= value <= settings.MOST_PARAMETER:
        return True
    report.add(
        "out-of-range",
        span,
        f"{value} is outside the range of {what}",
        f"an integer that is a parameter in ROS takes {settings.LEAST_PARAMETER} to"
        f" {settings.MOST_PARAMETER}",
    )
    return False


def _constant(
    node: nodes.DataNode, type_: Type, what: str, types: TypeTable, report: Report
) -> Value | None:
    """The value of a constant expression; None after a reported error.

    The value of an object is a dict, that of an array a tuple.
    """
    kind = "constant" if what.startswith("constant") else "parameter"
    typer = Typer(report, types, None, no_value(f"a {kind} cannot depend on a received value"))
    data = DataTyper(typer, types, report).typed(node, type_, what)
    return None if data is None else _value(data, type_, what, node.span, report)


def _value(data: Data, type_: Type, what: str, span: source.Span, report: Report) -> Value | None:
    match data, type_:
        case DataObject(fields=fields), ObjectType():
            found: dict[str, Value | None] = {}
            for name, part in fields:
                inner = type_.property(name)
                assert inner is not None
                found[name] = _value(part, inner, what, span, report)
            return None if None in found.values() else cast(Value, found)
        case DataArray(elements=elements), ArrayType(element=element):
            parts = [_value(part, element, what, span, report) for part in elements]
            return None if None in parts else cast(Value, tuple(parts))
        case Aggregate(), ArrayType() if data.makes_array and (made := constant(data)) is not None:
            return _value(_as_data(made, type_, data.span or span), type_, what, span, report)
    assert not isinstance(data, DataObject | DataArray)
    value = constant(data)
    if value is None or value is values.NOW:
        message = f"the value of {what} must be a finite constant"
        report.add("initial-not-constant", data.span or span, message)
        return None
    if isinstance(value, int) and abs(value) > leaves.MAX_INTEGER:
        message = f"the value of {what} is too large: whole numbers go up to {leaves.MAX_INTEGER}"
        report.add("number-too-large", data.span or span, message)
        return None
    if isinstance(value, str) and len(value) > limits.TEXT_CONSTANT:
        message = f"the value of {what} has more than {limits.TEXT_CONSTANT:,} characters"
        report.add("out-of-range", data.span or span, message)
        return None
    literal = coerce(Literal(value, type_), type_)
    assert isinstance(literal, Literal)
    return literal.value


def _as_data(value: Any, type_: Type, span: source.Span) -> Data:
    """The value of a constant as data, whose parts are checked."""
    match type_:
        case ObjectType(properties=properties) if isinstance(value, dict):
            types = dict(properties)
            return DataObject(tuple((n, _as_data(v, types[n], span)) for n, v in value.items()))
        case ArrayType(element=element):
            return DataArray(tuple(_as_data(part, element, span) for part in value), span=span)
    return Literal(value, type_, span)


def _bounds_of(node: nodes.ParameterNode) -> tuple[float, float] | None:
    match node.type:
        case nodes.BasicTypeNode(name="double", bounds=(low, high)):
            return float(low), float(high)
    return None
