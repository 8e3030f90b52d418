"""Expressions and names in CIF, within what its data-based synthesis computes with.

Integers there start at 0, and sums are safest where nothing in between is negative. So a variable
whose range starts below 0 is kept as its distance from that bound (:func:`offset`), and a
comparison is written with every term on the side where it is added: ``x - y < 2`` becomes
``x < y + 2``. What is no such sum (products, divisions, fractions) is written out value by value;
all is finite here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

from robosc.ir.automaton import Plant, VariableKind
from robosc.language.operators import Spelled, Text
from robosc.model.entities import Variable
from robosc.model.evaluation import evaluate
from robosc.model.expr import (
    Binary,
    Call,
    Convert,
    Expr,
    Leaf,
    Literal,
    Operation,
    PhaseRef,
    StateRef,
    VariableRef,
)
from robosc.model.traversal import fold, walk
from robosc.model.types import (
    BooleanType,
    EnumType,
    IntegerType,
    Type,
    Value,
    domain,
    is_number,
)
from robosc.names import without_index

__all__ = ["CifScope", "CifNames", "condition", "in_range", "initial", "offset", "update"]

_RESERVED = (
    "alg alphabet and any attr automaton bool break case const cont continue controllable def der "
    "dict disables disc dist do edge elif else end enum equation event external false final for "
    "from func goto group id if import in initial input int invariant list location marked mod "
    "monitor namespace needs not now or plant post pre print printfile real requirement "
    "return sample self set string sub supervisor svgcopy svgfile svgin svgmove svgout switch "
    "tau text time to true tuple type uncontrollable urgent value void when while div file "
    "abs acos acosh asin asinh atan atanh cbrt ceil cos cosh del empty exp floor fmt ln log "
    "max min pop pow round scale sign sin sinh size sqrt tan tanh bernoulli beta binomial "
    "constant erlang exponential gamma geometric lognormal normal poisson random triangle "
    "uniform weibull "
)
_KEYWORDS = frozenset(_RESERVED.split())
_MOST_REPEATED = 4  # `x + x + x + x`; larger factors are written out value by value


@dataclass
class CifNames:
    """Identifiers already in use, of the specification and of each automaton."""

    taken: set[str] = field(default_factory=set)
    inner: dict[str, set[str]] = field(default_factory=dict)

    def fresh(self, wanted: str) -> str:
        """A name for something of the specification itself."""
        return _unused(wanted, self.taken, frozenset())

    def local(self, automaton: str, wanted: str) -> str:
        """A name inside an automaton, which must not hide one outside."""
        return _unused(wanted, self.inner.setdefault(automaton, set()), self.taken)


def _unused(wanted: str, taken: set[str], others: Iterable[str]) -> str:
    name = without_index(wanted)
    while name in taken or name in others:
        name += "_"
    taken.add(name)
    return f"${name}" if name in _KEYWORDS else name


class CifScope:
    """What everything of a plant is called in CIF."""

    def __init__(self, plant: Plant, names: CifNames) -> None:
        self.plant = plant
        self._names = names
        robot = plant.robot
        self._automata = {c.name: names.fresh(c.name) for c in robot.components}
        self._phases = {
            key: names.fresh(f"{c.name}_phase")
            for key, c in robot.communications.items()
            if c.phases is not None
        }
        self._enums: dict[EnumType, tuple[str, dict[str, str]]] = {}
        for variable in self.variables.values():
            self._declare_enum(variable.type)
        self._locals: dict[tuple[str, str, str], str] = {}

    def _declare_enum(self, type_: Type) -> None:
        if isinstance(type_, EnumType) and type_ not in self._enums:
            name = self._names.fresh(type_.name)
            literals = {v: self._names.fresh(f"{type_.name}_{v}") for v in type_.values}
            self._enums[type_] = (name, literals)

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """The synthesis variables by key."""
        return {
            variable.key: variable
            for component in self.plant.robot.components
            if component.behaviour is not None
            for variable in component.behaviour.variables
            if (VariableKind.DATA, variable.key) in self.plant.variable_index
        }

    def enums(self) -> list[tuple[str, list[str]]]:
        return [(name, list(literals.values())) for name, literals in self._enums.values()]

    def automaton(self, component: str) -> str:
        return self._automata[component]

    def phase(self, communication: str) -> str:
        return self._phases[communication]

    def location(self, component: str, state: str) -> str:
        return self._local(component, "location", state)

    def own_variable(self, key: str) -> str:
        component, _, name = key.partition(".")
        return self._local(component, "variable", name)

    def _local(self, component: str, what: str, wanted: str) -> str:
        key = component, what, wanted
        if key not in self._locals:
            self._locals[key] = self._names.local(component, wanted)
        return self._locals[key]

    def reference(self, leaf: Leaf) -> str:
        match leaf:
            case VariableRef(component=component, variable=variable):
                own = self.own_variable(f"{component}.{variable}")
                return f"{self.automaton(component)}.{own}"
            case StateRef(component=component, state=state):
                return f"{self.automaton(component)}.{self.location(component, state)}"
            case PhaseRef(communication=key, phase=phase):
                return f"{self.phase(key)}.{phase}"
        raise TypeError(leaf)

    def type(self, type_: Type) -> str:
        match type_:
            case EnumType():
                return self._enums[type_][0]
            case IntegerType(bounds=(low, high)):
                shift = offset(type_)
                return f"int[{low + shift}..{high + shift}]"
        return "bool"

    def literal(self, value: Value, type_: Type) -> str:
        if isinstance(type_, EnumType):
            return self._enums[type_][1][str(value)]
        return str(value).lower()


def offset(type_: Type) -> int:
    """What is added to an integer to keep it from 0 upwards."""
    match type_:
        case IntegerType(bounds=(low, _)) if low < 0:
            return -low
    return 0


def initial(context: CifScope, type_: Type, value: Value) -> str:
    if isinstance(type_, IntegerType):
        return str(int(value) + offset(type_))
    return context.literal(value, type_)


# --- booleans ------------------------------------------------------------------------------------

_ATOM = 9


def condition(context: CifScope, expr: Expr, least: int = 0) -> str:
    """A boolean expression; in parentheses if it binds weaker than ``least``."""
    return f"{_boolean(context, expr):{least}}"


def _boolean(context: CifScope, expr: Expr) -> Spelled:

    def whole(node: Expr) -> Spelled | None:
        """A comparison of anything but booleans, and what is told by a function."""
        if isinstance(node, Call) or any(isinstance(part, Convert) for part in _sides(node)):
            return _written_out(context, node)
        if not isinstance(node, Binary) or isinstance(node.left.type, BooleanType):
            return None
        if is_number(node.left.type):
            return _comparison(context, node)
        if isinstance(node.left.type, EnumType):
            sides = (Spelled(_enum(context, side), _ATOM) for side in node.operands)
            return _text(node).of(sides)
        return _constant(evaluate(node, _no_leaf))

    def leaf(node: Literal | Leaf) -> Spelled:
        if isinstance(node, Literal):
            return _constant(node.value)
        return Spelled(context.reference(node), _ATOM)

    def operation(node: Operation, operands: tuple[Spelled, ...]) -> Spelled:
        text = _text(node)
        return text.of(
            Spelled(inner.text, _ATOM) if _same(part, node) else inner
            for part, inner in zip(node.operands, operands, strict=True)
        )

    return fold(expr, leaf, operation, known=whole)


def _text(node: Operation) -> Text:
    text = node.operation.cif
    assert text is not None
    return text


def _constant(value: Value) -> Spelled:
    return Spelled("true" if value else "false", _ATOM)


def _sides(node: Expr) -> tuple[Expr, ...]:
    return node.operands if isinstance(node, Binary) else ()


def _same(part: Expr, node: Operation) -> bool:
    """Whether parentheses can be left out: ``a and (b and c)`` is ``a and b and c``."""
    return (
        isinstance(part, Binary)
        and part.operator == node.operator
        and part.operation.is_lazy
        and not part.operation.right_associative
    )


def _enum(context: CifScope, expr: Expr) -> str:
    if isinstance(expr, Literal):
        return context.literal(expr.value, expr.type)
    assert isinstance(expr, VariableRef)
    return context.reference(expr)


def _no_leaf(leaf: Leaf) -> Value | None:
    raise TypeError(leaf)


# --- integers ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Sum:
    """``terms`` (variable to factor, never 0) and a constant, over the variables' own values."""

    terms: Mapping[VariableRef, int]
    constant: int

    def plus(self, other: _Sum, factor: int = 1) -> _Sum:
        terms = dict(self.terms)
        for variable, count in other.terms.items():
            terms[variable] = terms.get(variable, 0) + factor * count
        kept = {variable: count for variable, count in terms.items() if count}
        return _Sum(kept, self.constant + factor * other.constant)

    def shifted(self) -> _Sum:
        """The same number, told by the variables as CIF keeps them."""
        moved = sum(count * offset(variable.type) for variable, count in self.terms.items())
        return _Sum(self.terms, self.constant - moved)

    def span(self) -> tuple[int, int]:
        low = high = self.constant
        for variable, count in self.terms.items():
            values = domain(variable.type)
            assert values is not None
            ends = sorted((count * int(values[0]), count * int(values[-1])))
            low, high = low + ends[0], high + ends[1]
        return low, high


