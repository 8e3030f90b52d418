"""The plant with its classes of data as enumerations, for tools without reals and strings.

A number or a string that decides becomes a variable of an enumeration with one value for each class
that the model's comparisons distinguish; a test of data becomes a variable of the component whose
data it reads. So the exported plant has the same states and transitions as the one here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

from robosc.errors import UsageError
from robosc.ir.automaton import Edge, Event, EventParameter, Plant, StateVariable, VariableKind
from robosc.ir.formulas import Leaf, conjunction, disjunction, evaluate
from robosc.model.entities import Behaviour, Component, Robot, State, Variable
from robosc.model.evaluation import converted
from robosc.model.expr import (
    Binary,
    Convert,
    Expr,
    Holds,
    Literal,
    Operation,
    TestRef,
    Unary,
    ValueRef,
    VariableRef,
)
from robosc.model.traversal import rewritten, walk
from robosc.model.types import (
    BooleanType,
    EnumRule,
    EnumType,
    NoneType,
    StringType,
    Type,
    Value,
    domain,
)

__all__ = ["DiscretePlant", "discrete_plant"]

_BOOLEAN = BooleanType()
_LONGEST = 24
"""Characters of a class's name; others have a number, and what they stand for in a comment."""
_WORDS = {
    ">=": "from", "<=": "up_to", "!=": "is_not", ">": "above", "<": "below", "=": "is", "!": "not",
    "-": "minus",
}  # fmt: skip


@dataclass(frozen=True)
class _Counterpart:
    """A leaf over an enumeration or a boolean in the place of data."""

    leaf: VariableRef | ValueRef
    values: Mapping[Value, Value]
    """The value of the plant by that of the counterpart."""
    classes: Sequence[Value | None] = ()
    """The classes whose numbers are those of the values; empty for what is finite itself."""


@dataclass(frozen=True)
class DiscretePlant:
    """The plant without data; ``notes`` say what the values of each enumeration stand for."""

    plant: Plant
    notes: Mapping[str, str]
    _states: Mapping[Expr, _Counterpart]

    def expression(self, expr: Expr) -> Expr:
        """A condition over the state, such as the supervisor's guards, without data."""
        return _discrete(expr, self._states)


def discrete_plant(plant: Plant) -> DiscretePlant:
    """The plant with enumerations in the place of data.

    What parameters of the node come to are variables of a component of their own, which nothing
    changes.

    Raises:
        UsageError: a test reads data of several components.
    """
    notes: dict[str, str] = {}
    taken = set(plant.robot.variables)
    states: dict[Expr, _Counterpart] = {}
    variables: list[StateVariable] = []
    parameters = _parameters_component(plant)
    for variable in plant.variables:
        found = _state(variable, notes, taken, parameters)
        if found is not None:
            original, counterpart = found
            states[original] = counterpart
            variable = _renamed(variable, counterpart)
        variables.append(variable)
    events = tuple(_event(event, states, variables, notes) for event in plant.events)
    if any(name.startswith(f"{parameters}.") for name in (v.name for v in variables)):
        known = VariableKind.LOCATION, parameters, (_KNOWN,), 0, frozenset((0,))
        variables.append(StateVariable(*known))
    robot = _robot(plant, states, variables, parameters)
    invariants = tuple((_discrete(e, states), number) for e, number in plant.invariants)
    made = Plant(robot, tuple(variables), events, invariants, plant.view)
    return DiscretePlant(made, notes, states)


# --- variables of the state ----------------------------------------------------------------------


def _state(
    variable: StateVariable, notes: dict[str, str], taken: set[str], parameters: str
) -> tuple[VariableRef | TestRef, _Counterpart] | None:
    """What the plant's expressions say for data of the state, and what stands in its place."""
    test = variable.test
    if test is not None:
        component, name = _owner(test, parameters), _identifier(test.name)
        while f"{component}.{name}" in taken:
            name += "_"
        taken.add(f"{component}.{name}")
        if domain(test.type) is not None:
            finite = {value: value for value in variable.values}
            return test, _Counterpart(VariableRef(component, name, test.type), finite)
        enum, values = _enumeration(f"{component}_{name}", variable, test.name, notes)
        return test, _Counterpart(VariableRef(component, name, enum), values, variable.values)
    if variable.labels is None:
        return None
    component, _, name = variable.name.partition(".")
    enum, values = _enumeration(f"{component}_{name}", variable, variable.name, notes)
    type_ = getattr(variable.values, "type", None)
    assert type_ is not None, "only classes have labels"
    original = VariableRef(component, name, type_)
    return original, _Counterpart(VariableRef(component, name, enum), values, variable.values)


_KNOWN = "known"
"""The state of the component of the parameters."""


