"""Traversal of expressions: folds, substitution of leaves, iteration over parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from operator import is_
from typing import TypeVar

from robosc.expr import tree, types
from robosc.source import Span

T = TypeVar("T")


def fold(
    expr: tree.Expr,
    leaf: Callable[[tree.Literal | tree.Leaf], T],
    strict: Callable[[tree.Operation, tuple[T, ...]], T],
    lazy: Callable[[tree.Binary, T, Callable[[], T]], T] | None = None,
    known: Callable[[tree.Expr], T | None] | None = None,
    bound: Callable[[tree.Aggregate, T, Callable[[tree.Expr], T]], T] | None = None,
    total: Callable[[Callable[[], T]], T] | None = None,
    otherwise: Callable[[Callable[[], T], Callable[[], T]], T] | None = None,
) -> T:
    """The result for an expression, computed bottom-up from the results for its parts.

    ``leaf`` is called for leaves, ``strict`` for operations with the results for all operands, in
    order. ``lazy`` is called for operators that may not evaluate their right operand, with the
    result for the left and a function that computes that for the right; without it they are strict.
    ``known`` may return the result for a part, whose operands are then not visited. ``bound`` is
    called for an aggregate with the result for its array, and a function that computes those for
    its element and condition, once or for each element of the array; without it these are operands
    like others. ``total`` is called for ``Holds`` with a function that computes the result for its
    operand, and ``otherwise`` for ``else`` with such functions for both operands; without them
    these are strict.
    """

    def visit(node: tree.Expr) -> T:
        if known is not None:
            found = known(node)
            if found is not None:
                return found
        if isinstance(node, tree.Binary):
            if otherwise is not None and node.operator == "else":
                return otherwise(lambda: visit(node.left), lambda: visit(node.right))
            left = visit(node.left)
            if lazy is not None and node.operation.decider is not None:
                return lazy(node, left, lambda: visit(node.right))
            return strict(node, (left, visit(node.right)))
        if bound is not None and isinstance(node, tree.Aggregate):
            return bound(node, visit(node.array), visit)
        if total is not None and isinstance(node, tree.Holds):
            return total(lambda: visit(node.operand))
        if isinstance(node, tree.Operation):
            return strict(node, tuple(visit(operand) for operand in node.operands))
        return leaf(node)

    return visit(expr)


def rewritten(expr: tree.Expr, leaf: Callable[[tree.Literal | tree.Leaf], tree.Expr]) -> tree.Expr:
    """The expression with every leaf replaced; parts that it shares are rewritten once, and stay
    shared: a count is expanded into twenty times as many parts as there are different ones."""
    found: dict[int, tree.Expr] = {}

    def operation(node: tree.Operation, operands: tuple[tree.Expr, ...]) -> tree.Expr:
        made = found[id(node)] = with_operands(node, operands)
        return made

    return fold(expr, leaf, operation, known=lambda node: found.get(id(node)))


def with_operands(node: tree.Operation, operands: tuple[tree.Expr, ...]) -> tree.Expr:
    """The operation on other operands; itself if they are the same.

    So what is known of a shared part of a large condition is known after it was rewritten, too.
    """
    if all(map(is_, operands, node.operands)):
        return node
    match node:
        case tree.Unary():
            return replace(node, operand=operands[0])
        case tree.Binary():
            return replace(node, left=operands[0], right=operands[1])
        case tree.Call():
            return replace(node, operands=operands)
        case tree.Convert():
            return replace(node, argument=operands[0])
        case tree.Part():
            return part_of(operands[0], node.path, node.type, node.span)
        case tree.Made():
            return replace(node, operands=operands)
        case tree.Holds():
            return replace(node, operand=operands[0])
        case tree.Aggregate():
            array, element, *condition = operands
            return replace(
                node, array=array, element=element, condition=condition[0] if condition else None
            )


def part_of(
    whole: tree.Expr, path: tuple[str | int, ...], type_: types.Type, span: Span | None = None
) -> tree.Expr:
    """The part of an expression's value at a path, as a single node where possible."""
    match whole:
        case tree.ChoiceRef():
            return tree.Part(whole, path, type_, span)
        case tree.ValueRef(path=before):
            return tree.ValueRef((*before, *path), type_, span, whole.optional)
        case tree.Part(operand=operand, path=before):
            return tree.Part(operand, (*before, *path), type_, span)
        case tree.Made() if (
            part := _part_of_made(whole, path[0], type_, len(path) > 1)
        ) is not None:
            return part_of(part, path[1:], type_, span) if path[1:] else part
    return tree.Part(whole, path, type_, span)


