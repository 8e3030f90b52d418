"""Names and values in CIF: what everything in a plant is called there.

A number or a string that decides becomes a variable of an enumeration, with one value for each
class that the model's comparisons distinguish. A test of data becomes a variable of the component
whose data it reads, and a parameter of the node one of a component of its own, which nothing
changes.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from robosc import dotted, errors, names
from robosc.expr import tree, types
from robosc.expr.traversal import walk
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import EventParameter, Plant, StateVariable, VariableKind

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
_WORDS = {
    '""': "empty", ">=": "from", "<=": "up_to", "!=": "is_not", ">": "above", "<": "below",
    "=": "is", "!": "not", "-": "minus",
}  # fmt: skip
_LONGEST = 24
"""Characters of a class's name; others have a number, and what they stand for in a comment."""


@dataclass(frozen=True)
class CifVariable:
    """A variable of a component's automaton: data of the plant's state, or a test of data.

    ``wanted`` is the name that it should have there, ``type`` its type in CIF. ``literals`` are the
    values of its enumeration, in the order of the plant's (empty: it is an integer or a boolean).
    An integer is kept from 0 upwards: CIF has it plus ``offset``.
    """

    component: str
    wanted: str
    state: StateVariable
    type: str
    literals: tuple[str, ...] = ()
    offset: int = 0

    def text(self, value: types.Value) -> str:
        """A value of the plant as CIF keeps it."""
        if self.literals:
            return self.literals[self.state.values.index(value)]
        return str(value).lower() if isinstance(value, bool) else str(int(value) + self.offset)


