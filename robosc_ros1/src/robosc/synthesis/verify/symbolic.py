"""Symbolic verification of systems with too many states for explicit search.

It proves the same as :mod:`robosc.synthesis.verify.explicit`, by sets of states. With the symbolic
engine it shares the BDD manager and the order of the variables; the transition relations
(:mod:`robosc.synthesis.verify.state_sets`) and the fixpoints
(:mod:`robosc.synthesis.verify.closures`) are independent.

What may be kept is computed first, and what is reached inside it. Where the guards allow there what
stays inside, and nothing else, they are right. Only where they do not, what they lead to is
computed as well: their conditions read many variables, the plant's events few.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from itertools import islice
from typing import Final, TypeAlias, TypeVar

from robosc.errors import StateSpaceError
from robosc.expr.tree import FALSE, TRUE
from robosc.plant.automaton import Plant, PlantGoal
from robosc.progress import Progress
from robosc.supervisor import Supervisor
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.verify.closures import Closure, place_of
from robosc.synthesis.verify.state_sets import Assigned, Relation, StateSets
from robosc.synthesis.verify.verify_report import (
    MISSING,
    Check,
    Findings,
    event_phrase,
    possible_check,
)

_SECONDS: Final = 0.05
"""Between two reports of progress."""

_MANY_NODES: Final = 2**18
"""In use in a first try: one direction of the order of variables may take a hundred times the nodes
of the other, and no rule known tells which. That in which synthesis ended comes first."""
_SHARE: Final = 5
"""One group of variables may take this part of the values that are looked at."""
_Result = TypeVar("_Result")
_Take: TypeAlias = Callable[[Relation, Bdd, Bdd], Bdd]
"""From a relation, those of its steps that count, and a set: what they lead to, or come from."""


def search_by_sets(
    supervisor: Supervisor, progress: Progress | None = None, turn: int | None = None
) -> Findings:
    """Return what the search finds, without traces.

    Raises:
        ManyNodes: it takes more than ``turn`` nodes, garbage included.
        StateSpaceError: an event or a condition reads too much, or the diagrams grow too large.
    """
    if turn is not None:
        return _Proof(supervisor, progress, supervisor.opposite_order, turn, turn).found()
    return _proved(supervisor, progress, _Proof.found)


def plant_states(supervisor: Supervisor, progress: Progress | None = None) -> int:
    """Return how many states the plant reaches without requirements; raises the same."""
    return _proved(supervisor, progress, _Proof.plant_states)


def reached_values(
    supervisor: Supervisor, groups: Sequence[frozenset[int]], most: int
) -> list[list[Assigned] | None]:
    """Return, for each group of state variables, the values that they have together in some state
    under the supervisor; None for groups with many, so that ``most`` are looked at in all.

    The states are those that a correct supervisor allows: its guards, which read many variables,
    are not asked.

    Raises:
        StateSpaceError: an event or a condition reads too much, or the diagrams grow large.
    """
    found: dict[int, list[Assigned] | None] = {}
    left, share = most, most // _SHARE
    try:
        proof = _Proof(supervisor, None, supervisor.opposite_order, _MANY_NODES)
        _, reached = proof.kept_and_reached()
        for number in sorted(range(len(groups)), key=lambda number: len(groups[number])):
            limit = min(left, share)
            values = list(islice(proof.sets.values(reached, groups[number]), limit + 1))
            left -= min(len(values), limit)
            found[number] = values if len(values) <= limit else None
    except (ManyNodes, MemoryError):
        raise StateSpaceError("the sets of states are too large to look at their values") from None
    return [found[number] for number in range(len(groups))]


def _proved(
    supervisor: Supervisor, progress: Progress | None, what: Callable[[_Proof], _Result]
) -> _Result:
    first = supervisor.opposite_order
    directions, most = [first, not first], _MANY_NODES
    while directions:
        for reverse in tuple(directions):
            try:
                return what(_Proof(supervisor, progress, reverse, most))
            except ManyNodes:
                pass
            except MemoryError:
                directions.remove(reverse)
        most *= 8
    raise StateSpaceError("verification ran out of the memory that it may use")


class ManyNodes(Exception):
    """The other direction of the order of variables may need fewer."""


class _Proof:
    def __init__(
        self,
        supervisor: Supervisor,
        progress: Progress | None,
        reverse: bool,
        most_nodes: int,
        turn: float = math.inf,
    ) -> None:
        self._supervisor, self._most_nodes, self._turn = supervisor, most_nodes, turn
        self.plant: Plant = supervisor.plant
        gc.collect()  # frees diagrams, also those of synthesis, before there are others
        self.sets = StateSets(self.plant, reverse)
        self.manager, self.relations = self.sets.manager, self.sets.relations
        self.false = self.manager.false
        self._progress = progress
        self._again = 0.0

    @cached_property
    def guards(self) -> Mapping[int, Bdd]:
        """Where the guard of each event holds."""
        guards = {guard.event.identity: guard.expr for guard in self._supervisor.guards}
        free = {
            event.identity: FALSE if event.controllable else TRUE for event in self.plant.events
        }
        every = free | guards
        return {n: self.sets.holds(every[e.identity]) for n, e in enumerate(self.plant.events)}

    @cached_property
    def required(self) -> Mapping[int, Bdd]:
        """Where the requirement of each event holds."""
        events = enumerate(self.plant.events)
        return {n: self.sets.holds(event.requirement or TRUE) for n, event in events}

    @cached_property
    def unsafe(self) -> Bdd:
        failing = [~self.sets.holds(expr) for expr, _ in self.plant.invariants]
        return self.manager.union([*failing, *(r.escapes for r in self.relations)])

    def tick(self, part: Bdd, place: int) -> None:
        if self.manager.in_use > self._most_nodes or self.manager.nodes > self._turn:
            raise ManyNodes
        if self._progress is not None and (now := time.monotonic()) >= self._again:
            self._again = now + _SECONDS
            self._progress("verification", self.sets.count_from(place, part), self.sets.most)

    def kept_and_reached(self) -> tuple[Bdd, Bdd]:
        """Return what may be kept, and what is reached inside it."""
        initial = self.sets.initial
        permitted = self._allowed(self.required)
        safe = self._closed(initial, ~self.unsafe, permitted, self._image)
        kept = self._keepable(safe)
        keeping = self._keeping(kept)
        reached = safe  # where nothing had to be removed
        if kept != safe or keeping != permitted:
            reached = self._closed(initial, kept, keeping, self._image)
        return kept, reached

    def found(self) -> Findings:
        initial, sets = self.sets.initial, self.sets
        kept, reached = self.kept_and_reached()
        right = initial & ~kept == self.false and self._right(reached, kept)
        if not right:
            reached = self._under_guards()
        return Findings(
            method="symbolic",
            keeps_initial=initial & ~kept == self.false,
            safe=_check("safe", None if right else self._unsafe(reached)),
            nonblocking=_check("nonblocking", None if right else self._blocking(reached)),
            possible=tuple(
                _check(
                    possible_check(self.plant.robot.goals[goal.index].text),
                    None if right else self._lacking(goal, reached),
                )
                for goal in self.plant.goals
            ),
            permissive=_check(
                "maximally permissive", None if right else self._needless(reached, kept)
            ),
            states=sets.count(reached),
            transitions=self._transitions(reached),
            plant_states=self.plant_states(),
        )

    def plant_states(self) -> int:
        steps = [relation.steps for relation in self.relations]
        return self.sets.count(
            self._closed(self.sets.initial, self.manager.true, steps, self._image)
        )

    # --- properties

    def _right(self, reached: Bdd, kept: Bdd) -> bool:
        """Whether the guards allow in ``reached`` what stays in ``kept``, and nothing else."""
        for number, relation in enumerate(self.relations):
            here, guard = reached & relation.possible, self.guards[number]
            wanted = self.required[number]
            if relation.event.controllable:
                wanted = wanted & self._staying(relation, kept)
            if here & (guard ^ wanted) != self.false:
                return False
        return True

    def _unsafe(self, reached: Bdd) -> str | None:
        if reached & self.unsafe != self.false:
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
        steps = self._allowed(self.guards)
        back = self._closed(reached & self.sets.marked, reached, steps, self._preimage)
        return None if back == reached else "no marked state can be reached any more"

    def _lacking(self, goal: PlantGoal, reached: Bdd) -> str | None:
        missing = self._missing(goal, reached, self._allowed(self.guards))
        return None if missing == self.false else MISSING

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

    # --- steps

    def _image(self, relation: Relation, steps: Bdd, states: Bdd) -> Bdd:
        found = self.manager.and_exists(states, steps, relation.now)
        return self.manager.rename(found, relation.forward)

    def _preimage(self, relation: Relation, steps: Bdd, states: Bdd) -> Bdd:
        renamed = self.manager.rename(states, relation.backward)
        return self.manager.and_exists(renamed, steps, relation.after)

    def _staying(self, relation: Relation, within: Bdd) -> Bdd:
        """Return where an event is possible and all its outcomes are ``within``."""
        return relation.possible & ~self._preimage(relation, relation.steps, ~within)

    def _allowed(self, where: Mapping[int, Bdd]) -> list[Bdd]:
        """Return the steps of each event, where it is allowed."""
        return [relation.steps & where[n] for n, relation in enumerate(self.relations)]

    def _keeping(self, kept: Bdd) -> list[Bdd]:
        """Return the permitted steps of each event; of a command with values only those that stay
        in ``kept`` whatever its outcome."""
        where = dict(self.required)
        for number, relation in enumerate(self.relations):
            if relation.event.controllable and relation.event.parameters:
                where[number] = where[number] & self._staying(relation, kept)
        return self._allowed(where)

    # --- fixpoints

    def _closed(self, states: Bdd, inside: Bdd, steps: Sequence[Bdd], take: _Take) -> Bdd:
        """Return ``states`` and what is reached from them, without leaving ``inside``."""
        arrows = [
            (
                min(map(place_of, (some, relation.now, relation.after))),
                partial(take, relation, some),
            )
            for relation, some in zip(self.relations, steps, strict=True)
            if some != self.false
        ]
        return Closure(self.manager, arrows, self.tick).of(states & inside, inside)

    def _under_guards(self) -> Bdd:
        """Return what is reached under the guards; unsafe states are not left."""
        left = {number: guard & ~self.unsafe for number, guard in self.guards.items()}
        everywhere = self.manager.true
        return self._closed(self.sets.initial, everywhere, self._allowed(left), self._image)

    def _keepable(self, kept: Bdd) -> Bdd:
        """Return the supremal safe, controllable and nonblocking set of those that are permitted.

        ``kept`` are those that are reached over safe ones.

        In turn those states are removed from which uncontrollable events lead out of the set, and
        those that reach no marked state inside it.
        """
        uncontrollable = [
            self.false if relation.event.controllable else relation.steps
            for relation in self.relations
        ]
        lost = self.manager.union(
            self._preimage(relation, steps, self.unsafe)
            for relation, steps in zip(self.relations, uncontrollable, strict=True)
        )
        while True:
            kept = kept & ~self._closed(lost, kept, uncontrollable, self._preimage)
            marked = kept & self.sets.marked
            keeping = self._keeping(kept)
            lost = kept & ~self._closed(marked, kept, keeping, self._preimage)
            if lost == self.false:
                lost = self.manager.union(
                    self._missing(goal, kept, keeping)
                    for goal in self.plant.goals
                    if not self._comes_with(goal, marked, kept)
                )
            if lost == self.false:
                return kept

    def _comes_with(self, goal: PlantGoal, marked: Bdd, within: Bdd) -> bool:
        """Whether a goal is reached wherever a marked state is: all of these are in it."""
        there, along, _ = (self.sets.holds(expr) for expr in goal.conditions)
        return (marked & ~there) | (within & ~along) == self.false

    def _missing(self, goal: PlantGoal, within: Bdd, steps: Sequence[Bdd]) -> Bdd:
        """Return the states ``within`` in which something must be possible, and is not."""
        there, along, origin = (self.sets.holds(expr) & within for expr in goal.conditions)
        return origin & ~self._closed(there, there | along, steps, self._preimage)


def _check(name: str, failure: str | None) -> Check:
    return Check(name, failure is None, failure)