def _sum(expr: Expr) -> _Sum | None:
    """The expression as a sum of variables, None if it is none (or one with large factors)."""
    found = _any_sum(expr)
    if found is None or any(abs(count) > _MOST_REPEATED for count in found.terms.values()):
        return None
    return found


def _any_sum(expr: Expr) -> _Sum | None:
    def leaf(node: Literal | Leaf) -> _Sum | None:
        if isinstance(node, VariableRef):
            return _Sum({node: 1}, 0)
        assert isinstance(node, Literal)
        value = float(node.value)
        return _Sum({}, int(node.value)) if value.is_integer() else None

    return fold(expr, leaf, _linear)


def _linear(node: Operation, operands: tuple[_Sum | None, ...]) -> _Sum | None:
    """Sums, differences and multiples of sums; everything else is none."""
    match node.operator, operands:
        case "-", (_Sum() as inner,):
            return _Sum({}, 0).plus(inner, -1)
        case "+" | "-", (_Sum() as left, _Sum() as right):
            return left.plus(right, 1 if node.operator == "+" else -1)
        case "*", (_Sum() as left, _Sum() as right) if not (left.terms and right.terms):
            terms, factor = (left, right) if left.terms else (right, left)
            return _Sum({}, 0).plus(terms, factor.constant)
    return None


