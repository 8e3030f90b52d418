"""Expressions: one element of the grammar that reads them without recursion.

pyparsing's ``infix_notation`` tries every level of precedence for every operand and recurses for
each parenthesis. This element keeps operands and pending operators on two lists instead, so the
cost is linear and no text can exhaust the stack.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal, cast

from pyparsing import ParseException, ParserElement, ParseSyntaxException

from robosc.language.operators import BINARY, UNARY
from robosc.names import RESERVED
from robosc.source import Span
from robosc.syntax.elements import Fault, ModelText, skip_space, text_of
from robosc.syntax.keywords import NAME, is_declaration
from robosc.syntax.nodes import Access, BinaryNode, ExprNode, LiteralNode, Name, UnaryNode

__all__ = ["ACCESS", "MAX_DEPTH", "Expression", "make_access", "make_integer", "make_name"]

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

MAX_INTEGER = 2**64 - 1
"""The largest whole number of any ROS type (uint64)."""

ACCESS = rf"{NAME}(?:\s*\.\s*{NAME}|\s*\[\s*\d+\s*\])*"

# A name with a colon behind it is a property: the brace before it is missing.
_OPERAND = re.compile(
    rf"""\s*(?:
      (?P<access>(?!(?:true|false|and|or)\b){ACCESS}(?!\w|\s*:(?!=)))
    | (?P<number>\d\w*(?:\.\d\w*)?(?:(?<=[eE])[+-]\w+)?)
    | (?P<prefix>!(?!=)|-(?!>))
    | (?P<open>\()
    | (?P<boolean>(?:true|false)\b)
    | (?P<string>"[^"\\\n]*(?:\\.[^"\\\n]*)*"|'[^'\\\n]*(?:\\.[^'\\\n]*)*')
    )""",
    re.VERBOSE | re.ASCII,
)
_SPELLINGS = "|".join(
    rf"{o}\b" if o.isalpha() else re.escape(o) + ("(?!>)" if o == "-" else "")
    for o in sorted(BINARY, key=len, reverse=True)
)
_OPERATOR = re.compile(
    rf"\s*(?:(?P<close>\))|(?P<foreign>==|<>|=<|=/=)|(?P<operator>{_SPELLINGS})|(?P<stray>[.\[]))",
    re.ASCII,
)
_PART = re.compile(rf"({NAME})|(\d+)", re.ASCII)
_DOUBLE = re.compile(r"\d+(?:\.\d+)?(?:[eE][+-]?\d+)?", re.ASCII)

_FOREIGN = {"==": "=", "<>": "!=", "=/=": "!=", "=<": "<="}

_PREFIX_STRENGTH = UNARY["!"].level


def make_name(text: ModelText, start: int, end: int, found: str) -> Name:
    """A name; a reserved word without its escape is reported and taken all the same."""
    if found in RESERVED:
        hint = f"write '^{found}'"
        text.report("reserved-name", f"'{found}' is a keyword everywhere", start, end, hint)
    return Name(found.removeprefix("^"), span=Span(text.source, start, end))


def make_access(text: ModelText, start: int, end: int, found: str) -> Access:
    span = Span(text.source, start, end)
    if found.isidentifier():
        return Access(Name(found, span=span), (), span=span)
    parts: list[Name | int] = []
    for match in _PART.finditer(found):
        at = start + match.start()
        if match.group(1) is None:
            parts.append(make_integer(text, at, start + match.end(), match.group()))
        elif not parts:
            at_end = start + match.end()
            root = Name(match.group().removeprefix("^"), span=Span(text.source, at, at_end))
            parts.append(root)
        else:
            parts.append(make_name(text, at, start + match.end(), match.group()))
    return Access(cast(Name, parts[0]), tuple(parts[1:]), span=span)


def make_integer(text: ModelText, start: int, end: int, found: str) -> int:
    """The value of digits with an optional sign; limited, as Python's own conversion is."""
    digits = found.lstrip("- \t\r\n").lstrip("0") or "0"
    if len(digits) > 20 or int(digits) > MAX_INTEGER:
        message = f"this number is too large: whole numbers go up to {MAX_INTEGER}"
        raise Fault(text, start, message, end=end, code="number-too-large")
    return -int(digits) if found.startswith("-") else int(digits)


def unquote(text: ModelText, start: int, found: str) -> str:
    """The text that a string literal at ``start`` stands for."""
    body = found[1:-1]
    if "\\" not in body:
        return body

    def replace(match: re.Match[str]) -> str:
        try:
            return {"n": "\n", "t": "\t", "\\": "\\", '"': '"', "'": "'"}[match.group(1)]
        except KeyError:
            at = start + 1 + match.start()
            message = f"'{match.group()}' is no escape"
            hint = r"there are \n \t \\ \" \'"
            raise Fault(text, at, message, end=at + 2, code="bad-escape", hint=hint) from None

    return re.sub(r"\\(.)", replace, body)


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

    def __init__(self, text: ModelText) -> None:
        self.text = text
        self.operands: list[_Operand] = []
        self.pending: list[_Pending] = []
        self.open: list[int] = []

    def operand(self, node: ExprNode, start: int, end: int) -> None:
        self.operands.append(_Operand(node, start, end))

    def prefix(self, symbol: str, at: int) -> None:
        self._wait(_Pending(symbol, _PREFIX_STRENGTH, at))

    def parenthesis(self, at: int) -> None:
        if len(self.open) >= MAX_DEPTH:
            raise self._too_deep(at)
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
            if pending.strength == _PREFIX_STRENGTH:
                self.operands.append(self._unary(pending, self._finished(right)))
            elif pending.symbol in ("and", "or"):
                self.operands.append(self._chain(pending, self.operands.pop(), right))
            else:
                left = self._finished(self.operands.pop())
                right = self._finished(right)
                self.operands.append(self._binary(pending.symbol, pending.at, left, right))

    def _unary(self, pending: _Pending, operand: _Operand) -> _Operand:
        assert operand.node is not None
        span = Span(self.text.source, pending.at, operand.end)
        node = UnaryNode(cast(Literal["!", "-"], pending.symbol), operand.node, span=span)
        depth, nesting = operand.depth + 1, operand.nesting + 1
        return self._limited(_Operand(node, pending.at, operand.end, depth, nesting), pending.at)

    def _binary(self, symbol: str, at: int, left: _Operand, right: _Operand) -> _Operand:
        assert left.node is not None and right.node is not None
        source = self.text.source
        node = BinaryNode(
            symbol,
            left.node,
            right.node,
            operator_span=Span(source, at, at + len(symbol)),
            span=Span(source, left.start, right.end),
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
        message = f"this expression is nested more than {limit} levels deep"
        return Fault(self.text, at, message, end=at + 1, code="too-deep", hint="split it")


def _is_bracketed(left: _Operand, symbol: str) -> bool:
    """Whether a left operand is written in brackets, as a call for a division is."""
    if symbol == "/" or not isinstance(left.node, BinaryNode):
        return symbol == "/"
    return symbol == "=>" or BINARY[left.node.operator].level != BINARY[symbol].level


class Expression(ParserElement):
    """An expression; ``expected`` says in the user's words what is missing where none begins."""

    def __init__(self, expected: str) -> None:
        super().__init__()
        self._expected = expected
        self.errmsg = f"expected {expected}"
        self.mayIndexError = False

    def _generateDefaultName(self) -> str:
        return self._expected

    def parseImpl(self, instring: str, loc: int, do_actions: bool = True) -> Any:
        text = text_of(instring)
        builder = _Builder(text)
        expected = self._expected
        while True:
            match = _OPERAND.match(text, loc)
            kind = match.lastgroup or "" if match else ""
            found = match.group(kind) if match else ""
            if match is None or is_declaration(text, match.start(kind), found):
                # Once something was read there is no other rule to try.
                failure = ParseException if expected is self._expected else ParseSyntaxException
                raise failure(text, skip_space(text, loc), f"expected {expected}", self)
            start, loc = match.span(kind)
            if kind == "prefix":
                builder.prefix(found, start)
                expected = f"a value after '{found}'"
                continue
            if kind == "open":
                builder.parenthesis(start)
                expected = "an expression after '('"
                continue
            builder.operand(_leaf(text, kind, start, loc, found), start, loc)
            loc, symbol = _after_operand(builder, loc)
            if not symbol:
                return loc, [builder.finish()]
            expected = f"a value after '{symbol}'"


def _after_operand(builder: _Builder, loc: int) -> tuple[int, str]:
    """Close parentheses and take the next binary operator; none: the expression ends at ``loc``."""
    text = builder.text
    while True:
        match = _OPERATOR.match(text, loc)
        kind = match.lastgroup if match else None
        if match and kind == "operator":
            symbol = match.group("operator")
            builder.operator(symbol, match.start("operator"))
            return match.end(), symbol
        if match and kind == "foreign":
            raise _foreign(text, match.start("foreign"), match.group("foreign"))
        if match and kind == "stray" and not text.startswith("..", match.start("stray")):
            raise _stray(text, match.start("stray"))
        if match and kind == "close" and builder.open:
            loc = match.end()
            builder.close(loc)
            continue
        if builder.open:
            opened = text.source.position(builder.open[-1])
            message = f"expected an operator, or ')' to close the '(' of {opened[0]}:{opened[1]}"
            raise Fault(text, skip_space(text, loc), message)
        return loc, ""


def _foreign(text: ModelText, at: int, found: str) -> Fault:
    hint = f"write '{_FOREIGN[found]}'"
    return Fault(text, at, f"'{found}' is no operator", end=at + len(found), hint=hint)


def _stray(text: ModelText, at: int) -> Fault:
    if text[at] == ".":
        return Fault(text, at + 1, "expected a name after '.'")
    return Fault(text, at + 1, "expected a whole number in '[…]'", hint="an index is a literal")


def _leaf(text: ModelText, kind: str, start: int, end: int, found: str) -> ExprNode:
    if kind == "access":
        return make_access(text, start, end, found)
    span = Span(text.source, start, end)
    if kind == "boolean":
        return LiteralNode(found == "true", span=span)
    if kind == "string":
        return LiteralNode(unquote(text, start, found), span=span)
    if found.isdigit():
        return LiteralNode(make_integer(text, start, end, found), span=span)
    if not _DOUBLE.fullmatch(found):
        message = f"'{found[:40]}' is no number"
        hint = "numbers look like 42, 4.25 or 1e-3"
        raise Fault(text, start, message, end=end, code="bad-number", hint=hint)
    number = float(found)
    if number == float("inf"):
        message = "this number is too large for a double"
        raise Fault(text, start, message, end=end, code="number-too-large")
    return LiteralNode(number, span=span)
