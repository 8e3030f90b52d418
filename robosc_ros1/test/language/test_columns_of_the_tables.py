"""Every column of the tables of operators and functions says what the others say.

The meaning of an operation is written here once more, in plain Python; each check compares one
column with it, over the operation's values. That no check is idle is shown by faults: every entry
is replaced by those of other rows, and some check must see it.
"""

from __future__ import annotations

import math
import operator as python
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from itertools import product
from typing import Any

import pytest
from synthesis import oracle_values

from robosc.language.functions import AGGREGATES, CALLS, HELPERS
from robosc.language.operators import (
    BINARY,
    MIRRORED,
    UNARY,
    Operand,
    Operator,
    Result,
    Spelled,
)
from robosc.runtime.core.values import Undefined

NAN, INF = math.nan, math.inf
NUMBERS = (0, 1, -1, 2, 3, -7, 2**53 + 1, 10**400, 0.0, -0.0, 0.5, -2.5, 1e308, INF, -INF, NAN)
VALUES: Mapping[Operand, Sequence[Any]] = {
    Operand.BOOLEAN: (False, True),
    Operand.NUMBER: NUMBERS,
    Operand.EQUAL: NUMBERS,
    Operand.SUMMAND: (*NUMBERS, "a", "b"),
    Operand.INTEGER: (0, 1, -1, 2, 3, 6, 255),
    Operand.BASIC: (True, False, "text", 3, -0.5),
    Operand.ARRAY: ((), (1, 2.5), tuple(range(7))),
}
SCANS = [
    (tuple(range(count)), start, step, first, last)
    for count in (0, 1, 7, 12)
    for start, step in [(-1.5, 0.5), (1, -0.25), (0.0, math.pi / 6), (0, 0), (NAN, 1), (0.0, INF)]
    for first, last in [(-0.5, 0.5), (0, 1), (2.0, -2.0), (-INF, 0), (-9, 9.5), (10**400, 1)]
]
LOOSEST_FIRST = (
    ("else",), ("=>",), ("or",), ("and",), ("=", "!="), ("<", "<=", ">", ">="), ("+", "-"),
    ("*", "/", "%"),
)  # fmt: skip
RIGHT = {"else", "=>"}
LAZY = {"=>": (False, True), "or": (True, True), "and": (False, False)}
OPPOSITE = {"=": "!=", "!=": "="}
VARIADIC = {"min", "max"}


def _double(number: Any) -> float:
    try:
        return float(number)
    except OverflowError:
        return INF if number > 0 else -INF


def _doubling(function: Callable[..., Any]) -> Callable[..., Any]:
    """Integers beside doubles are doubles, however large they are."""

    def apply(*values: Any) -> Any:
        if any(type(value) is float for value in values):
            return function(*map(_double, values))
        return function(*values)

    return apply


def _of_doubles(function: Callable[..., float]) -> Callable[..., float]:
    def apply(*values: Any) -> float:
        try:
            return function(*map(_double, values))
        except ValueError:
            return NAN

    return apply


def _whole(function: Callable[[float], int]) -> Callable[[Any], int]:
    def apply(value: Any) -> int:
        finite = type(value) is int or math.isfinite(value)
        return function(value) if finite else 0

    return apply


def _element(array: Sequence[Any], index: int) -> Any:
    if not -len(array) <= index < len(array):
        raise Undefined
    return array[index]


def _section(array: Sequence[Any], first: int, last: int) -> list[Any]:
    count = len(array)
    low, high = (n + count if n < 0 else n for n in (first, last))
    if low <= high:
        return [array[n] for n in range(count) if low <= n <= high]
    return [array[n] for n in (*range(max(low, 0), count), *range(min(high + 1, count)))]


def _sector(ranges: Sequence[Any], start: Any, step: Any, first: Any, last: Any) -> list[Any]:
    """The rays whose angle is in the sector after some whole turns, asked one by one."""
    start, step, first, last = map(_double, (start, step, first, last))
    if len(ranges) == 1 and step == 0:
        step = 0.001
    turn = 2 * math.pi
    width = min(last - first if last >= first else (last - first) % turn, turn)
    if not 0 < abs(step) <= turn or not math.isfinite(start + first + last):
        return []
    found = []
    for place, value in enumerate(ranges):
        # From the first angle of the sector, where a thousandth of a step does not count.
        angle = (start + place * step - first) % turn
        if turn - angle <= abs(step) / 1000:
            angle -= turn
        if angle <= width + abs(step) / 1000:
            found.append((angle, value))
    return [value for _, value in sorted(found)]


