"""Expressions as Python text: what generated controllers and compiled steps evaluate."""

from __future__ import annotations

from collections.abc import Callable

from robosc.expr import tree, types
from robosc.expr.traversal import fold, may_be_undefined, walk
from robosc.language.operators import PYTHON_ATOM, Spelled


def may_be_huge(expr: tree.Expr) -> bool:
    """Whether this is an integer that may be too large for a double.

    Received integers have at most 64 bits, so that takes a variable without a range, or a product
    of more than twelve factors.
    """
    if not isinstance(expr.type, types.IntegerType):
        return False
    parts = list(walk(expr))
    factors = sum(isinstance(part, tree.Binary) and part.operator == "*" for part in parts)
    return factors > 12 or any(
        isinstance(part, tree.VariableRef) and part.type == types.IntegerType() for part in parts
    )


def to_python(
    expr: tree.Expr,
    leaf: Callable[[tree.Leaf], str],
    literal: Callable[[tree.Literal], str] = lambda node: repr(node.value),
    convert: Callable[[types.EnumType, str], str] | None = None,
    part: Callable[[tree.Part, str], str] | None = None,
) -> str:
    """Return the expression as Python source.

    ``leaf``, ``literal``, ``convert`` and ``part`` give the texts of these nodes.

    Division is written ``divide(a, b)``, and an integer that may be too large for the other
    operand, a double, ``widen(a)``: the namespace of the text must have the functions of
    ``HELPERS``. Texts of nodes that are not atomic (``a == b``) must include their parentheses.
    """

    def of_leaf(node: tree.Literal | tree.Leaf) -> Spelled:
        if not isinstance(node, tree.Literal):
            return Spelled(leaf(node), PYTHON_ATOM)
        spelled = literal(node)
        return Spelled(spelled, PYTHON_ATOM - spelled.startswith("-"))

    def of_operation(node: tree.Operation, operands: tuple[Spelled, ...]) -> Spelled:
        operation = node.operation
        if isinstance(node, tree.Convert):
            assert convert is not None
            return Spelled(convert(node.type, operands[0].text), PYTHON_ATOM)
        if isinstance(node, tree.Part):
            assert part is not None
            return Spelled(part(node, operands[0].text), PYTHON_ATOM)
        if isinstance(node, tree.Made):
            parts = [text.text for text in operands]
            names = [literal(tree.Literal(name, types.StringType())) for name in node.names]
            named = [f"{n}: {p}" for n, p in zip(names, parts, strict=False)]
            listed = f"{{{', '.join(named)}}}" if named else f"[{', '.join(parts)}]"
            return Spelled(listed, PYTHON_ATOM)
        if isinstance(node.type, types.DoubleType) and operation.python.level < PYTHON_ATOM:
            operands = tuple(
                Spelled(f"widen({text.text})", PYTHON_ATOM) if may_be_huge(part) else text
                for part, text in zip(node.operands, operands, strict=True)
            )
        return operation.python.of(operands)

    return fold(expr, of_leaf, of_operation, bound=_through_array).text


def _through_array(
    node: tree.Aggregate, array: Spelled, visit: Callable[[tree.Expr], Spelled]
) -> Spelled:
    """Return an aggregate as a function of a list comprehension without undefined elements."""
    name, items, of_pair = element_name(node.variable), array.text, "{}"
    if node.position:
        name = f"{element_name(node.position)}, {name}"
        items, of_pair = f"enumerate({items})", "spread({})"
    element = visit(node.element)
    condition = None if node.condition is None else visit(node.condition).text
    if condition is not None and node.condition is not None and may_be_undefined(node.condition):
        test = of_pair.format(f"lambda {name}: {condition}")
        items, condition = f"where({test}, {items})", None
    kept = "" if condition is None else f" if {condition}"
    if may_be_undefined(node.element) and not node.makes_array:
        chosen = f"[({name}) for {name} in {items}{kept}]" if kept else items
        results = f"defined({of_pair.format(f'lambda {name}: {element.text}')}, {chosen})"
    elif element.text == name and not kept and not node.makes_array:
        results = items
    else:
        results = f"[{element.text} for {name} in {items}{kept}]"
    return node.operation.python.of([Spelled(results, PYTHON_ATOM)])


def element_name(variable: str) -> str:
    """Return the Python name of an aggregate's variable: no keyword, no name of the runtime."""
    return f"{variable}_"
