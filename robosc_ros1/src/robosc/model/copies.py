"""Expansion of indexed components, of ``for``, and of aggregates over components.

``component Station[1..6] { … }`` becomes six components ``Station[1]`` to ``Station[6]``, and
``for i in 1..6 { … }`` six copies of its statements. Aggregates over components,
``any(s.waiting for s in Station)``, are expanded, too. This is done on the syntax tree before names
are resolved; later stages have no indexes. The copies share nodes that do not depend on an index.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache, partial
from typing import Any, TypeVar, cast

from robosc.language.operators import BINARY, MIRRORED
from robosc.model.copies_scope import Scope, filled_in, is_alike, with_place
from robosc.model.diagnostics import Report
from robosc.model.quantified import Chains, at_least, joined
from robosc.source import Span
from robosc.syntax.nodes import (
    Access,
    AggregateNode,
    BinaryNode,
    CallNode,
    ComponentNode,
    ConditionNode,
    DeclarationNode,
    ElementNode,
    ExprNode,
    FileNode,
    ForNode,
    ImportNode,
    LiteralNode,
    MemberNode,
    Name,
    RangeNode,
    SliceNode,
    StringNode,
    UnaryNode,
)

__all__ = ["copy_name", "over_copies", "write_out"]

_Many = TypeVar("_Many", AggregateNode, BinaryNode)

MOST_COPIES = 10_000
"""More copies of one component, or of the statements of one ``for``, are an error."""


def copy_name(name: str, index: int) -> str:
    """The name of one copy of an indexed component: ``Station[3]``."""
    return f"{name}[{index}]"


def write_out(node: FileNode, report: Report) -> FileNode:
    """The file with indexed components and ``for`` expanded; the same file if it has none."""
    several = {
        item.name.text: item.indexes
        for item in node.declarations
        if isinstance(item, ComponentNode | ImportNode) and item.indexes is not None
    }
    if not several and not any(isinstance(item, ForNode) for item in node.declarations):
        return node
    writer = _Writer(several, report)
    declarations: list[DeclarationNode] = []
    for item in node.declarations:
        declarations += writer.declaration(item, Scope())
    return replace(
        node,
        declarations=tuple(declarations),
        written=node,
        mentions=tuple(writer.mentions),
    )


def over_copies(node: ExprNode, components: Iterable[str], report: Report) -> ExprNode:
    """A condition in which ``Station[3]`` and ``any(s.on for s in Station)`` are expanded.

    ``components`` are the names of all components, copies included.
    """
    found: dict[str, list[int]] = {}
    for component in components:
        name, bracket, index = component.partition("[")
        if bracket:
            found.setdefault(name, []).append(int(index.rstrip("]")))
    several = {
        name: RangeNode(min(indexes), max(indexes), span=node.span)
        for name, indexes in found.items()
    }
    written: ExprNode = _Writer(several, report).node(node, Scope())
    return written


class _Writer:
    """Expands declarations; ``mentions`` has the first copy's name for each aggregate."""

    def __init__(self, several: Mapping[str, RangeNode], report: Report) -> None:
        self._several = several
        self._report = report
        self._touched: dict[int, bool] = {}
        self._aggregates: dict[int, ExprNode] = {}
        self._elements: dict[tuple[int, str], ExprNode] = {}
        self._chains: dict[int, Chains] = {}
        self.mentions: list[Name] = []

    # --- declarations ---

    def declaration(self, item: DeclarationNode, scope: Scope) -> Iterable[DeclarationNode]:
        if isinstance(item, ForNode):
            return self._for(item, scope)
        if isinstance(item, ComponentNode | ImportNode) and item.indexes is not None:
            return self._component(item, item.indexes)
        return (self.node(item, scope),)

    def _indexes(self, node: RangeNode) -> range:
        if node.first > node.last:
            message = f"{node.first} is greater than {node.last}"
            self._report.add("empty-range", node.span, message, "write the smaller one first")
        elif node.last - node.first >= MOST_COPIES:
            message = f"this range has more than {MOST_COPIES:,} indexes"
            self._report.add("bad-index", node.span, message)
        else:
            return range(node.first, node.last + 1)
        return range(node.first, node.first + 1)

    def _component(
        self, item: ComponentNode | ImportNode, indexes: RangeNode
    ) -> list[DeclarationNode]:
        copies: list[DeclarationNode] = []
        for index in self._indexes(indexes):
            scope = Scope({"index": index})
            name = replace(item.name, text=copy_name(item.name.text, index))
            if isinstance(item, ComponentNode):
                items = tuple(self.node(part, scope) for part in item.items)
                copies.append(replace(item, name=name, items=items, indexes=None, index=index))
            else:
                prefix = self.node(item.prefix, scope) if item.prefix else None
                arguments = tuple(self.node(part, scope) for part in item.arguments)
                copies.append(
                    replace(item, name=name, prefix=prefix, arguments=arguments, indexes=None)
                )
        return copies

    def _for(self, node: ForNode, scope: Scope) -> list[DeclarationNode]:
        written: list[DeclarationNode] = []
        for index in self._indexes(node.indexes):
            inner = scope.number(node.variable.text, index)
            for statement in node.statements:
                if isinstance(statement, ConditionNode):
                    value = self.node(statement.value, inner)
                    inner = inner.condition(statement.name.text, value)
                    continue
                for copy in self.declaration(statement, inner):
                    written.append(with_place(copy, inner))
        return written

    # --- nodes of any kind ---

    def node(self, node: Any, scope: Scope) -> Any:
        """The expanded node; the same object if nothing in it depends on the scope."""
        if isinstance(node, tuple):
            parts = tuple(self.node(part, scope) for part in node)
            return parts if any(a is not b for a, b in zip(parts, node, strict=True)) else node
        if (
            not is_dataclass(node)
            or isinstance(node, Span | Name)
            or not self._depends(node, scope)
        ):
            return node
        match node:
            case StringNode(text=text):
                return replace(node, text=filled_in(text, scope))
            case LiteralNode(value=str() as text):
                return replace(node, value=filled_in(text, scope))
            case Access():
                return self._access(node, scope)
            case MemberNode(object=ElementNode(array=Access(path=()) as array, index=index)) if (
                self._is_several(array, scope)
            ):
                return self._member(array, index, node, scope)
            case BinaryNode(left=AggregateNode() as many, operator=operator, right=right) if (
                operator in MIRRORED and many.function.text == "count"
            ):
                return self._once(node, scope, partial(self._count, many, operator, right))
            case BinaryNode(left=left, operator=operator, right=AggregateNode() as many) if (
                operator in MIRRORED and many.function.text == "count"
            ):
                return self._once(node, scope, partial(self._count, many, MIRRORED[operator], left))
            case AggregateNode():
                return self._once(node, scope, self._over_components)
        return self._parts(node, scope)

    def _parts(self, node: Any, scope: Scope) -> Any:
        changes = {}
        for name in _parts_of(cast(Hashable, type(node))):
            part = getattr(node, name)
            copy = self._named(part, scope) if name in _NAMING else self.node(part, scope)
            if copy is not part:
                changes[name] = copy
        return replace(node, **changes) if changes else node

    def _named(self, part: Any, scope: Scope) -> Any:
        """A name of a communication, variable or function: never an index or a condition."""
        if isinstance(part, tuple):
            parts = tuple(self._named(one, scope) for one in part)
            return parts if any(a is not b for a, b in zip(parts, part, strict=True)) else part
        copy = self.node(part, scope)
        return copy if isinstance(copy, Access) else part

    def _depends(self, node: Any, scope: Scope) -> bool:
        """Whether anything in a node depends on an index, or names an indexed component."""
        if scope.components or scope.conditions:
            return True
        found = self._touched.get(id(node))
        if found is None:
            text = node.span.text
            names = {*self._several, *scope.numbers}
            words = {word.lstrip("^") for word in re.findall(r"\^?[A-Za-z_]\w*", text)}
            found = self._touched[id(node)] = not words.isdisjoint(names)
        return found

    def _is_several(self, access: Access, scope: Scope) -> bool:
        return access.root.text in self._several and access.root.text not in scope.components

    # --- names ---

    def _access(self, node: Access, scope: Scope) -> ExprNode:
        name = node.root.text
        if name in scope.components:
            return replace(node, root=replace(node.root, text=scope.components[name]))
        if name in scope.conditions and not node.path:
            return scope.conditions[name]
        if name in scope.numbers and not node.path and node.index is None:
            return LiteralNode(scope.numbers[name], span=node.span)
        if name not in self._several:
            return node
        if node.index is not None:
            return self._one(node, self._constant(node.index, scope), node.path)
        if node.path and isinstance(node.path[0], int):
            return self._one(node, node.path[0], node.path[1:])
        indexes = self._several[name]
        hint = f"write {copy_name(name, indexes.first)}, or any(c.… for c in {name})"
        message = f"{name} is an indexed component: {name}[{indexes.first}..{indexes.last}]"
        self._report.add("bad-index", node.root.span, message, hint)
        return self._one(node, indexes.first, node.path)

    def _one(self, node: Access, index: int | None, path: tuple[Name | int, ...]) -> Access:
        """The access with the copy of an index as its root; the first copy after an error."""
        name = node.root.text
        indexes = self._several[name]
        if index is None:
            index = indexes.first
        elif not indexes.first <= index <= indexes.last:
            hint = f"the indexes are {indexes.first}..{indexes.last}"
            self._report.add("bad-index", node.span, f"there is no {copy_name(name, index)}", hint)
            index = indexes.first
        root = replace(node.root, text=copy_name(name, index))
        return Access(root, path, span=node.span)

    def _member(self, array: Access, index: ExprNode, node: MemberNode, scope: Scope) -> Access:
        found = self._constant(index, scope)
        return self._one(replace(array, span=node.span), found, node.path)

    def _constant(self, node: ExprNode, scope: Scope) -> int | None:
        """The value of an index; None after an error."""
        value = _value(self.node(node, scope))
        if value is None:
            names = ", ".join(scope.numbers) or "numbers"
            self._report.add(
                "bad-index",
                node.span,
                "the index of a component must be a whole number known when the model is read",
                f"it can be computed from {names}",
            )
        return value

    # --- aggregates over components ---

    def _members(self, node: AggregateNode, scope: Scope) -> list[str] | None:
        """The components over which an aggregate ranges; None if it ranges over data."""
        array = node.array
        base = array.array if isinstance(array, SliceNode) else array
        if not isinstance(base, Access) or base.path or not self._is_several(base, scope):
            return None
        name = base.root.text
        first, last = self._several[name].first, self._several[name].last
        self.mentions.append(replace(base.root, text=copy_name(name, first)))
        if isinstance(array, SliceNode):
            low, high = self._constant(array.first, scope), self._constant(array.last, scope)
            for index, place in ((low, array.first), (high, array.last)):
                if index is not None and not first <= index <= last:
                    hint = f"the indexes are {first}..{last}"
                    message = f"there is no {copy_name(name, index)}"
                    self._report.add("bad-index", place.span, message, hint)
            first, last = max(first, low or first), min(last, high or last)
        return [copy_name(name, index) for index in range(first, last + 1)]

    def _once(
        self, node: _Many, scope: Scope, written: Callable[[_Many, Scope], ExprNode]
    ) -> ExprNode:
        """The expanded node, shared by all copies if it does not depend on their index."""
        if scope.components or not is_alike(node, scope):
            return written(node, scope)
        if id(node) not in self._aggregates:
            self._aggregates[id(node)] = written(node, scope)
        return self._aggregates[id(node)]

    def _over_components(self, node: AggregateNode, scope: Scope) -> ExprNode:
        members = self._members(node, scope)
        if members is None:
            parts: ExprNode = self._parts(node, scope)
            return parts
        function = node.function.text
        own = [part for part in (node.element, node.condition) if part is not None]
        if not scope.components and all(is_alike(part, scope) for part in own):
            elements = [self._known_element(node, member, scope) for member in members]
            known = self._chains.setdefault(id(node), {})
        else:
            elements, known = [self._element(node, member, scope) for member in members], None
        if function == "any":
            return joined("or", elements, node.span, False, known)
        if function == "all":
            return joined("and", elements, node.span, True, known)
        if function in ("sum", "min", "max") and node.condition is None:
            if function == "sum":
                return joined("+", elements, node.span, empty=0)
            return CallNode(
                Access(node.function, (), span=node.function.span), tuple(elements), span=node.span
            )
        hint = "compare count(…) with a number" if function == "count" else "leave out the 'if'"
        message = f"'{function}' over components is not allowed here"
        self._report.add("not-over-components", node.span, message, hint)
        return LiteralNode(0, span=node.span)

    def _known_element(self, node: AggregateNode, component: str, scope: Scope) -> ExprNode:
        """The element for one component, shared by all copies."""
        key = id(node), component
        if key not in self._elements:
            self._elements[key] = self._element(node, component, scope)
        return self._elements[key]

    def _element(self, node: AggregateNode, component: str, scope: Scope) -> ExprNode:
        """The element of an aggregate for one component, its condition included."""
        inner = scope.component(node.variable.text, component)
        element: ExprNode = self.node(node.element, inner)
        if node.condition is None:
            return element
        condition: ExprNode = self.node(node.condition, inner)
        operator = "=>" if node.function.text == "all" else "and"
        return BinaryNode(operator, condition, element, operator_span=node.span, span=node.span)

    def _count(
        self, many: AggregateNode, operator: str, bound: ExprNode, node: BinaryNode, scope: Scope
    ) -> ExprNode:
        """The expanded comparison of a count with a number."""
        members = self._members(many, scope)
        number = _value(self.node(bound, scope))
        if members is None:
            parts: ExprNode = self._parts(node, scope)
            return parts
        if number is None:
            message = "the number of components can only be compared with a whole number"
            self._report.add("not-over-components", bound.span, message)
            number = 0
        elements = [self._element(many, member, scope) for member in members]
        written = at_least(operator, elements, number, many.span)
        if written is None:
            message = "this count has too many cases to be expanded"
            hint = "compare it with a smaller number, or count fewer components"
            self._report.add("not-over-components", many.span, message, hint)
            return LiteralNode(True, span=node.span)
        return written


def _value(node: Any) -> int | None:
    """The value of an expression over whole numbers; None for any other expression."""
    match node:
        case LiteralNode(value=int() as value) if not isinstance(value, bool):
            return value
        case UnaryNode(operator="-", operand=operand):
            inner = _value(operand)
            return None if inner is None else -inner
        case BinaryNode(operator=operator) if BINARY[operator].keeps_integers:
            numbers = _value(node.left), _value(node.right)
            if None in numbers or (operator == "%" and numbers[1] == 0):
                return None
            return int(BINARY[operator].scalar(*numbers))
    return None


_NAMING = frozenset({"communication", "communications", "function", "over", "preferred", "target"})
"""Fields of nodes that contain names of communications, variables and functions."""


@cache
def _parts_of(kind: Hashable) -> tuple[str, ...]:
    """The fields of a kind of node that may contain nodes."""
    return tuple(f.name for f in fields(cast(Any, kind)) if f.compare)
