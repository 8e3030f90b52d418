"""Properties of the controller that runs the supervisor (docs/semantics.md, "The result").

Synthesis does not fix the order of controllable events; the controller does. After each event it
runs to completion: it takes the internal transitions (taus) in source order until none is possible,
and only then sends commands. A state in which none is possible is *at rest*. The checks follow the
controller properties checker of the Eclipse ESCET toolset:

- *bounded response*: each run-to-completion step ends; the bound caps it at run time;
- *confluence*: it ends in the same state whatever the order of the internal transitions;
- *nonblocking under control*: from each reachable state at rest, one that is marked and at rest can
  be reached, internal transitions taken eagerly.

Preferences are taken into account: while a preferred command is enabled, the other one is not sent.
A message is one input, whatever the number of its communications. Without internal transitions and
preferences, all three properties follow from synthesis. With them the controlled system is
searched state by state, or, if it is too large, by sets of states (:meth:`System.runs`). Where that
takes too long, bounded response is proved from the components' automata alone or by a greatest
fixpoint (:meth:`System.longest_completion`), or refuted by a cycle found near the initial state; a
diagnostic names the properties that were not checked.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

from robosc.errors import Diagnostic, Severity, listing
from robosc.ir.automaton import Plant, PlantState
from robosc.model.diagnostics import first_of
from robosc.model.entities import EventKind
from robosc.supervisor import Guard, Step
from robosc.synthesis.event_parameters import MOST_COMBINATIONS, weight
from robosc.synthesis.explain.local_bound import longest_locally
from robosc.synthesis.explore import reaching
from robosc.synthesis.formatting import amount, step_text, trace_text
from robosc.synthesis.stepper import CompiledEvent, Stepper
from robosc.synthesis.system import Runs, System, inputs, make_step

__all__ = ["Properties", "examine"]

_Path: TypeAlias = tuple[PlantState, ...]

_FEW_STATES = 10_000
"""States up to which explicit search is as fast as the symbolic one."""
_MOST_STATES = 100_000
"""States above which there is no full explicit search."""
_FIRST = 2_000
"""Run-to-completion steps that are searched for a cycle in a system with more states."""


@dataclass(frozen=True)
class Properties:
    """Whether each property holds, by name; unknown ones are left out.

    ``step_bound`` bounds the internal transitions of a run-to-completion step; None: unknown or
    livelock.
    """

    holds: tuple[tuple[str, bool], ...]
    step_bound: int | None
    diagnostics: tuple[Diagnostic, ...] = ()


_NAMES = ("bounded response", "confluence", "nonblocking under control")


def examine(system: System, guards: Sequence[Guard], controlled_states: int) -> Properties:
    """Return the properties of the controller of a supervisor that is not empty."""
    stepping = any(g.event.kind is EventKind.TAU and g.status != "never" for g in guards)
    yields_to = system.plant.robot.yields_to
    if not stepping and not any(guard.event.key in yields_to for guard in guards):
        return Properties(tuple((name, True) for name in _NAMES), 0)
    if _branching(system) > MOST_COMBINATIONS:
        return _of_large(system, guards, controlled_states)
    runs = system.runs() if controlled_states > _FEW_STATES else None
    if runs is not None:
        return _Controller(system.plant, guards).of_runs(runs, _longest(system))
    if controlled_states > _MOST_STATES:
        return _of_large(system, guards, controlled_states)
    return _Controller(system.plant, guards).examine()


def _longest(system: System) -> int | None:
    """Return a bound on the internal transitions of a step, in any order, if there is one."""
    bound = longest_locally(system.plant)
    return system.longest_completion() if bound is None else bound


def _of_large(system: System, guards: Sequence[Guard], controlled_states: int) -> Properties:
    """Return what can be decided without visiting all states."""
    bound = _longest(system)
    branching, livelock = _branching(system), None
    outcomes = f", a message {amount(branching)} values" if branching > MOST_COMBINATIONS else ""
    if bound is None and branching <= MOST_COMBINATIONS:
        livelock = _Controller(system.plant, guards).livelock(_FIRST)
    holds: tuple[tuple[str, bool], ...] = ()
    if bound is not None or livelock is not None:
        holds = ((_NAMES[0], livelock is None),)
    left_out = _NAMES[len(holds) :]
    unchecked = Diagnostic(
        Severity.WARNING,
        "properties-unchecked",
        f"the controlled system has {amount(controlled_states)} states{outcomes},"
        " too many to visit:"
        f" {listing(left_out)} {'was' if len(left_out) == 1 else 'were'} not checked",
        system.plant.robot.span,
        "narrow the ranges of variables that requirements read, or avoid internal transitions",
    )
    return Properties(holds, bound, (*([] if livelock is None else [livelock]), unchecked))


def _branching(system: System) -> int:
    return max(map(weight, system.plant.events), default=0)


@dataclass(frozen=True, slots=True)
class _Completion:
    """The states of one run-to-completion step, with its start; ``ends`` is False for a cycle."""

    path: tuple[PlantState, ...]
    ends: bool

    @property
    def rest(self) -> PlantState:
        return self.path[-1]


class _Controller:
    """Explicit search of the controller: from a state at rest one event, then run to completion."""

    def __init__(self, plant: Plant, guards: Sequence[Guard]) -> None:
        self.plant = plant
        self.stepper = Stepper(plant)
        events = self.stepper.controlled(guards)
        self.taus = [w for w in events if plant.events[w.number].kind is EventKind.TAU]
        self.inputs = [tuple(events[n] for n in numbers) for numbers in inputs(plant)]
        requests = {e.key: n for n, e in enumerate(plant.events) if e.kind is EventKind.REQUEST}
        self.preferred = {
            requests[key]: [events[requests[other]] for other in others]
            for key, others in plant.robot.yields_to.items()
            if key in requests  # the plant may be a part of the robot
        }
        self.completions: dict[PlantState, _Completion] = {}
        self.came: dict[PlantState, _Path] = {}
        """Per state in which a step starts, the path to it from a state at rest."""
        self.rests: dict[PlantState, PlantState] = {}
        """Per state at rest, the start of the first step that led to it."""
        self.edges: list[tuple[PlantState, PlantState]] = []

    def examine(self) -> Properties:
        self._run()
        diagnostics: list[Diagnostic] = []
        livelock = next((s for s in self.completions.values() if not s.ends), None)
        if livelock is not None:
            diagnostics.append(self._livelock(livelock))
        differing = self._differing()
        if differing is not None:
            diagnostics.append(self._order_matters(*differing))
        stuck = self._stuck()
        if stuck is not None and livelock is None:
            diagnostics.append(self._blocking(stuck))
        answers = (livelock is None, differing is None, stuck is None and livelock is None)
        holds = tuple(zip(_NAMES, answers, strict=True))
        bound = max(len(s.path) - 1 for s in self.completions.values())
        return Properties(holds, bound if livelock is None else None, tuple(diagnostics))

    def of_runs(self, runs: Runs, bound: int | None) -> Properties:
        """Return the properties from a symbolic search; ``bound`` replaces its bound if given."""
        diagnostics: list[Diagnostic] = []
        if runs.livelock is not None:
            diagnostics.append(self._livelock(self._follow(runs.livelock)))
        if runs.differing is not None:
            chain, one, other = runs.differing
            diagnostics.append(self._order_matters(self._follow(chain).path[0], one, other))
        if runs.stuck is not None and runs.livelock is None:
            diagnostics.append(self._blocking(self._follow(runs.stuck).rest))
        if bound is None:
            bound = runs.longest
        ends = runs.livelock is None
        answers = (ends, runs.differing is None, runs.stuck is None and ends)
        holds = tuple(zip(_NAMES, answers, strict=True))
        return Properties(holds, bound if ends else None, tuple(diagnostics))

    def _follow(self, chain: Sequence[PlantState]) -> _Completion:
        """Run to completion from each state of a chain (:class:`Runs`); return the last step."""
        for start in chain:
            self._completed(start)
        for before, start in pairwise(chain):
            rest = self.completions[before].rest
            self.rests[rest] = before
            paths = (path for events in self.inputs for path in _paths(events, rest))
            self.came[start] = next(path for path in paths if path[-1] == start)
        return self.completions[chain[-1]]

    def livelock(self, most: int) -> Diagnostic | None:
        """Return the diagnostic of a cycle among the first ``most`` steps, if there is one."""
        self._run(most)
        found = next((s for s in self.completions.values() if not s.ends), None)
        return None if found is None else self._livelock(found)

    def _run(self, most: int | None = None) -> None:
        """Search all steps, or until there are ``most``."""
        queue: list[PlantState] = []
        for state in self.plant.initial_states:
            queue.extend(self._completed(state))
            if most is not None and len(self.completions) > most:
                return
        for rest in queue:  # appended to below
            if most is not None and len(self.completions) > most:
                return
            for events in self.inputs:
                preferred = self.preferred.get(events[0].number, ())
                if any(_is_enabled(other, rest) for other in preferred):
                    continue
                for path in _paths(events, rest):
                    after = path[-1]
                    if after not in self.completions:
                        self.came[after] = path
                    queue.extend(self._completed(after))
                    if self.completions[after].ends:
                        self.edges.append((rest, self.completions[after].rest))

    def _completed(self, start: PlantState) -> list[PlantState]:
        """Run to completion from a new state; return the state at rest if that is new, too."""
        if start in self.completions:
            return []
        completion = self.completions[start] = self._complete(start)
        if not completion.ends or completion.rest in self.rests:
            return []
        self.rests[completion.rest] = start
        return [completion.rest]

    def _complete(self, state: PlantState) -> _Completion:
        """Run to completion as the controller does: taus in source order until none is left."""
        path = [state]
        seen: set[PlantState] = set()
        while state not in seen:
            seen.add(state)
            before = len(path)
            for tau in self.taus:
                for after in _moves(tau, state):
                    state = after
                    path.append(state)
            if len(path) == before:
                return _Completion(tuple(path), True)
        return _Completion(tuple(path), False)

    def _differing(self) -> tuple[PlantState, PlantState, PlantState] | None:
        """Return a state from which a step may end in two states, and both; None if there is none.

        An order that never ends is not counted as an end: bounded response covers it.
        """
        known: dict[PlantState, PlantState] = {}
        for start in self.completions:
            ends: dict[PlantState, None] = {}
            closing: list[PlantState] = []
            before: dict[PlantState, list[PlantState]] = {start: []}
            queue = [start]
            for state in queue:  # appended to below
                after = [target for tau in self.taus for target in _moves(tau, state)]
                if state in known or not after:
                    ends[known.get(state, state)] = None
                    closing.append(state)
                    continue
                queue.extend(t for t in dict.fromkeys(after) if t not in before)
                for target in after:
                    before.setdefault(target, []).append(state)
            if len(ends) > 1:
                one, other, *_ = ends
                return start, one, other
            for state in closing:  # appended to below, backward from the end
                known.setdefault(state, *ends)
                closing.extend(before.pop(state, ()))
        return None

    def _stuck(self) -> PlantState | None:
        """Return a state at rest from which no marked one at rest is reachable, if there is one."""
        good = reaching(filter(self.plant.is_marked, self.rests), self.edges)
        return next((rest for rest in self.rests if rest not in good), None)

    # --- diagnostics

    def _trace_to(self, start: PlantState) -> tuple[Step, ...]:
        """Return the trace from the initial state to a state in which a step starts."""
        steps: list[Step] = []
        while start in self.came:
            path = self.came[start]
            events = [event for events in self.inputs for event in events]
            steps[:0] = (self._step(events, before, after) for before, after in pairwise(path))
            start = self.rests[path[0]]
            steps[:0] = self._internal(self.completions[start].path)
        return tuple(steps)

    def _internal(self, path: Sequence[PlantState]) -> tuple[Step, ...]:
        return tuple(self._step(self.taus, before, after) for before, after in pairwise(path))

    def _step(self, events: Sequence[CompiledEvent], before: PlantState, after: PlantState) -> Step:
        for compiled in events:
            values = compiled.leading(before, after)
            if values is not None:
                event = self.plant.events[compiled.number]
                return make_step(self.plant, event, values, before, after)
        raise AssertionError("the states do not follow each other")

    def _after(self, steps: Sequence[Step]) -> str:
        return f"after {trace_text(steps)}" if steps else "at the start"

    def _livelock(self, completion: _Completion) -> Diagnostic:
        path = completion.path
        begin = path.index(path[-1])
        cycle = self._internal(path[begin:])
        trace = self._trace_to(path[0]) + self._internal(path[: begin + 1])
        return Diagnostic(
            Severity.WARNING,
            "livelock",
            f"the internal transitions never end: {self._after(trace)} they repeat"
            f" {first_of(map(step_text, cycle))}",
            cycle[0].event.span,
            "give one of the transitions a guard that fails after the step",
        )

    def _order_matters(self, start: PlantState, one: PlantState, other: PlantState) -> Diagnostic:
        first = next(tau for tau in self.taus if _moves(tau, start))
        return Diagnostic(
            Severity.WARNING,
            "order-matters",
            "where the internal transitions end depends on their order:"
            f" {self._after(self._trace_to(start))}, in {self._difference(one, other)};"
            " the controller takes them in source order",
            self.plant.events[first.number].span,
            "let their guards exclude each other, or accept the source order",
        )

    def _difference(self, one: PlantState, other: PlantState) -> str:
        sides = [
            [
                f"{variable.name}.{variable.values[state[n]]}"
                for n, variable in enumerate(self.plant.variables)
                if one[n] != other[n]
            ]
            for state in (one, other)
        ]
        return " or in ".join(listing(names) for names in sides)

    def _order(self) -> str:
        """Return which choices of the controller synthesis does not make."""
        if not self.taus:
            return "it sends preferred commands as long as they are enabled"
        preferring = ", and preferred commands first" if self.preferred else ""
        return f"it takes the internal transitions as soon as it can{preferring}"

    def _blocking(self, rest: PlantState) -> Diagnostic:
        start = self.rests[rest]
        trace = self._trace_to(start) + self._internal(self.completions[start].path)
        return Diagnostic(
            Severity.WARNING,
            "blocking-under-control",
            f"{self._after(trace)} the controller never again comes to rest in a marked state,"
            f" because {self._order()}",
            self.plant.robot.span,
            "mark the states in which it does come to rest, or guard the steps that leave them",
        )


def _paths(events: Sequence[CompiledEvent], state: PlantState) -> Iterable[_Path]:
    """Return a path to each state that these events, one after the other, may lead to."""
    found: dict[PlantState, _Path] = {state: ()}
    for event in events:
        after: dict[PlantState, _Path] = {}
        for before, path in found.items():
            for _, target in event.targets(before):
                after.setdefault(target, (*path, before))
        found = after
    return [(*path, target) for target, path in found.items()]


def _is_enabled(event: CompiledEvent, state: PlantState) -> bool:
    return any(True for _ in event.targets(state))


def _moves(tau: CompiledEvent, state: PlantState) -> list[PlantState]:
    """Return where an internal transition leads; the controller takes no self-loop."""
    return [target for _, target in tau.targets(state) if target != state]
