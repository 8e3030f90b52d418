"""The plant's events as disjunctively partitioned transition relations.

The transition relation of an event is stored as its *disjuncts* (Burch, Clarke & Long, "Symbolic
model checking with partitioned transition relations", VLSI 1991). A disjunct that assigns constants
needs no variables for the state afterwards: its image quantifies the written state variables and
conjoins the new values. Only where there would be too many such disjuncts (a counter, many automata
with a choice each) is it a relation between old and new values, over both kinds of boolean
variables. State variables that an event does not write do not occur in it and stay unchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from robosc.expr.tree import TRUE
from robosc.expr.types import Value
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Edge, LocalAutomaton
from robosc.plant.support import event_support
from robosc.synthesis.bdd.encoding import Encoding
from robosc.synthesis.bdd.manager import Bdd, Renaming
from robosc.synthesis.bdd.partition import Partition
from robosc.synthesis.bdd.sources import LeafSource
from robosc.synthesis.event_parameters import private_parameters

MOST_DISJUNCTS = 3
"""Disjuncts of one event that assign constants; if there were more, a relation is used.

Measured: a counter is seven times faster as a relation, a choice of two or three is slower.
"""


@dataclass(frozen=True, eq=False, slots=True)
class Disjunct:
    """One disjunct of a transition relation.

    ``relation`` is over the state before the event and the new values of those variables that are
    not assigned constants. ``target`` are the constants. ``written`` is the cube of all written
    state variables, ``fixed`` that of those assigned constants, ``after`` that of the others' new
    values; ``forward`` and ``backward`` rename between these and the old ones. ``stays``: it writes
    nothing.
    """

    relation: Bdd
    target: Bdd
    written: Bdd
    fixed: Bdd
    after: Bdd
    forward: Renaming | None
    backward: Renaming | None
    stays: bool


@dataclass(frozen=True, eq=False, slots=True)
class EventRelation:
    """One event of the plant; ``number`` is its index in ``Plant.events``.

    ``possible`` is where it is possible with some parameter values, ``range_violation`` where a
    range is left with some; ``occurring`` is ``possible`` before the parameters are quantified.
    ``required`` is where the requirements allow it. ``variables`` are the state variables that it
    reads or writes, ``writes`` those that it writes.
    """

    number: int
    disjuncts: tuple[Disjunct, ...]
    possible: Bdd
    range_violation: Bdd
    occurring: Bdd
    required: Bdd
    variables: frozenset[int]
    writes: frozenset[int]


@dataclass(frozen=True, eq=False, slots=True)
class _Case:
    """One way to take part in an event, over state and parameters.

    ``constants`` are new values by state variable; ``moved`` are the state variables whose new
    values are part of ``relation``.
    """

    relation: Bdd
    constants: tuple[tuple[int, int], ...]
    moved: frozenset[int]


@dataclass(frozen=True, eq=False, slots=True)
class _LocalRelation:
    """A component's part in an event: its cases, where it is enabled, where no range is left."""

    cases: list[_Case]
    enabled: Bdd
    inside: Bdd


