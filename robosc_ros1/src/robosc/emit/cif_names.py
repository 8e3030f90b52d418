"""Names in CIF, and how the plant's values stand in it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from robosc.ir.automaton import Plant, VariableKind
from robosc.model.entities import Variable
from robosc.model.expr import Leaf, PhaseRef, StateRef, VariableRef
from robosc.model.types import EnumType, IntegerType, Type, Value
from robosc.names import without_index

__all__ = ["CifNames", "CifScope", "initial", "offset"]

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