def _extreme(best: Callable[..., Any]) -> Callable[..., Any]:
    def apply(*values: Any) -> Any:
        return NAN if any(v != v for v in values) else best(values)

    return apply


def _extreme_of(best: Callable[..., Any]) -> Callable[..., Any]:
    def apply(values: Sequence[Any]) -> Any:
        there = [value for value in values if value == value]
        if not there:
            raise Undefined
        return best(there)

    return apply


def _remainder(left: Any, right: Any) -> Any:
    return oracle_values.remainder(left, right)


MEANING: Mapping[str, Callable[..., Any]] = {
    "!": python.not_,
    "negative": python.neg,
    "else": lambda a, b: b if a != a else a,
    "=>": lambda a, b: b if a else True,
    "or": lambda a, b: bool(a | b),
    "and": lambda a, b: bool(a & b),
    "=": lambda a, b: a == b,
    "!=": lambda a, b: a < b or a > b or a != a or b != b,
    "<": lambda a, b: b > a,
    "<=": lambda a, b: b >= a,
    ">": lambda a, b: b < a,
    ">=": lambda a, b: b <= a,
    "+": _doubling(lambda a, b: a + b),
    "-": _doubling(lambda a, b: a - b),
    "*": _doubling(lambda a, b: a * b),
    "/": lambda a, b: oracle_values.divide(_double(a), _double(b)),
    "%": _doubling(_remainder),
    "abs": lambda a: -a if a < 0 or math.copysign(1, _double(a)) < 0 else a,
    "min": _extreme(min),
    "max": _extreme(max),
    "sqrt": _of_doubles(lambda a: math.sqrt(a)),
    "hypot": _of_doubles(lambda a, b: math.hypot(a, b)),
    "sin": _of_doubles(math.sin),
    "cos": _of_doubles(math.cos),
    "atan2": _of_doubles(math.atan2),
    "floor": _whole(math.floor),
    "ceil": _whole(math.ceil),
    "round": _whole(round),
    "isnan": lambda a: a != a,
    "isinf": lambda a: type(a) is float and math.isinf(a),
    "has": lambda bits, mask: bits | mask == bits,
    "string": lambda a: {True: "true", False: "false"}[a] if type(a) is bool else str(a),
    "length": lambda a: sum(1 for _ in a),
    "element": _element,
    "section": _section,
    "sector": _sector,
}
OF_LISTS: Mapping[str, Callable[..., Any]] = {
    "any": lambda values: True in values,
    "all": lambda values: False not in values,
    "count": lambda values: list(values).count(True),
    "sum": lambda values: oracle_sum(values),
    "min": _extreme_of(min),
    "max": _extreme_of(max),
    "first": lambda values: _element(values, 0),
    "[": list,
}


def oracle_sum(values: Sequence[Any]) -> Any:
    total: Any = 0
    for value in values:
        total = MEANING["+"](total, value)
    return total


def key(row: Operator) -> str:
    """Unary and binary minus have one spelling; the independent name of a row."""
    return "negative" if row.spelling == "-" and row.is_unary else row.spelling


def result(function: Callable[..., Any], *values: Any) -> str:
    """What a function comes to, with its type; NaN is itself, 0.0 is not -0.0."""
    try:
        found = function(*values)
    except Undefined:
        return "undefined"
    return repr(list(found) if isinstance(found, list | tuple) else found)


def kinds(row: Operator) -> tuple[Operand, ...]:
    return row.arguments or (row.operands,) * (1 if row.is_unary else 2)


def values_of(row: Operator) -> Iterator[tuple[Any, ...]]:
    """Operands of an operation, of its kinds and of one type where it needs that."""
    if row.spelling == "sector":
        yield from SCANS
        return
    for values in product(*(VALUES[kind] for kind in kinds(row))):
        if len({isinstance(v, str) for v in values}) == 1 or row.arguments:
            yield values


# --- the checks, one for each column -------------------------------------------------------------


def check_operands(row: Operator, group: Mapping[str, Operator]) -> None:
    assert key(row) in (OF_LISTS if group is AGGREGATES else MEANING)
    booleans = {"!", "=>", "or", "and", "any", "all", "count"}
    expected = {
        **dict.fromkeys(booleans, Operand.BOOLEAN), "=": Operand.EQUAL, "!=": Operand.EQUAL,
        "else": Operand.EQUAL, "+": Operand.SUMMAND, "has": Operand.INTEGER,
        "string": Operand.BASIC, "length": Operand.ARRAY, "element": Operand.ARRAY,
        "section": Operand.ARRAY, "sector": Operand.ARRAY, "first": Operand.ANY, "[": Operand.ANY,
    }.get(row.spelling, Operand.NUMBER)  # fmt: skip
    assert row.operands is expected
    index = (Operand.INTEGER,)
    numbers = (Operand.NUMBER,) * 4
    more = {"has": index, "element": index, "section": index * 2, "sector": numbers}.get(
        row.spelling, ()
    )
    pair = (Operand.NUMBER,) if row.spelling in ("hypot", "atan2", *VARIADIC) else ()
    is_function = group in (CALLS, AGGREGATES)
    of_lists = () if group is AGGREGATES else pair
    assert row.arguments == ((expected, *more, *of_lists) if is_function else ())


