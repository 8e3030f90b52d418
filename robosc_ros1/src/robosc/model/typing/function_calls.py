"""Typing of calls of functions, of ``in``, and of elements and sections of arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any, cast

from robosc import remedies, source
from robosc.expr import evaluation, quantified, traversal, tree, undefined_data
from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    ObjectType,
    Type,
    Value,
    is_number,
)
from robosc.language.functions import AGGREGATES, FUNCTIONS, GEOMETRY
from robosc.language.operators import BINARY, Operand, Operator, Result
from robosc.model.diagnostics import Report
from robosc.model.names.value_scope import ValueScope
from robosc.model.typing.compatibility import coerce, comparable, describe, result_type
from robosc.model.typing.expected import ANY, ExpectedType, equal_to, expected_type, needs_of
from robosc.syntax import nodes
from robosc.syntax.nodes import CallNode, ExprNode

# ``yaw``, ``distance`` and ``sector``, as functions of what their objects are made of.


_DOUBLE = DoubleType()


def typed_geometry(
    node: CallNode, check: Callable[[ExprNode, ExpectedType, str], tree.Expr | None], report: Report
) -> tree.Expr | None:
    """The expression for which a call of a function in ``GEOMETRY`` stands; None after an error."""
    name = node.function.root.text
    objects, numbers, fields, words = GEOMETRY[name]
    if len(node.arguments) != objects + numbers:
        count = f"{objects + numbers} argument{'s' * (objects + numbers > 1)}"
        message = f"'{name}' takes {count}, not {len(node.arguments)}"
        report.add("type-mismatch", node.span, message)
        return None
    parts = []
    for argument in node.arguments[:objects]:
        found = check(argument, needs_of(Operand.ANY), f"'{name}'")
        if found is None:
            return None
        if not _has(found, fields):
            message = f"'{name}' needs {words}, not {describe(found.type)}"
            hint = f"an object with the numbers {', '.join(fields)}"
            if fields[0] == "ranges":
                hint = (
                    f"an object with an array of numbers 'ranges', and {' and '.join(fields[1:])}"
                )
            report.add("type-mismatch", argument.span, message, hint)
            return None
        if (missing := _missing(found, fields)) is not None:
            message = f"the constant has no value for '{missing}'"
            report.add("unknown-member", argument.span, message)
            return None
        parts.append([_part(found, field, node.span) for field in fields])
    angles = [check(a, needs_of(Operand.NUMBER), f"'{name}'") for a in node.arguments[objects:]]
    given = [angle for angle in angles if angle is not None]
    if len(given) < len(angles):
        return None
    match name:
        case "sector":
            operands = (*parts[0], *given)
            return tree.Call("sector", operands, parts[0][0].type, node.span)
        case "yaw":
            return _yaw(*parts[0])
    return _distance(*parts)


def _has(expr: tree.Expr, fields: Sequence[str]) -> bool:
    type_ = expr.type
    if not isinstance(type_, ObjectType):
        return False
    types = {field: type_.property(field) for field in fields}
    ranges = types.pop("ranges", ArrayType(_DOUBLE))
    numbers = [*types.values(), ranges.element if isinstance(ranges, ArrayType) else None]
    return all(part is not None and is_number(part) for part in numbers)


def _missing(expr: tree.Expr, fields: Sequence[str]) -> str | None:
    """A field that a constant leaves out; None if it has all."""
    if not isinstance(expr, tree.Literal):
        return None
    value: Any = expr.value
    return next((field for field in fields if field not in value), None)


def _part(whole: tree.Expr, field: str, span: source.Span) -> tree.Expr:
    assert isinstance(whole.type, ObjectType)
    type_ = whole.type.property(field)
    assert type_ is not None
    if isinstance(whole, tree.Literal):
        return tree.Literal(evaluation.part_of_value(whole.value, (field,)), type_, span)
    return traversal.part_of(whole, (field,), type_, span)


def _of(operator: str, left: tree.Expr, right: tree.Expr) -> tree.Expr:
    type_ = result_type(BINARY[operator].result, [left.type, right.type])
    return tree.Binary(operator, left, right, type_, left.span)


def _yaw(x: tree.Expr, y: tree.Expr, z: tree.Expr, w: tree.Expr) -> tree.Expr:
    """The rotation about the upward axis, in radians (REP 103)."""
    two, one = tree.Literal(2.0, _DOUBLE, x.span), tree.Literal(1.0, _DOUBLE, x.span)
    sine = _of("*", two, _of("+", _of("*", w, z), _of("*", x, y)))
    cosine = _of("-", one, _of("*", two, _of("+", _of("*", y, y), _of("*", z, z))))
    return tree.Call("atan2", (sine, cosine), _DOUBLE, x.span)


def _distance(first: list[tree.Expr], second: list[tree.Expr]) -> tree.Expr:
    x, y, z = (_of("-", a, b) for a, b in zip(first, second, strict=True))
    flat = tree.Call("hypot", (x, y), _DOUBLE, x.span)
    return tree.Call("hypot", (flat, z), _DOUBLE, x.span)


Check = Callable[[nodes.ExprNode, ExpectedType, str], tree.Expr | None]
"""Types an expression, given the expected type and a text for its place in messages."""


def typed_call(node: nodes.CallNode, check: Check, report: Report) -> tree.Expr | None:
    """A call of one of the language's functions; None after a reported error."""
    name = node.function.root.text
    if name in GEOMETRY and not node.function.path:
        return typed_geometry(node, check, report)
    function = FUNCTIONS.get(name) if not node.function.path else None
    if function is None and name == "now" and not node.function.path:
        message = "now() is a point in time: it stands in provided data, where a field takes one"
        report.add("type-mismatch", node.span, message)
        return None
    if function is None:
        report.add(
            "unknown-name",
            node.function.span,
            f"there is no function '{node.function.span.text}'",
            _function_meant(node) or report.suggest(name, [*FUNCTIONS, *GEOMETRY]),
        )
        return None
    if not _right_number(function, node, report):
        return None
    kinds = [*function.arguments]
    kinds += kinds[-1:] * (len(node.arguments) - len(kinds))
    arguments = [
        check(argument, needs_of(kind), f"'{name}'")
        for argument, kind in zip(node.arguments, kinds, strict=True)
    ]
    known = [argument for argument in arguments if argument is not None]
    if len(known) < len(arguments):
        return None
    if name == "defined":
        return replace(undefined_data.defined(known[0]), span=node.span)
    return _nested(function, known, node.span)


