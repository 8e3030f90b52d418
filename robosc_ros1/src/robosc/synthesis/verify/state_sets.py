"""Sets of states and transition relations of the symbolic verifier, as decision diagrams.

The transition relation of an event is the conjunction of one table per automaton that takes part,
computed state by state. Conditions are decomposed at their operators, and the operands evaluated
value by value. The order of the variables is found by the means of the symbolic engine: any order
gives the same sets.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from math import prod
from typing import Final, TypeAlias

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.expr.evaluation import evaluate
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.tree import Binary, Expr, Unary
from robosc.expr.types import Value
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.event_values import values_read
from robosc.plant.step import Values, Verdict, lookup, outcome, valuations
from robosc.plant.support import support
from robosc.synthesis.bdd.manager import Bdd, Manager, Renaming
from robosc.synthesis.bdd.order import ordered
from robosc.synthesis.verify.steps import read_by
from robosc.synthesis.verify.verify_report import event_phrase

_FEW_ROWS: Final = 1 << 10  # above, operands are combined by value: sums have few values

_Row: TypeAlias = tuple[int, ...]
"""Values of some state variables."""
Assigned: TypeAlias = tuple[tuple[int, int], ...]
"""State variables, each with the index of its value."""
_Effect: TypeAlias = tuple[int | None, ...]
"""The new values of the state variables that an event writes; None: unchanged."""


@dataclass(frozen=True, eq=False, slots=True)
class Relation:
    """An event: its steps as pairs of states before and after, over what it reads and writes.

    ``possible`` is where it can happen with some values, ``escapes`` where it may leave a range,
    ``weights`` are sets of states, each with a number of values with which it can happen there.
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


@dataclass(frozen=True, eq=False, slots=True)
class _Table:
    """The effect of an automaton for some values of an event.

    ``inside`` is where it takes part within the ranges, ``escapes`` where it may leave one;
    ``steps`` are pairs of states before and after, over what it reads and writes.
    """

    inside: Bdd
    escapes: Bdd
    steps: Bdd


@dataclass(frozen=True, eq=False, slots=True)
class _Local:
    """An automaton's part in an event: one table per combination of the values that it reads.

    ``written`` are state variables, ``reads`` indexes into the event's values.
    """

    written: list[int]
    reads: list[int]
    tables: dict[Values, _Table]

    def read(self, values: Values) -> Values:
        """Return those of the event's values that the automaton reads."""
        return tuple(values[place] for place in self.reads)


def _parts(event: Event) -> Iterator[Event]:
    """Yield the event without automata, then with the phase left out for each automaton alone."""
    yield replace(event, automata=())
    for automaton in event.automata:
        yield replace(event, automata=(automaton,), phase=None)


