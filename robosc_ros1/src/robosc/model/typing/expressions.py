"""Typing of expressions: name resolution and type checking.

A name other than ``value`` can have several meanings: bare, a variable or a state of the component
itself (in a behaviour) and a value of any enum of the file; as ``A.b``, a variable or state of
component A and a value of enum A. The expected type selects among them:

- If the place has an expected type (an assigned variable, a property, ``and`` and conditions,
  arithmetic), the meanings of that type remain. So a state takes precedence over an enum value of
  the same name where a boolean is expected, and the enum value where the enum is. Values of the
  expected enum count even if the enum is not in scope (declared in the library of a component).
- If one side of ``=``/``!=`` is no name, its type is expected of the other side.
- If both sides are names, the pairs of meanings of equal type remain; a pair of two constants is
  dropped if another pair reads something.

If one meaning remains, it is taken. If none remains, the types do not fit. If several remain, the
name is ``ambiguous-name``, and the user writes ``Enum.value`` or ``Component.name``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from robosc.expr import evaluation, tree, types, undefined_data
from robosc.expr.traversal import part_of, path_text
from robosc.expr.tree import Binary, ElementRef, Expr, Literal, Unary, ValueRef
from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    DurationType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    Type,
)
from robosc.language import operators
from robosc.lazy_dataclasses import dataclass
from robosc.model.declarations.datatypes import TypeTable
from robosc.model.diagnostics import Report
from robosc.model.names import report_unknown, resolve_name, tables
from robosc.model.names.occurrences import Symbol, SymbolKind
from robosc.model.typing import aggregates, compatibility, durations, function_calls, value_word
from robosc.model.typing.compatibility import describe
from robosc.model.typing.expected import (
    ANY,
    BOOLEAN,
    ExpectedType,
    equal_to,
    expected_type,
    needs_of,
)
from robosc.model.typing.value_word import Incoming, is_value
from robosc.remedies import Change, Hint, Remedy, write
from robosc.runtime.core.values import Undefined
from robosc.syntax import nodes
from robosc.syntax.nodes import Access, BinaryNode, ExprNode, LiteralNode, MemberNode, Name

# Typing of parts of objects and arrays: of received values, variables, constants, elements.


def path_of(access: Access | MemberNode) -> tuple[str | int, ...]:
    """The path of an access with names as str."""
    return tuple(p.text if isinstance(p, Name) else p for p in access.path)


def _unbounded(type_: Type) -> Type:
    """The type of a part of a variable: the range of a part is not checked on assignment."""
    return IntegerType() if isinstance(type_, IntegerType) else type_


@dataclass(frozen=True)
class Parts:
    """Types the parts that accesses name; errors are reported at the member in question."""

    report: Report
    types: TypeTable

    def type_of(self, access: Access | MemberNode, whole: Type) -> Type | None:
        """The type of a part; None after a reported error."""
        type_: Type | None = whole
        for part in access.path:
            assert type_ is not None
            type_ = self._member(access, type_, part)
            if type_ is None:
                return None
        return type_

    def _member(self, access: Access | MemberNode, type_: Type, part: Name | int) -> Type | None:
        if isinstance(part, int):
            if isinstance(type_, ArrayType):
                return type_.element
            self.report.add(
                "unknown-member", access.span, f"{describe(type_)} has no element [{part}]"
            )
            return None
        if isinstance(type_, ObjectType):
            found = type_.property(part.text)
            self.types.record_property(part, type_)
            if found is not None:
                return found
            declarations = self.types.type_declarations
            if not declarations.may_have(type_, part.text):
                diagnostic = self.report.add(
                    "unknown-member",
                    part.span,
                    f"{type_.name} has no property '{part.text}'",
                    self.report.suggest(part.text, [n for n, _ in type_.properties]),
                )
                declarations.miss(type_, part.text, diagnostic)
            return None
        hint: Hint | None = "take an element first: [0]" if isinstance(type_, ArrayType) else None
        if isinstance(type_, ArrayType) and part.text in ("length", "len", "size", "count"):
            whole = access.span.text.removesuffix(f".{part.text}")
            hint = f"write length({whole})"
        if access.span.text == f"value.{part.text}" and not isinstance(type_, ArrayType):
            hint = "it is the value itself: write value"
        self.report.add(
            "unknown-member",
            part.span,
            f"{describe(type_)} has no property '{part.text}'",
            hint,
        )
        return None

    def of_computed(self, node: MemberNode, whole: Expr) -> Expr | None:
        """A part of a computed object; None after a reported error."""
        type_ = self.type_of(node, whole.type)
        return (
            None if type_ is None else part_of(whole, path_of(node), _unbounded(type_), node.span)
        )

    def of_argument(self, access: Access, whole: Expr) -> Expr | None:
        """An argument of a function, or a part of it; None after a reported error."""
        if isinstance(whole, ElementRef):
            type_ = self.type_of(access, whole.type)
            path = (*whole.path, *path_of(access))
            return None if type_ is None else replace(whole, path=path, type=type_)
        return self.of_named(access, whole, 0)

    def of_named(self, access: Access, whole: Expr, members: int) -> Expr | None:
        """A part of a variable or a constant; None after a reported error.

        The first ``members`` names of the access's path belong to the name of the whole.
        """
        rest = replace(access, path=access.path[members:])
        if not rest.path:
            return whole
        type_ = self.type_of(rest, whole.type)
        if type_ is None:
            return None
        if isinstance(whole, Literal):
            return self._of_constant(whole, rest, type_)
        return part_of(whole, path_of(rest), _unbounded(type_), access.span)

    def _of_constant(self, whole: Literal, rest: Access, type_: Type) -> Literal | None:
        path = path_of(rest)
        try:
            return Literal(evaluation.part_of_value(whole.value, path), type_, rest.span)
        except (Undefined, KeyError):
            message = f"the constant has no value for '{path_text(path)}'"
            self.report.add("unknown-member", rest.span, message)
            return None


# Comparisons that the range of a parameter decides, whatever its value is.


_ALWAYS: Mapping[str, Callable[[float, float, float], bool]] = {
    "<": lambda low, high, limit: high < limit,
    "<=": lambda low, high, limit: high <= limit,
    ">": lambda low, high, limit: low > limit,
    ">=": lambda low, high, limit: low >= limit,
    "=": lambda low, high, limit: low == high == limit,
    "!=": lambda low, high, limit: not low <= limit <= high,
}


def decided(comparison: tree.Binary) -> tree.Expr:
    """Return ``far > 3.0`` as what it is for every value that the parameter can have."""
    operator, left, right = comparison.operator, comparison.left, comparison.right
    if operator not in _ALWAYS:
        return comparison
    if isinstance(right, tree.ParameterRef):
        operator, left, right = operators.MIRRORED[operator], right, left
    if not isinstance(left, tree.ParameterRef) or left.parameter.bounds is None:
        return comparison
    limit = evaluation.constant(right)
    if isinstance(limit, bool) or not isinstance(limit, int | float):
        return comparison
    low, high = left.parameter.bounds
    for value, word in ((True, operator), (False, operators.OPPOSITE[operator])):
        if _ALWAYS[word](low, high, limit):
            return tree.Literal(value, comparison.type, comparison.span)
    return comparison


# Texts of the messages about types.


def _of_three(node: ExprNode, place: str) -> str | None:
    """The hint for ``a < x < b``, if a node is a comparison that is compared; else None."""
    orders = {f"'{o.spelling}'": o.spelling for o in operators.BINARY.values() if o.is_comparison}
    if place not in orders or not isinstance(node, BinaryNode):
        return None
    if not operators.BINARY[node.operator].is_comparison:
        return None
    middle = node.right.span.text
    return f"write {node.span.text} and {middle} {orders[place]} …"


VALUE_PLACES = (
    "'value' can be used in enum rules, in requirements on commands and their data, and after"
    " 'on request', 'on response', 'on feedback' and an action's 'on error'"
)


def alternatives(meanings: list[tree.Expr]) -> str:
    """The types of a name's meanings as text: ``a state (a boolean) or a value of Way``."""
    return " or ".join(dict.fromkeys(_in_words(m) for m in meanings))


