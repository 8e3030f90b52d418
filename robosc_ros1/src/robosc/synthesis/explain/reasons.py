"""Explanations why a command is restricted beyond its requirements, or the supervisor is empty.

The trace of a refused command: a short path under control to a state in which the requirements
would allow it; the command; then the uncontrollable events that lead on, over states that must all
be avoided, to the first bad state: a state requirement fails, a variable leaves its range, or no
marked state can be reached any more. It is made from single steps (:class:`Stepper`), so that it
does not depend on the engine.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial

from robosc import limits
from robosc.errors import Diagnostic, Note, Severity, listing
from robosc.expr.traversal import walk
from robosc.expr.tree import FALSE, StateRef, VariableRef
from robosc.language.events import EventKind
from robosc.model.entities import Requirement
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.logic import conjunction, negation
from robosc.plant.step import Outcome, Verdict
from robosc.progress import Progress
from robosc.supervisor import Explanation, Guard, Step
from robosc.synthesis.compiled_steps import CompiledEvent, Stepper, Test
from robosc.synthesis.controlled_system import System, allowed, make_step, possible, steps_of
from robosc.synthesis.explain.blocking import Cause, why_blocked, why_impossible
from robosc.synthesis.explain.near_fault import near_fault
from robosc.synthesis.explain.range_violation import why_out_of_range
from robosc.synthesis.explain.starts import (
    UNTRACED,
    assumed,
    lost_start,
    nearest,
    whereabouts,
)
from robosc.synthesis.formatting import event_text, quoted, trace_text


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
) -> tuple[Explanation, ...]:
    """Return an explanation per guard that is restricted or never holds."""
    explainer = _Explainer(system)
    found: list[Explanation] = []
    for number, guard in enumerate(guards):
        if progress is not None:
            progress("explanations", number, len(guards))
        if guard.status != "as required" and not _is_refused_by_data(guard, guards):
            found += explainer.guard(guard)
    return tuple(found)


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

    @cached_property
    def uncontrollable(self) -> list[CompiledEvent]:
        """All uncontrollable events, compiled on demand."""
        return [
            self.stepper.compiled(number, None)
            for number, event in enumerate(self.plant.events)
            if not event.controllable
        ]

    @cached_property
    def leaving(self) -> list[CompiledEvent]:
        """Uncontrollable events that may take a variable out of its range."""
        return [e for e in self.uncontrollable if _may_leave(self.plant, e.number)]

    @cached_property
    def invariants(self) -> list[tuple[Test, Requirement]]:
        """The state requirements, compiled."""
        return [
            (self.stepper.test(condition), self.plant.robot.requirements[index])
            for condition, index in self.plant.invariants
        ]

    def empty(self) -> Explanation:
        robot = self.plant.robot
        first = lost_start(self.system)
        bad = self._bad_state(first)
        trace = self._trace(bad.states, bad.last)
        start = assumed(self.plant, first)
        start += f"after {trace_text(trace)}, which no controller can prevent, " if trace else ""
        message = f"no controller can satisfy the requirements: {start}{bad.cause.reason}"
        cause = bad.cause
        diagnostic = Diagnostic(
            Severity.ERROR, "empty-supervisor", message, robot.span, cause.remedy, _notes(cause)
        )
        return Explanation(None, message, trace, diagnostic.hint, diagnostic)

    def guard(self, guard: Guard) -> Iterator[Explanation]:
        """Yield what there is to say of a guard that is restricted or never holds."""
        event = guard.event
        refused = conjunction([allowed(self.plant, event), negation(guard.expr)])
        path = nearest(self.system, refused)
        if path is None:
            yield from self._never_asked(guard)
            return
        number = self.plant.events.index(event)
        outcomes = list(self.stepper.compiled(number, None).targets(path[-1]))
        # Of several outcomes that the environment chooses from, explain a bad one.
        values, target = min(outcomes, key=lambda outcome: self.system.is_good(outcome[1]))
        command = make_step(self.plant, event, values, path[-1], target)
        bad = self._bad_state(target, (command,))
        after = self._trace(bad.states, bad.last)
        trace = (*steps_of(self.stepper, path), command, *after)
        name = event_text(event)
        never = guard.status == "never"
        head = f"{name} can never be allowed" if never else f"{name} is restricted further"
        before = trace_text(trace[: len(trace) - len(after)])
        forced = f" the controller cannot prevent {trace_text(after)}; then" if after else ","
        traced = self.plant.is_initial(path[0])
        if traced:
            start, end = assumed(self.plant, path[0]), ""
        else:
            start, end = f"{whereabouts(self.plant, path[0], refused)}, ", f" {UNTRACED}"
        message = f"{head}: {start}after {before}{forced} {bad.cause.reason}{end}"
        diagnostic = Diagnostic(
            Severity.WARNING,
            "never-allowed" if never else "restricted-command",
            message,
            event.span,
            bad.cause.remedy,
            _notes(bad.cause),
        )
        shown = trace if traced else ()
        yield Explanation(event, message, shown, diagnostic.hint, diagnostic, traced)

    def _never_asked(self, guard: Guard) -> Iterator[Explanation]:
        """Yield why a command never happens that the plant or the requirements never allow.

        Where nothing is ever violated there is nothing to cancel, and nothing to say.
        """
        event = guard.event
        name = event_text(event)
        if not self.system.reaches(possible(self.plant, event)):
            reason = f"{name} never happens: {self._impossible(event)}"
        elif event.kind is EventKind.CANCEL and guard.required == FALSE:
            reason = f"{name} never happens: no requirement is a reason to cancel {event.name}"
        elif event.kind is EventKind.CANCEL:
            return
        else:
            reason = (
                f"{name} never happens: its requirements hold in no state of the controlled system"
                " in which it is possible"
            )
        diagnostic = Diagnostic(Severity.WARNING, "never-allowed", reason, event.span)
        yield Explanation(event, reason, (), None, diagnostic)

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

        ``before`` is the step that led to ``start``.
        """
        paths: list[tuple[PlantState, ...]] = []
        for path in self._unpreventable(start):
            found = self._plain(path, before)
            if found is not None:
                return found
            paths.append(path)
        for path in paths:
            steps = partial(self._steps, before, path)
            blocked = why_blocked(self.stepper, path[-1], steps)
            if blocked is not None:
                return _BadState(path, None, blocked)
        for path in paths if self.plant.goals else ():
            impossible = why_impossible(self.stepper, path[-1])
            if impossible is not None:
                return _BadState(path, None, impossible)
        where = "a marked state"
        if self.plant.goals:
            where += ", or to what must remain possible,"
        reason = f"each way back to {where} passes through states that must be avoided"
        near = near_fault(self.stepper, start, self.leaving)
        if near is None:
            return _BadState((start,), None, Cause(reason))
        cause = Cause(f"{reason}: {near.reason}", near.remedy, near.span)
        return _BadState((start,), None, cause)

    def _steps(self, before: tuple[Step, ...], path: tuple[PlantState, ...]) -> tuple[Step, ...]:
        return (*before, *steps_of(self.stepper, path))

    def _unpreventable(self, start: PlantState) -> Iterator[tuple[PlantState, ...]]:
        """Yield paths of uncontrollable events over states that are not good, shortest first.

        Where there are many, it goes on depth first: of twelve parts that fail in any order, the
        subsets are many, and the first sequence is as good as another.
        """
        seen = {start}
        looked = 0
        sampled = any(event.is_sampled for event in self.uncontrollable)
        most = limits.SAMPLED_STEPS if sampled else limits.EXPLAINING_STEPS
        left = deque[tuple[PlantState, ...]]([(start,)])
        for number in range(limits.PATHS):
            if not left:
                return
            shortest_first = number < limits.SHORTEST_PATHS or len(left[0]) <= 2
            path = left.popleft() if shortest_first else left.pop()
            yield path
            if looked > most:
                continue
            for step, target in self._uncontrollable(path[-1], self.uncontrollable):
                looked += 1 + len(step.values)  # time grows with the number of parameters
                if isinstance(target, Verdict) or target in seen:
                    continue
                if not self.system.is_good(target):
                    seen.add(target)
                    left.append((*path, target))

    def _uncontrollable(
        self, state: PlantState, events: Iterable[CompiledEvent]
    ) -> Iterator[tuple[Step, Outcome]]:
        for event in events:
            for values in event.some_values:
                target = event.step(state, values)
                if target is not Verdict.IMPOSSIBLE:
                    yield Step(self.plant.events[event.number], values), target

    def _plain(self, path: tuple[PlantState, ...], before: tuple[Step, ...]) -> _BadState | None:
        state = path[-1]
        for holds, requirement in self.invariants:
            if not holds(state):
                reason = f"{quoted(requirement.text)} fails"
                steps = (*before, *steps_of(self.stepper, path))
                remedy = _avoiding(requirement, steps[-1].event if steps else None)
                return _BadState(path, None, Cause(reason, remedy, requirement.span))
        for step, target in self._uncontrollable(state, self.leaving):
            if target is Verdict.OUT_OF_RANGE:
                return _BadState(path, step, why_out_of_range(self.plant, step, state))
        return None


def _may_leave(plant: Plant, number: int) -> bool:
    return any(
        isinstance(plant.variables[variable].values, range)
        for automaton in plant.events[number].automata
        for edge in automaton.edges
        for variable, _ in edge.updates
    )


def _avoiding(requirement: Requirement, event: Event | None) -> str:
    """Return how to mend a state requirement that fails after an event, or at the start (None)."""
    read = dict.fromkeys(
        part.component
        for part in walk(requirement.condition)
        if isinstance(part, VariableRef | StateRef)
    )
    if not read:
        return "relax the requirement"
    if event is None:
        return f"let {listing(list(read))} start otherwise, or relax the requirement"
    movers = [p.component for p in event.automata if p.component in read]
    return f"change what {event_text(event)} does to {listing(movers)}, or relax the requirement"


def _notes(cause: Cause) -> tuple[Note, ...]:
    return () if cause.span is None else (Note("this is where it goes wrong", cause.span),)
