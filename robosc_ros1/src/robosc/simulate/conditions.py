"""Conditions in the language's own syntax, over the state of a whole robot.

They read what requirements read, and more: data-only variables, and the phase of a service or
action as ``grab.busy`` (which is how guards are printed).
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from robosc.errors import Severity
from robosc.model.entities import Component, Robot
from robosc.model.expr import Binary, Expr, Literal, PhaseRef, StateRef, Unary, VariableRef
from robosc.model.types import (
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    StringType,
    Type,
    is_number,
)
from robosc.model.values import comparable, describe
from robosc.simulate.faults import InvalidLine
from robosc.source import Source
from robosc.syntax.nodes import (
    Access,
    BinaryNode,
    ExprNode,
    LiteralNode,
    Name,
    RequirementNode,
    UnaryNode,
)
from robosc.syntax.parser import parse

__all__ = ["condition"]

_BEFORE = "robot r { requirement always "


def condition(text: str, robot: Robot) -> Expr:
    """The condition that a text means. Raises InvalidLine with the reason."""
    expr = _Resolver(robot).typed(_parsed(text), BooleanType())
    if not isinstance(expr.type, BooleanType):
        raise InvalidLine(f"a condition is true or false; this is {describe(expr.type)}")
    return expr


def _parsed(text: str) -> ExprNode:
    if not text.strip():
        raise InvalidLine("a condition is missing, such as Motor.moving and Sensor.value = free")
    tree, diagnostics = parse(Source("condition", _BEFORE + text + "\n}"))
    errors = [d for d in diagnostics if d.severity is Severity.ERROR]
    if errors:
        hint = f" ({errors[0].hint})" if errors[0].hint else ""
        column = max(1, min(errors[0].span.start - len(_BEFORE), len(text)) + 1)
        raise InvalidLine(
            f"'{text}' is no condition: {errors[0].message}{hint} at column {column} of it"
        )
    found = tree.declarations if tree is not None else ()
    if len(found) != 1 or not isinstance(found[0], RequirementNode):
        raise InvalidLine(f"'{text}' is no condition")
    return found[0].condition


class _Resolver:
    """Finds out what names mean; the other side of a comparison decides between enum values."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.components = {c.name: c for c in robot.components}
        enums = {
            v.type for c in robot.components if c.behaviour for v in c.behaviour.variables
            if isinstance(v.type, EnumType)
        }  # fmt: skip
        self.enums = sorted(enums, key=lambda e: (e.name, e.origin))

    def typed(self, node: ExprNode, wanted: Type | None = None) -> Expr:
        match node:
            case Access():
                return self._access(node, wanted)
            case LiteralNode(value=value):
                return Literal(value, _literal_type(value))
            case UnaryNode(operator=operator):
                operand = self.typed(node.operand)
                _need(operator, operand)
                return Unary(operator, operand, operand.type)
            case BinaryNode(operator="=" | "!="):
                return self._equality(node)
        left, right = self.typed(node.left), self.typed(node.right)
        _need(node.operator, left)
        _need(node.operator, right)
        type_: Type = BooleanType()
        if node.operator in ("+", "-", "*", "/"):
            whole = isinstance(left.type, IntegerType) and isinstance(right.type, IntegerType)
            type_ = IntegerType() if whole and node.operator != "/" else DoubleType()
        return Binary(node.operator, left, right, type_)

    def _equality(self, node: BinaryNode) -> Expr:
        if _is_bare(node.left):
            right = self.typed(node.right)
            left = self.typed(node.left, right.type)
        else:
            left = self.typed(node.left)
            right = self.typed(node.right, left.type)
        if not comparable(left.type, right.type):
            raise InvalidLine(
                f"'{node.operator}' compares two values of one type, not"
                f" {describe(left.type)} and {describe(right.type)}"
            )
        return Binary(node.operator, left, right, BooleanType())

    def _access(self, access: Access, wanted: Type | None) -> Expr:
        name = access.root.text
        rest = [part.text if isinstance(part, Name) else str(part) for part in access.path]
        if not rest:
            return self._bare(name, wanted)
        if rest[-1] == "busy" and (phase := self._phase(".".join([name, *rest[:-1]]))):
            return phase
        if len(rest) > 1:
            raise InvalidLine(f"'{name}.{'.'.join(rest)}' is no state and no variable")
        component = self.components.get(name)
        if component is not None and component.behaviour is not None:
            found = _member(component, rest[0], wanted)
            if found is not None:
                return found
        for enum in self.enums:
            if enum.name == name and rest[0] in enum.values:
                return Literal(rest[0], enum)
        if component is not None:
            members = _members(component)
            raise InvalidLine(
                f"{name} has no state or variable '{rest[0]}'{_nearest(rest[0], members)}"
            )
        raise InvalidLine(f"there is no component '{name}'{_nearest(name, self.components)}")

    def _bare(self, name: str, wanted: Type | None) -> Expr:
        if isinstance(wanted, EnumType):
            if name in wanted.values:
                return Literal(name, wanted)
            known = ", ".join(wanted.values)
            raise InvalidLine(f"{wanted.name} has no value '{name}'; it has {known}")
        owners = [
            f"{c.name}.{name}" for c in self.robot.components if name in _members(c)
        ]  # fmt: skip
        if owners:
            raise InvalidLine(f"write {' or '.join(owners)}, not '{name}' alone")
        raise InvalidLine(
            f"'{name}' means nothing here; write Component.state or Component.variable"
        )

    def _phase(self, name: str) -> PhaseRef | None:
        for key, communication in self.robot.communications.items():
            if communication.has_phase and name in (key, self.robot.display_names[key]):
                return PhaseRef(key)
        return None


def _members(component: Component) -> list[str]:
    behaviour = component.behaviour
    if behaviour is None:
        return []
    return [*(v.name for v in behaviour.variables), *(s.name for s in behaviour.states)]


def _member(component: Component, name: str, wanted: Type | None) -> Expr | None:
    """A variable or a state; where both are called so, the type decides."""
    assert component.behaviour is not None
    variable = next((v for v in component.behaviour.variables if v.name == name), None)
    is_state = any(s.name == name for s in component.behaviour.states)
    if variable is None:
        return StateRef(component.name, name) if is_state else None
    if is_state and isinstance(wanted, BooleanType):
        return StateRef(component.name, name)
    return VariableRef(component.name, name, variable.type)


def _need(operator: str, expr: Expr) -> None:
    if operator in ("and", "or", "=>", "!"):
        if not isinstance(expr.type, BooleanType):
            raise InvalidLine(
                f"'{operator}' needs something true or false, not {describe(expr.type)}"
            )
    elif not is_number(expr.type):
        raise InvalidLine(f"'{operator}' needs a number, not {describe(expr.type)}")


def _is_bare(node: ExprNode) -> bool:
    return isinstance(node, Access) and not node.path


def _literal_type(value: bool | int | float | str) -> Type:
    match value:
        case bool():
            return BooleanType()
        case int():
            return IntegerType()
        case float():
            return DoubleType()
    return StringType()


def _nearest(name: str, names: Iterable[str]) -> str:
    found = get_close_matches(name, list(names), 1)
    return f"; did you mean '{found[0]}'?" if found else ""
