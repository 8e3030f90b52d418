"""Scopes of constants, parameters and named conditions: those of a file and of a component."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from robosc.expr import tree, types
from robosc.language.functions import AGGREGATES, FUNCTIONS, GEOMETRY
from robosc.model.automata import Lasting
from robosc.model.diagnostics import Report
from robosc.model.names.scope import FileScope, report_duplicate
from robosc.syntax.nodes import ConditionNode, ConstantNode, FunctionNode, ParameterNode, ValueNode

LANGUAGE_FUNCTIONS = frozenset({*FUNCTIONS, *AGGREGATES, *GEOMETRY, "now"})


class Functions(Protocol):
    """What a scope asks of :class:`robosc.model.typing.declared_functions.FunctionTyper`."""

    def arguments(self, node: FunctionNode) -> tuple[types.Type, ...] | None: ...
    def call(self, node: FunctionNode, arguments: Sequence[tree.Expr]) -> tree.Expr | None: ...


@dataclass
class ValueScope:
    """The named values of a component (``owner``) or a file, within the scope ``outer``.

    ``typed`` returns the meaning of a declaration; it is called once for each. ``typer`` types the
    ``functions`` that are declared here.
    """

    owner: str = ""
    outer: ValueScope | None = None
    typed: Callable[[ValueNode], tree.Expr | None] = lambda node: None
    typer: Functions | None = None
    functions: dict[str, FunctionNode] = field(default_factory=dict)
    lasting: list[Lasting] = field(default_factory=list)
    """The conditions of this scope that must have held for some time, as they are typed."""
    _nodes: dict[str, ValueNode] = field(default_factory=dict)
    _meanings: dict[int, tree.Expr | None] = field(default_factory=dict)

    def declare(self, items: Iterable[object], scope: FileScope, report: Report) -> None:
        """Add the declarations of named values among the items of a file or a component."""
        for item in items:
            if isinstance(item, FunctionNode):
                self._declare_function(item, scope, report)
            if not isinstance(item, ConstantNode | ParameterNode | ConditionNode):
                continue
            scope.names.declare(item, self.owner)
            first = self._nodes.setdefault(item.name.text, item)
            if first is not item:
                report_duplicate(
                    "constant, parameter or condition", item.name, first.name.span, report
                )

    def _declare_function(self, node: FunctionNode, scope: FileScope, report: Report) -> None:
        scope.names.declare(node, self.owner)
        name = node.name.text
        if name in LANGUAGE_FUNCTIONS:
            message = f"'{name}' is a function of the language"
            report.add("duplicate-name", node.name.span, message, "give it another name")
            return
        first = self.functions.get(name) or scope.datatypes.get(name)
        if first is not None:
            report_duplicate("function or datatype", node.name, first.name.span, report)
            return
        self.functions[name] = node

    def function(self, name: str) -> tuple[FunctionNode, ValueScope] | None:
        """The function of a bare name in this scope or ``outer``, and the scope that has it."""
        if name in self.functions:
            return self.functions[name], self
        return None if self.outer is None else self.outer.function(name)

    def resolve(self) -> None:
        """Type all declarations, so that errors in unused ones are reported, too."""
        for node in self._nodes.values():
            self._meaning(node)
        for function in self.functions.values():
            if self.typer is not None:
                self.typer.arguments(function)

    @property
    def declared(self) -> Iterable[str]:
        """The names that are declared in this scope, without ``outer``."""
        return self._nodes

    @property
    def nodes(self) -> Iterable[ValueNode]:
        """The declarations in this scope, without ``outer``."""
        return self._nodes.values()

    def node(self, name: str) -> ValueNode | None:
        """The declaration of a name in this scope, without ``outer``."""
        return self._nodes.get(name)

    @property
    def settable(self) -> list[str]:
        """The names of constants and parameters, which an import may set."""
        return [
            name
            for name, node in self._nodes.items()
            if isinstance(node, ConstantNode | ParameterNode)
        ]

    @property
    def parameters(self) -> Iterator[tree.RosParameter]:
        """The parameters that are declared in this scope."""
        for node in self._nodes.values():
            meaning = self._meaning(node)
            if isinstance(node, ParameterNode) and isinstance(meaning, tree.ParameterRef):
                yield meaning.parameter

    def own(self, name: str) -> tuple[ValueNode, tree.Expr | None] | None:
        """Declaration and meaning of a name in this scope; meaning None after an error."""
        node = self._nodes.get(name)
        return None if node is None else (node, self._meaning(node))

    def find(self, name: str) -> tuple[ValueNode, tree.Expr | None, str] | None:
        """Declaration, meaning and owner of a bare name in this scope or ``outer``."""
        found = self.own(name)
        if found is not None:
            return (*found, self.owner)
        return None if self.outer is None else self.outer.find(name)

    @property
    def names(self) -> list[str]:
        """The names that are declared in this scope and in ``outer``."""
        return [*self._nodes, *(self.outer.names if self.outer is not None else ())]

    def _meaning(self, node: ValueNode) -> tree.Expr | None:
        if id(node) not in self._meanings:
            self._meanings[id(node)] = self.typed(node)
        return self._meanings[id(node)]
