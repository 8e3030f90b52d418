"""Resolved, typed expressions: shared by the model, the plant, guards and generated code.

Each node has its type. Equality ignores spans: where expressions were written does not matter.

The meaning of the operators is defined in :mod:`robosc.language.operators`. Whatever is computed
from an expression bottom-up (a value, a text, the states where it holds) is an instance of
:func:`robosc.expr.traversal.fold`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Any, ClassVar, TypeAlias, cast

from robosc.expr import types
from robosc.language import functions, operators
from robosc.lazy_dataclasses import dataclass
from robosc.runtime.core.settings import parameter_name
from robosc.source import Span


@dataclass(frozen=True, slots=True)
class Literal:
    """A constant.

    A value of an enum is its name, that of an object a dict, that of an array a tuple; that of a
    point in time is ``NOW``. 0.0 and -0.0 differ, since quotients by them do.
    """

    value: types.Value
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Literal)
            and type(self.value) is type(other.value)
            and self.value == other.value
            and (not isinstance(self.value, float) or str(self.value) == str(other.value))
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
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def key(self) -> str:
        """The key of the :class:`robosc.model.entities.Variable`."""
        return f"{self.component}.{self.variable}"


@dataclass(frozen=True, slots=True)
class StateRef:
    """True while the component is in that state; ``within``: in one of those states in it."""

    component: str
    state: str
    span: Span | None = field(default=None, compare=False, repr=False)
    within: tuple[str, ...] = ()
    type: ClassVar[types.Type] = types.BooleanType()

    @property
    def places(self) -> tuple[str, ...]:
        """The states without others in them in which it is true."""
        return self.within or (self.state,)


@dataclass(frozen=True, slots=True)
class RosParameter:
    """A parameter of the generated node that the model declares.

    ``key`` is the name shown to users, qualified by that of the component or library. One that is
    ``required`` must be given when the node starts; what only plays a robot takes the default.
    ``bounds`` are the least and the greatest value of a double.
    """

    key: str
    type: types.Type
    default: types.Value = field(compare=False)
    span: Span = field(compare=False, repr=False)
    required: bool = field(default=False, compare=False)
    bounds: tuple[float, float] | None = None

    @property
    def name(self) -> str:
        """The private name in ROS: ``limit``, ``Battery/limit``, ``station_3/limit``."""
        return parameter_name(self.key)


@dataclass(frozen=True, slots=True)
class ParameterRef:
    """The value of a parameter, which does not change while the node runs."""

    parameter: RosParameter
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> types.Type:
        return self.parameter.type


@dataclass(frozen=True, slots=True)
class PhaseRef:
    """True while a communication (by key) is in a phase, not its first; ``within``: in one of
    those, as ``scan.heard``, and as ``order.busy``, which holds while it is ending, too."""

    communication: str
    phase: str
    span: Span | None = field(default=None, compare=False, repr=False)
    within: tuple[str, ...] = ()
    type: ClassVar[types.Type] = types.BooleanType()

    @property
    def places(self) -> tuple[str, ...]:
        """The phases in which it is true."""
        return self.within or (self.phase,)


@dataclass(frozen=True, slots=True)
class ValueRef:
    """The received ``value``, or the part of it at a path of member names and array indexes.

    ``optional`` says that there may be no value at all, as of an action that failed.
    """

    path: tuple[str | int, ...]
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)
    optional: bool = False


@dataclass(frozen=True, slots=True)
class TestRef:
    """The result of a computation on data, as the plant abstracts it to finitely many values.

    It is the value of ``subject``: a number, a boolean, a value of an enum. With ``other``, it is
    the comparison of the two: -1.0 if the subject is less, 0.0, 1.0, or NaN if one of them is NaN.
    ``name`` is its text. Occurs in the plant (:mod:`robosc.plant.data`), not in the model.
    """

    subject: Expr
    other: Expr | None
    type: types.Type
    name: str
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def sides(self) -> tuple[Expr, ...]:
        return (self.subject,) if self.other is None else (self.subject, self.other)


@dataclass(frozen=True, slots=True)
class ChoiceRef(ValueRef):
    """A test of data whose result the environment chooses when the event happens.

    The plant takes it as a further part of the event's value; its ``path`` is the test's name.
    ``renews`` is the term of the state that it replaces, where no test determines the outcome.
    """

    test: TestRef | None = None
    renews: VariableRef | TestRef | None = None


REASON = ("error reason",)  # the path of the reason, which is that of no part of a value


@dataclass(frozen=True, slots=True)
class ReasonRef(ValueRef):
    """The reason of an error: a part of every error, whether it brings a value or not."""


@dataclass(frozen=True, slots=True)
class Unary:
    """``!operand`` or ``-operand``."""

    operator: str
    operand: Expr
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)
    _hash: int | None = field(default=None, init=False, compare=False, repr=False)

    def __hash__(self) -> int:
        return _kept_hash(self, self._hash)

    @property
    def operation(self) -> operators.Operator:
        return operators.UNARY[self.operator]

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.operand,)


@dataclass(frozen=True, slots=True)
class Binary:
    """``left operator right``, an operator of the table ``BINARY``."""

    operator: str
    left: Expr
    right: Expr
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)
    _hash: int | None = field(default=None, init=False, compare=False, repr=False)

    def __hash__(self) -> int:
        return _kept_hash(self, self._hash)

    @property
    def operation(self) -> operators.Operator:
        return operators.BINARY[self.operator]

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.left, self.right)


def _kept_hash(node: Unary | Binary, known: int | None) -> int:
    """Return the hash of an operation, computed once: that of a large condition takes long."""
    if known is None:
        known = hash((node.operator, *node.operands))
        object.__setattr__(node, "_hash", known)
    return known


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a function of the table ``CALLS``."""

    operator: str
    operands: tuple[Expr, ...]
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def operation(self) -> operators.Operator:
        return functions.CALLS[self.operator]


