"""What generated code takes from ROS messages, and what it puts into them."""

from __future__ import annotations

from collections.abc import Iterator

from robosc.emit.controller import attribute_names, naming, python, template_data
from robosc.expr import traversal, tree, types
from robosc.language.events import EventKind, command_key
from robosc.model import entities
from robosc.model.declarations.state_variables import all_expressions
from robosc.model.typing.command_values import fold_text
from robosc.plant import automaton, event_values, python_text


def reading(
    event: automaton.Event, robot: entities.Robot, attributes: python.Attributes
) -> tuple[str | None, tuple[tuple[str, str], ...]]:
    """How the event's value is taken from ``message``: one expression, or entries by path."""
    type_ = event_values.value_type(robot, event)
    if isinstance(type_, types.NoneType):
        return None, ()
    sort = robot.communications[event.key].sort.event(event.kind)
    optional = event_values.is_optional(robot, event)
    binding = robot.communications[event.key].binding
    message = "given(message)" if optional else "message"
    carried = type_.source if isinstance(type_, types.EnumType) else type_
    if isinstance(carried, types.ObjectType) and isinstance(type_, types.ObjectType):
        lines = []
        for path, part_type in event_values.value_parts(robot, event).items():
            text = python.converted(part_type, python.access(message, path), attributes)
            if optional or not traversal.all_names(path):
                text = f"optional(lambda: {text})"
            lines.append((python.literal(traversal.path_text(path)), text))
        return ("dict" if lines else None), tuple(lines)
    root = message
    if not isinstance(carried, types.ObjectType):
        assert sort is not None
        name = getattr(binding, f"{sort.brings}_field")
        root = (
            f"{message}.{naming.field_attribute(name)}"
            if name is not None
            else f"getattr({message}, only_field({message}))"
        )
    text = python.converted(type_, root, attributes)
    return f"optional(lambda: {text})" if optional else text, ()


def corrected_data(
    key: str, robot: entities.Robot, attributes: python.Attributes
) -> tuple[str, ...]:
    """The statements that return which fields of another controller's command are set, and the
    correction that says so; empty if it is not corrected."""
    if key not in robot.corrected:
        return ()
    provides = [provide for provide in robot.provides if provide.communication == key]
    lines: list[str] = []
    for provide in provides:
        text = _fields(provide, robot.commands[key], attributes)
        place = python.literal(provide.span.place)
        told = f"{python.literal(fold_text(provide.span.text))}, {place}"
        if provide.condition is None:
            return (*lines, f"return {text}, {told}")
        condition = attributes.text(provide.condition)
        if traversal.may_be_undefined(provide.condition):
            condition = f"self.holds(lambda: {condition}, {python.literal(provide.span.place)})"
        lines += [f"if {condition}:", f"    return {text}, {told}"]
    return (*lines, "return None")


def provided_data(
    key: str, robot: entities.Robot, attributes: python.Attributes
) -> tuple[str, ...]:
    """The statements that return the fields that a command sets; empty if it provides none, or
    corrects what another controller provides."""
    provides = [p for p in robot.provides if p.communication == key and key not in robot.corrected]
    lines: list[str] = []
    for provide in provides:
        where, text = provide.span.place, _fields(provide, robot.commands[key], attributes)
        if provide.condition is None:
            lines += [f"# {where}", f"return {text}"]
        else:
            condition = attributes.text(provide.condition)
            lines += [f"if {condition}:  # {where}", f"    return {text}"]
    if provides and all(provide.condition is not None for provide in provides):
        lines.append("return None")
    return tuple(lines)


def refusals(
    robot: entities.Robot, attributes: python.Attributes, names: naming.PythonNames
) -> Iterator[template_data.RefusalView]:
    """The data that provide statements give to errors of calls that are served."""
    for key, communication in robot.communications.items():
        command = command_key(key, EventKind.REFUSAL)
        if communication.sort.served:
            body = provided_data(command, robot, attributes)
            if body:
                name = names.take(f"data_for_error_of_{attribute_names.word_of(key, robot)}")
                yield template_data.RefusalView(key, name, body)


