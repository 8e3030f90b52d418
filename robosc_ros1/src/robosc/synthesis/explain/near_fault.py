"""The nearest state that is bad by itself, where a whole region must be avoided because of it.

Such a state takes a variable out of its range whatever the controller does, or no marked state, or
none of what must remain possible, can be reached from it in the plant under its requirements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from robosc import limits
from robosc.plant.automaton import PlantGoal, PlantState
from robosc.plant.step import Values, Verdict
from robosc.supervisor import Step
from robosc.synthesis.compiled_steps import CompiledEvent, Stepper
from robosc.synthesis.controlled_system import steps_of
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.explain.blocking import Cause, why_blocked, why_impossible
from robosc.synthesis.explain.range_violation import why_out_of_range
from robosc.synthesis.formatting import trace_text


def near_fault(
    stepper: Stepper, start: PlantState, leaving: Iterable[CompiledEvent]
) -> Cause | None:
    """Return the nearest bad state as a cause, its reason with the trace that leads there; None if
    none is found.

    ``leaving`` are the uncontrollable events that may take a variable out of its range.
    """
    plant = stepper.plant
    if any(weight(event) > limits.COMBINATIONS for event in plant.events):
        return None
    region = _Region(stepper, start)
    candidates = [
        _out_of_range(stepper, region, list(leaving)),
        *(_cut_off(stepper, region, goal) for goal in (None, *plant.goals)),
    ]
    found = [candidate for candidate in candidates if candidate is not None]
    if not found:
        return None
    number, last = min(found, key=lambda candidate: candidate[0])
    path = region.path(number)
    steps = steps_of(stepper, path)
    if last is not None:
        cause = why_out_of_range(plant, last, path[-1])
        return _told((*steps, last), cause)
    here = path[-1]
    why = why_blocked(stepper, here, lambda: steps) or why_impossible(stepper, here)
    return None if why is None else _told(steps, why)


_Candidate = tuple[int, Step | None]
"""The number of a bad state, and the step that takes a variable out of its range there."""


def _told(steps: tuple[Step, ...], cause: Cause) -> Cause:
    after = f"after {trace_text(steps)}, " if steps else ""
    return Cause(after + cause.reason, cause.remedy, cause.span)


@dataclass
class _Region:
    """What can be reached from a state, in breadth-first order, and ``complete`` if that is all."""

    stepper: Stepper
    start: PlantState
    states: list[PlantState] = field(default_factory=list)
    before: list[int] = field(default_factory=list)
    """For each state, by number, the one from which it is reached first."""
    into: list[list[int]] = field(default_factory=list)
    """For each state, those with an event that leads to it."""
    complete: bool = False

    def __post_init__(self) -> None:
        events = self.stepper.required()
        work = sum(weight(event) for event in self.stepper.plant.events)  # in each state
        most = min(limits.REGION_STATES, limits.EXPLAINING_STEPS // max(work, 1))
        numbers = {self.start: 0}
        self.states, self.before, self.into = [self.start], [0], [[]]
        for number, state in enumerate(self.states):  # appended to below
            for event in events:
                for _, target in event.targets(state):
                    if target not in numbers:
                        numbers[target] = len(self.states)
                        self.states.append(target)
                        self.before.append(number)
                        self.into.append([])
                    self.into[numbers[target]].append(number)
            if len(self.states) > most:
                return
        self.complete = True

    def path(self, number: int) -> tuple[PlantState, ...]:
        """The states on the way to one."""
        found = [number]
        while found[-1]:
            found.append(self.before[found[-1]])
        return tuple(self.states[n] for n in reversed(found))

    def leading_to(
        self, there: Callable[[PlantState], bool], along: Callable[[PlantState], bool]
    ) -> set[int]:
        """Those from which a state can be reached, on states that fulfil a condition."""
        todo = [n for n, state in enumerate(self.states) if there(state)]
        found = set(todo)
        while todo:
            for other in self.into[todo.pop()]:
                if other not in found and along(self.states[other]):
                    found.add(other)
                    todo.append(other)
        return found


def _out_of_range(
    stepper: Stepper, region: _Region, leaving: list[CompiledEvent]
) -> _Candidate | None:
    for number, state in enumerate(region.states):
        for event, values in _tried(leaving):
            if event.step(state, values) is Verdict.OUT_OF_RANGE:
                return number, Step(stepper.plant.events[event.number], values)
    return None


def _tried(events: Iterable[CompiledEvent]) -> Iterator[tuple[CompiledEvent, Values]]:
    return ((event, values) for event in events for values in event.some_values)


def _cut_off(stepper: Stepper, region: _Region, goal: PlantGoal | None) -> _Candidate | None:
    """The first state from which a goal (None: a marked state) can no longer be reached."""
    if not region.complete:
        return None
    there, along, origin = (
        (stepper.plant.is_marked, _always, _always)
        if goal is None
        else map(stepper.test, goal.conditions)
    )
    leading = region.leading_to(there, along)
    return next(
        ((n, None) for n, s in enumerate(region.states) if n not in leading and origin(s)), None
    )


def _always(_: PlantState) -> bool:
    return True
