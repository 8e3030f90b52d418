"""Builds the finite view of a model from its conditions and assignments."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TypeAlias, TypeGuard

from robosc.expr import evaluation, traversal, tree, types
from robosc.language import events, operators
from robosc.model.automata import Transition
from robosc.model.entities import Component, Robot
from robosc.plant import logic, model_text, precedence
from robosc.plant.assumptions import Restrictions, conditions_of_states
from robosc.plant.data import disjoint_sets, terms, view
from robosc.plant.data.classes import Classes, Comparison
from robosc.plant.lasting import resets

# The reasons, as text for users, why the plant does not know the outcome of a test of data.


MAY_BE_MISSING = "it is assigned a part of a variable that may be missing"
SEVERAL_CHANGES = "one event changes several things that it reads"
WIDENED = "an integer that may be too large for a double is assigned to one"


def why_free(term: tree.TestRef | tree.ChoiceRef) -> str:
    """Return why the outcome of a test, or of an assignment to what it reads, is unknown."""
    test = term.test if isinstance(term, tree.ChoiceRef) else term
    assert test is not None, "a choice without a test has its own reason"
    parts = [part for side in test.sides for part in traversal.walk(side)]
    if any(map(terms.reads_parameters, test.sides)):
        return "it reads a parameter"
    if any(isinstance(part, tree.Aggregate) for part in parts):
        return "it goes through the elements of an array"
    called = [part.operator for part in parts if isinstance(part, tree.Call)]
    if "section" in called or "sector" in called:
        return "it reads a part of an array"
    if "element" in called:
        return "it reads a computed or negative index"
    read = set(_read(parts))
    if len(read) > 1:
        incoming = [isinstance(each, tree.ValueRef) for each in read]
        if any(incoming) and not all(incoming):
            return "it reads a received value and a variable"
        return "it reads more than one number or string"
    if called:
        return f"it calls {called[0]}(…)"
    if any(isinstance(part, tree.Convert) for part in parts):
        return "the rules of the enum do not only compare with constants"
    if any(isinstance(part, tree.Binary | tree.Unary) and not _asks(part) for part in parts):
        return "it is computed"
    if any(isinstance(part, tree.Part) for part in parts):
        return "it is a part of a variable, and is assigned to another variable"
    if any(isinstance(part, tree.ValueRef) and part.optional for part in parts):
        return "an error may come without a value"
    return "what is assigned is of another type"


def _asks(part: tree.Binary | tree.Unary) -> bool:
    """Whether this is a comparison or a connective; otherwise it computes a number or a string."""
    return part.operator == "!" or (
        isinstance(part, tree.Binary) and (part.operation.is_comparison or part.operation.is_lazy)
    )


def _read(parts: list[tree.Expr]) -> Iterator[tree.Expr]:
    """Yield the distinct data that are read."""
    whole = {part.operand for part in parts if isinstance(part, tree.Part)}
    for part in parts:
        if isinstance(part, tree.Part | tree.ValueRef | tree.ParameterRef) or (
            isinstance(part, tree.VariableRef) and part not in whole
        ):
            yield part


_Name: TypeAlias = tuple[str, str]
"""A component and its variable."""


def _read_by(term: view.StateTerm) -> set[_Name]:
    """Return the variables that a term reads."""
    sides = [term] if isinstance(term, tree.VariableRef) else term.sides
    parts = (part for side in sides for part in traversal.walk(side))
    return {(p.component, p.variable) for p in parts if isinstance(p, tree.VariableRef)}


def finite_view(robot: Robot, restrictions: Restrictions) -> view.FiniteView:
    """Return the finite view of a robot without errors, of whose events this is assumed."""
    return ViewBuilder(robot, restrictions).build()


class ViewBuilder:
    def __init__(self, robot: Robot, restrictions: Restrictions) -> None:
        self.robot = robot
        self.restrictions = restrictions
        self.terms = terms.Terms(partial(model_text.to_dsl, robot=robot))
        self.variables = robot.variables
        self.states: dict[view.StateTerm, None] = {}
        """Terms of the state, in order of appearance; also the work list of :meth:`build`."""
        self.comparisons: dict[view.ScopedTerm, set[Comparison]] = {}
        self.groups = disjoint_sets.DisjointSets()
        """Terms that are compared with the same constants, since one is assigned to the other."""
        self.turned: list[view.ScopedTerm] = []
        """Terms to which the negation of another term is assigned."""
        self.updates: dict[view.UpdateKey, dict[view.StateTerm, tree.Expr]] = {}
        self.small = True
        self.free: dict[str, str] = {}
        """Tests and values whose outcome is left open, as text, with the reason."""
        self.unknown: dict[tree.ChoiceRef, str] = {}
        """Choices of events that represent no test, with the reason."""

    def build(self) -> view.FiniteView:
        deciding = ((scope, self.terms.finite(expr)) for scope, expr in self._deciding())
        for scope, expr in {(scope, id(expr)): (scope, expr) for scope, expr in deciding}.values():
            self._note(scope, expr)
        self.small = all(
            abs(constant) < operators.EXACT_IN_DOUBLE
            for found in self.comparisons.values()
            for _, constant in found
            if isinstance(constant, int | float)
        )
        for provide in self.robot.provides:
            for variable in view.sent_wholes(provide):
                self.states.setdefault(self.terms.computed(tree.Holds(variable)))
        worked = 0
        while worked < len(self.states):
            term = list(self.states)[worked]
            worked += 1
            assigning = {n for name in _read_by(term) for n in self._assigning.get(name, ())}
            for component, transition in map(self._transitions.__getitem__, sorted(assigning)):
                update = self._update(term, component, transition)
                if update is not None:
                    key = view.update_key(component.name, transition)
                    self.updates.setdefault(key, {})[term] = update
                    self._join(term, (transition.event, transition.communication), update)
        classes = self._classes()
        return view.FiniteView(
            robot=self.robot,
            tests=tuple(t for t in self.states if isinstance(t, tree.TestRef)),
            variables={
                f"{t.component}.{t.variable}": classes[None, t]
                for t in self.states
                if isinstance(t, tree.VariableRef)
            },
            free=self.free,
            _terms=self.terms,
            _classes=classes,
            _updates={key: tuple(found.items()) for key, found in self.updates.items()},
        )

    # --- what decides

    @cached_property
    def _transitions(self) -> Sequence[tuple[Component, Transition]]:
        return [
            (component, transition)
            for component in self.robot.components
            for transition in precedence.joined_transitions(component.behaviour)
        ]

    @cached_property
    def _assigning(self) -> Mapping[_Name, Sequence[int]]:
        """The transitions that assign a variable."""
        found: dict[_Name, list[int]] = defaultdict(list)
        for number, (component, transition) in enumerate(self._transitions):
            for assignment in transition.assignments:
                found[component.name, assignment.variable].append(number)
        return found

    def _deciding(self) -> Iterator[tuple[view.Scope, tree.Expr]]:
        for component, transition in self._transitions:
            scope = transition.event, transition.communication
            if transition.guard is not None:
                yield scope, transition.guard
            for assignment in transition.assignments:
                variable = self.variables[f"{component.name}.{assignment.variable}"]
                if variable.in_state and types.domain(variable.type) is not None:
                    yield (
                        scope,
                        terms.kept_where_undefined(view.reference_to(variable), assignment.value),
                    )
        for key, communication in self.robot.communications.items():
            if communication.expect is not None:
                yield (events.EventKind.RESPONSE, key), communication.expect
                yield (events.EventKind.ERROR, key), view.expected_of_error(communication)
        yield from ((view.data_scope(r), r.condition) for r in self.robot.requirements)
        yield from ((None, expr) for goal in self.robot.goals for expr in goal.conditions)
        for event, assumed in self.restrictions.items():
            yield from ((event, restriction.condition) for restriction in assumed)
        yield from ((None, condition) for condition, _ in conditions_of_states(self.robot))
        yield from (((kind, key), reset.kept) for (kind, key, _), reset in resets(self.robot))
        for provide in self.robot.provides:
            if provide.deciding is not None:
                yield None, provide.deciding

    def _note(self, scope: view.Scope, expr: tree.Expr) -> None:
        """Record the terms of a deciding expression, and what they are compared with."""
        for part in traversal.walk_all([expr]):
            if isinstance(part, tree.TestRef):
                self.states.setdefault(part)
                if terms.follows_assignments(part):
                    continue
            if isinstance(part.type, types.BooleanType):
                for side in terms.sides_of(part):
                    if _is_free(side):
                        self.free.setdefault(model_text.to_dsl(part, self.robot), why_free(side))
            match part:
                case tree.Binary():
                    compared = terms.compared_with_constant(part)
                    if compared is not None and _is_term(compared[1]):
                        self._compare(scope, *compared)
                case tree.Convert(argument=argument) if _is_term(argument):
                    for operator, constant in terms.compared_in_rules(part) or ():
                        self._compare(scope, operator, argument, constant)
                case tree.Holds(operand=tree.ValueRef() as asked) if (
                    types.domain(asked.type) is None
                ):
                    self.comparisons.setdefault(self._node(scope, asked), set())

    def _compare(
        self, scope: view.Scope, operator: str, term: tree.Expr, constant: tree.Expr
    ) -> None:
        assert isinstance(term, tree.VariableRef | tree.ValueRef | tree.TestRef)
        value = evaluation.evaluate(constant, lambda leaf: None)
        self.comparisons.setdefault(self._node(scope, term), set()).add((operator, value))
        if isinstance(term, tree.VariableRef):
            self.states.setdefault(term)

    # --- what assignments do

    def _update(
        self, term: view.StateTerm, component: Component, transition: Transition
    ) -> tree.Expr | None:
        given = {
            (component.name, assignment.variable): assignment.value
            for assignment in transition.assignments
            # What is assigned to itself does not change.
            if assignment.value
            != tree.VariableRef(component.name, assignment.variable, assignment.value.type)
        }
        if isinstance(term, tree.VariableRef):
            value = given.get((term.component, term.variable))
            return None if value is None else self._assigned(term, value)
        read = _read_by(term)
        changed = read & given.keys()
        if not changed:
            return None
        copied = [value for value in map(given.get, changed) if isinstance(value, tree.VariableRef)]
        together = self._together(read, component, transition)
        alone = len(changed) == len(copied) == 1 and not together
        followed = terms.element_asked_for(term.subject) is not None or terms.is_presence(
            term.subject
        )
        if alone and followed:
            return self._copied(term, copied[0], given)
        uncertain = any(traversal.may_be_undefined(given[name]) for name in changed)
        # An assignment of an undefined value has no effect, so only some may happen.
        if together or (uncertain and len(changed) > 1):
            return self._anything(term, SEVERAL_CHANGES)
        if uncertain and terms.is_presence(term.subject) and len(changed) == 1:
            asked = terms.element_needed(given[next(iter(changed))], transition, self.robot)
            if asked is not None:  # what is not there leaves the variable as it was
                return logic.disjunction([self.terms.finite(tree.Holds(asked)), term])
        # These are defined where what is assigned is not.
        parts = (part for side in term.sides for part in traversal.walk(side))
        if uncertain and any(map(terms.replaces_undefined, parts)):
            return self._anything(term, MAY_BE_MISSING)
        if any(self._rounded(name, given[name]) for name in changed):
            return self._anything(term, WIDENED)
        return self._substituted(term, given)

    def _anything(self, term: view.StateTerm, reason: str) -> tree.ChoiceRef:
        """Return a choice by the environment: any value of the term.

        Its name is that of the whole term: tests of one variable against different things change
        independently of each other.
        """
        name = term.name if isinstance(term, tree.TestRef) else model_text.to_dsl(term, self.robot)
        choice = tree.ChoiceRef((f"new {name}",), term.type, renews=term)
        self.unknown.setdefault(choice, reason)
        return choice

    def _copied(
        self,
        test: tree.TestRef,
        source: tree.VariableRef,
        given: Mapping[tuple[str, str], tree.Expr],
    ) -> tree.Expr:
        """Return a test of presence or of an element after a copy.

        It is unchanged if the source is missing.
        """
        there = self.terms.computed(tree.Holds(replace(source, span=None)))
        self.states.setdefault(there)
        copied = self._substituted(test, given)
        kept = logic.conjunction([logic.negation(there), test])
        return logic.disjunction([logic.conjunction([there, copied]), kept])

    def _rounded(self, name: tuple[str, str], value: tree.Expr) -> bool:
        """Whether an integer is converted to a double, which may change its value."""
        double = isinstance(self.variables[".".join(name)].type, types.DoubleType)
        return double and isinstance(value.type, types.IntegerType) and not terms.is_constant(value)

    def _together(self, read: set[_Name], component: Component, transition: Transition) -> bool:
        """Whether another component may change what a test reads at the same time."""
        return any(
            name[0] != component.name
            and (also.event, also.communication) == (transition.event, transition.communication)
            for name in read
            for _, also in map(self._transitions.__getitem__, self._assigning.get(name, ()))
        )

    def _assigned(self, variable: tree.VariableRef, value: tree.Expr) -> tree.Expr:
        """Return what is assigned to a variable with classes, in terms of the plant."""
        if terms.is_constant(value):
            return value
        if self._rounded((variable.component, variable.variable), value) and not self.small:
            return self._anything(variable, WIDENED)
        if isinstance(value, tree.ParameterRef):
            return self._parameter(value)
        if isinstance(value, tree.VariableRef | tree.ValueRef):
            if isinstance(value, tree.VariableRef) and types.domain(value.type) is None:
                self.states.setdefault(replace(value, span=None))
            return value
        return self._known(self.terms.computed(value))

    def _parameter(self, reference: tree.ParameterRef) -> tree.TestRef:
        """Return a parameter as a term of the state."""
        test = self.terms.computed(replace(reference, span=None))
        self.states.setdefault(test)
        return test

    def _substituted(
        self, test: tree.TestRef, given: Mapping[tuple[str, str], tree.Expr]
    ) -> tree.Expr:
        subject = terms.substituted(test.subject, given)
        if test.other is None:
            if terms.is_there(subject):
                return tree.Literal(True, test.type)
            if terms.is_constant(subject):
                return tree.Literal(evaluation.evaluate(subject, lambda leaf: None), test.type)
            if terms.element_asked_for(test.subject) is not None:
                return self._after_assignment(test.subject, subject, given)
            return self._known(self.terms.computed(subject))
        other = terms.substituted(test.other, given)
        if terms.is_constant(subject) and terms.is_constant(other):
            constant = tree.TestRef(subject, other, test.type, "")
            return tree.Literal(terms.value_of(constant, lambda leaf: None), test.type)
        pair, swapped = self.terms.pair(subject, other)
        found = self._known(pair)
        return tree.Unary("-", found, test.type) if swapped else found

    def _after_assignment(
        self, before: tree.Expr, after: tree.Expr, given: Mapping[tuple[str, str], tree.Expr]
    ) -> tree.Expr:
        """Return a test of one array element after an assignment to the array.

        The outcome is known if the received value, or a part of another variable, is assigned.
        """
        part, test = terms.element_asked_for(before), self.terms.computed(after)
        assert part is not None and isinstance(part.operand, tree.VariableRef)
        assigned = given[part.operand.component, part.operand.variable]
        whole = isinstance(after, tree.Holds) and isinstance(
            after.operand.type, types.ArrayType | types.ObjectType
        )
        if isinstance(assigned, tree.ValueRef) and isinstance(after, tree.Holds) and not whole:
            found = self.terms.finite(after.operand)
            chosen = any(isinstance(leaf, tree.ChoiceRef) for leaf in traversal.walk(found))
            # A number with a range has no classes.
            if not chosen and terms.type_of_part(assigned.type, part.path) == part.type:
                return replace(after, operand=found)
        elif terms.element_asked_for(after) is not None:
            self.states.setdefault(test)
        return self._known(test)

    def _known(self, test: tree.TestRef) -> tree.TestRef | tree.ChoiceRef:
        """Return the test if it is a term of the state, else a choice of the event."""
        return test if test in self.states else self.terms.choice(test)

    # --- classes

    def _node(self, scope: view.Scope, term: terms.Term) -> view.ScopedTerm:
        return (scope if isinstance(term, tree.ValueRef) else None), term

    def _join(self, term: terms.Term, scope: view.Scope, update: tree.Expr) -> None:
        for part in traversal.walk(update):
            if isinstance(part, tree.Holds):
                self._note(scope, part)
        if isinstance(update, tree.ChoiceRef):
            self._note_choice(term, update)
        if isinstance(update, tree.Unary):
            self.turned.append((None, term))
            update = update.operand
        if (
            isinstance(update, tree.VariableRef | tree.ValueRef | tree.TestRef)
            and types.domain(update.type) is None
        ):
            node = self._node(scope, update)
            self.comparisons.setdefault(node, set())
            self.groups.join([(None, term), node])

    def _note_choice(self, term: terms.Term, update: tree.ChoiceRef) -> None:
        """Record that an event changes a term to an unknown outcome."""
        reason = self.unknown.get(update) or why_free(update)
        if terms.follows_assignments(term):
            self.free.setdefault(term.name, reason)
        elif isinstance(term, tree.VariableRef):
            name = model_text.to_dsl(term, self.robot) if update.test is None else update.test.name
            self.free.setdefault(name, reason)

    def _classes(self) -> dict[view.ScopedTerm, Classes]:
        find = self.groups.find
        turned = set(map(find, self.turned))
        groups: dict[Hashable, set[Comparison]] = {}
        for node, found in self.comparisons.items():
            leader = find(node)
            more = {(operators.MIRRORED[op], c) for op, c in found} if leader in turned else set()
            groups.setdefault(leader, set()).update(found, more)
        for term in self.states:
            if types.domain(term.type) is None:
                self.comparisons.setdefault((None, term), set())
        return {
            node: Classes(
                node[1].type,
                frozenset(groups.get(find(node), set())),
                view.may_be_missing(node[1]),
            )
            for node in self.comparisons
        }


def _is_free(expr: tree.Expr) -> TypeGuard[tree.TestRef | tree.ChoiceRef]:
    """Whether the outcome of a term is open. A parameter's value is fixed, though unknown."""
    if isinstance(expr, tree.TestRef) and isinstance(expr.subject, tree.ParameterRef):
        return expr.other is not None
    return isinstance(expr, tree.TestRef | tree.ChoiceRef)


def _is_term(expr: tree.Expr) -> bool:
    return (
        isinstance(expr, tree.VariableRef | tree.ValueRef | tree.TestRef)
        and types.domain(expr.type) is None
    )