def typed_declared_call(
    node: nodes.CallNode,
    function: nodes.FunctionNode,
    scope: ValueScope,
    check: Check,
    report: Report,
) -> tree.Expr | None:
    """A call of a function of the model, which ``scope`` declares; None after a reported error."""
    types = scope.typer.arguments(function) if scope.typer is not None else None
    if scope.typer is None or types is None:
        return None
    name = f"'{function.name.text}'"
    if len(types) != len(node.arguments):
        wanted = f"{len(types)} argument{'s' * (len(types) > 1)}"
        report.add("type-mismatch", node.span, f"{name} takes {wanted}, not {len(node.arguments)}")
        return None
    pairs = zip(node.arguments, types, strict=True)
    given = [(check(part, expected_type(type_), name), type_) for part, type_ in pairs]
    known = [coerce(part, type_) for part, type_ in given if part is not None]
    typed = scope.typer.call(function, known) if len(known) == len(types) else None
    if typed is None and not report.has_errors:
        report.add("type-mismatch", node.span, f"{name} has no value for these arguments")
    return typed


def typed_conversion(
    node: nodes.CallNode, enum: EnumType, check: Check, report: Report
) -> tree.Convert | None:
    """A call of an enum, which converts its argument; None after a reported error."""
    if len(node.arguments) != 1:
        message = f"'{enum.name}' takes 1 argument, not {len(node.arguments)}"
        report.add("type-mismatch", node.span, message)
        return None
    argument = check(node.arguments[0], expected_type(enum.source), f"'{enum.name}'")
    return None if argument is None else tree.Convert(argument, enum, node.span)


def _right_number(function: Operator, node: nodes.CallNode, report: Report) -> bool:
    least, given = len(function.arguments), len(node.arguments)
    if given == least or (function.variadic and given > least):
        return True
    more = " or more" if function.variadic else ""
    report.add(
        "type-mismatch",
        node.span,
        f"'{function.spelling}' takes {least}{more} argument{'s' * (least > 1)}, not {given}",
        _of_an_array(function, node.arguments) if function.spelling in AGGREGATES else None,
    )
    return False


def _of_an_array(function: Operator, arguments: Sequence[nodes.ExprNode]) -> str | None:
    """The hint for the least or greatest element of an array."""
    match arguments:
        case [nodes.ArrayNode(span=span)]:
            return f"write {function.spelling}({span.text[1:-1].strip()})"
        case [array]:
            return f"of an array: {function.spelling}(x for x in {array.span.text})"
    return None


def _function_meant(node: nodes.CallNode) -> remedies.Hint | None:
    """The hint for names that other languages have for functions, such as ``Math.abs``."""
    called = node.function.span.text
    last = node.function.path[-1] if node.function.path else None
    if called in ("if", "when"):
        return remedies.Remedy(f"leave '{called}' out", remedies.Change.REMOVE)
    if last is None and called[0].isupper():
        return "data is written in braces: { NAME: …, NAME: … }"
    if node.function.root.text == "value" and len(node.arguments) == 1:
        return f"an element is in brackets: {called}[…]"
    if isinstance(last, nodes.Name) and last.text in FUNCTIONS:
        return f"write {last.text}(…)"
    if node.function.span.text in ("pow", "power", "sqr", "square"):
        return "write x * x"
    return None


