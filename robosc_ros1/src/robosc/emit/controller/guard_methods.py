"""Guards of commands as Python text, with the requirements called by their methods."""

from __future__ import annotations

from collections.abc import Sequence

from robosc.emit.controller import template_data
from robosc.emit.controller.python import Attributes, PythonCode
from robosc.emit.write.line_breaks import unparenthesised
from robosc.expr import traversal, tree, undefined_data
from robosc.expr.types import BooleanType, Value
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Requirement
from robosc.plant.automaton import Event, EventParameter
from robosc.plant.data.classes import Classes
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.supervisor import Guard, Supervisor


@dataclass(frozen=True)
class GuardText:
    """What a guard method returns, comments above it, and why synthesis restricts it, if so.

    ``read`` are the attributes that it reads, ``shown`` the conditions beside the requirements in
    it, with the names of their parts.
    """

    notes: tuple[str, ...]
    text: str
    read: frozenset[str]
    reason: str | None
    shown: tuple[tree.Expr, ...]


def holds_where(requirement: Requirement) -> tree.Expr:
    """The condition under which a requirement is met."""
    condition = requirement.condition
    return negation(condition) if requirement.forbids else condition


@dataclass(frozen=True)
class GuardTexts:
    """Makes the guards of one supervisor."""

    supervisor: Supervisor
    attributes: Attributes
    requirements: Sequence[template_data.RequirementView]

    def guard(self, guard: Guard) -> GuardText:
        event = guard.event
        reason = None if guard.status == "as required" else self._reason(event)
        notes = []
        called: Sequence[int] = event.requirements
        rest = PythonCode("")
        shown: tuple[tree.Expr, ...] = ()
        if guard.status != "as required" or not event.requirements:
            called, rest, shown = self._with_calls(event, guard.expr)
            if guard.status == "restricted":
                notes += [self._cited(i) for i in event.requirements if i not in called]
                notes.append("Restricted further by synthesis: " + (reason or ""))
        if event.kind is EventKind.CANCEL and not event.requirements:
            notes.append("No requirement is a reason to cancel this action.")
        elif guard.status == "never" and event.kind.sent:
            notes.append("Never allowed: " + (reason or "found by synthesis"))
        requirements = self.supervisor.plant.robot.requirements
        read = (self.attributes.code(requirements[n].condition).reads for n in called)
        parts = [*(self._call(event, number) for number in called), rest.text]
        return GuardText(
            tuple(" ".join(note.split()) for note in notes),
            f" {_operator(event)} ".join(filter(None, parts)),
            rest.reads.union(*read),
            reason,
            shown,
        )

    def _reason(self, event: Event) -> str | None:
        for explanation in self.supervisor.explanations:
            of = explanation.event
            if of is not None and (of == event or of.whole is event):
                return explanation.reason
        return None

    def _cited(self, number: int) -> str:
        requirement = self.supervisor.plant.robot.requirements[number]
        return f"{requirement.text} ({requirement.span.place})"

    def _call(self, event: Event, number: int) -> str:
        """The requirement's part in a request's or, violated, in a cancel's guard."""
        requirement = self.requirements[number]
        negated = "not " if event.kind is EventKind.CANCEL else ""
        return f"{negated}self.{requirement.method}({'value' if requirement.on_data else ''})"

    def _with_calls(
        self, event: Event, expr: tree.Expr
    ) -> tuple[list[int], PythonCode, tuple[tree.Expr, ...]]:
        """The requirements that stand in a guard word for word, and the conditions beside them."""
        operator = _operator(event)
        parts = whole = traversal.operands(expr, operator)
        called = []
        for number in event.requirements:
            holds = holds_where(self.supervisor.plant.robot.requirements[number])
            wanted = traversal.operands(negation(holds) if operator == "or" else holds, operator)
            if all(part in whole for part in wanted):
                parts = [part for part in parts if part not in wanted]
                called.append(number)
        read = [self.attributes.code(part) for part in parts]
        names = self.supervisor.part_names
        if parts and names.is_long(expr):
            rest = conjunction(parts) if operator == "and" else disjunction(parts)
            parts = traversal.operands(names.short(rest), operator)
        spelled = self.attributes.operand if operator == "and" else self.attributes.text
        text = f" {operator} ".join(map(spelled, parts))
        reads = frozenset[str]().union(*(code.reads for code in read))
        return called, PythonCode(text if called else unparenthesised(text), reads), tuple(parts)


