"""Resolved, typed expressions: shared by the model, the plant, guards and generated code.

Names are resolved to what they mean, and each node knows its type. Equality ignores spans, so equal
expressions compare equal wherever they were written.

What the operators mean is said in :mod:`robosc.language.operators`. What is computed from an
expression bottom up (a value, a text, the states where it holds) is an instance of :func:`fold`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TypeAlias, TypeVar

from robosc.language.functions import AGGREGATES, CALLS, CONVERSION, PART, PRESENCE
from robosc.language.operators import BINARY, UNARY, Operator
from robosc.model.types import ArrayType, BooleanType, EnumType, ObjectType, Type, Value
from robosc.runtime.settings import parameter_name
from robosc.source import Span

__all__ = [
    "FALSE", "TRUE", "Aggregate", "Binary", "Call", "ChoiceRef", "Convert", "ElementRef", "Expr",
    "Holds", "Leaf", "Literal", "Operation", "ParameterRef", "Part", "PhaseRef", "RosParameter",
    "StateRef", "TestRef", "Unary", "ValueRef", "VariableRef", "all_names", "fold",
    "may_be_undefined", "parameters_of", "part_of", "path_text", "reads_value",
    "rewritten", "walk", "walk_all",
    "with_operands",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Literal:
    """A constant; for an enum type the value is the enum value's name.

    The value of an object is a dict, that of an array a tuple; that of a time is ``NOW``.
    """

    value: Value
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Literal)
            and type(self.value) is type(other.value)
            and self.value == other.value
            and self.type == other.type
        )

    def __hash__(self) -> int:
        whole = isinstance(self.value, dict | tuple)
        return hash((type(self.value), str(self.type) if whole else self.value))


@dataclass(frozen=True, slots=True)
class VariableRef:
    """The current value of a component's variable."""

    component: str
    variable: str
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class StateRef:
    """True while the component is in that state."""

    component: str
    state: str
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> Type:
        return BooleanType()


@dataclass(frozen=True, slots=True)
class RosParameter:
    """A parameter of the generated node that the model declares.

    ``key`` is the name as users see it, with that of the component or library before it.
    """

    key: str
    type: Type
    default: Value = field(compare=False)
    span: Span = field(compare=False, repr=False)

    @property
    def name(self) -> str:
        """The name in ROS, below the node's: ``limit``, ``Battery/limit``, ``station_3/limit``."""
        return parameter_name(self.key)


@dataclass(frozen=True, slots=True)
class ParameterRef:
    """The value of a parameter, which is the same all the time that the node runs."""

    parameter: RosParameter
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> Type:
        return self.parameter.type


@dataclass(frozen=True, slots=True)
class PhaseRef:
    """True while a communication (by key) is in its active phase: ``grab.busy``, ``scan.fresh``."""

    communication: str
    phase: str
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> Type:
        return BooleanType()


@dataclass(frozen=True, slots=True)
class ValueRef:
    """What came in (``value``), or a part of it: member names and array indexes after ``value``.

    ``optional`` tells that there may be no value at all, as of an action that failed.
    """

    path: tuple[str | int, ...]
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)
    optional: bool = False


@dataclass(frozen=True, slots=True)
class TestRef:
    """What is computed from data, where the plant knows only what it comes to.

    ``subject`` is what decides: a number, a boolean, a value of an enum. With ``other``, it is how
    the subject compares with that: -1.0 if it is less, 0.0, 1.0, or NaN if one of them is NaN.
    ``name`` is the same as text. The model has none of these; the plant has
    (:mod:`robosc.ir.finite`).
    """

    subject: Expr
    other: Expr | None
    type: Type
    name: str
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class ChoiceRef(ValueRef):
    """A test of data that is known only when the event happens, or a choice of the environment.

    The plant takes it as one more part of the event's value; its ``path`` is the name of the test.
    """

    test: TestRef | None = None


@dataclass(frozen=True, slots=True)
class Unary:
    """``!`` or ``-``."""

    operator: str
    operand: Expr
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def operation(self) -> Operator:
        return UNARY[self.operator]

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.operand,)


