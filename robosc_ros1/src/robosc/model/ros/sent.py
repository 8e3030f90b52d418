"""The check of provided data against fields: ranges of integers, lengths of arrays."""

from __future__ import annotations

from collections.abc import Sequence

from robosc.expr import evaluation, types
from robosc.expr.tree import Expr, ParameterRef, VariableRef
from robosc.expr.types import IntegerType
from robosc.language.events import Direction
from robosc.model import diagnostics, entities
from robosc.model.ros import interfaces
from robosc.model.ros.definitions import BASIC, MessageDefinitions

# The check that a type of the model fits a field of a message.


def misfit(type_: types.Type, field: interfaces.FieldType, sending: bool) -> tuple[str, str] | None:
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


def _kind_fits(type_: types.Type, field: interfaces.FieldType, sending: bool) -> bool:
    word = interfaces.WORDS.get(field.base)
    match type_:
        case types.IntegerType():
            return word == "integer" or (sending and word == "double")
        case types.DoubleType():
            return word == "double" or (not sending and word == "integer")
        case types.ObjectType():
            return field.is_message
    return word == str(type_)


def _kind_words(type_: types.Type, field: interfaces.FieldType) -> str:
    if isinstance(type_, types.DoubleType) and field.base in interfaces.INTEGERS:
        return "a double cannot be sent through it; use integer"
    if isinstance(type_, types.IntegerType) and field.base in ("float32", "float64"):
        return "the field is not an integer; use double"
    if field.is_message:
        return f"it is a message itself, {type_} does not fit; use an object"
    if isinstance(type_, types.ObjectType):
        return f"it has no fields of its own, the object {type_} does not fit"
    return f"{type_} does not fit"


def too_wide(
    bounds: tuple[int, int], field: interfaces.FieldType, what: str
) -> tuple[str, str] | None:
    """Code and text of the error that a range does not fit a field of integers, or None."""
    if field.base not in interfaces.INTEGERS:
        return None
    low, high = interfaces.INTEGERS[field.base]
    if low <= bounds[0] and bounds[1] <= high:
        return None
    return "field-range", f"it takes {low} to {high}, {what} does not fit"


def carrier(
    definitions: MessageDefinitions, communication: entities.Communication, direction: Direction
) -> interfaces.Definition | None:
    """The part of a communication's definition with its data in a direction; None if there is no
    definition. Those of basic types need not be installed."""
    package, type_ = communication.binding.package, communication.binding.type
    found = definitions.interface(package, type_, communication.sort.folder)
    if isinstance(found, interfaces.Missing):
        basic = (i for i in BASIC.values() if (i.package, i.type) == (package, type_))
        if (built_in := next(basic, None)) is None:
            return None
        found = built_in
    return found.parts[communication.sort.parts.index(direction)]


class SentData:
    """Checks the provided data of one file."""

    def __init__(self, definitions: MessageDefinitions, report: diagnostics.Report) -> None:
        self._definitions = definitions
        self._report = report

    @property
    def is_for_ros2(self) -> bool:
        return self._definitions.are_for_ros2

    def field_of(
        self, command: entities.Command, path: Sequence[str | int]
    ) -> interfaces.Field | None:
        """The field of a command's data at a path; None if no definition is installed."""
        definition = self._carrier(command)
        field: interfaces.Field | None = None
        for step in path or (command.field or "",):
            if isinstance(step, int):
                field = field and field.element(step)
                continue
            if field is not None:
                inner = self._definitions.fields(field.type)
                definition = inner if isinstance(inner, interfaces.Definition) else None
            field = None if definition is None else definition.field(step)
        return field

    def _carrier(self, command: entities.Command) -> interfaces.Definition | None:
        if not command.communication.binding.found:
            return None
        return carrier(self._definitions, command.communication, command.direction)

    def check(self, data: entities.Data, command: entities.Command) -> None:
        """Check the data of a provide statement for a command."""
        definition = self._carrier(command)
        if definition is not None and isinstance(data, entities.DataObject):
            self._object(data, definition)
        elif definition is not None and (field := definition.field(command.field or "")):
            self._value(data, field.type, f"{definition.name}.{field.name}")

    def _object(self, data: entities.DataObject, definition: interfaces.Definition) -> None:
        for name, value in data.fields:
            field = definition.field(name)
            if field is not None:
                self._value(value, field.type, f"{definition.name}.{name}")

    def _value(self, data: entities.Data, field: interfaces.FieldType, name: str) -> None:
        match data:
            case entities.DataObject():
                nested = self._definitions.fields(field)
                if isinstance(nested, interfaces.Definition):
                    self._object(data, nested)
            case entities.DataArray(elements=elements, span=span):
                if field.length is not None and field.length != len(elements):
                    self._report.add(
                        "field-length",
                        span,
                        f"{name} is {field}: it takes {field.length} elements, not {len(elements)}",
                    )
                for number, element in enumerate(elements):
                    self._value(element, field.element, f"{name}[{number}]")
            case _:
                self._number(data, field, name)

    def _number(self, expr: Expr, field: interfaces.FieldType, name: str) -> None:
        bounds: tuple[int, int] | None = None
        value = evaluation.constant(expr)
        if type(value) is int:
            bounds = (value, value)
        elif isinstance(expr, VariableRef | ParameterRef) and isinstance(expr.type, IntegerType):
            bounds = expr.type.bounds
        if bounds is None or expr.span is None:
            return
        problem = too_wide(bounds, field, str(value) if value is not None else str(expr.type))
        if problem is not None:
            self._report.add(problem[0], expr.span, f"{name} is {field}: {problem[1]}")
