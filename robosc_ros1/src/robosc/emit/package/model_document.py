"""The model as plain data, for viewers (``~model``) and for the test that plays the robot.

Components, transitions, requirements stand here as the user wrote them; derived is only which
commands synthesis restricts. So the test of a package has the model from here and does not believe
the controller.
"""

from __future__ import annotations

import math
from typing import Any

from robosc import limits
from robosc.emit.controller import guard_methods
from robosc.emit.export.pictured_transitions import as_written, pictured
from robosc.emit.package.plot_lines import thresholds
from robosc.expr import types
from robosc.language.events import EventKind
from robosc.model import automata
from robosc.model.entities import Component, Robot
from robosc.plant.automaton import Plant
from robosc.plant.model_text import to_dsl
from robosc.runtime.core.places import DUE, place_of
from robosc.supervisor import Supervisor

Json = Any


def model_document(supervisor: Supervisor, source: str) -> dict[str, Json]:
    """The document of ``~model``: the model as a person reads it, expressions as text."""
    robot = supervisor.plant.robot
    names = robot.display_names
    return {
        "version": 1,
        "robot": robot.name,
        "source": source,
        "components": [_component(component, supervisor.plant) for component in robot.components],
        "communications": [
            {
                "name": names[c.key],
                "component": c.component,
                "kind": c.kind.value,
                "identifier": c.identifier,
                "request": str(c.request),
                "response": str(c.response),
                "feedback": str(c.feedback),
                "place": c.span.place,
            }
            for c in robot.communications.values()
        ],
        "parameters": [
            {
                "name": parameter.key,
                "parameter": parameter.name,
                "type": str(parameter.type),
                "default": parameter.default,
                "place": parameter.span.place,
            }
            for parameter in robot.parameters
        ],
        "requirements": [
            {
                "text": requirement.text,
                "place": requirement.span.place,
                "communications": [names[key] for key in requirement.communications],
            }
            for requirement in robot.requirements
        ]
        + [
            {"text": goal.text, "place": goal.span.place, "communications": []}
            for goal in robot.goals
        ],
        "commands": [
            {
                "event": _event(guard.event.kind, guard.event.name, guard.event.index),
                "guard": to_dsl(guard.expr, robot),
                "status": guard.status,
            }
            for guard in guard_methods.whole_guards(supervisor)
        ],
        "thresholds": dict(thresholds(robot)),
    }


def _event(kind: EventKind, name: str, index: int) -> dict[str, Json]:
    return {"kind": kind.word, "name": name} | ({"index": index} if index else {})


def _component(component: Component, plant: Plant) -> dict[str, Json]:
    robot = plant.robot
    return {
        "name": component.name,
        "place": component.span.place,
        "library": component.library,
        "states": [
            {"name": place_of(s.name), "initial": s.initial, "marked": s.marked}
            | _performed(s, robot)
            for s in component.states
            if s.name == place_of(s.name) or s.name.endswith(f" {DUE}")
        ],
        "variables": [
            {"name": v.name, "type": str(v.type), "initial": v.initial}
            | ({"persistent": True} if v.persistent else {})
            | _message(v.type)
            | _comparisons(v, plant)
            for v in component.variables
        ],
        "transitions": _transitions(component.behaviour, component.name, robot),
    }


def _performed(state: automata.State, robot: Robot) -> dict[str, Json]:
    """The command that a state performs, if it performs one."""
    performed = next((outer.performs for outer in state.around), None)
    return {} if performed is None else {"performs": robot.display_names[performed]}


def _message(type_: types.Type) -> dict[str, Json]:
    """The type of std_msgs that holds the values of a type, if there is one."""
    match type_:
        case types.BooleanType():
            return {"message": "Bool"}
        case types.IntegerType():
            return {"message": "Int64"}
        case types.DoubleType():
            return {"message": "Float64"}
        case types.StringType() | types.EnumType():
            return {"message": "String"}
        case types.ArrayType(element=types.IntegerType() | types.DoubleType()):
            return {"message": "Float64MultiArray"}
    return {}


def _comparisons(variable: automata.Variable, plant: Plant) -> dict[str, Json]:
    """The numbers that decisions compare a variable with, and the classes that they make of it:
    how the comparisons come out (``1`` holds, ``0`` does not), to what users see of the class."""
    classes = plant.view.variables.get(variable.key)
    if classes is None or not isinstance(variable.type, types.DoubleType | types.IntegerType):
        return {}
    if len(classes) > limits.SHOWN_CLASSES:
        return {}  # the page shows the number alone
    labels = next(v.labels for v in plant.variables if v.name == variable.key)
    assert labels is not None
    there = range(len(classes) - classes.optional)
    outcomes = [classes.outcomes(number) for number in there]
    finite = [c for c in outcomes[0] if not isinstance(c[1], str) and math.isfinite(c[1])]
    texts = {
        "".join("01"[found[comparison]] for comparison in finite): labels[number]
        for number, found in enumerate(outcomes)
    }
    return {"comparisons": [list(comparison) for comparison in finite], "classes": texts}


def _transitions(behaviour: automata.Behaviour, component: str, robot: Robot) -> list[Json]:
    """All transitions; ``from`` None stands for every state, ``to`` None for staying.

    That of a state with states in it leaves each of those; ``box`` is its name.
    """
    names = robot.display_names
    states = dict.fromkeys(place_of(state.name) for state in behaviour.states)
    inside = {
        outer.name: [state for state in states if automata.is_in(state, outer.name)]
        for outer in behaviour.composites
        if outer.performs is None
    }
    return [
        {
            "from": source,
            "to": t.goto,
            "event": _event(t.event, names.get(t.communication, component), t.index),
            "guard": None if t.guard is None else to_dsl(t.guard, robot),
            "assignments": [f"{a.variable} := {to_dsl(a.value, robot)}" for a in t.assignments],
            "place": t.span.place,
        }
        | ({} if t.delay is None else {"delay": as_written(t.delay, robot)})
        | ({"box": state} if state in inside else {})
        | ({"into": t.named} if t.named in inside else {})
        for state, t in pictured(behaviour)
        for source in inside.get(state or "", [state])
    ]