class StateSets:
    """Sets of states of a plant, and the transition relations of its events.

    With ``reverse`` the variables have the opposite order.
    """

    def __init__(self, plant: Plant, reverse: bool = False) -> None:
        self.plant = plant
        self._order = [item for item in ordered(plant) if isinstance(item, int)]
        if reverse:
            self._order.reverse()
        self._bits: list[tuple[int, ...]] = [()] * len(plant.variables)
        first = 0
        for index in self._order:
            bits = (plant.variables[index].size - 1).bit_length()
            self._bits[index] = tuple(range(first, first + 2 * bits, 2))
            first += 2 * bits
        self._rest = [[min(rest, v.size - 1) for v in plant.variables] for rest in (0, 1)]
        self._holding: IdentityCache[Bdd] = IdentityCache()
        self._place = {index: place for place, index in enumerate(self._order)}
        self.manager = Manager(first)
        self.false = self.manager.false
        self.relations = [self._relation(event) for event in plant.events]

    @property
    def initial(self) -> Bdd:
        states = self.manager.true
        for index in reversed(self._order):
            starts = self.plant.variables[index].start_indexes
            states = self._rows([index], [(start,) for start in starts]) & states
        return states

    @property
    def marked(self) -> Bdd:
        states = self.manager.true
        for index in reversed(self._order):
            marked = self.plant.variables[index].marked
            if marked is not None:
                states = self._rows([index], [(value,) for value in marked]) & states
        return states

    def holds(self, expr: Expr) -> Bdd:
        """Return the states in which a condition holds."""
        return self._holding.of(expr, self._new_holds)

    def _new_holds(self, expr: Expr) -> Bdd:
        match expr:
            case Unary(operator="!", operand=operand):
                return ~self.holds(operand)
            case Binary(operator="and" | "or" | "=>" as operator, left=left, right=right):
                first, second = self.holds(left), self.holds(right)
                if operator == "and":
                    return first & second
                return (first if operator == "or" else ~first) | second
        return self._valued(expr).get(True, self.false)

    def count(self, states: Bdd) -> int:
        return self.manager.count(states, self.manager.variables // 2)

    def values(self, states: Bdd, variables: Collection[int]) -> Iterator[Assigned]:
        """Yield the values that variables have together in some of the states."""
        others = (b for index in self._order if index not in variables for b in self._bits[index])
        alone = self.manager.exists(states, self.manager.cube(others))
        return self._values(alone, self._sorted(variables))

    def _values(self, states: Bdd, variables: Sequence[int]) -> Iterator[Assigned]:
        if not variables:
            yield ()
            return
        first, *rest = variables
        for value in range(self.plant.variables[first].size):
            having = states & self._value(self._bits[first], value)
            if having != self.false:
                yield from (((first, value), *row) for row in self._values(having, rest))

    @property
    def most(self) -> int:
        """How many states there are, reachable or not."""
        return prod(variable.size for variable in self.plant.variables)

    def count_from(self, place: int, states: Bdd) -> int:
        """Return the number of states in a set that reads no bit before a place, from there."""
        return self.count(states) >> (place + 1) // 2

    def _valued(self, expr: Expr) -> dict[Value, Bdd]:
        """Return the values of an expression, each with the states in which it has it.

        It is evaluated for all combinations of what it reads; if these are too many, its operands
        are, and their values combined.
        """
        variables = self._sorted(support(self.plant, expr))
        if self._size(variables) <= _FEW_ROWS or not isinstance(expr, Binary):
            rows: dict[Value, list[_Row]] = {}
            for row in self._combinations(variables):
                look = lookup(self.plant, None, (), self._at(variables, row))
                rows.setdefault(evaluate(expr, look), []).append(row)
            return {value: self._rows(variables, having) for value, having in rows.items()}
        left, right = self._valued(expr.left), self._valued(expr.right)
        if len(left) * len(right) > limits.VERIFIED_ROWS:
            raise self._too_many(variables)
        found: dict[Value, list[Bdd]] = {}
        for (first, some), (second, others) in product(left.items(), right.items()):
            found.setdefault(expr.operation.scalar(first, second), []).append(some & others)
        return {value: self.manager.union(sets) for value, sets in found.items()}

    def _relation(self, event: Event) -> Relation:
        if prod(len(parameter.values) for parameter in event.parameters) > limits.VERIFIED_ROWS:
            raise StateSpaceError(
                f"verification stops at {limits.VERIFIED_ROWS} values;"
                f" the {event_phrase(event)} has more"
            )
        parts = [self._local(part) for part in _parts(event)]
        alike = Counter(tuple(part.read(values) for part in parts) for values in valuations(event))
        steps: list[Bdd] = []
        escapes: list[Bdd] = []
        weights: Counter[Bdd] = Counter()
        for read, times in alike.items():
            taken = [part.tables[values] for part, values in zip(parts, read, strict=True)]
            inside = possible = relation = self.manager.true
            for table in taken:
                inside = inside & table.inside
                possible = possible & (table.inside | table.escapes)
                relation = relation & table.steps
            steps.append(relation)
            escapes.append(possible & ~inside)
            weights[inside] += times
        pairs = [(bit, bit + 1) for part in parts for a in part.written for bit in self._bits[a]]
        return Relation(
            event=event,
            steps=self.manager.union(steps),
            now=self.manager.cube(now for now, _ in pairs),
            after=self.manager.cube(after for _, after in pairs),
            forward=self.manager.renaming([(after, now) for now, after in pairs]),
            backward=self.manager.renaming(pairs),
            possible=self.manager.union(weights),
            escapes=self.manager.union(escapes),
            weights=tuple((weight, states) for states, weight in weights.items()),
        )

    def _local(self, event: Event) -> _Local:
        """Return the part of one automaton, given as an event of its own."""
        variables = self._sorted(read_by(self.plant, event))
        paths = values_read(e for automaton in event.automata for e in automaton.expressions)
        reads = [n for n, parameter in enumerate(event.parameters) if parameter.path in paths]
        local = _Local(self._sorted(event.writes), reads, {})
        for values in valuations(event):
            if (read := local.read(values)) not in local.tables:
                if self._size(variables) * (len(local.tables) + 1) > limits.VERIFIED_ROWS:
                    raise self._too_many(variables)
                local.tables[read] = self._table(event, variables, local.written, values)
        return local

    def _table(
        self, event: Event, variables: Sequence[int], written: Sequence[int], values: Values
    ) -> _Table:
        """Return the effect of an event for some values, as a table over what it reads.

        A variable that is written but not read is either unchanged or assigned a constant; two
        states that differ in it show which.
        """
        escapes: list[_Row] = []
        effects: dict[_Effect, list[_Row]] = {}
        for row in self._combinations(variables):
            state, other = self._at(variables, row, 0), self._at(variables, row, 1)
            after = outcome(self.plant, event, values, state)
            if not isinstance(after, Verdict):
                again = outcome(self.plant, event, values, other)
                assert not isinstance(again, Verdict)  # it depends on what is read
                effect = tuple(
                    None
                    if state[variable] != other[variable] and after[variable] != again[variable]
                    else after[variable]
                    for variable in written
                )  # fmt: skip
                effects.setdefault(effect, []).append(row)
            elif after is Verdict.OUT_OF_RANGE and not event.controllable:
                escapes.append(row)
        return _Table(
            inside=self._rows(variables, (row for rows in effects.values() for row in rows)),
            escapes=self._rows(variables, escapes),
            steps=self.manager.union(
                self._rows(variables, rows) & self._after(written, effect)
                for effect, rows in effects.items()
            ),
        )

    def _sorted(self, variables: Iterable[int]) -> list[int]:
        return sorted(variables, key=self._place.__getitem__)

    def _size(self, variables: Iterable[int]) -> int:
        return prod(self.plant.variables[variable].size for variable in variables)

    def _combinations(self, variables: Sequence[int]) -> Iterator[_Row]:
        if self._size(variables) > limits.VERIFIED_ROWS:
            raise self._too_many(variables)
        return product(*(range(self.plant.variables[variable].size) for variable in variables))

    def _too_many(self, variables: Sequence[int]) -> StateSpaceError:
        names = ", ".join(self.plant.variables[variable].name for variable in variables[:5])
        return StateSpaceError(
            f"verification stops at {limits.VERIFIED_ROWS} combinations of values of {names}"
        )

    def _at(self, variables: Sequence[int], row: _Row, rest: int = 0) -> PlantState:
        """Return the state with some values; all others are ``rest``, or their maximum."""
        state = list(self._rest[rest])
        for index, value in zip(variables, row, strict=True):
            state[index] = value
        return tuple(state)

    def _rows(self, variables: Sequence[int], rows: Iterable[_Row]) -> Bdd:
        """Return where state variables, in their order, have the values of one of the rows."""
        if not variables:
            return self.manager.true if any(True for _ in rows) else self.false
        by_value: dict[int, list[_Row]] = {}
        for row in rows:
            by_value.setdefault(row[0], []).append(row[1:])
        same: dict[Bdd, list[int]] = {}
        for value, below in by_value.items():
            same.setdefault(self._rows(variables[1:], below), []).append(value)
        return self.manager.union(
            below & self.manager.union(self._value(self._bits[variables[0]], v) for v in values)
            for below, values in same.items()
        )

    def _value(self, bits: Sequence[int], value: int) -> Bdd:
        equal = self.manager.true
        for place, bit in enumerate(reversed(bits)):
            equal = self.manager.literal(bit, bool(value >> place & 1)) & equal
        return equal

    def _after(self, written: Sequence[int], effect: _Effect) -> Bdd:
        relation = self.manager.true
        for variable, value in zip(reversed(written), reversed(effect), strict=True):
            if value is not None:
                relation = self._value([bit + 1 for bit in self._bits[variable]], value) & relation
                continue
            for bit in reversed(self._bits[variable]):
                now, after = (self.manager.literal(b, True) for b in (bit, bit + 1))
                relation = ~(now ^ after) & relation
        return relation
