"""Functions that a model declares: a call is the body, typed with the arguments in it.

So later stages have no calls of them. The body is checked once where it is declared; in a call it
is typed anew, because whether a part of it can be undefined depends on the arguments.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

from robosc import limits
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import walk
from robosc.expr.tree import ElementRef, Expr, PhaseRef, StateRef, VariableRef
from robosc.expr.types import Type
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Muted, Report
from robosc.model.names.scope import report_duplicate
from robosc.model.typing import compatibility, expected, expressions, value_word
from robosc.model.typing.data import DataTyper, as_expression
from robosc.syntax import nodes

_ONLY = "a function reads its arguments, constants and parameters only"


@dataclass
class FunctionTyper:
    """Types the functions of a file or a component; see :class:`ValueScope`."""

    types: TypeTable
    report: Report
    _arguments: dict[int, tuple[Type, ...] | None] = field(default_factory=dict)
    _open: list[nodes.FunctionNode] = field(default_factory=list)
    _level: int = 0
    _sizes: IdentityCache[int] = field(default_factory=IdentityCache)

    def arguments(self, node: nodes.FunctionNode) -> tuple[Type, ...] | None:
        """The types of the arguments; None if the declaration has an error.

        Its errors are reported when they are asked for the first time.
        """
        if id(node) in self._arguments:
            return self._arguments[id(node)]
        if node in self._open:
            self.report.add(
                "initial-not-constant", node.name.span, f"function '{node.name.text}' calls itself"
            )
            return None
        self._open.append(node)
        self._arguments[id(node)] = self._checked(node)
        self._open.remove(node)
        return self._arguments[id(node)]

    def _checked(self, node: nodes.FunctionNode) -> tuple[Type, ...] | None:
        names = [parameter.name for parameter in node.parameters]
        first: dict[str, nodes.Name] = {}
        for name in names:
            if first.setdefault(name.text, name) is not name:
                report_duplicate("argument", name, first[name.text].span, self.report)
                return None
        types = [self.types.of_value(parameter.type) for parameter in node.parameters]
        known = [type_ for type_ in types if type_ is not None]
        if len(known) < len(types):
            return None
        given = [
            ElementRef(name.text, (), type_, name.span)
            for name, type_ in zip(names, known, strict=True)
        ]
        found = self._typed(node, given, self.report)
        if found is None:
            return None
        for part in walk(found):
            if isinstance(part, VariableRef | StateRef | PhaseRef):
                span = part.span or node.name.span
                message = f"{_ONLY}, and this depends on the state"
                self.report.add("unknown-name", span, message, "make it an argument")
                return None
        return tuple(known)

    def call(self, node: nodes.FunctionNode, arguments: Sequence[Expr]) -> Expr | None:
        """The value of a sound function for these arguments; None where it has none."""
        outside = {p.variable for a in arguments for p in walk(a) if isinstance(p, ElementRef)}
        return self._typed(replace(node, value=_apart(node.value, outside)), arguments, Muted())

    def _typed(
        self, node: nodes.FunctionNode, arguments: Sequence[Expr], report: Report
    ) -> Expr | None:
        result = self.types.of_value(node.type)
        if result is None:
            return None
        if self._level >= limits.CALLS_IN_CALLS:
            message = f"functions call functions more than {limits.CALLS_IN_CALLS} levels deep"
            self.report.add("too-deep", node.name.span, message)
            return None
        given = dict(zip((p.name.text for p in node.parameters), arguments, strict=True))
        types = self.types.reporting_to(report)
        typer = expressions.Typer(report, types, None, value_word.no_value(_ONLY), given)
        self._level += 1
        place = f"function '{node.name.text}'"
        found: Expr | None = None
        if isinstance(node.value, nodes.DataObjectNode | nodes.ArrayNode):
            data = DataTyper(typer, types, report).typed(node.value, result, place)
            found = None if data is None else as_expression(data, result)
        else:
            found = typer.check(node.value, expected.expected_type(result), place)
        self._level -= 1
        if found is None or self._sizes.of(found, self._size) <= limits.CALL_TERMS:
            return None if found is None else compatibility.coerce(found, result)
        message = f"'{node.name.text}' has more than {limits.CALL_TERMS:,} terms with what it calls"
        self.report.add("too-deep", node.name.span, message, "keep a part in a variable")
        return None

    def _size(self, expr: Expr) -> int:
        operands: tuple[Expr, ...] = getattr(expr, "operands", ())
        return 1 + sum(self._sizes.of(operand, self._size) for operand in operands)


def _apart(body: nodes.DataNode, outside: Set[str]) -> nodes.DataNode:
    """The body with other names for its aggregates' variables that have one of those outside."""
    inside = {name for node in _aggregates(body) for name in _bound(node)} if outside else set()
    names = {name: f"{name}_" for name in inside & outside}
    while clashes := {name for name, other in names.items() if other in inside | outside}:
        names |= {name: f"{names[name]}_" for name in clashes}
    found: nodes.DataNode = _renamed(body, names) if names else body
    return found


def _aggregates(node: Any) -> Iterator[nodes.AggregateNode]:
    if isinstance(node, nodes.AggregateNode):
        yield node
    for part in node if isinstance(node, tuple) else _parts(node).values():
        yield from _aggregates(part)


def _bound(node: nodes.AggregateNode) -> Iterator[str]:
    """The names that an aggregate gives to positions and elements."""
    yield from (name.text for name in (node.position, node.variable) if name is not None)


def _renamed(node: Any, names: dict[str, str]) -> Any:
    if isinstance(node, tuple):
        return tuple(_renamed(part, names) for part in node)
    changes = {name: _renamed(part, names) for name, part in _parts(node).items()}
    for named in {nodes.Access: ("root",), nodes.AggregateNode: ("position", "variable")}.get(
        type(node), ()
    ):
        if (name := getattr(node, named)) is not None:
            changes[named] = replace(name, text=names.get(name.text, name.text))
    return replace(node, **changes) if changes else node


def _parts(node: Any) -> dict[str, Any]:
    """The fields of a node that may contain nodes; none of anything else."""
    if not is_dataclass(node):
        return {}
    return {f.name: getattr(node, f.name) for f in fields(node) if f.compare}
