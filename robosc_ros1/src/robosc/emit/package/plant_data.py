"""The plant as plain data, for the test that plays the robot."""

from __future__ import annotations

from collections.abc import Iterable

from robosc.emit.controller.naming import place
from robosc.emit.package.model_document import Json
from robosc.expr.identity_cache import IdentityCache
from robosc.expr.traversal import fold
from robosc.expr.tree import (
    Aggregate,
    Convert,
    ElementRef,
    Expr,
    Leaf,
    Literal,
    Made,
    Operation,
    ParameterRef,
    Part,
    PhaseRef,
    ReasonRef,
    StateRef,
    ValueRef,
    VariableRef,
    condition_of,
)
from robosc.expr.types import (
    ArrayType,
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    NoneType,
    ObjectType,
    StringType,
    Type,
)
from robosc.language.events import Direction, EventKind
from robosc.model.automata import Transition
from robosc.model.checks.used_fields import Usage, converted_part
from robosc.model.entities import (
    Command,
    Communication,
    Component,
    Data,
    DataArray,
    DataObject,
    Provide,
    Requirement,
    Robot,
)
from robosc.plant.assumptions import events_of
from robosc.plant.event_values import value_type
from robosc.plant.logic import exact
from robosc.plant.places import written_out
from robosc.supervisor import Guard


class _Enums(dict[str, EnumType]):
    """The enums that were met, by name. ``trees`` are those of expressions that were met: what
    several have in common is one object."""

    def __init__(self) -> None:
        super().__init__()
        self.trees: IdentityCache[Json] = IdentityCache()


def plant_data(robot: Robot, guards: Iterable[Guard] = ()) -> dict[str, Json]:
    """What an interpreter needs: expressions and types as nested lists.

    ``restricted`` are the commands (kind, communication) that synthesis forbids where requirements
    do not, with what it demands where they can happen; ``preferences`` has, by communication, those
    that are preferred to it.

    Expressions are ``["=", left, right]`` and the like, ``["!", e]``, ``["negative", e]``, and the
    leaves ``["literal", v]``, ``["variable", "C.v"]``, ``["state", "C", "s"]``,
    ``["parameter", name]``, ``["value", path, type]``.
    """
    enums = _Enums()
    usage = Usage(robot)
    judged = [r for r in robot.requirements if robot.supervises and r.on_data]
    kinds = {key: command.kind for key, command in robot.commands.items()}
    provided = [p for p in robot.provides if kinds[p.communication].sent]
    errors = [p.communication for p in robot.provides if not kinds[p.communication].sent]
    refusals = sorted({robot.commands[key].communication.key for key in errors})
    corrected = [p for p in robot.provides if p.communication in robot.corrected]
    guards = tuple(guards)
    return {
        "robot": robot.name,
        "parameters": {p.key: p.default for p in robot.parameters},
        "components": [_plant_component(c, enums) for c in robot.components if c.behaviour],
        "communications": [
            _plant_communication(c, robot, enums, usage) for c in robot.communications.values()
        ],
        "requirements": [_required(r, enums) for r in robot.requirements if r not in judged],
        "provides": [_statement(p, robot, enums) for p in provided if p not in corrected],
        **({"refusals": refusals} if refusals else {}),
        **_of_others(robot, guards, judged, corrected, enums),
        **_assumed(robot, enums),
        **_lasting(robot, enums),
        "enums": _enum_tables(enums),
        **({"together": _together(robot)} if robot.together else {}),
        "preferences": {key: list(others) for key, others in robot.yields_to.items()},
        "restricted": [
            [guard.event.kind.value, guard.event.key, _tree(exact(guard.expr), enums)]
            for guard in guards
            if guard.status != "as required" and guard.event.kind is not EventKind.TAU
        ],
    }


def _together(robot: Robot) -> dict[str, list[str]]:
    """The components that perform a command that several perform, by its key."""
    return {key: sorted(components) for key, components in robot.together.items()}


