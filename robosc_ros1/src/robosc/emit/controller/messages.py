"""What generated code takes from ROS messages, and what it puts into them."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.emit.controller.attribute_names import word_of
from robosc.emit.controller.naming import PythonNames, field_attribute, place
from robosc.emit.controller.python import (
    Attributes,
    access,
    converted,
    converter_counts,
    converter_parameters,
    in_enum_rule,
    literal,
)
from robosc.emit.controller.template_data import EnumView, RefusalView
from robosc.expr.traversal import all_names, may_be_undefined, path_text, walk
from robosc.expr.tree import Aggregate, Convert, Expr, Literal, condition_of
from robosc.expr.types import (
    ArrayType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    Type,
)
from robosc.language.events import EventKind, command_key
from robosc.model.declarations.state_variables import all_expressions
from robosc.model.entities import (
    Command,
    Data,
    DataArray,
    DataObject,
    Provide,
    Robot,
)
from robosc.model.typing.command_values import fold_text
from robosc.plant.automaton import Event
from robosc.plant.event_values import is_optional, value_parts, value_type
from robosc.plant.python_text import may_be_huge


def reading(
    event: Event, robot: Robot, attributes: Attributes
) -> tuple[str | None, tuple[tuple[str, str], ...]]:
    """How the event's value is taken from ``message``: one expression, or entries by path."""
    type_ = value_type(robot, event)
    if isinstance(type_, NoneType):
        return None, ()
    sort = robot.communications[event.key].sort.event(event.kind)
    optional = is_optional(robot, event)
    binding = robot.communications[event.key].binding
    message = "given(message)" if optional else "message"
    carried = type_.source if isinstance(type_, EnumType) else type_
    if isinstance(carried, ObjectType) and isinstance(type_, ObjectType):
        lines = []
        for path, part_type in value_parts(robot, event).items():
            text = converted(part_type, access(message, path), attributes)
            if optional or not all_names(path):
                text = f"optional(lambda: {text})"
            lines.append((literal(path_text(path)), text))
        return ("dict" if lines else None), tuple(lines)
    root = message
    if not isinstance(carried, ObjectType):
        assert sort is not None
        name = getattr(binding, f"{sort.brings}_field")
        root = (
            f"{message}.{field_attribute(name)}"
            if name is not None
            else f"getattr({message}, only_field({message}))"
        )
    text = converted(type_, root, attributes)
    return f"optional(lambda: {text})" if optional else text, ()


def corrected_data(key: str, robot: Robot, attributes: Attributes) -> tuple[str, ...]:
    """The statements that return which fields of another controller's command are set, and the
    correction that says so; empty if it is not corrected."""
    if key not in robot.corrected:
        return ()
    provides = [provide for provide in robot.provides if provide.communication == key]
    lines: list[str] = []
    for provide in provides:
        text = _fields(provide, robot.commands[key], attributes)
        told = f"{literal(fold_text(provide.span.text))}, {literal(place(provide.span))}"
        if provide.condition is None:
            return (*lines, f"return {text}, {told}")
        condition = attributes.text(provide.condition)
        if may_be_undefined(provide.condition):
            condition = f"self.holds(lambda: {condition}, {literal(place(provide.span))})"
        lines += [f"if {condition}:", f"    return {text}, {told}"]
    return (*lines, "return None")


def provided_data(key: str, robot: Robot, attributes: Attributes) -> tuple[str, ...]:
    """The statements that return the fields that a command sets; empty if it provides none, or
    corrects what another controller provides."""
    provides = [p for p in robot.provides if p.communication == key and key not in robot.corrected]
    lines: list[str] = []
    for provide in provides:
        where, text = place(provide.span), _fields(provide, robot.commands[key], attributes)
        if provide.condition is None:
            lines += [f"# {where}", f"return {text}"]
        else:
            condition = attributes.text(provide.condition)
            lines += [f"if {condition}:  # {where}", f"    return {text}"]
    if provides and all(provide.condition is not None for provide in provides):
        lines.append("return None")
    return tuple(lines)


