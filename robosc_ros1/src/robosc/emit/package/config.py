"""Options of the generator that lie beside a model: ``robosc.yaml``, ``controller-config.json``.

The second is the file of the original RoboSC, see :mod:`robosc.emit.package.original_config`; what
``robosc.yaml`` sets takes precedence.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Any

from robosc.emit.controller.python import duration
from robosc.errors import UsageError
from robosc.expr import tree, types
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model.declarations.parameters import KEEPING
from robosc.model.entities import Communication, Robot
from robosc.runtime.core import model, qos, settings, shapes
from robosc.runtime.core.shortening import excerpt

EVENT_LOG = "~/.ros/log/{package}.jsonl"
OWN = "robosc.yaml"


@dataclass(frozen=True)
class Config:
    """Options of one generation; what the command line says goes before ``package`` and ``output``.

    ``output`` are the folders that get packages, by target; ``locations`` those that become the
    package themselves, by target and mode. ``parameters`` are defaults of the node's parameters by
    their full names. ``supervisor`` names the node that a supervisor guards, as it stands in the
    file; ``lifecycle`` makes a managed node of one of ROS 2. ``untested`` are the commands that the
    package's test need not show. ``warnings`` are what somebody should
    know who wrote the files.
    """

    package: str | None = None
    output: Mapping[str, Path] = field(default_factory=dict)
    locations: Mapping[tuple[str, str], Path] = field(default_factory=dict)
    version: str = "0.1.0"
    maintainer: str = "robosc"
    email: str = "robosc@example.org"
    licence: str = "BSD-3-Clause"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    supervisor: Mapping[str, Any] = field(default_factory=dict)
    lifecycle: bool = False
    untested: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def of_package(self, package: str) -> Config:
        """The same; the log that the original's file asks for is one of the package's own."""
        if self.parameters.get("event_log") != EVENT_LOG:
            return self
        log = EVENT_LOG.format(package=package)
        return replace(self, parameters={**self.parameters, "event_log": log})

    def checked(self, robot: Robot) -> Config:
        """The same, if the parameters fit the robot, with the stop command of the model as default.

        Each quality of a message is that of all messages on its topic. (ROS 1 has no such quality,
        but one file may serve both.)

        Raises:
            UsageError: one has a wrong value or is unknown.
        """
        communications = declared_communications(robot)
        more = [*playable_parameters(robot), *qos.qos_parameters(communications)]
        stop = {} if robot.stop is None else {"stop_command": robot.display_names[robot.stop]}
        try:
            own = shapes.gathered(more, {**stop, **self.parameters})
            given = qos.shared(communications, own, shared_topics(robot))
            settings.read(communications, given, more, strict=True)
        except settings.ParameterError as error:
            raise UsageError(str(error)) from error
        return replace(self, parameters=given)


DEFAULTS = Config()
"""Without any file."""


ATTRIBUTES = model.Communication._fields[model.Communication._fields.index("timeout") :]
"""What the runtime knows of a communication from its attributes, by the names in the model."""


def declared_communications(robot: Robot) -> list[model.Communication]:
    """The communications as the runtime knows them."""
    return [
        model.Communication(c.key, robot.display_names[c.key], c.sort.name, **_attributes(c, robot))
        for c in robot.communications.values()
    ]


def _attributes(communication: Communication, robot: Robot) -> dict[str, Any]:
    values = {name: getattr(communication, name) for name in ATTRIBUTES}
    repeated = (c.key for c in communication.commands if c.kind is not EventKind.ANSWER)
    if values["rate"] == model.ONCE and not robot.performed.keys().isdisjoint(repeated):
        del values["rate"]  # it is due whenever a state that performs it begins
    return {
        n: duration(v) if isinstance(v, tree.Literal | tree.ParameterRef) else v
        for n, v in values.items()
    }


def declared_parameters(
    robot: Robot, attributes: Mapping[str, str] | None = None
) -> list[model.Parameter]:
    """The model's parameters as the runtime knows them.

    ``attributes`` are those of the generated controller, by the parameters' keys.
    """
    own = [
        model.Parameter(
            p.name,
            meaning=f"parameter {p.key} of the model"
            + _IN_SECONDS * (p.type == types.DurationType()),
            default=p.default,
            attribute="" if attributes is None else attributes[p.key],
            required=p.required,
            **{**_allowed(p.type), **_between(p.bounds)},
        )
        for p in robot.parameters
    ]
    return [*own, *(KEEPING if robot.persistent else ())]


def playable_parameters(robot: Robot) -> list[model.Parameter]:
    """The same, none of which must be given."""
    return [p._replace(required=False) for p in declared_parameters(robot)]


_IN_SECONDS = ", in seconds"


def _shape(type_: types.Type) -> Any:
    """What is in an array or object; see :mod:`robosc.runtime.core.shapes`."""
    match type_:
        case types.ArrayType(element=element):
            return [_shape(element)]
        case types.ObjectType(properties=properties):
            return {name: _shape(inner) for name, inner in properties}
    return _allowed(type_)["type"]


def _between(bounds: tuple[float, float] | None) -> dict[str, Any]:
    return {} if bounds is None else {"minimum": bounds[0], "maximum": bounds[1]}


def _allowed(type_: types.Type) -> dict[str, Any]:
    """What a parameter of a type may be given."""
    match type_:
        case types.BooleanType():
            return {"type": "boolean"}
        case types.IntegerType(bounds=(low, high)):
            return {"type": "integer", "minimum": low, "maximum": high}
        case types.IntegerType():
            return {"type": "integer"}
        case types.DurationType():
            return {"type": "number", "minimum": settings.SHORTEST_DURATION}
        case types.EnumType(values=values):
            return {"type": "string", "choices": values}
        case types.ArrayType():
            return {"type": "array", "shape": _shape(type_)}
        case types.ObjectType():
            return {"type": "object", "shape": _shape(type_)}
        case types.StringType():
            return {"type": "string"}
    return {"type": "number"}


def shared_topics(robot: Robot) -> list[tuple[str, list[str]]]:
    """Each topic with the keys of the messages that come or go there."""
    topics: dict[tuple[str, Kind, str], list[Communication]] = {}
    for communication in robot.communications.values():
        if communication.kind in (Kind.INCOMING, Kind.OUTGOING) and not communication.frames:
            type_ = f"{communication.binding.package}/{communication.binding.type}"
            place = (communication.ros_name, communication.kind, type_)
            topics.setdefault(place, []).append(communication)
    return [(found[0].identifier, [c.key for c in found]) for found in topics.values()]


def read_text(file: Path) -> str:
    """The text of a file with options.

    Raises UsageError if it cannot be read.
    """
    try:
        return file.read_text(encoding="utf-8-sig")  # some editors begin with a mark
    except OSError as error:
        raise UsageError(f"cannot read {file}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"cannot read {file}: it is not UTF-8 text") from error


def read_own(file: Path, config: Config) -> Config:
    """The options with those that a ``robosc.yaml`` sets.

    Raises:
        UsageError: it cannot be read, is no YAML, or has a key or value that is not known; the
            message names file and key.
    """
    return _apply(file, _parsed_yaml(file, read_text(file)), config)


def _parsed_yaml(file: Path, text: str) -> Any:
    try:
        import yaml
    except ImportError as error:
        raise UsageError(f"{file} cannot be read: python3-yaml is not installed") from error

    class Loader(yaml.SafeLoader):  # type: ignore[misc]
        """YAML says that keys are unique; its reader takes the last of several."""

        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            seen: set[str] = set()
            for key, _ in node.value:
                if str(key.value) in seen:
                    place = f"{key.start_mark.line + 1}:{key.start_mark.column + 1}"
                    raise UsageError(f"{file}:{place}: duplicate key {key.value!r}")
                seen.add(str(key.value))
            return super().construct_mapping(node, deep)

    try:
        return yaml.load(text, Loader)
    # A ValueError is that of an integer with too many digits, or of a date that no calendar has.
    except (yaml.YAMLError, ValueError) as error:
        raise UsageError(f"{file}: {' '.join(str(error).split())}") from error
    except RecursionError as error:
        raise UsageError(f"{file} is nested too deeply") from error


Setter = Callable[[Config, Any, Path], Config]


def _apply(file: Path, document: Any, config: Config) -> Config:
    if document is None:
        return config
    if not isinstance(document, dict):
        raise UsageError(f"{file} must hold keys and values")
    for key, value in document.items():
        if key not in _KEYS:
            raise UsageError(f"{file}: unknown key {key!r}; {key_hint(str(key), _KEYS)}")
        try:
            config = _KEYS[key](config, value, file)
        except ValueError as error:
            raise UsageError(f"{file}: {key} must be {error}, not {excerpt(value)}") from None
    return config


def key_hint(key: str, known: Collection[str]) -> str:
    """What to write instead of a key that is not known."""
    near = difflib.get_close_matches(key, known, 1)
    return f"did you mean {near[0]}?" if near else f"known keys: {', '.join(known)}"


def _valid(
    name: str, fits: Callable[[Any], Any], what: str, made: Callable[[Any], Any] = lambda v: v
) -> Setter:
    def put(config: Config, value: Any, _: Path) -> Config:
        if not fits(value):
            raise ValueError(what)
        changes: dict[str, Any] = {name: made(value)}
        return replace(config, **changes)

    return put


def _text(name: str, pattern: str, what: str) -> Setter:
    return _valid(name, lambda v: isinstance(v, str) and re.fullmatch(pattern, v), what)


def _output(config: Config, value: Any, file: Path) -> Config:
    """A folder, or one per target; relative ones start at the folder of the file."""
    places = value if isinstance(value, dict) else {"ros1": value, "ros2": value}
    folders = {}
    for target, folder in places.items():
        name = str(target).lower()
        if name not in ("ros1", "ros2") or not isinstance(folder, str):
            raise ValueError("a folder, or folders for ros1 and ros2")
        folders[name] = file.parent / Path(folder).expanduser()
    # What the original's file says of these targets is no longer asked for.
    locations = {key: place for key, place in config.locations.items() if key[0] not in folders}
    return replace(config, output={**config.output, **folders}, locations=locations)


def _parameters(config: Config, value: Any, _: Path) -> Config:
    if not isinstance(value, dict):
        raise ValueError("names of parameters with their values")
    return replace(config, parameters={**config.parameters, **settings.flatten(value)})


def _are_texts(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(part, str) for part in value)


_KEYS: Mapping[str, Setter] = {
    "package": _text("package", r"[a-z][a-z0-9_]*", "a package name in lower case"),
    "output": _output,
    "version": _text("version", r"\d+\.\d+\.\d+", "a text like 1.2.3"),
    "maintainer": _text("maintainer", r".*\S.*", "a name"),
    "email": _text("email", r"[^@\s]+@[^@\s]+\.[^@\s.]+", "an address with a dotted domain"),
    "license": _text("licence", r".*\S.*", "the name of a licence"),
    "parameters": _parameters,
    "supervisor": _valid("supervisor", lambda v: isinstance(v, dict), "a section"),
    "lifecycle": _valid("lifecycle", lambda v: isinstance(v, bool), "true or false"),
    "untested": _valid("untested", _are_texts, "names of commands", tuple),
}
