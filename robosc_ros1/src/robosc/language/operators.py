"""The table of operators: how each is written, typed, evaluated and printed.

It is the only definition of what an operator means. Its users are the parser, the formatter, type
checking, evaluation, the BDD engine, the printers of model text,
Python and CIF, and the tables of the reference interpreter in generated tests.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from typing import Any, NamedTuple

from robosc.lazy_dataclasses import dataclass
from robosc.runtime.core.operations import divide, remainder
from robosc.runtime.core.values import widen


class Operand(Enum):
    """What an operator requires of its operands."""

    BOOLEAN = "boolean"
    NUMBER = "number"
    EQUAL = "two values of one type"
    SUMMAND = "two numbers or two strings"
    INTEGER = "integer"
    BASIC = "a value of a basic type or an enum"
    ARRAY = "array"
    ANY = "any value"


class Result(Enum):
    """The type of a result."""

    BOOLEAN = "boolean"
    NUMBER = "integer if all operands are, else double"
    DOUBLE = "double"
    INTEGER = "integer"
    STRING = "string"
    ELEMENT = "an element of the array"
    ENUM = "a value of the enum"
    ARRAY = "an array of the same type"
    SUM = "string if the operands are strings, else as a number"
    SAME = "the type that both operands have"


PYTHON_ATOM = 8
"""The precedence of names, literals and calls in Python text."""


class Spelled(NamedTuple):
    """A text and its precedence; ``{text:5}`` adds parentheses if that is below 5."""

    text: str
    level: int

    def __format__(self, least: str) -> str:
        return self.text if self.level >= int(least) else f"({self.text})"


@dataclass(frozen=True, slots=True)
class Text:
    """A template for the text of an expression in some language.

    ``template`` holds the operands as ``{0:5}`` (operand 0, in parentheses unless it binds at least
    as tightly as level 5 of that language) or all of them, separated by commas, as ``{*}``.
    ``level`` is the precedence of the whole expression.
    """

    template: str
    level: int

    def of(self, operands: Iterable[Spelled]) -> Spelled:
        if "{*}" in self.template:
            listed = ", ".join(operand.text for operand in operands)
            return Spelled(self.template.replace("{*}", listed), self.level)
        return Spelled(self.template.format(*operands), self.level)


EXACT_IN_DOUBLE = 2**53


@dataclass(frozen=True, slots=True)
class Operator:
    """An operator with one or two operands, or a function (which has ``arguments``).

    ``level`` is the precedence in the language; higher binds tighter. ``scalar`` is the function of
    Python values. A lazy operator evaluates its right operand only if the left one is not
    ``decider``; if it is, the result is ``decided``. ``negation`` is the operator with the opposite
    result. A ``variadic`` function accepts its last argument any number of times. ``written`` is
    the model text of a function that is not written as a call.
    """

    spelling: str
    level: int
    operands: Operand
    result: Result
    scalar: Callable[..., Any]
    python: Text
    cif: Text | None = None
    decider: bool | None = None
    decided: bool = False
    negation: str = ""
    right_associative: bool = False
    is_unary: bool = False
    name: str = ""
    arguments: tuple[Operand, ...] = ()
    variadic: bool = False
    written: Text | None = None

    @property
    def is_lazy(self) -> bool:
        return self.decider is not None

    @property
    def is_comparison(self) -> bool:
        """Whether it compares values, with a boolean result."""
        return self.result is Result.BOOLEAN and self.operands is not Operand.BOOLEAN

    @property
    def keeps_integers(self) -> bool:
        """Whether its result is an integer if its operands are integers."""
        return self.result in (Result.NUMBER, Result.SUM)

    @property
    def is_word(self) -> bool:
        return self.spelling.isalpha()

    @property
    def key(self) -> str:
        """The unique name of the operation in the tables of generated tests."""
        return self.name or self.spelling

    @property
    def text(self) -> Text:
        """The template for model text."""
        if self.written is not None:
            return self.written
        if self.arguments:
            return Text(f"{self.spelling}({{*}})", self.level)
        if self.is_unary:
            return Text(f"{self.spelling}{{0:{self.level}}}", self.level)
        left = self.level + self.right_associative
        # 'and' and 'or' are associative, so they need no parentheses.
        right = self.level + (not self.right_associative and not self.is_lazy)
        return Text(f"{{0:{left}}} {self.spelling} {{1:{right}}}", self.level)


def _call(function: Callable[..., Any]) -> Text:
    """Return the template of a call of a runtime function with two arguments."""
    return Text(f"{function.__name__}({{0:0}}, {{1:0}})", PYTHON_ATOM)


def _widening(operation: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    def widened(left: Any, right: Any) -> Any:
        try:
            return operation(left, right)
        except OverflowError:  # a double, and an integer too large for one
            return operation(widen(left), widen(right))

    return widened


def _and(left: Any, right: Any) -> Any:
    return left and right


def _or(left: Any, right: Any) -> Any:
    return left or right


def _implies(left: Any, right: Any) -> Any:
    return not left or right


def _number_or(left: Any, right: Any) -> Any:
    """Return the left operand, which is defined, unless it is not a number."""
    return right if isinstance(left, float) and left != left else left


def _comparison(
    spelling: str, scalar: Callable[..., Any], python: str, negation: str = ""
) -> Operator:
    equality = spelling in ("=", "!=")
    # Python chains comparisons and this language does not, so both sides must bind tighter.
    return Operator(
        spelling,
        level=4 if equality else 5,
        operands=Operand.EQUAL if equality else Operand.NUMBER,
        result=Result.BOOLEAN,
        scalar=scalar,
        python=Text(f"{{0:5}} {python} {{1:5}}", 4),
        cif=Text(f"{{0:9}} {spelling} {{1:9}}", 4),
        negation=negation,
    )


UNARY: Mapping[str, Operator] = {
    o.spelling: o
    for o in (
        Operator(
            "!", 8, Operand.BOOLEAN, Result.BOOLEAN, operator.not_,
            python=Text("not {0:3}", 3),
            cif=Text("not {0:9}", 8),
            is_unary=True,
        ),
        Operator(
            "-", 8, Operand.NUMBER, Result.NUMBER, operator.neg,
            python=Text("-{0:8}", 7),
            is_unary=True, name="negative",
        ),
    )
}  # fmt: skip
"""The unary operators by spelling; all bind tighter than any binary operator."""

BINARY: Mapping[str, Operator] = {
    o.spelling: o
    for o in (
        Operator(
            "else", 0, Operand.EQUAL, Result.SAME, _number_or,
            python=Text("otherwise(lambda: {0:0}, lambda: {1:0})", PYTHON_ATOM),
            right_associative=True,
        ),
        Operator(
            "=>", 1, Operand.BOOLEAN, Result.BOOLEAN, _implies,
            python=Text("not {0:3} or {1:1}", 1),
            cif=Text("{0:2} => {1:2}", 1),
            decider=False, decided=True, right_associative=True,
        ),
        Operator(
            "or", 2, Operand.BOOLEAN, Result.BOOLEAN, _or,
            python=Text("{0:1} or {1:1}", 1),
            cif=Text("{0:3} or {1:3}", 2),
            decider=True, decided=True,
        ),
        Operator(
            "and", 3, Operand.BOOLEAN, Result.BOOLEAN, _and,
            python=Text("{0:2} and {1:2}", 2),
            cif=Text("{0:4} and {1:4}", 3),
            decider=False, decided=False,
        ),
        _comparison("=", operator.eq, "==", negation="!="),
        _comparison("!=", operator.ne, "!=", negation="="),
        _comparison("<", operator.lt, "<"),
        _comparison("<=", operator.le, "<="),
        _comparison(">", operator.gt, ">"),
        _comparison(">=", operator.ge, ">="),
        Operator(
            "+", 6, Operand.SUMMAND, Result.SUM, _widening(operator.add),
            python=Text("{0:5} + {1:6}", 5),
        ),
        Operator(
            "-", 6, Operand.NUMBER, Result.NUMBER, _widening(operator.sub),
            python=Text("{0:5} - {1:6}", 5),
        ),
        Operator(
            "*", 7, Operand.NUMBER, Result.NUMBER, _widening(operator.mul),
            python=Text("{0:6} * {1:7}", 6),
        ),
        Operator(
            "/", 7, Operand.NUMBER, Result.DOUBLE, divide,
            python=_call(divide),
        ),
        Operator(
            "%", 7, Operand.NUMBER, Result.NUMBER, remainder,
            python=_call(remainder),
        ),
    )
}  # fmt: skip
"""The binary operators by spelling, lowest precedence first."""


def infix_signs() -> tuple[str, ...]:
    """Return the binary operators, as signs, that cannot start an operand."""
    return tuple(o.spelling for o in BINARY.values() if not o.is_word and o.spelling not in UNARY)


MIRRORED: Mapping[str, str] = {
    "=": "=", "!=": "!=", "<": ">", "<=": ">=", ">": "<", ">=": "<=",
}  # fmt: skip
"""The comparison that is equivalent with its operands exchanged."""

OPPOSITE: Mapping[str, str] = {
    "=": "!=", "!=": "=", "<": ">=", "<=": ">", ">": "<=", ">=": "<",
}  # fmt: skip
"""The comparison that holds where one does not, but for values that are no numbers."""


def symbols(*, words: bool) -> tuple[str, ...]:
    """Return the operators spelt as words, or those that are signs, longest first."""
    found = {o.spelling for o in (*UNARY.values(), *BINARY.values()) if o.is_word == words}
    return tuple(sorted(found, key=lambda s: (-len(s), s)))