def check_precedence(row: Operator, group: Mapping[str, Operator]) -> None:
    if group is BINARY:
        place = next(n for n, names in enumerate(LOOSEST_FIRST) if row.spelling in names)
        for other in BINARY.values():
            theirs = next(n for n, names in enumerate(LOOSEST_FIRST) if other.spelling in names)
            if other.spelling != row.spelling:
                assert (row.level > other.level) is (place > theirs)
                assert (row.level == other.level) is (place == theirs)
        assert 0 <= row.level < UNARY["!"].level
    else:
        assert row.level > max(other.level for other in BINARY.values())
        assert row.level == (8 if group is UNARY else 9)
    assert row.right_associative is (group is BINARY and row.spelling in RIGHT)
    assert row.is_unary is (group is UNARY)
    assert row.variadic is (group is CALLS and row.spelling in VARIADIC)


def check_scalar(row: Operator, group: Mapping[str, Operator]) -> None:
    if group is AGGREGATES:
        for values in lists_of(row):
            assert result(row.scalar, values) == result(OF_LISTS[row.spelling], values), values
        return
    for values in values_of(row):
        assert result(row.scalar, *values) == result(MEANING[key(row)], *values), values


def check_spelling(row: Operator, group: Mapping[str, Operator]) -> None:
    assert row.spelling in group
    check_operands(row, group)
    check_scalar(row, group)


def lists_of(row: Operator) -> Sequence[list[Any]]:
    """What an aggregate goes through."""
    if row.spelling in ("any", "all", "count"):
        return [], [False], [True, False, True], [True, True]
    return [], [3, -2, 5.5], [0.0, 1], [1, NAN, 0], [2, 2.0], [10**400, 0.5], [NAN], [1e308, 1e308]


def check_result(row: Operator, group: Mapping[str, Operator]) -> None:
    special = {Result.ELEMENT: {"element", "first"}, Result.ARRAY: {"section", "sector", "["}}
    assert (row.spelling in set().union(*special.values())) is (row.result in special)
    if row.result in special:
        assert row.spelling in special[row.result]
        return
    seen = set()
    meaning = OF_LISTS[row.spelling] if group is AGGREGATES else MEANING[key(row)]
    for values in [([True],), ([2, 3],)] if group is AGGREGATES else values_of(row):
        if group is AGGREGATES and (row.operands is Operand.BOOLEAN) != (values == ([True],)):
            continue
        whole = all(type(v) is int for v in (values[0] if group is AGGREGATES else values))
        expected = {
            Result.BOOLEAN: bool, Result.INTEGER: int, Result.STRING: str, Result.DOUBLE: float,
            Result.NUMBER: int if whole else float,
            Result.SUM: str if isinstance(values[0], str) else int if whole else float,
            Result.SAME: type(values[0]),
        }[row.result]  # fmt: skip
        if row.result is Result.SAME and len({type(v) for v in values}) > 1:
            continue
        found = meaning(*values)
        mixed = row.spelling in VARIADIC  # min(1, 2.5) is 1, which becomes 1.0 where it is kept
        assert mixed or type(found) is expected, values
        seen.add(expected)
    assert seen and (row.result is not Result.SUM or str in seen)
    assert (row.result is Result.NUMBER) is (
        row.spelling in {"-", "*", "%", "abs", "min", "max"}
        or (group is AGGREGATES and row.spelling == "sum")
    )
    assert (row.result is Result.SAME) is (row.spelling == "else")


def check_python(row: Operator, group: Mapping[str, Operator]) -> None:
    if group is AGGREGATES:
        code = row.python.of([Spelled("v0", 8)]).text
        for values in lists_of(row):
            known = {**HELPERS, "v0": values}
            found = result(lambda known=known: eval(code, known))
            assert found == result(OF_LISTS[row.spelling], values), values
        assert row.python.level == 8
        return
    names = [f"v{n}" for n in range(len(kinds(row)))]
    code = row.python.of([Spelled(name, 8) for name in names]).text
    for values in values_of(row):
        # The runtime widens integers that are too large; the text does so around the operands.
        if all(abs(v) < 2**60 for v in values if type(v) is int):
            known = {**HELPERS, **dict(zip(names, values, strict=True))}
            found = result(lambda known=known: eval(code, known))
            assert found == result(MEANING[key(row)], *values), values
    assert row.python.level == _LEVELS_OF_PYTHON.get(key(row), 8)
    _check_nesting(row, lambda other: other.python, _python_of)


