"""The model as plain data, for viewers (``~model``) and for the test that plays the robot.

Components, transitions, requirements stand here as the user wrote them; derived is only which
commands synthesis restricts. So the test of a package has the model from here and does not believe
the controller.
"""

from __future__ import annotations

import math
from typing import Any

from robosc.emit.naming import place
from robosc.emit.thresholds import thresholds
from robosc.ir.automaton import Plant
from robosc.ir.formulas import to_dsl
from robosc.model.entities import (
    After,
    Behaviour,
    Component,
    ResultTransition,
    Robot,
    Tau,
    Variable,
)
from robosc.model.expr import Expr
from robosc.model.types import DoubleType, IntegerType
from robosc.supervisor import Supervisor

__all__ = ["model_document"]

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
                "place": place(c.span),
            }
            for c in robot.communications.values()
        ],
        "parameters": [
            {
                "name": parameter.key,
                "parameter": parameter.name,
                "type": str(parameter.type),
                "default": parameter.default,
                "place": place(parameter.span),
            }
            for parameter in robot.parameters
        ],
        "requirements": [
            {
                "text": requirement.text,
                "place": place(requirement.span),
                "communications": [names[key] for key in requirement.communications],
            }
            for requirement in robot.requirements
        ],
        "commands": [
            {
                "event": _event(guard.event.kind.value, guard.event.name, guard.event.index),
                "guard": to_dsl(guard.expr, robot),
                "status": guard.status,
            }
            for guard in supervisor.guards
        ],
        "thresholds": dict(thresholds(robot)),
    }


def _event(kind: str, name: str, index: int) -> dict[str, Json]:
    event: dict[str, Json] = {"kind": kind, "name": name}
    if index:
        event["index"] = index
    return event


def _component(component: Component, plant: Plant) -> dict[str, Json]:
    behaviour = component.behaviour
    robot = plant.robot
    states: list[Json] = []
    variables: list[Json] = []
    transitions: list[Json] = []
    if behaviour is not None:
        states = [
            {"name": s.name, "initial": s.initial, "marked": s.marked} for s in behaviour.states
        ]
        variables = [
            {"name": v.name, "type": str(v.type), "initial": v.initial} | _comparisons(v, plant)
            for v in behaviour.variables
        ]
        transitions = _transitions(behaviour, component.name, robot)
    return {
        "name": component.name,
        "place": place(component.span),
        "library": component.library,
        "states": states,
        "variables": variables,
        "transitions": transitions,
    }


def _comparisons(variable: Variable, plant: Plant) -> dict[str, Json]:
    """The numbers that decisions compare a variable with, and the classes that they make of it:
    how the comparisons come out (``1`` holds, ``0`` does not), to what users see of the class."""
    classes = plant.view.variables.get(variable.key)
    if classes is None or not isinstance(variable.type, DoubleType | IntegerType):
        return {}
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


def _transitions(behaviour: Behaviour, component: str, robot: Robot) -> list[Json]:
    """All transitions; ``from`` None stands for every state, ``to`` None for staying."""

    def guard(expr: Expr | None) -> str | None:
        return None if expr is None else to_dsl(expr, robot)

    def result(state: str | None, transition: ResultTransition) -> Json:
        name = robot.display_names[transition.communication]
        return {
            "from": state,
            "to": transition.goto,
            "event": _event(transition.event.value, name, 0),
            "guard": guard(transition.guard),
            "assignments": [
                f"{a.variable} := {to_dsl(a.value, robot)}" for a in transition.assignments
            ],
            "place": place(transition.span),
        }

    def step(state: str | None, tau: Tau) -> Json:
        return {
            "from": state,
            "to": tau.goto,
            "event": _event("tau", component, tau.index),
            "guard": guard(tau.guard),
            "assignments": [],
            "place": place(tau.span),
        }

    everywhere = [result(None, t) for t in behaviour.transitions]
    everywhere += [step(None, t) for t in behaviour.taus]

    def waiting(state: str, after: After) -> Json:
        taken = after.transition
        return {
            "from": state,
            "to": taken.goto,
            "event": _event("after", component, after.index),
            "guard": guard(taken.guard),
            "assignments": [f"{a.variable} := {to_dsl(a.value, robot)}" for a in taken.assignments],
            "place": place(after.span),
        }

    return everywhere + [
        entry
        for state in behaviour.states
        for entry in (
            [result(state.name, t) for t in state.transitions]
            + [step(state.name, t) for t in state.taus]
            + [waiting(state.name, after) for after in state.afters]
        )
    ]
