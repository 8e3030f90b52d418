"""Synthesis of a plant: choose the engine, solve independent parts, build the supervisor."""

from __future__ import annotations

import gc
import time
from collections.abc import Collection, Iterator
from functools import partial
from math import prod

from robosc import limits
from robosc.errors import StateSpaceError, listing
from robosc.expr.tree import Binary, Call, Expr, Unary
from robosc.plant.automaton import Plant
from robosc.plant.event_values import values_read
from robosc.plant.support import support
from robosc.progress import Progress
from robosc.supervisor import Guard, Supervisor
from robosc.synthesis.bdd.arithmetic import is_linear
from robosc.synthesis.bdd.manager import remedy, usable
from robosc.synthesis.decomposition import combined, independent_parts
from robosc.synthesis.dense.bitset import count
from robosc.synthesis.dense.dense_engine import DenseEngine, DenseSolution
from robosc.synthesis.dense.layout import Layout
from robosc.synthesis.dense.projection import projected_layout
from robosc.synthesis.dense.search import DenseSystem
from robosc.synthesis.dense.transitions import Compiler
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.explain.conflicts import Identity, with_conflicts
from robosc.synthesis.formatting import amount, contributors
from robosc.synthesis.guards.shorten import GuardInputs, make_guard
from robosc.synthesis.result import Sizes, make_supervisor
from robosc.synthesis.time_limit import ExplanationTime

_DENSE = 2**16
"""Product sizes above which the symbolic engine is usually faster, as measured."""
_DENSE_GUARDS = 2**12
"""The same where synthesis restricts commands: minimising guards takes most of the time then."""
_DENSE_BY_VALUES = 2**24
"""Product sizes above which the symbolic engine is faster even with nonlinear expressions."""
_DENSE_PAIRS = 10_000
"""Combinations of one event's parameter values above which the symbolic engine is faster."""
_MOST_VALUES = 2**14
"""Combinations per nonlinear expression above which the symbolic engine is slower."""
_SMALL = 2**12
"""Product size up to which dependent state variables are not projected."""
_WHOLE = 2**12
"""Product size up to which a plant is not decomposed."""
_TOGETHER = {"dense": 2**6, "bdd": 2**60}
"""Per engine, the product size up to which small parts are solved together, as measured."""


def synthesize(
    plant: Plant,
    engine: str = "auto",
    max_states: int | None = None,
    progress: Progress | None = None,
    explain_seconds: float | None = None,
) -> Supervisor:
    """Return the maximally permissive, safe, controllable and nonblocking supervisor of a plant.

    ``engine`` is ``auto``, ``dense`` or ``bdd``. ``max_states`` bounds the size of the dense
    engine's state array, for each independent part separately and after projection of dependent
    state variables. ``explain_seconds`` of processor time may be spent on explanations (None: about
    as long as synthesis takes). An empty supervisor is a result, not an error.

    Raises:
        StateSpaceError: the array is larger than ``max_states``, and no other engine may be used.
    """
    parts = [plant]
    if prod(variable.size for variable in plant.variables) > _WHOLE:
        symbolic = engine == "bdd" or (engine == "auto" and usable())
        parts = independent_parts(plant, _TOGETHER["bdd" if symbolic else "dense"])
    max_states = max_states or limits.DENSE_STATES
    explaining = ExplanationTime(explain_seconds)
    found = []
    try:
        for part in parts:
            found.append(_synthesize(part, engine, max_states, progress, explaining))
            if found[-1].engine == "bdd" and part is not plant:
                gc.collect()  # frees the diagrams of this part before the next is solved
                gc.freeze()  # later collections skip what survived
    finally:
        if len(parts) > 1:
            gc.unfreeze()
    supervisor = found[0] if len(found) == 1 else combined(plant, found)
    if not all(map(_is_quick, parts)):
        return supervisor
    return with_conflicts(supervisor, sum(part.plant_states for part in found), _allowed)


def _is_quick(part: Plant) -> bool:
    """Whether the dense engine solves a part so fast that it may do so several times."""
    small = prod(variable.size for variable in part.variables) <= limits.CONFLICT_PRODUCT
    few = max(map(weight, part.events), default=0) <= _DENSE_PAIRS
    return small and few and not _crowded(part, _DENSE)


def _allowed(part: Plant) -> Collection[Identity] | None:
    """Return the commands that the supervisor of a small part allows; None if it is empty."""
    compiler = Compiler(part)
    rules = [compiler.event(event) for event in part.events]
    engine = DenseEngine(compiler, rules, Layout.plain(part))
    found = engine.solve()
    if found.empty:
        return None
    return {
        step.event.identity
        for step in engine.steps
        if step.event.controllable and engine.enabled(step, found.states)
    }


