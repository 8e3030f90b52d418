"""The events that a path to a state most likely needs: those of a relaxed plan.

In the relaxed system a state variable keeps every value that it had (Hoffmann & Nebel, "The FF
planning system", JAIR 14, 2001): whether a value can be taken is found in a few rounds over all
events, with sets of values instead of sets of states. The events that lead to the values of a
wanted state there, and to what these need in turn, often suffice in the system itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TypeAlias

from robosc.synthesis.bdd.manager import Bdd
from robosc.synthesis.bdd.relations import Disjunct
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine

_Fact: TypeAlias = tuple[int, int]
"""A state variable and the index of one of its values."""

Moves: TypeAlias = Mapping[int, tuple[Sequence[Disjunct], frozenset[int]]]
"""The disjuncts of each event, by its number, and the state variables that they touch."""


class Relaxation:
    """The relaxed system of some events."""

    def __init__(self, engine: SymbolicEngine, moves: Moves) -> None:
        self._engine = engine
        self._encoding = engine.encoding
        self._false = engine.manager.false
        self._moves = moves
        self._variables = range(len(engine.plant.variables))

    def events(self, wanted: Bdd) -> frozenset[int]:
        """Return the numbers of events that lead to a wanted state; one of them is reachable."""
        found: set[int] = set()
        facts = self._choose(wanted, self._first_round(wanted), self._variables)
        for variable, index in facts:  # appended to below
            rank, number, disjunct = self._achievers[variable, index]
            found.add(number)
            touched = self._moves[number][1]
            before = self._engine.relations.preimage(
                disjunct, self._encoding.value(variable, index)
            )
            for fact in self._choose(before, rank - 1, sorted(touched)):
                if fact not in facts:
                    facts.append(fact)
        return frozenset(found)

    def _choose(self, states: Bdd, rank: int, variables: Sequence[int]) -> list[_Fact]:
        """Return what holds in a state that can be reached within some rounds, but not initially.

        Each variable has the value that is reached first, the initial one if it can.
        """
        states = states & self._box(rank, variables)
        facts = []
        for variable in variables:
            for index, when in self._ranks[variable].items():
                here = states & self._encoding.value(variable, index)
                if when <= rank and here != self._false:
                    states = here
                    if when:
                        facts.append((variable, index))
                    break
        return facts

    def _first_round(self, wanted: Bdd) -> int:
        """Return after how many rounds a wanted state can be reached."""
        low, high = 0, max(rank for ranks in self._ranks.values() for rank in ranks.values())
        while low < high:
            middle = (low + high) // 2
            if self._box(middle, self._variables) & wanted != self._false:
                high = middle
            else:
                low = middle + 1
        return low

    def _box(self, rank: int, variables: Sequence[int]) -> Bdd:
        """Return where some state variables have values that are reached within some rounds."""
        return self._encoding.box(
            {
                variable: [i for i, when in self._ranks[variable].items() if when <= rank]
                for variable in variables
            }
        )

    @property
    def _ranks(self) -> dict[int, dict[int, int]]:
        """By state variable, the rounds that reach its values, by index and in this order."""
        return self._reached[0]

    @property
    def _achievers(self) -> dict[_Fact, tuple[int, int, Disjunct]]:
        """By value, the round in which it is first reached, the event and its disjunct."""
        return self._reached[1]

    @cached_property
    def _reached(
        self,
    ) -> tuple[dict[int, dict[int, int]], dict[_Fact, tuple[int, int, Disjunct]]]:
        plant = self._engine.plant
        ranks = {n: dict.fromkeys(plant.variables[n].start_indexes, 0) for n in self._variables}
        achievers: dict[_Fact, tuple[int, int, Disjunct]] = {}
        changed = set(self._variables)
        rank = 0
        while changed:
            rank += 1
            self._engine.manager.make_room()
            known = {variable: tuple(values) for variable, values in ranks.items()}
            recent, changed = changed, set()
            for number, (disjuncts, touched) in self._moves.items():
                if touched.isdisjoint(recent):
                    continue
                box = self._encoding.box({variable: known[variable] for variable in touched})
                for disjunct in disjuncts:
                    if disjunct.stays:
                        continue
                    after = self._engine.relations.image(disjunct, box)
                    for variable in self._engine.events[number].writes:
                        for index in self._new(after, variable, ranks[variable]):
                            ranks[variable][index] = rank
                            achievers[variable, index] = (rank, number, disjunct)
                            changed.add(variable)
        return ranks, achievers

    def _new(self, states: Bdd, variable: int, known: Mapping[int, int]) -> list[int]:
        """Return the indexes of values of a state variable in a set that are not known."""
        found: list[int] = []
        states = states & ~self._encoding.values(variable, tuple(known))
        while states != self._false:
            found.append(self._encoding.pick(states)[variable])
            states = states & ~self._encoding.value(variable, found[-1])
        return found
