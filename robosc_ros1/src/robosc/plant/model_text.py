"""Expressions as the text of a model."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from typing import Any

from robosc import dotted
from robosc.expr import traversal, tree, types
from robosc.expr.undefined_data import asked_for, with_presence_written
from robosc.language.keywords import escape
from robosc.language.operators import BINARY, UNARY, Spelled
from robosc.model import automata, entities
from robosc.names import copy_name
from robosc.plant.counting import copies_of, with_counts
from robosc.plant.logic import exact
from robosc.runtime.core.values import NOW

_ATOM = 9
_UNARY_LEVEL = UNARY["!"].level


def to_dsl(
    expr: tree.Expr,
    robot: entities.Robot,
    spelled: Callable[[tree.Leaf], str | None] = lambda leaf: None,
    *,
    is_part: bool = False,
    element: tuple[str, str] = ("", ""),
) -> str:
    """Return the expression as model text, as in a requirement.

    Tests of the plant are written as the model has them. ``spelled`` may give a leaf another text.
    ``is_part``: the text is to be used within a requirement, not as the whole condition.
    ``element`` is a component, and the variable that stands for it.
    """
    component_names = {component.name for component in robot.components}
    lasting = {condition.name for condition in robot.lasting}

    def owner(component: str) -> str:
        return element[1] if component == element[0] else escape(component)

    def phases_of(node: tree.PhaseRef) -> tuple[str, ...]:
        phases = robot.communications[node.communication].phases
        return () if phases is None else phases.names

    def leaf(node: tree.Leaf) -> str:
        match node:
            case _ if (text := spelled(node)) is not None:
                return text
            case tree.TestRef(name=name) | tree.ChoiceRef(path=(str(name),)):
                return name
            case tree.ReasonRef():
                return "reason"
            case tree.StateRef(component=component, state=name) if component in lasting:
                path = ".".join(map(escape, dotted.parts(component)))
                return path if name == automata.HOLDING else f"!{path}"
            case (
                tree.VariableRef(component=component, variable=name)
                | tree.StateRef(component=component, state=name)
            ):
                path = ".".join(map(escape, dotted.parts(name.replace(" ", "."))))
                return f"{owner(component)}.{path}"
            case tree.ParameterRef(parameter=parameter):
                return ".".join(escape(part) for part in dotted.parts(parameter.key))
            case tree.PhaseRef(communication=key, phase=phase):
                name = robot.display_names[key]
                component, own = dotted.first(key), dotted.inside(key)
                if component == element[0] or name in component_names:
                    name = f"{owner(component)}.{escape(own)}"
                else:
                    name = ".".join(escape(part) for part in dotted.parts(name))
                # In models, a message that has never been heard is silent, too.
                if phase == "silent":
                    return f"({name}.heard and {name}.silent)"
                if phase == "busy" and not node.within and "ending" in phases_of(node):
                    return f"({name}.busy and !{name}.ending)"  # what is ending is busy, too
                return f"{name}.{phase}"
            case tree.ValueRef(path=path):
                return "value" + _parts(path)
            case tree.ElementRef(variable=name, path=path):
                return escape(name) + _parts(path)

    def of_leaf(node: tree.Literal | tree.Leaf) -> Spelled:
        if isinstance(node, tree.Count):

            def text(one: tree.Expr, element: tuple[str, str]) -> str:
                return to_dsl(one, robot, spelled, is_part=True, element=element)

            return _count_text(node, text, component_names)
        if not isinstance(node, tree.Literal):
            return Spelled(leaf(node), _ATOM)
        negative = not isinstance(node.value, bool | str) and str(node.value)[0] == "-"
        return Spelled(_constant_text(node.value, node.type), _UNARY_LEVEL if negative else _ATOM)

    def of_operation(node: tree.Operation, operands: tuple[Spelled, ...]) -> Spelled:
        match node:
            case tree.Convert(argument=argument, type=enum):
                if _is_element(argument, enum):
                    return operands[0]
                own = enum.origin == robot.name
                name = enum.name if own else f"{escape(enum.origin)}.{enum.name}"
                return Spelled(f"{name}({operands[0].text})", _ATOM)
            case tree.Part(path=path):
                return Spelled(f"{operands[0]:{_ATOM}}{_parts(path)}", _ATOM)
            case tree.Made(names=names):
                parts = [text.text for text in operands]
                named = [f"{escape(n)}: {p}" for n, p in zip(names, parts, strict=False)]
                listed = f"{{ {', '.join(named)} }}" if names else f"[{', '.join(parts)}]"
                return Spelled(listed, _ATOM)
            case tree.Holds():
                return Spelled(f"defined({text_of(asked_for(node))})", _ATOM)
            case tree.Call(operator="sector", operands=(ranges, *_)) if (
                scan := traversal.without_last(ranges)
            ):
                operands = (Spelled(text_of(scan), _ATOM), *operands[-2:])
        return node.operation.text.of(operands)

    def of_aggregate(
        node: tree.Aggregate, array: Spelled, visit: Callable[[tree.Expr], Spelled]
    ) -> Spelled:
        names = ", ".join(filter(None, (node.position, node.variable)))
        through = f"{visit(node.element).text} for {names} in {array.text}"
        condition = "" if node.condition is None else f" if {visit(node.condition).text}"
        return node.operation.text.of([Spelled(f"{through}{condition}", _ATOM)])

    def text_of(written: tree.Expr) -> str:
        return traversal.fold(written, of_leaf, of_operation, bound=of_aggregate).text

    return text_of(with_presence_written(exact(with_counts(expr, robot)), not is_part))


def _is_element(argument: tree.Expr, enum: types.EnumType) -> bool:
    """Whether it is an element of an array of an enum: the model does not write its conversion."""
    return (
        isinstance(argument, tree.Call)
        and argument.operator == "element"
        and argument.operands[0].type == types.ArrayType(enum)
    )


def _count_text(
    count: tree.Count,
    text: Callable[[tree.Expr, tuple[str, str]], str],
    components: Collection[str],
) -> Spelled:
    """``count(s.served for s in Station[1..3]) < 2``, or ``count(x for x in [A.busy, …]) < 2``."""
    copies = copies_of(count)
    shown = count.conditions[: 1 if copies else None]
    taken = {*components, *(name for one in shown for name in _bare_names(one))}
    letter = "x" if copies is None else copies[0][0].lower()
    name = next(n for n in (letter * length for length in range(1, 99)) if n not in taken)
    if copies is None:
        texts = ", ".join(text(one, ("", "")) for one in shown)
        inner = f"({name} for {name} in [{texts}])"
    else:
        kind, low = copies
        high = low + len(count.conditions) - 1
        is_whole = {copy_name(kind, low - 1), copy_name(kind, high + 1)}.isdisjoint(components)
        array = escape(kind) if is_whole else f"{escape(kind)}[{low}..{high}]"
        inner = f"({text(shown[0], (copy_name(kind, low), name))} for {name} in {array})"
    if count.least in (1, len(count.conditions)):
        function = "any" if count.least == 1 else "all"
        return Spelled("!" * count.negated + function + inner, _UNARY_LEVEL)
    sign = "<" if count.negated else ">="
    return Spelled(f"count{inner} {sign} {count.least}", BINARY[sign].level)


def _bare_names(expr: tree.Expr) -> Iterator[str]:
    """The names in the text of a condition that stand behind no component's."""
    for part in traversal.walk(exact(expr)):
        match part:
            case tree.Literal(value=str() as name) | tree.ElementRef(variable=name):
                yield name
            case tree.ParameterRef(parameter=parameter):
                yield from dotted.parts(parameter.key)
            case tree.Aggregate(variable=name, position=position):
                yield from (name, position)


def _parts(path: tuple[str | int, ...]) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{escape(part)}" for part in path)


def _constant_text(value: Any, type_: types.Type) -> str:
    if isinstance(value, dict):
        fields = dict(type_.properties) if isinstance(type_, types.ObjectType) else {}
        parts = (f"{escape(n)}: {_constant_text(v, fields[n])}" for n, v in value.items())
        return "{ " + ", ".join(parts) + " }"
    if isinstance(value, tuple):
        element = type_.element if isinstance(type_, types.ArrayType) else type_
        return f"[{', '.join(_constant_text(v, element) for v in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is NOW:
        return str(value)
    if isinstance(value, str):
        if isinstance(type_, types.StringType):
            escaped = value.replace("\\", "\\\\").replace('"', '\\"')
            return '"' + escaped.replace("\n", "\\n").replace("\t", "\\t") + '"'
        return escape(value)
    if isinstance(value, float) and not math.isfinite(value):
        return f"({0 if value != value else math.copysign(1.0, value):g} / 0)"
    text = repr(value)
    # Exponents as people write them: 1E16, not 1e+16.
    return text.replace("e+", "E").replace("e-", "E-") if isinstance(value, float) else text
