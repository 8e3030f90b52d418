"""From a supervisor to a package, by the table of a target."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from robosc import __version__, resources
from robosc.emit.controller import assembly, template_data
from robosc.emit.controller.python_literals import assignment, literal
from robosc.emit.package import package_context
from robosc.emit.package.config import Config, declared_parameters
from robosc.emit.package.model_document import model_document
from robosc.emit.package.package import (
    MARKER,
    File,
    Mode,
    Package,
    frozen_files,
    own_modules,
    own_test_files,
    runtime_files,
)
from robosc.emit.package.readme import ParameterView, readme_context
from robosc.emit.package.rendering import render
from robosc.emit.supervisor import listening, meant_messages, supervisor_package
from robosc.emit.write.line_breaks import break_long_lines
from robosc.expr.tree import ReasonRef
from robosc.language.events import EventKind, Kind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Communication, Robot
from robosc.names import package_name, rostest_name
from robosc.plant.event_values import values_read
from robosc.runtime.core import launch_arguments, settings
from robosc.supervisor import Supervisor

# What the test of a controller's package knows of the robot that it plays.


USUAL = {
    "event_log": "",
    "exit_on_stop": False,
    "on_mismatch": "ignore",
    "order": "rotate",
    "server_lost_after": 1e5,
    "state_rate": 200.0,
    "stop_command": "",
    "whole_values": True,
}
"""The parameters of a node under test, but for those of the model and those that a script sets."""

OF_MODE: dict[Mode, dict[str, Any]] = {
    "controller": {},
    "supervisor": {},
    "monitor": {"tolerance": 0.0},
}
"""Those of one mode: what is sent one by one does not cross."""
TOLD: dict[Mode, list[str]] = {
    "controller": [],
    "supervisor": ["~/blocked"],
    "monitor": ["~/findings"],
}
"""The topics on which a node tells what it judges."""


def communications_under_test(robot: Robot) -> dict[str, dict[str, Any]]:
    """By name: the key of a communication, its kind, and by event the field of a plain value."""
    return {
        robot.display_names[c.key]: {"key": c.key, "kind": c.kind.value, "fields": _fields(c)}
        for c in robot.communications.values()
    }


def read_when_failed(robot: Robot) -> list[str]:
    """The keys of the actions of which the model reads the result of a goal that failed."""
    found = []
    for _, transition in robot.transitions:
        read = values_read(transition.expressions).values()
        if transition.event is EventKind.ERROR and not all(isinstance(v, ReasonRef) for v in read):
            found.append(transition.communication)
    return sorted(set(found))


def _fields(communication: Communication) -> dict[str, str]:
    found = {}
    for sort in communication.sort.events:
        field = getattr(communication.binding, f"{sort.brings}_field", None)
        if field is not None:
            found[sort.kind.word] = field
    return found


def commands_under_test(robot: Robot) -> list[tuple[str, str]]:
    """Name and kind of each command."""
    return [
        (robot.display_names[c.key], sort.kind.word)
        for c in robot.communications.values()
        for sort in c.sort.events
        if sort.kind.controllable
    ]


@dataclass(frozen=True)
class Target:
    """A version of ROS: the files of its packages, and how it spells names and types.

    ``modules`` is the folder of a package's own Python modules. ``templates`` has the templates of
    all packages by the paths of their files, ``of_mode`` those of one mode; in paths, ``{package}``
    stands for the package and ``{rostest}`` for its test. ``program`` is the module of the
    test that is started. ``dependencies`` are the packages that every package needs.
    ``identifier`` is a communication's name in ROS, ``module`` and ``type`` are module and class of
    its type in Python, ``interface`` is that type for the tools of ROS. ``action_parts`` are the
    names below that of an action; ``shows_results``: whoever listens there gets the results of
    goals.
    ``has_qos``: nodes have parameters for the quality of service; ``has_lifecycle``: there are
    managed nodes.
    """

    name: str
    modules: str
    templates: Mapping[str, str]
    of_mode: Mapping[Mode, Mapping[str, str]]
    program: str
    dependencies: tuple[str, ...]
    identifier: Callable[[Communication], str]
    module: Callable[[Communication], str]
    type: Callable[[Communication], str]
    interface: Callable[[Communication], str]
    parameters: Callable[[Robot, Config], tuple[ParameterView, ...]]
    action_parts: tuple[str, ...]
    shows_results: bool
    has_qos: bool
    has_lifecycle: bool


_XML = ("package.xml", "launch", "rostest")
"""How the names of templates end that make XML."""

_NODES: Mapping[Mode, str] = {
    "controller": "node.py",
    "supervisor": "supervisor_node.py",
    "monitor": "monitor_node.py",
}


def package_of(
    target: Target,
    supervisor: Supervisor,
    package: str,
    config: Config,
    mode: Mode,
    runs: Mapping[str, str],
) -> Package:
    """The package, ready to be written and built.

    ``package`` is a legal package name; the node has the same. ``runs`` are further files, by path:
    those of its test.

    Raises:
        ModelError: a supervisor cannot do what it must with the topics of the model.
        UsageError: the configuration does not fit the robot.
    """
    robot = supervisor.plant.robot
    source = robot.span.source.file_name
    controller = assembly.controller_context(supervisor, source)
    context = _context(target, robot, package, controller.class_name, config.checked(robot))
    controls = config.package or f"{package_name(robot.name)}_controller"
    if mode != "monitor":  # which alone may be a shadow
        own = tuple(p for p in context.parameters if p.name != "shadow")
        context = replace(context, parameters=own)
    if mode == "supervisor":
        context = supervisor_package.relay_context(context, supervisor, config, target.action_parts)
    elif mode == "monitor":
        context = listening.monitor_context(context, supervisor, controls, target.shows_results)
    readme = readme_context(
        supervisor,
        package,
        context.parameters,
        lambda c: (target.identifier(c), target.interface(c)),
    )
    if mode == "monitor":
        readme = listening.monitor_readme(readme, context, robot, controls)
    modules = target.modules.format(package=package)
    texts = {
        f"{modules}/__init__.py": _data_module(source, f"{context.title} of {robot.name}."),
        f"{modules}/controller.py": render("common/node/controller.py.jinja", controller),
        f"{modules}/model.py": _model_module(supervisor, source),
        "LICENSE": _licence(source),
        f"{modules}/node.py": render(f"common/node/{_NODES[mode]}.jinja", context),
        **runs,
    }
    texts["test/robot_tables.py"] = _robot_module(target, robot, context, mode)
    texts["test/players.py"] = _players_module(source, mode)
    for path, template in {**target.templates, **target.of_mode[mode]}.items():
        shown = package_context.escaped(context) if template.endswith(_XML) else context
        text = render(f"{target.name}/{template}.jinja", readme if path == "README.md" else shown)
        texts[path.format(package=package, rostest=rostest_name(package))] = text
    files = {path: File(text) for path, text in texts.items()}
    files |= own_modules(package, modules, target.name, files)
    files |= own_test_files(files, target.name, target.program)
    parts = [*_parts(controller, robot, mode), *(["core/heavy"] if context.heavy else [])]
    files |= runtime_files(f"{modules}/_runtime", files, parts)
    return Package(package, frozen_files(files), target.name)


def _parts(controller: template_data.ControllerContext, robot: Robot, mode: Mode) -> Iterator[str]:
    """The modules of the runtime that an engine imports when its model needs them."""
    communications = robot.communications.values()
    if robot.transforms:
        yield "core/transforms"
    if any(c.max_age is not None for c in communications):
        yield "core/ages"
    if any(p.shape is not None for p in declared_parameters(robot)):
        yield "core/shapes"
    if controller.persistent:
        yield "core/persistence"
    if mode != "monitor" and any(c.sort.served for c in communications):
        yield "served/served_calls"
        if mode == "supervisor":
            yield "served/relayed_calls"


def _data_module(source: str, sentence: str, body: str = "") -> str:
    """A Python module that holds nothing but data."""
    head = f"# This file was generated by robosc from {source}. Do not edit it: change the model.\n"
    return break_long_lines(f'{head}"""{sentence}"""\n') + body


def _model_module(supervisor: Supervisor, source: str) -> str:
    sentence = "The model as data, as it is published on ~model."
    model = assignment("MODEL", model_document(supervisor, source))
    version = assignment("GENERATOR", f"robosc {__version__}")
    hashes = {Path(s.path).name: s.sha256 for s in supervisor.plant.robot.sources}
    sources = assignment("SOURCES", hashes)
    return _data_module(source, sentence, f"\n{version}{sources}{model}")


def _licence(source: str) -> str:
    """The licence of what robosc adds to the model."""
    text = (resources.templates_folder() / "common" / "LICENSE").read_text(encoding="utf-8")
    head = f"This package was {MARKER} {__version__} from {source}. Of what is not from that model:"
    return f"{textwrap.fill(head, 100)}\n\n{text}"


def _robot_module(
    target: Target, robot: Robot, context: package_context.PackageContext, mode: Mode
) -> str:
    """What the package's test knows of the package and of the robot."""
    parameters = {
        name: value
        for p in context.parameters
        if p.example is not None
        for name, value in launch_arguments.parts_by_name(p.name, p.example)
    }
    names = robot.display_names
    outgoing = (c for c in robot.communications.values() if c.kind is Kind.OUTGOING)
    messages = [settings.parameter_name(names[c.key]) for c in outgoing]
    modules = ["ros_messages", "ros_parameters"] if target.has_qos else ["ros_messages"]
    offered = [
        "COMMANDS", "COMMUNICATIONS", "MEANT", "MESSAGES", "PACKAGE", "PARAMETERS", "RESULTS",
        "TABLES", "TOLD", "USUAL",
    ]  # fmt: skip
    body = f"\nfrom {context.package} import {', '.join(modules)}\n"
    body += f"from {context.package}.node import TABLES\n\n"
    body += assignment("__all__", offered + modules)
    body += f'\nPACKAGE = "{context.package}"\n'
    body += assignment("PARAMETERS", parameters)
    kept: dict[str, Any] = {p.name: "" for p in context.parameters if p.name == "persistent_file"}
    transformed = (key for keys in robot.transforms.values() for key in keys)
    kept |= {f"rate/{settings.parameter_name(names[key])}": 0.0 for key in transformed}
    body += assignment("USUAL", {**USUAL, **OF_MODE[mode], **kept})
    body += assignment("TOLD", TOLD[mode])
    body += assignment("MEANT", meant_messages.meant(robot) if mode != "controller" else {})
    body += assignment("MESSAGES", messages)
    body += assignment("COMMUNICATIONS", communications_under_test(robot))
    body += assignment("RESULTS", read_when_failed(robot))
    body += assignment("COMMANDS", commands_under_test(robot))
    return _data_module(
        context.source, "What the test uses of the package, and knows of the robot.", body
    )


