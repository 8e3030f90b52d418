"""The parameters of a controller node: names, types, defaults, meaning, and how they are checked.

Both ROS versions declare the same parameters; here they are plain data. Per communication there are
``timeout/<name>`` (and ``goal_timeout/<name>`` for actions), where a dot in the name is a slash.
"""

from __future__ import annotations

import difflib
import math
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from .model import Communication

__all__ = [
    "Parameter",
    "ParameterError",
    "Settings",
    "declared",
    "flatten",
    "parameter_name",
    "read",
]


class ParameterError(Exception):
    """Parameters that the node cannot start with; the text names each of them."""


class Parameter(NamedTuple):
    """``type`` is "number", "integer", "boolean" or "string"; an empty string means "not set"."""

    name: str
    type: str
    default: Any
    meaning: str
    choices: Tuple[str, ...] = ()
    minimum: Optional[float] = None


class Settings(NamedTuple):
    """The checked values; the maps are by key of the communication."""

    rate: float = 10.0
    order: str = "rotate"
    seed: int = 0
    on_mismatch: str = "ignore"
    stop_command: str = ""
    exit_on_stop: bool = False
    server_lost_after: float = 5.0
    state_rate: float = 20.0
    publish_events: bool = True
    event_log: str = ""
    event_log_size: float = 10.0
    event_log_files: int = 5
    legacy_state_topic: str = ""
    timeout: Mapping[str, float] = {}
    goal_timeout: Mapping[str, float] = {}

    def timeout_of(self, key: str) -> float:
        return self.timeout.get(key, 5.0)

    def goal_timeout_of(self, key: str) -> Optional[float]:
        return self.goal_timeout.get(key) or None


_GENERAL = (
    Parameter(
        "rate", "number", 10.0,
        "how often a command is repeated while it stays allowed, in Hz", minimum=1e-3,
    ),
    Parameter(
        "order", "string", "rotate",
        "which of several due commands goes first", choices=("rotate", "declared", "random"),
    ),
    Parameter("seed", "integer", 0, "seed of the random order"),
    Parameter(
        "on_mismatch", "string", "ignore",
        "what to do when the robot reports what the model says cannot happen",
        choices=("ignore", "stop"),
    ),
    Parameter(
        "stop_command", "string", "",
        "communication that is requested once at a safe stop and at shutdown, guard or not",
    ),
    Parameter("exit_on_stop", "boolean", False, "end the node after a safe stop"),
    Parameter(
        "server_lost_after", "number", 5.0,
        "seconds of wall time without status after which an action's server counts as lost",
        minimum=0.1,
    ),
    Parameter("state_rate", "number", 20.0, "limit for the rate of ~state, in Hz", minimum=0.1),
    Parameter("publish_events", "boolean", True, "publish each event on ~events"),
    Parameter("event_log", "string", "", "file that gets each event as a line of JSON"),
    Parameter(
        "event_log_size", "number", 10.0,
        "size at which the log file is rotated, in MB", minimum=1e-3,
    ),
    Parameter("event_log_files", "integer", 5, "how many rotated log files are kept", minimum=0),
    Parameter(
        "legacy_state_topic", "string", "",
        "topic that gets the state in the layout of the original tool's /state",
    ),
)  # fmt: skip


def parameter_name(name: str) -> str:
    """A communication's name as a part of a parameter's name."""
    return name.replace(".", "/")


def declared(communications: Sequence[Communication]) -> List[Parameter]:
    """All parameters of a controller, in the order in which they are documented."""
    result = list(_GENERAL)
    for communication in communications:
        name = parameter_name(communication.name)
        if communication.sort == "service":
            meaning = "deadline of a call of %s, in seconds" % communication.name
            result.append(Parameter("timeout/" + name, "number", 5.0, meaning, minimum=1e-3))
        elif communication.sort == "action":
            meaning = "deadline until a goal of %s is accepted, in seconds" % communication.name
            result.append(Parameter("timeout/" + name, "number", 5.0, meaning, minimum=1e-3))
            meaning = "deadline of an accepted goal of %s, in seconds; 0: none" % communication.name
            result.append(Parameter("goal_timeout/" + name, "number", 0.0, meaning, minimum=0.0))
    return result


def flatten(tree: Mapping[str, Any], prefix: str = "") -> Dict[str, Any]:
    """Nested parameters by their full names."""
    flat: Dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, dict):
            flat.update(flatten(value, prefix + name + "/"))
        else:
            flat[prefix + name] = value
    return flat


def read(
    communications: Sequence[Communication], given: Mapping[str, Any]
) -> Tuple[Settings, List[str]]:
    """The settings from parameters by full name, and warnings about names that mean nothing.

    Raises:
        ParameterError: values of the wrong type or outside what is allowed; all of them are named.
    """
    parameters = {p.name: p for p in declared(communications)}
    warnings = []
    for name in given:
        if name not in parameters:
            near = difflib.get_close_matches(name, parameters, 1)
            hint = "; did you mean ~%s?" % near[0] if near else ""
            warnings.append("unknown parameter ~%s is ignored%s" % (name, hint))
    faults = []
    values: Dict[str, Any] = {}
    for parameter in parameters.values():
        value = given.get(parameter.name, parameter.default)
        fault = _fault(parameter, value)
        if fault:
            faults.append("parameter ~%s must be %s, not %r" % (parameter.name, fault, value))
        else:
            values[parameter.name] = float(value) if parameter.type == "number" else value
    names = {c.name: c.key for c in communications if c.sort != "outgoing"}
    stop = values.get("stop_command", "")
    if stop and stop not in names:
        faults.append(
            "parameter ~stop_command must name a message, service or action that the controller"
            " can request (%s), not %r" % (", ".join(names), stop)
        )
    if faults:
        raise ParameterError("\n".join(faults))
    return _settings(communications, values, names.get(stop, "")), warnings


def _fault(parameter: Parameter, value: Any) -> Optional[str]:
    """What the value must be, if it is not."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if parameter.type == "boolean":
        return None if isinstance(value, bool) else "true or false"
    if parameter.type == "string":
        if not isinstance(value, str):
            return "a string"
        if parameter.choices and value not in parameter.choices:
            return "one of " + ", ".join(parameter.choices)
        return None
    what = "an integer" if parameter.type == "integer" else "a number"
    if not number or not math.isfinite(value):
        return what
    if parameter.type == "integer" and not isinstance(value, int):
        return what
    if parameter.minimum is not None and value < parameter.minimum:
        return "%s of at least %g" % (what, parameter.minimum)
    return None


def _settings(
    communications: Sequence[Communication], values: Dict[str, Any], stop: str
) -> Settings:
    timeouts = {}
    goal_timeouts = {}
    for communication in communications:
        name = parameter_name(communication.name)
        if communication.sort in ("service", "action"):
            timeouts[communication.key] = values.pop("timeout/" + name)
        if communication.sort == "action":
            goal_timeouts[communication.key] = values.pop("goal_timeout/" + name)
    values["stop_command"] = stop
    return Settings(timeout=timeouts, goal_timeout=goal_timeouts, **values)