def _fields(
    provide: entities.Provide, command: entities.Command, attributes: python.Attributes
) -> str:
    """A dict of the fields that a provide statement sets, as Python source."""
    text = _data(provide.data, command.type, attributes)
    if isinstance(command.type, types.ObjectType | types.NoneType):
        return text
    return f"{{{python.literal(command.field or '')}: {text}}}"


def _data(data: entities.Data, type_: types.Type, attributes: python.Attributes) -> str:
    if isinstance(data, entities.DataObject):
        parts = [
            f"{python.literal(name)}: {_data(value, _property(type_, name), attributes)}"
            for name, value in data.fields
        ]
        return "{" + ", ".join(parts) + "}"
    if isinstance(data, entities.DataArray):
        element = type_.element if isinstance(type_, types.ArrayType) else types.NoneType()
        return f"[{', '.join(_data(value, element, attributes) for value in data.elements)}]"
    if isinstance(data, tree.Literal) and isinstance(type_, types.ArrayType | types.ObjectType):
        return python.literal(data.value)
    if isinstance(data, tree.Aggregate) and data.makes_array:
        return attributes.text(data)
    if isinstance(type_, types.ArrayType | types.ObjectType):
        return f"copied({attributes.text(data)})"
    if isinstance(type_, types.DoubleType) and isinstance(data.type, types.IntegerType):
        # A message's floating point field takes a float, not an integer.
        if isinstance(data, tree.Literal) and isinstance(data.value, int):
            return repr(float(data.value))
        widen = "widen" if python_text.may_be_huge(data) else "float"
        return f"{widen}({attributes.text(data)})"
    return attributes.text(data)


def _property(type_: types.Type, name: str) -> types.Type:
    property_ = type_.property(name) if isinstance(type_, types.ObjectType) else None
    return types.NoneType() if property_ is None else property_


def converting_enums(robot: entities.Robot) -> list[types.EnumType]:
    """All enums that convert something, those that others use first."""
    enums: dict[types.EnumType, None] = {}

    def visit(type_: types.Type) -> None:
        for _, part in types.innermost(type_):
            if isinstance(part, types.EnumType):
                visit(part.source)
                for rule in part.rules:
                    convert(tree.condition_of(rule))
                enums.setdefault(part, None)

    def convert(expr: tree.Expr) -> None:
        for part in traversal.walk(expr):
            if isinstance(part, tree.Convert):
                visit(part.type)

    for communication in robot.communications.values():
        for direction in communication.sort.received:
            visit(getattr(communication, direction))
    for expr in all_expressions(robot):
        convert(expr)
    return list(enums)


def enum_view(enum: types.EnumType, attributes: python.Attributes) -> template_data.EnumView:
    """The function that converts a received value to an enum."""
    parameters = [attributes.parameters[key] for key in python.converter_parameters(enum)]
    return template_data.EnumView(
        attributes.enums[enum],
        enum.name,
        ("value", *["undefined"] * python.converter_counts(enum), *parameters),
        (*_rules(enum, attributes), f"return {python.literal(enum.default)}"),
    )


def _rules(enum: types.EnumType, attributes: python.Attributes) -> Iterator[str]:
    """The statements of an enum's function: the first rule that holds decides."""
    for rule in enum.rules:
        condition = tree.condition_of(rule)
        where = "" if condition.span is None else condition.span.place
        indent = "    " if traversal.may_be_undefined(condition) else ""
        if indent:
            yield "try:"
        yield f"{indent}if {python.in_enum_rule(condition, attributes)}:  # {where}"
        yield f"{indent}    return {python.literal(rule.value)}"
        if indent:
            yield "except IndexError:"
            yield f"    undefined({python.literal(where)})"
