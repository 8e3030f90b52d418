"""Verification of a supervisor by explicit search, state by state.

Steps that the guards forbid and the requirements permit are followed as well: where they lead
decides whether the guards forbid more than necessary.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from operator import and_
from typing import TypeAlias

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import PlantState, VariableKind
from robosc.plant.support import support
from robosc.runtime.core.places import path_of
from robosc.supervisor import Step, Supervisor
from robosc.synthesis.bdd.manager import remedy
from robosc.synthesis.verify.graph import Backward, CodedGraph, Reached
from robosc.synthesis.verify.steps import Coding, EventSteps, Successors, condition, grouped
from robosc.synthesis.verify.verify_report import (
    MISSING,
    Check,
    Findings,
    event_phrase,
    possible_check,
)

_Work: TypeAlias = tuple[int, Successors, bool, bool]
"""One event in one state: its first label, its successors, whether its guard allows it, and whether
the requirements permit it.
"""

_Test: TypeAlias = Callable[[PlantState], bool]
_Invariants: TypeAlias = list[tuple[_Test, int]]
"""Conditions that must hold, each with the number of its requirement."""

# --- the search ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Goal:
    """What must remain possible, its conditions compiled."""

    text: str
    tests: tuple[_Test, ...]
    """What must be reached, what must hold on the way there, and from where."""


def _lead(
    graph: CodedGraph,
    backward: Backward,
    within: bytearray,
    along: bytearray,
    forbidden: bool,
    reaching: bytearray,
    todo: list[int],
) -> None:
    """Mark as ``reaching`` also what leads to states ``todo`` through states ``along``.

    With ``forbidden``, steps that the guards forbid count, too, and a command counts only where all
    its outcomes are ``within``.
    """
    while todo:
        for source, label in backward.steps(todo.pop()):
            if not along[source] or reaching[source]:
                continue
            if graph.staying(source, label, within) if forbidden else label >= 0:
                reaching[source] = 1
                todo.append(source)


class ExplicitVerifier:
    """One verification: conditions and successors are cached across its searches."""

    def __init__(self, supervisor: Supervisor, limit: int) -> None:
        plant = supervisor.plant
        self._supervisor = supervisor
        self._plant = plant
        self._limit = limit
        self._coding = Coding(plant)
        self._events = [EventSteps(plant, self._coding, event) for event in plant.events]
        guards = {guard.event.identity: guard.expr for guard in supervisor.guards}
        self._conditions = [(e.requirement, guards.get(e.identity)) for e in plant.events]
        self._invariants = [(condition(plant, expr), index) for expr, index in plant.invariants]
        self._touched: dict[int, _Invariants] = {}
        """Per first label of an event, what it may come to violate where all held before."""
        compiled = cache(partial(condition, plant))
        self._goals = [
            _Goal(plant.robot.goals[goal.index].text, tuple(map(compiled, goal.conditions)))
            for goal in plant.goals
        ]
        self._held: dict[_Test, bytearray] = {}
        # Uncontrollable events have the first labels, so one comparison identifies them.
        self._order = sorted(range(len(plant.events)), key=lambda i: plant.events[i].controllable)
        self._labels: dict[int, int] = {}
        self._labelled: list[tuple[int, int]] = []
        self._outcomes: dict[int, range] = {}
        for event in self._order:
            self._labels[event] = len(self._labelled)
            self._labelled += [(event, n) for n in range(len(self._events[event].valuations))]
            labels = range(self._labels[event], len(self._labelled))
            self._touched[labels.start] = [
                invariant
                for invariant, (expr, _) in zip(self._invariants, plant.invariants, strict=True)
                if not plant.events[event].writes.isdisjoint(support(plant, expr))
            ]
            if plant.events[event].controllable and len(labels) > 1:
                self._outcomes.update(dict.fromkeys(labels, labels))
        self._controllable_from = sum(not plant.events[e].controllable for e, _ in self._labelled)
        self._work = self._grouped_work()

    def _grouped_work(self) -> Callable[[PlantState], list[_Work]]:
        conditions = [
            [None if expr is None else condition(self._plant, expr) for expr in pair]
            for pair in self._conditions
        ]

        def work_out(event: int, state: PlantState) -> _Work | None:
            # Range violations last, so only the last one has to be checked.
            steps = sorted(self._events[event].successors(state), key=lambda step: step[1] is None)
            if not steps:
                return None
            required, guard = conditions[event]
            label = self._labels[event]
            free = label < self._controllable_from or (guard is not None and guard(state))
            permitted = required is None or required(state)
            return label, tuple(steps), free, permitted

        return grouped(self._plant, ((e, self._variables(e)) for e in self._order), work_out)

    def _variables(self, event: int) -> set[int]:
        """Return the state variables on which the work of an event depends."""
        exprs = (expr for expr in self._conditions[event] if expr is not None)
        read = (support(self._plant, expr) for expr in exprs)
        return self._events[event].variables.union(*read)

    def found(self) -> Findings:
        """Return what the searches find.

        Raises:
            StateSpaceError: there are too many states or transitions.
        """
        self._refuse()
        graph = self._search()
        backward = Backward.of(graph)
        keepable = self._keepable(graph, backward)
        reached = Reached.of(graph)
        # Where nothing is forbidden or lost, both searches for what blocks are the same.
        forbidding = bool(graph.violations) or min(graph.labels, default=0) < 0
        again = forbidding or not all(keepable)
        return Findings(
            method="explicit",
            keeps_initial=all(keepable[: graph.starts]),
            safe=self._check_safe(graph, reached),
            nonblocking=self._check_nonblocking(graph, backward, reached)
            if again
            else Check("nonblocking", True),
            possible=tuple(
                self._check_possible(goal, graph, backward, reached)
                if again
                else Check(possible_check(goal.text), True)
                for goal in self._goals
            ),
            permissive=self._check_permissive(graph, reached, keepable),
            states=len(reached.order),
            transitions=sum(graph.allowed[state] for state in reached.order),
            plant_states=self._plant_states(),
        )

    def _search(self) -> CodedGraph:
        """Return the graph that the requirements permit; unsafe states have no successors."""
        codes = [self._coding.encode(state) for state in self._plant.initial_states]
        number = {code: n for n, code in enumerate(codes)}
        graph = CodedGraph(codes, number, len(codes), self._outcomes)
        concerned = [self._invariants] * len(codes)
        here = 0
        while here < len(graph.codes):
            state = self._coding.decode(graph.codes[here])
            failing = self._violated(state, concerned[here])
            if failing is None:
                work = self._work(state)
                failing = self._escaping(work)
            if failing is None:
                self._add_steps(graph, here, work, concerned)
            else:
                graph.unsafe[here] = failing
                graph.allowed.append(0)
            graph.first.append(len(graph.targets))
            self._stop_at_limit(len(graph.codes), len(graph.targets))
            here += 1
        return graph

    def _add_steps(
        self, graph: CodedGraph, here: int, work: list[_Work], concerned: list[_Invariants]
    ) -> None:
        code, allowed = graph.codes[here], 0
        codes, number = graph.codes, graph.number
        for label, successors, free, permitted in work:
            if not permitted:
                if free:
                    graph.violations.setdefault(here, label)
                continue
            for values, change in successors:
                assert change is not None  # the state is safe
                allowed += free
                if change or not free:
                    after = code + change
                    target = number.setdefault(after, len(codes))
                    if target == len(codes):
                        codes.append(after)
                        concerned.append(self._touched[label])
                    graph.targets.append(target)
                    graph.labels.append(label + values if free else ~(label + values))
        graph.allowed.append(allowed)

    def _violated(self, state: PlantState, concerned: _Invariants) -> str | None:
        """Return which of some state requirements fails in a state; None if all hold."""
        for holds, index in concerned:
            if not holds(state):
                return f"'{self._plant.robot.requirements[index].text}' fails"
        return None

    def _escaping(self, work: list[_Work]) -> str | None:
        """Return what may take a variable out of its range; None if nothing may."""
        for label, successors, _, _ in work:
            if successors[-1][1] is None:
                event = self._plant.events[self._labelled[label][0]]
                return f"the {event_phrase(event)} may take a variable out of its range"
        return None

    def _refuse(self) -> None:
        """Raise StateSpaceError before the search if the supervisor's sizes exceed the limits."""
        supervisor = self._supervisor
        for number, what, most in (
            (supervisor.controlled_states, "states", self._limit),
            (supervisor.controlled_transitions, "transitions", limits.VERIFIED_TRANSITIONS),
        ):
            if number > most:
                raise StateSpaceError(
                    f"the controlled system has {number} {what}; verification stops at {most}"
                    f" without the symbolic engine; {remedy()}"
                )

    def _stop_at_limit(self, states: int, steps: int = 0) -> None:
        if states > self._limit:
            raise StateSpaceError(f"verification stops at {self._limit} states; there are more")
        if steps > limits.VERIFIED_TRANSITIONS:
            raise StateSpaceError(
                f"verification stops at {limits.VERIFIED_TRANSITIONS} transitions"
            )

    def _keepable(self, graph: CodedGraph, backward: Backward) -> bytearray:
        """Return the supremal safe, controllable and nonblocking set: 1 per state in it, else 0.

        Starting from all but the unsafe states, remove in turn those from which uncontrollable
        events lead out of the set, and those that reach no marked state inside it, or not what must
        remain possible there.
        """
        kept = bytearray(b"\1" * len(graph.codes))
        fresh = list(graph.unsafe)
        while True:
            for state in fresh:
                kept[state] = 0
            while fresh:
                for source, label in backward.steps(fresh.pop()):
                    if kept[source] and 0 <= label < self._controllable_from:
                        kept[source] = 0
                        fresh.append(source)
            fresh = self._blocked(graph, backward, kept, forbidden=True)
            for goal in self._goals:
                fresh += self._missing(goal, graph, backward, kept, forbidden=True)
            fresh = list(dict.fromkeys(fresh))
            if not fresh:
                return kept

    def _blocked(
        self, graph: CodedGraph, backward: Backward, within: bytearray, forbidden: bool
    ) -> list[int]:
        """Return the states ``within`` that reach no marked one through such states.

        With ``forbidden``, steps that the guards forbid count, too, and a command counts only where
        all its outcomes are ``within``.
        """
        reaching = bytearray(len(within))
        marked = self._holding(graph, self._plant.is_marked)
        todo = [number for number, kept in enumerate(within) if kept and marked[number]]
        for number in todo:
            reaching[number] = 1
        _lead(graph, backward, within, within, forbidden, reaching, todo)
        return [n for n in range(len(within)) if within[n] and not reaching[n]]

    def _missing(
        self, goal: _Goal, graph: CodedGraph, backward: Backward, within: bytearray, forbidden: bool
    ) -> list[int]:
        """Return the states ``within`` in which something must be possible, and is not.

        ``forbidden`` is as above.
        """
        there, along, origin = (self._holding(graph, test) for test in goal.tests)
        reaching = bytearray(map(and_, within, there))
        todo = [number for number, here in enumerate(reaching) if here]
        wanted = [n for n, here in enumerate(map(and_, within, origin)) if here and not there[n]]
        along = bytearray(map(and_, within, along))
        _lead(graph, backward, within, along, forbidden, reaching, todo)
        return [number for number in wanted if not reaching[number]]

    def _holding(self, graph: CodedGraph, test: _Test) -> bytearray:
        """Return 1 for each state in which a condition of goals, or of marking, holds; else 0."""
        if not self._held:
            tests = {self._plant.is_marked, *(t for goal in self._goals for t in goal.tests)}
            self._held = {one: bytearray() for one in tests}
            for code in graph.codes:
                state = self._coding.decode(code)
                for one, found in self._held.items():
                    found.append(one(state))
        return self._held[test]

    # --- the properties --------------------------------------------------------------------------

    def _check_safe(self, graph: CodedGraph, reached: Reached) -> Check:
        for state in reached.order:
            if state in graph.unsafe:
                trace = self._trace(graph, reached, state)
                return Check("safe", False, graph.unsafe[state], trace)
            if state in graph.violations:
                label = graph.violations[state]
                event = self._plant.events[self._labelled[label][0]]
                detail = f"the {event_phrase(event)} violates a requirement"
                step = self._step(graph.codes[state], label)
                return Check("safe", False, detail, (*self._trace(graph, reached, state), step))
        return Check("safe", True)

    def _check_nonblocking(self, graph: CodedGraph, backward: Backward, reached: Reached) -> Check:
        blocked = set(self._blocked(graph, backward, reached.among, forbidden=False))
        for state in reached.order if blocked else ():
            if state in blocked:
                detail = "no marked state can be reached any more"
                return Check("nonblocking", False, detail, self._trace(graph, reached, state))
        return Check("nonblocking", True)

    def _check_possible(
        self, goal: _Goal, graph: CodedGraph, backward: Backward, reached: Reached
    ) -> Check:
        name = possible_check(goal.text)
        missing = set(self._missing(goal, graph, backward, reached.among, forbidden=False))
        for state in reached.order if missing else ():
            if state in missing:
                return Check(name, False, MISSING, self._trace(graph, reached, state))
        return Check(name, True)

    def _check_permissive(self, graph: CodedGraph, reached: Reached, keepable: bytearray) -> Check:
        for state in reached.order:
            for target, label in graph.steps(state):
                if label < 0 and keepable[target] and graph.staying(state, label, keepable):
                    event = self._plant.events[self._labelled[~label][0]]
                    detail = f"the {event_phrase(event)} is forbidden unnecessarily"
                    step = self._step(graph.codes[state], ~label)
                    trace = (*self._trace(graph, reached, state), step)
                    return Check("maximally permissive", False, detail, trace)
        return Check("maximally permissive", True)

    def _plant_states(self) -> int | None:
        """Return how many states the plant reaches without requirements; None if too many."""
        if self._supervisor.plant_states > self._limit:
            return None
        changes = grouped(
            self._plant,
            ((event, self._events[event].variables) for event in range(len(self._events))),
            lambda event, state: [c for _, c in self._events[event].successors(state) if c] or None,
        )
        todo = [self._coding.encode(state) for state in self._plant.initial_states]
        seen = set(todo)
        while todo:
            code = todo.pop()
            for changed in changes(self._coding.decode(code)):
                for change in changed:
                    if code + change not in seen:
                        seen.add(code + change)
                        todo.append(code + change)
            self._stop_at_limit(len(seen))
        return len(seen)

    # --- traces ----------------------------------------------------------------------------------

    def _trace(self, graph: CodedGraph, reached: Reached, state: int) -> tuple[Step, ...]:
        """Return a shortest trace from an initial state."""
        steps = []
        while (source := reached.parents[state]) != state:
            label = next(n for target, n in graph.steps(source) if target == state and n >= 0)
            steps.append(self._step(graph.codes[source], label))
            state = source
        return tuple(reversed(steps))

    def _step(self, code: int, label: int) -> Step:
        index, values = self._labelled[label]
        event = self._plant.events[index]
        if not event.kind.of_component:
            return Step(event, self._events[index].valuations[values])
        variable = self._plant.variable_index[VariableKind.LOCATION, event.key]
        before = self._coding.decode(code)
        change = dict(self._events[index].successors(before))[values] or 0
        after = self._coding.decode(code + change)
        names = self._plant.variables[variable].values
        return Step(event, (path_of(f"{names[before[variable]]}->{names[after[variable]]}"),))