@dataclass(frozen=True, slots=True)
class ElementRef:
    """The variable of an enclosing aggregate, which ranges over an array, or a part of it.

    ``constant``: the array is a constant.
    """

    variable: str
    path: tuple[str | int, ...]
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)
    constant: bool = False

    @property
    def carried(self) -> types.Type:
        """The type of what is there; what is carried for an enum is converted by it."""
        return _of_constant(self.type) if self.constant else self.type


@dataclass(frozen=True, slots=True)
class NamedPart(ElementRef):
    """A condition by its name (``variable``): texts that share it define it beside the guards.

    It is never undefined. Occurs in texts only (:mod:`robosc.plant.part_names`).
    """


@dataclass(frozen=True, slots=True)
class Count(ElementRef):
    """Whether at least ``least`` of some conditions hold, or (``negated``) fewer.

    Occurs in texts only (:mod:`robosc.plant.counting`); the model and the plant enumerate the
    cases.
    """

    conditions: tuple[Expr, ...] = ()
    least: int = 0
    negated: bool = False


@dataclass(frozen=True, slots=True)
class Aggregate:
    """``any(element for variable in array if condition)``; the operator is of ``AGGREGATES``.

    ``position`` is the variable for the position in the array, from 0; empty if there is none.
    """

    operator: str
    variable: str
    array: Expr
    element: Expr
    condition: Expr | None
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)
    position: str = ""

    @property
    def makes_array(self) -> bool:
        """Whether it is an array, which is undefined if one of its elements is."""
        return self.operation.result is operators.Result.ARRAY

    @property
    def operation(self) -> operators.Operator:
        return functions.AGGREGATES[self.operator]

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.array, self.element, *(() if self.condition is None else (self.condition,)))


@dataclass(frozen=True, slots=True)
class Convert:
    """An enum used as a function: ``Way(value.front)``."""

    argument: Expr
    type: types.EnumType
    span: Span | None = field(default=None, compare=False, repr=False)
    operation: ClassVar[operators.Operator] = functions.CONVERSION
    """The row common to all enums; :func:`robosc.expr.evaluation.converted` gives values."""

    @property
    def operator(self) -> str:
        return self.type.name

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.argument,)


@dataclass(frozen=True, slots=True)
class Part:
    """A part of an object or array: member names and indexes, as in ``Operator.goal.pose.x``."""

    operand: Expr
    path: tuple[str | int, ...]
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)
    operator: ClassVar[str] = functions.PART.spelling
    operation: ClassVar[operators.Operator] = functions.PART

    @property
    def carried(self) -> types.Type:
        """The type of what is there; what is carried for an enum is converted by it."""
        return _of_constant(self.type) if is_constant_data(self.operand) else self.type

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.operand,)


@dataclass(frozen=True, slots=True)
class Holds:
    """Whether a condition is defined and true, or data is present (``defined(…)``)."""

    operand: Expr
    span: Span | None = field(default=None, compare=False, repr=False)
    type: ClassVar[types.Type] = types.BooleanType()
    operator: ClassVar[str] = functions.PRESENCE.spelling
    operation: ClassVar[operators.Operator] = functions.PRESENCE

    @property
    def operands(self) -> tuple[Expr, ...]:
        return (self.operand,)


@dataclass(frozen=True, slots=True)
class Made:
    """An object made of named values, ``{ x: a, y: b }``, or an array of them if none has a name.

    It is an element of an array that is made in data: ``[{ x: p.x } for p in path]``.
    """

    names: tuple[str, ...]
    operands: tuple[Expr, ...]
    type: types.Type
    span: Span | None = field(default=None, compare=False, repr=False)
    operator: ClassVar[str] = functions.MADE.spelling
    operation: ClassVar[operators.Operator] = functions.MADE

    def of(self, values: Sequence[Any]) -> Any:
        """The object or array with these values: a dict or a tuple."""
        return dict(zip(self.names, values, strict=True)) if self.names else tuple(values)


Leaf: TypeAlias = VariableRef | StateRef | PhaseRef | ParameterRef | ValueRef | TestRef | ElementRef
"""A part of an expression that reads something."""
Operation: TypeAlias = Unary | Binary | Call | Aggregate | Convert | Part | Made | Holds
Expr: TypeAlias = Literal | Leaf | Operation

TRUE = Literal(True, types.BooleanType())
FALSE = Literal(False, types.BooleanType())


def is_constant_data(expr: Expr) -> bool:
    """Whether an array or object is a constant or a part of one."""
    while isinstance(expr, Call | Part | Aggregate):
        expr = expr.element if isinstance(expr, Aggregate) else expr.operands[0]
    return isinstance(expr, Literal) or (isinstance(expr, ElementRef) and expr.constant)


def _of_constant(type_: types.Type) -> types.Type:
    """The type of a part of a constant, which has the names of an enum's values."""
    return types.StringType() if isinstance(type_, types.EnumType) else type_


def condition_of(rule: types.EnumRule) -> Expr:
    """The condition of an enum's rule, which reads the incoming value as a ``ValueRef``."""
    return cast(Expr, rule.condition)
