"""Expressions and types of the model as Python source."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from typing import Any

from robosc.emit.controller import python_literals
from robosc.emit.controller.naming import field_attribute
from robosc.expr import traversal, tree, types
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Robot
from robosc.plant import counting, logic, places, python_text
from robosc.runtime.core.values import NOW

Path = tuple[str | int, ...]

_LOCATION = "\0location"  # no variable can be called so


@dataclass(frozen=True)
class PythonCode:
    """The Python source of an expression, and what happens when it is evaluated.

    ``reads`` are attributes of the controller, those that called requirements read included.
    ``mismatches`` says that a value outside a range may raise Mismatch.
    """

    text: str
    reads: frozenset[str] = frozenset()
    mismatches: bool = False

    def __bool__(self) -> bool:
        return bool(self.text)


def joined(operator: str, codes: Iterable[PythonCode]) -> PythonCode:
    """The operands, those that are not empty, with an operator between them."""
    parts = [code for code in codes if code]
    return PythonCode(
        f" {operator} ".join(code.text for code in parts),
        frozenset().union(*(code.reads for code in parts)),
        any(code.mismatches for code in parts),
    )


@dataclass(frozen=True)
class Attributes:
    """The controller's attributes, and expressions over them as Python source.

    They are given by component (its state), ``Component.variable``, and key and phase (whether the
    communication is in it; in its first phase it is in none of the others).

    ``entries`` are those that count how often a component entered a state, or entered or left one
    with states in it (``Component.state``), ``parameters`` those
    that hold parameters, by their keys. ``parts`` are methods, by the names of parts of guards.
    """

    robot: Robot
    locations: Mapping[str, str]
    variables: Mapping[str, str]
    phases: Mapping[tuple[str, str], str]
    enums: Mapping[types.EnumType, str]
    entries: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, str] = field(default_factory=dict)
    parts: Mapping[str, str] = field(default_factory=dict)
    lasting: Mapping[str, str] = field(default_factory=dict)
    """The methods for what lasting conditions are about, by their names."""

    def text(self, expr: tree.Expr) -> str:
        """An expression over the controller's state and an event's ``value``.

        The value of a basic type or enum is a plain one, that of an object a dict by path. What did
        not come is None there.
        """

        def leaf(node: tree.Leaf) -> str:
            return _in_controller(node, self)

        def convert(enum: types.EnumType, text: str) -> str:
            return converted(enum, text, self)

        def part(node: tree.Part, whole: str) -> str:
            return converted(node.carried, defined_access(whole, node.path), self)

        return python_text.to_python(self._spread(expr), leaf, _constant, convert, part)

    def _spread(self, expr: tree.Expr) -> tree.Expr:
        """The expression as it is written: a state may stand for several, and be a chain then."""
        counted = counting.with_counts(expr, self.robot, chains=False)
        return _spread(places.written_out(logic.exact(counted)))

    def operand(self, expr: tree.Expr) -> str:
        """The text of a condition as an operand of ``and``."""
        written, text = self._spread(expr), self.text(expr)
        weak = isinstance(written, tree.Binary) and written.operator in ("or", "=>")
        return f"({text})" if weak else text

    def code(self, expr: tree.Expr) -> PythonCode:
        """An expression without named parts, and what evaluating it reads and raises."""
        read = logic.exact(expr)
        return PythonCode(
            self.text(expr),
            frozenset(self._read_by(read)),
            any(
                isinstance(part, tree.ElementRef | tree.Part) and _ranged(part.carried)
                for part in traversal.walk(read)
            ),
        )

    def _read_by(self, expr: tree.Expr) -> Iterator[str]:
        for parameter in traversal.parameters_of(expr):
            yield self.parameters[parameter.key]
        for part in traversal.walk(expr):
            match part:
                case tree.StateRef(component=component):
                    yield self.locations[component]
                case tree.VariableRef(key=key):
                    yield self.variables[key]
                case tree.PhaseRef(communication=key, places=phases):
                    yield from (self.phases[key, phase] for phase in phases)


def read_by(codes: Iterable[PythonCode], more: Iterable[str] = ()) -> tuple[str, ...]:
    """The attributes that some code reads, and ``more``."""
    return tuple(sorted(joined("and", codes).reads.union(more)))


def _ranged(type_: types.Type) -> bool:
    return isinstance(type_, types.IntegerType) and type_.bounds is not None


def literal(value: Any) -> str:
    """A value of the model as Python source; an array is a list there."""
    if value is NOW:
        return "now()"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(n)}: {literal(v)}" for n, v in value.items()) + "}"
    if isinstance(value, tuple):
        return f"[{', '.join(map(literal, value))}]"
    return python_literals.literal(value)


def _constant(node: tree.Literal) -> str:
    """A constant in an expression; the fields of objects are read there."""
    return readable(node.value)


def readable(value: Any) -> str:
    """A value as Python source that reads the fields of objects as those of messages."""
    if isinstance(value, dict):
        fields = (f"{field_attribute(name)}={readable(part)}" for name, part in value.items())
        return f"record({', '.join(fields)})"
    if isinstance(value, tuple):
        return f"[{', '.join(map(readable, value))}]"
    return literal(value)


def _in_controller(node: tree.Leaf, attributes: Attributes) -> str:
    match node:
        case tree.VariableRef(component=component, variable=name):
            if name == _LOCATION:
                return f"self.{attributes.locations[component]}"
            text = f"self.{attributes.variables[f'{component}.{name}']}"
            return (
                f"given({text})"
                if isinstance(node.type, types.ArrayType | types.ObjectType)
                else text
            )
        case tree.StateRef() | tree.TestRef():
            raise AssertionError("states and tests are spread before")
        case tree.PhaseRef(communication=key, phase=phase):
            return f"self.{attributes.phases[key, phase]}"
        case tree.ParameterRef(parameter=parameter):
            return f"self.{attributes.parameters[parameter.key]}"
        case tree.Count(conditions=conditions, least=least, negated=negated):
            texts = ", ".join(map(attributes.text, conditions))
            return f"sum(({texts})) {'<' if negated else '>='} {least}"
        case tree.NamedPart(variable=name):
            return f"self.{attributes.parts[name]}()"
        case tree.ReasonRef():
            return "self.reason"
        case tree.ValueRef(path=(), type=type_, optional=optional):
            whole = 'value[""]' if isinstance(type_, types.ObjectType) else "value"
            return f"given({whole})" if optional else whole
        case tree.ElementRef(variable=name, path=path):
            return converted(node.carried, access(python_text.element_name(name), path), attributes)
        case tree.ValueRef(path=path, optional=optional):
            part = f"value[{literal(traversal.path_text(path))}]"
            return part if traversal.all_names(path) and not optional else f"given({part})"


def _spread(expr: tree.Expr) -> tree.Expr:
    """State tests as comparisons of the component's state, which need fewer parentheses."""

    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        if isinstance(node, tree.Count) and node.least in (1, len(node.conditions)):
            chain = logic.disjunction if node.least == 1 else logic.conjunction
            whole = chain(node.conditions)
            return _spread(logic.negation(whole) if node.negated else whole)
        return _state_test("=", node) if isinstance(node, tree.StateRef) else node

    def negated(node: tree.Expr) -> tree.Expr | None:
        match node:
            case tree.Unary(operator="!", operand=tree.StateRef() as state):
                return _state_test("!=", state)
            case tree.Unary(operator="!", operand=tree.Binary(operator="=" | "!=") as same):
                return _spread(logic.negation(same))
            case tree.Binary(
                operator="=>", left=tree.Binary(operator="=" | "!=") as same, right=right
            ):
                return _spread(tree.Binary("or", logic.negation(same), right, types.BooleanType()))
        return None

    return traversal.fold(expr, leaf, traversal.with_operands, known=negated)