def refusals(robot: Robot, attributes: Attributes, names: PythonNames) -> Iterator[RefusalView]:
    """The data that provide statements give to errors of calls that are served."""
    for key, communication in robot.communications.items():
        command = command_key(key, EventKind.REFUSAL)
        if communication.sort.served:
            body = provided_data(command, robot, attributes)
            if body:
                name = names.take(f"data_for_error_of_{word_of(key, robot)}")
                yield RefusalView(key, name, body)


def _fields(provide: Provide, command: Command, attributes: Attributes) -> str:
    """A dict of the fields that a provide statement sets, as Python source."""
    text = _data(provide.data, command.type, attributes)
    if isinstance(command.type, ObjectType):
        return text
    return f"{{{literal(command.field or '')}: {text}}}"


def _data(data: Data, type_: Type, attributes: Attributes) -> str:
    if isinstance(data, DataObject):
        parts = [
            f"{literal(name)}: {_data(value, _property(type_, name), attributes)}"
            for name, value in data.fields
        ]
        return "{" + ", ".join(parts) + "}"
    if isinstance(data, DataArray):
        element = type_.element if isinstance(type_, ArrayType) else NoneType()
        return f"[{', '.join(_data(value, element, attributes) for value in data.elements)}]"
    if isinstance(data, Literal) and isinstance(type_, ArrayType | ObjectType):
        return literal(data.value)
    if isinstance(data, Aggregate) and data.makes_array:
        return attributes.text(data)
    if isinstance(type_, ArrayType | ObjectType):
        return f"copied({attributes.text(data)})"
    if isinstance(type_, DoubleType) and isinstance(data.type, IntegerType):
        # A message's floating point field takes a float, not an integer.
        if isinstance(data, Literal) and isinstance(data.value, int):
            return repr(float(data.value))
        widen = "widen" if may_be_huge(data) else "float"
        return f"{widen}({attributes.text(data)})"
    return attributes.text(data)


def _property(type_: Type, name: str) -> Type:
    property_ = type_.property(name) if isinstance(type_, ObjectType) else None
    return NoneType() if property_ is None else property_


def converting_enums(robot: Robot) -> list[EnumType]:
    """All enums that convert something, those that others use first."""
    enums: dict[EnumType, None] = {}

    def visit(type_: Type) -> None:
        match type_:
            case EnumType():
                visit(type_.source)
                for rule in type_.rules:
                    convert(condition_of(rule))
                enums.setdefault(type_, None)
            case ObjectType():
                for _, inner in type_.properties:
                    visit(inner)
            case ArrayType():
                visit(type_.element)

    def convert(expr: Expr) -> None:
        for part in walk(expr):
            if isinstance(part, Convert):
                visit(part.type)

    for communication in robot.communications.values():
        for direction in communication.sort.received:
            visit(getattr(communication, direction))
    for expr in all_expressions(robot):
        convert(expr)
    return list(enums)


def enum_view(enum: EnumType, attributes: Attributes) -> EnumView:
    """The function that converts a received value to an enum."""
    parameters = [attributes.parameters[key] for key in converter_parameters(enum)]
    return EnumView(
        attributes.enums[enum],
        enum.name,
        ("value", *["undefined"] * converter_counts(enum), *parameters),
        (*_rules(enum, attributes), f"return {literal(enum.default)}"),
    )


def _rules(enum: EnumType, attributes: Attributes) -> Iterator[str]:
    """The statements of an enum's function: the first rule that holds decides."""
    for rule in enum.rules:
        condition = condition_of(rule)
        where = "" if condition.span is None else place(condition.span)
        indent = "    " if may_be_undefined(condition) else ""
        if indent:
            yield "try:"
        yield f"{indent}if {in_enum_rule(condition, attributes)}:  # {where}"
        yield f"{indent}    return {literal(rule.value)}"
        if indent:
            yield "except IndexError:"
            yield f"    undefined({literal(where)})"