def _part_of_made(
    made: tree.Made, first: str | int, type_: types.Type, further: bool
) -> tree.Expr | None:
    """What stands in an object or array at one place; of an object, what is not named is what a
    message begins with. None: it is not known before it runs."""
    if isinstance(first, int):
        return made.operands[first] if first < len(made.operands) else None
    if first in made.names:
        return made.operands[made.names.index(first)]
    inner = made.type.property(first) if isinstance(made.type, types.ObjectType) else None
    if isinstance(inner, types.ObjectType) and (further or inner == type_):
        return tree.Made((), (), inner)
    zero = _ZEROS.get(type(inner))
    return None if inner is None or zero is None else tree.Literal(zero, inner)


_ZEROS: dict[type, bool | int | float | str] = {
    types.BooleanType: False,
    types.IntegerType: 0,
    types.DoubleType: 0.0,
    types.StringType: "",
}


def without_last(part: tree.Expr) -> tree.Expr | None:
    """The object of which an expression reads a field; None if it reads none."""
    match part:
        case tree.ValueRef(path=(*before, str())) | tree.ElementRef(path=(*before, str())):
            return replace(part, path=tuple(before))
        case tree.Part(operand=operand, path=(*before, str())):
            return replace(part, path=tuple(before)) if before else operand
    return None


def may_be_undefined(expr: tree.Expr) -> bool:
    """Whether an expression can be undefined: it reads optional data or an array's element."""
    stack = [expr]
    while stack:
        part = stack.pop()
        match part:
            case tree.Holds():
                continue
            case tree.Binary(operator="else", right=right):
                stack.append(right)
                continue
            case tree.VariableRef(type=types.ArrayType() | types.ObjectType()):
                return True  # it may hold nothing yet
            case tree.ValueRef(optional=True):
                return True
            case tree.ValueRef(path=path) | tree.ElementRef(path=path) | tree.Part(path=path) if (
                not all_names(path)
            ):
                return True
            case tree.Call(operator="element") | tree.Aggregate(operator="min" | "max" | "first"):
                return True
        if isinstance(part, tree.Operation):
            stack.extend(part.operands)
    return False


def all_names(path: tuple[str | int, ...]) -> bool:
    """Whether a path leads through no array."""
    return all(isinstance(part, str) for part in path)


def walk(
    expr: tree.Expr, inside: Callable[[tree.Expr], bool] = lambda node: True
) -> Iterator[tree.Expr]:
    """The expression and all its parts, in source order, without recursion.

    The operands of a part are visited only if ``inside`` returns True for it.
    """
    stack = [expr]
    while stack:
        node = stack.pop()
        yield node
        if isinstance(node, tree.Operation) and inside(node):
            stack.extend(reversed(node.operands))


def walk_all(exprs: Iterable[tree.Expr]) -> Iterator[tree.Expr]:
    """All parts of several expressions; shared parts (by identity) are visited once."""
    seen: dict[int, tree.Expr] = {}  # keeps them alive, so that no identity is used again
    for expr in exprs:
        stack = [expr]
        while stack:
            node = stack.pop()
            if id(node) not in seen:
                seen[id(node)] = node
                yield node
                if isinstance(node, tree.Operation):
                    stack.extend(reversed(node.operands))


def parameters_of(expr: tree.Expr) -> Iterator[tree.RosParameter]:
    """The parameters that an expression reads, also in tests and in the rules of enums."""
    for part in walk(expr):
        match part:
            case tree.ParameterRef(parameter=parameter):
                yield parameter
            case tree.ChoiceRef(test=tree.TestRef() as test) | (tree.TestRef() as test):
                for side in test.sides:
                    yield from parameters_of(side)
            case (
                tree.Convert(type=enum)
                | tree.ValueRef(type=types.EnumType() as enum)
                | tree.Part(type=types.EnumType() as enum)
                | tree.ElementRef(type=types.EnumType() as enum)
            ):
                for rule in enum.rules:
                    yield from parameters_of(tree.condition_of(rule))


def reads_value(expr: tree.Expr) -> bool:
    """Whether an expression reads the received value."""
    return any(isinstance(part, tree.ValueRef) for part in walk(expr))


def path_text(path: tuple[str | int, ...]) -> str:
    """The text of a path for users: ``pose.x``, ``ranges[0]``; empty for the whole value."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def operands(expr: tree.Expr, operator: str) -> list[tree.Expr]:
    """The operands of a chain of one operator; the expression alone if it is none."""
    found, left = [], [expr]
    while left:
        part = left.pop()
        if isinstance(part, tree.Binary) and part.operator == operator:
            left += (part.right, part.left)
        else:
            found.append(part)
    return found


def within(expr: tree.Expr, type_: types.Type) -> bool:
    """Whether a value assigned to a variable of this type is surely in its range."""
    if not (isinstance(type_, types.IntegerType) and type_.bounds):
        return True
    low, high = type_.bounds
    match expr:
        case tree.Literal(value=int(value)):
            return low <= value <= high
        case tree.VariableRef() | tree.ValueRef() | tree.ParameterRef() if isinstance(
            expr.type, types.IntegerType
        ):
            bounds = expr.type.bounds
            return bounds is not None and low <= bounds[0] and bounds[1] <= high
    return False