def _parameters_component(plant: Plant) -> str:
    """A name for the component that has what is asked of parameters."""
    name = "Parameters"
    while any(component.name == name for component in plant.robot.components):
        name += "_"
    return name


def _owner(test: TestRef, parameters: str) -> str:
    """The component whose data a test reads; ``parameters`` if it reads nothing but these."""
    parts = [part for side in test.sides for part in walk(side)]
    found = {part.component for part in parts if isinstance(part, VariableRef)}
    if len(found) > 1:
        raise UsageError(
            f"CIF has no numbers without bounds, and '{test.name}' compares data of several"
            " components: convert the received value by an enum, or export as JSON"
        )
    return found.pop() if found else parameters


def _renamed(variable: StateVariable, counterpart: _Counterpart) -> StateVariable:
    leaf = counterpart.leaf
    assert isinstance(leaf, VariableRef)
    return StateVariable(
        VariableKind.DATA,
        f"{leaf.component}.{leaf.variable}",
        tuple(counterpart.values),
        variable.initial,
        starts=variable.starts,
    )


def _enumeration(
    name: str, of: StateVariable | EventParameter, term: str, notes: dict[str, str]
) -> tuple[EnumType, dict[Value, Value]]:
    """An enumeration of classes, and the representative that each of its values stands for.

    Its values are called as the labels of the classes, without what these are about.
    """
    assert of.labels is not None
    found: dict[Value, Value] = {}
    told: list[str] = []
    for value, label in zip(of.values, of.labels, strict=True):
        if value is None:
            continue  # what is missing is no value
        word = _identifier(label.replace(term, ""))
        if len(word) > _LONGEST:
            word = f"class{len(found) + 1}"
        while word in found:
            word += "_"
        found[word] = value
        told.append(f"{word}: {label}")
    names = tuple(str(word) for word in found)
    name += "_class"
    while name in notes:
        name += "_"
    enum = EnumType(name, "", NoneType(), names, names[0], ())
    notes[enum.name] = ", ".join(told)
    return enum, found


def _identifier(text: str) -> str:
    """A condition as a name: ``charge_above_0_2``."""
    for sign, word in _WORDS.items():
        text = text.replace(sign, f" {word} ")
    return re.sub(r"\W+", "_", text).strip("_")


# --- events --------------------------------------------------------------------------------------


def _event(
    event: Event,
    states: Mapping[Expr, _Counterpart],
    variables: Sequence[StateVariable],
    notes: dict[str, str],
) -> Event:
    leaves = dict(states)
    parameters: list[EventParameter] = []
    for parameter in event.parameters:
        if domain(parameter.type) is None:
            name = f"{event.name}_{_identifier('_'.join(map(str, parameter.path)) or 'value')}"
            enum, values = _enumeration(name, parameter, "value", notes)
            for leaf in _leaves_of(event, parameter):
                incoming = ValueRef(parameter.path, enum, optional=parameter.optional)
                leaves[leaf] = _Counterpart(incoming, values, parameter.values)
            missing = (None,) if None in parameter.values else ()
            parameter = EventParameter(
                parameter.path, enum, (*enum.values, *missing), optional=parameter.optional
            )
        parameters.append(parameter)
    automata = tuple(
        replace(a, edges=tuple(_edge(edge, leaves, variables) for edge in a.edges))
        for a in event.automata
    )
    requirement = event.requirement and _discrete(event.requirement, states)
    return replace(event, parameters=tuple(parameters), automata=automata, requirement=requirement)


def _leaves_of(event: Event, parameter: EventParameter) -> Iterator[ValueRef]:
    for automaton in event.automata:
        for edge in automaton.edges:
            readers = [expr for _, expr in edge.updates] + ([edge.guard] if edge.guard else [])
            for part in (part for reader in readers for part in walk(reader)):
                if isinstance(part, ValueRef) and part.path == parameter.path:
                    yield part


def _edge(
    edge: Edge, leaves: Mapping[Expr, _Counterpart], variables: Sequence[StateVariable]
) -> Edge:
    guard = edge.guard and _discrete(edge.guard, leaves)
    updates = tuple(
        (index, _update(expr, leaves, variables[index])) for index, expr in edge.updates
    )
    return replace(edge, guard=guard, updates=updates)


def _update(expr: Expr, leaves: Mapping[Expr, _Counterpart], target: StateVariable) -> Expr:
    counterpart = next(
        (c for c in leaves.values() if isinstance(c.leaf, VariableRef)
         and f"{c.leaf.component}.{c.leaf.variable}" == target.name),
        None,
    )  # fmt: skip
    if counterpart is None or not counterpart.classes:
        return _discrete(expr, leaves)
    enum = counterpart.leaf.type
    assert isinstance(enum, EnumType)

    def member(value: Value) -> str:
        """The value of the enumeration whose class a number or a string is in."""
        return str(tuple(counterpart.values)[counterpart.classes.index(value)])

    def outcome(value: Value | None) -> str:
        """What the assigned expression comes to where the one leaf that it reads has a value."""
        return member(evaluate(expr, lambda leaf: value))

    read = [part for part in walk(expr) if not isinstance(part, Literal | Operation)]
    if not read:
        return Literal(outcome(None), enum)
    return _converting(leaves.get(read[0]) or _integer(read[0]), enum, outcome)