def _players_module(source: str, mode: Mode) -> str:
    """Who plays beside the node: the robot, and the controller that another node judges."""
    own = "from player import Player\nfrom ros_player import Robot"
    if mode != "controller":
        own = "from guarded_player import GuardedPlayer as Player, GuardedRobot as Robot"
    body = f'\n{own}\n\n__all__ = ["Player", "Robot"]\n'
    return _data_module(source, "Who plays in the package's test.", body)


def _context(
    target: Target, robot: Robot, package: str, class_name: str, config: Config
) -> package_context.PackageContext:
    communications = robot.communications.values()
    parameters = target.parameters(robot, config)

    def type_(communication: Communication) -> str:
        return f"{target.module(communication)}.{target.type(communication)}"

    def messages(kind: Kind) -> tuple[package_context.TopicView, ...]:
        found = (c for c in communications if c.kind is kind and c.frames is None)
        return package_context.topics(found, target.identifier, type_)

    more = ("tf2_msgs",) if robot.transforms else ()

    def servers(kind: Kind) -> tuple[package_context.TopicView, ...]:
        return tuple(
            package_context.TopicView(target.identifier(c), type_(c), key=c.key)
            for c in communications
            if c.kind is kind
        )

    return package_context.PackageContext(
        package=package,
        node_name=package,
        robot=robot.name,
        source=robot.span.source.file_name,
        version=config.version,
        maintainer=config.maintainer,
        maintainer_email=config.email,
        licence=config.licence,
        class_name=class_name,
        dependencies=tuple(
            sorted({c.binding.package for c in communications}.union(target.dependencies, more))
        ),
        modules=tuple(sorted({target.module(c) for c in communications if c.frames is None})),
        subscriptions=messages(Kind.OUTGOING),
        heavy=any(
            c.kind is Kind.OUTGOING and c.frames is None and not c.binding.light
            for c in communications
        ),
        publications=messages(Kind.INCOMING),
        services=servers(Kind.SERVICE),
        actions=servers(Kind.ACTION),
        transforms=tuple(
            package_context.TransformView(*frames, keys)
            for frames, keys in robot.transforms.items()
        ),
        served_services=servers(Kind.SERVED_SERVICE),
        served_actions=servers(Kind.SERVED_ACTION),
        parameters=parameters,
        defaults=literal(
            {
                n: v
                for n, v in config.parameters.items()
                if target.has_qos or not n.startswith("qos/")
            }
        ),
        examples=tuple(
            f"{settings.dotted(name)}:={json.dumps(value)}"
            for p in parameters
            if p.example is not None
            for name, value in launch_arguments.parts_by_name(p.name, p.example)
        ),
        lifecycle=config.lifecycle and target.has_lifecycle,
    )
