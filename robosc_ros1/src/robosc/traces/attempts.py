"""What becomes of the commands of another controller."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.runtime.core.values import Undefined
from robosc.simulate.faults import InvalidLine
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import NOTHING, Carried, ExactStep, State, Steps


@dataclass(frozen=True)
class Attempt:
    """What becomes of a command: the state ``after`` it, which it changes only if it happens;
    ``set_fields`` are those that a correction sets, by path; ``reasons`` are why it is not allowed,
    as a node tells them (None: that cannot be told)."""

    is_allowed: bool
    after: State
    cases: frozenset[Case]
    set_fields: Mapping[str, Any]
    reasons: tuple[str, ...] | None


def attempted(
    steps: Steps, coverage: Coverage, step: ExactStep, state: State, sent: Carried
) -> Attempt | None:
    """What becomes of a command that carries ``sent``; None if it is no attempt worth showing: the
    end of what has not begun, an error that is told by an answer which passes, a goal beside one
    that it cannot replace, one that runs though the components have no place for it, or a
    correction that does not fit into its field."""
    try:
        made, fields = steps.made(step, state, sent)
        steps.fields.narrow(step.event, fields)
    except Undefined:
        return Attempt(False, state, frozenset(), {}, None)
    except InvalidLine:
        return None
    is_allowed = coverage.allows(step, state, made)
    answer = steps.told_as(step)
    if answer and (steps.reads_data(answer) or coverage.allows(answer, state, NOTHING)):
        return None
    if step.event.kind is not EventKind.REQUEST:
        if not is_allowed:
            return None
    elif _kind(steps, step) is Kind.ACTION and not step.in_phase(state):
        return None
    changes = bool(fields) and steps.follows
    after = step.after(state, sent if changes else made)
    if steps.follows and after is None and _kind(steps, step) is Kind.ACTION:
        return None
    cases = coverage.of_command(step, state, made)
    cases.update(_of_correction(steps, coverage, step, state, sent))
    if fields and is_allowed:
        cases.add(("corrected", step.number, *fields))
    if is_allowed and after is not None and not changes:
        cases |= coverage.of_step(step, state, made, after)
        return Attempt(True, after, frozenset(cases), fields, None)
    if step.replaces(state) and not is_allowed:
        cases.add(("replaced", step.number, False))
    # A monitor tells what forbids that which was sent; else, what would have become of it.
    told = sent if changes else made
    is_told = not is_allowed and not (changes and coverage.allows(step, state, sent))
    reasons = coverage.reasons(step, state, told) if is_told else None
    if not steps.follows or after is None:
        after = state
    return Attempt(False, after, frozenset(cases), {}, reasons)


def _of_correction(
    steps: Steps, coverage: Coverage, step: ExactStep, state: State, sent: Carried
) -> Iterator[Case]:
    """The cases of what corrects a command where it would otherwise become something else."""

    @cache
    def outcome(turned: int | None) -> Any:
        try:
            made, fields = steps.made(step, state, sent, turned)
        except Undefined:
            return None
        return fields if coverage.allows(step, state, made) else None

    for case in coverage.data_of(step, state, sent):
        if case[0] == "provide":
            is_shown = outcome(case[2]) != outcome(None)
        else:
            is_shown = outcome(None) is not None
        if is_shown:
            yield case


def _kind(steps: Steps, step: ExactStep) -> Kind:
    return steps.robot.communications[step.event.key].kind
