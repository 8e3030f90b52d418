"""Least fixpoints of transition relations by saturation.

Saturation (Ciardo, Luettgen & Siminiceanu, TACAS 2001) applies a relation only to the parts of a
set below the topmost variable that the relation reads or writes, and closes such a part under all
relations further down before it goes on. So what has been found for a part is found for all states
that share it, and the diagrams between the first set and the fixpoint stay about as small as these.
Here the nodes are those of binary decision diagrams, and parts are their cofactors.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from functools import partial
from typing import Any, TypeAlias

from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.bdd.relations import Disjunct

_Part: TypeAlias = tuple[Bdd, Bdd, int]
"""A part of the set, the part of the bound for it, and the first relation that concerns it."""

_MOST_KNOWN = 2**19
"""Parts whose fixpoints are kept, some 300 bytes each outside the memory of the diagrams."""
_NO_LEVEL = 2**62
"""Stands below all variables: that of the constants."""


def saturated(
    manager: Manager,
    states: Bdd,
    within: Bdd,
    disjuncts: Sequence[Sequence[Disjunct]],
    step: Callable[[Disjunct, Bdd], Bdd],
    report: Callable[[Bdd, int], None],
) -> Bdd:
    """Return the least set with ``states`` and, for each disjunct, ``step(d, set) & within`` in it.

    ``report`` is called often, with a part and the level from which it is closed; it may raise what
    ends the search.

    Raises:
        MemoryError: the nodes do not suffice.
    """
    return Saturation(manager, disjuncts, step, report).of(states, within)


class Saturation:
    """The same for several sets; the fixpoints of parts are kept from one to the next."""

    def __init__(
        self,
        manager: Manager,
        disjuncts: Sequence[Sequence[Disjunct]],
        step: Callable[[Disjunct, Bdd], Bdd],
        report: Callable[[Bdd, int], None],
    ) -> None:
        self._manager = manager
        self._step = step
        self._report = report
        active = [d for several in disjuncts for d in several if not d.stays]
        by_level = sorted(((_top(d), n) for n, d in enumerate(active)))
        self._relations = [active[n] for _, n in by_level]
        self._tops = [level for level, _ in by_level]
        # Per relation, the first one whose top is further down.
        self._below = [0] * len(active)
        for n in reversed(range(len(active))):
            same = n + 1 < len(active) and self._tops[n + 1] == self._tops[n]
            self._below[n] = self._below[n + 1] if same else n + 1
        self._known: dict[_Part, Bdd] = {}
        self.work = 0
        """The parts whose fixpoints were computed so far."""
        self._run = partial(manager.run, forget=self._known.clear)

    def of(self, states: Bdd, within: Bdd) -> Bdd:
        """Return the fixpoint. The stack is a list, because that of Python is short."""
        stack: list[Generator[_Part, Bdd, Bdd]] = []
        part: _Part = (states, within, 0)
        while True:
            closure = self._at_hand(part)
            if closure is None:
                stack.append(self._saturate(*part))
                part = next(stack[-1])
                continue
            while True:
                if not stack:
                    return closure
                try:
                    part = stack[-1].send(closure)
                    break
                except StopIteration as end:
                    stack.pop()
                    closure = end.value

    def _at_hand(self, part: _Part) -> Bdd | None:
        states, within, first = part
        false = self._manager.false
        if first == len(self._relations) or states == false or within == false:
            return states
        return self._known.get(part)

    def _saturate(self, states: Any, within: Any, first: int) -> Generator[_Part, Bdd, Bdd]:
        """Return the fixpoint of a part; yield the parts of it whose fixpoints are needed."""
        self.work += 1
        of, bound = _level(states), _level(within)
        level = min(of, bound)
        closure: Bdd
        if level < self._tops[first]:
            highs, lows = states.cofactors() if of == level else (states, states)
            high, low = within.cofactors() if bound == level else (within, within)
            high = yield highs, high, first
            low = yield lows, low, first
            variable: Any = self._manager.literal(level, True)
            closure = self._run(lambda: variable.ite(high, low))
        else:
            closure, below = states, self._below[first]
            while True:
                before = closure
                closure = yield closure, within, below
                for relation in self._relations[first:below]:
                    closure = self._run(
                        lambda f=closure, r=relation: f | (self._step(r, f) & within)  # type: ignore[misc]
                    )
                if closure == before:
                    break
            if len(self._known) > _MOST_KNOWN:
                self._known.clear()
            self._known[closure, within, first] = closure
            self._report(closure, self._tops[first])
        self._known[states, within, first] = closure
        return closure


def _top(disjunct: Disjunct) -> int:
    """Return the topmost level of what a disjunct reads or writes."""
    return min(map(_level, (disjunct.relation, disjunct.target, disjunct.written)))


def _level(states: Any) -> int:
    level: int | None = states.node_level()
    return _NO_LEVEL if level is None else level
