"""Closures of sets of states under steps, as the symbolic verifier needs them.

A step concerns the variables from the topmost to the lowest one that it reads or writes. A diagram
is closed from its leaves to its root: both halves of a node are closed under the steps that concern
only variables below before a step that concerns the node's own variable is taken, and what that
step adds is closed below in the same way. This is saturation (Ciardo, Luettgen & Siminiceanu,
TACAS 2001). The engine's (:mod:`robosc.synthesis.bdd.saturation`) is another text over other
relations; they share no code.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import field
from itertools import groupby
from typing import Any, Final, TypeAlias

from robosc.lazy_dataclasses import dataclass
from robosc.synthesis.bdd.manager import Bdd, Manager

_BOTTOM: Final = 1 << 62
"""Stands for the place of the two constants, below all variables."""
_MOST_REMEMBERED: Final = 1 << 19
"""Closures of parts that are remembered, some 300 bytes each."""

Arrow: TypeAlias = tuple[int, Callable[[Bdd], Bdd]]
"""A step: the place of the topmost variable that it concerns, and what it makes of a set."""
_Task: TypeAlias = tuple[Bdd, Bdd, int]
"""A set to close, where it must stay, and the first stage of steps under which it is closed."""
_Work: TypeAlias = Generator[_Task, Bdd, Bdd]


@dataclass(frozen=True, slots=True)
class _Stage:
    """All steps whose topmost variable is at one place."""

    place: int
    arrows: tuple[Callable[[Bdd], Bdd], ...]


def place_of(states: Any) -> int:
    """Return the place of the topmost variable of a diagram."""
    found: int | None = states.node_level()
    return _BOTTOM if found is None else found


@dataclass
class Closure:
    """Closes sets under some arrows.

    ``tick`` is called at short intervals with a part that is closed from some place on; it may
    raise.
    """

    manager: Manager
    arrows: Iterable[Arrow]
    tick: Callable[[Bdd, int], None] = lambda part, place: None
    _stages: list[_Stage] = field(init=False)
    _remembered: dict[_Task, Bdd] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        ordered = sorted(self.arrows, key=lambda arrow: arrow[0])
        self._stages = [
            _Stage(place, tuple(take for _, take in group))
            for place, group in groupby(ordered, key=lambda arrow: arrow[0])
        ]

    def of(self, states: Bdd, inside: Bdd) -> Bdd:
        """Return the least set that contains ``states`` and what arrows reach from it ``inside``.

        Work that waits for other work is in a list: Python's own stack would be too short.
        """
        waiting: list[_Work] = []
        work = self._close(states, inside, 0)
        answer: Bdd | None = None
        while True:
            try:
                task = next(work) if answer is None else work.send(answer)
            except StopIteration as finished:
                answer = finished.value
                if not waiting:
                    assert answer is not None
                    return answer
                work = waiting.pop()
                continue
            answer = self._remembered.get(task)
            if answer is None:
                waiting.append(work)
                work = self._close(*task)

    def _close(self, states: Bdd, inside: Bdd, stage: int) -> _Work:
        false = self.manager.false
        if stage == len(self._stages) or states == false or inside == false:
            return states
        task = states, inside, stage
        place = min(place_of(states), place_of(inside))
        if place >= self._stages[stage].place:
            closed = yield from self._close_here(states, inside, stage)
            self._remember((closed, inside, stage), closed)
            self.tick(closed, self._stages[stage].place)
        else:
            high = yield _half(states, place, 0), _half(inside, place, 0), stage
            low = yield _half(states, place, 1), _half(inside, place, 1), stage
            variable: Any = self.manager.literal(place, True)
            closed = self.manager.run(lambda: variable.ite(high, low), self._remembered.clear)
        self._remember(task, closed)
        return closed

    def _close_here(self, states: Bdd, inside: Bdd, stage: int) -> _Work:
        """Close under the steps of one stage, and after each round under those further down."""
        arrows = self._stages[stage].arrows
        before, closed = None, states
        while closed != before:
            before = closed = yield closed, inside, stage + 1
            for take in arrows:
                closed = self.manager.run(
                    lambda s=closed, t=take: s | (t(s) & inside),  # type: ignore[misc]
                    self._remembered.clear,
                )
        return closed

    def _remember(self, task: _Task, closed: Bdd) -> None:
        if len(self._remembered) >= _MOST_REMEMBERED:
            self._remembered.clear()
        self._remembered[task] = closed


def _half(states: Any, place: int, number: int) -> Bdd:
    """Return the part of a set in which the variable at a place is true (0) or false (1)."""
    half: Bdd = states.cofactors()[number] if place_of(states) == place else states
    return half
