"""Constants, parameters and named conditions of a file or a component."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from robosc.model.datatypes import TypeTable
from robosc.model.evaluation import constant
from robosc.model.expected import BOOLEAN, expected_type
from robosc.model.expr import Expr, Literal
from robosc.model.expressions import Typer, no_value
from robosc.model.report import Report
from robosc.model.tables import SymbolTable
from robosc.model.types import EnumType, Type
from robosc.model.values import check_range, coerce, describe, is_basic
from robosc.syntax.nodes import ConditionNode, ConstantNode, DataObjectNode, ValueNode

__all__ = ["NamedValueTyper"]


@dataclass
class NamedValueTyper:
    """Types the values that a file or a component names, each when it is first asked for.

    What they mean stands in the place of their names from then on: later stages know no names.
    """

    types: TypeTable
    report: Report
    symbols: Callable[[], SymbolTable]
    _open: list[str] = field(default_factory=list)

    def __call__(self, node: ValueNode) -> Expr | None:
        """The meaning of the name that a node declares; None after a reported error."""
        name = node.name.text
        if name in self._open:
            self.report.add("initial-not-constant", node.name.span, f"'{name}' is told by itself")
            return None
        self._open.append(name)
        try:
            if isinstance(node, ConditionNode):
                reason = "a named condition is about the state, not about what comes in"
                typer = Typer(self.report, self.types, self.symbols(), no_value(reason))
                return typer.check(node.value, BOOLEAN, f"condition '{name}'")
            assert isinstance(node, ConstantNode)
            return self._constant(node)
        finally:
            self._open.remove(name)

    def _constant(self, node: ConstantNode) -> Expr | None:
        type_ = self.types.resolve(node.type)
        if type_ is None or not self._is_possible(node, type_):
            return None
        assert not isinstance(node.value, DataObjectNode)
        what = f"constant '{node.name.text}'"
        reason = "a constant cannot depend on what comes in"
        typer = Typer(self.report, self.types, None, no_value(reason))
        expr = typer.check(node.value, expected_type(type_), what)
        if expr is None:
            return None
        value = constant(expr)
        if value is None:
            message = f"the value of {what} must be a finite constant"
            self.report.add("initial-not-constant", node.value.span, message)
            return None
        check_range(expr, type_, what, self.report)
        return coerce(Literal(value, type_, node.name.span), type_)

    def _is_possible(self, node: ConstantNode, type_: Type) -> bool:
        if is_basic(type_) or isinstance(type_, EnumType):
            return not isinstance(node.value, DataObjectNode)
        self.report.add(
            "variable-type",
            node.type.span,
            f"constant '{node.name.text}' cannot be {describe(type_)}",
            "use string, boolean, integer, double or an enum",
        )
        return False