def _operator(event: Event) -> str:
    """What joins requirements: a cancel is allowed where one of them is violated."""
    return "or" if event.kind is EventKind.CANCEL else "and"


# One guard for each command, where synthesis found one for each case of the data.


def whole_guards(supervisor: Supervisor) -> tuple[Guard, ...]:
    """The guards of a supervisor; those of requests whose data it judges read ``value``."""
    found: dict[object, list[Guard]] = {}
    for guard in supervisor.guards:
        whole = guard.event.whole or guard.event
        found.setdefault(whole.identity, []).append(guard)
    return tuple(
        _whole(guards) if guards[0].event.whole else guards[0] for guards in found.values()
    )


def _whole(cases: Sequence[Guard]) -> Guard:
    event = cases[0].event.whole
    assert event is not None
    required = event.requirement or tree.TRUE
    asked = [guard for guard in cases if guard.required != tree.FALSE]
    if all(guard.status == "as required" for guard in asked):
        return Guard(event, required, required, "as required" if asked else "never")
    if all(guard.status == "never" for guard in asked):
        return Guard(event, tree.FALSE, required, "never")
    parameters = [event.parameters[i] for i in cases[0].event.known]
    beyond = _by_value(parameters, [(_numbers(guard, parameters), guard) for guard in cases])
    return Guard(event, conjunction([required, beyond]), required, "restricted")


_Case = tuple[tuple[int, ...], Guard]
"""A guard, with the number of each parameter's value."""


def _numbers(guard: Guard, parameters: Sequence[EventParameter]) -> tuple[int, ...]:
    data = guard.event.data
    return tuple(p.values.index(data[p.path]) for p in parameters)


def _by_value(parameters: Sequence[EventParameter], cases: Sequence[_Case]) -> tree.Expr:
    """What is demanded beyond the requirements, by the values of the parameters one by one."""
    if not parameters:
        ((_, guard),) = cases
        # Where the requirements forbid these data, nothing more has to.
        required = guard.status == "as required" or guard.required == tree.FALSE
        return tree.TRUE if required else guard.expr
    by_number: dict[int, list[_Case]] = {}
    for (number, *rest), guard in cases:
        by_number.setdefault(number, []).append((tuple(rest), guard))
    alike: dict[tree.Expr, list[int]] = {}
    for number, found in by_number.items():
        alike.setdefault(_by_value(parameters[1:], found), []).append(number)
    if len(alike) == 1:
        return next(iter(alike))
    return disjunction(
        conjunction([_is_one_of(parameters[0], numbers), rest]) for rest, numbers in alike.items()
    )


def _is_one_of(parameter: EventParameter, numbers: Sequence[int]) -> tree.Expr:
    reference = _reference(parameter)
    values = parameter.values
    if isinstance(values, Classes):
        return values.condition(numbers, numbers).of(reference)
    return disjunction(_has(reference, parameter, values[number]) for number in numbers)


def _reference(parameter: EventParameter) -> tree.ValueRef:
    if parameter.test is not None:
        return tree.ChoiceRef(parameter.path, parameter.type, test=parameter.test)
    return tree.ValueRef(parameter.path, parameter.type)


def _has(reference: tree.ValueRef, parameter: EventParameter, value: Value | None) -> tree.Expr:
    if value is None:
        return negation(undefined_data.defined(reference))
    if isinstance(parameter.type, BooleanType):
        return reference if value else negation(reference)
    return tree.Binary("=", reference, tree.Literal(value, parameter.type), BooleanType())
