"""Mutants of a generated controller: one small fault each in its guards, data, rules, updates or
preferences."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

__all__ = ["Mutant", "mutants"]

_SWAPPED: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_NOT_MUTATED = ("__init__", "components", "variables", "copy")


@dataclass(frozen=True)
class Mutant:
    """A faulty controller: its source, what kind of fault it has, where, and the line before and
    after."""

    source: str
    kind: str
    method: str
    before: str
    after: str


def mutants(source: str) -> Iterator[Mutant]:
    """Yield the mutants of a controller's source in the order of its lines."""
    tree = ast.parse(source)
    for function in _functions(tree):
        for parent, field, index, node in _places(function):
            line = _line(source, node)
            for replacement in _replacements(node, parent):
                _put(parent, field, index, replacement)
                ast.fix_missing_locations(tree)
                after = ast.unparse(replacement).partition("\n")[0]
                yield Mutant(
                    ast.unparse(tree), _kind(function.name), function.name, line, after
                )  # fmt: skip
                _put(parent, field, index, node)
    yield from _without_preferences(tree, source)


def _without_preferences(tree: ast.Module, source: str) -> Iterator[Mutant]:
    """One command at a time no longer yields to those that are preferred to it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "yields_to":
            preferred, node.value = node.value, ast.Tuple([], ast.Load())
            line = _line(source, preferred)
            yield Mutant(ast.unparse(tree), "preference", "COMMANDS", line, "yields_to=()")
            node.value = preferred


def _functions(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node
        elif isinstance(node, ast.ClassDef):
            for method in node.body:
                if not isinstance(method, ast.FunctionDef) or method.name in _NOT_MUTATED:
                    continue
                # What is told of a violated requirement has a test of its own, and decides nothing.
                if not method.name.startswith("failures_of_"):
                    yield method


def _kind(name: str) -> str:
    if name.startswith(("requirement_", "can_", "synchronises_", "partner_")):
        return "guard"
    if name.startswith("data_for_"):
        return "data"
    if name.startswith(("on_", "request_", "cancel_", "step_", "after_")):
        return "update"
    return "rule"


_Place = tuple[ast.AST, str, int | None, ast.AST]


def _places(function: ast.FunctionDef) -> Iterator[_Place]:
    """What may be replaced: parent, its field, the index in a list, and the node itself."""
    for parent in ast.walk(function):
        for field, value in ast.iter_fields(parent):
            if parent is function and field in ("args", "decorator_list"):
                continue
            if isinstance(value, list):
                for index, node in enumerate(value):
                    if isinstance(node, ast.AST):
                        yield parent, field, index, node
            elif isinstance(value, ast.AST):
                yield parent, field, None, value


def _put(parent: ast.AST, field: str, index: int | None, node: ast.AST) -> None:
    if index is None:
        setattr(parent, field, node)
    else:
        getattr(parent, field)[index] = node


def _replacements(node: ast.AST, parent: ast.AST) -> Iterator[ast.expr | ast.stmt]:
    match node:
        case ast.BoolOp(op=op, values=values):
            for index in range(len(values)):
                rest = values[:index] + values[index + 1 :]
                yield rest[0] if len(rest) == 1 else ast.BoolOp(op, rest)
        case ast.Compare(left=left, ops=[op], comparators=comparators):
            for other in _SWAPPED.get(type(op), ()):
                yield ast.Compare(left, [other()], comparators)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield operand
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int() | float() as number) if not isinstance(parent, ast.Subscript):
            yield from _shifted(number)
        case ast.Assign(targets=[ast.Attribute()]):
            yield ast.Pass()
        case ast.AugAssign(target=ast.Attribute() as target, op=ast.Add(), value=value):
            yield ast.Pass()
            yield ast.AugAssign(target, ast.Sub(), value)
        case ast.AugAssign(target=ast.Attribute() as target, op=ast.Sub(), value=value):
            yield ast.Pass()
            yield ast.AugAssign(target, ast.Add(), value)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield ast.BinOp(left, ast.Sub(), right)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            yield ast.BinOp(left, ast.Add(), right)
        case ast.Attribute(value=ast.Name(id="self")) if isinstance(parent, ast.BoolOp | ast.If):
            yield ast.UnaryOp(ast.Not(), node)


def _shifted(number: float) -> Iterator[ast.expr]:
    """A number that is a little wrong; -1 is written with a minus."""
    if isinstance(number, int):
        yield ast.Constant(number + 1)
        if number > 0:
            yield ast.Constant(number - 1)
    else:
        yield ast.Constant(round(number * 1.2 + 0.05, 6))


def _line(source: str, node: ast.AST) -> str:
    number = getattr(node, "lineno", None)
    return "" if number is None else source.splitlines()[number - 1].strip()
