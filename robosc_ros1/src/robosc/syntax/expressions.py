"""Expressions: one element of the grammar that reads them without recursion.

pyparsing's ``infix_notation`` tries every level of precedence for every operand and recurses for
each parenthesis. This element finds operands and operators in one loop instead, and two stacks put
them together, so the cost is linear and no text can exhaust the interpreter's stack.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

from pyparsing import Empty, ParseException, ParseSyntaxException

from robosc.language.operators import BINARY, UNARY
from robosc.language.tokens import (
    BAD_NUMBER,
    FOREIGN,
    INTEGER,
    NUMBER,
    STRING,
    kind_of,
    kinds_of,
    pattern,
)
from robosc.syntax.nodes import BinaryNode, ExprNode, LiteralNode, UnaryNode
from robosc.syntax.reading import Fault, Form, Reading, Stop
from robosc.syntax.values import make_access, make_number, make_string

__all__ = ["ACCESS", "MAX_DEPTH", "MAX_NESTING", "Expression"]

MAX_DEPTH = 200
"""Levels that the tree of an expression may have, so that later stages may recurse.

Chains of ``and`` or ``or`` do not count: long ones become balanced trees, which mean the same.
Arithmetic is not associative on doubles, so its chains stay as they are written.
"""

MAX_NESTING = 60
"""Levels of brackets that an expression may need.