_LEVELS_OF_PYTHON = {
    "=>": 1, "or": 1, "and": 2, "!": 3, "=": 4, "!=": 4, "<": 4, "<=": 4, ">": 4, ">=": 4, "+": 5,
    "-": 5, "*": 6, "negative": 7,
}  # fmt: skip
"""Of what is no call; "8" are calls and names. The order is Python's."""


def _python_of(text: str, values: Mapping[str, bool]) -> object:
    return eval(text, {**HELPERS, **values})


def _check_nesting(
    row: Operator, column: Callable[[Operator], Any], evaluated: Callable[..., Any]
) -> None:
    """Two operations on booleans in one another mean the same with as few brackets as they get."""
    others = [o for o in (*UNARY.values(), *BINARY.values()) if column(o) is not None]
    for other in others:
        for outer, inner in ((row, other), (other, row)):
            of_booleans = {outer.operands, inner.operands} <= {Operand.BOOLEAN, Operand.EQUAL}
            if of_booleans and "else" not in (outer.spelling, inner.spelling):
                _check_pair(outer, inner, column, evaluated)


def _check_pair(
    outer: Operator, inner: Operator, column: Callable[[Operator], Any], evaluated: Any
) -> None:
    count, inside = len(kinds(outer)), len(kinds(inner))
    for place in range(count):
        names = [f"p{n}" for n in range(inside)]
        whole = column(inner).of([Spelled(name, 9) for name in names])
        rest = [f"q{n}" for n in range(count - 1)]
        operands = [Spelled(name, 9) for name in rest]
        operands.insert(place, whole)
        text = column(outer).of(operands).text
        for truths in product((False, True), repeat=inside + count - 1):
            values = dict(zip([*names, *rest], truths, strict=True))
            parts: list[Any] = [values[name] for name in rest]
            parts.insert(place, MEANING[key(inner)](*(values[name] for name in names)))
            assert evaluated(text, values) is MEANING[key(outer)](*parts), text


def check_cif(row: Operator, group: Mapping[str, Operator]) -> None:
    """CIF's own precedence: ``not``, comparisons, ``and``, ``or``, ``=>``."""
    spelled = {"!", "=>", "or", "and", "=", "!=", "<", "<=", ">", ">="}
    assert (row.cif is not None) is (row.spelling in spelled and group in (UNARY, BINARY))
    if row.cif is not None:
        if row.operands in (Operand.BOOLEAN, Operand.EQUAL):
            _check_nesting(row, lambda other: other.cif, _cif_of)
        else:
            assert row.cif.of([Spelled("a", 9), Spelled("b", 9)]).text == f"a {row.spelling} b"
            assert row.cif.of([Spelled("a", 8), Spelled("b", 8)]).text == f"(a) {row.spelling} (b)"
        levels = {"!": 8, "and": 3, "or": 2, "=>": 1}
        assert row.cif.level == levels.get(row.spelling, 4)


def _cif_of(text: str, values: Mapping[str, bool]) -> bool:
    """A condition of CIF, read by its grammar."""
    words = text.replace("(", " ( ").replace(")", " ) ").split()
    binary = [("=>",), ("or",), ("and",), ("=", "!=")]

    def level(n: int) -> bool:
        if n == len(binary):
            return factor()
        found = level(n + 1)
        while words and words[0] in binary[n]:
            word = words.pop(0)
            # Implications and comparisons are not chained in what is exported.
            other = level(n + 1) if word != "=>" else level(n)
            found = MEANING[word](found, other)
        return found

    def factor() -> bool:
        word = words.pop(0)
        if word == "not":
            return not factor()
        if word == "(":
            found = level(0)
            assert words.pop(0) == ")"
            return found
        return values[word]

    found = level(0)
    assert not words, text
    return found


def check_laziness(row: Operator, group: Mapping[str, Operator]) -> None:
    assert (row.decider, row.decided) == (
        LAZY.get(row.spelling, (None, False)) if group is BINARY else (None, False)
    )
    if row.decider is not None:
        for right in (False, True):
            assert MEANING[row.spelling](row.decider, right) is row.decided


