"""Explicit search of the controller that runs a supervisor: its run-to-completion steps.

From a state at rest the controller takes one input or command, then internal transitions (taus) in
source order, round by round, until none is possible: one *step*.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Iterator
from itertools import chain
from typing import TypeAlias

from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.step import is_replacing
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import NumberedSteps, Runs, inputs
from robosc.synthesis.explore import reaching

_Path: TypeAlias = tuple[int, ...]
Input: TypeAlias = tuple[int, ...]
"""The events of one input, one after the other, by their numbers in the plant; only a message may
have several."""


@dataclass(frozen=True, slots=True)
class Completion:
    """The numbers of the states of one run to completion, with its start; ``ends`` is False for a
    cycle."""

    path: _Path
    ends: bool

    @property
    def rest(self) -> int:
        return self.path[-1]


class ExplicitController:
    """The controller of a supervisor, searched state by state; states are numbers in ``steps``."""

    def __init__(self, plant: Plant, steps: NumberedSteps) -> None:
        self.plant = plant
        self.steps = steps
        self._taus = {n for n, event in enumerate(plant.events) if event.kind is EventKind.TAU}
        self._inputs = inputs(plant)
        requests = {e.command: n for n, e in enumerate(plant.events) if e.kind.sent}
        self.preferred = {
            requests[key]: [requests[other] for other in others]
            for key, others in plant.robot.yields_to.items()
            if key in requests  # the plant may be a part of the robot
        }
        self._completions: dict[int, Completion] = {}
        self._came: dict[int, int] = {}
        """Per state in which a step starts, the state at rest before it; none for initial ones."""
        self._rests: dict[int, int] = {}
        """Per state at rest, the start of the first step that led to it."""
        self._went: dict[int, list[int]] = {}
        """Per state at rest the starts of the steps that follow."""
        self._internal: dict[int, list[tuple[int, int]]] = {}

    def runs(self) -> Runs:
        """Return what fails of the controller's run to completion."""
        self._run()
        livelock, differing, stuck = self._endless(), self._differing(), self._stuck()
        longest = max(len(completion.path) - 1 for completion in self._completions.values())
        return Runs(
            livelock=livelock,
            differing=differing,
            stuck=stuck,
            missed=self._missed(),
            longest=longest if livelock is None else None,
        )

    def livelock(self, most: int) -> tuple[PlantState, ...] | None:
        """Return the chain to a cycle among the first ``most`` steps, if there is one."""
        self._run(most)
        return self._endless()

    def complete(self, state: int) -> Completion:
        """Run to completion as the controller does: taus in source order until none is left."""
        path = [state]
        seen: set[int] = set()
        while state not in seen:
            seen.add(state)
            before, last = len(path), -1
            while step := next((s for s in self.internal(state) if s[0] > last), None):
                last, state = step
                path.append(state)
            if len(path) == before:
                return Completion(tuple(path), True)
        return Completion(tuple(path), False)

    def internal(self, state: int) -> list[tuple[int, int]]:
        """Return the internal transitions of a state; the controller takes no self-loop."""
        found = self._internal.get(state)
        if found is None:
            steps = self.steps.after(state)
            found = [(n, after) for n, after in steps if n in self._taus and after != state]
            self._internal[state] = found
        return found

    def leaving(self, rest: int) -> Iterator[tuple[Input, _Path]]:
        """Yield what may happen at rest, with a path to each state that it leads to."""
        steps: dict[int, list[int]] = {}
        for number, after in self.steps.after(rest):
            steps.setdefault(number, []).append(after)
        for numbers in self._inputs:
            targets = steps.get(numbers[0])
            if targets is None or self._yields(numbers[0], rest, steps):
                continue
            if len(numbers) == 1:
                for after in targets:
                    yield numbers, (rest, after)
            else:
                for path in self._paths(numbers, rest):
                    yield numbers, path

    def _yields(self, number: int, rest: int, steps: Container[int]) -> bool:
        """Whether a command is not sent at rest, since a preferred one is enabled."""
        others = self.preferred.get(number)
        if others is None:
            return False
        state = self.steps.states[rest]
        events = (self.plant.events[other] for other in others if other in steps)
        return not all(is_replacing(event, state) for event in events)

    def _paths(self, numbers: Input, state: int) -> list[_Path]:
        """Return a path to each state that these events, one after the other, may lead to."""
        found: dict[int, _Path] = {state: ()}
        for number in numbers:
            after: dict[int, _Path] = {}
            for before, path in found.items():
                for event, target in self.steps.after(before):
                    if event == number:
                        after.setdefault(target, (*path, before))
            found = after
        return [(*path, target) for target, path in found.items()]

    # --- the search

    def _run(self, most: float = math.inf) -> None:
        """Search all steps, or until there are more than ``most``."""
        queue: list[int] = []
        for state in self.plant.initial_states:
            queue.extend(self._completed(self.steps.number(state)))
            if len(self._completions) > most:
                return
        for rest in queue:  # appended to below
            if len(self._completions) > most:
                return
            self._went[rest] = list(dict.fromkeys(path[-1] for _, path in self.leaving(rest)))
            for after in self._went[rest]:
                if after not in self._completions:
                    self._came[after] = rest
                    queue.extend(self._completed(after))

    def _completed(self, start: int) -> list[int]:
        """Run to completion from a new state; return the state at rest if that is new, too."""
        if start in self._completions:
            return []
        completion = self._completions[start] = self.complete(start)
        if not completion.ends or completion.rest in self._rests:
            return []
        self._rests[completion.rest] = start
        return [completion.rest]

    def _chain(self, start: int) -> tuple[PlantState, ...]:
        """Return the chain (:class:`Runs`) to a step that was found, given its start."""
        found = [start]
        while (rest := self._came.get(found[-1])) is not None:
            found.append(self._rests[rest])
        return tuple(self.steps.states[number] for number in reversed(found))

    # --- the properties

    def _endless(self) -> tuple[PlantState, ...] | None:
        """Return the chain to a step that does not end, if one was found."""
        endless = (start for start, found in self._completions.items() if not found.ends)
        return next(map(self._chain, endless), None)

    def _differing(self) -> tuple[tuple[PlantState, ...], PlantState, PlantState] | None:
        """Return the chain to a step that may end in two states, and both; None if there is none.

        An order that never ends is not counted as an end: bounded response covers it.
        """
        known: dict[int, int] = {}
        for start in filter(self.internal, self._completions):
            ends: dict[int, None] = {}
            closing: list[int] = []
            before: dict[int, list[int]] = {start: []}
            queue = [start]
            for state in queue:  # appended to below
                after = [target for _, target in self.internal(state)]
                if state in known or not after:
                    ends[known.get(state, state)] = None
                    closing.append(state)
                    continue
                queue.extend(t for t in dict.fromkeys(after) if t not in before)
                for target in after:
                    before.setdefault(target, []).append(state)
            if len(ends) > 1:
                one, other, *_ = ends
                return self._chain(start), self.steps.states[one], self.steps.states[other]
            for state in closing:  # appended to below, backward from the end
                known.setdefault(state, *ends)
                closing.extend(before.pop(state, ()))
        return None

    def _stuck(self) -> tuple[PlantState, ...] | None:
        """Return the chain to a step that ends where no marked state at rest can be reached."""
        marked = self._all(self.plant.is_marked, self._rests)
        good = reaching(marked, self._steps(self._rests, self._completions))
        stuck = (start for rest, start in self._rests.items() if rest not in good)
        return next(map(self._chain, stuck), None)

    def _missed(self) -> tuple[tuple[PlantState, ...], int] | None:
        """Return the chain to a step that ends where something must remain possible and is not."""
        visited = set(chain.from_iterable(found.path for found in self._completions.values()))
        stepper = Stepper(self.plant)
        for number, goal in enumerate(self.plant.goals):
            tests = map(stepper.test, goal.conditions)
            there, along, origin = (self._all(test, visited) for test in tests)
            # Steps that come to it, be it in passing, and those that stay on the way to their end.
            coming: set[int] = set()
            staying: set[int] = set()
            for start, found in self._completions.items():
                end = next((s for s in found.path if s in there or s not in along), None)
                (staying if end is None else coming if end in there else set()).add(start)
            left = along & self._went.keys()
            good = there & self._rests.keys()
            good |= {rest for rest in left if not coming.isdisjoint(self._went[rest])}
            good = reaching(good, self._steps(left, staying))
            missed = (s for rest, s in self._rests.items() if rest in origin and rest not in good)
            found_chain = next(map(self._chain, missed), None)
            if found_chain is not None:
                return found_chain, number
        return None

    def _all(self, test: Callable[[PlantState], bool], numbers: Iterable[int]) -> set[int]:
        """Return the states that pass a test."""
        return {number for number in numbers if test(self.steps.states[number])}

    def _steps(self, rests: Iterable[int], starts: Container[int]) -> Iterator[tuple[int, int]]:
        """Yield from where to where, at rest both, steps with such starts lead and end."""
        for rest in rests:
            for start in self._went[rest]:
                if start in starts and (found := self._completions[start]).ends:
                    yield rest, found.rest