def _in_words(meaning: tree.Expr) -> str:
    if isinstance(meaning, tree.StateRef):
        return "a state (a boolean)"
    return compatibility.describe(meaning.type)


def _unquoted(value: object, expected: ExpectedType) -> str | None:
    """A number or boolean that is written in quotes; None for everything else."""
    if not isinstance(value, str):
        return None
    if value in ("true", "false") and expected.accepts(types.BooleanType()):
        return value
    is_number = value.replace(".", "", 1).removeprefix("-").isdecimal()
    return value if is_number and expected.accepts(types.DoubleType()) else None


_STRINGS = types.BooleanType | types.IntegerType | types.DoubleType | types.EnumType
"""Of whose values ``string(…)`` makes one."""


def hint_for(node: ExprNode, given: types.Type, expected: ExpectedType, place: str) -> Hint | None:
    """The remedy for an expression whose type does not fit its place; None if there is no usual."""
    if isinstance(expected.type, types.DurationType):
        return "write a number with a unit: 500 ms, 0.5 s, 2 min or 1 h"
    if isinstance(expected.type, types.IntegerType) and isinstance(given, types.DoubleType):
        return f"write round({node.span.text}), or floor or ceil of it"
    if isinstance(given, types.ObjectType):
        fitting = [name for name, type_ in given.properties if expected.accepts(type_)]
        if len(fitting) == 1:  # of std_msgs/Float32, for one
            return write(f"{node.span.text}.{fitting[0]}")
    if isinstance(expected.type, types.StringType) and isinstance(given, _STRINGS):
        return write(f"string({node.span.text})")
    if (comparison := _of_three(node, place)) is not None:
        return comparison
    if isinstance(node, LiteralNode) and (unquoted := _unquoted(node.value, expected)):
        return write(unquoted, ", without quotes")
    if place == "'=>'":
        return "'=>' means 'implies': write >= to compare"
    literal = place == value_word.RULE and isinstance(node, LiteralNode)
    if not literal:
        return None
    meant = f"value = {node.span.text}"
    return Remedy(f"write: {meant}", Change.REPLACE, (meant,))


