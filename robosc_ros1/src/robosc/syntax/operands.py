"""Operator-precedence parsing: the tree of an expression from its steps, with two stacks."""

from __future__ import annotations

from dataclasses import field
from typing import Any, Literal, TypeAlias, cast

from robosc import limits, source
from robosc.language import tokens
from robosc.language.operators import BINARY, PYTHON_ATOM, UNARY
from robosc.lazy_dataclasses import dataclass
from robosc.syntax import leaves, nodes
from robosc.syntax.parse_state import Fault, ParseState

BALANCE_FROM = 64
"""Chains of ``and`` or ``or`` up to this length are left-associative, longer ones balanced."""

Step: TypeAlias = tuple[
    Literal["operand", "prefix", "operator", "open", "close", "comma", "for", "parts"],
    int,
    int,
    str,
]
"""A token or bracket of an expression: kind, range of tokens, and operator or kind of bracket.

``comma`` is any separator within a bracket: also ``..`` and the ``if`` of an aggregate.
"""

_BOOLEANS = frozenset((*tokens.kinds_of("true"), *tokens.kinds_of("false")))
_NUMBERS = (tokens.INTEGER, tokens.NUMBER, tokens.BAD_NUMBER)
_PREFIX_LEVEL = UNARY["!"].level


@dataclass(slots=True)
class _Operand:
    """A finished operand, or the parts of a chain of ``and`` or ``or`` that may still grow.

    ``start`` and ``end`` (tokens) include parentheses, ``depth`` is the height of the tree, and
    ``nesting`` the greatest number of nested brackets when it is written as Python. ``joints`` are
    the tokens of the operators between ``parts``.
    """

    node: nodes.ExprNode | None
    start: int
    end: int
    depth: int = 1
    nesting: int = 0
    chain: str = ""
    parts: list[_Operand] | None = None
    joints: list[int] | None = None


@dataclass(frozen=True, slots=True)
class _Pending:
    """An operator that waits for its right operand; an opening bracket has level -1."""

    symbol: str
    level: int
    at: int


@dataclass(slots=True)
class _Bracket:
    """An open bracket and its parts so far.

    ``start`` (a token) includes the function that is called, or the array that is indexed, which
    is ``base``. ``count`` is the number of operands on the stack when it was opened.
    """

    what: str
    start: int
    end: int
    base: _Operand | None
    count: int
    parts: list[_Operand] = field(default_factory=list)
    names: list[nodes.Name] = field(default_factory=list)


