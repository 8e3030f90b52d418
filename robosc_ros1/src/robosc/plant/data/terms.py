"""Terms: the tests of data in conditions, which the plant represents by finitely many outcomes.

Data are unbounded numbers, strings, and what is computed from them. A comparison of a variable or a
part of ``value`` with a constant is kept; its term is that variable or part. So is a conversion to
an enum whose rules are such comparisons. Any other test becomes a
:class:`~robosc.expr.tree.TestRef`, a boolean or compared with a constant. A parameter is a test
with an unknown outcome that never changes. ``A.x > A.y``, ``A.y < A.x`` and ``A.x <= A.y`` all
compare the *order* of x and y with 0, so that conditions which exclude each other in the data do so
in the plant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias, TypeGuard

from robosc.expr import identity_cache, tree, types
from robosc.expr.evaluation import evaluate
from robosc.expr.traversal import (
    may_be_undefined,
    parameters_of,
    reads_value,
    rewritten,
    walk,
    with_operands,
)
from robosc.expr.undefined_data import condition_on_data
from robosc.language.operators import MIRRORED
from robosc.model.automata import Transition
from robosc.model.entities import Robot
from robosc.plant import logic
from robosc.plant.data.cases import by_state, by_value, reads_arrays, reads_states

Term: TypeAlias = tree.VariableRef | tree.ValueRef | tree.TestRef

_BOOLEAN = types.BooleanType()


def is_constant(expr: tree.Expr) -> bool:
    """Whether an expression has no variable parts."""
    reads = any(not isinstance(part, tree.Literal | tree.Operation) for part in walk(expr))
    return not reads and not reads_parameters(expr)


def reads_parameters(expr: tree.Expr) -> bool:
    """Whether an expression reads parameters, also in the rules of enums."""
    return any(True for _ in parameters_of(expr))


def reads_data(expr: tree.Expr) -> bool:
    """Whether the value of an expression depends on data that are not finite."""
    return any(
        reads_parameters(part)
        if isinstance(part, tree.Convert)
        else types.domain(part.type) is None
        and not isinstance(part, tree.Literal | tree.Operation | tree.ElementRef)
        for part in walk(expr)
    )


def compared_in_rules(expr: tree.Convert) -> list[tuple[str, tree.Expr]] | None:
    """Return the operators and constants of the comparisons in the rules of an enum.

    None if the rules have other conditions, or if the argument is not a variable or a part of
    ``value``.
    """
    if not isinstance(expr.argument, tree.VariableRef | tree.ValueRef) or not expr.type.rules:
        return None
    comparisons: list[tuple[str, tree.Expr]] = []
    work: list[tree.Expr] = [tree.condition_of(rule) for rule in expr.type.rules]
    while work:
        match work.pop():
            case tree.Unary(operator="!", operand=operand):
                work.append(operand)
            case tree.Binary(left=left, right=right) as both if both.operation.is_lazy:
                work += [left, right]
            case part:
                match compared_with_constant(part):
                    case operator, tree.ValueRef(path=()) as value, constant if (
                        types.domain(value.type) is None
                    ):
                        comparisons.append((operator, constant))
                    case _:
                        return None
    return comparisons


def compared_with_constant(expr: tree.Expr) -> tuple[str, tree.Expr, tree.Expr] | None:
    """Return a comparison with a constant as operator, left operand and constant, else None.

    The operator is mirrored if the constant is the left operand.
    """
    match expr:
        case tree.Binary(operator=operator, left=left, right=right) if operator in MIRRORED:
            if is_constant(right):
                return operator, left, right
            if is_constant(left):
                return MIRRORED[operator], right, left
    return None


def order(left: types.Value, right: types.Value) -> types.Value:
    """Return the order of two numbers: -1.0, 0.0, 1.0, or NaN."""
    if left != left or right != right:
        return float("nan")
    return float((left > right) - (left < right))  # type: ignore[operator]


def value_of(test: tree.TestRef, lookup: Callable[[tree.Leaf], types.Value | None]) -> types.Value:
    """Return the outcome of a test for given data.

    Raises:
        Undefined: it reads missing data.
    """
    subject = evaluate(test.subject, lookup)
    return subject if test.other is None else order(subject, evaluate(test.other, lookup))


def type_of_part(type_: types.Type, path: tuple[str | int, ...]) -> types.Type | None:
    """Return the type of a part of a received value."""
    part: types.Type | None = type_
    for step in path:
        match part:
            case types.ArrayType(element=element) if isinstance(step, int):
                part = element
            case types.ObjectType() if isinstance(step, str):
                part = part.property(step)
            case _:
                return None
    return part


def sides_of(expr: tree.Expr) -> tuple[tree.Expr, ...]:
    """Return the operands of a comparison, or else the expression itself."""
    if isinstance(expr, tree.Binary) and expr.operation.is_comparison:
        return expr.operands
    return (expr,)


def element_asked_for(test: tree.Expr) -> tree.Part | None:
    """Return the part of a variable that a test compares with a constant; None if it is another
    test."""
    found = _asked_for(test)
    found = found.argument if isinstance(found, tree.Convert) else found
    return (
        found
        if isinstance(found, tree.Part) and isinstance(found.operand, tree.VariableRef)
        else None
    )


def _asked_for(test: tree.Expr) -> tree.Expr | None:
    """Return what a test compares with a constant, or asks for; None if it compares several."""
    if not isinstance(test, tree.Holds):
        return None
    asked = test.operand
    while isinstance(asked, tree.Unary) and asked.operator == "!":
        asked = asked.operand
    sides = [side for side in sides_of(asked) if not is_constant(side)]
    return sides[0] if len(sides) == 1 else None


def _asks_of_event(test: tree.Holds) -> bool:
    """Whether the part of ``value`` that comes with an event, or does not, decides a test."""
    found = _asked_for(test)
    if isinstance(found, tree.Convert) and compared_in_rules(found) is not None:
        found = found.argument
    return isinstance(found, tree.ValueRef) and may_be_undefined(found)


def kept_where_undefined(variable: tree.VariableRef, value: tree.Expr) -> tree.Expr:
    """Return the value of a boolean variable after an assignment that leaves it if undefined.

    That is expressed only if each comparison reads one part of a variable, which the plant
    represents, or finite values. Otherwise this returns ``value`` itself, which may be undefined.
    """
    if not isinstance(variable.type, types.BooleanType):
        return value
    true, false = (condition_on_data(e) for e in (value, tree.Unary("!", value, _BOOLEAN)))
    asked = [part for side in (true, false) for part in walk(side) if isinstance(part, tree.Holds)]
    if not asked or any(reads_data(p) and element_asked_for(p) is None for p in asked):
        return value
    return logic.disjunction([true, logic.conjunction([variable, logic.negation(false)])])


def replaces_undefined(part: tree.Expr) -> bool:
    """Whether this is defined where its operand may not be."""
    return isinstance(part, tree.Holds) or (
        isinstance(part, tree.Binary) and part.operator == "else"
    )


def is_presence(subject: tree.Expr) -> bool:
    """Whether this tests that a variable has a value."""
    return isinstance(subject, tree.Holds) and isinstance(subject.operand, tree.VariableRef)


def is_there(subject: tree.Expr) -> bool:
    """Whether this tests the presence of data that are always present."""
    return (
        isinstance(subject, tree.Holds)
        and isinstance(subject.operand.type, types.ArrayType | types.ObjectType)
        and not may_be_undefined(subject.operand)
    )


class Terms:
    """Finds the terms of expressions; ``text`` gives the model text of an expression."""

    def __init__(self, text: Callable[[tree.Expr], str]) -> None:
        self._text = text
        self._pairs: dict[tuple[tree.Expr, tree.Expr], tree.TestRef] = {}
        self._finite: identity_cache.IdentityCache[tree.Expr] = identity_cache.IdentityCache()

    def finite(self, expr: tree.Expr) -> tree.Expr:
        """Return a deciding expression with tests of data replaced by terms, which read no state.

        Results are cached, since the requirements of component copies share expressions.
        """
        return self._finite.of(expr, self._new_finite)

    def _new_finite(self, expr: tree.Expr) -> tree.Expr:
        match expr:
            case tree.Unary(operator="!", operand=operand):
                return replace(expr, operand=self.finite(operand))
            case tree.Binary(operator=operator, left=left, right=right) if operator != "else":
                if operator not in MIRRORED or isinstance(left.type, types.BooleanType):
                    return replace(expr, left=self.finite(left), right=self.finite(right))
                if reads_data(expr) and reads_states(expr):
                    return self._by_states(expr)
                if isinstance(left.type, types.EnumType) and (
                    reads_data(expr) or not reads_arrays(expr)
                ):
                    return replace(expr, left=self.finite(left), right=self.finite(right))
                return self._comparison(expr) if reads_data(expr) else self._whole(expr)
            case (
                tree.VariableRef()
                | tree.ValueRef()
                | tree.StateRef()
                | tree.PhaseRef()
                | tree.Literal()
            ):
                return expr
            case tree.Convert() if compared_in_rules(expr) is not None:
                return expr
            case tree.Holds() if _asks_of_event(expr):
                return expr
        if not reads_data(expr):
            return self._whole(expr)
        if isinstance(expr.type, types.BooleanType) or not reads_states(expr):
            return self._free(expr)
        return self.choice(self.computed(expr))  # only assigned: no later state depends on it

    def _free(self, expr: tree.Expr) -> tree.Expr:
        """Return a test whose outcome the plant does not derive from what it reads."""
        return self._by_states(expr) if reads_states(expr) else self._seen(self.computed(expr))

    def _by_states(self, expr: tree.Expr) -> tree.Expr:
        """Return a test that also reads states as one test for each of these states."""
        cases = [(state, self.finite(test)) for state, test in by_state(expr)]
        if len({test for _, test in cases}) == 1:
            return cases[0][1]
        return logic.disjunction(logic.conjunction(case) for case in cases)

    def _whole(self, expr: tree.Expr) -> tree.Expr:
        """Return an expression over finite values, with parameters as terms of the state.

        Engines have no arrays, so expressions over arrays of finite values are replaced.
        """

        if any(
            isinstance(p, tree.ParameterRef)
            and isinstance(p.type, types.ArrayType | types.ObjectType)
            for p in walk(expr)
        ):
            of_boolean = isinstance(expr.type, types.BooleanType)
            return self._free(expr) if of_boolean else self.choice(self.computed(expr))

        def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
            return self.computed(node) if isinstance(node, tree.ParameterRef) else node

        found = rewritten(expr, leaf) if reads_parameters(expr) else expr
        if not reads_arrays(expr):
            return found
        if isinstance(expr.type, types.BooleanType):
            written = by_value(found)
            return self._free(expr) if written is None else written
        if (
            isinstance(expr, tree.Operation) and types.domain(expr.type) is None
        ):  # of parts with ranges
            return with_operands(expr, tuple(map(self._whole, expr.operands)))
        return self.choice(self.computed(expr))  # it is assigned

    def _comparison(self, expr: tree.Binary) -> tree.Expr:
        if is_constant(expr.right):
            return replace(expr, left=self.term(expr.left))
        if is_constant(expr.left):
            return replace(expr, right=self.term(expr.right))
        if isinstance(expr.left.type, types.StringType):
            same = self._seen(self.computed(replace(expr, operator="=")))
            return same if expr.operator == "=" else tree.Unary("!", same, _BOOLEAN, expr.span)
        test, swapped = self.pair(expr.left, expr.right)
        operator = MIRRORED[expr.operator] if swapped else expr.operator
        return tree.Binary(
            operator, self._seen(test), tree.Literal(0, types.IntegerType()), _BOOLEAN, expr.span
        )

    def term(self, expr: tree.Expr) -> Term:
        """Return the term of a number or a string that is compared with constants."""
        if isinstance(expr, tree.VariableRef | tree.ValueRef):
            return expr
        return self._seen(self.computed(expr))

    def computed(self, expr: tree.Expr) -> tree.TestRef:
        return tree.TestRef(expr, None, expr.type, self._text(expr))

    def pair(self, left: tree.Expr, right: tree.Expr) -> tuple[tree.TestRef, bool]:
        """Return the test of the order of two numbers, and whether its operands are exchanged."""
        if (right, left) in self._pairs:
            return self._pairs[right, left], True
        if (left, right) not in self._pairs:
            both = [left.type, right.type]
            integers = all(types.is_number(t) and isinstance(t, types.IntegerType) for t in both)
            type_: types.Type = types.IntegerType() if integers else types.DoubleType()
            name = f"compare({self._text(left)}, {self._text(right)})"
            self._pairs[left, right] = tree.TestRef(left, right, type_, name)
        return self._pairs[left, right], False

    def _seen(self, test: tree.TestRef) -> tree.TestRef | tree.ChoiceRef:
        """Return the test, or a choice if it reads ``value``, which is known only at the event.

        A test that may be undefined, which occurs only in assignments, is a choice, too.
        """
        at_event = any(reads_value(side) or may_be_undefined(side) for side in test.sides)
        return self.choice(test) if at_event else test

    def choice(self, test: tree.TestRef) -> tree.ChoiceRef:
        return tree.ChoiceRef((test.name,), test.type, test=test)


def substituted(expr: tree.Expr, given: Mapping[tuple[str, str], tree.Expr]) -> tree.Expr:
    """Return an expression with what is assigned to variables in place of them."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        if isinstance(node, tree.VariableRef):
            return given.get((node.component, node.variable), node)
        return node

    return rewritten(expr, leaf)


def element_needed(value: tree.Expr, transition: Transition, robot: Robot) -> tree.ValueRef | None:
    """Return the element of an array without which a part of the value that a transition receives
    is missing; None if there is more that may be missing, or nothing."""
    if not isinstance(value, tree.ValueRef) or value.optional:
        return None
    whole = robot.communications[transition.communication].value_type(transition.event)
    numbers = [n for n, step in enumerate(value.path) if isinstance(step, int)]
    path = value.path[: numbers[-1] + 1] if numbers else ()
    type_ = type_of_part(whole, path) if path else None
    return None if type_ is None else tree.ValueRef(path, type_)


def follows_assignments(term: Term) -> TypeGuard[tree.TestRef]:
    """Whether the outcome of a test is known unless an assignment leaves it open."""
    if not isinstance(term, tree.TestRef):
        return False
    return is_presence(term.subject) or element_asked_for(term.subject) is not None