The parser of Python 3.8 gives up at 90, and in generated code expressions are parts of longer ones.
"""

BALANCE_FROM = 64
"""Chains of ``and`` or ``or`` up to this length are left-associative trees as usual."""

ACCESS = "NAME (?: '.' WORD | '[' INTEGER ']' )*"

# A name with a colon behind it is a property: the brace before it is missing.
_OPERAND = re.compile(
    pattern(f"(?! true | false | and | or ) {ACCESS} (?! ':' ) | NUMBER | STRING | true | false")
)
_PREFIX = {kind_of(symbol): symbol for symbol in UNARY}
_INFIX = {kind: symbol for symbol in BINARY for kind in kinds_of(symbol)}
_FOREIGN = {kind_of(symbol): symbol for symbol in FOREIGN}
_BOOLEANS = frozenset((*kinds_of("true"), *kinds_of("false")))
_OPEN, _CLOSE = kind_of("("), kind_of(")")

_PREFIX_LEVEL = UNARY["!"].level


@dataclass(slots=True)
class _Operand:
    """A finished operand, or the parts of a chain of ``and`` or ``or`` that may still grow.

    ``start`` and ``end`` include parentheses, ``depth`` is the height of the tree, ``nesting`` the
    brackets that stand within each other when it is written as Python, at the most.
    """

    node: ExprNode | None
    start: int
    end: int
    depth: int = 1
    nesting: int = 0
    chain: str = ""
    parts: list[_Operand] | None = None
    joints: list[int] | None = None


@dataclass(frozen=True, slots=True)
class _Pending:
    """An operator that waits for its right side; an opening parenthesis has no strength."""

    symbol: str
    strength: int
    at: int


class _Builder:
    """Operator precedence with two stacks."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading
        self.operands: list[_Operand] = []
        self.pending: list[_Pending] = []
        self.open: list[int] = []

    def operand(self, node: ExprNode, start: int, end: int) -> None:
        self.operands.append(_Operand(node, start, end))

    def prefix(self, symbol: str, at: int) -> None:
        self._wait(_Pending(symbol, _PREFIX_LEVEL, at))

    def parenthesis(self, at: int) -> None:
        self.open.append(at)
        self.pending.append(_Pending("(", 0, at))

    def close(self, end: int) -> None:
        self._reduce(1)
        start = self.pending.pop().at
        self.open.pop()
        inner = self._finished(self.operands.pop())
        self.operands.append(_Operand(inner.node, start, end, inner.depth, inner.nesting))

    def operator(self, symbol: str, at: int) -> None:
        operation = BINARY[symbol]
        # What binds as tightly is reduced first, except for a right-associative one.
        self._reduce(operation.level + operation.right_associative)
        self._wait(_Pending(symbol, operation.level, at))

    def finish(self) -> ExprNode:
        self._reduce(1)
        node = self._finished(self.operands.pop()).node
        assert node is not None
        return node

    def _wait(self, pending: _Pending) -> None:
        # Whatever waits for its right side will stand above all that comes behind it.
        if len(self.pending) - len(self.open) >= MAX_DEPTH:
            raise self._too_deep(pending.at)
        self.pending.append(pending)

    def _reduce(self, strength: int) -> None:
        """Apply all pending operators at least that strong, back to the last parenthesis."""
        while self.pending and self.pending[-1].strength >= strength:
            pending = self.pending.pop()
            right = self.operands.pop()
            if pending.strength == _PREFIX_LEVEL:
                self.operands.append(self._unary(pending, self._finished(right)))
            elif pending.symbol in ("and", "or"):
                self.operands.append(self._chain(pending, self.operands.pop(), right))
            else:
                left = self._finished(self.operands.pop())
                right = self._finished(right)
                self.operands.append(self._binary(pending.symbol, pending.at, left, right))

    def _unary(self, pending: _Pending, operand: _Operand) -> _Operand:
        assert operand.node is not None
        span = self.reading.span(pending.at, operand.end)
        node = UnaryNode(cast(Literal["!", "-"], pending.symbol), operand.node, span=span)
        depth, nesting = operand.depth + 1, operand.nesting + 1
        return self._limited(_Operand(node, pending.at, operand.end, depth, nesting), pending.at)

    def _binary(self, symbol: str, at: int, left: _Operand, right: _Operand) -> _Operand:
        assert left.node is not None and right.node is not None
        node = BinaryNode(
            symbol,
            left.node,
            right.node,
            operator_span=self.reading.span(at, at + 1),
            span=self.reading.span(left.start, right.end),
        )
        depth = 1 + max(left.depth, right.depth)
        nesting = max(left.nesting + _is_bracketed(left, symbol), right.nesting + 1)
        return self._limited(_Operand(node, left.start, right.end, depth, nesting), at)

    def _chain(self, pending: _Pending, left: _Operand, right: _Operand) -> _Operand:
        right = self._finished(right)
        if left.chain == pending.symbol:
            assert left.parts is not None and left.joints is not None
            left.parts.append(right)
            left.joints.append(pending.at)
            left.end = right.end
            return left
        parts = [self._finished(left), right]
        return _Operand(None, left.start, right.end, 1, 0, pending.symbol, parts, [pending.at])

    def _finished(self, operand: _Operand) -> _Operand:
        if operand.parts is None or operand.joints is None:
            return operand
        return self._fold(operand.chain, operand.parts, operand.joints)

    def _fold(self, symbol: str, parts: list[_Operand], joints: list[int]) -> _Operand:
        if len(parts) <= BALANCE_FROM:
            result = parts[0]
            for at, part in zip(joints, parts[1:], strict=True):
                result = self._binary(symbol, at, result, part)
            return result
        half = len(parts) // 2
        left = self._fold(symbol, parts[:half], joints[: half - 1])
        right = self._fold(symbol, parts[half:], joints[half:])
        return self._binary(symbol, joints[half - 1], left, right)

    def _limited(self, operand: _Operand, at: int) -> _Operand:
        if operand.depth > MAX_DEPTH:
            raise self._too_deep(at)
        if operand.nesting > MAX_NESTING:
            raise self._too_deep(at, MAX_NESTING)
        return operand

    def _too_deep(self, at: int, limit: int = MAX_DEPTH) -> Fault:
        return Fault(at, _nested_too_deep(limit), code="too-deep", hint=_SPLIT)


def _is_bracketed(left: _Operand, symbol: str) -> bool:
    """Whether a left operand is written in brackets, as a call for a division is."""
    if symbol == "/" or not isinstance(left.node, BinaryNode):
        return symbol == "/"
    return symbol == "=>" or BINARY[left.node.operator].level != BINARY[symbol].level


