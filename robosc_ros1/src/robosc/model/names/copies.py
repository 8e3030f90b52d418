"""Expansion of indexed components, of ``for``, and of aggregates over components.

``component Station[1..6] { … }`` becomes six components ``Station[1]`` to ``Station[6]``, and
``for i in 1..6 { … }`` six copies of its statements. An aggregate over components,
``any(s.waiting for s in Station)``, becomes one over the list of what it asks of each of them. This
is done on the syntax tree before names are resolved; later stages have no indexes. The copies share
the nodes whose names mean the same in them.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Mapping, Set
from dataclasses import field, fields, is_dataclass, replace
from functools import cache
from operator import is_
from typing import Any, cast

from robosc import limits, source
from robosc.language import functions, operators
from robosc.lazy_dataclasses import dataclass
from robosc.model.diagnostics import Report
from robosc.names import Copy, copy_name
from robosc.syntax import nodes

# The meaning of names in one copy of a component, or of the statements of a ``for``.


_PLACEHOLDER = re.compile(r"\{([A-Za-z_]\w*)\}", re.ASCII)


@dataclass(frozen=True)
class Scope:
    """The meanings of names in the copy that is being made.

    ``index`` and the variables of ``for`` are numbers, the variables of aggregates over components
    the names of components, and the conditions declared in a ``for`` expressions. ``own`` is the
    copy of a component that is being made: the bare name ``family`` means it.
    """

    names: Mapping[str, int | str | nodes.ExprNode] = field(default_factory=dict)
    own: Copy | None = None

    @property
    def family(self) -> str:
        return "" if self.own is None else self.own.family

    def inside(self, name: str, meaning: int | str | nodes.ExprNode) -> Scope:
        """The scope with one more name, which hides an outer one."""
        return replace(self, names={**self.names, name: meaning})

    @property
    def numbers(self) -> dict[str, int]:
        return {name: number for name, number in self.names.items() if isinstance(number, int)}

    def meanings(self, words: Set[str]) -> tuple[tuple[str, int | str], ...]:
        """What tells two scopes apart for a text of these words; of an expression its identity."""
        found = tuple(
            (name, meaning if isinstance(meaning, int | str) else f"condition {id(meaning)}")
            for name, meaning in self.names.items()
            if name in words
        )
        own = () if self.own is None or self.family not in words else (("", self.own.name),)
        return *found, *own

    def filled_in(self, text: str) -> str:
        """A string with its placeholders ``{index}`` and ``{i}`` replaced."""
        numbers = self.numbers
        return _PLACEHOLDER.sub(lambda match: str(numbers.get(match[1], match[0])), text)


def repeated(statement: Any, scope: Scope, block: source.Span) -> Any:
    """A statement that is one of the copies of those in a block, if its kind tells that."""
    if not hasattr(statement, "repeated") or statement.repeated is not None:
        return statement
    return replace(statement, repeated=nodes.Repeated(tuple(scope.numbers.items()), block))


def indexes_of(node: nodes.RangeNode, report: Report) -> range:
    """The indexes of a range; only the first one after a reported error."""
    if node.first > node.last:
        message = f"{node.first} is greater than {node.last}"
        report.add("empty-range", node.span, message, "write the smaller one first")
    elif node.last - node.first >= limits.COPIES:
        message = f"this range has more than {limits.COPIES:,} indexes"
        report.add("bad-index", node.span, message)
    else:
        return range(node.first, node.last + 1)
    return range(node.first, node.first + 1)


def indexes_of_for(node: nodes.ForNode, scope: Scope, report: Report) -> range:
    """The indexes of a ``for``, with the statements of all that are in it taken into account."""
    indexes = indexes_of(node.indexes, report)
    if len(indexes) == 1 or _statements_from(node) <= limits.STATEMENTS:
        return indexes
    if not scope.numbers:  # reported once, for the outermost
        message = f"this makes more than {limits.STATEMENTS:,} statements"
        report.add("bad-index", node.indexes.span, message)
    return indexes[:1]


def _statements_from(node: nodes.ForNode) -> int:
    """How many statements a ``for`` stands for, if all its ranges have a permitted length."""
    length = min(max(0, node.indexes.last - node.indexes.first + 1), limits.COPIES)
    each = (_statements_from(s) if isinstance(s, nodes.ForNode) else 1 for s in node.statements)
    return length * max(1, sum(each))  # an empty one is visited, too


def write_out(node: nodes.FileNode, report: Report) -> nodes.FileNode:
    """The file with indexed components, ``for`` and groups of requirements expanded; the same file
    if it has none."""
    several = {
        item.name.text: item.indexes
        for item in node.declarations
        if isinstance(item, nodes.ComponentNode | nodes.ImportNode) and item.indexes is not None
    }
    single = _ungrouped(node.declarations)
    repeats = several or any(isinstance(item, nodes.ForNode) for item in node.declarations)
    if not repeats:
        return (
            node
            if single is node.declarations
            else replace(node, declarations=single, written=node)
        )
    writer = _Writer(several, report)
    declarations: list[nodes.DeclarationNode] = []
    for item in single:
        declarations += writer.declaration(item, Scope())
    return replace(
        node,
        declarations=tuple(declarations),
        written=node,
        mentions=tuple(writer.mentions),
    )


def _ungrouped(items: tuple[Any, ...]) -> tuple[Any, ...]:
    """Declarations with the members of groups of requirements in their places."""
    found: list[Any] = []
    for item in items:
        if isinstance(item, nodes.RequirementsNode):
            found += item.statements
        elif isinstance(item, nodes.ComponentNode):
            inside = _ungrouped(item.items)
            found.append(item if inside is item.items else replace(item, items=inside))
        elif isinstance(item, nodes.ForNode):
            statements = _ungrouped(item.statements)
            changed = statements is not item.statements
            found.append(replace(item, statements=statements) if changed else item)
        else:
            found.append(item)
    same = len(found) == len(items) and all(a is b for a, b in zip(found, items, strict=True))
    return items if same else tuple(found)


def over_copies(node: nodes.ExprNode, copies: Iterable[Copy], report: Report) -> nodes.ExprNode:
    """A condition in which ``Station[3]`` and ``any(s.on for s in Station)`` are expanded.

    ``copies`` are those of all indexed components.
    """
    indexes: dict[str, list[int]] = {}
    for copy in copies:
        indexes.setdefault(copy.family, []).append(copy.index)
    several = {
        family: nodes.RangeNode(min(of_family), max(of_family), span=node.span)
        for family, of_family in indexes.items()
    }
    written: nodes.ExprNode = _Writer(several, report).node(node, Scope())
    return written


class _Writer:
    """Expands declarations; ``mentions`` has the first copy's name for each aggregate."""

    def __init__(self, several: Mapping[str, nodes.RangeNode], report: Report) -> None:
        self._several = several
        self._report = report
        # All by the identities of nodes; ``_written`` also by the meanings of the names in them.
        self._words: dict[int, frozenset[str]] = {}
        self._written: dict[tuple[int, Hashable], Any] = {}
        self._asked: dict[int, nodes.ExprNode] = {}
        self.mentions: list[nodes.Name] = []

    # --- declarations ---

    def declaration(
        self, item: nodes.DeclarationNode, scope: Scope
    ) -> Iterable[nodes.DeclarationNode]:
        if isinstance(item, nodes.ForNode):
            return self._for(item, scope)
        if isinstance(item, nodes.ComponentNode | nodes.ImportNode) and item.indexes is not None:
            return self._component(item, item.indexes)
        return (self.node(item, scope),)

    def _component(
        self, item: nodes.ComponentNode | nodes.ImportNode, indexes: nodes.RangeNode
    ) -> list[nodes.DeclarationNode]:
        copies: list[nodes.DeclarationNode] = []
        for index in indexes_of(indexes, self._report):
            copy = Copy(item.name.text, index)
            name = replace(item.name, text=copy.name)
            scope = Scope(own=copy).inside("index", index)
            if isinstance(item, nodes.ComponentNode):
                parts = (self.node(part, scope) for part in item.items)
                items = tuple(repeated(part, scope, item.span) for part in parts)
                copies.append(replace(item, name=name, items=items, indexes=None, copy=copy))
            else:
                prefix = self.node(item.prefix, scope) if item.prefix else None
                arguments = tuple(self.node(part, scope) for part in item.arguments)
                changed = replace(item, name=name, prefix=prefix, arguments=arguments)
                copies.append(replace(changed, indexes=None, copy=copy))
        return copies

    def _for(self, node: nodes.ForNode, scope: Scope) -> list[nodes.DeclarationNode]:
        written: list[nodes.DeclarationNode] = []
        for index in indexes_of_for(node, scope, self._report):
            inner = scope.inside(node.variable.text, index)
            for statement in node.statements:
                if isinstance(statement, nodes.ConditionNode):
                    if statement.duration is not None:
                        self._report.add(
                            "misplaced",
                            statement.duration.span,
                            "a condition in a 'for' statement cannot have to last",
                            "declare the condition in a component",
                        )
                    value = self.node(statement.value, inner)
                    inner = inner.inside(statement.name.text, value)
                    continue
                for copy in self.declaration(statement, inner):
                    written.append(repeated(copy, inner, node.span))
        return written

    # --- nodes of any kind ---

    def node(self, node: Any, scope: Scope) -> Any:
        """The expanded node; one object for all scopes in which its names mean the same."""
        if isinstance(node, tuple):
            parts = tuple(self.node(part, scope) for part in node)
            return parts if any(a is not b for a, b in zip(parts, node, strict=True)) else node
        if not is_dataclass(node) or isinstance(node, source.Span | nodes.Name):
            return node
        words = self._words_of(node)
        meanings = scope.meanings(words)
        if not meanings and words.isdisjoint(self._several):
            return node
        key = id(node), meanings
        if key not in self._written:
            self._written[key] = self._expanded(node, scope)
        return self._written[key]

    def _words_of(self, node: Any) -> frozenset[str]:
        if id(node) not in self._words:
            words = re.findall(r"[A-Za-z_]\w*", node.span.text)
            self._words[id(node)] = frozenset(words)
        return self._words[id(node)]

    def _expanded(self, node: Any, scope: Scope) -> Any:
        match node:
            case nodes.StringNode(text=text):
                return replace(node, text=scope.filled_in(text))
            case nodes.LiteralNode(value=str() as text):
                return replace(node, value=scope.filled_in(text))
            case nodes.Access():
                return self._access(node, scope)
            case nodes.MemberNode(
                object=nodes.ElementNode(array=nodes.Access(path=()) as array, index=index)
            ) if self._is_several(array, scope):
                found = self._constant(index, scope)
                return self._one(replace(array, span=node.span), found, node.path)
            case nodes.AggregateNode():
                members = self._members(node, scope)
                if members is not None:
                    return self._over_components(node, members, scope)
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
            parts = tuple(one for each in part for one in self._each(each, scope))
            same = len(parts) == len(part) and all(map(is_, parts, part))
            return part if same else parts
        copy = self.node(part, scope)
        kept = nodes.Access | nodes.ExceptNode | nodes.StringNode
        return copy if isinstance(copy, kept) else part

    def _each(self, part: Any, scope: Scope) -> Iterable[Any]:
        """A named part; all copies where an indexed component is named as a whole."""
        whole = isinstance(part, nodes.Access) and not part.path and part.index is None
        if not whole or not self._is_several(part, scope) or part.root.text == scope.family:
            return (self._named(part, scope),)
        indexes = self._several[part.root.text]
        return [self._one(part, i, ()) for i in range(indexes.first, indexes.last + 1)]

    def _is_several(self, access: nodes.Access, scope: Scope) -> bool:
        name = access.root.text
        return name in self._several and not isinstance(scope.names.get(name), str)

    # --- names ---

    def _access(self, node: nodes.Access, scope: Scope) -> nodes.ExprNode:
        name = node.root.text
        match scope.names.get(name):
            case str(component):
                return replace(node, root=replace(node.root, text=component))
            case int(number) if not node.path and node.index is None:
                return nodes.LiteralNode(number, span=node.span)
            case None | int():
                pass
            case condition if not node.path:
                return condition
        if name not in self._several:
            return node
        if node.index is not None:
            return self._one(node, self._constant(node.index, scope), node.path)
        if node.path and isinstance(node.path[0], int):
            return self._one(node, node.path[0], node.path[1:])
        if scope.own is not None and name == scope.own.family:
            return replace(node, root=replace(node.root, text=scope.own.name))
        indexes = self._several[name]
        hint = f"write {copy_name(name, indexes.first)}, or any(c.… for c in {name})"
        message = f"{name} is an indexed component: {name}[{indexes.first}..{indexes.last}]"
        self._report.add("bad-index", node.root.span, message, hint)
        return self._one(node, indexes.first, node.path)

    def _one(
        self, node: nodes.Access, index: int | None, path: tuple[nodes.Name | int, ...]
    ) -> nodes.Access:
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
        return nodes.Access(root, path, span=node.span)

    def _constant(self, node: nodes.ExprNode, scope: Scope) -> int | None:
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

    def _members(self, node: nodes.AggregateNode, scope: Scope) -> list[str] | None:
        """The components over which an aggregate ranges; None if it ranges over data."""
        array = node.array
        base = array.array if isinstance(array, nodes.SliceNode) else array
        if not isinstance(base, nodes.Access) or base.path or not self._is_several(base, scope):
            return None
        name = base.root.text
        first, last = self._several[name].first, self._several[name].last
        self.mentions.append(replace(base.root, text=copy_name(name, first)))
        if isinstance(array, nodes.SliceNode):
            low, high = self._constant(array.first, scope), self._constant(array.last, scope)
            for index, place in ((low, array.first), (high, array.last)):
                if index is not None and not first <= index <= last:
                    hint = f"the indexes are {first}..{last}"
                    message = f"there is no {copy_name(name, index)}"
                    self._report.add("bad-index", place.span, message, hint)
            # A bound may be 0: only one that was reported counts as left out.
            first = first if low is None else max(first, low)
            last = last if high is None else min(last, high)
        return [copy_name(name, index) for index in range(first, last + 1)]

    def _over_components(
        self, node: nodes.AggregateNode, members: Iterable[str], scope: Scope
    ) -> nodes.AggregateNode | nodes.ArrayNode | nodes.LiteralNode:
        """The aggregate over the list of what it asks of each component."""
        operation = functions.AGGREGATES.get(node.function.text)
        if node.condition and operation and operation.operands is not operators.Operand.BOOLEAN:
            what = "an array" if node.function.text == "[" else f"'{node.function.text}'"
            message = f"{what} over components takes no 'if'"
            self._report.add("not-over-components", node.span, message, "leave out the 'if'")
            makes_array = node.function.text == "["
            return (
                nodes.ArrayNode((), span=node.span)
                if makes_array
                else nodes.LiteralNode(0, span=node.span)
            )
        asked, name = self._asked_of(node), node.variable.text
        elements = tuple(self.node(asked, scope.inside(name, member)) for member in members)
        array = nodes.ArrayNode(elements, span=node.array.span)
        element = nodes.Access(
            nodes.Name(name, span=node.function.span), (), span=node.function.span
        )
        return replace(node, element=element, array=array, condition=None)

    def _asked_of(self, node: nodes.AggregateNode) -> nodes.DataNode:
        """What an aggregate asks of each component: its element, on its condition."""
        if node.condition is None or isinstance(node.element, nodes.DataObjectNode):
            return node.element
        if id(node) not in self._asked:
            operator = "=>" if node.function.text == "all" else "and"
            self._asked[id(node)] = nodes.BinaryNode(
                operator, node.condition, node.element, operator_span=node.span, span=node.span
            )
        return self._asked[id(node)]


def _value(node: Any) -> int | None:
    """The value of an expression over whole numbers; None for any other expression."""
    match node:
        case nodes.LiteralNode(value=int() as value) if not isinstance(value, bool):
            return value
        case nodes.UnaryNode(operator="-", operand=operand):
            inner = _value(operand)
            return None if inner is None else -inner
        case nodes.BinaryNode(operator=operator) if operators.BINARY[operator].keeps_integers:
            numbers = _value(node.left), _value(node.right)
            if None in numbers or (operator == "%" and numbers[1] == 0):
                return None
            return int(operators.BINARY[operator].scalar(*numbers))
    return None


_NAMING = frozenset({"communication", "communications", "function", "over", "preferred", "target"})
"""Fields of nodes that contain names of communications, variables and functions."""


@cache
def _parts_of(kind: Hashable) -> tuple[str, ...]:
    """The fields of a kind of node that may contain nodes."""
    return tuple(f.name for f in fields(cast(Any, kind)) if f.compare)