class Typer:
    """Types the expressions of one place; None stands for an expression with a reported error."""

    def __init__(
        self,
        report: Report,
        types: TypeTable,
        symbols: tables.SymbolTable | None,
        incoming: Incoming,
        arguments: Mapping[str, Expr] = MappingProxyType({}),
    ) -> None:
        self._arguments = arguments
        self._report = report
        self._types = types
        self._incoming = incoming
        self._faults = report_unknown.NameFaults(report, types, symbols)
        self._meanings = resolve_name.Meanings(report, types, symbols, incoming.reasons)
        self._parts = Parts(report, types)
        self._bound: dict[str, aggregates.Bound] = {}
        self._aggregates = aggregates.Aggregates(self.check, self._bound, report)
        self._conditions: dict[tuple[int, str], tuple[nodes.ExprNode, Expr | None]] = {}

    def check(self, node: nodes.ExprNode, expected: ExpectedType, place: str) -> Expr | None:
        """The typed expression; None after a reported error. ``place`` is a text for messages.

        Copies of a statement share parts of their conditions: those are typed once.
        """
        if expected is not BOOLEAN or self._bound:
            return self._typed(node, expected, place)
        key = id(node), place
        if key not in self._conditions:
            self._conditions[key] = node, self._typed(node, expected, place)
        return self._conditions[key][1]

    def _typed(self, node: nodes.ExprNode, expected: ExpectedType, place: str) -> Expr | None:
        match node:
            case nodes.Access() if node.root.text in self._bound and not node.root.escaped:
                typed = self._element(node)
            case nodes.Access() if node.root.text in self._arguments and not node.root.escaped:
                typed = self._parts.of_argument(node, self._arguments[node.root.text])
            case nodes.Access() if not is_value(node):
                whole = self._meanings.whole_of(node)
                if whole is None:
                    return self._choose(node, expected, place)
                typed = self._parts.of_named(node, *whole)
            case nodes.Access():
                typed = self._value(node)
            case nodes.LiteralNode():
                typed = Literal(node.value, compatibility.type_of(node.value), node.span)
            case nodes.UnaryNode() | nodes.DurationNode() if isinstance(
                expected.type, DurationType
            ) and (duration := durations.signed_duration(node)):
                typed = durations.typed_duration(duration, self._report)
            case nodes.UnaryNode():
                typed = self._unary(node)
            case nodes.BinaryNode():
                typed = self._binary(node, expected)
            case nodes.CallNode():
                typed = self._call(node)
            case nodes.InNode():
                typed = function_calls.typed_membership(node, self.check, self._report)
            case nodes.ElementNode():
                typed = function_calls.typed_element(node, self.check)
            case nodes.MemberNode():
                whole_node = self.check(node.object, ANY, "'.'")
                typed = None if whole_node is None else self._parts.of_computed(node, whole_node)
            case nodes.SliceNode():
                typed = function_calls.typed_section(node, self.check)
            case nodes.AggregateNode():
                typed = self._aggregates.typed(node)
            case nodes.ArrayNode() if expected == needs_of(operators.Operand.ARRAY):
                typed = function_calls.typed_list(node, self.check, self._report)
            case nodes.ArrayNode() | nodes.DurationNode():
                what = "an array" if isinstance(node, nodes.ArrayNode) else "a duration"
                self._report.add(
                    "type-mismatch",
                    node.span,
                    f"{place} needs {expected.text}, this is {what}",
                    "arrays and durations stand in provided data, where a field takes them",
                )
                return None
            case _:
                raise AssertionError(f"{type(node).__name__} has no meaning yet")
        if typed is not None and not expected.accepts(typed.type):
            self._mismatch(node, typed.type, expected, place)
            return None
        return typed

    def made(self, node: nodes.AggregateNode, element: Callable[[], Expr | None]) -> Expr | None:
        """An array in data; ``element`` types what it is made of. None after a reported error."""
        return self._aggregates.typed(node, element)

    def _mismatch(
        self, node: nodes.ExprNode, given: Type, expected: ExpectedType, place: str
    ) -> None:
        self._report.add(
            "type-mismatch",
            node.span,
            f"{place} needs {expected.text}, this is {compatibility.describe(given)}",
            hint_for(node, given, expected, place),
        )

    # --- operators -------------------------------------------------------------------------------

    def _unary(self, node: nodes.UnaryNode) -> Expr | None:
        expected = needs_of(operators.UNARY[node.operator].operands)
        operand = self.check(node.operand, expected, f"'{node.operator}'")
        if operand is None:
            return None
        operation = operators.UNARY[node.operator]
        type_ = compatibility.result_type(operation.result, (operand.type,))
        if operation.operands is operators.Operand.NUMBER and isinstance(operand, Literal):
            return Literal(operation.scalar(operand.value), type_, node.span)
        return Unary(node.operator, operand, type_, node.span)

    def _binary(self, node: nodes.BinaryNode, expected: ExpectedType) -> Expr | None:
        constant = self._meanings.ros_constant(node)
        if constant is not None:
            return self._types.ros_constant(*constant)
        counted = self._aggregates.counted(node)
        if counted is not None:
            return counted.expr
        operation = operators.BINARY[node.operator]
        if node.operator == "else":
            return self._otherwise(node, expected)
        if operation.operands is operators.Operand.EQUAL:
            return self._equality(node)
        expected = needs_of(operation.operands)
        # Where '>=' is meant, one error is enough.
        reversed_ = function_calls.is_reversed(node)
        left = None if reversed_ else self.check(node.left, expected, f"'{node.operator}'")
        if operation.operands is operators.Operand.SUMMAND and left is not None:
            expected = equal_to(left.type)
        right = self.check(node.right, expected, f"'{node.operator}'")
        if left is None or right is None:
            return None
        type_ = compatibility.result_type(operation.result, (left.type, right.type))
        return decided(Binary(node.operator, left, right, type_, node.span))

    def _otherwise(self, node: nodes.BinaryNode, expected: ExpectedType) -> Expr | None:
        left = self.check(node.left, expected, "'else'")
        if left is None:
            return None
        if isinstance(left.type, ArrayType):
            hint = "write it behind what is computed of the array: min(x for x in …) else 0.0"
            message = f"'else' cannot replace {compatibility.describe(left.type)}"
            self._report.add("type-mismatch", node.left.span, message, hint)
            return None
        right = self.check(node.right, expected_type(left.type), "'else', as what is before it,")
        if right is None:
            return None
        right = compatibility.coerce(right, left.type)
        if isinstance(left.type, BooleanType):
            return undefined_data.otherwise(left, right, node.span)
        if isinstance(left.type, DoubleType) != isinstance(right.type, DoubleType):
            expected = ExpectedType("a double", lambda _: False)
            self._mismatch(node.right, right.type, expected, "'else', as what is before it,")
            return None
        type_ = compatibility.result_type(operators.BINARY["else"].result, (left.type, right.type))
        return Binary("else", left, right, type_, node.span)

    def _equality(self, node: nodes.BinaryNode) -> Expr | None:
        open_left, open_right = self._is_open(node.left), self._is_open(node.right)
        place = f"'{node.operator}'"
        if open_left and open_right:
            assert isinstance(node.left, nodes.Access) and isinstance(node.right, nodes.Access)
            pair = self._pair(node, node.left, node.right)
            if pair is None:
                return None
            left, right = pair
            return Binary(node.operator, left, right, BooleanType(), node.span)
        first, second = (node.right, node.left) if open_left else (node.left, node.right)
        known = self.check(first, ANY, place)
        if known is None:
            self._silently(second, place)
            return None
        if not compatibility.comparable(known.type, known.type):
            self._report.add(
                "type-mismatch",
                first.span,
                f"{place} cannot compare {compatibility.describe(known.type)}",
                "compare one of its parts"
                if isinstance(known.type, ArrayType | ObjectType)
                else None,
            )
            return None
        other = self.check(second, equal_to(known.type), "the other side of " + place)
        if other is None:
            return None
        left, right = (other, known) if open_left else (known, other)
        return decided(Binary(node.operator, left, right, BooleanType(), node.span))

    def _is_open(self, node: nodes.ExprNode) -> bool:
        """Whether a side of a comparison is a name whose meaning the other side's type selects."""
        return (
            isinstance(node, nodes.Access)
            and not is_value(node)
            and (node.root.text not in {*self._bound, *self._arguments} or node.root.escaped)
            and self._meanings.whole_of(node) is None
        )

    def _silently(self, node: nodes.ExprNode, place: str) -> None:
        """Report the errors of a comparison's side that do not depend on the other, faulty side."""
        if isinstance(node, nodes.Access) and not is_value(node):
            if self._meanings.of(node) == [] and node.path:
                self._faults.unknown(node)
        else:
            self.check(node, ANY, place)

    def _pair(
        self, node: nodes.BinaryNode, left: nodes.Access, right: nodes.Access
    ) -> tuple[Expr, Expr] | None:
        """The meanings of two names that are compared with each other."""
        first, second = self._meanings.of(left), self._meanings.of(right)
        if first is None or second is None:
            # A bare name may be a value of an enum with an error: it is not reported.
            for known, access in ((first, left), (second, right)):
                if known == [] and access.path:
                    self._faults.unknown(access)
            return None
        known_types = [m.type for m in first], [m.type for m in second]
        first = first + self._meanings.out_of_sight(left, known_types[1], first)
        second = second + self._meanings.out_of_sight(right, known_types[0], second)
        if not first or not second:
            self._faults.unknown_pair(left, first, right, second)
            return None
        pairs = [(a, b) for a in first for b in second if compatibility.comparable(a.type, b.type)]
        reading = [p for p in pairs if not all(isinstance(e, Literal) for e in p)]
        pairs = reading or pairs
        if len(pairs) == 1:
            return self._recorded(left, pairs[0][0]), self._recorded(right, pairs[0][1])
        if pairs:
            ambiguous = right if len({id(b) for _, b in pairs}) > 1 else left
            self._faults.ambiguous(ambiguous, second if ambiguous is right else first)
            return None
        self._unequal(node, first, second)
        return None

    def _unequal(self, node: nodes.BinaryNode, first: list[Expr], second: list[Expr]) -> None:
        wrong, given, other = node.right, second, first
        if isinstance(first[0], Literal) and not isinstance(second[0], Literal):
            wrong, given, other = node.left, first, second
        hint = None
        needed = next((m.type for m in other if isinstance(m.type, EnumType)), None)
        if needed is not None and isinstance(wrong, nodes.Access):
            name = report_unknown.last_name(wrong)
            hint = self._report.suggest(name, needed.values, f"{needed.name} has")
        self._report.add(
            "type-mismatch",
            wrong.span,
            f"'{node.operator}' compares two values of one type: this is "
            f"{alternatives(given)}, the other side is {alternatives(other)}",
            hint,
        )

    # --- names -----------------------------------------------------------------------------------

    def _choose(self, access: nodes.Access, expected: ExpectedType, place: str) -> Expr | None:
        meanings = self._meanings.of(access)
        if meanings is None:
            return None
        if expected.type is not None:
            meanings = meanings + self._meanings.out_of_sight(access, [expected.type], meanings)
        if not meanings:
            self._faults.unknown(access, expected.type)
            return None
        fitting = [m for m in meanings if expected.accepts(m.type)]
        if len(fitting) == 1:
            return self._recorded(access, fitting[0])
        if fitting:
            self._faults.ambiguous(access, fitting)
        else:
            hint = None
            if isinstance(expected.type, EnumType):
                name = report_unknown.last_name(access)
                hint = self._report.suggest(name, expected.type.values, f"{expected.type.name} has")
            self._report.add(
                "type-mismatch",
                access.span,
                f"{place} needs {expected.text}, this is {alternatives(meanings)}",
                hint,
            )
        return None

    def _recorded(self, access: nodes.Access, meaning: Expr) -> Expr:
        self._meanings.record(access, meaning)
        if isinstance(meaning, Literal) and isinstance(meaning.type, EnumType):
            return replace(meaning, type=self._types.full(meaning.type))
        return meaning

    def _call(self, node: nodes.CallNode) -> Expr | None:
        """A call of a function, or of an enum that converts."""
        enum = self._types.called_enum(node.function)
        function = None if enum is not None else self._meanings.function(node.function)
        if function is not None:
            return function_calls.typed_declared_call(node, *function, self.check, self._report)
        if enum is None and self._types.scope.is_unresolved(node.function.root.text, "function"):
            return None
        if enum is None:
            return function_calls.typed_call(node, self.check, self._report)
        return function_calls.typed_conversion(node, enum, self.check, self._report)

    def _element(self, access: nodes.Access) -> Expr | None:
        """The variable of an enclosing aggregate, or a part of its value."""
        name = access.root.text
        bound = self._bound[name]
        type_ = self._parts.type_of(access, bound.type)
        if type_ is None:
            return None
        return ElementRef(name, path_of(access), type_, access.span, bound.constant)

    # --- value -----------------------------------------------------------------------------------

    def _value(self, access: nodes.Access) -> Expr | None:
        incoming = self._incoming
        detail = str(incoming.type) if incoming.type is not None else ""
        self._types.scope.names.note(access.root, Symbol(SymbolKind.INCOMING, "value", detail))
        if incoming.type is None:
            if incoming.known:
                self._report.add(
                    "value-not-allowed", access.root.span, incoming.reason, VALUE_PLACES
                )
            return None
        if isinstance(incoming.type, NoneType):
            self._report.add("value-not-allowed", access.root.span, "this event carries no value")
            return None
        type_ = self._parts.type_of(access, incoming.type)
        if type_ is None:
            return None
        return ValueRef(path_of(access), type_, access.span, incoming.optional)
