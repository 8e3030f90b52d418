"""Classes of numbers and strings that comparisons with constants do not distinguish."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Sequence
from functools import cached_property
from itertools import groupby
from typing import Any, TypeAlias, overload

from robosc.expr import tree, types
from robosc.language.operators import BINARY, OPPOSITE
from robosc.lazy_dataclasses import dataclass
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.runtime.core.values import widen

Comparison: TypeAlias = tuple[str, types.Value]
"""An operator and its right operand, a constant."""

_Key: TypeAlias = tuple[int | None, types.Value | None]

_AT = 1
_CUT = {"<": 0, ">=": 0, "<=": 2, ">": 2}
"""On which side of its constant a comparison changes its result: below (0) or above (2) ``_AT``."""

_BOOLEAN = types.BooleanType()
_NAN = math.nan


@dataclass(frozen=True, slots=True)
class ClassCondition:
    """A disjunction of conjunctions of comparisons, or (``negated``) its negation."""

    alternatives: tuple[tuple[Comparison, ...], ...]
    negated: bool

    @property
    def length(self) -> tuple[int, bool]:
        """The length of the condition, to choose the shortest one."""
        return sum(len(part) for part in self.alternatives), self.negated

    def of(self, left: tree.Expr, right: tree.Expr | None = None) -> tree.Expr:
        """Return the condition on ``left``, compared with ``right`` or with the constants."""
        equal = disjunction(
            conjunction(_comparison(left, right, one) for one in part) for part in self.alternatives
        )
        return negation(equal) if self.negated else equal


def _comparison(left: tree.Expr, right: tree.Expr | None, comparison: Comparison) -> tree.Expr:
    operator, constant = comparison
    if right is None:
        right = tree.Literal(constant, _type_of(constant))
    return tree.Binary(operator, left, right, _BOOLEAN)


def _type_of(constant: types.Value) -> types.Type:
    match constant:
        case str():
            return types.StringType()
        case float():
            return types.DoubleType()
    return types.IntegerType()


@dataclass(frozen=True, slots=True)
class _Region:
    """Numbers between two constants, one constant, or NaN.

    ``begins`` and ``ends`` are the comparisons that bound a run of regions that begins or ends
    here.
    """

    representative: types.Value
    begins: Comparison | None
    ends: Comparison | None


@dataclass(frozen=True, eq=False)
class Classes(Sequence[Any]):
    """The classes into which some comparisons divide the values of a type.

    A sequence of one representative of each class in ascending order, with None at the end if
    ``optional``. Any value of the type is ``in`` it; ``index`` gives the number of its class.
    """

    type: types.Type
    comparisons: frozenset[Comparison]
    optional: bool = False

    # --- the sequence

    def __len__(self) -> int:
        return len(self._members) + self.optional

    @overload
    def __getitem__(self, index: int) -> types.Value | None: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[types.Value | None]: ...
    def __getitem__(self, index: int | slice) -> Any:
        return self._values[index]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._values)

    def __contains__(self, value: object) -> bool:
        if value is None:
            return self.optional
        return self._key(value) in self._numbers

    def index(self, value: Any, start: int = 0, stop: int | None = None) -> int:
        """Return the number of the class of a value."""
        if value is None and self.optional:
            return len(self._members)
        return self._numbers[self._key(value)]

    # --- conditions

    def tell(self, operator: str, constant: types.Value) -> bool:
        """Whether a comparison with a constant has the same result for all values of each class."""
        asked = {(operator, constant)}
        if not isinstance(self.type, types.DoubleType):  # for NaN the opposite is not the negation
            asked.add((OPPOSITE[operator], constant))
        return not asked.isdisjoint(self.comparisons)

    def condition(self, needed: Collection[int], free: Collection[int]) -> ClassCondition:
        """Return a short condition that holds in all needed classes, and otherwise only in free
        ones."""
        must, may = self._in_regions(needed), self._in_regions(free)
        if isinstance(self.type, types.StringType):
            return self._equalities(must, may)
        last = len(self._regions) - 1
        conditions = []
        if isinstance(self.type, types.DoubleType):  # the last region is NaN
            count, is_needed, is_free = last, last in must, last in may
        else:
            count, is_needed, is_free = last + 1, False, True
        if not is_needed:
            runs = self._runs(intervals(must, may - {count}), is_free)
            conditions.append(ClassCondition(runs, False))
        if is_free:
            runs = self._runs(_between(must, may, count), not is_needed)
            conditions.append(_turned(runs, self.type))
        return min(conditions, key=lambda c: c.length)

    def label(self, index: int, term: tree.Expr, text: Callable[[tree.Expr], str]) -> str:
        """Return the condition on the term that defines a class, as text."""
        if index == len(self._members):
            return "missing"
        if len(self._members) == 1:
            return "any"
        return text(self.condition([index], [index]).of(term))

    def outcomes(self, index: int) -> dict[Comparison, bool]:
        """Return the results of the comparisons in a class (not that of missing values)."""
        value = self._values[index]
        return {(op, right): bool(BINARY[op].scalar(value, right)) for op, right in self._ordered}

    # --- regions

    @cached_property
    def _constants(self) -> tuple[Any, ...]:
        return tuple(sorted(dict.fromkeys(constant for _, constant in self._dividing)))

    @cached_property
    def _regions(self) -> tuple[_Region, ...]:
        """The nonempty regions between and at the constants, ascending, NaN last."""
        if isinstance(self.type, types.StringType):
            return tuple(_strings(self._constants))
        regions = list(_numbers(self._constants, isinstance(self.type, types.DoubleType)))
        if isinstance(self.type, types.DoubleType):
            regions.append(_Region(_NAN, None, None))
        return tuple(regions)

    def _key(self, value: Any) -> _Key:
        """Equal for two values if all comparisons have the same results for them, and only then.

        It is the number of cuts below the value, and the constant that it equals if a comparison
        asks for that.
        """
        if value != value:
            return self._key_of_nan
        return bisect_left(self._cuts, (value, _AT)), value if value in self._equated else None

    @cached_property
    def _cuts(self) -> list[tuple[Any, int]]:
        """Where the result of a comparison by size changes: below a constant or above it."""
        return sorted({(right, _CUT[op]) for op, right in self._dividing if op in _CUT})

    @cached_property
    def _equated(self) -> frozenset[Any]:
        return frozenset(right for op, right in self._dividing if op not in _CUT)

    @cached_property
    def _key_of_nan(self) -> _Key:
        """That of the values for which no comparison by size holds, if there are such."""
        least, most = 0, len(self._cuts)
        for op, right in self._dividing:
            if op in _CUT:
                cut = bisect_left(self._cuts, (right, _CUT[op]))
                if op in ("<", "<="):
                    least = max(least, cut + 1)
                else:
                    most = min(most, cut)
        return (least if least == most else None), None

    @property
    def _dividing(self) -> Iterator[Comparison]:
        """The comparisons but those with NaN, which have the same result for all values."""
        return (one for one in self._ordered if one[1] == one[1])

    @cached_property
    def _ordered(self) -> tuple[Comparison, ...]:
        return tuple(sorted(self.comparisons, key=repr))

    @cached_property
    def _by_key(self) -> dict[_Key, list[int]]:
        """For each class its regions: those with equal results of all comparisons."""
        by_key: dict[_Key, list[int]] = {}
        for number, region in enumerate(self._regions):
            by_key.setdefault(self._key(region.representative), []).append(number)
        return by_key

    @cached_property
    def _members(self) -> tuple[list[int], ...]:
        return tuple(self._by_key.values())

    @cached_property
    def _numbers(self) -> dict[_Key, int]:
        return {key: number for number, key in enumerate(self._by_key)}

    @cached_property
    def _values(self) -> tuple[types.Value | None, ...]:
        values = [self._regions[members[0]].representative for members in self._members]
        return (*values, None) if self.optional else tuple(values)

    def _in_regions(self, classes: Iterable[int]) -> set[int]:
        return {region for number in classes for region in self._members[number]}

    def _runs(
        self, pairs: Iterable[tuple[int, int]], nan: bool
    ) -> tuple[tuple[Comparison, ...], ...]:
        """Return runs of regions as comparisons; a run of all has none."""
        return tuple(run for low, high in pairs for run in self._run(low, high, nan))

    def _run(self, low: int, high: int, nan: bool) -> Iterator[tuple[Comparison, ...]]:
        """Yield the condition of a run of regions; ``nan``: it may hold for NaN."""
        first, last = self._regions[low].begins, self._regions[high].ends
        if first is None and last is None and not nan:
            yield (("<=", self._constants[0]),)
            yield ((">", self._constants[0]),)
        elif first is not None and last is not None and first[1] == last[1]:
            yield (("=", first[1]),)
        else:
            yield tuple(bound for bound in (first, last) if bound is not None)

    def _equalities(self, must: set[int], may: set[int]) -> ClassCondition:
        """Return "equal to one of these strings" or "to none of those", whichever names fewer."""
        count = len(self._regions)
        other = count - 1  # all strings that are no constant
        if other in must or (other in may and count - len(may) < len(must)):
            unequal = [region for region in range(count) if region not in may]
            return _turned(self._named(unequal), self.type)
        return ClassCondition(self._named(sorted(must)), False)

    def _named(self, regions: Iterable[int]) -> tuple[tuple[Comparison, ...], ...]:
        return tuple((("=", self._regions[region].representative),) for region in regions)


def intervals(needed: Container[int], free: Iterable[int]) -> Iterator[tuple[int, int]]:
    """Yield the widest intervals of free numbers that contain a needed one."""
    for _, run in groupby(enumerate(sorted(free)), lambda item: item[1] - item[0]):
        numbers = [number for _, number in run]
        if any(number in needed for number in numbers):
            yield numbers[0], numbers[-1]


def _between(needed: Iterable[int], free: Container[int], count: int) -> Iterator[tuple[int, int]]:
    """Yield the widest intervals below ``count`` of numbers not needed of which one is not free."""
    first = 0
    for number in sorted({*needed, count}):
        if any(other not in free for other in range(first, number)):
            yield first, number - 1
        first = number + 1


def _turned(runs: tuple[tuple[Comparison, ...], ...], type_: types.Type) -> ClassCondition:
    """Return the negation of all runs, as comparisons if possible."""
    if all(len(run) == 1 for run in runs):
        flat = [run[0] for run in runs]
        if not isinstance(type_, types.DoubleType) or all(operator == "=" for operator, _ in flat):
            return ClassCondition(
                (tuple((OPPOSITE[op], constant) for op, constant in flat),), False
            )
    return ClassCondition(runs, True)


def _strings(constants: Sequence[str]) -> Iterator[_Region]:
    for constant in constants:
        equal = ("=", constant)
        yield _Region(constant, equal, equal)
    other = ""
    while other in constants:
        other += "?"
    yield _Region(other, None, None)


def _numbers(constants: Sequence[int | float], double: bool) -> Iterator[_Region]:
    sample = _double_between if double else _integer_between
    below: int | float | None = None
    for constant in constants:
        between = sample(below, constant)
        if between is not None:
            yield _Region(between, _above(below), ("<", constant))
        point = _exactly(constant, double)
        if point is not None:
            yield _Region(point, (">=", constant), ("<=", constant))
        below = constant
    between = sample(below, None)
    if between is not None:
        yield _Region(between, _above(below), None)


def _above(constant: int | float | None) -> Comparison | None:
    return None if constant is None else (">", constant)


def _exactly(constant: int | float, double: bool) -> int | float | None:
    """Return the constant as a value of the type; None if the type cannot represent it."""
    if double:
        number = widen(constant)
        return number if number == constant else None
    if isinstance(constant, int):
        return constant
    return int(constant) if constant.is_integer() else None


def _integer_between(low: int | float | None, high: int | float | None) -> int | None:
    if low == math.inf or high == -math.inf:
        return None
    first = None if low is None or low == -math.inf else math.floor(low) + 1
    last = None if high is None or high == math.inf else math.ceil(high) - 1
    if first is None:
        return 0 if last is None else last
    return first if last is None or first <= last else None


def _double_between(low: int | float | None, high: int | float | None) -> float | None:
    """Return a double strictly between two numbers, with few digits if possible; None: there is
    none."""
    start = -math.inf if low is None else widen(low)
    end = math.inf if high is None else widen(high)
    candidates: Iterable[float] = _round_doubles(low, high, start, end)
    # The least double above ``low`` is among these, so that no double is missed.
    least: tuple[float, ...] = (
        (-math.inf,) if low is None else (start, math.nextafter(start, math.inf))
    )
    for double in (*candidates, *least, end):
        if (low is None or low < double) and (high is None or double < high):
            return double
    return None


def _round_doubles(
    low: int | float | None, high: int | float | None, start: float, end: float
) -> Iterator[float]:
    if low is None and high is None:
        yield 0.0
    elif low is None:
        yield end - 1.0
    elif high is None:
        yield start + 1.0
    middle = start / 2 + end / 2
    if math.isfinite(middle):
        for digits in range(18):
            yield round(middle, digits)
        yield middle
