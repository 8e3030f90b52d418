"""Builds the finite view of a model from its conditions and assignments."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TypeGuard

from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import may_be_undefined, walk, walk_all
from robosc.expr.tree import (
    Binary,
    ChoiceRef,
    Convert,
    Expr,
    Holds,
    Literal,
    ParameterRef,
    TestRef,
    Unary,
    ValueRef,
    VariableRef,
)
from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    IntegerType,
    ObjectType,
    domain,
)
from robosc.language.events import EventKind
from robosc.language.operators import EXACT_IN_DOUBLE, MIRRORED
from robosc.model.automata import Transition
from robosc.model.entities import Component, Robot
from robosc.plant.assumptions import Restrictions, conditions_of_states
from robosc.plant.data.classes import Classes, Comparison
from robosc.plant.data.disjoint_sets import DisjointSets
from robosc.plant.data.terms import (
    Term,
    Terms,
    compared_in_rules,
    compared_with_constant,
    element_asked_for,
    element_needed,
    follows_assignments,
    is_constant,
    is_presence,
    is_there,
    kept_where_undefined,
    replaces_undefined,
    sides_of,
    substituted,
    type_of_part,
    value_of,
)
from robosc.plant.data.unknown_outcomes import MAY_BE_MISSING, SEVERAL_CHANGES, WIDENED, why_free
from robosc.plant.data.view import (
    FiniteView,
    Scope,
    ScopedTerm,
    StateTerm,
    UpdateKey,
    data_scope,
    expected_of_error,
    may_be_missing,
    reference_to,
    sent_wholes,
    update_key,
)
from robosc.plant.lasting import resets
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.model_text import to_dsl
from robosc.plant.precedence import joined_transitions


def finite_view(robot: Robot, restrictions: Restrictions) -> FiniteView:
    """Return the finite view of a robot without errors, of whose events this is assumed."""
    return ViewBuilder(robot, restrictions).build()


class ViewBuilder:
    def __init__(self, robot: Robot, restrictions: Restrictions) -> None:
        self.robot = robot
        self.restrictions = restrictions
        self.terms = Terms(partial(to_dsl, robot=robot))
        self.variables = robot.variables
        self.states: dict[StateTerm, None] = {}
        """Terms of the state, in order of appearance; also the work list of :meth:`build`."""
        self.comparisons: dict[ScopedTerm, set[Comparison]] = {}
        self.groups = DisjointSets()
        """Terms that are compared with the same constants, since one is assigned to the other."""
        self.turned: list[ScopedTerm] = []
        """Terms to which the negation of another term is assigned."""
        self.updates: dict[UpdateKey, dict[StateTerm, Expr]] = {}
        self.small = True
        self.free: dict[str, str] = {}
        """Tests and values whose outcome is left open, as text, with the reason."""
        self.unknown: dict[ChoiceRef, str] = {}
        """Choices of events that represent no test, with the reason."""

    def build(self) -> FiniteView:
        deciding = ((scope, self.terms.finite(expr)) for scope, expr in self._deciding())
        for scope, expr in {(scope, id(expr)): (scope, expr) for scope, expr in deciding}.values():
            self._note(scope, expr)
        self.small = all(
            abs(constant) < EXACT_IN_DOUBLE
            for found in self.comparisons.values()
            for _, constant in found
            if isinstance(constant, int | float)
        )
        for provide in self.robot.provides:
            for variable in sent_wholes(provide):
                self.states.setdefault(self.terms.computed(Holds(variable)))
        worked = 0
        while worked < len(self.states):
            term = list(self.states)[worked]
            worked += 1
            for component, transition in self._transitions():
                update = self._update(term, component, transition)
                if update is not None:
                    key = update_key(component.name, transition)
                    self.updates.setdefault(key, {})[term] = update
                    self._join(term, (transition.event, transition.communication), update)
        classes = self._classes()
        return FiniteView(
            robot=self.robot,
            tests=tuple(t for t in self.states if isinstance(t, TestRef)),
            variables={
                f"{t.component}.{t.variable}": classes[None, t]
                for t in self.states
                if isinstance(t, VariableRef)
            },
            free=self.free,
            _terms=self.terms,
            _classes=classes,
            _updates={key: tuple(found.items()) for key, found in self.updates.items()},
        )

    # --- what decides

    def _transitions(self) -> Iterator[tuple[Component, Transition]]:
        for component in self.robot.components:
            if component.behaviour is not None:
                for transition in joined_transitions(component.behaviour):
                    yield component, transition

    def _deciding(self) -> Iterator[tuple[Scope, Expr]]:
        for component, transition in self._transitions():
            scope = transition.event, transition.communication
            if transition.guard is not None:
                yield scope, transition.guard
            for assignment in transition.assignments:
                variable = self.variables[f"{component.name}.{assignment.variable}"]
                if variable.in_state and domain(variable.type) is not None:
                    yield scope, kept_where_undefined(reference_to(variable), assignment.value)
        for key, communication in self.robot.communications.items():
            if communication.expect is not None:
                yield (EventKind.RESPONSE, key), communication.expect
                yield (EventKind.ERROR, key), expected_of_error(communication)
        yield from ((data_scope(r), r.condition) for r in self.robot.requirements)
        yield from ((None, expr) for goal in self.robot.goals for expr in goal.conditions)
        for event, assumed in self.restrictions.items():
            yield from ((event, restriction.condition) for restriction in assumed)
        yield from ((None, condition) for condition, _ in conditions_of_states(self.robot))
        yield from (((kind, key), reset.kept) for (kind, key, _), reset in resets(self.robot))
        for provide in self.robot.provides:
            if provide.deciding is not None:
                yield None, provide.deciding

    def _note(self, scope: Scope, expr: Expr) -> None:
        """Record the terms of a deciding expression, and what they are compared with."""
        for part in walk_all([expr]):
            if isinstance(part, TestRef):
                self.states.setdefault(part)
                if follows_assignments(part):
                    continue
            if isinstance(part.type, BooleanType):
                for side in sides_of(part):
                    if _is_free(side):
                        self.free.setdefault(to_dsl(part, self.robot), why_free(side))
            match part:
                case Binary():
                    compared = compared_with_constant(part)
                    if compared is not None and _is_term(compared[1]):
                        self._compare(scope, *compared)
                case Convert(argument=argument) if _is_term(argument):
                    for operator, constant in compared_in_rules(part) or ():
                        self._compare(scope, operator, argument, constant)
                case Holds(operand=ValueRef() as asked) if domain(asked.type) is None:
                    self.comparisons.setdefault(self._node(scope, asked), set())

    def _compare(self, scope: Scope, operator: str, term: Expr, constant: Expr) -> None:
        assert isinstance(term, VariableRef | ValueRef | TestRef)
        value = evaluate(constant, lambda leaf: None)
        self.comparisons.setdefault(self._node(scope, term), set()).add((operator, value))
        if isinstance(term, VariableRef):
            self.states.setdefault(term)

    # --- what assignments do

    def _update(self, term: StateTerm, component: Component, transition: Transition) -> Expr | None:
        given = {
            (component.name, assignment.variable): assignment.value
            for assignment in transition.assignments
            # What is assigned to itself does not change.
            if assignment.value
            != VariableRef(component.name, assignment.variable, assignment.value.type)
        }
        if isinstance(term, VariableRef):
            value = given.get((term.component, term.variable))
            return None if value is None else self._assigned(term, value)
        parts = [part for side in term.sides for part in walk(side)]
        read = {(p.component, p.variable) for p in parts if isinstance(p, VariableRef)}
        changed = read & given.keys()
        if not changed:
            return None
        copied = [value for value in map(given.get, changed) if isinstance(value, VariableRef)]
        together = self._together(read, component, transition)
        alone = len(changed) == len(copied) == 1 and not together
        followed = element_asked_for(term.subject) is not None or is_presence(term.subject)
        if alone and followed:
            return self._copied(term, copied[0], given)
        uncertain = any(may_be_undefined(given[name]) for name in changed)
        # An assignment of an undefined value has no effect, so only some may happen.
        if together or (uncertain and len(changed) > 1):
            return self._anything(term, SEVERAL_CHANGES)
        if uncertain and is_presence(term.subject) and len(changed) == 1:
            asked = element_needed(given[next(iter(changed))], transition, self.robot)
            if asked is not None:  # what is not there leaves the variable as it was
                return disjunction([self.terms.finite(Holds(asked)), term])
        # These are defined where what is assigned is not.
        if uncertain and any(map(replaces_undefined, parts)):
            return self._anything(term, MAY_BE_MISSING)
        if any(self._rounded(name, given[name]) for name in changed):
            return self._anything(term, WIDENED)
        return self._substituted(term, given)

    def _anything(self, term: StateTerm, reason: str) -> ChoiceRef:
        """Return a choice by the environment: any value of the term.

        Its name is that of the whole term: tests of one variable against different things change
        independently of each other.
        """
        name = term.name if isinstance(term, TestRef) else to_dsl(term, self.robot)
        choice = ChoiceRef((f"new {name}",), term.type, renews=term)
        self.unknown.setdefault(choice, reason)
        return choice

    def _copied(
        self, test: TestRef, source: VariableRef, given: Mapping[tuple[str, str], Expr]
    ) -> Expr:
        """Return a test of presence or of an element after a copy.

        It is unchanged if the source is missing.
        """
        there = self.terms.computed(Holds(replace(source, span=None)))
        self.states.setdefault(there)
        copied = self._substituted(test, given)
        kept = conjunction([negation(there), test])
        return disjunction([conjunction([there, copied]), kept])

    def _rounded(self, name: tuple[str, str], value: Expr) -> bool:
        """Whether an integer is converted to a double, which may change its value."""
        double = isinstance(self.variables[".".join(name)].type, DoubleType)
        return double and isinstance(value.type, IntegerType) and not is_constant(value)

    def _together(
        self, read: set[tuple[str, str]], component: Component, transition: Transition
    ) -> bool:
        """Whether another component may change what a test reads at the same time."""
        return any(
            other.name != component.name
            and (also.event, also.communication) == (transition.event, transition.communication)
            and any((other.name, a.variable) in read for a in also.assignments)
            for other, also in self._transitions()
        )

    def _assigned(self, variable: VariableRef, value: Expr) -> Expr:
        """Return what is assigned to a variable with classes, in terms of the plant."""
        if is_constant(value):
            return value
        if self._rounded((variable.component, variable.variable), value) and not self.small:
            return self._anything(variable, WIDENED)
        if isinstance(value, ParameterRef):
            return self._parameter(value)
        if isinstance(value, VariableRef | ValueRef):
            if isinstance(value, VariableRef) and domain(value.type) is None:
                self.states.setdefault(replace(value, span=None))
            return value
        return self._known(self.terms.computed(value))

    def _parameter(self, reference: ParameterRef) -> TestRef:
        """Return a parameter as a term of the state."""
        test = self.terms.computed(replace(reference, span=None))
        self.states.setdefault(test)
        return test

    def _substituted(self, test: TestRef, given: Mapping[tuple[str, str], Expr]) -> Expr:
        subject = substituted(test.subject, given)
        if test.other is None:
            if is_there(subject):
                return Literal(True, test.type)
            if is_constant(subject):
                return Literal(evaluate(subject, lambda leaf: None), test.type)
            if element_asked_for(test.subject) is not None:
                return self._after_assignment(test.subject, subject, given)
            return self._known(self.terms.computed(subject))
        other = substituted(test.other, given)
        if is_constant(subject) and is_constant(other):
            constant = TestRef(subject, other, test.type, "")
            return Literal(value_of(constant, lambda leaf: None), test.type)
        pair, swapped = self.terms.pair(subject, other)
        found = self._known(pair)
        return Unary("-", found, test.type) if swapped else found

    def _after_assignment(
        self, before: Expr, after: Expr, given: Mapping[tuple[str, str], Expr]
    ) -> Expr:
        """Return a test of one array element after an assignment to the array.

        The outcome is known if the received value, or a part of another variable, is assigned.
        """
        part, test = element_asked_for(before), self.terms.computed(after)
        assert part is not None and isinstance(part.operand, VariableRef)
        assigned = given[part.operand.component, part.operand.variable]
        whole = isinstance(after, Holds) and isinstance(after.operand.type, ArrayType | ObjectType)
        if isinstance(assigned, ValueRef) and isinstance(after, Holds) and not whole:
            found = self.terms.finite(after.operand)
            chosen = any(isinstance(leaf, ChoiceRef) for leaf in walk(found))
            # A number with a range has no classes.
            if not chosen and type_of_part(assigned.type, part.path) == part.type:
                return replace(after, operand=found)
        elif element_asked_for(after) is not None:
            self.states.setdefault(test)
        return self._known(test)

    def _known(self, test: TestRef) -> TestRef | ChoiceRef:
        """Return the test if it is a term of the state, else a choice of the event."""
        return test if test in self.states else self.terms.choice(test)

    # --- classes

    def _node(self, scope: Scope, term: Term) -> ScopedTerm:
        return (scope if isinstance(term, ValueRef) else None), term

    def _join(self, term: Term, scope: Scope, update: Expr) -> None:
        if isinstance(update, Holds):
            self._note(scope, update)
        elif isinstance(update, ChoiceRef):
            self._note_choice(term, update)
        if isinstance(update, Unary):
            self.turned.append((None, term))
            update = update.operand
        if isinstance(update, VariableRef | ValueRef | TestRef) and domain(update.type) is None:
            node = self._node(scope, update)
            self.comparisons.setdefault(node, set())
            self.groups.join([(None, term), node])

    def _note_choice(self, term: Term, update: ChoiceRef) -> None:
        """Record that an event changes a term to an unknown outcome."""
        reason = self.unknown.get(update) or why_free(update)
        if follows_assignments(term):
            self.free.setdefault(term.name, reason)
        elif isinstance(term, VariableRef):
            name = to_dsl(term, self.robot) if update.test is None else update.test.name
            self.free.setdefault(name, reason)

    def _classes(self) -> dict[ScopedTerm, Classes]:
        find = self.groups.find
        turned = set(map(find, self.turned))
        groups: dict[Hashable, set[Comparison]] = {}
        for node, found in self.comparisons.items():
            leader = find(node)
            more = {(MIRRORED[op], c) for op, c in found} if leader in turned else set()
            groups.setdefault(leader, set()).update(found, more)
        for term in self.states:
            if domain(term.type) is None:
                self.comparisons.setdefault((None, term), set())
        return {
            node: Classes(
                node[1].type,
                frozenset(groups.get(find(node), set())),
                may_be_missing(node[1]),
            )
            for node in self.comparisons
        }


def _is_free(expr: Expr) -> TypeGuard[TestRef | ChoiceRef]:
    """Whether the outcome of a term is open. A parameter's value is fixed, though unknown."""
    if isinstance(expr, TestRef) and isinstance(expr.subject, ParameterRef):
        return expr.other is not None
    return isinstance(expr, TestRef | ChoiceRef)


def _is_term(expr: Expr) -> bool:
    return isinstance(expr, VariableRef | ValueRef | TestRef) and domain(expr.type) is None
