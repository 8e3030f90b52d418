"""The machine that a command line asks for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from robosc.errors import UsageError
from robosc.model.declarations.parameters import with_parameters, with_starts
from robosc.model.ros.definitions import MessageDefinitions
from robosc.plant.build import lower
from robosc.simulate.faults import InvalidLine
from robosc.simulate.machines import event_by_event, machine, supervised
from robosc.simulate.machines.execute import Check, Execution, read_settings
from robosc.simulate.script.session import MakeMachine
from robosc.simulate.values.literals import parse_raw
from robosc.simulate.values.message_fields import Fields, KnownFields
from robosc.supervisor import Supervisor

_NOTHING: Mapping[str, Any] = MappingProxyType({})


def machine_maker(supervisor: Supervisor, *, execute: bool) -> MakeMachine:
    """Makes machines of single events, or of the controller as it executes.

    They are given parameters of the node by name (``rate``, ``order``, ``timeout/grab`` …), those
    of the model among them. Raise InvalidLine if one is unknown or has a wrong value.
    """
    demand_fitting = _fitting(supervisor)

    def make(given: Mapping[str, Any], starts: Mapping[str, Any] = _NOTHING) -> machine.Machine:
        robot = supervisor.plant.robot
        settings = read_settings(robot, given)
        chosen = supervisor_with(supervisor, settings.more, starts)
        if execute and robot.supervises:
            stop = {} if robot.stop is None else {"stop_command": robot.display_names[robot.stop]}
            settings = read_settings(robot, {**stop, **given})
            return supervised.SupervisedExecution(chosen, settings, demand_fitting)
        if execute:
            return Execution(chosen, settings, demand_fitting)
        if not settings.more.keys() >= given.keys():
            raise InvalidLine("this is a parameter of the controller's node: use --execute")
        return event_by_event.SingleEvents(chosen)

    return make


def _fitting(supervisor: Supervisor) -> Check:
    """Demands that the data of a command, by its key and kind, fit into its message, if its
    definition is known: nodes send no others."""
    robot = supervisor.plant.robot
    sent = {(e.key, e.kind.word): e for e in supervisor.plant.events if e.kind.sent}

    @cache
    def fields() -> Fields:
        return KnownFields(robot, MessageDefinitions.for_model(Path(robot.span.source.path)))

    def demand(key: str, kind: str, data: Any) -> None:
        if (key, kind) in sent:
            fields().demand_fitting(sent[key, kind], data)

    return demand


def supervisor_with(
    supervisor: Supervisor, values: Mapping[str, Any], starts: Mapping[str, Any] = _NOTHING
) -> Supervisor:
    """The supervisor for a robot whose parameters have these values, by name in ROS, and whose
    persistent variables start with those of ``starts``.

    What it allows is the same for all; where the robot starts, and its data, are not.

    Raises:
        InvalidLine: there is no such variable, or the value is not of its type.
    """
    robot = supervisor.plant.robot
    try:
        chosen = with_starts(with_parameters(robot, values), starts)
    except ValueError as error:
        raise InvalidLine(str(error)) from None
    if chosen is robot:
        return supervisor
    plant = lower(chosen)
    events = dict(zip(map(id, supervisor.plant.events), plant.events, strict=True))
    guards = tuple(replace(g, event=events[id(g.event)]) for g in supervisor.guards)
    return replace(supervisor, plant=plant, guards=guards)


def started(supervisor: Supervisor, texts: Iterable[str]) -> Supervisor:
    """The supervisor with values of persistent variables, given as ``NAME=VALUE``.

    Raises:
        UsageError: one is no such variable, or has a wrong value.
    """
    try:
        return supervisor_with(supervisor, {}, parameters(texts))
    except InvalidLine as fault:
        raise UsageError(str(fault)) from None


def parameters(texts: Iterable[str]) -> dict[str, Any]:
    """Parameters by name from ``NAME=VALUE``. Raises InvalidLine."""
    found: dict[str, Any] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not name or not sign:
            raise InvalidLine(f"'{text}' is not a parameter: write NAME=VALUE")
        raw = parse_raw(value)
        if raw is None or isinstance(raw, dict):
            raise InvalidLine(f"'{value}' is not a value of the parameter {name}")
        found[name] = raw
    return found