_Step: TypeAlias = tuple[Literal["operand", "prefix", "open", "close", "operator"], int, int, str]
"""A token or operand of an expression: its extent, and the spelling of an operator."""


class Expression(Empty):
    """An expression; ``expected`` says in the user's words what is missing where none begins."""

    def __init__(self, expected: str) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self.leave_whitespace()
        self.set_name(expected)
        self._expected = expected

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        steps: list[_Step] = []
        opened: list[int] = []
        expected = self._expected
        start = loc
        while True:
            match = _OPERAND.match(instring, loc)
            kind = instring[loc : loc + 1]
            if match:
                steps.append(("operand", loc, match.end(), ""))
                loc, symbol = _after_operand(instring, match.end(), steps, opened)
                if not symbol:
                    return loc, [Form(_build, start, loc, [start, steps])]
                expected = f"a value after '{symbol}'"
            elif kind in _PREFIX:
                steps.append(("prefix", loc, loc + 1, _PREFIX[kind]))
                expected = f"a value after '{_PREFIX[kind]}'"
                loc += 1
            elif kind == _OPEN:
                if len(opened) >= MAX_DEPTH:
                    raise Stop(instring, loc, _nested_too_deep(), code="too-deep", hint=_SPLIT)
                opened.append(loc)
                steps.append(("open", loc, loc + 1, ""))
                expected = "an expression after '('"
                loc += 1
            else:
                # Once something was read there is no other rule to try.
                failure = ParseSyntaxException if steps else ParseException
                raise failure(instring, loc, f"expected {expected}", self)


def _after_operand(kinds: str, loc: int, steps: list[_Step], opened: list[int]) -> tuple[int, str]:
    """Close parentheses and take the next binary operator; none: the expression ends at ``loc``."""
    while True:
        kind = kinds[loc : loc + 1]
        if kind in _INFIX:
            steps.append(("operator", loc, loc + 1, _INFIX[kind]))
            return loc + 1, _INFIX[kind]
        if kind == _CLOSE and opened:
            opened.pop()
            loc += 1
            steps.append(("close", loc - 1, loc, ""))
            continue
        if kind in _FOREIGN:
            found = _FOREIGN[kind]
            raise Stop(kinds, loc, f"'{found}' is no operator", hint=f"write '{FOREIGN[found]}'")
        if kind == ".":
            raise Stop(kinds, loc + 1, "expected a name after '.'")
        if kind == "[":
            message = "expected a whole number in '[…]'"
            raise Stop(kinds, loc + 1, message, hint="an index is a literal")
        if opened:
            message = "expected an operator, or ')' to close the '('"
            raise Stop(kinds, loc, message, opened=opened[-1])
        return loc, ""


def _build(reading: Reading, start: int, end: int, parts: list[Any]) -> ExprNode:
    """The tree of an expression from its steps, whose places count from ``first``."""
    first, steps = parts
    base = start - first
    builder = _Builder(reading)
    for what, begin, stop, symbol in steps:
        at = base + begin
        if what == "operand":
            builder.operand(_leaf(reading, at, base + stop), at, base + stop)
        elif what == "operator":
            builder.operator(symbol, at)
        elif what == "prefix":
            builder.prefix(symbol, at)
        elif what == "open":
            builder.parenthesis(at)
        else:
            builder.close(at + 1)
    return builder.finish()


def _leaf(reading: Reading, start: int, end: int) -> ExprNode:
    kind = reading.kind(start)
    if kind in _BOOLEANS:
        return LiteralNode(reading.text(start) == "true", span=reading.span(start, end))
    if kind == STRING:
        return LiteralNode(make_string(reading, start), span=reading.span(start, end))
    if kind in (INTEGER, NUMBER, BAD_NUMBER):
        return LiteralNode(make_number(reading, start), span=reading.span(start, end))
    return make_access(reading, start, end, [])


_SPLIT = "split it"


def _nested_too_deep(limit: int = MAX_DEPTH) -> str:
    return f"this expression is nested more than {limit} levels deep"
