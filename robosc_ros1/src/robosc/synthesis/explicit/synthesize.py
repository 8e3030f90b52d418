"""Synthesis with the explicit engine."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Iterator
from functools import partial

from robosc.plant.automaton import Event, Plant, PlantState
from robosc.progress import Progress
from robosc.supervisor import Guard
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.explicit.care_set import ExplicitCareSet, care_set
from robosc.synthesis.explicit.explicit_engine import (
    EventOutcomes,
    ExplicitEngine,
    ExplicitSolution,
    Limit,
    ManyGuarded,
)
from robosc.synthesis.explicit.plant_states import PlantStates
from robosc.synthesis.explicit.search import ExplicitSystem
from robosc.synthesis.guards.shorten import GuardInputs, GuardMaker
from robosc.synthesis.result import Sizes, Solved
from robosc.synthesis.time_limit import ExplanationTime


class ExplicitSynthesis:
    """Synthesis of one plant, which goes on where a limit ended it before."""

    def __init__(
        self,
        plant: Plant,
        progress: Progress | None = None,
        explaining: ExplanationTime | None = None,
    ) -> None:
        self._engine = ExplicitEngine(plant)
        self._plant_states = PlantStates(plant)
        self._progress = progress
        self._explaining = explaining

    def run(self, limit: Limit, most_guarded: float = math.inf) -> Solved:
        """Return the supervisor; an empty one is a result, not an error.

        Raises:
            TooMany: by ``limit``, or commands are restricted in more than ``most_guarded`` states.
        """
        start = time.perf_counter()
        solution = self._engine.solve(limit)
        if len(solution.states) > most_guarded and solution.restricted:
            raise ManyGuarded(self._engine.found.states)
        self._plant_states.search(limit)
        guards, transitions = _measured(solution, self._progress)
        sizes = Sizes(self._plant_states.count, len(solution.states), transitions)
        seconds = time.perf_counter() - start
        system = ExplicitSystem(solution, self._plant_states, self._explaining)
        return Solved(system, "explicit", seconds, sizes, guards, self._progress)


def enabled_commands(plant: Plant, limit: Limit) -> list[Event] | None:
    """Return the commands that the supervisor allows in some state; None if it is empty.

    Raises:
        TooMany: by ``limit``.
    """
    solution = ExplicitEngine(plant).solve(limit)
    if solution.empty:
        return None
    return [
        event.event
        for event in solution.engine.events
        if event.event.controllable and _Places(solution, event).allowed
    ]


def _measured(
    solution: ExplicitSolution, progress: Progress | None
) -> tuple[tuple[Guard, ...], int]:
    """Return the guards, and the number of transitions under control."""
    guards: list[Guard] = []
    transitions = 0
    events = solution.engine.events
    states = [solution.engine.found.states[number] for number in solution.states]
    maker = GuardMaker(solution.engine.plant)
    for event in events if not solution.empty else ():
        if progress is not None:
            progress("guards", event.number, len(events))
        if not event.event.controllable:
            transitions += event.number_in(states)
            continue
        places = _Places(solution, event)
        transitions += len(places.allowed) * weight(event.event)
        guards.append(maker.guard(event.event, places.inputs))
    return tuple(guards), transitions


class _Places:
    """The controlled states in which a command is possible (``possible``), required (``asked``),
    and allowed under control."""

    def __init__(self, solution: ExplicitSolution, event: EventOutcomes) -> None:
        self._stepper = solution.engine.stepper
        states = solution.engine.found.states
        own = event.number
        keeping = solution.keeping.get(own, ())
        refused = solution.engine.refused(solution.good) if event.event.branches else set()
        self.possible = [n for n in solution.states if event.of(states[n]).changes]
        self.asked = [n for n in self.possible if event.test is None or event.test(states[n])]
        self.allowed = {n for n in self.asked if n in keeping and (n, own) not in refused}
        self._states = states

    @property
    def inputs(self) -> GuardInputs:
        return GuardInputs(
            not self.allowed,
            len(self.allowed) == len(self.asked),
            partial(self._care_set, self.asked),
            partial(self._care_set, self.possible),
        )

    def _care_set(self, among: Collection[int]) -> ExplicitCareSet:
        return care_set(
            self._stepper,
            self._chosen(self.allowed),
            self._chosen(n for n in among if n not in self.allowed),
        )

    def _chosen(self, numbers: Collection[int] | Iterator[int]) -> Iterator[PlantState]:
        return (self._states[number] for number in numbers)
