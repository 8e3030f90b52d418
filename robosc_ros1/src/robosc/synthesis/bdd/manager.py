"""The BDD library of the symbolic engine, imported on demand and used within a memory limit.

The library is OxiDD (https://oxidd.net), an optional extra. It was chosen over CUDD (``dd``) by
measurement: twelve times faster on transfer lines, exact counts of any size, an error instead of
swapping when the nodes run out, and one wheel for every Python from 3.9 on all platforms.
Algorithms: Bryant, "Graph-based algorithms for Boolean function manipulation", IEEE Trans.
Computers 35(8), 1986.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import sysconfig
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeAlias, TypeVar

from robosc import limits
from robosc.errors import StateSpaceError
from robosc.synthesis.bdd.memory import budget, has_room
from robosc.synthesis.time_limit import lost_error

_BYTES_PER_NODE = 36  # measured at the peak, with the unique table
_BYTES_PER_CACHE_ENTRY = 24
_CACHE_ENTRIES = 2**21
# Small models would spend most of their time on allocating and clearing a large cache.
_CACHE_ENTRIES_PER_VARIABLE = 2**12
_FEWEST_NODES = 2**16
_AMPLE_NODES = 2**20
"""Nodes from which garbage is collected: 36 MB, and a moment's work."""
_PAUSES = (0.0, 0.001, 0.01, 0.1, 1.0)
"""Seconds before each look whether garbage was collected."""

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


def load() -> None:
    """Import the library, if there is one: that takes longer than a small synthesis."""
    if available():
        importlib.import_module("oxidd.bdd")
        importlib.import_module("oxidd.util")


def usable() -> bool:
    """Whether the library can be imported and there is memory for it."""
    return available() and has_room()


def install_hint(package: str = "oxidd") -> str:
    """Return the shell command that installs the package for the running Python."""
    python = sys.executable or "python3"
    options = "" if sys.prefix != sys.base_prefix else " --user"
    if options and Path(sysconfig.get_path("stdlib"), "EXTERNALLY-MANAGED").exists():
        # Debian's Python refuses pip without this (PEP 668), and has no package of the library.
        options += " --break-system-packages"
    hint = f"{python} -m pip install{options} {package}"
    if importlib.util.find_spec("pip") is None:
        hint = f"sudo apt install python3-pip && {hint}"
    return hint


def remedy() -> str:
    """Return how to make the symbolic engine usable, as the end of a message."""
    if available():
        return "or give the symbolic engine more memory (free memory, 'ulimit -v')"
    return f"or install the symbolic engine: {install_hint()}"


def _nothing() -> None:
    """Nothing is kept."""


