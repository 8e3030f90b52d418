"""The check for data that may be undefined: commands that go on with the last value.

An assignment whose value is undefined leaves its variable as it was, and a condition over elements
that are not there is decided by nothing. So a message may have come, be fresh, and yet say
nothing: a laser scan that is empty or of which no ray brought a number.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from robosc.expr import traversal, tree, types
from robosc.expr.types import ArrayType, EnumType, ObjectType, Type
from robosc.language.events import EventKind, Kind
from robosc.model.automata import Assignment, Transition
from robosc.model.diagnostics import Report
from robosc.model.entities import Component, Robot, data_expressions
from robosc.source import Source

# The check of literal indexes into arrays of fixed length.


Lengths = Mapping[tuple[ObjectType, str], tuple[int, str]]
"""Array properties of fixed length: the number of elements, and the field as text."""


def check_indexes(
    components: Iterable[Component], enums: Iterable[EnumType], lengths: Lengths, report: Report
) -> None:
    """Report indexes past the end, in the rules of enums and in behaviours of this file."""
    read = [(tree.condition_of(rule), enum.source) for enum in enums for rule in enum.rules]
    carried = {c.key: c for component in components for c in component.communications}
    read += [(c.expect, c.response) for c in carried.values() if c.expect is not None]
    for component in components:
        for transition in component.transitions if component.library is None else ():
            if transition.communication in carried:
                type_ = carried[transition.communication].value_type(transition.event)
                read += [(expr, type_) for expr in transition.expressions]
    for expr, type_ in read:
        _check(expr, type_, lengths, report)


def _check(expr: tree.Expr, type_: Type, lengths: Lengths, report: Report) -> None:
    for part in traversal.walk(expr):
        if not isinstance(part, tree.ValueRef) or part.span is None:
            continue
        for index, (length, field) in _fixed(part.path, type_, lengths):
            if index >= length:
                report.add(
                    "field-index",
                    part.span,
                    f"{field} has {length} elements, so there is no [{index}]",
                    f"the last one is [{length - 1}]",
                )


def has_open_index(path: tuple[str | int, ...], type_: Type, lengths: Lengths) -> bool:
    """Whether a path leads to an element of an array that may be shorter."""
    return sum(isinstance(step, int) for step in path) > len(list(_fixed(path, type_, lengths)))


def _fixed(
    path: tuple[str | int, ...], type_: Type | None, lengths: Lengths
) -> Iterator[tuple[int, tuple[int, str]]]:
    """The indexes on a path into arrays of fixed length, each with the entry of ``lengths``."""
    array: tuple[ObjectType, str] | None = None
    for step in path:
        if isinstance(step, int):
            if array is not None and array in lengths:
                yield step, lengths[array]
            array = None
            type_ = type_.element if isinstance(type_, ArrayType) else None
        elif isinstance(type_, ObjectType):
            array = (type_, step)
            type_ = type_.property(step)


_UNDEFINED = object()
"""What an expression comes to that finds no data."""


def check_undefined_data(robot: Robot, lengths: Lengths, source: Source, report: Report) -> None:
    """Warn where a command would go on with a value that a fresh message did not bring.

    Only what is written in ``source`` is reported, each place once. ``lengths`` are those of arrays
    in messages that have a fixed one.
    """
    needed = _needed(robot)
    for component, transition in _from_messages(robot):
        if transition.guard is not None and _asks_for_data(transition.guard):
            continue
        message = robot.communications[transition.communication]
        nothing = _Nothing(message.value_type(transition.event), lengths)
        for assignment in transition.assignments:
            key = f"{component.name}.{assignment.variable}"
            value = nothing.of(assignment.value) if key in needed else None
            if value is _UNDEFINED:
                stays = f"'{assignment.variable}' keeps its last value"
                _report(assignment, message.name, stays, _OF_VALUES, source, report)
            elif value is not None and _lets_happen(robot, key, value):
                shown = str(value).lower() if isinstance(value, bool) else value
                becomes = f"'{assignment.variable}' becomes {shown}"
                _report(assignment, message.name, becomes, _OF_CONDITIONS, source, report)
    _check_provided(robot, lengths, source, report)


def _check_provided(robot: Robot, lengths: Lengths, source: Source, report: Report) -> None:
    """Warn where a command is not sent, for its data may be missing.

    What a guard asks for elsewhere, as ``defined(x[next])``, is taken to be there.
    """
    guards = (taken.guard for _, taken in robot.transitions if taken.guard is not None)
    known = _variables(part for guard in guards for part in _asked_for(guard))
    for provide in robot.provides:
        command = robot.commands.get(provide.communication)
        conditions = [
            r.condition for r in robot.requirements if provide.communication in r.communications
        ]
        conditions += [] if provide.condition is None else [provide.condition]
        if command is None or any(map(_asks_for_data, conditions)):
            continue
        nothing = _Nothing(command.type, lengths)
        for data in data_expressions(provide.data):
            span = data.span
            if nothing.of(data) is not _UNDEFINED or _variables([data]) & known:
                continue
            if span is not None and span.source is source:
                name = robot.display_names[provide.communication]
                message = f"where what this reads is missing, {name} is not sent"
                report.add("undefined-data", span, message, _otherwise(data.type, span.text))


def _otherwise(type_: types.Type, text: str) -> str:
    if isinstance(type_, types.ObjectType) and type_.properties:
        (first, _), *_ = type_.properties
        return f"say what is sent then, field by field: {{ {first}: {text}.{first} else VALUE, … }}"
    return "say what is sent then: … else VALUE"


_OF_VALUES = "say what it is then: … else VALUE"
_OF_CONDITIONS = "let the condition say what holds then: (min(r for r in …) else 0.0) < …"


def _report(
    assignment: Assignment,
    message: str,
    consequence: str,
    hint: str,
    source: Source,
    report: Report,
) -> None:
    span = assignment.value.span or assignment.span
    if span.source is not source:
        return  # it is for the author of the library
    report.add(
        "undefined-data",
        span,
        f"where {message} lacks what this reads, {consequence}, and a command depends on it",
        hint,
    )


def _from_messages(robot: Robot) -> Iterator[tuple[Component, Transition]]:
    """The transitions on the responses of messages."""
    for component, transition in robot.transitions:
        message = robot.communications.get(transition.communication)
        is_message = message is not None and message.kind is Kind.OUTGOING
        if is_message and transition.event is EventKind.RESPONSE:
            yield component, transition


def _asks_for_data(condition: tree.Expr) -> bool:
    """Whether a condition says itself what there must be: ``length(…) > 0``, ``defined(…)``."""
    return any(True for _ in _asked_for(condition))


def _asked_for(condition: tree.Expr) -> Iterator[tree.Expr]:
    """The parts of a condition that ask for data."""
    for part in traversal.walk(condition):
        if isinstance(part, tree.Holds) or (
            isinstance(part, tree.Call) and part.operator == "length"
        ):
            yield part


# --- which variables matter ----------------------------------------------------------------------


def _needed(robot: Robot) -> set[str]:
    """The keys of variables on which commands depend, directly or through other variables."""
    read = [requirement.condition for requirement in robot.requirements]
    sources: dict[str, list[tree.Expr]] = {}
    for component, transition in robot.transitions:
        read += [] if transition.guard is None else [transition.guard]
        for assignment in transition.assignments:
            key = f"{component.name}.{assignment.variable}"
            sources.setdefault(key, []).append(assignment.value)
    for provide in robot.provides:
        read += provide.expressions
    needed: set[str] = set()
    work = _variables(read)
    while work:
        key = work.pop()
        if key not in needed:
            needed.add(key)
            work |= _variables(sources.get(key, ()))
    return needed


def _variables(exprs: Iterable[tree.Expr]) -> set[str]:
    return {part.key for part in traversal.walk_all(exprs) if isinstance(part, tree.VariableRef)}


def _lets_happen(robot: Robot, key: str, value: object) -> bool:
    """Whether some command is possible with a value of a variable, and not with another one."""
    type_ = robot.variables[key].type
    others = type_.values if isinstance(type_, types.EnumType) else (True, False)
    for condition, wanted in _conditions_of_commands(robot):
        if _outcome(condition, key, value) is (not wanted):
            continue
        if any(_outcome(condition, key, other) is (not wanted) for other in others):
            return True
    return False


_DECIDED = (EventKind.REQUEST, EventKind.ANSWER, EventKind.REFUSAL, EventKind.TAU)


def _conditions_of_commands(robot: Robot) -> Iterator[tuple[tree.Expr, bool]]:
    """What commands depend on, each with what it must come to."""
    for requirement in robot.requirements:
        yield requirement.condition, not requirement.forbids
    for _, transition in robot.transitions:
        if transition.event in _DECIDED and transition.guard is not None:
            yield transition.guard, True
    yield from ((p.condition, True) for p in robot.provides if p.condition is not None)


def _outcome(condition: tree.Expr, key: str, value: object) -> bool | None:
    """What a condition comes to where a variable has a value; None if that does not decide it."""
    match condition:
        case tree.VariableRef() if condition.key == key:
            return value is True
        case tree.Literal(value=bool(known)):
            return known
        case tree.Holds(operand=operand):
            return _outcome(operand, key, value)
        case tree.Unary(operator="!", operand=operand):
            outcome = _outcome(operand, key, value)
            return None if outcome is None else not outcome
        case tree.Binary(
            operator="=" | "!=", left=tree.VariableRef() as left, right=tree.Literal(value=right)
        ) if left.key == key:
            return (value == right) is (condition.operator == "=")
        case tree.Binary(left=left, right=right) if condition.operation.decider is not None:
            operation = condition.operation
            first, second = _outcome(left, key, value), _outcome(right, key, value)
            if first is operation.decider:
                return operation.decided
            if first is None:
                # Only the value that the right side alone can force.
                return second if second is operation.decided else None
            return second
    return None


# --- what comes of nothing -----------------------------------------------------------------------


class _Nothing:
    """What expressions come to where the arrays of a message of some type bring nothing."""

    def __init__(self, type_: types.Type, lengths: Lengths) -> None:
        self._type = type_
        self._lengths = lengths

    def of(self, expr: tree.Expr) -> object | None:
        """``_UNDEFINED``, a boolean or the value of an enum; None if nothing follows.

        What the model itself says of missing data, by ``else``, ``defined`` or ``length``, does not
        follow from nothing.
        """
        if _asks_for_data(expr):
            return None
        match expr:
            case tree.ValueRef(path=(), type=types.EnumType() as enum):
                return self._converted(enum)
            case tree.ValueRef(path=path):
                open_ = has_open_index(path, self._type, self._lengths)
                return _UNDEFINED if open_ else None
            case tree.ElementRef() | tree.Literal() | tree.VariableRef():
                return None
            case tree.Aggregate():
                return self._aggregate(expr)
            case tree.Binary(operator="else"):
                found = self.of(expr.left)
                return None if found is _UNDEFINED else found
            case tree.Binary(operator="/") if _reads_data(expr.right) and not _is_positive(
                expr.right
            ):
                return _UNDEFINED
            case tree.Binary() if expr.operation.decider is not None:
                return self._decided(expr)
            case tree.Unary(operator="!"):
                found = self.of(expr.operand)
                return not found if isinstance(found, bool) else found
            case tree.Convert(argument=tree.ValueRef(path=()) as argument, type=enum):
                return _Nothing(argument.type, self._lengths)._converted(enum)
            case tree.Call(operator="element"):
                return _UNDEFINED
        if isinstance(expr, tree.Part) and any(isinstance(step, int) for step in expr.path):
            return _UNDEFINED
        operands = expr.operands if isinstance(expr, tree.Operation) else ()
        return _UNDEFINED if any(self.of(o) is _UNDEFINED for o in operands) else None

    def _aggregate(self, expr: tree.Aggregate) -> object | None:
        if isinstance(expr.array, tree.Literal) and expr.condition is None:
            return None
        if expr.operator in ("min", "max", "first"):
            return _UNDEFINED
        is_slice = isinstance(expr.array, tree.Call) and expr.array.operator in (
            "section",
            "sector",
        )
        return {"any": False, "all": True}.get(expr.operator) if is_slice else None

    def _decided(self, expr: tree.Binary) -> object | None:
        """Of ``and``, ``or``, ``=>``: what the sides that come of nothing decide alone."""
        decider, decided = expr.operation.decider, expr.operation.decided
        left, right = self.of(expr.left), self.of(expr.right)
        if left is decider or right is decided:
            return decided
        if _UNDEFINED in (left, right):
            return _UNDEFINED
        if right is not None:
            return right
        return None if left is None else not decided

    def _converted(self, enum: types.EnumType) -> object | None:
        """The value that the rules of an enum lead to; None if no rule asks for missing data."""
        inner = _Nothing(enum.source, self._lengths)
        asked = False
        for rule in enum.rules:
            found = inner.of(tree.condition_of(rule)) if rule.condition is not None else True
            if found is True:
                return rule.value if asked or rule.condition is not None else None
            asked |= found is not None
        return enum.default if asked else None


def _reads_data(expr: tree.Expr) -> bool:
    return any(
        isinstance(part, tree.ValueRef | tree.VariableRef | tree.ElementRef)
        for part in traversal.walk(expr)
    )


def _is_positive(expr: tree.Expr) -> bool:
    """Whether a divisor is surely no 0: ``max(speed, 0.001)``."""
    if not (isinstance(expr, tree.Call) and expr.operator == "max"):
        return False
    numbers = (part.value for part in expr.operands if isinstance(part, tree.Literal))
    return any(isinstance(number, int | float) and number > 0 for number in numbers)
