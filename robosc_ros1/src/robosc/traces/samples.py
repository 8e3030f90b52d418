"""What the robot sends in runs: values at, just below and just above the numbers of the model.

A sample is written as a script writes it: a literal, or literals by path, in the types of ROS,
before any enum converts them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise, permutations
from typing import Any

from robosc import dotted
from robosc.emit.package.config import shared_topics
from robosc.expr.traversal import path_text, walk
from robosc.expr.tree import REASON, Binary, VariableRef
from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
    domain,
)
from robosc.language.events import EventKind, Kind
from robosc.language.reasons import FAILED
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Robot
from robosc.plant.automaton import Event
from robosc.plant.event_values import value_parts, value_type
from robosc.simulate.faults import InvalidLine
from robosc.simulate.machines.machine import label
from robosc.simulate.values.event_data import Given, complete, outer_parts, part_given
from robosc.simulate.values.literals import literal_text
from robosc.simulate.values.message_fields import Fields
from robosc.simulate.values.typed_values import within_whole
from robosc.traces.model_numbers import (
    OF_SCANS,
    constants,
    enums,
    expressions,
    origins,
    sections,
)

NEAR = 1e-6
"""How far a number is from the one beside which it lies, as a fraction of it, or of 1."""
MOST = 300
"""The most samples of one event that are looked at."""
PARTS = 6000
"""The most parts that all values have together that are looked at."""
BASES = 16
"""So many objects differ in all their parts; others in one from one of these."""
LENGTHS = (36, 9, 6, 4, 3, 2, 1)
"""Lengths of arrays, one of which may be that of the message; a scan may go around."""
REJECTED = "rejected"
SHORT = "x"
"""A text where the usual ones are too long."""


@dataclass(frozen=True, eq=False)
class Sample:
    """What an event carries: ``text`` as in a script, ``given`` for machines, ``parts`` as the
    plant reads them; ``rounded``: the same as it arrives in fields of 32 bits, if that differs."""

    text: str
    given: Given
    parts: Mapping[Any, Any]
    raw: Any = None
    rounded: Mapping[Any, Any] | None = None
    rejects: bool = False
    """Whether a server rejects a goal: that has no result, where what it ends otherwise has one."""
    also: tuple[tuple[Event, Mapping[Any, Any]], ...] = ()
    """The events that the same message is besides, with the parts that they read."""
    converted: str = ""
    """What enums make something else of, as text."""


class Samples:
    """Values of the inputs of a robot."""

    def __init__(self, robot: Robot, events: Iterable[Event], fields: Fields | None = None) -> None:
        self.robot = robot
        self._known = Fields() if fields is None else fields
        self.events = tuple(events)
        self._together: dict[str, list[Event]] = {}
        for _, keys in shared_topics(robot):
            for key in keys if len(keys) > 1 else ():
                others = [e for e in self.events if e.key in keys and e.key != key]
                self._together[key] = [e for e in others if e.kind is EventKind.RESPONSE]
        self._expressions = list(expressions(robot, self.events))
        self._read_by = origins(robot, self.events)
        self._sections = sections(robot, self.events)

    def of(self, event: Event) -> list[Sample]:
        """The samples of an event, the plainest first; one without value if it carries none."""
        found: dict[str, Sample] = {}
        for raw in _bounded(map(_flat, self._raws(event))):
            text = _text(raw)
            if text not in found and (sample := self._sample(event, raw, text)) is not None:
                found[text] = sample
            if len(found) >= MOST:
                break
        return list(found.values())

    def around(self, event: Event, sample: Sample) -> list[Sample]:
        """The samples that differ from one in a single part."""
        if not isinstance(sample.raw, dict):
            return self.of(event)
        type_ = value_type(self.robot, event)
        if not isinstance(type_, ObjectType):
            return [sample]
        found: dict[str, Sample] = {}
        columns = self._columns(event, type_).items()
        changed = ({name: v} for name, values in columns for v in values[: MOST // 4])
        for raw in _bounded(_flat({**sample.raw, **change}) for change in changed):
            if (text := _text(raw)) not in found:
                other = self._sample(event, raw, text)
                if other is not None:
                    found[text] = other
        return list(found.values())

    def _sample(self, event: Event, raw: Any, text: str) -> Sample | None:
        try:
            given = complete(self.robot, event, raw, label(event))
            narrow = self._known.narrow(event, raw)
            self._known.demand_whole(event, raw)
            arrived = given if narrow == raw else complete(self.robot, event, narrow, label(event))
            also = []
            for other in self._together.get(event.key, ()) if event.kind.word == "response" else ():
                others = complete(self.robot, other, raw, label(other))
                also.append((other, self._parts(other, others)))
                given = {**others, **given}
        except InvalidLine:
            return None
        rounded = None if narrow == raw else self._parts(event, arrived)
        rejects = raw == {"reason": REJECTED} or (raw is None and self._has_result(event))
        parts, converted = self._parts(event, given), self._converted(event, raw)
        return Sample(text, given, parts, raw, rounded, rejects, tuple(also), converted)

    def _converted(self, event: Event, raw: Any) -> str:
        """What enums make something else of, in the parts that are read."""
        read = value_parts(self.robot, event).items()
        names = {path_text((*path, *inner)) for path, t in read for _, inner in enums(t, ())}
        if not (isinstance(raw, dict) and all(names)):
            return _text(raw) if names else ""
        return _text({n: v for n, v in raw.items() if n in names or _around(n) & names})

    def _has_result(self, event: Event) -> bool:
        """Whether it is the error of a goal whose result is read."""
        is_read = not isinstance(value_type(self.robot, event), NoneType)
        return event.kind is EventKind.ERROR and self._kind(event) is Kind.ACTION and is_read

    def _kind(self, event: Event) -> Kind:
        return self.robot.communications[event.key].kind

    def _parts(self, event: Event, given: Given) -> Mapping[Any, Any]:
        parts = {p.path: part_given(given, p.path, p.type) for p in event.parameters if not p.test}
        parts |= {p: part_given(given, p, t) for p, t in value_parts(self.robot, event).items()}
        parts[()] = given.get((), parts.get(()))
        if event.kind is EventKind.ERROR:
            parts[REASON] = given.get(REASON) or FAILED
        return {**given, **parts}

    def _raws(self, event: Event) -> Iterator[Any]:
        type_ = value_type(self.robot, event)
        values = [None] if isinstance(type_, NoneType) else list(self._values(event, type_))
        if event.kind is not EventKind.ERROR:
            yield from values
            return
        is_action = self._kind(event) is Kind.ACTION
        with_reason = any(p.path == REASON for p in event.parameters)
        for value in values if is_action else [None]:
            yield {"reason": FAILED, **fields_of(value)} if with_reason else value
        if is_action:
            yield {"reason": REJECTED} if with_reason else None

    def _values(self, event: Event, type_: Type) -> Iterator[Any]:
        if not isinstance(type_, ObjectType):
            yield from self._of_type(event, (), type_)
            return
        yield from _combined(self._columns(event, type_))
        if any(isinstance(s, int) for path in outer_parts(self.robot, event) for s in path):
            yield {}  # no element arrives

    def _columns(self, event: Event, type_: ObjectType) -> dict[str, list[Any]]:
        """The values of each part that is read, by its path."""
        outer = outer_parts(self.robot, event)
        if list(outer) == [()]:
            outer = {(name,): inner for name, inner in type_.properties}
        found: dict[str, list[Any]] = {}
        while outer:
            path = next(iter(outer))
            part = outer.pop(path)
            if isinstance(part, ObjectType):
                outer |= {(*path, n): t for n, t in part.properties if n != "header"}
            elif path[-1:] != ("header",):
                name = path_text(path)
                found[name] = _likely(name, self._fitting(event, path, part)) or [None]
        return found

    def _fitting(self, event: Event, path: tuple[Any, ...], type_: Type) -> list[Any]:
        """The values of a part that fit into its field."""

        def fits(value: Any) -> bool:
            try:
                self._known.narrow(event, {path_text(path): value})
            except InvalidLine:
                return False
            return True

        found = list(filter(fits, self._of_type(event, path, type_)))
        return found or ([SHORT] if isinstance(type_, StringType) else [])

    def _of_type(self, event: Event, path: tuple[Any, ...], type_: Type) -> Iterator[Any]:
        while isinstance(type_, EnumType):
            type_ = within_whole(type_)
        match type_:
            case BooleanType():
                yield from (False, True)
            case StringType():
                yield from self._strings(event, path)
            case IntegerType(bounds=bounds):
                yield from self._integers(event, path, bounds)
            case DoubleType():
                yield from self._numbers(event, path)
            case ArrayType(element=element):
                yield from self._arrays(event, path, element)
            case ObjectType(properties=properties):
                parts = {n: self._fitting(event, (*path, n), t) for n, t in properties}
                yield from _combined(parts)

    # --- numbers of the model ----------------------------------------------------------------

    def _literals(self, event: Event, path: tuple[Any, ...]) -> list[Any]:
        """The constants that stand beside a part of the event's value, or beside a variable that
        gets it."""
        names = self._read_by.get((event.identity, path), frozenset())
        wide = self._read_by.get((event.identity, None), frozenset())
        near = [v for e, reads in self._expressions if reads & names for v in constants(e)]
        near = near or [v for k in self._beside(names) for v in self._values_of(k)]
        return near or [v for e, reads in self._expressions if reads & wide for v in constants(e)]

    def beside(self, event: Event) -> dict[str, list[Any]]:
        """The variables with few values with which a part of the event's value is compared."""
        found = self._beside(frozenset({event.identity}))
        return {key: self._values_of(key) for key in found if self._values_of(key)}

    def _beside(self, names: frozenset[Any]) -> list[str]:
        """The variables that are compared, without any constant, with what has one of the names."""
        parts = (e for e, reads in self._expressions if reads & names and not list(constants(e)))
        leaves = (leaf for e in parts if isinstance(e, Binary) for leaf in walk(e))
        return list(dict.fromkeys(leaf.key for leaf in leaves if isinstance(leaf, VariableRef)))

    def _values_of(self, key: str) -> list[Any]:
        values = domain(self.robot.variables[key].type)
        return [] if values is None or len(values) > BASES else list(values)

    def _numbers(self, event: Event, path: tuple[Any, ...]) -> Iterator[float]:
        found = [float(v) for v in self._literals(event, path) if _is_number(v)]
        if path[-1:] == ("ranges",):
            found += [OF_SCANS["range_min"], OF_SCANS["range_max"]]
        finite = sorted({v for v in found if math.isfinite(v) and abs(v) < 1e30} or {0.0})
        more = {a * b for a in finite for b in finite} if len(finite) < 6 else set()
        more |= {a / b for a in finite for b in finite if b} if len(finite) < 6 else set()
        far = [finite[0] - 1.0, finite[-1] + 1.0]
        far += [(a + b) / 2 for a, b in pairwise(finite)]
        near = [v + sign * NEAR * max(1.0, abs(v)) for v in finite for sign in (0, -1, 1)]
        rest = sorted(more | {-v for v in finite} | {0.0})
        asked = [v for v in found if not math.isfinite(v)]
        yield from map(_rounded, dict.fromkeys([*asked, *far, *near, *rest, math.nan]))

    def _integers(
        self, event: Event, path: tuple[Any, ...], bounds: tuple[int, int] | None
    ) -> Iterator[int]:
        low, high = bounds or (-(2**31), 2**31 - 1)
        numbers = [v for v in self._literals(event, path) if _is_number(v) and abs(v) < 2**31]
        exact = sorted({int(v) for v in numbers})
        numbers = numbers if len(set(numbers)) < 6 else []
        products = {round(a * b) for a in numbers for b in numbers if abs(a * b) < 2**31}
        found = list(dict.fromkeys([*exact, *sorted(products)]))
        values = [0, *(v + step for v in found or [0] for step in (0, -1, 1))]
        values += [*(bounds or ()), sum(v for v in found if v > 0), 1, 2, 3]
        yield from dict.fromkeys(v for v in values if low <= v <= high)

    def _strings(self, event: Event, path: tuple[Any, ...]) -> Iterator[str]:
        found = [v for v in self._literals(event, path) if isinstance(v, str)]
        yield from dict.fromkeys([*found, "other"])

    def _arrays(self, event: Event, path: tuple[Any, ...], element: Type) -> Iterator[Any]:
        """Arrays of equal elements, and those of which one differs."""
        indexes = [
            p[len(path)]
            for p in value_parts(self.robot, event)
            if p[: len(path)] == path and len(p) > len(path) and isinstance(p[len(path)], int)
        ]
        longest = max([4, *(abs(int(i)) for i in indexes)]) + 1
        ends = sorted(self._sections.get((event.identity, path), ()))
        if ends:  # counted from the front and from the back they do not meet
            longest = max(longest, 1 - min(ends[0], 0) + max(ends[-1], 0))
            longest = max(longest, LENGTHS[0] if path[-1:] == ("ranges",) else 0)
        items = list(self._of_type(event, path, element))
        usual = items[:2]
        for item in items[:BASES]:
            yield [item] * longest
        for length in LENGTHS:
            for item in usual:
                yield [item] * length
        for place in ends:
            for rest, item in permutations(usual):
                array = [rest] * longest
                array[place] = item
                yield array
        for item in items[BASES:]:
            yield [item] * longest
        for place in dict.fromkeys([*map(int, indexes), *ends[1:2], longest // 2, 0]):
            for item in items[:BASES]:
                for rest in usual:
                    array = [rest] * longest
                    array[place] = item
                    yield array
        yield []


def _combined(columns: Mapping[str, list[Any]]) -> Iterator[dict[str, Any]]:
    """Objects that differ in all their parts, and then those that differ in one."""

    def base(number: int) -> dict[str, Any]:
        return {
            name: values[(number * (2 * index + 1) + index * (number > 1)) % len(values)]
            for index, (name, values) in enumerate(columns.items())
            if values
        }

    bases = [base(number) for number in range(BASES)]
    # Of distances and norms, one part alone brings exactly a number; arrays may all be empty.
    bases[3] = {
        n: next((v for v in some if v in (0, [])), some[0]) for n, some in columns.items() if some
    }
    yield from bases
    rounds = max(map(len, columns.values()), default=0)
    for number in range(rounds):
        for name, values in columns.items():
            if number < len(values):
                for one in bases[:4]:
                    yield {**one, name: values[number]}


def _flat(raw: Any) -> Any:
    """A raw value of which each part has its own path."""
    if not isinstance(raw, dict):
        return raw
    found: dict[str, Any] = {}
    for name, value in raw.items():
        if isinstance(value, dict):
            inner = _flat(value)
            found |= {f"{name}.{path}" if name else path: part for path, part in inner.items()}
        else:
            found[name] = value
    return found


def _likely(name: str, values: list[Any]) -> list[Any]:
    usual = OF_SCANS.get(dotted.last(name))
    return values if usual is None else [usual]


def _around(name: str) -> set[str]:
    """The names of the parts in which a part is."""
    return {name[: found.start()] for found in re.finditer(r"[.\[]", name)}


def _bounded(raws: Iterable[Any]) -> Iterator[Any]:
    """The first of some values, fewer where each has many parts."""
    parts = 0
    for raw in raws:
        yield raw
        parts += len(raw) if isinstance(raw, dict) else 1
        if parts > PARTS:
            return


def fields_of(value: Any) -> dict[str, Any]:
    """A raw value by path; that of a plain one is empty."""
    if value is None:
        return {}
    return dict(value) if isinstance(value, dict) else {"": value}


def _text(raw: Any) -> str:
    if raw is None:
        return ""
    if not isinstance(raw, dict):
        return literal_text(raw, quoted=True)
    return fields_text(raw, "reason")


def fields_text(fields: Mapping[str, Any], word: str | None = None) -> str:
    """Values by path, as a script writes them; the value of one is a ``word``."""
    parts = [(name, literal_text(v, quoted=name != word)) for name, v in fields.items()]
    return ", ".join(f"{name}: {text}" if name else text for name, text in parts)


def _rounded(number: float) -> float:
    return float(repr(round(number, 12)))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
