"""Explicit search of the controller that runs a supervisor: its run-to-completion steps.

From a state at rest the controller takes one input or command, then internal transitions (taus) in
source order, round by round, until none is possible: one *step*.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from robosc.language.events import EventKind
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.step import is_replacing
from robosc.supervisor import Guard
from robosc.synthesis.compiled_steps import CompiledEvent, Stepper
from robosc.synthesis.controlled_system import Runs, inputs
from robosc.synthesis.explore import reaching

_Path: TypeAlias = tuple[PlantState, ...]
Input: TypeAlias = tuple[CompiledEvent, ...]
"""The events of one input, one after the other; only a message may have several."""


@dataclass(frozen=True, slots=True)
class Completion:
    """The states of one run to completion, with its start; ``ends`` is False for a cycle."""

    path: _Path
    ends: bool

    @property
    def rest(self) -> PlantState:
        return self.path[-1]


class ExplicitController:
    """The controller of a supervisor, searched state by state."""

    def __init__(self, plant: Plant, guards: Sequence[Guard]) -> None:
        self.plant = plant
        compiled = Stepper(plant)
        events = compiled.controlled(guards)
        self.taus = [w for w in events if plant.events[w.number].kind is EventKind.TAU]
        self._inputs = [tuple(events[n] for n in numbers) for numbers in inputs(plant)]
        requests = {e.command: n for n, e in enumerate(plant.events) if e.kind.sent}
        self.preferred = {
            requests[key]: [events[requests[other]] for other in others]
            for key, others in plant.robot.yields_to.items()
            if key in requests  # the plant may be a part of the robot
        }
        self._completions: dict[PlantState, Completion] = {}
        self._came: dict[PlantState, PlantState] = {}
        """Per state in which a step starts, the state at rest before it; none for initial ones."""
        self._rests: dict[PlantState, PlantState] = {}
        """Per state at rest, the start of the first step that led to it."""
        self._went: list[tuple[PlantState, PlantState]] = []
        """From each state at rest to the starts of the steps that follow, if something must remain
        possible."""
        self._goals = [tuple(map(compiled.test, goal.conditions)) for goal in plant.goals]
        self._edges: list[tuple[PlantState, PlantState]] = []

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

    def complete(self, state: PlantState) -> Completion:
        """Run to completion as the controller does: taus in source order until none is left."""
        path = [state]
        seen: set[PlantState] = set()
        while state not in seen:
            seen.add(state)
            before = len(path)
            for tau in self.taus:
                for after in tau_targets(tau, state):
                    state = after
                    path.append(state)
            if len(path) == before:
                return Completion(tuple(path), True)
        return Completion(tuple(path), False)

    def leaving(self, rest: PlantState) -> Iterator[tuple[Input, _Path]]:
        """Yield what may happen at rest, with a path to each state that it leads to."""
        for events in self._inputs:
            preferred = self.preferred.get(events[0].number, ())
            sent = (o for o in preferred if not is_replacing(self.plant.events[o.number], rest))
            if not any(True for other in sent for _ in other.targets(rest)):
                yield from ((events, path) for path in _paths(events, rest))

    # --- the search

    def _run(self, most: float = math.inf) -> None:
        """Search all steps, or until there are more than ``most``."""
        queue: list[PlantState] = []
        for state in self.plant.initial_states:
            queue.extend(self._completed(state))
            if len(self._completions) > most:
                return
        for rest in queue:  # appended to below
            if len(self._completions) > most:
                return
            for _, path in self.leaving(rest):
                after = path[-1]
                if after not in self._completions:
                    self._came[after] = rest
                queue.extend(self._completed(after))
                if self._goals:
                    self._went.append((rest, after))
                if self._completions[after].ends:
                    self._edges.append((rest, self._completions[after].rest))

    def _completed(self, start: PlantState) -> list[PlantState]:
        """Run to completion from a new state; return the state at rest if that is new, too."""
        if start in self._completions:
            return []
        completion = self._completions[start] = self.complete(start)
        if not completion.ends or completion.rest in self._rests:
            return []
        self._rests[completion.rest] = start
        return [completion.rest]

    def _chain(self, start: PlantState) -> tuple[PlantState, ...]:
        """Return the chain (:class:`Runs`) to a step that was found, given its start."""
        chain = [start]
        while (rest := self._came.get(chain[-1])) is not None:
            chain.append(self._rests[rest])
        return tuple(reversed(chain))

    # --- the properties

    def _endless(self) -> tuple[PlantState, ...] | None:
        """Return the chain to a step that does not end, if one was found."""
        endless = (start for start, found in self._completions.items() if not found.ends)
        return next(map(self._chain, endless), None)

    def _differing(self) -> tuple[tuple[PlantState, ...], PlantState, PlantState] | None:
        """Return the chain to a step that may end in two states, and both; None if there is none.

        An order that never ends is not counted as an end: bounded response covers it.
        """
        known: dict[PlantState, PlantState] = {}
        for start in self._completions:
            ends: dict[PlantState, None] = {}
            closing: list[PlantState] = []
            before: dict[PlantState, list[PlantState]] = {start: []}
            queue = [start]
            for state in queue:  # appended to below
                after = [target for tau in self.taus for target in tau_targets(tau, state)]
                if state in known or not after:
                    ends[known.get(state, state)] = None
                    closing.append(state)
                    continue
                queue.extend(t for t in dict.fromkeys(after) if t not in before)
                for target in after:
                    before.setdefault(target, []).append(state)
            if len(ends) > 1:
                one, other, *_ = ends
                return self._chain(start), one, other
            for state in closing:  # appended to below, backward from the end
                known.setdefault(state, *ends)
                closing.extend(before.pop(state, ()))
        return None

    def _stuck(self) -> tuple[PlantState, ...] | None:
        """Return the chain to a step that ends where no marked state at rest can be reached."""
        good = reaching(filter(self.plant.is_marked, self._rests), self._edges)
        stuck = (start for rest, start in self._rests.items() if rest not in good)
        return next(map(self._chain, stuck), None)

    def _missed(self) -> tuple[tuple[PlantState, ...], int] | None:
        """Return the chain to a step that ends where something must remain possible and is not."""
        for number, (there, along, origin) in enumerate(self._goals):
            # The first state of each step, in between included, that ends the way one way or other.
            ends = {
                start: next((s for s in found.path if there(s) or not along(s)), None)
                for start, found in self._completions.items()
            }
            good = set(filter(there, self._rests))
            left = [(rest, after) for rest, after in self._went if along(rest)]
            good.update(r for r, after in left if (s := ends[after]) is not None and there(s))
            ended = [(r, self._completions[a]) for r, a in left if ends[a] is None]
            good = reaching(good, [(r, found.rest) for r, found in ended if found.ends])
            missed = (s for rest, s in self._rests.items() if origin(rest) and rest not in good)
            chain = next(map(self._chain, missed), None)
            if chain is not None:
                return chain, number
        return None


def _paths(events: Input, state: PlantState) -> list[_Path]:
    """Return a path to each state that these events, one after the other, may lead to."""
    found: dict[PlantState, _Path] = {state: ()}
    for event in events:
        after: dict[PlantState, _Path] = {}
        for before, path in found.items():
            for _, target in event.targets(before):
                after.setdefault(target, (*path, before))
        found = after
    return [(*path, target) for target, path in found.items()]


def tau_targets(tau: CompiledEvent, state: PlantState) -> list[PlantState]:
    """Return where an internal transition leads; the controller takes no self-loop."""
    return [target for _, target in tau.targets(state) if target != state]
