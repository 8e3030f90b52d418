"""The machine that a command line asks for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from robosc.simulate.execute import Execution
from robosc.simulate.faults import InvalidLine
from robosc.simulate.machine import Machine
from robosc.simulate.session import MakeMachine
from robosc.simulate.single import SingleEvents
from robosc.simulate.values import parse_raw
from robosc.supervisor import Supervisor

__all__ = ["machine_maker", "parameters"]


def machine_maker(supervisor: Supervisor, *, execute: bool) -> MakeMachine:
    """Makes machines of single events, or of the controller as it executes."""

    def make(given: Mapping[str, Any]) -> Machine:
        if execute:
            return Execution(supervisor, given)
        if given:
            raise InvalidLine("parameters are those of the executing controller: use --execute")
        return SingleEvents(supervisor)

    return make


def parameters(texts: Iterable[str]) -> dict[str, Any]:
    """Parameters by name from ``NAME=VALUE``. Raises InvalidLine."""
    found: dict[str, Any] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not name or not sign:
            raise InvalidLine(f"'{text}' is no parameter: write NAME=VALUE")
        raw = parse_raw(value)
        if raw is None or isinstance(raw, dict):
            raise InvalidLine(f"'{value}' is no value of the parameter {name}")
        found[name] = raw
    return found
