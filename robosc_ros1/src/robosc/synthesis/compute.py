"""Synthesis of a plant: choose the engine, solve independent parts, build the supervisor."""

from __future__ import annotations

import gc
import math
from collections.abc import Callable, Collection, Sequence
from math import prod

from robosc import limits
from robosc.errors import OUT_OF_MEMORY, StateSpaceError
from robosc.plant.automaton import Plant, PlantState
from robosc.progress import Progress
from robosc.supervisor import Supervisor
from robosc.synthesis.bdd.manager import remedy, usable
from robosc.synthesis.decomposition import combined, independent_parts
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.explain.conflicts import Identity, with_conflicts
from robosc.synthesis.explicit.explicit_engine import Limit, ManyGuarded, TooMany
from robosc.synthesis.explicit.synthesize import ExplicitSynthesis, enabled_commands
from robosc.synthesis.formatting import contributors
from robosc.synthesis.result import Solved
from robosc.synthesis.time_limit import ExplanationTime

_FEW_STATES = 100_000
"""States up to which the explicit engine is the faster one, as measured."""
_MOST_STEPS = 600_000
"""Steps, about half a second: the same where states have many, if the end is not near."""
_NEAR_THE_END = 0.1
"""Share of the states found that are not left yet, below which the end is near: zones 12 15."""
_FEW_STEPS = 50_000
"""The same before the symbolic engine has had its first turn: conveyor 60."""
_FEW_VALUES_READ = 10**6
"""The same as steps times variables, for states of many variables take longer: broad 300."""
_FEW_NODES = 2**17
"""Nodes, about a fifth of a second, of the symbolic engine's first turn: zones 8 11."""
_FEW_GUARDED, _MOST_GUARDED = 2**9, 2**13
"""States up to which the explicit engine keeps its turn where synthesis restricts commands:
minimising guards takes most of its time then. cluster_tool 5."""
_FEW_VALUES = 10_000
"""Combinations of one event's parameter values up to which the explicit engine is tried."""
_GROWING = 0.5
"""Share of the states found that are not left yet, above which very many are to be expected."""
_FIRST_STEPS = 20_000
"""Steps after which this is looked at."""
_WHOLE = 2**12
"""Product size up to which a plant is not decomposed."""
_KEPT_NODES = 2**22
"""Nodes of parts, some 150 MB, that are kept until all parts are solved."""
_TOGETHER = 2**6
"""Product size up to which small parts are solved together, as measured."""


def synthesize(
    plant: Plant,
    engine: str = "auto",
    max_states: int | None = None,
    progress: Progress | None = None,
    explain_seconds: float | None = None,
    solved: Callable[[Supervisor], None] | None = None,
) -> Supervisor:
    """Return the maximally permissive, safe, controllable and nonblocking supervisor of a plant.

    ``engine`` is ``auto``, ``explicit`` (also called ``dense``) or ``bdd``. ``max_states`` bounds
    how many states the explicit engine visits, of each independent part
    (None: ``limits.EXPLICIT_STATES``). ``explain_seconds`` of processor time may be spent on
    explanations (None: about as long as synthesis takes); before, ``solved`` is called with the
    supervisor as it is without them. An empty supervisor is a result, not an error.

    Raises:
        StateSpaceError: there are more states, and no other engine may be used.
    """
    most = max_states or limits.EXPLICIT_STATES
    explaining = ExplanationTime(explain_seconds)
    parts = [plant]
    if prod(variable.size for variable in plant.variables) > _WHOLE:
        parts = independent_parts(plant, _TOGETHER)
    found = _Parts()
    for part in parts:
        found.make_room()
        found.add(_synthesize(part, engine, most, progress, explaining))
    if solved is not None:
        solved(found.supervisor(plant))
    supervisor = found.explained(plant)
    if not all(map(_is_quick, parts)):
        return supervisor
    try:
        return with_conflicts(supervisor, found.plant_states, _allowed)
    except TooMany:
        return supervisor


class _Parts:
    """Independent parts that are solved, and explained once all of them are.

    Diagrams are kept until then; where they are many, parts are explained before others are solved.
    """

    def __init__(self) -> None:
        self._parts: list[Supervisor | Solved] = []

    def add(self, part: Solved) -> None:
        self._parts.append(part)

    def make_room(self) -> None:
        """Give up the diagrams of the parts so far if they are many."""
        if sum(part.nodes for part in self._parts if isinstance(part, Solved)) > _KEPT_NODES:
            self._explain()
            gc.collect()

    def supervisor(self, plant: Plant) -> Supervisor:
        """Return the supervisor of the plant as far as it is explained."""
        parts = self._each
        return parts[0] if len(parts) == 1 else combined(plant, parts)

    def explained(self, plant: Plant) -> Supervisor:
        """Return the supervisor of the plant, all of it explained."""
        self._explain()
        return self.supervisor(plant)

    @property
    def plant_states(self) -> int:
        """The states of all plants of parts together."""
        return sum(part.plant_states for part in self._each)

    @property
    def _each(self) -> list[Supervisor]:
        return [part.supervisor if isinstance(part, Solved) else part for part in self._parts]

    def _explain(self) -> None:
        self._parts = [
            part.explained() if isinstance(part, Solved) else part for part in self._parts
        ]


