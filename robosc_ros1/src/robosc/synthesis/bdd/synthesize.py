"""Synthesis with the symbolic engine; the supervisor is the same as the explicit engine's."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable
from functools import partial
from typing import TypeAlias

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.expr.tree import TRUE
from robosc.plant.automaton import Plant
from robosc.plant.logic import conjunction
from robosc.progress import Progress
from robosc.supervisor import Guard
from robosc.synthesis.bdd.care_set import BddCareSet, wide_condition
from robosc.synthesis.bdd.manager import Bdd, load
from robosc.synthesis.bdd.relations import EventRelation
from robosc.synthesis.bdd.search import SymbolicSystem
from robosc.synthesis.bdd.symbolic_engine import (
    SymbolicEngine,
    SymbolicSolution,
    TooManyNodes,
    Turn,
)
from robosc.synthesis.formatting import contributors
from robosc.synthesis.guards.shorten import GuardInputs, GuardMaker
from robosc.synthesis.guards.sum_of_products import TooLarge
from robosc.synthesis.result import Sizes, Solved
from robosc.synthesis.time_limit import ExplanationTime

_MANY_NODES = 2**18
"""Nodes in use, after a second of work, with which the other direction of the order is tried."""
_FAR = 3
"""Times the nodes that one direction makes for what the plant reaches, above which it is the wrong
one: 3.4 in lift 8 8, 160 in elevators 4 10. Twice as many say nothing: cell 16 12."""
_SLOW_START = 2**14
"""Nodes so made, after some hundredths of a second, with which the other direction is looked at."""

_Make: TypeAlias = Callable[..., SymbolicEngine]


def synthesize_bdd(
    plant: Plant,
    progress: Progress | None = None,
    memory: int = limits.MEMORY,
    explaining: ExplanationTime | None = None,
    turn: Turn | None = None,
) -> Solved:
    """Return the supervisor of a plant; an empty one is a result, not an error.

    Raises:
        StateSpaceError: the library is missing, or ``memory`` bytes do not suffice.
    """
    load()
    start = time.perf_counter()
    try:
        solution = _solved(plant, progress, memory, turn)
        guards = []
        transitions = 0
        maker = GuardMaker(plant)
        for event in solution.engine.events:
            if progress is not None:
                progress("guards", event.number, len(plant.events))
            if not plant.events[event.number].controllable:
                transitions += solution.occurrences(event)
            elif not solution.empty:
                enabled = solution.enabled(event)
                guards.append(_guard(solution, event, enabled, maker))
                transitions += solution.occurrences(event, enabled)
        seconds = time.perf_counter() - start
        states = solution.controlled_states
        sizes = Sizes(solution.plant_states, states, transitions)
        system = SymbolicSystem(solution, guards, time=explaining)
        turned = solution.engine.opposite_order
        return Solved(system, "bdd", seconds, sizes, tuple(guards), progress, turned)
    except MemoryError:
        raise _too_large(plant, memory) from None


def _solved(
    plant: Plant, progress: Progress | None, memory: int, turn: Turn | None
) -> SymbolicSolution:
    """Return the controlled system, found in another way if the first is slow.

    One direction of the order of variables can take a hundred times the nodes of the other, and no
    rule known tells which from the plant; but what it reaches, which is quick, most often takes far
    more nodes too. Robots in zones of which each holds one end only if what all requirements forbid
    is never computed.
    """
    make = partial(SymbolicEngine, plant, progress, memory, most_nodes=_MANY_NODES, turn=turn)
    turned, together, most = False, False, math.inf
    for invariants_first in (False, True) if plant.invariants else (False,):
        for second in (False, True):
            try:
                reverse = turned != second
                engine = _begun(make, most, reverse=reverse, invariants_first=invariants_first)
                if most == math.inf:
                    engine = _far_quicker(engine, make)
                    turned, together = engine.opposite_order, engine.together
                    make = partial(make, together=together)
                    most = _FAR * engine.manager.made
                return engine.solve(None if turn is None else turn.found)
            except (TooManyNodes, MemoryError):
                engine = None
            gc.collect()  # frees the diagrams before there are others
    return SymbolicEngine(plant, progress, memory, reverse=turned, together=together).solve()


def _begun(make: _Make, most_made: float, **options: bool) -> SymbolicEngine:
    """Return an engine that knows what the plant reaches, for which it makes so many nodes at most.

    Raises:
        TooManyNodes: that takes more.
    """
    engine = make(most_made=most_made, **options)
    engine.begin()
    return engine


def _far_quicker(engine: SymbolicEngine, make: _Make) -> SymbolicEngine:
    """Return an engine, or one of another order if that has begun with far fewer nodes: one that
    does not tear components apart (chargers 12 3), the other direction, or both."""
    options: dict[str, bool] = {}
    for other in ("together", "reverse"):
        made = engine.manager.made
        if made < _SLOW_START or engine.opposite_order:
            break
        try:
            engine = _begun(make, made / _FAR, **options, **{other: True})
        except (TooManyNodes, MemoryError, StateSpaceError):  # there may be no memory for both
            continue
        options[other] = True
    return engine


def _guard(
    solution: SymbolicSolution, relation: EventRelation, enabled: Bdd, maker: GuardMaker
) -> Guard:
    plant = solution.engine.plant
    event = plant.events[relation.number]
    requirement = event.requirement or TRUE
    encoding = solution.engine.encoding
    encoding.manager.make_room()
    possible = solution.possible(relation)
    required = possible & relation.required
    variables = tuple(range(len(plant.variables)))
    care_set = partial(BddCareSet, encoding, variables, enabled)
    inputs = GuardInputs(
        is_never=enabled == encoding.manager.false,
        is_as_required=enabled == required,
        within_requirement=lambda: care_set(required & ~enabled),
        within_plant=lambda: care_set(possible & ~enabled),
    )
    try:
        return maker.guard(event, inputs)
    except TooLarge:
        extra = wide_condition(care_set(required & ~enabled))
        return Guard(event, conjunction([requirement, extra]), requirement, "restricted")


def _too_large(plant: Plant, memory: int) -> StateSpaceError:
    names = contributors((variable.name, variable.size) for variable in plant.variables)
    return StateSpaceError(
        f"the symbolic engine ran out of the {memory // 2**20} MB that it may use. The largest"
        f" contributors are {names}: narrow their ranges, or drop variables that no condition needs"
    )
