"""Explanations why a command is restricted beyond its requirements, or the supervisor is empty.

The trace of a refused command: a short path under control to a state in which the requirements
would allow it; the command; then the uncontrollable events that lead on, over states that must all
be avoided, to the first bad state: a state requirement fails, a variable leaves its range, or no
marked state can be reached any more. It is made from single steps (:class:`Stepper`), so that it
does not depend on the engine.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

from robosc.errors import Diagnostic, Note, Severity, listing
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import walk
from robosc.expr.tree import FALSE, TRUE, Expr, StateRef, VariableRef
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.diagnostics import first_of
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.logic import conjunction, negation
from robosc.plant.step import Values, Verdict
from robosc.progress import Progress
from robosc.supervisor import Explanation, Guard, Step
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import (
    System,
    allowed,
    found_step,
    make_step,
    possible,
    steps_of,
)
from robosc.synthesis.explain.blocking import Cause, why_blocked, why_impossible
from robosc.synthesis.explain.copies import Copies, Told, copy_of, family_of, told_once
from robosc.synthesis.explain.range_violation import why_out_of_range
from robosc.synthesis.explain.starts import UNTRACED, assumed, lost_start, nearest, whereabouts
from robosc.synthesis.faults import UNSAFE, Faults, way_through_rounds
from robosc.synthesis.formatting import event_text, quoted, trace_text
from robosc.synthesis.time_limit import TimeIsUp

_TOO_LATE = "the time for explanations was too short to find out why (--explain-seconds)"


@dataclass(frozen=True, slots=True)
class _BadState:
    """A bad state, and the path of uncontrollable events to it.

    ``last`` is the step out of the last of ``states`` that takes a variable out of its range, if
    that is what is bad.
    """

    states: tuple[PlantState, ...]
    last: Step | None
    cause: Cause


def explain_guards(
    system: System,
    guards: tuple[Guard, ...],
    progress: Progress | None = None,
) -> tuple[tuple[Explanation, ...], tuple[Diagnostic, ...]]:
    """Return an explanation per guard that is restricted or never holds, and what was left out."""
    explainer = _Explainer(system)
    found: list[Told] = []
    left_out: list[Event] = []
    for number, guard in enumerate(guards):
        if progress is not None:
            progress("explanations", number, len(guards))
        if guard.status != "as required" and not _is_refused_by_data(guard, guards):
            try:
                system.time.check()
                found += explainer.guard(guard)
            except TimeIsUp:
                left_out.append(guard.event)
    return told_once(system.plant, found), tuple(_left_out(system, left_out))


def _left_out(system: System, events: Sequence[Event]) -> Iterator[Diagnostic]:
    """Yield what tells of commands that are not explained."""
    if events:
        yield Diagnostic(
            Severity.WARNING,
            "explanations-left-out",
            f"{first_of([event_text(event) for event in events])}"
            f" {'is' if len(events) == 1 else 'are'} restricted further, or never allowed, for"
            f" reasons that were not found within {system.time.seconds:.3g} s",
            events[0].span,
            "give the search more time: --explain-seconds 60",
        )


def _is_refused_by_data(guard: Guard, guards: Iterable[Guard]) -> bool:
    """Whether requirements refuse the data of this case of a command, and not of all cases."""
    if guard.required != FALSE or not guard.event.known:
        return False
    cases = [g for g in guards if g.event.whole is guard.event.whole]
    return guard is not cases[0] or any(g.required != FALSE for g in cases)


def explain_empty(system: System) -> Explanation:
    """Return why an initial state cannot be kept."""
    return _Explainer(system).empty()


class _Explainer:
    def __init__(self, system: System) -> None:
        self.system = system
        self.plant: Plant = system.plant
        self.stepper = Stepper(self.plant)

        self.copies = Copies(self.plant)
        self.paths: dict[object, tuple[Event, tuple[PlantState, ...]]] = {}
        """Per family, a command of one copy and the path to where it is refused."""

        self._read: IdentityCache[list[str]] = IdentityCache()
        self.goals: Faults = tuple(range(len(self.plant.goals)))

    def empty(self) -> Explanation:
        robot = self.plant.robot
        first = lost_start(self.system)
        try:
            bad = self._bad_state(first)
        except TimeIsUp:
            bad = _BadState((first,), None, Cause(_TOO_LATE))
        trace = self._trace(bad.states, bad.last)
        start = assumed(self.plant, first)
        start += f"after {trace_text(trace)}, which no controller can prevent, " if trace else ""
        message = f"no controller can satisfy the requirements: {start}{bad.cause.reason}"
        cause = bad.cause
        diagnostic = Diagnostic(
            Severity.ERROR, "empty-supervisor", message, robot.span, cause.remedy, _notes(cause)
        )
        return Explanation(None, message, trace, diagnostic.hint, diagnostic)

    def guard(self, guard: Guard) -> Iterator[Told]:
        """Yield what there is to say of a guard that is restricted or never holds."""
        event = guard.event
        refused = conjunction([allowed(self.plant, event), negation(guard.expr)])
        number = self.plant.events.index(event)
        path, copied = self._of_other_copy(event, number), True
        if path is None:
            path, copied = nearest(self.system, refused), False
        if path is None:
            yield from self._never_asked(guard)
            return
        # Of several outcomes that the environment chooses from, explain a bad one.
        values, target = min(
            self._outcomes(number, path[-1]), key=lambda o: self.system.is_good(o[1])
        )
        command = make_step(self.plant, event, values, path[-1], target)
        bad = self._bad_state(target, (command,))
        after = self._trace(bad.states, bad.last)
        trace = (*steps_of(self.stepper, path), command, *after)
        never = guard.status == "never"
        head = "can never be allowed" if never else "is restricted further"
        before = trace_text(trace[: len(trace) - len(after)])
        forced = f" the controller cannot prevent {trace_text(after)}; then" if after else ","
        traced = self.plant.is_initial(path[0])
        if traced:
            start, end = assumed(self.plant, path[0]), ""
            self.paths.setdefault(family_of(event), (event, path))
        else:
            start, end = f"{whereabouts(self.plant, path[0], refused)}, ", f" {UNTRACED}"
        rest = f"{start}after {before}{forced} {bad.cause.reason}{end}"
        message = f"{event_text(event)} {head}: {rest}"
        diagnostic = Diagnostic(
            Severity.WARNING,
            "never-allowed" if never else "restricted-command",
            message,
            event.span,
            bad.cause.remedy,
            _notes(bad.cause),
        )
        shown = trace if traced else ()
        explanation = Explanation(event, message, shown, diagnostic.hint, diagnostic, traced)
        yield Told(guard, head, rest, explanation, copied)

    def _outcomes(self, number: int, state: PlantState) -> list[tuple[Values, PlantState]]:
        return list(self.stepper.compiled(number, None).targets(state))

    def _of_other_copy(self, event: Event, number: int) -> tuple[PlantState, ...] | None:
        """Return the path to where the command of another copy is refused, both exchanged in it.

        None: there is none yet, or it is no path of the controlled system that ends so.
        """
        one, other = copy_of(event), None
        if one is not None and (known := self.paths.get(family_of(event))) is not None:
            other = copy_of(known[0])
        if one is None or other is None or known is None:
            return None
        path = []
        for state in known[1]:
            exchanged = self.copies.exchanged(state, one, other)
            if exchanged is None or not self.system.is_good(exchanged):
                return None
            path.append(exchanged)
        if not self.plant.is_initial(path[0]):
            return None
        if any(not self._follows(before, after) for before, after in pairwise(path)):
            return None
        requirement = event.requirement or TRUE
        asked = self.stepper.holds(requirement, path[-1])
        bad = [not self.system.is_good(s) for _, s in self._outcomes(number, path[-1])]
        return tuple(path) if asked and any(bad) else None

    def _follows(self, before: PlantState, after: PlantState) -> bool:
        """Whether a step from a good state to one is one of the controlled system."""
        step = found_step(self.stepper, before, after)
        return step is not None and not step.event.branches

    def _never_asked(self, guard: Guard) -> Iterator[Told]:
        """Yield why a command never happens that the plant or the requirements never allow.

        Where nothing is ever violated there is nothing to cancel, and nothing to say.
        """
        event = guard.event
        if not self.system.reaches(possible(self.plant, event)):
            rest = self._impossible(event)
        elif event.kind is EventKind.CANCEL and guard.required == FALSE:
            rest = f"no requirement is a reason to cancel {event.name}"
        elif event.kind is EventKind.CANCEL:
            return
        else:
            rest = (
                "its requirements hold in no state of the controlled system in which it is possible"
            )
        reason = f"{event_text(event)} never happens: {rest}"
        diagnostic = Diagnostic(Severity.WARNING, "never-allowed", reason, event.span)
        explanation = Explanation(event, reason, (), None, diagnostic)
        yield Told(guard, "never happens", rest, explanation)

    def _impossible(self, event: Event) -> str:
        if event.kind is EventKind.CANCEL:
            return f"{event.name} never runs in the controlled system"
        if event.kind is EventKind.TAU:
            return "the controlled system reaches no state in which it is possible"
        return "the controlled system reaches no state in which no component blocks it"

    def _trace(self, states: tuple[PlantState, ...], last: Step | None) -> tuple[Step, ...]:
        steps = steps_of(self.stepper, states)
        return steps if last is None else (*steps, last)

    # --- the bad state

    def _bad_state(self, start: PlantState, before: tuple[Step, ...] = ()) -> _BadState:
        """Return a near bad state to which uncontrollable events lead from ``start``.

        ``before`` is the step that led to ``start``. Where none is reached by uncontrollable events
        alone, the cause is what is wrong with the ways back.
        """
        forced = self._forced(start)
        if forced is not None:
            last, cause = self._cause(*forced, before)
            return _BadState(forced[0], last, cause)
        where = "a marked state"
        if self.plant.goals:
            where += ", or to what must remain possible,"
        reason = f"each way back to {where} passes through states that must be avoided"
        path, faults = self._nearest_fault(start)
        if path is None:
            return _BadState((start,), None, Cause(reason))
        last, cause = self._cause(path, faults, ())
        steps = self._trace(path, last)
        after = f"after {trace_text(steps)}, " if steps else ""
        reason = f"{reason}: {after}{cause.reason}"
        return _BadState((start,), None, replace(cause, reason=reason))

    def _forced(self, start: PlantState) -> tuple[tuple[PlantState, ...], Faults] | None:
        """Return a way by uncontrollable events to a bad state, and what may be wrong with it."""
        for faults in (UNSAFE, ("blocked",), self.goals):
            path = self.system.faults.way(start, faults, forced=True)
            if path is not None:
                return path, faults
        return None

    def _nearest_fault(self, start: PlantState) -> tuple[tuple[PlantState, ...] | None, Faults]:
        """Return a way to what is wrong with the ways back from a state.

        It leads on up to where uncontrollable events may lead to a bad state; if that is nowhere,
        it is a way to the nearest bad state.
        """
        search = self.system.faults
        passed: list[PlantState] = []
        for state in way_through_rounds(search, start):
            forced = self._forced(state)
            if forced is not None:
                return (*passed, *forced[0]), forced[1]
            passed.append(state)
        ways = [
            (path, faults)
            for faults in (("range",), ("blocked",), self.goals)
            if (path := search.way(start, faults, forced=False)) is not None
        ]
        return min(ways, key=lambda way: len(way[0])) if ways else (None, ())

    def _cause(
        self, path: tuple[PlantState, ...], faults: Faults, before: tuple[Step, ...]
    ) -> tuple[Step | None, Cause]:
        """Return what is wrong at the end of a path, and the step out of a range if it is that."""
        state = path[-1]
        fault = next(fault for fault in faults if self.system.faults.has(state, fault))
        steps = partial(self._steps, before, path)
        match fault:
            case "requirement":
                return None, self._failing(state, steps())
            case "range":
                last = self._leaving_step(state)
                return last, why_out_of_range(self.plant, last, state)
            case "blocked":
                values = self.system.faults.values_beyond(state)
                return None, why_blocked(self.plant, values, steps)
        return None, why_impossible(self.plant, fault)

    def _steps(self, before: tuple[Step, ...], path: tuple[PlantState, ...]) -> tuple[Step, ...]:
        return (*before, *steps_of(self.stepper, path))

    def _failing(self, state: PlantState, steps: tuple[Step, ...]) -> Cause:
        requirement = next(
            self.plant.robot.requirements[index]
            for condition, index in self.plant.invariants
            if not self.stepper.holds(condition, state)
        )
        read = self._read.of(requirement.condition, _components)
        remedy = _avoiding(read, steps[-1].event if steps else None)
        return Cause(f"{quoted(requirement.text)} fails", remedy, requirement.span)

    def _leaving_step(self, state: PlantState) -> Step:
        """Return a step by which a variable leaves its range."""
        for number, event in enumerate(self.plant.events):
            if not event.controllable and _may_leave(self.plant, number):
                compiled = self.stepper.compiled(number, None)
                for values in compiled.some_values:
                    if compiled.step(state, values) is Verdict.OUT_OF_RANGE:
                        return Step(event, values)
        raise TimeIsUp  # by values that are not among those that are tried


def _may_leave(plant: Plant, number: int) -> bool:
    return any(
        isinstance(plant.variables[variable].values, range)
        for automaton in plant.events[number].automata
        for edge in automaton.edges
        for variable, _ in edge.updates
    )


def _components(condition: Expr) -> list[str]:
    """Return the components whose state or variables a condition reads."""
    parts = (part for part in walk(condition) if isinstance(part, VariableRef | StateRef))
    return list(dict.fromkeys(part.component for part in parts))


def _avoiding(read: Sequence[str], event: Event | None) -> str:
    """Return how to mend a state requirement on some components that fails after an event, or at
    the start (None)."""
    if not read:
        return "relax the requirement"
    if event is None:
        return f"let {listing(read)} start otherwise, or relax the requirement"
    movers = [p.component for p in event.automata if p.component in read]
    if not movers:
        return "relax the requirement"  # only the phase of a communication has changed
    return f"change what {event_text(event)} does to {listing(movers)}, or relax the requirement"


def _notes(cause: Cause) -> tuple[Note, ...]:
    return () if cause.span is None else (Note("this is where it goes wrong", cause.span),)