class _Builder:
    """Builds the tree from steps: a stack of operands and one of pending operators."""

    def __init__(self, reading: ParseState) -> None:
        self.reading = reading
        self.operands: list[_Operand] = []
        self.pending: list[_Pending] = []
        self.brackets: list[_Bracket] = []

    def operand(self, node: nodes.ExprNode, start: int, end: int) -> None:
        self.operands.append(_Operand(node, start, end))

    def prefix(self, symbol: str, at: int) -> None:
        self._wait(_Pending(symbol, _PREFIX_LEVEL, at))

    def open(self, what: str, start: int, end: int) -> None:
        base = None
        if what == "set":
            self._reduce(BINARY["="].level)
        if what in ("set", "index", "called"):
            base = self._finished(self.operands.pop())
            start = base.start
        self.brackets.append(_Bracket(what, start, end, base, len(self.operands)))
        self.pending.append(_Pending("(", -1, start))

    def comma(self) -> None:
        """Finish one part of the open bracket."""
        self._reduce(0)
        self.brackets[-1].parts.append(self._finished(self.operands.pop()))

    def bind(self, names: list[nodes.Name]) -> None:
        """Make the open bracket an aggregate with this variable, or a position and a variable."""
        self.comma()
        self.brackets[-1].names = names

    def close(self, end: int) -> None:
        self._reduce(0)
        bracket = self.brackets.pop()
        self.pending.pop()
        if len(self.operands) > bracket.count:
            bracket.parts.append(self._finished(self.operands.pop()))
        if bracket.what == "group":
            (inner,) = bracket.parts
            self.operands.append(
                _Operand(inner.node, bracket.start, end, inner.depth, inner.nesting)
            )
            return
        span = self.reading.span(bracket.start, end)
        self._put(_bracketed(self.reading, bracket, span), bracket, end)

    def _put(self, node: nodes.ExprNode, bracket: _Bracket, end: int) -> None:
        inside = [*bracket.parts, bracket.base] if bracket.base else bracket.parts
        depth = 1 + max((part.depth for part in inside), default=0)
        nesting = 1 + max((part.nesting for part in inside), default=0)
        operand = _Operand(node, bracket.start, end, depth, nesting)
        self.operands.append(self._limited(operand, bracket.start))

    def parts(self, start: int, end: int) -> None:
        """Add the path ``.x[0]`` behind an index or a call."""
        of = self.operands.pop()
        assert of.node is not None
        path = leaves.make_parts(self.reading, start, end)
        span = self.reading.span(of.start, end)
        node = nodes.MemberNode(of.node, path, span=span)
        self.operands.append(_Operand(node, of.start, end, of.depth, of.nesting))

    def operator(self, symbol: str, at: int) -> None:
        operation = BINARY[symbol]
        # Operators of the same level are reduced first, unless they are right-associative.
        self._reduce(operation.level + operation.right_associative)
        self._wait(_Pending(symbol, operation.level, at))

    def finish(self) -> nodes.ExprNode:
        self._reduce(0)
        node = self._finished(self.operands.pop()).node
        assert node is not None
        return node

    def _wait(self, pending: _Pending) -> None:
        # Each pending operator will be an ancestor of all that follows in the tree.
        if len(self.pending) - len(self.brackets) >= limits.EXPRESSION_DEPTH:
            raise self._too_deep(pending.at)
        self.pending.append(pending)

    def _reduce(self, level: int) -> None:
        """Apply the pending operators of at least this level, back to the last open bracket."""
        while self.pending and self.pending[-1].level >= level:
            pending = self.pending.pop()
            right = self.operands.pop()
            if pending.level == _PREFIX_LEVEL:
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
        node = nodes.UnaryNode(cast(Literal["!", "-"], pending.symbol), operand.node, span=span)
        depth, nesting = operand.depth + 1, operand.nesting + 1
        return self._limited(_Operand(node, pending.at, operand.end, depth, nesting), pending.at)

    def _binary(self, symbol: str, at: int, left: _Operand, right: _Operand) -> _Operand:
        assert left.node is not None and right.node is not None
        node = nodes.BinaryNode(
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
        if operand.depth > limits.EXPRESSION_DEPTH:
            raise self._too_deep(at)
        if operand.nesting > limits.EXPRESSION_NESTING:
            raise self._too_deep(at, limits.EXPRESSION_NESTING)
        return operand

    def _too_deep(self, at: int, limit: int = limits.EXPRESSION_DEPTH) -> Fault:
        return Fault(at, nested_too_deep(limit), code="too-deep", hint="split it")


def _is_bracketed(left: _Operand, symbol: str) -> bool:
    """Whether a left operand needs brackets in Python; some operators become a call."""
    is_call = BINARY[symbol].python.level == PYTHON_ATOM
    if is_call or not isinstance(left.node, nodes.BinaryNode):
        return is_call
    return symbol == "=>" or BINARY[left.node.operator].level != BINARY[symbol].level


def _member(node: nodes.ExprNode, at: int) -> nodes.Access:
    """The name ``Station[i-1].limit`` of a function; Fault at the token where it is none."""
    match node:
        case nodes.Access():
            return node
        case nodes.MemberNode(
            object=nodes.ElementNode(array=nodes.Access(root, ()), index=index), path=path
        ):
            return nodes.Access(root, path, index, span=node.span)
    raise Fault(at, "a function has a name: NAME(…), COMPONENT.NAME(…) or COMPONENT[i].NAME(…)")


def _bracketed(reading: ParseState, bracket: _Bracket, span: source.Span) -> nodes.ExprNode:
    """The node of a bracket other than a parenthesis."""
    operands = tuple(cast(nodes.ExprNode, part.node) for part in bracket.parts)
    base = bracket.base.node if bracket.base else None
    if bracket.names:
        function = leaves.make_name(reading, bracket.start, bracket.start + 1, [])
        condition = operands[2] if len(operands) > 2 else None
        *position, variable = bracket.names
        return nodes.AggregateNode(
            function, operands[0], variable, operands[1], condition, *position[:1], span=span
        )
    if bracket.what == "call":
        function_ = leaves.make_access(reading, bracket.start, bracket.end - 1, [])
        return nodes.CallNode(function_, operands, span=span)
    if bracket.what == "array":
        return nodes.ArrayNode(operands, span=span)
    assert base is not None
    if bracket.what == "called":
        return nodes.CallNode(_member(base, bracket.end - 1), operands, span=span)
    if bracket.what == "set":
        return nodes.InNode(base, operands, span=span)
    if len(operands) == 1:
        return nodes.ElementNode(base, operands[0], span=span)
    return nodes.SliceNode(base, operands[0], operands[1], span=span)


def build_expression(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.ExprNode:
    """The tree of an expression.

    ``parts`` are the token from which the steps count, and the steps.

    Raises:
        Fault: it is nested too deep, or a literal in it is faulty.
    """
    first, steps = parts
    base = start - first
    builder = _Builder(reading)
    for what, begin, stop, symbol in steps:
        at, behind = base + begin, base + stop
        if what == "operand":
            builder.operand(make_leaf(reading, at, behind, []), at, behind)
        elif what == "operator":
            builder.operator(symbol, at)
        elif what == "prefix":
            builder.prefix(symbol, at)
        elif what == "open":
            builder.open(symbol, at, behind)
        elif what == "comma":
            builder.comma()
        elif what == "for":
            names = range(at + 1, behind - 1, 2)
            builder.bind([leaves.make_name(reading, name, name + 1, []) for name in names])
        elif what == "parts":
            builder.parts(at, behind)
        else:
            builder.close(behind)
    return builder.finish()


def make_leaf(reading: ParseState, start: int, end: int, parts: list[Any]) -> nodes.ExprNode:
    """The literal, duration or access in a range of tokens.

    Raises:
        Fault: a number or string is faulty.
    """
    kind = reading.kind(start)
    span = reading.span(start, end)
    if kind in _BOOLEANS:
        return nodes.LiteralNode(reading.text(start) == "true", span=span)
    if kind == tokens.STRING:
        return nodes.LiteralNode(leaves.make_string(reading, start), span=span)
    if kind in _NUMBERS:
        number = leaves.make_number(reading, start)
        if end > start + 1:
            unit = reading.text(start + 1)
            return nodes.DurationNode(number, unit, span=span)
        return nodes.LiteralNode(number, span=span)
    return leaves.make_access(reading, start, end, [])


def nested_too_deep(limit: int = limits.EXPRESSION_DEPTH) -> str:
    """The message about an expression beyond a limit."""
    return f"this expression is nested more than {limit} levels deep"
