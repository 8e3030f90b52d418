"""The finite view of one model: its terms, their classes, and what assignments do to them.

An assignment changes a term as it changes an expression (Dijkstra's weakest precondition): after
``x := e``, the term ``f(x)`` is what ``f(e)`` was before. Where that is constant, a term of the
plant or a part of ``value``, the change is exact. Else it is a choice of the environment, one and
the same for equal expressions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from robosc.ir.finite.classes import Classes
from robosc.ir.finite.terms import Term, Terms, kept_where_undefined, reads_parameters, value_of
from robosc.ir.formulas import Leaf
from robosc.model.entities import Assignment, EventKind, ResultTransition, Robot, Variable
from robosc.model.expr import (
    Aggregate,
    Binary,
    ChoiceRef,
    Expr,
    Holds,
    Literal,
    Operation,
    ParameterRef,
    TestRef,
    ValueRef,
    VariableRef,
)
from robosc.model.traversal import may_be_undefined, walk
from robosc.model.types import Value

__all__ = ["FiniteView", "may_be_missing", "reference_to"]

Scope: TypeAlias = tuple[EventKind, str] | None
"""Where ``value`` means something: an event, by its communication's key."""
_Node: TypeAlias = tuple[Scope, Term]
_StateTerm: TypeAlias = VariableRef | TestRef
_Key: TypeAlias = tuple[str, EventKind, str, tuple[Assignment, ...]]
"""Assignments that are made at once, with their component, event and communication."""


@dataclass(frozen=True, eq=False)
class FiniteView:
    """What the plant knows of the data of a robot.

    ``variables`` are the classes of variables that are compared, by key; ``tests`` those terms of
    the state that no variable is. ``free`` are those tests and computed values, as text, of which
    the plant reckons with every outcome, each with the reason why.
    """

    robot: Robot
    tests: tuple[TestRef, ...]
    variables: Mapping[str, Classes]
    free: Mapping[str, str]
    _terms: Terms
    _classes: Mapping[_Node, Classes]
    _updates: Mapping[_Key, tuple[tuple[_StateTerm, Expr], ...]]

    def expression(self, expr: Expr) -> Expr:
        """A deciding expression as the plant has it."""
        return self._terms.finite(expr)

    def assigned(self, variable: Variable, value: Expr) -> Expr:
        """What a finite variable becomes when a value is assigned to it."""
        return self._terms.finite(kept_where_undefined(reference_to(variable), value))

    def updates(
        self, component: str, transition: ResultTransition
    ) -> tuple[tuple[_StateTerm, Expr], ...]:
        """What terms of the state become when a transition is taken; others stay as they are."""
        return self._updates.get(_key(component, transition), ())

    def values(self, scope: Scope, term: Term) -> Classes | None:
        """The classes of a term that is a number or a string without bounds."""
        return self._classes.get((scope, term))

    def is_there(self, variable: VariableRef) -> TestRef:
        """Whether an object or an array that provided data read has come."""
        return self._terms.computed(Holds(variable))

    def initial(self, test: TestRef) -> Value:
        """What a test comes to at the start, with the defaults of parameters."""

        def look(leaf: Leaf) -> Value | None:
            assert isinstance(leaf, VariableRef)
            return self.robot.variables[f"{leaf.component}.{leaf.variable}"].initial

        return value_of(test, look)

    def starts(self, test: TestRef, outcomes: Sequence[Value]) -> tuple[int, ...]:
        """The numbers of the outcomes that a test can have at the start, the defaults' first.

        Of what reads parameters that is any; but a parameter is a number, and variables begin as
        numbers, so that none of them is NaN.
        """
        first = outcomes.index(self.initial(test))
        fixed = not any(map(reads_parameters, _sides_of(test)))
        if fixed or (isinstance(test.subject, Holds) and self._needs_nothing(test.subject.operand)):
            return (first,)
        numbers = all(isinstance(s, Literal | VariableRef | ParameterRef) for s in _sides_of(test))
        found = (n for n, outcome in enumerate(outcomes) if not (numbers and outcome != outcome))
        return first, *(number for number in found if number != first)

    def _needs_nothing(self, expr: Expr) -> bool:
        """Whether an expression is undefined at the start: it needs data that are not there."""
        match expr:
            case VariableRef(component=component, variable=name):
                return self.robot.variables[f"{component}.{name}"].initial is None
            case Binary(left=left) if expr.operation.is_lazy:
                return self._needs_nothing(left)
            case Aggregate(array=array):
                return self._needs_nothing(array)
            case Holds():
                return False
        return isinstance(expr, Operation) and any(map(self._needs_nothing, expr.operands))


def reference_to(variable: Variable) -> VariableRef:
    return VariableRef(variable.component, variable.name, variable.type)


def _key(component: str, transition: ResultTransition) -> _Key:
    return component, transition.event, transition.communication, transition.assignments


def _parts(test: TestRef) -> Iterator[Expr]:
    for side in _sides_of(test):
        yield from walk(side)


def _sides_of(test: TestRef) -> tuple[Expr, ...]:
    return (test.subject,) if test.other is None else (test.subject, test.other)


def may_be_missing(term: Term) -> bool:
    """Whether a part of an event's value may not be there."""
    match term:
        case ChoiceRef(test=None):
            return False
        case ChoiceRef(test=TestRef() as test):
            return any(may_be_undefined(part) for part in _parts(test))
        case ValueRef():
            return may_be_undefined(term)
    return False