@dataclass(frozen=True, slots=True)
class Binary:
    """Two operands and an operator of the table ``BINARY``."""

    operator: str
    left: Expr
    right: Expr
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def operation(self) -> Operator:
        return BINARY[self.operator]

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.left, self.right)


@dataclass(frozen=True, slots=True)
class Call:
    """A function of the table ``CALLS``, applied to arguments."""

    operator: str
    operands: tuple[Expr, ...]
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def operation(self) -> Operator:
        return CALLS[self.operator]


@dataclass(frozen=True, slots=True)
class ElementRef:
    """What goes through an array, or a part of it, inside of its aggregate."""

    variable: str
    path: tuple[str | int, ...]
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Aggregate:
    """``any(element for variable in array if condition)``; the operator is of ``AGGREGATES``."""

    operator: str
    variable: str
    array: Expr
    element: Expr
    condition: Expr | None
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def operation(self) -> Operator:
        return AGGREGATES[self.operator]

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.array, self.element, *(() if self.condition is None else (self.condition,)))


@dataclass(frozen=True, slots=True)
class Convert:
    """An enum used as a function: ``Way(value.front)``."""

    argument: Expr
    type: EnumType
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def operator(self) -> str:
        return self.type.name

    @property
    def operation(self) -> Operator:
        """What is common to all enums; :func:`robosc.model.evaluation.converted` has the values."""
        return CONVERSION

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.argument,)


@dataclass(frozen=True, slots=True)
class Part:
    """A part of an object or array: member names and indexes, as in ``Operator.goal.pose.x``."""

    operand: Expr
    path: tuple[str | int, ...]
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def operator(self) -> str:
        return "part"

    @property
    def operation(self) -> Operator:
        return PART

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.operand,)


@dataclass(frozen=True, slots=True)
class Holds:
    """Whether a condition is true, or data are there; False where the operand is undefined."""

    operand: Expr
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> Type:
        return BooleanType()

    @property
    def operator(self) -> str:
        return "holds"

    @property
    def operation(self) -> Operator:
        return PRESENCE

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.operand,)


Leaf: TypeAlias = VariableRef | StateRef | PhaseRef | ParameterRef | ValueRef | TestRef | ElementRef
"""What an expression reads."""
Operation: TypeAlias = Unary | Binary | Call | Aggregate | Convert | Part | Holds
Expr: TypeAlias = Literal | Leaf | Operation

TRUE = Literal(True, BooleanType())
FALSE = Literal(False, BooleanType())

T = TypeVar("T")


def fold(
    expr: Expr,
    leaf: Callable[[Literal | Leaf], T],
    strict: Callable[[Operation, tuple[T, ...]], T],
    lazy: Callable[[Binary, T, Callable[[], T]], T] | None = None,
    known: Callable[[Expr], T | None] | None = None,
    bound: Callable[[Aggregate, T, Callable[[Expr], T]], T] | None = None,
    total: Callable[[Callable[[], T]], T] | None = None,
) -> T:
    """What is made of an expression from what is made of its parts, from the leaves up.

    ``strict`` is given the results for all operands, in order. ``lazy`` is called for operators
    that may leave their right side alone, with the result of the left and a function that makes
    that of the right; without it they count as strict. ``known`` may give the result for a part as
    a whole, so that nothing below it is looked at. ``bound`` is given the result for the array of
    an aggregate, and a function that makes those of its element and condition, once or for each
    element of the array; without it these are operands like others. ``total`` is given a function
    that makes the result for what is asked whether it holds.
    """

    def visit(node: Expr) -> T:
        if known is not None:
            found = known(node)
            if found is not None:
                return found
        if isinstance(node, Binary):
            left = visit(node.left)
            if lazy is not None and node.operation.decider is not None:
                return lazy(node, left, lambda: visit(node.right))
            return strict(node, (left, visit(node.right)))
        if bound is not None and isinstance(node, Aggregate):
            return bound(node, visit(node.array), visit)
        if total is not None and isinstance(node, Holds):
            return total(lambda: visit(node.operand))
        if isinstance(node, Operation):
            return strict(node, tuple(visit(operand) for operand in node.operands))
        return leaf(node)

    return visit(expr)


