"""The check that a type of the model fits a field of a message."""

from __future__ import annotations

from robosc.expr import types
from robosc.model.ros.interfaces import INTEGERS, FieldType


def misfit(type_: types.Type, field: FieldType, sending: bool) -> tuple[str, str] | None:
    """Code and text of the error that a type does not fit a field; None if it fits."""
    if isinstance(type_, types.EnumType):
        return misfit(type_.source, field, sending)
    if isinstance(type_, types.ArrayType):
        if not field.is_array:
            return "field-kind", f"it is not an array, {type_} does not fit"
        return misfit(type_.element, field.element, sending)
    if field.is_array:
        return "field-kind", f"it is an array, {type_} does not fit; write array({type_})"
    if not _kind_fits(type_, field, sending):
        return "field-kind", _kind_words(type_, field)
    if sending and isinstance(type_, types.IntegerType) and type_.bounds is not None:
        return too_wide(type_.bounds, field, str(type_))
    return None


def _kind_fits(type_: types.Type, field: FieldType, sending: bool) -> bool:
    base = field.base
    floating = base in ("float32", "float64")
    match type_:
        case types.BooleanType():
            return base == "bool"
        case types.StringType():
            return base == "string"
        case types.IntegerType():
            return base in INTEGERS or (sending and floating)
        case types.DoubleType():
            return floating or (not sending and base in INTEGERS)
        case types.ObjectType():
            return field.is_message
    return False


def _kind_words(type_: types.Type, field: FieldType) -> str:
    if isinstance(type_, types.DoubleType) and field.base in INTEGERS:
        return "a double cannot be sent through it; use integer"
    if isinstance(type_, types.IntegerType) and field.base in ("float32", "float64"):
        return "the field is not an integer; use double"
    if field.is_message:
        return f"it is a message itself, {type_} does not fit; use an object"
    if isinstance(type_, types.ObjectType):
        return f"it has no fields of its own, the object {type_} does not fit"
    return f"{type_} does not fit"


def too_wide(bounds: tuple[int, int], field: FieldType, what: str) -> tuple[str, str] | None:
    """Code and text of the error that a range does not fit a field of integers, or None."""
    if field.base not in INTEGERS:
        return None
    low, high = INTEGERS[field.base]
    if low <= bounds[0] and bounds[1] <= high:
        return None
    return "field-range", f"it takes {low} to {high}, {what} does not fit"
