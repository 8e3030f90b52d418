"""Names for common parts of long guards, so that people can read them.

A guard is a tree of chains of ``and`` and ``or``. Operands that several chains with the same
operator share become a named *part*. The part that saves most text is chosen first, its name
replaces the operands, and the search is repeated, so that parts may contain other parts. This is
common-cube extraction of multi-level logic minimisation (Brayton, Rudell, Sangiovanni-Vincentelli,
Wang, "MIS: a multiple-level logic optimization system", IEEE Trans. CAD 6(6), 1987), with the
length of the text as the cost. Only the text changes: replacing each name by its part, in
parentheses, gives the guard again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, combinations, count, product
from operator import itemgetter
from string import ascii_lowercase
from typing import NamedTuple

from robosc.expr import identity_cache, tree, types
from robosc.expr.traversal import operands, walk
from robosc.model.entities import Robot
from robosc.plant import counting, logic
from robosc.plant.model_text import to_dsl

LONG = 200
"""Guards of more characters are shown with named parts."""

_MOST_PARTS = 26
_MOST_CHAINS = 40
_MOST_OPERANDS = 4000
"""Only the longest chains are compared pairwise: at most this many, with this many operands in
all."""
_LEAST_SAVED = 40
"""The least number of characters that a part must save."""
_NAME = len("part_a")
_JOINT = len(" and ")
_DEFINITION = len("let part_a = ")


class NamedExpr(NamedTuple):
    """A part: its name and its expression, which refers to earlier parts by their names."""

    name: str
    expr: tree.Expr

    def text(self, robot: Robot) -> str:
        """Return the expression as model text."""
        return to_dsl(self.expr, robot, is_part=True)

    def line(self, robot: Robot) -> str:
        return f"let {self.name} = {self.text(robot)}"


class _Node(NamedTuple):
    """An expression: its operator and the numbers of its operands; a leaf has only ``expr``."""

    operator: str
    operands: tuple[int, ...]
    expr: tree.Expr


class _Part(NamedTuple):
    """A part: the number of the node that refers to it, and that of the chain or count it names."""

    reference: int
    body: int


class PartNames:
    """Finds the named parts of the long ones among some guards."""

    def __init__(self, robot: Robot, guards: Iterable[tree.Expr]) -> None:
        self._robot = robot
        self._nodes: list[_Node] = []
        self._numbers: dict[object, int] = {}
        self._by_identity: identity_cache.IdentityCache[int] = identity_cache.IdentityCache()
        self._atoms: dict[int, int] = {}
        self._chains: dict[int, tuple[int, ...]] = {}
        self._parts: list[_Part] = []
        self._references: dict[int, int] = {}
        self._long = [guard for guard in guards if len(to_dsl(guard, robot)) > LONG]
        self._find([self._number(counting.with_counts(expr, robot)) for expr in self._long])
        self.definitions = tuple(self._definitions())

    def is_long(self, guard: tree.Expr) -> bool:
        return any(guard is long for long in self._long)

    def of_guard(self, guard: tree.Expr) -> tree.Expr:
        """Return the guard, with named parts if it is long."""
        return self.short(guard) if self.is_long(guard) else guard

    def lines(self, guard: tree.Expr) -> list[str]:
        """Return the guard as text, after a line for each part that it uses."""
        shown = self.of_guard(guard)
        parts = [part.line(self._robot) for part in self.used([shown])]
        return [*parts, to_dsl(shown, self._robot)]

    def short(self, expr: tree.Expr) -> tree.Expr:
        """Return an expression with all parts in it replaced by their names."""
        number = self._number(counting.with_counts(expr, self._robot))
        return self._expr(self._references.get(number, number))

    def used(self, exprs: Iterable[tree.Expr]) -> tuple[NamedExpr, ...]:
        """Return the parts that some expressions use, directly or through other parts, in order."""
        wanted = _names(exprs)
        for part in reversed(self.definitions):
            if part.name in wanted:
                wanted |= _names([part.expr])
        return tuple(part for part in self.definitions if part.name in wanted)

    # --- expressions as numbers; operands have smaller numbers than the expression

    def _number(self, expr: tree.Expr) -> int:
        return self._by_identity.of(expr, self._new_number)

    def _new_number(self, expr: tree.Expr) -> int:
        node = _Node("", (), expr)
        match expr:
            case tree.Binary(operator="and" | "or" as operator):
                own = dict.fromkeys(self._number(part) for part in operands(expr, operator))
                node = _Node(operator, tuple(own), expr)
            case tree.Unary(operator="!", operand=operand):
                node = _Node("!", (self._number(operand),), expr)
        key = (node.operator, node.operands) if node.operator else expr
        if key not in self._numbers:
            self._numbers[key] = self._add(node)
        return self._numbers[key]

    def _add(self, node: _Node) -> int:
        self._nodes.append(node)
        number = len(self._nodes) - 1
        if node.operator in ("and", "or"):
            self._chains[number] = node.operands
            for part in self._parts:
                self._replace(number, part)
        return number

    def _replace(self, number: int, part: _Part) -> None:
        """Replace a part's operands in a chain by its name, at the place of the first of them."""
        own, body = self._chains[number], self._nodes[part.body]
        wanted = body.operands or (part.body,)
        if body.operator in ("", self._nodes[number].operator) and (
            len(wanted) <= len(own) and set(wanted) <= set(own)
        ):
            at = min(own.index(operand) for operand in wanted)
            rest = tuple(operand for operand in own[at:] if operand not in wanted)
            self._chains[number] = (*own[:at], part.reference, *rest)

    def _operands(self, number: int) -> tuple[int, ...]:
        """Return the current operands of an expression, with named parts replaced."""
        own = self._chains.get(number)
        if own is None:
            own = tuple(self._references.get(n, n) for n in self._nodes[number].operands)
        return own

    def _expr(self, number: int) -> tree.Expr:
        node = self._nodes[number]
        parts = [self._expr(operand) for operand in self._operands(number)]
        match node.operator:
            case "and":
                return logic.conjunction(parts)
            case "or":
                return logic.disjunction(parts)
            case "!":
                return tree.Unary("!", parts[0], types.BooleanType())
        return node.expr

    # --- the search

    def _find(self, guards: Sequence[int]) -> None:
        while len(self._parts) < _MOST_PARTS:
            roots = [self._references.get(guard, guard) for guard in guards]
            best = self._best([*roots, *(part.body for part in self._parts)])
            if best is None:
                return
            body = best if isinstance(best, int) else self._add(best)
            unnamed = tree.NamedPart("", (), types.BooleanType())
            part = _Part(self._add(_Node("", (), unnamed)), body)
            self._atoms[part.reference] = _NAME
            if isinstance(best, int):
                self._references[body] = part.reference
            for number in self._chains:
                if number != body:
                    self._replace(number, part)
            self._parts.append(part)

    def _best(self, roots: Sequence[int]) -> _Node | int | None:
        """Return the operands, or the number of the count, whose name saves most; None: none saves
        enough."""
        written = self._written(roots)
        lengths = self._lengths(written)
        counts = (
            (_saved(uses, lengths[number]), number)
            for number, uses in written.items()
            if isinstance(self._nodes[number].expr, tree.Count) and number not in self._references
        )
        candidates = chain[tuple[int, _Node | int]](counts, self._common(written, lengths))
        saved, best = max(candidates, key=itemgetter(0), default=(0, None))
        return best if saved >= _LEAST_SAVED else None

    def _common(
        self, written: Counter[int], lengths: dict[int, int]
    ) -> Iterator[tuple[int, _Node]]:
        """Yield the operands that chains of one operator share, with what their name saves."""
        chains = [n for n in written if len(self._chains.get(n, ())) > 1]
        chains = list(self._longest(chains, lengths))
        own = {number: frozenset(self._chains[number]) for number in chains}
        pairs = [(number, number) for number in chains if written[number] > 1]
        seen = set()
        for first, second in (*pairs, *combinations(chains, 2)):
            operator = self._nodes[first].operator
            common = own[first] & own[second]
            if (
                self._nodes[second].operator != operator
                or len(common) < 2
                or (operator, common) in seen
            ):
                continue
            seen.add((operator, common))
            uses = sum(
                written[n]
                for n in chains
                if self._nodes[n].operator == operator and common <= own[n]
            )
            length = sum(lengths[n] + _JOINT for n in common) - _JOINT
            kept = tuple(n for n in self._chains[first] if n in common)
            yield _saved(uses, length), _Node(operator, kept, self._nodes[first].expr)

    def _written(self, roots: Sequence[int]) -> Counter[int]:
        """Return how often each expression occurs in the texts of the roots."""
        times = Counter(roots)
        for number in range(len(self._nodes) - 1, -1, -1):
            if times[number]:
                for operand in self._operands(number):
                    times[operand] += times[number]
        return times

    def _lengths(self, numbers: Iterable[int]) -> dict[int, int]:
        """Return the approximate lengths of texts, in characters."""
        lengths = dict(self._atoms)
        for number in sorted(numbers):
            node = self._nodes[number]
            if number in lengths:
                continue
            if not node.operator:
                lengths[number] = self._atoms[number] = len(to_dsl(node.expr, self._robot))
            else:
                own = self._operands(number)
                lengths[number] = 1 + sum(lengths[n] + _JOINT for n in own) - _JOINT
        return lengths

    def _longest(self, chains: Iterable[int], lengths: dict[int, int]) -> Iterator[int]:
        left = _MOST_OPERANDS
        for number in sorted(chains, key=lambda n: (-lengths[n], n))[:_MOST_CHAINS]:
            left -= len(self._chains[number])
            if left >= 0:
                yield number

    # --- names

    def _definitions(self) -> Iterator[NamedExpr]:
        """Yield the named parts, each after those that it uses."""
        names = _free_names(self._robot)
        chains = {part.reference: part.body for part in self._parts}
        done: set[int] = set()

        def visit(number: int) -> Iterator[NamedExpr]:
            if number in done:
                return
            done.add(number)
            for operand in self._operands(chains.get(number, number)):
                yield from visit(operand)
            if number in chains:
                part = tree.NamedPart(next(names), (), types.BooleanType())
                self._nodes[number] = _Node("", (), part)
                yield NamedExpr(part.variable, self._expr(chains[number]))

        for part in self._parts:
            yield from visit(part.reference)


def _saved(uses: int, length: int) -> int:
    """Return the characters that a name saves, less those of its definition."""
    return uses * (length - _NAME) - length - _DEFINITION


def _names(exprs: Iterable[tree.Expr]) -> set[str]:
    return {p.variable for expr in exprs for p in walk(expr) if isinstance(p, tree.NamedPart)}


def _free_names(robot: Robot) -> Iterator[str]:
    """Yield ``part_a``, ``part_b``, …; numbers would look like those of component copies."""
    taken = {component.name for component in robot.components}
    taken |= {parameter.key for parameter in robot.parameters}
    letters = ("".join(name) for n in count(1) for name in product(ascii_lowercase, repeat=n))
    return (name for name in (f"part_{end}" for end in letters) if name not in taken)
