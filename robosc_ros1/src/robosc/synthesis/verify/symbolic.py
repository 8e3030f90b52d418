"""The second opinion on systems that are too large to visit every state: sets of states.

The same proof as in :mod:`robosc.synthesis.verify.check`, with decision diagrams of its own. It
shares the library with the symbolic engine, and nothing else: variables stand in model order, the
transition relation of an event is one table of what :class:`EventSteps` works out state by state,
conditions are taken apart at their operators and looked up value by value, and the fixpoints are
plain rounds over all events.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Final, TypeAlias

from robosc.errors import StateSpaceError
from robosc.ir.automaton import Event, Plant, PlantState
from robosc.model.expr import FALSE, TRUE, Binary, Expr, Unary
from robosc.supervisor import Supervisor
from robosc.synthesis.bdd.manager import Bdd, Manager, Renaming
from robosc.synthesis.verify.steps import Coding, EventSteps, axes_of, axes_read, condition

__all__ = ["Answers", "answers"]

_MOST_ROWS: Final = 1 << 18  # some seconds each

_Row: TypeAlias = tuple[int, ...]
"""Values of some axes."""
_Effect: TypeAlias = tuple[int | None, ...]
"""What becomes of the axes that an event writes; None: one stays as it is."""


@dataclass(frozen=True, slots=True)
class Answers:
    """What the guards of a supervisor do; what fails is told in a sentence, None: it holds."""

    unsafe: str | None
    blocking: str | None
    needless: str | None
    states: int
    transitions: int
    plant_states: int
    keeps_initial: bool


def answers(supervisor: Supervisor, describe: Callable[[Event], str]) -> Answers:
    """What is to be said of a supervisor; ``describe`` names an event in a sentence.

    Raises:
        StateSpaceError: an event or a condition reads too much, or the diagrams grow too large.
    """
    try:
        return _Sets(supervisor, describe).answers()
    except MemoryError:
        raise StateSpaceError("verification ran out of the memory that it may use") from None


@dataclass(frozen=True, eq=False, slots=True)
class _Relation:
    """An event: its steps as pairs of states before and after, over what it reads and writes.

    ``possible`` is where it can happen at all, ``escapes`` where it may leave a range, ``weights``
    in how many ways it can happen.
    """

    event: Event
    steps: Bdd
    now: Bdd
    after: Bdd
    forward: Renaming
    backward: Renaming
    possible: Bdd
    escapes: Bdd
    weights: tuple[tuple[int, Bdd], ...]


class _Sets:
    def __init__(self, supervisor: Supervisor, describe: Callable[[Event], str]) -> None:
        self.plant: Plant = supervisor.plant
        self.describe = describe
        self._bits: list[tuple[int, ...]] = []
        first = 0
        for variable in self.plant.variables:
            bits = (variable.size - 1).bit_length()
            self._bits.append(tuple(range(first, first + 2 * bits, 2)))
            first += 2 * bits
        self.manager = Manager(first)
        self.false = self.manager.false
        coding = Coding(self.plant)
        self.relations = [self._relation(coding, n) for n in range(len(self.plant.events))]
        guards = {g.event.identity: g.expr for g in supervisor.guards}
        self.required: dict[int, Bdd] = {}
        self.guards: dict[int, Bdd] = {}
        for number, event in enumerate(self.plant.events):
            free = FALSE if event.controllable else TRUE
            guard = guards.get(event.identity, free)
            self.guards[number] = self.holds(guard)
            self.required[number] = self.holds(event.requirement or TRUE)

    def answers(self) -> Answers:
        manager = self.manager
        initial = manager.true
        for axis, variable in enumerate(self.plant.variables):
            initial = initial & self._rows([axis], [(index,) for index in variable.start_indexes])
        failing = [~self.holds(expr) for expr, _ in self.plant.invariants]
        escaping = [r.escapes for r in self.relations]
        unsafe = manager.union([*failing, *escaping])
        everything = [manager.true] * len(self.relations)
        plant = self._forward(initial, everything, manager.true)
        permitted = self._forward(initial, list(self.required.values()), ~unsafe)
        keepable = self._keepable(permitted & ~unsafe)
        reached = self._forward(initial, list(self.guards.values()), ~unsafe)
        return Answers(
            unsafe=self._unsafe(reached, unsafe),
            blocking=self._blocking(reached),
            needless=self._needless(reached, keepable),
            states=self._count(reached),
            transitions=self._transitions(reached),
            plant_states=self._count(plant),
            keeps_initial=initial & ~keepable == self.false,
        )

    # --- what is asked

    def _unsafe(self, reached: Bdd, unsafe: Bdd) -> str | None:
        if reached & unsafe != self.false:
            for expr, index in self.plant.invariants:
                if reached & ~self.holds(expr) != self.false:
                    return f"'{self.plant.robot.requirements[index].text}' fails"
            leaving = next(r for r in self.relations if reached & r.escapes != self.false)
            return f"the {self.describe(leaving.event)} may take a variable out of its range"
        for number, relation in enumerate(self.relations):
            taken = reached & relation.possible & self.guards[number]
            if taken & ~self.required[number] != self.false:
                return f"the {self.describe(relation.event)} happens against a requirement"
        return None

    def _blocking(self, reached: Bdd) -> str | None:
        back = self._coreachable(reached, list(self.guards.values()))
        return None if back == reached else "no marked state can be reached any more"

    def _needless(self, reached: Bdd, keepable: Bdd) -> str | None:
        for number, relation in enumerate(self.relations):
            forbidden = reached & relation.possible & self.required[number] & ~self.guards[number]
            if forbidden & self._staying(relation, keepable) != self.false:
                return f"the {self.describe(relation.event)} is forbidden without need"
        return None

    def _transitions(self, reached: Bdd) -> int:
        return sum(
            weight * self._count(reached & states & self.guards[number])
            for number, relation in enumerate(self.relations)
            for weight, states in relation.weights
        )

    # --- fixpoints

    def _image(self, relation: _Relation, states: Bdd) -> Bdd:
        found = self.manager.and_exists(states, relation.steps, relation.now)
        return self.manager.rename(found, relation.forward)

    def _preimage(self, relation: _Relation, states: Bdd) -> Bdd:
        renamed = self.manager.rename(states, relation.backward)
        return self.manager.and_exists(renamed, relation.steps, relation.after)

    def _staying(self, relation: _Relation, within: Bdd) -> Bdd:
        """Where an event is possible and all that it leads to is ``within``."""
        return relation.possible & ~self._preimage(relation, ~within)

    def _forward(self, states: Bdd, where: Sequence[Bdd], left: Bdd) -> Bdd:
        """All that events reach where they are allowed, from states that may be ``left``."""
        while True:
            before = states
            for relation, allowed in zip(self.relations, where, strict=True):
                self.manager.collect_garbage()
                states = states | self._image(relation, states & allowed & left)
            if states == before:
                return states

    def _coreachable(self, within: Bdd, where: Sequence[Bdd]) -> Bdd:
        """The states ``within`` from which a marked one is reached there."""
        found = within & self._marked()
        while True:
            before = found
            for relation, allowed in zip(self.relations, where, strict=True):
                self.manager.collect_garbage()
                found = found | (self._preimage(relation, found) & allowed & within)
            if found == before:
                return found

    def _keepable(self, safe: Bdd) -> Bdd:
        """What some supervisor can keep safe and nonblocking, of the safe states."""
        kept = safe
        while True:
            before = kept
            for relation in self.relations:
                if not relation.event.controllable:
                    self.manager.collect_garbage()
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

    # --- diagrams

    def holds(self, expr: Expr) -> Bdd:
        """The states in which a condition holds."""
        match expr:
            case Unary(operator="!", operand=operand):
                return ~self.holds(operand)
            case Binary(operator="and" | "or" | "=>" as operator, left=left, right=right):
                first, second = self.holds(left), self.holds(right)
                if operator == "and":
                    return first & second
                return (first if operator == "or" else ~first) | second
        axes = sorted(axes_of(self.plant, expr))
        test = condition(self.plant, expr)
        rows = self._combinations(axes)
        return self._rows(axes, (row for row in rows if test(self._at(axes, row))))

    def _relation(self, coding: Coding, number: int) -> _Relation:
        event = self.plant.events[number]
        steps = EventSteps(self.plant, coding, event)
        axes, written = sorted(axes_read(self.plant, event)), sorted(self.plant.writes[number])
        possible: dict[int, list[_Row]] = {}
        escapes: list[_Row] = []
        effects: dict[_Effect, list[_Row]] = {}
        for row in self._combinations(axes, len(steps.valuations)):
            found = list(self._effects(steps, axes, row, written))
            if None in found:
                escapes.append(row)
            taken = [effect for effect in found if effect is not None]
            if taken:
                possible.setdefault(len(taken), []).append(row)
            for effect in set(taken):
                effects.setdefault(effect, []).append(row)
        weights = tuple((weight, self._rows(axes, rows)) for weight, rows in possible.items())
        pairs = [(bit, bit + 1) for axis in written for bit in self._bits[axis]]
        return _Relation(
            event=event,
            steps=self.manager.union(
                self._rows(axes, rows) & self._after(written, effect)
                for effect, rows in effects.items()
            ),
            now=self.manager.cube(now for now, _ in pairs),
            after=self.manager.cube(after for _, after in pairs),
            forward=self.manager.renaming([(after, now) for now, after in pairs]),
            backward=self.manager.renaming(pairs),
            possible=self.manager.union(states for _, states in weights),
            escapes=self._rows(axes, escapes),
            weights=weights,
        )

    def _effects(
        self, steps: EventSteps, axes: Sequence[int], row: _Row, written: Sequence[int]
    ) -> Iterator[_Effect | None]:
        """What becomes of what is written, for each value of the event; None: a range is left.

        An axis that is not read either stays or gets the same value whatever it was: two states
        that differ in it tell which.
        """
        state, other = self._at(axes, row, 0), self._at(axes, row, 1)
        for values in steps.valuations:
            after = steps.after(state, values)
            if isinstance(after, list):
                again = steps.after(other, values)
                yield tuple(
                    None if state[axis] != other[axis] and after[axis] != again[axis]
                    else after[axis]
                    for axis in written
                )  # fmt: skip
            elif after == "escapes" and not steps.event.controllable:
                yield None

    def _combinations(self, axes: Sequence[int], times: int = 1) -> Iterator[_Row]:
        sizes = [self.plant.variables[axis].size for axis in axes]
        if prod(sizes) * times > _MOST_ROWS:
            names = ", ".join(self.plant.variables[axis].name for axis in axes[:5])
            raise StateSpaceError(
                f"verification stops at {_MOST_ROWS} combinations of values of {names}"
            )
        return product(*map(range, sizes))

    def _at(self, axes: Sequence[int], row: _Row, rest: int = 0) -> PlantState:
        """The state with some values; all others are ``rest`` where they can be."""
        state = [min(rest, variable.size - 1) for variable in self.plant.variables]
        for axis, value in zip(axes, row, strict=True):
            state[axis] = value
        return tuple(state)

    def _rows(self, axes: Sequence[int], rows: Iterable[_Row]) -> Bdd:
        """The states in which some axes, in ascending order, have the values of one of the rows."""
        if not axes:
            return self.manager.true if any(True for _ in rows) else self.false
        by_value: dict[int, list[_Row]] = {}
        for row in rows:
            by_value.setdefault(row[0], []).append(row[1:])
        same: dict[Bdd, list[int]] = {}
        for value, below in by_value.items():
            same.setdefault(self._rows(axes[1:], below), []).append(value)
        return self.manager.union(
            below & self.manager.union(self._value(self._bits[axes[0]], v) for v in values)
            for below, values in same.items()
        )

    def _value(self, bits: Sequence[int], value: int) -> Bdd:
        found = self.manager.true
        for place, bit in enumerate(reversed(bits)):
            found = self.manager.literal(bit, bool(value >> place & 1)) & found
        return found

    def _after(self, written: Sequence[int], effect: _Effect) -> Bdd:
        found = self.manager.true
        for axis, value in zip(reversed(written), reversed(effect), strict=True):
            if value is not None:
                found = self._value([bit + 1 for bit in self._bits[axis]], value) & found
                continue
            for bit in reversed(self._bits[axis]):
                now, after = (self.manager.literal(b, True) for b in (bit, bit + 1))
                found = ~(now ^ after) & found
        return found

    def _marked(self) -> Bdd:
        found = self.manager.true
        for axis, variable in enumerate(self.plant.variables):
            if variable.marked is not None:
                found = found & self._rows([axis], [(value,) for value in variable.marked])
        return found

    def _count(self, states: Bdd) -> int:
        return self.manager.count(states, self.manager.variables // 2)