class Relations:
    """Builds the relations of a plant's events and computes with them."""

    def __init__(
        self, encoding: Encoding, most_disjuncts: int, check: Callable[[], None] = lambda: None
    ) -> None:
        """``check`` is called after each event; it may raise what ends the work."""
        self.encoding = encoding
        self.manager = encoding.manager
        self.most_disjuncts = most_disjuncts
        events = []
        for number in range(len(encoding.plant.events)):
            events.append(self._event(number))
            check()
        self.events = tuple(events)

    # --- images

    def image(self, disjunct: Disjunct, states: Bdd) -> Bdd:
        """Return the image of ``states`` under a disjunct."""
        manager = self.manager
        states_after = manager.and_exists(states, disjunct.relation, disjunct.written)
        if disjunct.forward is not None:
            states_after = manager.rename(states_after, disjunct.forward)
        return states_after & disjunct.target

    def preimage(self, disjunct: Disjunct, states: Bdd) -> Bdd:
        """Return the preimage of ``states`` under a disjunct."""
        manager = self.manager
        states_before = manager.and_exists(states, disjunct.target, disjunct.fixed)
        if disjunct.backward is None:
            return states_before & disjunct.relation
        states_before = manager.rename(states_before, disjunct.backward)
        return manager.and_exists(states_before, disjunct.relation, disjunct.after)

    # --- compilation

    def _event(self, number: int) -> EventRelation:
        encoding, manager = self.encoding, self.manager
        event = encoding.plant.events[number]
        parameters = encoding.parameters(number)
        start = encoding.valuations(number)
        constants: tuple[tuple[int, int], ...] = ()
        if event.phase is not None:
            phases = [encoding.value(event.phase.variable, s) for s in event.phase.sources]
            start = start & manager.union(phases)
            if event.phase.sources != (event.phase.target,):
                constants = ((event.phase.variable, event.phase.target),)
        cases = [_Case(start, constants, frozenset())]
        enabled = inside = start
        for automaton in event.automata:
            part = self._local_relation(automaton, number)
            enabled, inside = enabled & part.enabled, inside & part.inside
            cases = self._product(cases, part.cases)
        disjuncts = self._disjuncts(cases, encoding.now(parameters))
        occurring = enabled & inside
        return EventRelation(
            number=number,
            disjuncts=tuple(disjuncts),
            possible=manager.exists(occurring, encoding.now(parameters)),
            range_violation=manager.exists(enabled & ~inside, encoding.now(parameters)),
            occurring=occurring,
            required=encoding.holds(event.requirement or TRUE),
            variables=frozenset(event_support(encoding.plant, event)),
            writes=event.writes,
        )

    def _product(self, first: Sequence[_Case], second: Sequence[_Case]) -> list[_Case]:
        if len(first) * len(second) > self.most_disjuncts and len(second) > 1:
            second = [self._as_relation(second)]
        return [
            _Case(relation, one.constants + other.constants, one.moved | other.moved)
            for one in first
            for other in second
            if (relation := one.relation & other.relation) != self.manager.false
        ]

    def _local_relation(self, automaton: LocalAutomaton, event: int) -> _LocalRelation:
        encoding, manager = self.encoding, self.manager
        edges: dict[int, list[Edge]] = {}
        for edge in automaton.edges:
            edges.setdefault(edge.source, []).append(edge)
        cases: list[_Case] = []
        enabled: list[Bdd] = []
        outside: list[Bdd] = []
        for location in range(encoding.plant.variables[automaton.variable].size):
            left = encoding.value(automaton.variable, location)
            for edge in edges.get(location, ()):
                here = left
                if edge.guard is not None:
                    here = left & encoding.holds(edge.guard, event)
                left = left & ~here
                enabled.append(here)
                cases.extend(self._edge(edge, automaton.variable, here, event, outside))
            if not automaton.blocking:
                enabled.append(left)
                cases.append(_Case(left, (), frozenset()))
        everywhere = manager.union(enabled)
        return _LocalRelation(self._merge(cases), everywhere, everywhere & ~manager.union(outside))

    def _edge(
        self, edge: Edge, variable: int, here: Bdd, event: int, outside: list[Bdd]
    ) -> list[_Case]:
        """Return the cases of an edge, taken in ``here``; add range violations to ``outside``."""
        constants = ((variable, edge.target),) if edge.target != edge.source else ()
        cases = [_Case(here, constants, frozenset())]
        private = private_parameters(self.encoding.plant.events[event], edge)
        for written, partition in self._assigned(edge, event).items():
            values = self.encoding.plant.variables[written].values
            updates: list[_Case] = []
            own: list[LeafSource] = [(event, number) for number in private.get(written, ())]
            for value, states in partition:
                some = self._for_some(states, own)
                if value is None:
                    updates.append(_Case(some, (), frozenset()))
                elif value in values:
                    constant = (written, values.index(value))
                    updates.append(_Case(some, (constant,), frozenset()))
                else:
                    outside.append(here & states)
            cases = self._merge(self._product(cases, updates))
        return cases

    def _for_some(self, states: Bdd, parameters: Sequence[LeafSource]) -> Bdd:
        """Quantify parameters that nothing else depends on."""
        for parameter in parameters:
            states = states & self.encoding.all_values(parameter)
        return self.manager.exists(states, self.encoding.now(parameters)) if parameters else states

    def _assigned(self, edge: Edge, event: int) -> dict[int, Partition]:
        """Return the values that an edge assigns, by state variable.

        Of several assignments to one state variable the last defined one counts, but a value
        outside the range is an error in any of them, so it is kept.
        """
        assigned: dict[int, Partition] = {}
        for variable, expr in edge.updates:
            partition = self.encoding.partition(expr, event)
            if variable in assigned:
                values = self.encoding.plant.variables[variable].values
                partition = self._assigned_twice(assigned[variable], partition, values)
            assigned[variable] = partition
        return assigned

    def _assigned_twice(
        self, first: Partition, second: Partition, values: Sequence[Value]
    ) -> Partition:
        def assigned(value: Value | None, other: Value | None) -> Value | None:
            keep = other is None or (value is not None and value not in values)
            return value if keep else other

        return [
            (assigned(one, other), both)
            for one, states in first
            for other, others in second
            if (both := states & others) != self.manager.false
        ]

    def _merge(self, cases: Iterable[_Case]) -> list[_Case]:
        """Join cases with the same effect; drop those that never happen."""
        merged: dict[tuple[frozenset[tuple[int, int]], frozenset[int]], list[Bdd]] = {}
        for case in cases:
            # Of two assignments to one state variable the later one counts.
            constants = frozenset(dict(case.constants).items())
            merged.setdefault((constants, case.moved), []).append(case.relation)
        united = [(effect, self.manager.union(sets)) for effect, sets in merged.items()]
        return [
            _Case(states, tuple(sorted(constants)), moved)
            for (constants, moved), states in united
            if states != self.manager.false
        ]

    def _as_relation(self, cases: Sequence[_Case]) -> _Case:
        """Return one case for all, a relation with the new value of each written variable."""
        written = {variable for case in cases for variable, _ in case.constants}
        moved = written.union(*(case.moved for case in cases))
        relations = []
        for case in cases:
            relation = case.relation
            constants = dict(case.constants)
            for variable in sorted(moved - case.moved):
                if variable in constants:
                    relation = relation & self.encoding.value_after(variable, constants[variable])
                else:
                    relation = relation & self.encoding.unchanged(variable)
            relations.append(relation)
        return _Case(self.manager.union(relations), (), frozenset(moved))

    def _disjuncts(self, cases: Sequence[_Case], parameters: Bdd) -> list[Disjunct]:
        """Return the disjuncts over the state alone; join those that differ in constants only."""
        bare = [
            _Case(self.manager.exists(case.relation, parameters), case.constants, case.moved)
            for case in cases
        ]
        targets: dict[tuple[Bdd, tuple[int, ...], frozenset[int]], list[Bdd]] = {}
        for case in self._merge(bare):
            target = self.manager.true
            for variable, index in case.constants:
                target = target & self.encoding.value(variable, index)
            fixed = tuple(variable for variable, _ in case.constants)
            targets.setdefault((case.relation, fixed, case.moved), []).append(target)
        return [
            self._disjunct(relation, fixed, moved, self.manager.union(several))
            for (relation, fixed, moved), several in targets.items()
        ]

    def _disjunct(
        self, relation: Bdd, fixed: Sequence[int], moved: frozenset[int], target: Bdd
    ) -> Disjunct:
        encoding, manager = self.encoding, self.manager
        pairs = encoding.pairs(sorted(moved))
        return Disjunct(
            relation=relation,
            target=target,
            written=encoding.now([*fixed, *moved]),
            fixed=encoding.now(fixed),
            after=encoding.after(moved),
            forward=manager.renaming([(new, old) for old, new in pairs]) if pairs else None,
            backward=manager.renaming(pairs) if pairs else None,
            stays=not fixed and not moved,
        )
