"""Internal transitions of a controller under its supervisor, and which of them commute.

Two internal transitions are independent if neither writes what the other one reads or writes. What
depends on one another is a *group*; groups do not touch each other. In a group whose transitions
are never possible together, or independent where they are, each order that ends ends in the same
state and after as many transitions: every two that are possible lead to a common state, one step
after each (Newman, "On theories with a combinatorial definition of equivalence", Annals of
Mathematics 43, 1942).

If that is so in all groups, and all orders end, then where a controller comes to rest is the same
with inputs that come while some transitions are still possible, as long as these belong to groups
that the input does not touch: they can be taken before it as well. Such inputs read little, whereas
being at rest reads what all internal transitions read.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import combinations

from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import Disjunct, EventRelation
from robosc.synthesis.bdd.symbolic_engine import SymbolicSolution


@dataclass(frozen=True, eq=False, slots=True)
class TauMove:
    """A disjunct of an internal transition, and the controlled states in which it is taken."""

    disjunct: Disjunct
    before: Bdd


@dataclass(frozen=True, eq=False, slots=True)
class TauRelation:
    """An internal transition that may be taken. ``possible`` is where it is in the plant, reached
    or not; ``before`` where it is taken."""

    event: EventRelation
    moves: tuple[TauMove, ...]
    possible: Bdd
    before: Bdd


@dataclass(frozen=True, eq=False, slots=True)
class TauGroup:
    """Internal transitions that depend on one another, and the variables that they touch."""

    taus: tuple[TauRelation, ...]
    touches: frozenset[int]
    writes: frozenset[int]
    commute: bool

    def concerns(self, event: EventRelation) -> bool:
        """Whether a transition of the group and an event are not independent."""
        return not (
            self.touches.isdisjoint(event.writes) and self.writes.isdisjoint(event.variables)
        )


class TauGroups:
    """All internal transitions that a supervisor allows in some state, in source order."""

    def __init__(self, solution: SymbolicSolution) -> None:
        self._solution = solution
        self._manager = solution.engine.manager
        events = solution.engine.plant.events
        found = [
            self._tau(event)
            for event in solution.engine.events
            if events[event.number].kind is EventKind.TAU
        ]
        self.all = [tau for tau in found if tau.moves]
        self.moving = self._manager.union(tau.before for tau in self.all)
        self._groups = list(self._grouped())

    def _tau(self, event: EventRelation) -> TauRelation:
        exists = self._manager.exists
        disjuncts = self._solution.engine.permitted[event.number]
        # The controller does not take what changes nothing.
        changing = [d for d in disjuncts if not d.stays]
        places = [exists(d.relation, d.after) for d in changing]
        enabled = self._solution.enabled(event) if changing else self._manager.false
        each = (TauMove(d, p & enabled) for d, p in zip(changing, places, strict=True))
        moves = tuple(move for move in each if move.before != self._manager.false)
        union = self._manager.union
        return TauRelation(event, moves, union(places), union(move.before for move in moves))

    # --- what commutes

    @property
    def commute(self) -> bool:
        """Whether the order in which they are taken makes no difference in any controlled state."""
        return all(group.commute for group in self._groups)

    def undecided(self) -> frozenset[int]:
        """Return the variables whose last value may depend on the order."""
        return frozenset().union(*(group.writes for group in self._groups if not group.commute))

    def concerned(self, event: EventRelation) -> Bdd:
        """Return where one that an event touches is possible, or one that such a one depends on."""
        return self._manager.union(
            tau.possible for group in self._groups if group.concerns(event) for tau in group.taus
        )

    def _grouped(self) -> Iterator[TauGroup]:
        groups: list[tuple[list[TauRelation], set[int], set[int]]] = []
        for tau in self.all:
            together, touches, writes = [tau], set(tau.event.variables), set(tau.event.writes)
            apart = []
            for group in groups:
                if touches.isdisjoint(group[2]) and writes.isdisjoint(group[1]):
                    apart.append(group)
                else:
                    together = group[0] + together
                    touches |= group[1]
                    writes |= group[2]
            groups = [*apart, (together, touches, writes)]
        decided = all(map(self._is_decided, self.all))
        for taus, touches, writes in groups:
            commute = decided and self._is_confluent(taus)
            yield TauGroup(tuple(taus), frozenset(touches), frozenset(writes), commute)

    def _is_decided(self, tau: TauRelation) -> bool:
        """Whether it leads to one state from each, and the supervisor leaves it alone."""
        plant = self._solution.engine.plant
        allowed = tau.possible & self._solution.states
        return not plant.events[tau.event.number].branches and allowed == tau.before

    def _is_confluent(self, taus: Sequence[TauRelation]) -> bool:
        false = self._manager.false
        return all(
            a.event.writes.isdisjoint(b.event.variables)
            and b.event.writes.isdisjoint(a.event.variables)
            for a, b in _sharing(taus)
            if a.before & b.before != false
        )


def _sharing(taus: Sequence[TauRelation]) -> Iterator[tuple[TauRelation, TauRelation]]:
    """Yield the pairs that touch a variable in common; some several times."""
    by_variable: dict[int, list[TauRelation]] = defaultdict(list)
    for tau in taus:
        for variable in tau.event.variables:
            by_variable[variable].append(tau)
    for several in by_variable.values():
        yield from combinations(several, 2)
