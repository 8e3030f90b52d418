"""Which cases no run can show, because the plant under its supervisor excludes them.

Looked at is each state that is reached, as far as the plant knows it: its locations, phases and
finite variables. What depends on numbers or on data may come out in any way. So what is possible
here need not be possible on the robot, but what is not possible here is nowhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from robosc.errors import StateSpaceError
from robosc.plant.automaton import Plant, PlantState, VariableKind
from robosc.runtime.core.values import Undefined
from robosc.synthesis.explore import explore
from robosc.traces.coverage import Case, Coverage, JudgedEdge
from robosc.traces.deciding_atoms import DecidedCondition, Outcome, possible_values
from robosc.traces.exact_steps import UNKNOWN, ExactStep, Function, State

STATES = 10000
"""So many states are looked at; of a larger system nothing is proved."""
_KNOWN = (VariableKind.LOCATION, VariableKind.ASSUMPTION, VariableKind.PHASE)


def unreachable(coverage: Coverage) -> frozenset[Case]:
    """The cases of which it is proved that no run shows them. A monitor's robot is under no
    supervisor, so there it proves nothing."""
    steps = coverage.steps
    if steps.follows:
        return frozenset()
    try:
        states = explore(steps.supervisor, STATES).states
    except StateSpaceError:
        return frozenset()
    found: set[Case] = set()
    for state in {tuple(_known(steps.plant, state).items()) for state in states}:
        found.update(_PossibleCases(coverage, dict(state)).all())
    return frozenset(coverage.cases.keys() - found)


def _known(plant: Plant, state: PlantState) -> State:
    """What a state of the plant tells for certain."""
    found: State = {}
    for variable, index in zip(plant.variables, state, strict=True):
        if variable.kind in _KNOWN:
            phase = "~" if variable.kind is VariableKind.PHASE else ""
            found[phase + variable.name] = str(variable.values[index])
        elif isinstance(variable.values, tuple | range):
            found[variable.name] = variable.values[index]
    return found


class _PossibleCases:
    """The cases that may show in a state."""

    def __init__(self, coverage: Coverage, state: State) -> None:
        self._coverage, self._state = coverage, state

    def all(self) -> Iterator[Case]:
        for step in self._coverage.steps.steps:
            if not step.in_phase(self._state):
                continue
            may_happen = True
            if step.number in self._coverage.rules_by_number:
                yield from self._of_command(step)
                may_happen = step.guard is None or True in possible_values(step.guard, self._state)
            elif not step.event.controllable:
                yield "event", step.number, "" if step.phase is None else self._state[step.phase]
            for partner in step.partners if may_happen else ():
                place = step.number, partner.component
                edges = self._coverage.edges_at(step, partner, self._state)
                yield from self._of_edges(place, edges)

    def _of_command(self, step: ExactStep) -> Iterator[Case]:
        rule = self._coverage.rules_by_number[step.number]
        if step.replaces(self._state):
            yield from (("replaced", step.number, value) for value in (True, False))
        demands = [self._possible(demand.condition) for demand in rule.demands]
        open_partners = []
        for partner in step.partners:
            edges = self._coverage.edges_at(step, partner, self._state)
            may = [True in self._values(judged) for judged in edges]
            must = [self._values(judged) == {True} for judged in edges]
            if partner.blocking and not any(must):
                yield "blocked", step.number, partner.component
            open_partners.append(any(may) or not partner.blocking)
        if not all(open_partners):
            return
        for index, demand in enumerate(demands):
            others = [other for n, other in enumerate(demands) if n != index]
            if all(True in other for other in others):
                for outcomes in demand.values():
                    yield from (("demand", step.number, index, *one) for one in outcomes)
        if not all(True in demand for demand in demands):
            return
        for other in rule.preferred:
            if other.in_phase(self._state):
                yield "yields", step.number, other.number
        yield "sent", step.number
        for index, condition in enumerate(self._coverage.provided_if(step)):
            found = {True: frozenset[Outcome]()} if condition is None else self._possible(condition)
            for outcomes in found.values():
                yield from (("provide", step.number, index, *one) for one in outcomes)
            if True in found:
                yield "provided", step.number, index
            if False not in found:
                break

    def _of_edges(self, place: tuple[int, str], edges: Any) -> Iterator[Case]:
        for judged in edges:
            case = (*place, *judged.edge.name)
            values = {True: frozenset[Outcome]()}
            if judged.guard is not None:
                values = self._possible(judged.guard)
            for outcomes in values.values():
                yield from (("edge", *case, *one) for one in outcomes)
            if True in values:
                yield "taken", *case
                for key, value, *_ in judged.edge.assigned:
                    if self._may_change(key, value):
                        yield "assigned", *case, key
                for key, condition in judged.made.items():
                    for outcomes in self._possible(condition).values():
                        yield from (("made", *case, key, *one) for one in outcomes)
            if False not in values:
                break

    def _may_change(self, key: str, value: Function) -> bool:
        try:
            return bool(value(self._state, UNKNOWN) != self._state[key])
        except (Undefined, KeyError):
            return True

    def _values(self, judged: JudgedEdge) -> set[bool]:
        return {True} if judged.guard is None else set(self._possible(judged.guard))

    def _possible(self, condition: DecidedCondition) -> dict[bool, frozenset[Outcome]]:
        return condition.possible(self._state)
