"""State variables and parameters as boolean variables, expressions as sets of states.

The index of a state variable's value is encoded in binary, the most significant bit first. Each bit
has a boolean variable for the value before an event, and next to it one for the value after it.
Codes that encode no value are in no set of states.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cached_property, partial
from math import prod

from robosc.expr.evaluation import evaluate, scalar_of
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import fold, may_be_undefined, walk
from robosc.expr.tree import Binary, Expr, Leaf, Literal, Operation, Unary, ValueRef
from robosc.expr.types import Value
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.step import missing_together
from robosc.runtime.core.values import Undefined
from robosc.synthesis.bdd.arithmetic import Number, compared, number_of, of_index
from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.bdd.order import ordered
from robosc.synthesis.bdd.partition import Partition, combined, key_of
from robosc.synthesis.bdd.sources import LeafSource


@dataclass(frozen=True, slots=True)
class _Block:
    """The boolean variables of a state variable or parameter; a parameter has none ``after``."""

    size: int
    now: tuple[int, ...]
    after: tuple[int, ...]


class Encoding:
    """The boolean variables of one plant, and the sets of states of values and expressions."""

    def __init__(
        self,
        plant: Plant,
        memory: int,
        reverse: bool = False,
        piecewise: bool = False,
        together: bool = False,
    ) -> None:
        self.plant = plant
        self._blocks: dict[LeafSource, _Block] = {}
        self._known: dict[tuple[Expr, int | None], Partition] = {}
        # Each for what reads the ``value`` of an event, or of none.
        self._where: defaultdict[int | None, IdentityCache[Bdd]] = defaultdict(IdentityCache)
        self._partitions: defaultdict[int | None, IdentityCache[Partition]] = defaultdict(
            IdentityCache
        )
        self._piecewise = piecewise
        self._codes: dict[tuple[LeafSource, int], Bdd] = {}
        first = 0
        for item in ordered(plant, together)[:: -1 if reverse else 1]:
            block = self._blocks[item] = self._block(item, first)
            first += len(block.now) + len(block.after)
        self.manager = Manager(first, memory)
        self._now = sorted(
            bit for variable in range(len(plant.variables)) for bit in self._blocks[variable].now
        )
        self._bits = len(self._now)
        self.most = prod(variable.size for variable in plant.variables)

    def _block(self, source: LeafSource, first: int) -> _Block:
        if isinstance(source, int):
            size = self.plant.variables[source].size
            bits = (size - 1).bit_length()
            places = range(first, first + 2 * bits)
            return _Block(size, tuple(places[::2]), tuple(places[1::2]))
        event, number = source
        size = len(self.plant.events[event].parameters[number].values)
        return _Block(size, tuple(range(first, first + (size - 1).bit_length())), ())

    # --- sets of states

    def place(self, variable: int) -> int:
        """Return the position of a state variable in the order: its first boolean variable."""
        now = self._blocks[variable].now
        return now[0] if now else 0

    def value(self, source: LeafSource, index: int) -> Bdd:
        """Return where a state variable (or parameter) has the value with this index."""
        code = self._codes.get((source, index))
        if code is None:
            code = self._indexes(self._blocks[source].now, (index,))
            self._codes[source, index] = code
        return code

    def values(self, source: LeafSource, indexes: Collection[int]) -> Bdd:
        """Return where a state variable (or parameter) has a value with one of these indexes."""
        if len(indexes) == 1:
            return self.value(source, *indexes)
        return self._indexes(self._blocks[source].now, indexes)

    def value_after(self, variable: int, index: int) -> Bdd:
        """Return where a state variable has the value with this index after an event."""
        return self._indexes(self._blocks[variable].after, (index,))

    def all_values(self, source: LeafSource) -> Bdd:
        """Return where the code of a state variable (or parameter) encodes a value."""
        return self.values(source, range(self._blocks[source].size))

    def valuations(self, event: int) -> Bdd:
        """Return the combinations of parameter values that the event can have."""
        result = self.manager.true
        for source in self.parameters(event):
            result = result & self.all_values(source)
        for first, second in missing_together(self.plant.events[event]):
            # None stands last.
            one, other = (
                self.value(source, self._blocks[source].size - 1)
                for source in [(event, first), (event, second)]
            )
            result = result & (~one | other)
        return result

    def unchanged(self, variable: int) -> Bdd:
        """Return the relation that a state variable has the same value after an event as before."""
        block = self._blocks[variable]
        return self.manager.union(
            self.value(variable, index) & self.value_after(variable, index)
            for index in range(block.size)
        )

    def _indexes(self, variables: Sequence[int], indexes: Collection[int]) -> Bdd:
        manager = self.manager

        def build(depth: int, chosen: Collection[int]) -> Bdd:
            if not chosen:
                return manager.false
            if depth == len(variables) or len(chosen) == 1 << len(variables) - depth:
                return manager.true
            bit = 1 << len(variables) - depth - 1
            upper = [i for i in chosen if i & bit]
            lower = [i for i in chosen if not i & bit]
            variable = variables[depth]
            if not lower or not upper:  # at every level if there is a single value
                return manager.literal(variable, bool(upper)) & build(depth + 1, chosen)
            high, low = build(depth + 1, upper), build(depth + 1, lower)
            if high == low:
                return high
            return (manager.literal(variable, True) & high) | (
                manager.literal(variable, False) & low
            )

        return build(0, indexes)

    @cached_property
    def initial(self) -> Bdd:
        """The initial states."""
        variables = self.plant.variables
        return self.box({n: variable.start_indexes for n, variable in enumerate(variables)})

    @cached_property
    def marked(self) -> Bdd:
        """The marked states."""
        by_variable = ((n, variable.marked) for n, variable in enumerate(self.plant.variables))
        return self.box({n: marked for n, marked in by_variable if marked is not None})

    def state(self, state: PlantState) -> Bdd:
        """Return the set of one state."""
        return self.box({variable: (index,) for variable, index in enumerate(state)})

    def states(self, states: Sequence[PlantState]) -> Bdd:
        """Return the set of some states."""
        downwards = self._upwards[::-1]

        def build(depth: int, rows: Collection[PlantState]) -> Bdd:
            if depth == len(downwards):
                return self.manager.true
            parts: dict[int, list[PlantState]] = {}
            for row in rows:
                parts.setdefault(row[downwards[depth]], []).append(row)
            return self.manager.union(
                self.value(downwards[depth], index) & build(depth + 1, some)
                for index, some in parts.items()
            )

        return build(0, states) if states else self.manager.false

    def box(self, values: Mapping[int, Collection[int]]) -> Bdd:
        """Return where each of some state variables has one of the values with some indexes."""
        result = self.manager.true
        for variable in self._upwards:
            if variable in values:
                result = self.values(variable, values[variable]) & result
        return result

    @cached_property
    def _upwards(self) -> tuple[int, ...]:
        """The state variables from the last in the order to the first: the fastest to conjoin."""
        variables = range(len(self.plant.variables))
        return tuple(sorted(variables, key=self.place, reverse=True))

    def pick(self, states: Bdd) -> PlantState:
        """Return some state of a set that is not empty."""
        assignment = self.manager.pick(states)
        state = []
        for number in range(len(self.plant.variables)):
            index = 0
            for variable in self._blocks[number].now:
                index = index << 1 | bool(assignment[variable])
            state.append(index)
        return tuple(state)

    def contains(self, states: Bdd, state: PlantState) -> bool:
        """Whether a state is in a set."""
        return self.manager.contains(states, self.assignment(state))

    def assignment(self, state: PlantState) -> list[tuple[int, bool]]:
        """Return a state as values of boolean variables."""
        bits = []
        for number, index in enumerate(state):
            for shift, variable in enumerate(reversed(self._blocks[number].now)):
                bits.append((variable, bool(index >> shift & 1)))
        return bits

    def least(self, states: Bdd) -> PlantState:
        """Return the lexicographically first state of a set that is not empty."""
        only = self.pick(states)
        if states == self.state(only):
            return only
        state = []
        for variable in range(len(self.plant.variables)):
            for index in range(self._blocks[variable].size):
                here = states & self.value(variable, index)
                if here != self.manager.false:
                    states = here
                    state.append(index)
                    break
        return tuple(state)

    def count(self, states: Bdd) -> int:
        """Return the exact number of states in a set."""
        return self.manager.count(states, self.manager.variables - self._bits)

    def count_from(self, level: int, states: Bdd) -> int:
        """Return the number of states in a set that reads no variable above a level, from there."""
        return self.count(states) >> bisect_left(self._now, level)

    def count_with_parameters(self, event: int, states: Bdd) -> int:
        """Return the exact number of pairs of a state and parameter values of the event."""
        bits = self._bits + sum(len(self._blocks[p].now) for p in self.parameters(event))
        return self.manager.count(states, self.manager.variables - bits)

    def parameters(self, event: int) -> list[LeafSource]:
        return [(event, n) for n in range(len(self.plant.events[event].parameters))]

    def now(self, sources: Iterable[LeafSource]) -> Bdd:
        """Return the cube of the boolean variables before an event, to quantify over."""
        return self.manager.cube(v for source in sources for v in self._blocks[source].now)

    def after(self, variables: Iterable[int]) -> Bdd:
        """Return the cube of the boolean variables after an event."""
        return self.manager.cube(v for variable in variables for v in self._blocks[variable].after)

    def pairs(self, variables: Iterable[int]) -> list[tuple[int, int]]:
        """Return the pairs of boolean variables before and after an event."""
        return [
            pair
            for variable in variables
            for pair in zip(self._blocks[variable].now, self._blocks[variable].after, strict=True)
        ]

    # --- expressions

    def holds(self, expr: Expr, event: int | None = None) -> Bdd:
        """Return where a condition is true; ``event`` is the one whose parameters it reads.

        Results are cached: copies of a component share requirements, and warnings query them again.
        """
        return self._where[event].of(expr, lambda expr: self._new_holds(expr, event))

    def where(self, states: Bdd, condition: Expr) -> Bdd:
        """Return the states of a set in which a condition is true."""
        self.manager.make_room()
        if self._piecewise and not may_be_undefined(condition):
            return self._narrowed(states, condition)
        return states & self.holds(condition)

    def meets(self, states: Bdd, condition: Expr) -> bool:
        """Whether a condition is true in some state of a set."""
        match condition:
            case Binary(operator="or", left=left, right=right) if self._piecewise:
                if not may_be_undefined(condition):
                    return self.meets(states, left) or self.meets(states, right)
        return self.where(states, condition) != self.manager.false

    def _narrowed(self, states: Bdd, condition: Expr) -> Bdd:
        """Return the same; parts are applied one after the other, since all of them together can
        have a far larger diagram than what is left of the set."""
        match condition:
            case Binary(operator="and", left=left, right=right):
                return self._narrowed(self._narrowed(states, left), right)
            case Binary(operator="or", left=left, right=right):
                first = self._narrowed(states, left)
                return first | self._narrowed(states & ~first, right)
            case Unary(operator="!", operand=operand):
                return states & ~self._narrowed(states, operand)
        return states & self.holds(condition)

    def _new_holds(self, expr: Expr, event: int | None) -> Bdd:
        if isinstance(expr, Binary) and expr.operator == "and":
            return self.holds(expr.left, event) & self.holds(expr.right, event)
        wanted = True
        if isinstance(expr, Unary) and expr.operator == "!":
            expr, wanted = expr.operand, False
        values = self.partition(expr, event)
        return next((states for one, states in values if one is wanted), self.manager.false)

    def partition(self, expr: Expr, event: int | None = None) -> Partition:
        """Return the values of an expression, each with the states in which it has it."""
        return self._partitions[event].of(expr, lambda expr: self._new_partition(expr, event))

    def _new_partition(self, expr: Expr, event: int | None) -> Partition:
        shared: dict[int, Partition] = {}  # parts of this one expression: a count has many

        def known(node: Expr) -> Partition | None:
            """Return its partition, if that is cheaper than combining those of the operands."""
            partition = self._partitions[event].known(node) or shared.get(id(node))
            if partition is not None:
                return partition
            if _is_costly(node) and (node, event) in self._known:
                return self._known[node, event]
            sources = self._sources(node, event, 2)
            if len(sources) <= 1:
                partition = self._of_one_source(node, sources, event)
                if _is_costly(node):
                    self._known[node, event] = partition
                return partition
            return self._comparison(node, event)

        def operation(node: Operation, operands: tuple[Partition, ...]) -> Partition:
            partition = shared[id(node)] = combined(self.manager, node, operands)
            if _is_costly(node):
                self._known[node, event] = partition
            return partition

        def leaf(node: Expr) -> Partition:
            raise AssertionError("a leaf reads one source")

        return fold(expr, leaf, operation, known=known)

    def _sources(self, node: Expr, event: int | None, most: int | None = None) -> set[LeafSource]:
        """Return the sources that an expression reads, or the first ``most`` of them."""
        sources: set[LeafSource] = set()
        for leaf in walk(node):
            if isinstance(leaf, Leaf):
                sources.add(self._source(leaf, event))
            if len(sources) == most:
                break
        return sources

    def _comparison(self, node: Expr, event: int | None) -> Partition | None:
        """Return the partition of a comparison of linear integer expressions, by bits."""
        if not isinstance(node, Binary) or not node.operation.is_comparison:
            return None
        left, right = self._number(node.left, event), self._number(node.right, event)
        if left is None or right is None:
            return None
        valid = self.manager.true
        for source in self._sources(node, event):
            valid = valid & self.all_values(source)
        holds = compared(self.manager, node.operator, left, right)
        partition: Partition = [(True, valid & holds), (False, valid & ~holds)]
        return [(value, states) for value, states in partition if states != self.manager.false]

    def _number(self, expr: Expr, event: int | None) -> Number | None:
        def leaf(node: Leaf) -> Number | None:
            source = self._source(node, event)
            values = self._values_of(source)
            if not isinstance(values, range):
                return None
            return of_index(self.manager, self._blocks[source].now, values)

        return number_of(self.manager, expr, leaf)

    def _values_of(self, source: LeafSource) -> Sequence[Value | None]:
        if isinstance(source, int):
            return self.plant.variables[source].values
        event, number = source
        return self.plant.events[event].parameters[number].values

    def _source(self, leaf: Leaf, event: int | None) -> LeafSource:
        variable = self.plant.variable_of(leaf)
        if variable is not None:
            return variable
        assert event is not None and isinstance(leaf, ValueRef)
        parameters = self.plant.events[event].parameters
        return event, next(n for n, p in enumerate(parameters) if p.path == leaf.path)

    def _of_one_source(self, expr: Expr, sources: set[LeafSource], event: int | None) -> Partition:
        """Return the partition of an expression that reads one source, evaluated for each value."""
        if not sources:
            return [(_value(expr, lambda leaf: None), self.manager.true)]
        (source,) = sources
        by_value: dict[object, tuple[Value | None, list[int]]] = {}
        value_at = self._compared(expr, source)
        for index in range(self._blocks[source].size):
            value = value_at(index)
            by_value.setdefault(key_of(value), (value, []))[1].append(index)
        return [(value, self.values(source, indexes)) for value, indexes in by_value.values()]

    def _compared(self, expr: Expr, source: LeafSource) -> Callable[[int], Value | None]:
        """Return the value of an expression, given the index of the value of its one source.

        A number that is compared with many others has as many classes: a requirement of 1,000 terms
        on one took 15 s.
        """
        match expr:
            case Binary(left=leaf, right=Literal(value=other)) if isinstance(leaf, Leaf):
                if expr.operation.is_comparison:
                    scalar = scalar_of(expr)

                    def compared(index: int) -> Value | None:
                        value = self._read(source, index, leaf)
                        return None if value is None else scalar(value, other)

                    return compared
        return lambda index: _value(expr, partial(self._read, source, index))

    def _read(self, source: LeafSource, index: int, leaf: Leaf) -> Value | None:
        """Return the value of a leaf, given the index of the value of its source."""
        if isinstance(source, int):
            return self.plant.variables[source].read(leaf, index)
        event, parameter = source
        return self.plant.events[event].parameters[parameter].values[index]


def _is_costly(node: Expr) -> bool:
    """Whether to cache a node: comparisons, sums and leaves occur again in guards and warnings."""
    return isinstance(node, Leaf) or (isinstance(node, Operation) and not node.operation.is_lazy)


def _value(expr: Expr, lookup: Callable[[Leaf], Value | None]) -> Value | None:
    try:
        return evaluate(expr, lookup)
    except Undefined:
        return None
