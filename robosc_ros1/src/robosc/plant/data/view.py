"""The finite view of a model: its terms, their classes, and the effect of assignments on them.

The effect is that of Dijkstra's weakest precondition: after ``x := e``, the term ``f(x)`` has the
value that ``f(e)`` had before. If ``f(e)`` is a constant, a term of the plant or a part of
``value``, the update is exact. Otherwise it is a choice by the environment, the same one for equal
expressions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from robosc.expr.traversal import may_be_undefined, rewritten, walk
from robosc.expr.tree import (
    Aggregate,
    Binary,
    ChoiceRef,
    Expr,
    Holds,
    Leaf,
    Literal,
    Operation,
    ParameterRef,
    TestRef,
    ValueRef,
    VariableRef,
)
from robosc.expr.types import ArrayType, ObjectType, Value
from robosc.expr.undefined_data import known_condition
from robosc.language.events import EventKind
from robosc.model.automata import Assignment, Transition, Variable
from robosc.model.entities import Communication, Provide, Requirement, Robot, data_expressions
from robosc.plant.data.classes import Classes
from robosc.plant.data.terms import Term, Terms, kept_where_undefined, reads_parameters, value_of
from robosc.plant.logic import negation

Scope: TypeAlias = tuple[EventKind, str] | None
"""The event whose value ``value`` is: its kind and its communication's key."""
ScopedTerm: TypeAlias = tuple[Scope, Term]
"""A term, with the event if it is one of ``value``, else None."""
StateTerm: TypeAlias = VariableRef | TestRef
UpdateKey: TypeAlias = tuple[str, EventKind, str, tuple[Assignment, ...]]
"""The component, event, communication and simultaneous assignments of a transition."""


@dataclass(frozen=True, eq=False)
class FiniteView:
    """The representation of a robot's data in the plant.

    ``variables`` are the classes of compared variables, by key; ``tests`` are the other terms of
    the state. ``free`` are the tests and computed values, as text, for which the plant allows every
    outcome, each with the reason.
    """

    robot: Robot
    tests: tuple[TestRef, ...]
    variables: Mapping[str, Classes]
    free: Mapping[str, str]
    _terms: Terms
    _classes: Mapping[ScopedTerm, Classes]
    _updates: Mapping[UpdateKey, tuple[tuple[StateTerm, Expr], ...]]

    def expression(self, expr: Expr) -> Expr:
        """Return a deciding expression in terms of the plant."""
        return self._terms.finite(expr)

    def met(self, requirement: Requirement) -> Expr:
        """Return the condition under which a requirement is met, in terms of the plant."""
        condition = self.expression(requirement.condition)
        return negation(condition) if requirement.forbids else condition

    def assigned(self, variable: Variable, value: Expr) -> Expr:
        """Return the value, in terms of the plant, that an assignment gives to a finite
        variable."""
        return self._terms.finite(kept_where_undefined(reference_to(variable), value))

    def updates(self, component: str, transition: Transition) -> tuple[tuple[StateTerm, Expr], ...]:
        """Return the new values of the terms of the state that a transition changes."""
        return self._updates.get(update_key(component, transition), ())

    def values(self, scope: Scope, term: Term) -> Classes | None:
        """Return the classes of a term that is an unbounded number or a string; None for other
        terms."""
        return self._classes.get((scope, term))

    def is_there(self, variable: VariableRef) -> TestRef:
        """Return the test that an object or an array, which provided data read, has been
        received."""
        return self._terms.computed(Holds(variable))

    def starts(self, test: TestRef, outcomes: Sequence[Value]) -> tuple[int, ...]:
        """Return the indexes of the possible initial outcomes of a test, that of the defaults
        first.

        A test that reads parameters or persistent variables can have any outcome, but not NaN if it
        only compares parameters, variables and constants.
        """

        def initial(leaf: Leaf) -> Value | None:
            assert isinstance(leaf, VariableRef)
            return self.robot.variables[f"{leaf.component}.{leaf.variable}"].initial

        first = outcomes.index(value_of(test, initial))
        fixed = not any(map(self._is_open, test.sides))
        if fixed or (isinstance(test.subject, Holds) and self._needs_nothing(test.subject.operand)):
            return (first,)
        numbers = all(isinstance(s, Literal | VariableRef | ParameterRef) for s in test.sides)
        found = (n for n, outcome in enumerate(outcomes) if not (numbers and outcome != outcome))
        return first, *(number for number in found if number != first)

    def _is_open(self, side: Expr) -> bool:
        """Whether a side of a test may have several values at the start."""
        read = (part for part in walk(side) if isinstance(part, VariableRef))
        variables = self.robot.variables
        stays = any(variables[f"{part.component}.{part.variable}"].persistent for part in read)
        return stays or reads_parameters(side)

    def _needs_nothing(self, expr: Expr) -> bool:
        """Whether an expression is undefined initially, because it needs data not yet received."""
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


def data_scope(requirement: Requirement) -> Scope:
    """Return the request whose data a requirement reads."""
    return (EventKind.REQUEST, requirement.communications[0]) if requirement.on_data else None


def expected_of_error(communication: Communication) -> Expr:
    """Return the condition that the value of an error, if it has one, is as expected."""
    assert communication.expect is not None

    def leaf(node: Literal | Leaf) -> Expr:
        return replace(node, optional=True) if type(node) is ValueRef else node

    return known_condition(rewritten(communication.expect, leaf))


def update_key(component: str, transition: Transition) -> UpdateKey:
    return component, transition.event, transition.communication, transition.assignments


def may_be_missing(term: Term) -> bool:
    """Whether a part of an event's value may be missing."""
    match term:
        case ChoiceRef(test=None):
            return False
        case ChoiceRef(test=TestRef() as test):
            return any(map(may_be_undefined, test.sides))
        case ValueRef():
            return may_be_undefined(term)
    return False


def sent_wholes(provide: Provide) -> Iterator[VariableRef]:
    """Yield the objects and arrays that provided data read: no command is sent without them."""
    for expr in data_expressions(provide.data):
        for part in walk(expr):
            if isinstance(part, VariableRef) and isinstance(part.type, ArrayType | ObjectType):
                yield replace(part, span=None)
