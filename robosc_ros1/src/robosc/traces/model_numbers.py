"""The constants of a model, and which parts of the robot's values they stand beside."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from robosc.expr.traversal import walk
from robosc.expr.tree import (
    Aggregate,
    Binary,
    Call,
    Convert,
    ElementRef,
    Expr,
    Literal,
    ParameterRef,
    Unary,
    ValueRef,
    VariableRef,
    condition_of,
)
from robosc.expr.types import ArrayType, EnumType, ObjectType, Type
from robosc.language.events import EventKind
from robosc.model.entities import Robot, data_expressions
from robosc.plant.automaton import Event
from robosc.plant.logic import exact

_ASKED = {"isnan": math.nan, "isinf": math.inf}
"""What is asked for by functions."""
OF_SCANS = {"angle_min": -1.0, "angle_increment": 0.5, "range_min": 0.05, "range_max": 100.0}
"""What tells the directions and limits of a scan in runs."""
SECTIONS = ("section", "sector")
"""The functions that take some elements of an array, up to two ends."""


def constants(expr: Expr) -> Iterator[Any]:
    for part in walk(expr):
        if isinstance(part, Literal):
            value: Any = part.value
            if isinstance(value, dict):
                yield from value.values()
            elif isinstance(value, tuple):
                yield from value
            else:
                yield value
        elif isinstance(part, Unary) and part.operator == "-" and isinstance(part.operand, Literal):
            negative: Any = part.operand.value
            yield -negative
        elif isinstance(part, ParameterRef):
            yield part.parameter.default
        elif isinstance(part, Call) and part.operator in _ASKED:
            yield _ASKED[part.operator]
        elif isinstance(part, Convert):
            for rule in part.type.rules:
                yield from constants(condition_of(rule))


def expressions(robot: Robot, events: Iterable[Event]) -> Iterator[tuple[Expr, frozenset[Any]]]:
    """The comparisons of the model, and what else has constants, each with what it reads."""
    whole: list[Expr] = [r.condition for r in robot.requirements]
    whole += [p.condition for p in robot.provides if p.condition is not None]
    whole += [e for p in robot.provides for e in data_expressions(p.data)]
    whole += [a.condition for a in robot.assumptions]
    whole += [one.condition for one in robot.lasting]
    owned: list[tuple[Expr, Any]] = [(e, None) for e in whole]
    for communication in robot.communications.values():
        if communication.expect is not None:
            for event in events:
                if event.key == communication.key:
                    owned.append((communication.expect, event.identity))
        for direction in ("response", "feedback", "request"):
            for event in events:
                if event.key == communication.key and event.kind.word == direction:
                    for enum, path in enums(getattr(communication, direction), ()):
                        for rule in enum.rules:
                            for part in comparisons(condition_of(rule)):
                                yield part, frozenset({(event.identity, path), event.identity})
    for event in events:
        owned += [(expr, event.identity) for expr in judging(robot, event)]
        owned += [(expr, c) for c in _carriers(event) for _, expr, _ in _read_by(event)]
    for expr, owner in owned:
        arrays = {part.variable: part.array for part in walk(expr) if isinstance(part, Aggregate)}
        for part in comparisons(expr):
            reads: set[Any] = set()
            elements = {leaf.variable for leaf in walk(part) if isinstance(leaf, ElementRef)}
            roots = [part, *(arrays[name] for name in elements if name in arrays)]
            for leaf in (leaf for root in roots for leaf in walk(root)):
                if isinstance(leaf, VariableRef):
                    reads.add(leaf.key)
                elif isinstance(leaf, ValueRef) and owner is not None:
                    reads |= {(owner, leaf.path), owner}
            yield part, frozenset(reads)


def _read_by(event: Event) -> Iterator[tuple[str, Expr, str | None]]:
    """What edges of components read, with the variable that gets it (None: it is a guard)."""
    for automaton in event.automata:
        for edge in automaton.edges:
            yield from ((automaton.component, a.value, a.variable) for a in edge.assignments)
            if edge.guard is not None:
                yield automaton.component, exact(edge.guard), None


def _carriers(event: Event) -> tuple[Any, ...]:
    """The events, by identity, that bring the value of one: of an error also the answer that is not
    as expected."""
    answer = EventKind.RESPONSE, event.key, 0
    return (event.identity, answer) if event.kind is EventKind.ERROR else (event.identity,)


def judging(robot: Robot, event: Event) -> Iterator[Expr]:
    """What decides on the data of another controller's command, and corrects them."""
    if not (robot.supervises and event.kind.sent):
        return
    yield from (robot.requirements[number].condition for number in event.requirements)
    for provide in robot.provides if event.key in robot.corrected else ():
        if provide.communication == event.key:
            yield from data_expressions(provide.data)
            yield from () if provide.condition is None else (provide.condition,)