def _is_quick(part: Plant) -> bool:
    """Whether the explicit engine solves a part so fast that it may do so several times."""
    small = prod(variable.size for variable in part.variables) <= limits.CONFLICT_PRODUCT
    return small and max(map(weight, part.events), default=0) <= _FEW_VALUES


def _allowed(part: Plant) -> Collection[Identity] | None:
    """Return the commands that the supervisor of a small part allows; None if it is empty."""
    found = enabled_commands(part, _limit(part, _FEW_STATES, doubting=True))
    return None if found is None else {event.identity for event in found}


def _synthesize(
    plant: Plant,
    engine: str,
    max_states: int,
    progress: Progress | None,
    explaining: ExplanationTime,
) -> Solved:
    """Return the supervisor of a plant, without decomposition."""
    if engine == "bdd":
        return _symbolic(plant, progress, explaining)
    either = engine == "auto" and usable()
    if either and max(map(weight, plant.events), default=0) <= _FEW_VALUES:
        return _by_turns(plant, max_states, progress, explaining)
    if either:
        return _symbolic(plant, progress, explaining)
    advice = f"; {remedy()}" if engine == "auto" else ""
    limit = _limit(plant, max_states, progress, advice=advice)
    try:
        return ExplicitSynthesis(plant, progress, explaining).run(limit)
    except MemoryError:
        raise StateSpaceError(OUT_OF_MEMORY + advice) from None


def _by_turns(
    plant: Plant, max_states: int, progress: Progress | None, explaining: ExplanationTime
) -> Solved:
    """Return the supervisor of a plant by the first engine that is quick, each tried for a short
    time first: no rule known tells which one it is. Both go on where their turn ended."""
    most = min(max_states, _FEW_STATES)
    explicit = ExplicitSynthesis(plant, progress, explaining)
    try:
        steps = min(_FEW_STEPS, _FEW_VALUES_READ // max(1, len(plant.variables)))
        return explicit.run(_limit(plant, most, progress, steps=steps), _FEW_GUARDED)
    except TooMany:
        pass

    def again() -> Sequence[PlantState] | None:
        try:
            limit = _limit(plant, most, progress, doubting=True)
            raise _Answer(explicit.run(limit, _MOST_GUARDED))
        except ManyGuarded as fault:
            return fault.states
        except TooMany:
            return None

    try:
        return _symbolic(plant, progress, explaining, again)
    except _Answer as answer:
        return answer.solved


class _Answer(Exception):
    """What ends the symbolic engine: the other one was quicker."""

    def __init__(self, solved: Solved) -> None:
        super().__init__()
        self.solved = solved


def _symbolic(
    plant: Plant,
    progress: Progress | None,
    explaining: ExplanationTime,
    other: Callable[[], Sequence[PlantState] | None] | None = None,
) -> Solved:
    """``other`` is called where it takes longer than a first turn."""
    from robosc.synthesis.bdd.symbolic_engine import Turn
    from robosc.synthesis.bdd.synthesize import synthesize_bdd

    turn = None if other is None else Turn(_FEW_NODES, other)
    return synthesize_bdd(plant, progress, explaining=explaining, turn=turn)


def _limit(
    plant: Plant,
    most: int,
    progress: Progress | None = None,
    doubting: bool = False,
    advice: str = "",
    steps: float = math.inf,
) -> Limit:
    """Return what ends the explicit engine's search: there are more states than ``most``.

    ``doubting``: or so many are to be expected; or it takes more than ``steps``.
    """
    most_steps = steps

    def limit(found: int, left: int, steps: int) -> None:
        if progress is not None:
            progress("reachable states", found, most)
        growing = steps > _FIRST_STEPS and left > _GROWING * found
        long = steps > _MOST_STEPS and left > _NEAR_THE_END * found
        if found > most or steps > most_steps or (doubting and (growing or long)):
            raise _too_many(plant, most, advice)
        if steps > max(limits.EXPLICIT_STEPS, limits.EXPLICIT_VALUES * (found - left)):
            raise TooMany(
                f"there are more than {limits.EXPLICIT_STEPS} steps from state to state."
                f" {_contributors(plant)}: narrow their ranges, or convert them by an enum{advice}"
            )

    return limit


def _contributors(plant: Plant) -> str:
    names = contributors((variable.name, variable.size) for variable in plant.variables)
    return f"The largest contributors are {names}"


def _too_many(plant: Plant, most: int, advice: str) -> TooMany:
    """Return the error that names the largest variables and how to reduce the states."""
    return TooMany(
        f"there are more than {most} states, as many as are allowed. {_contributors(plant)}: narrow"
        f" their ranges, drop variables that no condition needs, or raise --max-states{advice}"
    )
