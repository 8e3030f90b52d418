"""Exact values and the classes that they are in: ``battery.response(0.15: value <= 0.2)``."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from robosc.expr import traversal, tree
from robosc.plant.automaton import Event, EventParameter, Plant, StateVariable
from robosc.runtime.core.values import jsonable


def value_with_classes(event: Event, value: Any) -> str:
    """The value of an input, or its parts by path, each with its class."""
    labels = {traversal.path_text(p.path): p for p in event.parameters if p.labels is not None}

    def with_class(path: str, part: Any) -> str:
        text = _text(part)
        parameter = labels.get(path)
        return text if parameter is None else f"{text}: {_label(parameter, part)}"

    if isinstance(value, dict):
        return ", ".join(f"{path} = {with_class(path, part)}" for path, part in value.items())
    return with_class("", value)


def data_behind(plant: Plant, event: Event, variables: Mapping[str, Any]) -> Iterator[str]:
    """The data that a command's requirements compare: each with its value and its class."""
    robot = plant.robot
    read = dict.fromkeys(
        f"{part.component}.{part.variable}"
        for index in event.requirements
        for part in traversal.walk(robot.requirements[index].condition)
        if isinstance(part, tree.VariableRef)
    )
    for variable in plant.variables:
        if variable.name in read and variable.labels is not None and variable.test is None:
            value = variables[variable.name]
            yield f"{variable.name} = {_text(value)}: {_label(variable, value)}"


def _text(value: Any) -> str:
    return json.dumps(jsonable(value))


def _label(of: EventParameter | StateVariable, value: Any) -> str:
    """What users see of the class that a value is in."""
    assert of.labels is not None
    return of.labels[of.values.index(value)]