def enums(type_: Type, path: tuple[Any, ...]) -> Iterator[tuple[EnumType, tuple[Any, ...]]]:
    match type_:
        case EnumType():
            yield type_, path
        case ObjectType(properties=properties):
            for name, inner in properties:
                yield from enums(inner, (*path, name))
        case ArrayType(element=element):
            yield from enums(element, path)


def comparisons(expr: Expr) -> Iterator[Expr]:
    """The comparisons in an expression, and what asks for a kind of number; itself if there are
    none."""

    def compares(part: Expr) -> bool:
        if isinstance(part, Call):
            return part.operator in _ASKED
        return isinstance(part, Binary) and part.operation.is_comparison

    yield from list(filter(compares, walk(expr))) or (expr,)


def origins(robot: Robot, events: Iterable[Event]) -> dict[Any, frozenset[Any]]:
    """By event and path of a part (None: any), the names under which expressions read it: itself,
    and the variables that are assigned from it, directly or through others."""
    flows: dict[str, set[str]] = {}
    found: dict[Any, set[Any]] = {}
    for event in events:
        for leaf in (leaf for expr in judging(robot, event) for leaf in walk(expr)):
            if isinstance(leaf, ValueRef):
                found.setdefault((event.identity, leaf.path), set())
        for component, expr, variable in _read_by(event):
            key = f"{component}.{variable}"
            for leaf in walk(expr):
                if isinstance(leaf, VariableRef) and variable is not None:
                    flows.setdefault(leaf.key, set()).add(key)
                elif isinstance(leaf, ValueRef):
                    for carrier in _carriers(event):
                        for path in (leaf.path, None):
                            names = found.setdefault((carrier, path), set())
                            names |= set() if variable is None else {key}
    for (identity, path), names in found.items():
        pending = list(names)
        while pending:
            for other in flows.get(pending.pop(), ()):
                if other not in names:
                    names.add(other)
                    pending.append(other)
        names |= {(identity, path)} if path is not None else {identity}
    for event in events:
        found.setdefault((event.identity, None), {event.identity})
    return {key: frozenset(names) for key, names in found.items()}


def sections(robot: Robot, events: Iterable[Event]) -> dict[Any, set[int]]:
    """By event and path of an array, the indexes at the ends of its sections, and beside them."""
    found: dict[Any, set[int]] = {}
    for event in events:
        exprs = [*judging(robot, event), *(expr for _, expr, _ in _read_by(event))]
        for part in (part for expr in exprs for part in walk(expr)):
            if not (isinstance(part, Call) and part.operator in SECTIONS):
                continue
            array, ends = part.operands[0], part.operands[-2:]
            first, last = (next(constants(end), None) for end in ends)
            if not isinstance(array, ValueRef) or first is None or last is None:
                continue
            if part.operator == "sector":
                first, last = math.ceil(_ray(first)), math.floor(_ray(last))
            for carrier in _carriers(event):
                places = found.setdefault((carrier, array.path), set())
                places |= {first, first - 1, last, last + 1}
    return found


def _ray(angle: float) -> float:
    """The index at which a scan's angle lies, the first time around."""
    turned = (angle - OF_SCANS["angle_min"]) % math.tau
    return round(turned / OF_SCANS["angle_increment"], 3)
