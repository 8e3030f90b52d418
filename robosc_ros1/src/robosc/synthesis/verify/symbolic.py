"""Symbolic verification of systems with too many states for explicit search.

It proves the same as :mod:`robosc.synthesis.verify.explicit`, by sets of states. With the symbolic
engine it shares the BDD manager: the transition relations are independent
(:mod:`robosc.synthesis.verify.state_sets`), and the fixpoints are plain rounds over all events.
"""

from __future__ import annotations

from collections.abc import Sequence

from robosc.errors import StateSpaceError
from robosc.expr.tree import FALSE, TRUE
from robosc.plant.automaton import Plant
from robosc.supervisor import Supervisor
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.verify.findings import Check, Findings, event_phrase
from robosc.synthesis.verify.state_sets import Relation, StateSets


def search_by_sets(supervisor: Supervisor) -> Findings:
    """Return what the search finds, without traces.

    Raises:
        StateSpaceError: an event or a condition reads too much, or the diagrams grow too large.
    """
    try:
        return _Proof(supervisor).found()
    except MemoryError:
        raise StateSpaceError("verification ran out of the memory that it may use") from None


class _Proof:
    def __init__(self, supervisor: Supervisor) -> None:
        self.plant: Plant = supervisor.plant
        self.sets = StateSets(self.plant)
        self.manager, self.relations = self.sets.manager, self.sets.relations
        self.false = self.manager.false
        guards = {g.event.identity: g.expr for g in supervisor.guards}
        self.required: dict[int, Bdd] = {}
        self.guards: dict[int, Bdd] = {}
        for number, event in enumerate(self.plant.events):
            free = FALSE if event.controllable else TRUE
            guard = guards.get(event.identity, free)
            self.guards[number] = self.sets.holds(guard)
            self.required[number] = self.sets.holds(event.requirement or TRUE)

    def found(self) -> Findings:
        manager = self.manager
        initial = self.sets.initial
        failing = [~self.sets.holds(expr) for expr, _ in self.plant.invariants]
        escaping = [r.escapes for r in self.relations]
        unsafe = manager.union([*failing, *escaping])
        everything = [manager.true] * len(self.relations)
        plant = self._forward(initial, everything, manager.true)
        permitted = self._forward(initial, list(self.required.values()), ~unsafe)
        keepable = self._keepable(permitted & ~unsafe)
        reached = self._forward(initial, list(self.guards.values()), ~unsafe)
        return Findings(
            method="symbolic",
            keeps_initial=initial & ~keepable == self.false,
            safe=_check("safe", self._unsafe(reached, unsafe)),
            nonblocking=_check("nonblocking", self._blocking(reached)),
            permissive=_check("maximally permissive", self._needless(reached, keepable)),
            states=self.sets.count(reached),
            transitions=self._transitions(reached),
            plant_states=self.sets.count(plant),
        )

    # --- properties

    def _unsafe(self, reached: Bdd, unsafe: Bdd) -> str | None:
        if reached & unsafe != self.false:
            for expr, index in self.plant.invariants:
                if reached & ~self.sets.holds(expr) != self.false:
                    return f"'{self.plant.robot.requirements[index].text}' fails"
            leaving = next(r for r in self.relations if reached & r.escapes != self.false)
            return f"the {event_phrase(leaving.event)} may take a variable out of its range"
        for number, relation in enumerate(self.relations):
            taken = reached & relation.possible & self.guards[number]
            if taken & ~self.required[number] != self.false:
                return f"the {event_phrase(relation.event)} violates a requirement"
        return None

    def _blocking(self, reached: Bdd) -> str | None:
        back = self._coreachable(reached, list(self.guards.values()))
        return None if back == reached else "no marked state can be reached any more"

    def _needless(self, reached: Bdd, keepable: Bdd) -> str | None:
        for number, relation in enumerate(self.relations):
            forbidden = reached & relation.possible & self.required[number] & ~self.guards[number]
            if forbidden & self._staying(relation, keepable) != self.false:
                return f"the {event_phrase(relation.event)} is forbidden unnecessarily"
        return None

    def _transitions(self, reached: Bdd) -> int:
        return sum(
            weight * self.sets.count(reached & states & self.guards[number])
            for number, relation in enumerate(self.relations)
            for weight, states in relation.weights
        )

    # --- fixpoints

    def _image(self, relation: Relation, states: Bdd) -> Bdd:
        found = self.manager.and_exists(states, relation.steps, relation.now)
        return self.manager.rename(found, relation.forward)

    def _preimage(self, relation: Relation, states: Bdd) -> Bdd:
        renamed = self.manager.rename(states, relation.backward)
        return self.manager.and_exists(renamed, relation.steps, relation.after)

    def _staying(self, relation: Relation, within: Bdd) -> Bdd:
        """Return where an event is possible and all its outcomes are ``within``."""
        return relation.possible & ~self._preimage(relation, ~within)

    def _forward(self, states: Bdd, where: Sequence[Bdd], left: Bdd) -> Bdd:
        """Return what events reach where they are allowed; states outside ``left`` are not left."""
        while True:
            before = states
            for relation, allowed in zip(self.relations, where, strict=True):
                self.manager.make_room()
                states = states | self._image(relation, states & allowed & left)
            if states == before:
                return states

    def _coreachable(self, within: Bdd, where: Sequence[Bdd]) -> Bdd:
        """Return the states ``within`` from which a marked one is reached inside ``within``."""
        found = within & self.sets.marked
        while True:
            before = found
            for relation, allowed in zip(self.relations, where, strict=True):
                self.manager.make_room()
                found = found | (self._preimage(relation, found) & allowed & within)
            if found == before:
                return found

    def _keepable(self, safe: Bdd) -> Bdd:
        """Return the supremal controllable and nonblocking subset of the safe states."""
        kept = safe
        while True:
            before = kept
            for relation in self.relations:
                if not relation.event.controllable:
                    self.manager.make_room()
                    kept = kept & ~self._preimage(relation, ~kept)
            if kept != before:
                continue
            where = [
                self.required[number] & self._staying(relation, kept)
                for number, relation in enumerate(self.relations)
            ]
            kept = self._coreachable(kept, where)
            if kept == before:
                return kept


def _check(name: str, failure: str | None) -> Check:
    return Check(name, failure is None, failure)