def _of_others(
    robot: Robot,
    guards: Iterable[Guard],
    judged: Iterable[Requirement],
    corrected: Iterable[Provide],
    enums: _Enums,
) -> dict[str, Json]:
    """What a supervisor judges and corrects of the data of another controller, if it does."""
    found: dict[str, Json] = {
        "judged": [_required(r, enums) for r in judged],
        "corrections": [_statement(p, robot, enums) for p in corrected],
        "reads_data": [
            guard.event.key
            for guard in guards
            if guard.event.kind.sent
            and robot.supervises
            and not isinstance(value_type(robot, guard.event), NoneType)
        ],
    }
    return {name: entries for name, entries in found.items() if entries}


def _lasting(robot: Robot, enums: _Enums) -> dict[str, Json]:
    """What lasting conditions are about, each behind those that it reads, if there are some."""
    found: list[Json] = [[one.name, _tree(one.condition, enums)] for one in robot.lasting]
    return {"lasting": found} if found else {}


def _assumed(robot: Robot, enums: _Enums) -> dict[str, Json]:
    """What the robot is assumed not to do, if something is; ``events`` are those of the
    communication that one assumption concerns."""
    found: list[Json] = [
        {
            "communication": assumption.communication,
            "events": [kind.value for kind in events_of(assumption, robot)],
            "condition": _tree(assumption.condition, enums),
            "text": assumption.text,
            "place": place(assumption.span),
        }
        for assumption in robot.assumptions
    ]
    return {"assumptions": found} if found else {}


def _required(requirement: Requirement, enums: _Enums) -> dict[str, Json]:
    return {
        "kind": requirement.kind,
        "communications": list(requirement.communications),
        "condition": _tree(requirement.condition, enums),
        "to_start": requirement.to_start,
        **({"to_cancel": True} if requirement.to_cancel else {}),
        "text": requirement.text,
        "place": place(requirement.span),
    }


def _statement(provide: Provide, robot: Robot, enums: _Enums) -> dict[str, Json]:
    condition = provide.condition
    return {
        "communication": provide.communication,
        "condition": None if condition is None else _tree(condition, enums),
        "data": _provided(provide.data, robot.commands[provide.communication], enums),
    }


def _plant_communication(
    communication: Communication, robot: Robot, enums: _Enums, usage: Usage
) -> Json:
    binding, age = communication.binding, communication.max_age

    def part(direction: Direction, type_: Type) -> Json:
        return _type(usage.part(communication.key, direction, type_), enums)

    return {
        "key": communication.key,
        "name": robot.display_names[communication.key],
        "kind": communication.kind.value,
        "timeout": communication.timeout is not None,
        **({"frames": communication.frames} if communication.frames else {}),
        **({} if age is None else {"max_age": _tree(age, enums)}),
        "expect": None if communication.expect is None else _tree(communication.expect, enums),
        **({"heard": True} if communication.heard else {}),
        **({"replaces": True} if communication.goals else {}),
        "identifier": communication.identifier,
        "interface": [binding.package, binding.type],
        "request": part("request", communication.request),
        "response": part("response", communication.response),
        "feedback": part("feedback", communication.feedback),
        "request_field": binding.request_field,
        "response_field": binding.response_field,
        "feedback_field": binding.feedback_field,
    }


def _plant_component(component: Component, enums: _Enums) -> Json:
    behaviour = component.behaviour
    assert behaviour is not None

    variables = [
        {
            "name": v.name,
            "type": _type(v.type, enums),
            "initial": v.initial,
            "in_state": v.in_state,
            **({"persistent": True} if v.persistent else {}),
        }
        for v in behaviour.variables
    ]
    found = [(t.event, _transition(place, t, enums)) for place, t in behaviour.placed]
    return {
        "name": component.name,
        "states": [s.name for s in behaviour.states],
        "initial": next(s.name for s in behaviour.states if s.initial),
        "variables": variables,
        "transitions": [t for kind, t in found if not kind.of_component],
        "taus": [t for kind, t in found if kind is EventKind.TAU],
        "afters": [t for kind, t in found if kind is EventKind.AFTER],
    }