def _state_test(operator: str, state: tree.StateRef) -> tree.Binary:
    text = types.StringType()
    location = tree.VariableRef(state.component, _LOCATION, text)
    return tree.Binary(operator, location, tree.Literal(state.state, text), types.BooleanType())


def in_enum_rule(expr: tree.Expr, attributes: Attributes) -> str:
    """An expression over the raw ``value`` that an enum converts, in the enum's function."""

    def leaf(node: tree.Leaf) -> str:
        match node:
            case tree.ValueRef(path=path):
                return convert(node.type, access("value", path))
            case tree.ElementRef(variable=name, path=path):
                return convert(node.carried, access(python_text.element_name(name), path))
            case tree.ParameterRef(parameter=parameter):
                return attributes.parameters[parameter.key]
        raise TypeError(f"{node} in the rule of an enum")

    def convert(type_: types.Type, text: str) -> str:
        return converted(type_, text, attributes, in_rule=True)

    def part(node: tree.Part, whole: str) -> str:
        return convert(node.carried, defined_access(whole, node.path))

    return python_text.to_python(expr, leaf, _constant, convert, part)


def access(root: str, path: Path) -> str:
    """A part of a ROS message by attributes and indexes."""
    return root + "".join(
        f"[{part}]" if isinstance(part, int) else f".{field_attribute(part)}" for part in path
    )


def defined_access(root: str, path: Path) -> str:
    """A part of what is stored or computed, which is undefined where an array is too short."""
    text = root
    for part in path:
        if isinstance(part, int):
            text = f"element({text}, {part})"
        else:
            text = f"{text}.{field_attribute(part)}"
    return text


def converted(
    type_: types.Type, text: str, attributes: Attributes, *, in_rule: bool = False
) -> str:
    """What came in as a value of the language: enums applied, ranges checked.

    The function of an enum gets all that it needs as arguments; ``in_rule`` says that it is called
    in another one.
    """
    match type_:
        case types.EnumType():
            here = "" if in_rule else "self."
            counter = "undefined" if in_rule else "self.count_undefined"
            arguments = [text, *([counter] if converter_counts(type_) else [])]
            arguments += [here + attributes.parameters[key] for key in converter_parameters(type_)]
            return f"{attributes.enums[type_]}({', '.join(arguments)})"
        case types.IntegerType(bounds=(low, high)):
            return f'in_range({text}, {low}, {high}, "the value")'
    return text


def converter_counts(enum: types.EnumType) -> bool:
    """Whether a rule of the enum can be undefined, so that its function takes a counter."""
    for rule in enum.rules:
        if traversal.may_be_undefined(tree.condition_of(rule)):
            return True
        for part in traversal.walk(tree.condition_of(rule)):
            reads = isinstance(part, tree.ValueRef | tree.ElementRef | tree.Part)
            if reads and isinstance(part.type, types.EnumType) and converter_counts(part.type):
                return True
    return False


def converter_parameters(enum: types.EnumType) -> tuple[str, ...]:
    """The parameters, by key, that the rules of an enum read, those of enums in them included."""
    found = (p.key for rule in enum.rules for p in traversal.parameters_of(tree.condition_of(rule)))
    return tuple(dict.fromkeys(found))


def duration(expr: tree.Expr) -> float | str:
    """A duration in seconds, or the name of the parameter that says it."""
    if isinstance(expr, tree.ParameterRef):
        return expr.parameter.name
    assert isinstance(expr, tree.Literal)
    return float(expr.value)
