"""Typing of aggregates, ``any(E for x in A)``; those over lists of expressions are expanded.

``count(x for x in [A.busy, !B.on]) < 2`` becomes a condition that enumerates the cases, so that
later stages have no aggregates over such lists. An aggregate over components is one over the list
of what it asks of each of them (:mod:`robosc.model.names.copies`). A list of constants is an array
like any other.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from robosc.expr import traversal, tree, types
from robosc.expr.evaluation import constant
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.quantified import Chains, chain, compared, joined, opposite
from robosc.language import functions, operators
from robosc.model.diagnostics import Report
from robosc.model.typing.compatibility import describe, result_type
from robosc.model.typing.expected import BOOLEAN, ExpectedType, needs_of
from robosc.model.typing.function_calls import Check, list_literal, typed_elements
from robosc.syntax import nodes

_BOOLEAN = types.BooleanType()


class Bound(NamedTuple):
    """The variable of an aggregate: its type, and whether the array is a constant."""

    type: types.Type
    constant: bool


class Counted(NamedTuple):
    """An expanded comparison of a count over a list; ``expr`` is None after a reported error."""

    expr: tree.Expr | None


class Aggregates:
    """Types aggregates; ``bound`` has the variables of enclosing ones."""

    def __init__(self, check: Check, bound: dict[str, Bound], report: Report) -> None:
        self._check = check
        self._bound = bound
        self._report = report
        self._chains: defaultdict[str, Chains] = defaultdict(dict)
        # By the value that an undefined condition counts as.
        self._defined: defaultdict[bool, IdentityCache[tree.Expr]] = defaultdict(IdentityCache)

    def typed(
        self, node: nodes.AggregateNode, element: Callable[[], tree.Expr | None] | None = None
    ) -> tree.Expr | None:
        """The aggregate, or the expression to which it expands; None after a reported error.

        ``element`` types what an array is made of, where its variables have a meaning.
        """
        name = node.function.text
        operation = functions.AGGREGATES.get(name)
        if operation is None:
            hint = self._report.suggest(name, functions.AGGREGATES)
            message = f"'{name}' is not a function over arrays"
            self._report.add("unknown-name", node.function.span, message, hint)
            return None
        for variable in filter(None, (node.position, node.variable)):
            again = variable is node.variable and _position_name(node) == variable.text
            if again or variable.text in self._bound or variable.text == "value":
                message = f"'{variable.text}' already has another meaning here"
                self._report.add("duplicate-name", variable.span, message, "give it another name")
                return None
        if not isinstance(node.array, nodes.ArrayNode):
            array = self._check(node.array, needs_of(operators.Operand.ARRAY), f"'{name}'")
            return None if array is None else self._through(node, array, element)
        listed = self._listed(node, node.array)
        if listed is None:
            return None
        if _is_array(node, listed[0]):
            array = list_literal(node.array, *listed, self._report)
            return None if array is None else self._through(node, array, element)
        return self._expanded(node, node.array, *listed)

    def counted(self, node: nodes.BinaryNode) -> Counted | None:
        """``count(…) < 2`` over a list of expressions, expanded; None for other comparisons."""
        for many, bound, operator in (
            (node.left, node.right, node.operator),
            (node.right, node.left, operators.MIRRORED.get(node.operator, "")),
        ):
            if (
                operator in operators.MIRRORED
                and isinstance(many, nodes.AggregateNode)
                and many.function.text == "count"
                and isinstance(many.array, nodes.ArrayNode)
            ):
                listed = self._listed(many, many.array)
                if listed is None:
                    return Counted(None)
                if _is_array(many, listed[0]):
                    return None
                comparison = self._compared(many, many.array, operator, bound, *listed)
                return Counted(None if comparison is None else replace(comparison, span=node.span))
        return None

    def _through(
        self,
        node: nodes.AggregateNode,
        array: tree.Expr,
        made_of: Callable[[], tree.Expr | None] | None,
    ) -> tree.Expr | None:
        assert isinstance(array.type, types.ArrayType)
        parts = self._parts(node, array.type.element, tree.is_constant_data(array), made_of)
        if parts is None:
            return None
        name, (element, condition) = node.function.text, parts
        type_ = self._type(node, element)
        if type_ is None:
            return None
        names = node.variable.text, array, element, condition, type_, node.span
        return tree.Aggregate(name, *names, _position_name(node))

    def _type(self, node: nodes.AggregateNode, element: tree.Expr) -> types.Type | None:
        """The type of an aggregate over an array; None after a reported error."""
        result = functions.AGGREGATES[node.function.text].result
        if result is operators.Result.ELEMENT:
            return element.type
        if result is not operators.Result.ARRAY:
            return result_type(result, (element.type,))
        if isinstance(element.type, types.EnumType):
            message = "an array of the values of an enum cannot be made"
            hint = "make one of what it converts from, or ask with any(…), count(…) or first(…)"
            self._report.add("type-mismatch", node.element.span, message, hint)
            return None
        if isinstance(element.type, types.ArrayType | types.NoneType):
            message = f"an array cannot be made of {describe(element.type)}"
            self._report.add("type-mismatch", node.element.span, message)
            return None
        return types.ArrayType(element.type)

    def _parts(
        self,
        node: nodes.AggregateNode,
        type_: types.Type,
        constant: bool = False,
        made_of: Callable[[], tree.Expr | None] | None = None,
    ) -> tuple[tree.Expr, tree.Expr | None] | None:
        """The typed element and condition of an aggregate; None after a reported error."""
        name = node.function.text
        self._bound[node.variable.text] = Bound(type_, constant)
        if node.position is not None:
            self._bound[node.position.text] = Bound(types.IntegerType(), False)
        needed = needs_of(functions.AGGREGATES[name].operands)
        element = made_of() if made_of else self._asked(node.element, needed, f"'{name}'")
        condition = None
        if node.condition is not None:
            condition = self._check(node.condition, BOOLEAN, "the 'if' of an array")
        del self._bound[node.variable.text]
        if node.position is not None:
            del self._bound[node.position.text]
        if element is None or (condition is None) != (node.condition is None):
            return None
        return element, condition

    def _asked(self, node: nodes.DataNode, needed: ExpectedType, place: str) -> tree.Expr | None:
        """The typed element; None after reporting that it is an object."""
        if not isinstance(node, nodes.DataObjectNode):
            return self._check(node, needed, place)
        message = "an array of objects is made in provided data only, where a field takes it"
        self._report.add("type-mismatch", node.span, message)
        return None

    # --- lists of expressions ---

    def _listed(
        self, node: nodes.AggregateNode, array: nodes.ArrayNode
    ) -> tuple[list[tree.Expr], types.Type] | None:
        """The elements of a list and their type; None after a reported error."""
        if not takes_elements(node):
            return typed_elements(array, self._check, self._report)
        name = node.function.text
        expected = needs_of(functions.AGGREGATES[name].operands)
        return typed_elements(array, self._check, self._report, expected, f"'{name}'")

    def _expanded(
        self,
        node: nodes.AggregateNode,
        array: nodes.ArrayNode,
        elements: Sequence[tree.Expr],
        type_: types.Type,
    ) -> tree.Expr | None:
        name = node.function.text
        if name in ("any", "all"):
            conditions = self._conditions(node, elements, type_)
            operator = "or" if name == "any" else "and"
            known = self._chains[operator] if takes_elements(node) else None
            if conditions is None:
                return None
            return replace(chain(operator, conditions, node.span, known), span=node.span)
        asked = self._asked_of(node, elements, type_)
        if asked is None:
            return None
        numbers, condition = asked
        fault = self._fault(name, _kind(array), numbers, condition)
        if fault is not None:
            self._report.add("not-over-components", node.span, *fault)
            return None
        operation = "+" if name == "sum" else name

        def join(left: tree.Expr, right: tree.Expr) -> tree.Expr:
            both = result_type(functions.AGGREGATES[name].result, (left.type, right.type))
            if operation == "+":
                return tree.Binary("+", left, right, both, node.span)
            return tree.Call(operation, (left, right), both, node.span)

        return joined(numbers or [tree.Literal(0, types.IntegerType(), node.span)], join)

    def _fault(
        self, name: str, kind: str, numbers: Sequence[tree.Expr], condition: bool
    ) -> tuple[str, str | None] | None:
        """Message and hint if a function of numbers cannot be expanded over these."""
        if name in ("first", "["):
            what = "an array" if name == "[" else "'first'"
            return f"{what} of {kind} is only possible in provided data, without 'if'", None
        if name == "count":
            message = f"'count' over {kind} is only possible in a comparison"
            return message, "compare count(…) with a number"
        if condition:
            return f"'{name}' over {kind} takes no 'if'", "leave out the 'if'"
        if not numbers and name != "sum":
            return f"'{name}' of no {kind} has no value", None
        if any(map(traversal.may_be_undefined, numbers)):
            hint = (
                "keep it in a variable of a number type, and use that: do near := value.ranges[0]"
            )
            return f"'{name}' over {kind} whose value may be missing is not possible", hint
        return None

    def _compared(
        self,
        many: nodes.AggregateNode,
        array: nodes.ArrayNode,
        operator: str,
        bound: nodes.ExprNode,
        elements: Sequence[tree.Expr],
        type_: types.Type,
    ) -> tree.Expr | None:
        conditions = self._conditions(many, elements, type_)
        number = self._check(bound, needs_of(operators.Operand.INTEGER), f"'{operator}'")
        if conditions is None or number is None:
            return None
        value = constant(number)
        if not isinstance(value, int):
            message = f"the number of {_kind(array)} can only be compared with a whole number"
            self._report.add("not-over-components", bound.span, message)
            return None
        condition = compared(conditions, operator, value)
        if condition is None:
            message = "this count has too many cases to be expanded"
            hint = f"compare it with a smaller number, or count fewer {_kind(array)}"
            self._report.add("not-over-components", many.span, message, hint)
        return condition

    def _conditions(
        self, node: nodes.AggregateNode, elements: Sequence[tree.Expr], type_: types.Type
    ) -> list[tree.Expr] | None:
        """The condition on each element, its ``if`` included; an undefined one does not count."""
        asked = self._asked_of(node, elements, type_)
        if asked is None:
            return None
        undefined_is = node.function.text == "all"
        cache = self._defined[undefined_is]
        return [
            cache.of(condition, lambda condition: _without_undefined(condition, undefined_is))
            for condition in asked[0]
        ]

    def _asked_of(
        self, node: nodes.AggregateNode, elements: Sequence[tree.Expr], type_: types.Type
    ) -> tuple[Sequence[tree.Expr], bool] | None:
        """The element of the aggregate for each element of the list, conditions with their ``if``.

        And whether it has an ``if``; None after a reported error.
        """
        if takes_elements(node):
            return elements, False
        parts = self._parts(node, type_)
        if parts is None:
            return None
        asked, condition = parts
        if condition is not None and asked.type == _BOOLEAN:
            operator = "=>" if node.function.text == "all" else "and"
            asked = tree.Binary(operator, condition, asked, _BOOLEAN)
        name, position = node.variable.text, _position_name(node)
        found = [
            _of_element(asked, {name: element, position: tree.Literal(place, types.IntegerType())})
            for place, element in enumerate(elements)
        ]
        return found, condition is not None


def takes_elements(node: nodes.AggregateNode) -> bool:
    """Whether an aggregate is over the elements of its array themselves: ``any(x for x in A)``."""
    match node.element:
        case nodes.Access(root=root, path=(), index=None):
            return root.text == node.variable.text and not root.escaped and node.condition is None
    return False


def _position_name(node: nodes.AggregateNode) -> str:
    return "" if node.position is None else node.position.text


def _is_array(node: nodes.AggregateNode, elements: Sequence[tree.Expr]) -> bool:
    """Whether a list stays an array, of constants about which an aggregate asks something.

    What is asked about the elements themselves is expanded, but for a count, of which only a
    comparison can be.
    """
    if takes_elements(node) and not (elements and node.function.text in ("count", "first", "[")):
        return False
    return all(constant(element) is not None for element in elements)


def _kind(array: nodes.ArrayNode) -> str:
    """What a list contains, in messages: it is written, or stands for indexed components."""
    return "expressions" if array.span.text.startswith("[") else "components"


def _of_element(asked: tree.Expr, values: Mapping[str, tree.Expr]) -> tree.Expr:
    """The expression over the variables of an aggregate, with values in their places."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        if isinstance(node, tree.ElementRef) and node.variable in values:
            value = values[node.variable]
            return traversal.part_of(value, node.path, node.type, node.span) if node.path else value
        return node

    return traversal.rewritten(asked, leaf)


def _without_undefined(condition: tree.Expr, undefined_is: bool) -> tree.Expr:
    """The condition, with the value ``undefined_is`` where it is undefined."""
    if not traversal.may_be_undefined(condition):
        return condition
    return opposite(tree.Holds(opposite(condition))) if undefined_is else tree.Holds(condition)