def _transition(place: str | None, transition: Transition, enums: _Enums) -> Json:
    """A transition, which leaves a place, with what its kind of events has."""

    def tree(expr: Expr | None) -> Json:
        return None if expr is None else _tree(expr, enums)

    own: dict[str, Json] = {"index": transition.index}
    if transition.delay is not None:
        own["delay"] = tree(transition.delay)
    elif not transition.event.of_component:
        own = {"event": transition.event.value, "communication": transition.communication}
    named = {} if transition.named is None else {"named": transition.named}
    return {
        "from": place,
        **own,
        "guard": tree(transition.guard),
        "assign": [[a.variable, tree(a.value)] for a in transition.assignments],
        "goto": transition.goto,
        **named,
    }


def _provided(data: Data, command: Command, enums: _Enums) -> Json:
    """Provided data: of fields, of the only field, or a whole object that was stored."""
    if isinstance(data, Operation | Leaf) and isinstance(command.type, ObjectType):
        return {"whole": _tree(data, enums)}
    return _data(data, command, enums)


def _data(data: Data, command: Command, enums: _Enums) -> Json:
    if isinstance(data, DataArray):
        return {"elements": [_data(d, command, enums) for d in data.elements]}
    if isinstance(data, DataObject):
        return {"fields": [[name, _data(d, command, enums)] for name, d in data.fields]}
    return {"field": command.field, "value": _tree(data, enums)}


def _tree(expr: Expr, enums: _Enums) -> Json:
    def leaf(node: Literal | Leaf) -> Json:
        match node:
            case Literal(value=value):
                return ["literal", value]
            case VariableRef(component=component, variable=name):
                return ["variable", f"{component}.{name}"]
            case StateRef(component=component, state=state):
                return ["state", component, state]
            case ReasonRef():
                return ["reason"]
            case ValueRef(path=path, type=type_):
                return ["value", list(path), _type(type_, enums)]
            case ElementRef(variable=name, path=path, carried=type_):
                return ["bound", name, list(path), _type(type_, enums)]
            case ParameterRef(parameter=parameter):
                return ["parameter", parameter.key]
            case PhaseRef(communication=key, phase=phase):
                return ["phase", key, phase]

    def operation(node: Operation, operands: tuple[Json, ...]) -> Json:
        return enums.trees.of(node, lambda node: made(node, operands))

    def made(node: Expr, operands: tuple[Json, ...]) -> Json:
        assert isinstance(node, Operation)
        if isinstance(node, Convert):
            return ["convert", _type(node.type, enums), *operands]
        if isinstance(node, Aggregate):
            return ["each", node.operator, [node.variable, node.position], *operands]
        if isinstance(node, Made):
            return ["made", list(node.names), *operands]
        if isinstance(node, Part):
            return ["part", *operands, list(node.path), _type(node.carried, enums)]
        return [node.operation.key, *operands]

    return fold(written_out(expr), leaf, operation, known=enums.trees.known)


def _type(type_: Type, enums: _Enums) -> Json:
    match type_:
        case NoneType() | BooleanType() | StringType() | DoubleType():
            return [str(type_)]
        case IntegerType(bounds=bounds):
            return ["integer", *(bounds or ())]
        case ArrayType(element=element):
            return ["array", _type(element, enums)]
        case ObjectType(properties=properties):
            return ["object", [[name, _type(inner, enums)] for name, inner in properties]]
        case EnumType():
            name = f"{type_.origin}.{type_.name}"
            enums.setdefault(name, type_)
            return ["enum", name]


def _enum_tables(enums: _Enums) -> dict[str, Json]:
    """All enums found, and those that their rules and sources mention."""
    tables: dict[str, Json] = {}
    while pending := [name for name in enums if name not in tables]:
        for name in pending:
            enum = enums[name]
            tables[name] = {
                "from": _type(converted_part(enum), enums),
                "values": list(enum.values),
                "default": enum.default,
                "rules": [[_tree(condition_of(rule), enums), rule.value] for rule in enum.rules],
            }
    return tables