class CifScope:
    """The names of everything in a plant; ``notes`` say what the values of enumerations mean.

    A name inside an automaton must not hide one outside, so all these are given first.

    Raises:
        UsageError: a test reads data of several components.
    """

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.notes: dict[str, str] = {}
        self.enums: dict[str, tuple[str, ...]] = {}
        self.parameters = ""
        """The component of the node's parameters; empty if nothing reads them."""
        self._taken: set[str] = set()
        self._inner: dict[str, set[str]] = {}
        self._locals: dict[tuple[str, str], str] = {}
        self._enums_of_model: dict[types.EnumType, str] = {}
        robot = plant.robot
        self._automata = {c.name: self.fresh(c.name) for c in robot.components}
        self._phases = {
            key: self.fresh(f"{c.name}_phase")
            for key, c in robot.communications.items()
            if c.phases is not None
        }
        self.variables = {
            index: self._variable(variable)
            for index, variable in enumerate(plant.variables)
            if variable.kind in (VariableKind.DATA, VariableKind.TEST)
        }

    # --- names

    def fresh(self, wanted: str) -> str:
        """A name for something of the specification itself."""
        return _unused(wanted, self._taken, frozenset())

    def _local(self, component: str, key: str, wanted: str) -> str:
        """The name inside an automaton of what has this key."""
        if (component, key) not in self._locals:
            inner = self._inner.setdefault(component, set())
            self._locals[component, key] = _unused(wanted, inner, self._taken)
        return self._locals[component, key]

    def automaton(self, component: str) -> str:
        return self._automata[component]

    def phase(self, communication: str) -> str:
        return self._phases[communication]

    def location(self, component: str, state: types.Value) -> str:
        return self._local(
            component, f"location {state}", str(state).replace(".", "_").replace(" ", "_")
        )

    def own_name(self, variable: CifVariable) -> str:
        """The name of a variable in its automaton."""
        return self._local(variable.component, variable.state.name, variable.wanted)

    def variable(self, leaf: tree.Leaf) -> CifVariable:
        match leaf:
            case tree.TestRef(name=name):
                key = VariableKind.TEST, name
            case tree.VariableRef(component=component, variable=name):
                key = VariableKind.DATA, f"{component}.{name}"
            case _:
                raise TypeError(leaf)
        return self.variables[self.plant.variable_index[key]]

    def reference(self, leaf: tree.Leaf) -> str:
        match leaf:
            case tree.StateRef(component=component, state=state):
                return f"{self.automaton(component)}.{self.location(component, state)}"
            case tree.PhaseRef(communication=key, phase=phase):
                return f"{self.phase(key)}.{phase}"
        variable = self.variable(leaf)
        return f"{self.automaton(variable.component)}.{self.own_name(variable)}"

    def literal(self, value: types.Value, enum: types.EnumType) -> str | None:
        """A value of an enum of the model; None if no variable has that type."""
        name = self._enums_of_model.get(enum)
        return None if name is None else self.enums[name][enum.values.index(str(value))]

    # --- variables

    def _variable(self, variable: StateVariable) -> CifVariable:
        test = variable.test
        if test is None:
            component = dotted.first(variable.name)
            wanted = dotted.inside(variable.name).replace(".", "_").replace(" ", "_")
            type_ = self.plant.robot.variables[variable.name].type
        else:
            component, wanted, type_ = self._owner(test), _identifier(test.name), test.type
        own = component, wanted, variable
        if variable.labels is not None:
            words = _class_names(variable, variable.name)
            enum = self._enumeration(f"{component}_{wanted}_class", words)
            self.notes[enum] = _note(words, variable)
            return CifVariable(*own, enum, self.enums[enum])
        match type_:
            case types.EnumType(name=name, values=values):
                if type_ not in self._enums_of_model:
                    self._enums_of_model[type_] = self._enumeration(name, values)
                enum = self._enums_of_model[type_]
                return CifVariable(*own, enum, self.enums[enum])
            case types.IntegerType(bounds=(low, high)):
                shift = max(0, -low)
                return CifVariable(*own, f"int[{low + shift}..{high + shift}]", offset=shift)
        return CifVariable(*own, "bool")

    def _owner(self, test: tree.TestRef) -> str:
        """The component whose data a test reads, or that of parameters if it reads only these."""
        parts = [*walk(test.subject), *(() if test.other is None else walk(test.other))]
        found = {part.component for part in parts if isinstance(part, tree.VariableRef)}
        if len(found) > 1:
            raise errors.UsageError(
                f"CIF has no numbers without bounds, and data of {' and '.join(sorted(found))}"
                " are compared with each other: convert the received value by an enum, or export as"
                " JSON"
            )
        if found:
            return found.pop()
        if not self.parameters:
            self.parameters = self.fresh("Parameters")
            self._automata[self.parameters] = self.parameters
        return self.parameters

    def _enumeration(self, wanted: str, words: Sequence[str]) -> str:
        """Declare an enumeration; its literals carry its name, since enums may share values."""
        name = self.fresh(wanted)
        self.enums[name] = tuple(self.fresh(f"{wanted}_{word}") for word in words)
        return name

    def value_names(self, event: str, parameter: EventParameter) -> tuple[str, ...]:
        """The values of a parameter, in their order, as parts of the names of events."""
        if parameter.labels is None:
            return tuple(map(_value_name, parameter.values))
        words = _class_names(parameter, "value")
        path = _identifier("_".join(map(str, parameter.path)) or "value")
        self.notes[f"{event}, {path}"] = _note(words, parameter)
        return words


def _unused(wanted: str, taken: set[str], others: Collection[str]) -> str:
    name = names.without_index(wanted)
    while name in taken or name in others:
        name += "_"
    taken.add(name)
    return f"${name}" if name in _KEYWORDS else name


def _class_names(of: StateVariable | EventParameter, term: str) -> tuple[str, ...]:
    """Names for classes, after their labels without the term that these are about."""
    assert of.labels is not None
    found: list[str] = []
    for value, label in zip(of.values, of.labels, strict=True):
        word = _value_name(value) if value is None else _identifier(label.replace(term, ""))
        if len(word) > _LONGEST:
            word = f"class{len(found) + 1}"
        while word in found:
            word += "_"
        found.append(word)
    return tuple(found)


def _note(words: Sequence[str], of: StateVariable | EventParameter) -> str:
    """What the values of an enumeration stand for; a missing one needs no explanation."""
    assert of.labels is not None
    found = zip(words, of.labels, of.values, strict=True)
    return ", ".join(f"{word}: {label}" for word, label, value in found if value is not None)


def _identifier(text: str) -> str:
    """A condition as a name: ``charge_above_0_2``."""
    for sign, word in _WORDS.items():
        text = text.replace(sign, f" {word} ")
    return re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")


def _value_name(value: types.Value | None) -> str:
    match value:
        case None:
            return "missing"
        case bool():
            return str(value).lower()
        case int():
            return f"m{-value}" if value < 0 else str(value)
    return str(value)
