"""What the answers of a service or an action can bring: which are a response, and which reasons and
values an error can have together."""

from __future__ import annotations

from collections.abc import Iterable

from robosc.expr import traversal, types, undefined_data
from robosc.expr.tree import REASON, TRUE, Binary, Expr, Literal, ReasonRef, ValueRef
from robosc.language import events, reasons
from robosc.model.entities import Communication
from robosc.plant import acceptance, logic
from robosc.plant.automaton import LocalAutomaton, PhaseStep
from robosc.plant.data.view import FiniteView, expected_of_error
from robosc.plant.event_values import values_read

_WHILE_CANCELLING = frozenset(reason.word for reason in reasons.REASONS if reason.while_cancelling)


def divided_phase(
    communication: Communication,
    kind: events.EventKind,
    phase: PhaseStep | None,
    automata: Iterable[LocalAutomaton],
    view: FiniteView,
    is_assumed: bool,
) -> LocalAutomaton | None:
    """Return the phase of an answer as an automaton that blocks what it cannot bring; None: it can
    bring anything. ``is_assumed``: the robot is assumed not to give every response; one that it
    gives nevertheless is an error."""
    if phase is None or communication.phases is None:
        return None
    guards: dict[int, Expr | None] = {}
    if kind is events.EventKind.RESPONSE and communication.expect is not None:
        guards = dict.fromkeys(phase.sources, view.expression(communication.expect))
    elif kind is events.EventKind.ERROR:
        read = values_read(e for automaton in automata for e in automaton.expressions).values()
        names = communication.phases.names
        guards = {
            number: _possible_error(communication, read, names[number], view, is_assumed)
            for number in phase.sources
        }
    if all(guard is None for guard in guards.values()):
        return None
    return acceptance.guarded_phase(communication.key, phase, guards, communication.span)


def _possible_error(
    communication: Communication,
    read: Iterable[ValueRef],
    phase: str,
    view: FiniteView,
    is_assumed: bool,
) -> Expr | None:
    """Return the condition on an error's reason and value that come in a phase; None: there is
    none. ``read`` are the parts of them that the model reads."""
    found = list(read)
    value = next((r for r in found if type(r) is ValueRef and traversal.all_names(r.path)), None)
    there = None if value is None else undefined_data.defined(value)
    refused = expected = None
    if there is not None and communication.expect is not None:
        expected = view.expression(expected_of_error(communication))
        refused = TRUE if is_assumed else logic.conjunction([there, logic.negation(expected)])
    reason = next((r.type for r in found if isinstance(r, ReasonRef)), None)
    if not isinstance(reason, types.EnumType):
        is_service = communication.kind is events.Kind.SERVICE
        if not is_service or there is None or refused is None or is_assumed:
            return None
        return logic.disjunction([logic.negation(there), refused])
    words = [
        word
        for word in reasons.reasons_of(communication.kind)
        if (word != reasons.REFUSED or is_assumed or communication.expect is not None)
        and (phase != "cancelling" or word in _WHILE_CANCELLING)
    ]
    if there is None:
        return None if len(words) == len(reason.values) else _one_of(words, reason)
    parts = []
    for word in words:
        also = logic.negation(there)
        if word == reasons.REFUSED:
            also = refused or TRUE
        elif word == reasons.FAILED and communication.kind is events.Kind.ACTION:
            also = TRUE
        parts.append(logic.conjunction([_one_of([word], reason), also]))
    return logic.disjunction(parts)


def _one_of(words: Iterable[str], reason: types.EnumType) -> Expr:
    return logic.disjunction(
        Binary("=", ReasonRef(REASON, reason), Literal(word, reason), types.BooleanType())
        for word in words
    )