def check_negation(row: Operator, group: Mapping[str, Operator]) -> None:
    assert row.negation == (OPPOSITE.get(row.spelling, "") if group is BINARY else "")
    if row.negation:
        for values in product(NUMBERS, NUMBERS):
            assert MEANING[row.negation](*values) is not MEANING[row.spelling](*values)


def check_text(row: Operator, group: Mapping[str, Operator]) -> None:
    """The name in tables of generated tests, and the text in the language."""
    assert row.name == ("negative" if group is UNARY and row.spelling == "-" else "")
    written = {"element": "a[b]", "section": "a[b..c]", "[": "[a]"}.get(row.spelling)
    parts = [Spelled(name, 9) for name in "abc"[: len(kinds(row))]]
    names = [part.text for part in parts]
    if group in (CALLS, AGGREGATES):
        expected = written or f"{row.spelling}({', '.join(names)})"
    else:
        expected = f"{row.spelling}a" if group is UNARY else f"a {row.spelling} b"
    assert row.text.of(parts).text == expected
    if written:
        weak = [Spelled(name, 0) for name in names]
        expected = written if group is AGGREGATES else "(a)" + written[1:]
        assert row.text.of(weak).text == expected
    assert (row.written is not None) is bool(written)


CHECKS: Mapping[str, Callable[[Operator, Mapping[str, Operator]], None]] = {
    "spelling": check_spelling,
    "operands": check_operands,
    "arguments": check_operands,
    "level": check_precedence,
    "right_associative": check_precedence,
    "is_unary": check_precedence,
    "variadic": check_precedence,
    "scalar": check_scalar,
    "result": check_result,
    "python": check_python,
    "cif": check_cif,
    "decider": check_laziness,
    "decided": check_laziness,
    "negation": check_negation,
    "name": check_text,
    "written": check_text,
}
GROUPS = {"unary": UNARY, "binary": BINARY, "functions": CALLS, "aggregates": AGGREGATES}
ROWS = [
    (f"{name} {row.spelling}", row, group)
    for name, group in GROUPS.items()
    for row in group.values()
]
IDS = [name for name, _, _ in ROWS]


def test_every_column_has_a_check() -> None:
    assert CHECKS.keys() == {field.name for field in fields(Operator)}


@pytest.mark.parametrize(("name", "row", "group"), ROWS, ids=IDS)
def test_all_columns_agree(name: str, row: Operator, group: Mapping[str, Operator]) -> None:
    for check in dict.fromkeys(CHECKS.values()):
        check(row, group)


def others(column: str, entry: Any) -> list[Any]:
    """What other rows have in a column, each once."""
    found = {repr(getattr(row, column)): getattr(row, column) for _, row, _ in ROWS}
    return [other for text, other in found.items() if text != repr(entry)]


@pytest.mark.parametrize("column", CHECKS)
@pytest.mark.parametrize(("name", "row", "group"), ROWS, ids=IDS)
def test_any_entry_of_another_row_is_seen(
    name: str, row: Operator, group: Mapping[str, Operator], column: str
) -> None:
    for entry in others(column, getattr(row, column)):
        faulty = replace(row, **{column: entry})
        assert is_seen(faulty, group, column) or means_the_same(row, column), entry


def is_seen(row: Operator, group: Mapping[str, Operator], column: str) -> bool:
    try:
        CHECKS[column](row, group)
    except Exception:  # whatever a wrong entry does
        return True
    return False


def means_the_same(row: Operator, column: str) -> bool:
    """Whether an entry that passed its check is right: it was tried with all values there are."""
    if row.spelling == "count" and column in ("scalar", "python"):
        return True  # the sum of truths
    if row.spelling == "[" and column in ("scalar", "python"):
        return True  # the least of one list is that list
    exhaustive = row.operands is Operand.BOOLEAN and not row.arguments
    return exhaustive and column == "scalar"


def test_mirrored_comparisons() -> None:
    assert set(MIRRORED) == {row.spelling for row in BINARY.values() if row.is_comparison}
    for spelling, mirrored in MIRRORED.items():
        for left, right in product(NUMBERS, NUMBERS):
            assert MEANING[spelling](left, right) is MEANING[mirrored](right, left)


def test_the_second_reading_of_the_tests_knows_every_operator() -> None:
    small = [v for v in NUMBERS if (v == v and abs(v) < 2**60) or type(v) is float]
    for row in BINARY.values():
        if row.is_lazy or row.spelling == "else":
            continue
        for values in product(small, small):
            found = result(oracle_values.apply, row.spelling, *values)
            assert found == result(MEANING[row.spelling], *values), (row.spelling, values)
