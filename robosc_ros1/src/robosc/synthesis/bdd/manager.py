"""Decision diagrams: the library behind the symbolic engine, found late and kept within a limit.

The library is OxiDD (https://oxidd.net), an optional extra. It was chosen over CUDD (``dd``) by
measurement: twelve times faster on transfer lines, exact counts of any size, an error instead of a
full machine when the nodes run out, and one wheel for every Python from 3.9 on all platforms.
Methods and algorithms: Bryant, "Graph-based algorithms for Boolean function manipulation", IEEE
Trans. Computers 35(8), 1986.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import sysconfig
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeAlias, TypeVar

from robosc.errors import StateSpaceError
from robosc.synthesis.bdd.memory import DEFAULT_MEMORY, budget, has_room

__all__ = ["Manager", "Bdd", "available", "install_hint", "remedy", "usable"]

_BYTES_PER_NODE = 36  # measured, with the unique table, at the worst moment of its iterates
_BYTES_PER_CACHE_ENTRY = 24
_CACHE_ENTRIES = 2**21
# Of small models most of the time would go by in making and emptying a large cache.
_CACHE_ENTRIES_PER_VARIABLE = 2**14
_FEWEST_NODES = 2**16

_Result = TypeVar("_Result")


class Bdd(Protocol):
    """A set of states: a boolean function. Equal sets are equal objects, and hash alike."""

    def __and__(self, other: Bdd, /) -> Bdd: ...

    def __or__(self, other: Bdd, /) -> Bdd: ...

    def __xor__(self, other: Bdd, /) -> Bdd: ...

    def __invert__(self) -> Bdd: ...

    def __hash__(self) -> int: ...

    def __eq__(self, other: object, /) -> bool: ...


Renaming: TypeAlias = Any
"""A substitution of variables for others, prepared by :meth:`Manager.renaming`."""


def available() -> bool:
    """Whether the library can be imported."""
    return importlib.util.find_spec("oxidd") is not None


def usable() -> bool:
    """Whether the library can be imported, and there is memory for it."""
    return available() and has_room()


def install_hint(package: str = "oxidd") -> str:
    """What to type so that the library is found by the Python that runs now."""
    python = sys.executable or "python3"
    options = "" if sys.prefix != sys.base_prefix else " --user"
    if options and Path(sysconfig.get_path("stdlib"), "EXTERNALLY-MANAGED").exists():
        # Debian's own Python wants to be asked twice (PEP 668); there is no package of it.
        options += " --break-system-packages"
    hint = f"{python} -m pip install{options} {package}"
    if importlib.util.find_spec("pip") is None:
        hint = f"sudo apt install python3-pip && {hint}"
    return hint


def remedy() -> str:
    """What to do so that the symbolic engine can be used."""
    if available():
        return "or give the symbolic engine more memory (free memory, 'ulimit -v')"
    return f"or install the symbolic engine: {install_hint()}"


class Manager:
    """The decision diagrams of one synthesis, over boolean variables in a fixed order.

    Operations raise MemoryError when the nodes that fit into ``memory`` bytes, or into what the
    machine and ``ulimit -v`` leave of them, are used up; nothing is allocated beyond that.
    """

    def __init__(self, variables: int, memory: int = DEFAULT_MEMORY) -> None:
        if not available():
            raise StateSpaceError(
                f"the symbolic engine needs the Python package oxidd; type: {install_hint()}"
            )
        # Not typed: the types would be there or not with the package, and so would mypy's opinion.
        bdd: Any = importlib.import_module("oxidd.bdd")
        util: Any = importlib.import_module("oxidd.util")
        memory = budget(memory)
        entries = min(
            _CACHE_ENTRIES,
            max(2**12, memory // 8 // _BYTES_PER_CACHE_ENTRY),
            variables * _CACHE_ENTRIES_PER_VARIABLE,
        )
        rest = memory - entries * _BYTES_PER_CACHE_ENTRY
        self.capacity = max(_FEWEST_NODES, rest // _BYTES_PER_NODE)
        self.variables = variables
        self._and = util.BooleanOperator.AND
        self._function = bdd.BDDFunction
        self._manager = bdd.BDDManager(self.capacity, entries, 1)
        self._manager.add_vars(variables)
        self.true: Bdd = self._manager.true()
        self.false: Bdd = self._manager.false()
        self._literals: dict[tuple[int, bool], Bdd] = {}

    def literal(self, variable: int, positive: bool) -> Bdd:
        found = self._literals.get((variable, positive))
        if found is None:
            make = self._manager.var if positive else self._manager.not_var
            found = self._literals[variable, positive] = make(variable)
        return found

    def cube(self, variables: Iterable[int]) -> Bdd:
        """The conjunction of variables, which names them as a set to quantify over."""
        result = self.true
        for variable in sorted(variables, reverse=True):
            result = self.literal(variable, True) & result
        return result

    def union(self, sets: Iterable[Bdd]) -> Bdd:
        """All of them, pairwise, so that intermediate results stay small."""
        level = list(sets)
        while len(level) > 1:
            pairs = [a | b for a, b in zip(level[::2], level[1::2], strict=False)]
            level = pairs + level[len(pairs) * 2 :]
        return level[0] if level else self.false

    def exists(self, states: Any, cube: Bdd) -> Bdd:
        found: Bdd = states.exists(cube)
        return found

    def and_exists(self, first: Any, second: Bdd, cube: Bdd) -> Bdd:
        """The conjunction, with the variables of ``cube`` quantified away on the way."""
        found: Bdd = first.apply_exists(self._and, second, cube)
        return found

    def renaming(self, pairs: Sequence[tuple[int, int]]) -> Renaming:
        """Each first variable becomes the second one."""
        return self._function.make_substitution(
            [(old, self.literal(new, True)) for old, new in pairs]
        )

    def rename(self, states: Any, renaming: Renaming) -> Bdd:
        found: Bdd = states.substitute(renaming)
        return found

    def count(self, states: Any, free: int) -> int:
        """How many assignments of all variables but ``free`` ones, which it does not read."""
        exact: int = states.sat_count(self.variables)
        return exact >> free

    def contains(self, states: Any, assignment: Sequence[tuple[int, bool]]) -> bool:
        """Whether a set holds for an assignment of all variables that it reads."""
        found: bool = states.eval(assignment)
        return found

    def pick(self, states: Any) -> Sequence[bool | None]:
        """One assignment of a set that is not empty; None where a variable may be either."""
        found: Sequence[bool | None] = states.pick_cube()
        return found

    def size(self, states: Any) -> int:
        found: int = states.node_count()
        return found

    @property
    def nodes(self) -> int:
        """Nodes in use, those not collected yet included."""
        found: int = self._manager.approx_num_inner_nodes()
        return found

    def collect_garbage(self) -> None:
        """Collect garbage if there may be much."""
        if self.nodes > self.capacity // 2:
            self._manager.gc()

    def collect(self) -> None:
        """Collect garbage now."""
        self._manager.gc()

    def run(self, operation: Callable[[], _Result]) -> _Result:
        """An operation, a second time after collecting garbage if the nodes ran out."""
        self.collect_garbage()
        try:
            return operation()
        except MemoryError:
            self._manager.gc()
            return operation()