class Manager:
    """The decision diagrams of one synthesis, over boolean variables in a fixed order.

    Nodes are limited to ``memory`` bytes, or to what the machine and ``ulimit -v`` leave of them.
    Operations raise MemoryError when they are used up.
    """

    def __init__(self, variables: int, memory: int = limits.MEMORY) -> None:
        if not available():
            raise StateSpaceError(
                f"the symbolic engine needs the Python package oxidd; type: {install_hint()}"
            )
        # Not typed: mypy must give the same result with and without the package.
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
        self._ample = min(self.capacity // 2, _AMPLE_NODES)
        self.in_use = 0
        """Nodes that were left when garbage was last collected."""
        self._collected = 0
        self.variables = variables
        self._and = util.BooleanOperator.AND
        self._function = bdd.BDDFunction
        self._manager = bdd.BDDManager(self.capacity, entries, 1)
        self._manager.add_vars(variables)
        self.true: Bdd = self._manager.true()
        self.false: Bdd = self._manager.false()
        self._literals: dict[tuple[int, bool], Bdd] = {}
        self._everything = self.cube(range(variables))

    def literal(self, variable: int, positive: bool) -> Bdd:
        literal = self._literals.get((variable, positive))
        if literal is None:
            make = self._manager.var if positive else self._manager.not_var
            literal = self._literals[variable, positive] = make(variable)
        return literal

    def cube(self, variables: Iterable[int]) -> Bdd:
        """Return the conjunction of variables, which represents the set to quantify over."""
        result = self.true
        for variable in sorted(variables, reverse=True):
            result = self.literal(variable, True) & result
        return result

    def union(self, sets: Iterable[Bdd]) -> Bdd:
        """Return the union of all, computed pairwise so that intermediate results stay small."""
        level = list(sets)
        while len(level) > 1:
            pairs = [a | b for a, b in zip(level[::2], level[1::2], strict=False)]
            level = pairs + level[len(pairs) * 2 :]
        return level[0] if level else self.false

    def disjoint(self, first: Bdd, second: Bdd) -> bool:
        """Whether two sets have nothing in common, without computing what they have."""
        return self.and_exists(first, second, self._everything) == self.false

    def exists(self, states: Any, cube: Bdd) -> Bdd:
        """Return a set with the variables of ``cube`` quantified existentially."""
        projected: Bdd = states.exists(cube)
        return projected

    def and_exists(self, first: Any, second: Bdd, cube: Bdd) -> Bdd:
        """Return the relational product: the conjunction with ``cube`` quantified existentially."""
        try:
            projected: Bdd = first.apply_exists(self._and, second, cube)
        except TypeError:
            # The library looks up the operator in Python, and loses what a signal raises there.
            raise lost_error() from None
        return projected

    def renaming(self, pairs: Sequence[tuple[int, int]]) -> Renaming:
        """Return the substitution of each first variable by the second."""
        return self._function.make_substitution(
            [(old, self.literal(new, True)) for old, new in pairs]
        )

    def rename(self, states: Any, renaming: Renaming) -> Bdd:
        renamed: Bdd = states.substitute(renaming)
        return renamed

    def count(self, states: Any, free: int) -> int:
        """Return the number of assignments, ignoring ``free`` variables that it does not read."""
        exact: int = states.sat_count(self.variables)
        return exact >> free

    def contains(self, states: Any, assignment: Sequence[tuple[int, bool]]) -> bool:
        """Whether a set holds for an assignment of all variables that it reads."""
        contained: bool = states.eval(assignment)
        return contained

    def pick(self, states: Any) -> Sequence[bool | None]:
        """Return one assignment of a set that is not empty; None where a variable may be either."""
        assignment: Sequence[bool | None] = states.pick_cube()
        return assignment

    def size(self, states: Any) -> int:
        """Return the number of nodes of a diagram."""
        nodes: int = states.node_count()
        return nodes

    @property
    def nodes(self) -> int:
        """Nodes in use, garbage included."""
        nodes: int = self._manager.approx_num_inner_nodes()
        return nodes

    @property
    def made(self) -> int:
        """Nodes made so far, a measure of the work done."""
        return self.nodes + self._collected

    def make_room(self, forget: Callable[[], None] = _nothing) -> None:
        """Collect garbage where it may be worth it: there are twice the nodes of the last time.

        Where more than half of all that there can be are in use, ``forget`` is called first: it
        gives up what is kept to save time.
        """
        if self.nodes >= self._ample:
            self.collect_garbage()
            if self.in_use > self.capacity // 2:
                forget()
                self.collect_garbage()

    def collect_garbage(self) -> None:
        before = self.nodes
        self._manager.gc()
        self.in_use = self.nodes
        self._collected += before - self.in_use
        self._ample = min(max(_AMPLE_NODES, 2 * self.in_use), (self.in_use + self.capacity) // 2)

    def run(
        self, operation: Callable[[], _Result], forget: Callable[[], None] = _nothing
    ) -> _Result:
        """Return an operation's result; on MemoryError try once more after garbage collection.

        ``forget`` gives up what is kept to save time.
        """
        self.make_room(forget)
        try:
            return operation()
        except MemoryError:
            pass  # no longer handled below: its traceback keeps what the operation has computed
        forget()
        self._await_collection()
        return operation()

    def _await_collection(self) -> None:
        """Collect garbage, also where the library is about to do so in its own thread.

        Then ``gc`` does nothing and returns 0, and operations fail until that was done (0.13.0; see
        findings/oxidd_garbage.sh).
        """
        before = self.nodes
        for pause in _PAUSES:
            time.sleep(pause)
            self.collect_garbage()
            if self.in_use < before:
                break
