"""Which part of a condition decides over data, and the condition over finitely many outcomes.

Data are numbers without bounds, strings, and all that is computed from them. A comparison of data
with a constant stays as it is: its term is the variable or the part of ``value``. So does what an
enum makes of one, if its rules are such comparisons. Any other becomes a
:class:`~robosc.model.expr.TestRef` that is compared with a constant, or is a boolean itself; a
parameter is such a test, too, whose outcome is not known at the start and never changes. So
``A.x > A.y`` asks whether the order of the two is above 0, as do ``A.y < A.x`` and, the other way
round, ``A.x <= A.y``: what excludes each other in the data does so in the plant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from robosc.ir.by_identity import ByIdentity
from robosc.ir.finite.cases import by_state, by_value, reads_arrays, reads_states
from robosc.ir.formulas import Leaf, conjunction, disjunction, evaluate, negation
from robosc.language.operators import MIRRORED
from robosc.model.expr import (
    Binary,
    ChoiceRef,
    Convert,
    ElementRef,
    Expr,
    Holds,
    Literal,
    Operation,
    ParameterRef,
    Part,
    PhaseRef,
    StateRef,
    TestRef,
    Unary,
    ValueRef,
    VariableRef,
    condition_of,
)
from robosc.model.presence import condition_on_data
from robosc.model.traversal import (
    may_be_undefined,
    parameters_of,
    reads_value,
    rewritten,
    walk,
    with_operands,
)
from robosc.model.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    ObjectType,
    StringType,
    Type,
    Value,
    domain,
    is_number,
)

__all__ = [
    "Term", "Terms", "compared_in_rules", "element_asked_for", "is_constant", "is_presence",
    "is_there", "kept_where_undefined", "order", "reads_data", "reads_parameters",
    "sides_of", "type_of_part", "value_of",
]  # fmt: skip

Term: TypeAlias = VariableRef | ValueRef | TestRef

_BOOLEAN = BooleanType()


def is_constant(expr: Expr) -> bool:
    """Whether an expression reads nothing."""
    reads = any(not isinstance(part, Literal | Operation) for part in walk(expr))
    return not reads and not reads_parameters(expr)


def reads_parameters(expr: Expr) -> bool:
    """Whether an expression reads parameters, also in the rules of enums."""
    return any(True for _ in parameters_of(expr))


def reads_data(expr: Expr) -> bool:
    """Whether what an expression comes to is not told by anything finite that it reads."""
    return any(
        reads_parameters(part)
        if isinstance(part, Convert)
        else domain(part.type) is None and not isinstance(part, Literal | Operation | ElementRef)
        for part in walk(expr)
    )


def compared_in_rules(expr: Convert) -> list[tuple[str, Expr]] | None:
    """What the rules of an enum compare a number or a string with: operators and constants.

    None if they ask anything else, or if what is converted is no variable and no part of ``value``.
    """
    if not isinstance(expr.argument, VariableRef | ValueRef) or not expr.type.rules:
        return None
    found: list[tuple[str, Expr]] = []
    work: list[Expr] = [condition_of(rule) for rule in expr.type.rules]
    while work:
        match work.pop():
            case Unary(operator="!", operand=operand):
                work.append(operand)
            case Binary(left=left, right=right) as both if both.operation.is_lazy:
                work += [left, right]
            case Binary(operator=operator, left=ValueRef(path=()) as left, right=right) if (
                operator in MIRRORED and domain(left.type) is None and is_constant(right)
            ):
                found.append((operator, right))
            case Binary(operator=operator, left=left, right=ValueRef(path=()) as right) if (
                operator in MIRRORED and domain(right.type) is None and is_constant(left)
            ):
                found.append((MIRRORED[operator], left))
            case _:
                return None
    return found


def order(left: Value, right: Value) -> Value:
    """How a number compares with another: -1.0, 0.0, 1.0, or NaN."""
    if left != left or right != right:
        return float("nan")
    return float((left > right) - (left < right))  # type: ignore[operator]


def value_of(test: TestRef, lookup: Callable[[Leaf], Value | None]) -> Value:
    """What a test comes to on the data themselves.

    Raises:
        Undefined: it reads something that is not there.
    """
    subject = evaluate(test.subject, lookup)
    return subject if test.other is None else order(subject, evaluate(test.other, lookup))


def type_of_part(type_: Type, path: tuple[str | int, ...]) -> Type | None:
    """The type of a part, as what comes in has it."""
    found: Type | None = type_
    for step in path:
        match found:
            case ArrayType(element=element) if isinstance(step, int):
                found = element
            case ObjectType() if isinstance(step, str):
                found = found.property(step)
            case _:
                return None
    return found


def sides_of(expr: Expr) -> tuple[Expr, ...]:
    """What a comparison compares; of anything else, that itself."""
    if isinstance(expr, Binary) and expr.operation.is_comparison:
        return expr.operands
    return (expr,)


def element_asked_for(test: Expr) -> Part | None:
    """The element of an array or object in a variable, if a test asks only how it compares."""
    if not isinstance(test, Holds):
        return None
    asked = test.operand
    while isinstance(asked, Unary) and asked.operator == "!":
        asked = asked.operand
    sides = [side for side in sides_of(asked) if not is_constant(side)]
    found = sides[0] if len(sides) == 1 else None
    found = found.argument if isinstance(found, Convert) else found
    return found if isinstance(found, Part) and isinstance(found.operand, VariableRef) else None


def kept_where_undefined(variable: VariableRef, value: Expr) -> Expr:
    """What a boolean variable becomes: what is assigned, or what it was if that is not there.

    So it is put if each comparison in it asks for one element of a variable, which the plant
    knows, or for what is finite. Else the value itself, undefined where something is not there.
    """
    if not isinstance(variable.type, BooleanType):
        return value
    true, false = (condition_on_data(e) for e in (value, Unary("!", value, _BOOLEAN)))
    asked = [part for side in (true, false) for part in walk(side) if isinstance(part, Holds)]
    if not asked or any(reads_data(p) and element_asked_for(p) is None for p in asked):
        return value
    return disjunction([true, conjunction([variable, negation(false)])])


def is_presence(subject: Expr) -> bool:
    """Whether this asks whether a variable holds anything."""
    return isinstance(subject, Holds) and isinstance(subject.operand, VariableRef)


def is_there(subject: Expr) -> bool:
    """Whether this asks for data that are there for sure."""
    return (
        isinstance(subject, Holds)
        and isinstance(subject.operand.type, ArrayType | ObjectType)
        and not may_be_undefined(subject.operand)
    )


class Terms:
    """Finds the terms of expressions; ``text`` is how an expression reads."""

    def __init__(self, text: Callable[[Expr], str]) -> None:
        self._text = text
        self._pairs: dict[tuple[Expr, Expr], TestRef] = {}
        self._finite: ByIdentity[Expr] = ByIdentity()

    def finite(self, expr: Expr) -> Expr:
        """A deciding expression with its tests of data replaced by terms, which read no state.

        What stands in several places, as in the requirements of copies, is looked at once.
        """
        return self._finite.of(expr, self._new_finite)

    def _new_finite(self, expr: Expr) -> Expr:
        match expr:
            case Unary(operator="!", operand=operand):
                return replace(expr, operand=self.finite(operand))
            case Binary(operator=operator, left=left, right=right):
                if operator not in MIRRORED or isinstance(left.type, BooleanType):
                    return replace(expr, left=self.finite(left), right=self.finite(right))
                if reads_data(expr) and reads_states(expr):
                    return self._by_states(expr)
                if isinstance(left.type, EnumType) and (reads_data(expr) or not reads_arrays(expr)):
                    return replace(expr, left=self.finite(left), right=self.finite(right))
                return self._comparison(expr) if reads_data(expr) else self._whole(expr)
            case VariableRef() | ValueRef() | StateRef() | PhaseRef() | Literal():
                return expr
            case Convert() if compared_in_rules(expr) is not None:
                return expr
        if not reads_data(expr):
            return self._whole(expr)
        if isinstance(expr.type, BooleanType) or not reads_states(expr):
            return self._free(expr)
        return self.choice(self.computed(expr))  # it is assigned: no later state depends on it

    def _free(self, expr: Expr) -> Expr:
        """A test whose outcomes the plant does not derive from what it reads."""
        return self._by_states(expr) if reads_states(expr) else self._seen(self.computed(expr))

    def _by_states(self, expr: Expr) -> Expr:
        """A test of data that reads states, as a test without them in each of these states."""
        cases = [(state, self.finite(test)) for state, test in by_state(expr)]
        if len({test for _, test in cases}) == 1:
            return cases[0][1]
        return disjunction(conjunction(case) for case in cases)

    def _whole(self, expr: Expr) -> Expr:
        """An expression over what is finite, with parameters as the state has them.

        Engines know no arrays: one that the model fixes is gone here.
        """

        def leaf(node: Literal | Leaf) -> Expr:
            return self.computed(node) if isinstance(node, ParameterRef) else node

        found = rewritten(expr, leaf) if reads_parameters(expr) else expr
        if not reads_arrays(expr):
            return found
        if isinstance(expr.type, BooleanType):
            written = by_value(found)
            return self._free(expr) if written is None else written
        if isinstance(expr, Operation) and domain(expr.type) is None:  # of parts with ranges
            return with_operands(expr, tuple(map(self._whole, expr.operands)))
        return self.choice(self.computed(expr))  # it is assigned

    def _comparison(self, expr: Binary) -> Expr:
        if is_constant(expr.right):
            return replace(expr, left=self.term(expr.left))
        if is_constant(expr.left):
            return replace(expr, right=self.term(expr.right))
        if isinstance(expr.left.type, StringType):
            same = self._seen(self.computed(replace(expr, operator="=")))
            return same if expr.operator == "=" else Unary("!", same, _BOOLEAN, expr.span)
        test, swapped = self.pair(expr.left, expr.right)
        operator = MIRRORED[expr.operator] if swapped else expr.operator
        return Binary(operator, self._seen(test), Literal(0, IntegerType()), _BOOLEAN, expr.span)

    def term(self, expr: Expr) -> Term:
        """What stands for a number or a string that is compared with constants."""
        if isinstance(expr, VariableRef | ValueRef):
            return expr
        return self._seen(self.computed(expr))

    def computed(self, expr: Expr) -> TestRef:
        return TestRef(expr, None, expr.type, self._text(expr))

    def pair(self, left: Expr, right: Expr) -> tuple[TestRef, bool]:
        """How two numbers compare; and whether the test has them the other way round."""
        if (right, left) in self._pairs:
            return self._pairs[right, left], True
        if (left, right) not in self._pairs:
            both = [left.type, right.type]
            integers = all(is_number(t) and isinstance(t, IntegerType) for t in both)
            type_: Type = IntegerType() if integers else DoubleType()
            name = f"compare({self._text(left)}, {self._text(right)})"
            self._pairs[left, right] = TestRef(left, right, type_, name)
        return self._pairs[left, right], False

    def _seen(self, test: TestRef) -> TestRef | ChoiceRef:
        """The test where it stands: what reads ``value`` is known only when the event happens.

        So is what reads data that may not be there, which only assignments do.
        """
        read = [test.subject] if test.other is None else [test.subject, test.other]
        at_event = any(reads_value(part) or may_be_undefined(part) for part in read)
        return self.choice(test) if at_event else test

    def choice(self, test: TestRef) -> ChoiceRef:
        return ChoiceRef((test.name,), test.type, test=test)
