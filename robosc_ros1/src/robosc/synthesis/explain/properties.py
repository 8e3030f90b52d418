"""Properties of the controller that runs the supervisor (docs/semantics.md, "The result").

Synthesis does not fix the order of controllable events; the controller does. After each event it
runs to completion: it takes the internal transitions (taus) in source order until none is possible,
and only then sends commands. A state in which none is possible is *at rest*. The checks follow the
controller properties checker of the Eclipse ESCET toolset:

- *bounded response*: each run-to-completion step ends; the bound caps it at run time;
- *confluence*: it ends in the same state whatever the order of the internal transitions;
- *nonblocking under control*: from each reachable state at rest, one that is marked and at rest can
  be reached, internal transitions taken eagerly;
- *always possible*, if the model asks for that: from each state at rest in which it is asked for,
  the controller can come to it, be it in passing, by steps from states at rest in which the
  condition for the way holds.

Preferences are taken into account: while a preferred command is enabled, the other one is not sent.
A message is one input, whatever the number of its communications. Without internal transitions and
preferences, all three properties follow from synthesis. With them the controlled system is
searched by sets of states (:meth:`System.runs`), or, if the engine has none, state by state. Where
that takes too long, bounded response is proved from the components' automata alone or by a greatest
fixpoint (:meth:`System.longest_completion`), or refuted by a cycle found near the initial state; a
diagnostic names the properties that were not checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from robosc import limits
from robosc.errors import Diagnostic, Severity, listing
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.diagnostics import first_of
from robosc.plant.automaton import Plant, PlantState
from robosc.supervisor import Guard, Step
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import Runs, System, make_step
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.explain.local_bound import longest_locally
from robosc.synthesis.explain.run_to_completion import ExplicitController
from robosc.synthesis.formatting import amount, quoted, step_text, trace_text

_FEW_STATES = 10_000
"""States up to which the longest step that is reached bounds all, and what fails is told by what
is found state by state."""


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


def _names(plant: Plant) -> tuple[str, ...]:
    return (*_NAMES, "always possible") if plant.goals else _NAMES


def examine(system: System, guards: Sequence[Guard], controlled_states: int) -> Properties:
    """Return the properties of the controller of a supervisor that is not empty."""
    stepping = any(g.event.kind is EventKind.TAU and g.status != "never" for g in guards)
    yields_to = system.plant.robot.yields_to
    if not stepping and not any(guard.event.key in yields_to for guard in guards):
        return Properties(tuple((name, True) for name in _names(system.plant)), 0)
    if _branching(system) > limits.COMBINATIONS:
        return _of_large(system, guards, controlled_states)
    controller = ExplicitController(system.plant, system.steps)
    few = controlled_states <= _FEW_STATES
    runs = system.runs(exactly=few)
    if runs is not None and not (few and runs.fails):
        return _of_runs(controller, runs, None if few else _longest(system))
    if controlled_states > limits.SEARCHED_STATES:
        return _of_large(system, guards, controlled_states)
    return _of_runs(controller, controller.runs(), None)


def _longest(system: System) -> int | None:
    """Return a bound on the internal transitions of a step, in any order, if there is one."""
    bound = longest_locally(system.plant)
    return system.longest_completion() if bound is None else bound


def _of_runs(controller: ExplicitController, runs: Runs, bound: int | None) -> Properties:
    """Return the properties from what a search found; ``bound`` replaces its bound if given."""
    reporter = _Reporter(controller)
    diagnostics: list[Diagnostic] = []
    if runs.livelock is not None:
        diagnostics.append(reporter.livelock(runs.livelock))
    if runs.differing is not None:
        diagnostics.append(reporter.order_matters(*runs.differing))
    if runs.stuck is not None and runs.livelock is None:
        diagnostics.append(reporter.blocking(runs.stuck))
    if runs.missed is not None and runs.livelock is None:
        diagnostics.append(reporter.impossible(*runs.missed))
    ends = runs.livelock is None
    found = ends, runs.differing is None, ends and runs.stuck is None, ends and runs.missed is None
    holds = zip(_names(controller.plant), found, strict=False)
    if bound is None:
        bound = runs.longest
    return Properties(tuple(holds), bound if ends else None, tuple(diagnostics))


def _of_large(system: System, guards: Sequence[Guard], controlled_states: int) -> Properties:
    """Return what can be decided without visiting all states."""
    bound = _longest(system)
    branching, livelock = _branching(system), None
    outcomes = f", a message {amount(branching)} values" if branching > limits.COMBINATIONS else ""
    if bound is None and branching <= limits.COMBINATIONS:
        controller = ExplicitController(system.plant, system.steps)
        chain = controller.livelock(limits.FIRST_STEPS)
        livelock = None if chain is None else _Reporter(controller).livelock(chain)
    holds: tuple[tuple[str, bool], ...] = ()
    if bound is not None or livelock is not None:
        holds = ((_NAMES[0], livelock is None),)
    left_out = _names(system.plant)[len(holds) :]
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


class _Reporter:
    """Diagnostics of what fails, each with the trace along a chain of steps (:class:`Runs`)."""

    def __init__(self, controller: ExplicitController) -> None:
        self.controller = controller
        self.plant = controller.plant
        self._steps = controller.steps
        self._stepper = Stepper(controller.plant)

    def livelock(self, chain: Sequence[PlantState]) -> Diagnostic:
        path = self._completed(chain[-1])
        begin = path.index(path[-1])
        cycle = self._internal(path[begin:])
        trace = self._trace(chain) + self._internal(path[: begin + 1])
        return Diagnostic(
            Severity.WARNING,
            "livelock",
            f"the internal transitions never end: {_after(trace)} they repeat"
            f" {first_of(map(step_text, cycle))}",
            cycle[0].event.span,
            "give one of the transitions a guard that fails after the step",
        )

    def order_matters(
        self, chain: Sequence[PlantState], one: PlantState, other: PlantState
    ) -> Diagnostic:
        first, _ = self.controller.internal(self._steps.number(chain[-1]))[0]
        return Diagnostic(
            Severity.WARNING,
            "order-matters",
            "where the internal transitions end depends on their order:"
            f" {_after(self._trace(chain))}, in {self._difference(one, other)};"
            " the controller takes them in source order",
            self.plant.events[first].span,
            "let their guards exclude each other, or accept the source order",
        )

    def blocking(self, chain: Sequence[PlantState]) -> Diagnostic:
        trace = self._trace(chain) + self._internal(self._completed(chain[-1]))
        return Diagnostic(
            Severity.WARNING,
            "blocking-under-control",
            f"{_after(trace)} the controller never again comes to rest in a marked state,"
            f" because {self._order()}",
            self.plant.robot.span,
            "mark the states in which it does come to rest, or guard the steps that leave them",
        )

    def impossible(self, chain: Sequence[PlantState], goal: int) -> Diagnostic:
        trace = self._trace(chain) + self._internal(self._completed(chain[-1]))
        written = self.plant.robot.goals[self.plant.goals[goal].index]
        return Diagnostic(
            Severity.WARNING,
            "impossible-under-control",
            f"{_after(trace)} {quoted(written.text)} fails under the controller,"
            f" because {self._order()}",
            written.span,
            "guard the steps that lead away from it, or give up the preference",
        )

    def _difference(self, one: PlantState, other: PlantState) -> str:
        sides = [
            [
                f"{variable.name}.{variable.values[state[n]]}".replace(" ", ".")
                for n, variable in enumerate(self.plant.variables)
                if one[n] != other[n]
            ]
            for state in (one, other)
        ]
        return " or in ".join(listing(names) for names in sides)

    def _order(self) -> str:
        """Return which choices of the controller synthesis does not make."""
        if not any(event.kind is EventKind.TAU for event in self.plant.events):
            return "it sends preferred commands as long as they are enabled"
        preferring = ", and preferred commands first" if self.controller.preferred else ""
        return f"it takes the internal transitions as soon as it can{preferring}"

    # --- traces

    def _trace(self, chain: Sequence[PlantState]) -> tuple[Step, ...]:
        """Return the trace from the initial state to the last state of a chain."""
        steps: list[Step] = []
        for before, start in pairwise(map(self._steps.number, chain)):
            completion = self.controller.complete(before)
            steps += self._internal(completion.path)
            events, path = next(
                each for each in self.controller.leaving(completion.rest) if each[1][-1] == start
            )
            steps += map(self._step, events, path, path[1:])
        return tuple(steps)

    def _completed(self, start: PlantState) -> Sequence[int]:
        return self.controller.complete(self._steps.number(start)).path

    def _internal(self, path: Sequence[int]) -> tuple[Step, ...]:
        return tuple(
            self._step(
                next(tau for tau, target in self.controller.internal(before) if target == after),
                before,
                after,
            )
            for before, after in pairwise(path)
        )

    def _step(self, event: int, one: int, other: int) -> Step:
        before, after = self._steps.states[one], self._steps.states[other]
        targets = self._stepper.compiled(event, None).targets(before)
        values = next(values for values, target in targets if target == after)
        return make_step(self.plant, self.plant.events[event], values, before, after)


def _after(steps: Sequence[Step]) -> str:
    return f"after {trace_text(steps)}" if steps else "at the start"