def _added(context: CifScope, sum_: _Sum, sign: int) -> list[str]:
    """The terms that are added (``sign`` 1) or taken away (-1), the constant last."""
    parts = [
        context.reference(variable)
        for variable, count in sum_.terms.items()
        for _ in range(sign * count)
    ]
    if sign * sum_.constant > 0:
        parts.append(str(sign * sum_.constant))
    return parts


def _comparison(context: CifScope, expr: Binary) -> Spelled:
    left, right = _sum(expr.left), _sum(expr.right)
    difference = None if left is None or right is None else left.plus(right, -1).shifted()
    if difference is None:
        return _written_out(context, expr)
    if not difference.terms:
        return _constant(evaluate(expr, _zero))
    sides = (" + ".join(_added(context, difference, sign)) or "0" for sign in (1, -1))
    return _text(expr).of(Spelled(side, _ATOM) for side in sides)


def _zero(leaf: Leaf) -> Value:
    """Any value will do where the terms cancel out."""
    return 0


def _valuations(expr: Expr) -> Iterator[dict[Expr, Value]]:
    """All values of the variables that an expression reads."""
    variables = list(dict.fromkeys(part for part in walk(expr) if isinstance(part, VariableRef)))
    for values in product(*(domain(variable.type) or () for variable in variables)):
        yield dict(zip(variables, values, strict=True))


