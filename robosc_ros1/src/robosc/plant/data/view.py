"""The finite view of a model: its terms, their classes, and the effect of assignments on them.

The effect is that of Dijkstra's weakest precondition: after ``x := e``, the term ``f(x)`` has the
value that ``f(e)`` had before. If ``f(e)`` is a constant, a term of the plant or a part of
``value``, the update is exact. Otherwise it is a choice by the environment, the same one for equal
expressions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from robosc.expr import traversal, tree, undefined_data
from robosc.expr.types import ArrayType, ObjectType, Value
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model import automata, entities
from robosc.plant.data import classes, terms
from robosc.plant.logic import negation

Scope: TypeAlias = tuple[EventKind, str] | None
"""The event whose value ``value`` is: its kind and its communication's key."""
ScopedTerm: TypeAlias = tuple[Scope, terms.Term]
"""A term, with the event if it is one of ``value``, else None."""
StateTerm: TypeAlias = tree.VariableRef | tree.TestRef
UpdateKey: TypeAlias = tuple[str, EventKind, str, tuple[automata.Assignment, ...]]
"""The component, event, communication and simultaneous assignments of a transition."""


@dataclass(frozen=True, eq=False)
class FiniteView:
    """The representation of a robot's data in the plant.

    ``variables`` are the classes of compared variables, by key; ``tests`` are the other terms of
    the state. ``free`` are the tests and computed values, as text, for which the plant allows every
    outcome, each with the reason.
    """

    robot: entities.Robot
    tests: tuple[tree.TestRef, ...]
    variables: Mapping[str, classes.Classes]
    free: Mapping[str, str]
    _terms: terms.Terms
    _classes: Mapping[ScopedTerm, classes.Classes]
    _updates: Mapping[UpdateKey, tuple[tuple[StateTerm, tree.Expr], ...]]

    def expression(self, expr: tree.Expr) -> tree.Expr:
        """Return a deciding expression in terms of the plant."""
        return self._terms.finite(expr)

    def met(self, requirement: entities.Requirement) -> tree.Expr:
        """Return the condition under which a requirement is met, in terms of the plant."""
        condition = self.expression(requirement.condition)
        return negation(condition) if requirement.forbids else condition

    def assigned(self, variable: automata.Variable, value: tree.Expr) -> tree.Expr:
        """Return the value, in terms of the plant, that an assignment gives to a finite
        variable."""
        return self._terms.finite(terms.kept_where_undefined(reference_to(variable), value))

    def updates(
        self, component: str, transition: automata.Transition
    ) -> tuple[tuple[StateTerm, tree.Expr], ...]:
        """Return the new values of the terms of the state that a transition changes."""
        return self._updates.get(update_key(component, transition), ())

    def values(self, scope: Scope, term: terms.Term) -> classes.Classes | None:
        """Return the classes of a term that is an unbounded number or a string; None for other
        terms."""
        return self._classes.get((scope, term))

    def is_there(self, variable: tree.VariableRef) -> tree.TestRef:
        """Return the test that an object or an array, which provided data read, has been
        received."""
        return self._terms.computed(tree.Holds(variable))

    def starts(self, test: tree.TestRef, outcomes: Sequence[Value]) -> tuple[int, ...]:
        """Return the indexes of the possible initial outcomes of a test, that of the defaults
        first.

        A test that reads parameters or persistent variables can have any outcome, but not NaN if it
        only compares parameters, variables and constants.
        """

        def initial(leaf: tree.Leaf) -> Value | None:
            assert isinstance(leaf, tree.VariableRef)
            return self.robot.variables[f"{leaf.component}.{leaf.variable}"].initial

        first = outcomes.index(terms.value_of(test, initial))
        fixed = not any(map(self._is_open, test.sides))
        if fixed or (
            isinstance(test.subject, tree.Holds) and self._needs_nothing(test.subject.operand)
        ):
            return (first,)
        numbers = all(
            isinstance(s, tree.Literal | tree.VariableRef | tree.ParameterRef) for s in test.sides
        )
        found = (n for n, outcome in enumerate(outcomes) if not (numbers and outcome != outcome))
        return first, *(number for number in found if number != first)

    def _is_open(self, side: tree.Expr) -> bool:
        """Whether a side of a test may have several values at the start."""
        read = (part for part in traversal.walk(side) if isinstance(part, tree.VariableRef))
        variables = self.robot.variables
        stays = any(variables[f"{part.component}.{part.variable}"].persistent for part in read)
        return stays or terms.reads_parameters(side)

    def _needs_nothing(self, expr: tree.Expr) -> bool:
        """Whether an expression is undefined initially, because it needs data not yet received."""
        match expr:
            case tree.VariableRef(component=component, variable=name):
                return self.robot.variables[f"{component}.{name}"].initial is None
            case tree.Binary(left=left) if expr.operation.is_lazy:
                return self._needs_nothing(left)
            case tree.Aggregate(array=array):
                return self._needs_nothing(array)
            case tree.Holds():
                return False
        return isinstance(expr, tree.Operation) and any(map(self._needs_nothing, expr.operands))


def reference_to(variable: automata.Variable) -> tree.VariableRef:
    return tree.VariableRef(variable.component, variable.name, variable.type)


def data_scope(requirement: entities.Requirement) -> Scope:
    """Return the request whose data a requirement reads."""
    return (EventKind.REQUEST, requirement.communications[0]) if requirement.on_data else None


def expected_of_error(communication: entities.Communication) -> tree.Expr:
    """Return the condition that the value of an error, if it has one, is as expected."""
    assert communication.expect is not None

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        return replace(node, optional=True) if type(node) is tree.ValueRef else node

    return undefined_data.known_condition(traversal.rewritten(communication.expect, leaf))


def update_key(component: str, transition: automata.Transition) -> UpdateKey:
    return component, transition.event, transition.communication, transition.assignments


def may_be_missing(term: terms.Term) -> bool:
    """Whether a part of an event's value may be missing."""
    match term:
        case tree.ChoiceRef(test=None):
            return False
        case tree.ChoiceRef(test=tree.TestRef() as test):
            return any(map(traversal.may_be_undefined, test.sides))
        case tree.ValueRef():
            return traversal.may_be_undefined(term)
    return False


def sent_wholes(provide: entities.Provide) -> Iterator[tree.VariableRef]:
    """Yield the objects and arrays that provided data read: no command is sent without them."""
    for expr in entities.data_expressions(provide.data):
        for part in traversal.walk(expr):
            if isinstance(part, tree.VariableRef) and isinstance(part.type, ArrayType | ObjectType):
                yield replace(part, span=None)