def rewritten(expr: Expr, leaf: Callable[[Literal | Leaf], Expr]) -> Expr:
    """The expression with every leaf replaced."""
    return fold(expr, leaf, with_operands)


def with_operands(node: Operation, operands: tuple[Expr, ...]) -> Expr:
    """The operation on other operands."""
    match node:
        case Unary():
            return replace(node, operand=operands[0])
        case Binary():
            return replace(node, left=operands[0], right=operands[1])
        case Call():
            return replace(node, operands=operands)
        case Convert():
            return replace(node, argument=operands[0])
        case Part():
            return part_of(operands[0], node.path, node.type, node.span)
        case Holds():
            return replace(node, operand=operands[0])
        case Aggregate():
            array, element, *condition = operands
            return replace(
                node, array=array, element=element, condition=condition[0] if condition else None
            )


def part_of(
    whole: Expr, path: tuple[str | int, ...], type_: Type, span: Span | None = None
) -> Expr:
    """A part of what an expression gives."""
    match whole:
        case ChoiceRef():
            return Part(whole, path, type_, span)
        case ValueRef(path=before):
            return ValueRef((*before, *path), type_, span, whole.optional)
        case Part(operand=operand, path=before):
            return Part(operand, (*before, *path), type_, span)
    return Part(whole, path, type_, span)


def may_be_undefined(expr: Expr) -> bool:
    """Whether an expression can be undefined, as what reads an element of an array is."""
    for part in walk(expr, inside=lambda node: not isinstance(node, Holds)):
        match part:
            case VariableRef(type=ArrayType() | ObjectType()):
                return True  # it may hold nothing yet
            case ValueRef(optional=True):
                return True
            case ValueRef(path=path) | ElementRef(path=path) | Part(path=path) if not all_names(
                path
            ):
                return True
            case Call(operator="element") | Aggregate(operator="min" | "max"):
                return True
    return False


def all_names(path: tuple[str | int, ...]) -> bool:
    """Whether a path goes through no array."""
    return all(isinstance(part, str) for part in path)


def walk(expr: Expr, inside: Callable[[Expr], bool] = lambda node: True) -> Iterator[Expr]:
    """The expression and all its parts, in source order, without recursion.

    Only the operands of those parts are visited for which ``inside`` holds.
    """
    stack = [expr]
    while stack:
        node = stack.pop()
        yield node
        if isinstance(node, Operation) and inside(node):
            stack.extend(reversed(node.operands))


def walk_all(exprs: Iterable[Expr]) -> Iterator[Expr]:
    """All parts of several expressions; what they share is visited once."""
    seen: dict[int, Expr] = {}  # which keeps them, so that no other can take their place
    for expr in exprs:
        stack = [expr]
        while stack:
            node = stack.pop()
            if id(node) not in seen:
                seen[id(node)] = node
                yield node
                if isinstance(node, Operation):
                    stack.extend(reversed(node.operands))


def parameters_of(expr: Expr) -> Iterator[RosParameter]:
    """The parameters that an expression reads, also in tests and in the rules of enums."""
    for part in walk(expr):
        match part:
            case ParameterRef(parameter=parameter):
                yield parameter
            case ChoiceRef(test=TestRef() as test) | (TestRef() as test):
                yield from parameters_of(test.subject)
                if test.other is not None:
                    yield from parameters_of(test.other)
            case (
                Convert(type=enum)
                | ValueRef(type=EnumType() as enum)
                | Part(type=EnumType() as enum)
                | ElementRef(type=EnumType() as enum)
            ):
                for rule in enum.rules:
                    yield from parameters_of(rule.condition)


def reads_value(expr: Expr) -> bool:
    """Whether an expression reads what came in."""
    return any(isinstance(part, ValueRef) for part in walk(expr))


def path_text(path: tuple[str | int, ...]) -> str:
    """A part of a value as users see it: ``pose.x``, ``ranges[0]``; empty for the whole."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")