def _point(context: CifScope, values: Mapping[Expr, Value]) -> str:
    parts = [
        f"{context.reference(variable)} = {initial(context, variable.type, value)}"
        for variable, value in values.items()
        if isinstance(variable, VariableRef)
    ]
    return " and ".join(parts)


def _written_out(context: CifScope, expr: Expr) -> Spelled:
    """A condition as the values of its variables for which it holds."""
    found = [(evaluate(expr, values.__getitem__), values) for values in _valuations(expr)]
    points = [_point(context, values) for holds, values in found if holds]
    if len(points) in (0, len(found)):
        return _constant(bool(points))
    several = len(found[0][1]) > 1
    texts = [f"({point})" if several and len(points) > 1 else point for point in points]
    return Spelled(" or ".join(texts), 2 if len(points) > 1 else (3 if several else 4))


# --- assignments ---------------------------------------------------------------------------------


def in_range(context: CifScope, type_: Type, expr: Expr) -> list[str]:
    """What must hold so that the assigned value is one of the type; empty if it always is."""
    match type_:
        case IntegerType(bounds=(low, high)):
            least, greatest = _span(expr)
            texts = []
            if least < low:
                texts.append(_against(context, expr, ">=", low))
            if greatest > high:
                texts.append(_against(context, expr, "<=", high))
            return texts
    return []


def _against(context: CifScope, expr: Expr, operator: str, bound: int) -> str:
    comparison = Binary(operator, expr, Literal(bound, IntegerType()), BooleanType())
    return condition(context, comparison, 3)


def _span(expr: Expr) -> tuple[int, int]:
    sum_ = _sum(expr)
    if sum_ is not None:
        return sum_.span()
    values = [int(evaluate(expr, point.__getitem__)) for point in _valuations(expr)]
    return min(values), max(values)


def update(context: CifScope, type_: Type, expr: Expr) -> str:
    """The right-hand side of an assignment to a variable of that type."""
    match type_:
        case EnumType() if isinstance(expr, Convert):
            points = list(_valuations(expr))
            values = [(evaluate(expr, p.__getitem__), _point(context, p)) for p in points]
            texts = [f"{point}: {context.literal(value, type_)}" for value, point in values[:-1]]
            last = context.literal(values[-1][0], type_)
            return f"if {' elif '.join(texts)} else {last} end" if texts else last
        case EnumType():
            return _enum(context, expr)
        case IntegerType(bounds=(low, high)):
            sum_ = _sum(expr)
            if sum_ is None:
                return _by_cases(context, type_, expr, low, high)
            kept = _Sum(sum_.terms, sum_.constant + offset(type_)).shifted()
            added = " + ".join(_added(context, kept, 1)) or "0"
            return " - ".join([added, *_added(context, kept, -1)])
    return condition(context, expr)


def _by_cases(context: CifScope, type_: Type, expr: Expr, low: int, high: int) -> str:
    """``if x = 0: 1 elif …``; values outside the range are ruled out by the edge's guard."""
    cases = [(int(evaluate(expr, p.__getitem__)), _point(context, p)) for p in _valuations(expr)]
    kept = [(value, point) for value, point in cases if low <= value <= high]
    if len(kept) < 2:
        return initial(context, type_, kept[0][0] if kept else low)
    texts = [f"{point}: {initial(context, type_, value)}" for value, point in kept[:-1]]
    return f"if {' elif '.join(texts)} else {initial(context, type_, kept[-1][0])} end"
