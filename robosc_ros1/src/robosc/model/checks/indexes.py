"""The check of literal indexes into arrays of fixed length."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, ValueRef, condition_of
from robosc.expr.types import ArrayType, EnumType, ObjectType, Type
from robosc.model.diagnostics import Report
from robosc.model.entities import Component

Lengths = Mapping[tuple[ObjectType, str], tuple[int, str]]
"""Array properties of fixed length: the number of elements, and the field as text."""


def check_indexes(
    components: Iterable[Component], enums: Iterable[EnumType], lengths: Lengths, report: Report
) -> None:
    """Report indexes past the end, in the rules of enums and in behaviours of this file."""
    read = [(condition_of(rule), enum.source) for enum in enums for rule in enum.rules]
    carried = {c.key: c for component in components for c in component.communications}
    read += [(c.expect, c.response) for c in carried.values() if c.expect is not None]
    for component in components:
        for transition in component.transitions if component.library is None else ():
            if transition.communication in carried:
                type_ = carried[transition.communication].value_type(transition.event)
                guard = [] if transition.guard is None else [transition.guard]
                read += [(e, type_) for e in (*guard, *(a.value for a in transition.assignments))]
    for expr, type_ in read:
        _check(expr, type_, lengths, report)


def _check(expr: Expr, type_: Type, lengths: Lengths, report: Report) -> None:
    for part in walk(expr):
        if not isinstance(part, ValueRef) or part.span is None:
            continue
        for index, (length, field) in _fixed(part.path, type_, lengths):
            if index >= length:
                report.add(
                    "field-index",
                    part.span,
                    f"{field} has {length} elements, so there is no [{index}]",
                    f"the last one is [{length - 1}]",
                )


def has_open_index(path: tuple[str | int, ...], type_: Type, lengths: Lengths) -> bool:
    """Whether a path leads to an element of an array that may be shorter."""
    return sum(isinstance(step, int) for step in path) > len(list(_fixed(path, type_, lengths)))


def _fixed(
    path: tuple[str | int, ...], type_: Type | None, lengths: Lengths
) -> Iterator[tuple[int, tuple[int, str]]]:
    """The indexes on a path into arrays of fixed length, each with the entry of ``lengths``."""
    array: tuple[ObjectType, str] | None = None
    for step in path:
        if isinstance(step, int):
            if array is not None and array in lengths:
                yield step, lengths[array]
            array = None
            type_ = type_.element if isinstance(type_, ArrayType) else None
        elif isinstance(type_, ObjectType):
            array = (type_, step)
            type_ = type_.property(step)
