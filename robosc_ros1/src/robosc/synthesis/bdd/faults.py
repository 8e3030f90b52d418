"""Bad states of a symbolic solution, ring by ring (:mod:`robosc.synthesis.faults`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from robosc.plant.automaton import PlantState
from robosc.plant.step import Verdict
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import Disjunct
from robosc.synthesis.bdd.saturation import saturated
from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.faults import Fault, Faults, Round
from robosc.synthesis.time_limit import ExplanationTime, TimeIsUp


class SymbolicFaults:
    """A :class:`~robosc.synthesis.faults.FaultSearch` by sets of states."""

    def __init__(self, solution: SymbolicSolution, time: ExplanationTime) -> None:
        self._solution = solution
        self._engine = solution.engine
        self._encoding = solution.engine.encoding
        self._manager = solution.engine.manager
        self._avoided = solution.explored & ~solution.good
        self._time = time
        self._stepper = Stepper(solution.engine.plant)
        self._faulty: dict[Fault, Bdd] = {}
        self._rings: dict[tuple[Faults | Round, bool], list[Bdd]] = {}

    def has(self, state: PlantState, fault: Fault) -> bool:
        return self._encoding.contains(self._with(fault), state)

    def round_of(self, state: PlantState) -> int | None:
        rounds = enumerate(self._solution.rounds)
        return next(
            (n for n, (_, left) in rounds if not self._encoding.contains(left, state)), None
        )

    def way(
        self, start: PlantState, to: Faults | Round, forced: bool
    ) -> tuple[PlantState, ...] | None:
        distance = self._distance(start, to, forced)
        if distance is None:
            return None
        rings = self._rings[to, forced]
        path = [start]
        while distance:
            distance -= 1
            after = self._successors(path[-1], forced)
            near = (s for s in after if self._encoding.contains(rings[distance], s))
            following = next(near, None)
            if following is None:
                return None  # by values that are not among those that are tried
            path.append(following)
        return tuple(path)

    def values_beyond(self, state: PlantState) -> Sequence[frozenset[int]]:
        start = self._encoding.state(state)
        reached = self._closed(start, self._with("blocked"), self._engine.relations.image)
        encoding, false = self._encoding, self._manager.false
        return [
            frozenset(i for i in range(v.size) if reached & encoding.value(n, i) != false)
            for n, v in enumerate(self._engine.plant.variables)
        ]

    def _distance(self, state: PlantState, to: Faults | Round, forced: bool) -> int | None:
        """Return in which ring a state is; rings are computed as far as they are asked for."""
        rings = self._rings.setdefault((to, forced), [])
        for number, ring in enumerate(rings):
            if self._encoding.contains(ring, state):
                return number
        if not rings:
            rings.append(self._at(to))
        while rings[-1] != self._manager.false:
            if self._encoding.contains(rings[-1], state):
                return len(rings) - 1
            rings.append(self._next(rings, forced))
        return None

    def _at(self, to: Faults | Round) -> Bdd:
        if not isinstance(to, Round):
            return self._manager.union(map(self._with, to))
        if to.part == "lost":
            return self._solution.rounds[to.number][0]
        if to.number == 0:
            return self._manager.false
        return self._avoided & ~self._solution.rounds[to.number - 1][1]

    def _next(self, rings: Sequence[Bdd], forced: bool) -> Bdd:
        """Return the states that are one step further away."""
        new = self._before(rings[-1], forced) & self._avoided
        for ring in rings:
            new = new & ~ring
        return new

    def _before(self, states: Bdd, forced: bool) -> Bdd:
        """Return the preimage under all events, with ``forced`` the uncontrollable ones."""
        engine, manager = self._engine, self._manager
        manager.make_room()
        found = []
        for event, disjuncts in zip(engine.events, engine.required_disjuncts, strict=True):
            self._time.check()
            if not (forced and engine.plant.events[event.number].controllable):
                found += [
                    manager.run(lambda d=one: engine.relations.preimage(d, states))  # type: ignore[misc]
                    for one in disjuncts
                    if not one.stays
                ]
        return manager.union(found)

    def _successors(self, state: PlantState, forced: bool) -> Iterator[PlantState]:
        for event in self._stepper.required():
            if forced and self._engine.plant.events[event.number].controllable:
                continue
            if event.test is None or event.test(state):
                for values in event.some_values:
                    target = event.step(state, values)
                    if not isinstance(target, Verdict):
                        yield target

    def _with(self, fault: Fault) -> Bdd:
        """Return the states with a fault among those to be avoided."""
        if fault not in self._faulty:
            self._faulty[fault] = self._avoided & self._wrong(fault)
        return self._faulty[fault]

    def _wrong(self, fault: Fault) -> Bdd:
        engine, encoding = self._engine, self._encoding
        reach, good = self._solution.explored, self._solution.good
        match fault:
            case "requirement":
                found = [~encoding.holds(expr) for expr, _ in engine.plant.invariants]
                return self._manager.union(self._avoided & failing for failing in found)
            case "range":
                return engine.leaving_range()
            case "blocked":
                marked = good | (encoding.marked & reach)
                return ~self._closed(marked, reach, engine.relations.preimage)
        conditions = engine.plant.goals[fault].conditions
        there, along, origin = (encoding.holds(expr) & reach for expr in conditions)
        return origin & ~self._closed(there, along | there, engine.relations.preimage)

    def _closed(self, states: Bdd, within: Bdd, step: Callable[[Disjunct, Bdd], Bdd]) -> Bdd:
        def report(part: Bdd, level: int) -> None:
            self._time.check()

        try:
            disjuncts = self._engine.required_disjuncts
            return saturated(self._manager, states, within, disjuncts, step, report)
        except MemoryError:
            raise TimeIsUp from None