def _converting(
    source: _Counterpart, enum: EnumType, outcome: Callable[[Value | None], str]
) -> Convert:
    """What the value of an enumeration, or an integer, becomes in another enumeration."""
    # A rule reads the name of the value: what is of an enum would be converted once more.
    named: Type = StringType() if isinstance(source.leaf.type, EnumType) else source.leaf.type
    rules = tuple(
        EnumRule(Binary("=", ValueRef((), named), Literal(own, named), _BOOLEAN), outcome(value))
        for own, value in source.values.items()
    )
    return Convert(source.leaf, replace(enum, source=source.leaf.type, rules=rules))


def _integer(leaf: Expr) -> _Counterpart:
    """An integer with a range, which CIF has as it is."""
    assert isinstance(leaf, VariableRef | ValueRef)
    values = domain(leaf.type)
    assert values is not None
    return _Counterpart(leaf, {value: value for value in values})


# --- conditions ----------------------------------------------------------------------------------


def _discrete(expr: Expr, leaves: Mapping[Expr, _Counterpart]) -> Expr:
    """A condition, or a finite value, with each comparison of data written out by classes."""
    match expr:
        case Unary(operator="!", operand=operand):
            return replace(expr, operand=_discrete(operand, leaves))
        case Holds(operand=operand):
            return replace(expr, operand=_discrete(operand, leaves))
        case Convert(argument=argument, type=enum) if argument in leaves:
            return _converting(leaves[argument], enum, lambda value: str(converted(enum, value)))
        case Binary(left=left, right=right) if isinstance(left.type, BooleanType):
            return replace(expr, left=_discrete(left, leaves), right=_discrete(right, leaves))
        case _ if isinstance(expr, Operation) and isinstance(expr.type, BooleanType):
            read = [p for p in dict.fromkeys(walk(expr)) if p in leaves and leaves[p].classes]
            if read:
                return _written_out(expr, [(part, leaves[part]) for part in read])

    def leaf(node: Literal | Leaf) -> Expr:
        return leaves[node].leaf if node in leaves else node

    return rewritten(expr, leaf)


def _written_out(expr: Expr, read: Sequence[tuple[Expr, _Counterpart]]) -> Expr:
    """Where a comparison holds, class by class."""
    found: list[Expr] = []
    for values in product(*(counterpart.values.items() for _, counterpart in read)):
        known = {part: value for (part, _), (_, value) in zip(read, values, strict=True)}
        if evaluate(expr, known.__getitem__):
            found.append(
                conjunction(
                    Binary("=", c.leaf, Literal(own, c.leaf.type), _BOOLEAN)
                    for (_, c), (own, _) in zip(read, values, strict=True)
                )
            )
    return disjunction(found)


# --- the model -----------------------------------------------------------------------------------


def _robot(
    plant: Plant,
    states: Mapping[Expr, _Counterpart],
    variables: Sequence[StateVariable],
    parameters: str,
) -> Robot:
    robot = plant.robot
    initial = {variable.name: variable.values[variable.initial] for variable in variables}
    requirements = tuple(
        replace(r, condition=_discrete(plant.view.expression(r.condition), states))
        for r in robot.requirements
    )
    own = robot.components
    if any(variable.name == parameters for variable in variables):
        state = State(_KNOWN, True, True, (), (), span=robot.span)
        behaviour = Behaviour((), (state,), (), (), span=robot.span)
        own += (Component(parameters, (), behaviour, None, span=robot.span),)
    components = tuple(_component(c, states, initial) for c in own)
    return replace(robot, components=components, requirements=requirements)


def _component(
    component: Component, states: Mapping[Expr, _Counterpart], initial: Mapping[str, Value]
) -> Component:
    behaviour = component.behaviour
    if behaviour is None:
        return component
    types: dict[str, Type] = {
        c.leaf.variable: c.leaf.type
        for c in states.values()
        if isinstance(c.leaf, VariableRef) and c.leaf.component == component.name
    }
    found = [v for v in behaviour.variables if v.name not in types]
    found += [
        Variable(name, component.name, type_, initial[f"{component.name}.{name}"], True,
                 span=component.span)
        for name, type_ in types.items()
    ]  # fmt: skip
    return replace(component, behaviour=replace(behaviour, variables=tuple(found)))