def _nested(function: Operator, arguments: Sequence[tree.Expr], span: source.Span) -> tree.Expr:
    """The call; with more arguments than the function has, nested calls from the left."""

    def call(operands: tuple[tree.Expr, ...]) -> tree.Expr:
        type_ = result_type(function.result, [operand.type for operand in operands])
        return tree.Call(function.spelling, operands, type_, span)

    if not function.variadic:
        return call(tuple(arguments))
    return reduce(lambda found, argument: call((found, argument)), arguments)


def is_reversed(node: nodes.BinaryNode) -> bool:
    """Whether a node is ``x => 0.3``, which is meant to be ``x >= 0.3``."""
    is_number = isinstance(node.right, nodes.LiteralNode) and not isinstance(node.right.value, bool)
    return node.operator == "=>" and is_number


def typed_membership(node: nodes.InNode, check: Check, report: Report) -> tree.Expr | None:
    """``E in { a, b }`` as a disjunction of comparisons with E; None after a reported error."""
    operand = check(node.operand, ANY, "'in'")
    if operand is not None and not comparable(operand.type, operand.type):
        message = f"'in' cannot compare {describe(operand.type)}"
        report.add("type-mismatch", node.operand.span, message)
        operand = None
    expected = ANY if operand is None else equal_to(operand.type)
    checked = [check(value, expected, "'in'") for value in node.values]
    values = [value for value in checked if value is not None]
    if operand is None or len(values) < len(checked):
        return None
    equal = [tree.Binary("=", operand, v, BooleanType(), node.span) for v in values]
    return quantified.chain("or", equal, node.span)


def typed_element(node: nodes.ElementNode, check: Check) -> tree.Expr | None:
    """``array[index]`` with a computed index; None after a reported error."""
    array = check(node.array, needs_of(Operand.ARRAY), "'[…]'")
    index = check(node.index, needs_of(Operand.INTEGER), "an index")
    if array is None or index is None:
        return None
    assert isinstance(array.type, ArrayType)
    element = array.type.element
    if isinstance(element, EnumType) and not tree.is_constant_data(array):
        # The array has what the enum converts from.
        call = tree.Call("element", (array, index), element.source, node.span)
        return tree.Convert(call, element, node.span)
    return tree.Call("element", (array, index), element, node.span)


def typed_section(node: nodes.SliceNode, check: Check) -> tree.Expr | None:
    """``array[first..last]``; None after a reported error."""
    array = check(node.array, needs_of(Operand.ARRAY), "'[…]'")
    ends = [check(end, needs_of(Operand.INTEGER), "an index") for end in (node.first, node.last)]
    known = [end for end in ends if end is not None]
    if array is None or len(known) < len(ends):
        return None
    return tree.Call("section", (array, *known), array.type, node.span)


def typed_elements(
    node: nodes.ArrayNode,
    check: Check,
    report: Report,
    expected: ExpectedType | None = None,
    place: str = "an element",
) -> tuple[list[tree.Expr], Type] | None:
    """The elements of ``[a, b, c]`` and their common type; None after a reported error.

    All have the type of the first if none is ``expected``. ``place`` is a text for messages.
    """
    elements: list[tree.Expr] = []
    for element in node.elements:
        if isinstance(element, nodes.DataObjectNode):
            report.add("type-mismatch", element.span, _OF_LISTS)
            return None
        of_first = equal_to(elements[0].type) if elements and expected is None else ANY
        expr = check(element, expected or of_first, place)
        if expr is None:
            return None
        elements.append(expr)
    types = [expr.type for expr in elements]
    type_ = result_type(Result.NUMBER, types) if types and is_number(types[0]) else None
    return elements, type_ or (types[0] if types else IntegerType())


def typed_list(node: nodes.ArrayNode, check: Check, report: Report) -> tree.Literal | None:
    """``[0, 1, 2]`` as an array of constants of one type; None after a reported error."""
    elements = typed_elements(node, check, report)
    return None if elements is None else list_literal(node, *elements, report)


def list_literal(
    node: nodes.ArrayNode, elements: Sequence[tree.Expr], type_: Type, report: Report
) -> tree.Literal | None:
    """The array of these elements; None after a reported error."""
    values = [evaluation.constant(element) for element in elements]
    for element, value in zip(node.elements, values, strict=True):
        if value is None:
            report.add("type-mismatch", element.span, _OF_LISTS)
            return None
    return tree.Literal(cast(Value, tuple(values)), ArrayType(type_), node.span)


_OF_LISTS = "the elements of an array are constants of a basic type here"