def _synthesize(
    plant: Plant,
    engine: str,
    max_states: int,
    progress: Progress | None,
    explaining: ExplanationTime,
) -> Supervisor:
    """Return the supervisor of a plant, without decomposition."""
    if engine == "bdd":
        return _symbolic(plant, progress, explaining)
    either = engine == "auto" and usable()
    if either and favours_symbolic(plant):
        return _symbolic(plant, progress, explaining)
    if crowded := _crowded(plant, limits.DENSE_PAIRS):
        if either:
            return _symbolic(plant, progress, explaining)
        raise StateSpaceError(f"{crowded}: narrow the ranges, or convert the values by an enum")
    start = time.perf_counter()
    compiler = Compiler(plant)
    rules = [compiler.event(event) for event in plant.events]
    layout = Layout.plain(plant)
    if layout.size > min(_SMALL, max_states):
        layout = projected_layout(plant, rules)
    if layout.size > max_states:
        if either:
            return _symbolic(plant, progress, explaining)
        raise _too_large(layout, max_states, engine)
    dense = DenseEngine(compiler, rules, layout, progress)
    solution = dense.solve()
    if either and solution.restricted and layout.size > _DENSE_GUARDS:
        return _symbolic(plant, progress, explaining)
    guards: tuple[Guard, ...]
    if solution.empty:
        guards, sizes = (), Sizes(dense.plant_states, 0, 0)
    else:
        guards, transitions = _measure(plant, dense, solution, progress)
        states = count(solution.states)
        sizes = Sizes(dense.plant_states, states, transitions)
    seconds = time.perf_counter() - start
    system = DenseSystem(solution, explaining)
    return make_supervisor(system, "dense", seconds, sizes, guards, progress)


def favours_symbolic(plant: Plant) -> bool:
    """Whether the symbolic engine is expected to be faster.

    The dense engine's time is proportional to the size of the product, and to the pairs of incoming
    and stored values. The symbolic engine's hardly depends on these, but it enumerates the operand
    values of nonlinear expressions.
    """
    size = prod(variable.size for variable in plant.variables)
    if size > _DENSE_BY_VALUES:
        return True
    if max(map(partial(_pairs, plant), _expressions(plant)), default=0) > _MOST_VALUES:
        return False
    combinations = max(map(weight, plant.events), default=0)
    return size > _DENSE or combinations > _DENSE_PAIRS or bool(_crowded(plant, _DENSE))


def _expressions(plant: Plant) -> Iterator[Expr]:
    yield from (condition for condition, _ in plant.invariants)
    for event in plant.events:
        if event.requirement is not None:
            yield event.requirement
        for automaton in event.automata:
            yield from automaton.expressions


def _pairs(plant: Plant, expr: Expr) -> int:
    """Return how many combinations of values the symbolic engine enumerates for an expression."""
    if not isinstance(expr, Unary | Binary | Call):
        return 0
    if len(expr.operands) == 1 or expr.operation.is_lazy:
        return max(_pairs(plant, operand) for operand in expr.operands)
    if expr.operation.is_comparison and all(map(is_linear, expr.operands)):
        return 0
    variables = support(plant, expr)
    return prod(plant.sizes(variables)) if len(variables) > 1 else 0


def _symbolic(plant: Plant, progress: Progress | None, explaining: ExplanationTime) -> Supervisor:
    # Imported on demand: the dense engine does without it.
    from robosc.synthesis.bdd.synthesize import synthesize_bdd

    return synthesize_bdd(plant, progress, explaining=explaining)


def _measure(
    plant: Plant, dense: DenseEngine, solution: DenseSolution, progress: Progress | None
) -> tuple[tuple[Guard, ...], int]:
    guards: list[Guard] = []
    transitions = 0
    states = solution.states
    for number, step in enumerate(dense.steps):
        if progress is not None:
            progress("guards", number, len(dense.steps))
        if not step.event.controllable:
            transitions += dense.occurrences(step, states)
            continue
        required = dense.required(step, states)
        enabled = dense.enabled(step, states) if solution.restricted else required
        transitions += enabled * step.rules.weight
        inputs = GuardInputs(
            required,
            enabled,
            partial(dense.care_set, step, states, True),
            partial(dense.care_set, step, states, False),
        )
        guards.append(make_guard(plant, step.event, inputs))
    return tuple(guards), transitions


def _crowded(plant: Plant, most: int) -> str | None:
    """Return which assignment has over ``most`` pairs of incoming and stored values, or None."""
    for event in plant.events:
        values = {parameter.path: len(parameter.values) for parameter in event.parameters}
        for automaton in event.automata:
            for variable, expr in {u for edge in automaton.edges for u in edge.updates}:
                taken = prod(values[path] for path in values_read([expr]))
                if taken * plant.variables[variable].size > most:
                    name, size = plant.variables[variable].name, plant.variables[variable].size
                    return (
                        f"the dense engine would have to combine {taken} values of {event.name}"
                        f" with the {size} of {name}"
                    )
    return None


def _too_large(layout: Layout, max_states: int, engine: str) -> StateSpaceError:
    """Return the error that names the largest dimensions of the product and how to reduce it."""
    variables = layout.plant.variables
    names = contributors(
        (listing([variables[variable].name for variable in dim.variables], "with"), dim.size)
        for dim in layout.dims
        if dim.size > 1
    )
    advice = "narrow their ranges, drop variables that no condition needs, or raise --max-states"
    if engine == "auto":
        advice += f"; {remedy()}"
    return StateSpaceError(
        f"the state space has {amount(layout.size)} combinations, more than the {max_states}"
        f" allowed. The largest contributors are {names}: {advice}"
    )
