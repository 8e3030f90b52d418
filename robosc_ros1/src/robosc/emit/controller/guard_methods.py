"""Guards of commands as Python text, with the requirements called by their methods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from robosc.emit.controller.naming import place
from robosc.emit.controller.python import Attributes, PythonCode, joined
from robosc.emit.write.line_breaks import unparenthesised
from robosc.expr.traversal import operands
from robosc.expr.tree import Expr
from robosc.language.events import EventKind
from robosc.model.entities import Requirement
from robosc.plant.automaton import Event
from robosc.plant.formulas import conjunction, disjunction, negation
from robosc.supervisor import Guard, Supervisor


@dataclass(frozen=True)
class GuardText:
    """What a guard method returns, comments above it, and why synthesis restricts it, if so.

    ``shown`` are the conditions in it, with the names of their parts.
    """

    notes: tuple[str, ...]
    code: PythonCode
    reason: str | None
    shown: tuple[Expr, ...] = ()


def holds_where(requirement: Requirement) -> Expr:
    """The condition under which a requirement is met."""
    condition = requirement.condition
    return negation(condition) if requirement.forbids else condition


class GuardTexts:
    """Makes the guards of one supervisor. ``methods`` are the requirements' methods by number."""

    def __init__(
        self, supervisor: Supervisor, attributes: Attributes, methods: Mapping[int, str]
    ) -> None:
        self.supervisor = supervisor
        self.names = supervisor.part_names
        self.attributes = attributes
        self.methods = methods

    def guard(self, guard: Guard) -> GuardText:
        event = guard.event
        reason = None if guard.status == "as required" else self._reason(event)
        notes = []
        shown: tuple[Expr, ...] = ()
        if guard.status == "as required" and event.requirements:
            code = joined(_operator(event), [self._call(event, n) for n in event.requirements])
        else:
            code, called, shown = self._with_calls(event, guard.expr)
            if guard.status == "restricted":
                notes += [self._cited(i) for i in event.requirements if i not in called]
                notes.append("Restricted further by synthesis: " + (reason or ""))
        if event.kind is EventKind.CANCEL and not event.requirements:
            notes.append("No requirement is a reason to cancel this action.")
        elif guard.status == "never" and event.kind.sent:
            notes.append("Never allowed: " + (reason or "found by synthesis"))
        return GuardText(tuple(" ".join(note.split()) for note in notes), code, reason, shown)

    def _reason(self, event: Event) -> str | None:
        for explanation in self.supervisor.explanations:
            of = explanation.event
            if of is not None and (of == event or of.whole is event):
                return explanation.reason
        return None

    def _cited(self, number: int) -> str:
        requirement = self.supervisor.plant.robot.requirements[number]
        return f"{requirement.text} ({place(requirement.span)})"

    def _call(self, event: Event, number: int) -> PythonCode:
        """The requirement's part in a request's or, violated, in a cancel's guard."""
        robot = self.supervisor.plant.robot
        requirement = robot.requirements[number]
        given = "value" if robot.supervises and requirement.on_data else ""
        call = f"self.{self.methods[number]}({given})"
        read = self.attributes.code(requirement.condition)
        return replace(read, text=f"not {call}" if event.kind is EventKind.CANCEL else call)

    def _with_calls(
        self, event: Event, expr: Expr
    ) -> tuple[PythonCode, list[int], tuple[Expr, ...]]:
        """The guard with calls of the requirements that stand in it word for word, these, and the
        conditions beside them."""
        operator = _operator(event)
        parts = whole = operands(expr, operator)
        called = []
        for number in event.requirements:
            holds = holds_where(self.supervisor.plant.robot.requirements[number])
            wanted = operands(negation(holds) if operator == "or" else holds, operator)
            if all(part in whole for part in wanted):
                parts = [part for part in parts if part not in wanted]
                called.append(number)
        read = [self.attributes.code(part) for part in parts]
        if parts and self.names.is_long(expr):
            rest = conjunction(parts) if operator == "and" else disjunction(parts)
            parts = operands(self.names.short(rest), operator)
        spelled = self.attributes.operand if operator == "and" else self.attributes.text
        texts = [PythonCode(spelled(part)) for part in parts]
        code = joined(operator, [*(self._call(event, n) for n in called), *texts])
        reads = code.reads.union(*(code.reads for code in read))
        return PythonCode(unparenthesised(code.text), reads), called, tuple(parts)


def _operator(event: Event) -> str:
    """What joins requirements: a cancel is allowed where one of them is violated."""
    return "or" if event.kind is EventKind.CANCEL else "and"
