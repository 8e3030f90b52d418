"""What the templates of supervisors see: both sides of each topic, service and action."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields, replace

from robosc.emit.controller.python_literals import literal
from robosc.emit.package.config import Config
from robosc.emit.package.package_context import PackageContext, TopicView
from robosc.emit.supervisor.command_recognition import CommandMatch, command_matches
from robosc.errors import UsageError
from robosc.supervisor import Supervisor

PREFIX = "supervised"
"""First part of the names that the guarded controller uses instead of the robot's."""


@dataclass(frozen=True)
class RelayView:
    """A topic, service or action by its names on both sides; ``commands`` as Python source."""

    robot: str
    controller: str
    type: str
    keys: tuple[str, ...] = ()
    key: str = ""
    commands: tuple[str, ...] = ()

    @property
    def row(self) -> str:
        """What stands for a service or an action in the table of ``node.py``."""
        names = f"{literal(self.controller)}, {literal(self.robot)}"
        return f"{names}, {self.type}, {literal(self.key)}"


@dataclass(frozen=True)
class ControllerNode:
    """The controller that is guarded, if the launch file is to start it; empty texts: it is not.

    These are the keys of the section ``supervisor`` in ``robosc.yaml``. ``launch_file`` is one of
    the package, which is included instead of starting an executable.
    """

    package: str = ""
    executable: str = ""
    name: str = "controller"
    namespace: str = ""
    arguments: str = ""
    launch_file: str = ""


@dataclass(frozen=True)
class RelayContext(PackageContext):
    """What all templates of a supervisor see: those of a controller, and both sides."""

    prefix: str
    controller: ControllerNode
    inputs: tuple[RelayView, ...]
    commands: tuple[RelayView, ...]
    relayed_services: tuple[RelayView, ...]
    relayed_actions: tuple[RelayView, ...]
    guarded_services: tuple[RelayView, ...]
    guarded_actions: tuple[RelayView, ...]
    remaps: tuple[tuple[str, str], ...]


_IDLE = ("rate", "order", "seed")
"""Parameters of commands that a supervisor does not send of its own."""


def relay_context(
    base: PackageContext, supervisor: Supervisor, config: Config, action_parts: tuple[str, ...]
) -> RelayContext:
    """The context of a supervisor from that of a controller.

    ``action_parts`` are the names below an action's own, which are remapped one by one.

    Raises:
        ModelError: see :func:`.guarding.command_matches`.
        UsageError: the configuration's section about the supervisor has a wrong key.
    """
    robot = supervisor.plant.robot
    means = {r.key: r for found in command_matches(robot).values() for r in found}
    known = {f.name: getattr(base, f.name) for f in fields(base)}
    known["title"] = "Supervisor"
    known["heavy"] = False  # it passes on bytes
    known["parameters"] = tuple(
        p for p in base.parameters if re.split("[./]", p.name)[0] not in _IDLE
    )
    inputs = tuple(_view(topic) for topic in base.subscriptions)
    commands = tuple(
        _view(topic, tuple(source_of(r) for r in in_order([means[key] for key in topic.keys])))
        for topic in base.publications
    )
    services = tuple(_view(service) for service in base.services)
    actions = tuple(_view(action) for action in base.actions)
    served = tuple(_view(service) for service in base.served_services)
    served_actions = tuple(_view(action) for action in base.served_actions)
    pairs = [(v.robot, v.controller) for v in (*inputs, *commands, *services, *served)]
    pairs += [
        (v.robot + part, v.controller + part)
        for v in (*actions, *served_actions)
        for part in action_parts
    ]
    return RelayContext(
        **known,
        prefix=PREFIX,
        controller=_controller(config),
        inputs=inputs,
        commands=commands,
        relayed_services=services,
        relayed_actions=actions,
        guarded_services=served,
        guarded_actions=served_actions,
        # A private name is the supervisor's own; the controller's node has no such.
        remaps=tuple(dict.fromkeys(pair for pair in pairs if not pair[0].startswith("~"))),
    )


def _view(topic: TopicView, commands: tuple[str, ...] = ()) -> RelayView:
    other = controller_name(topic.name)
    return RelayView(topic.name, other, topic.type, topic.keys, topic.key, commands)


def controller_name(name: str) -> str:
    """Return the name that the guarded controller uses instead of one of the robot's."""
    for start in ("~/", "~", "/"):
        if name.startswith(start):
            return f"{start}{PREFIX}/{name.removeprefix(start)}"
    return f"{PREFIX}/{name}"


def in_order(matches: list[CommandMatch]) -> list[CommandMatch]:
    """The patterns of a topic, exact data before a field: they may have a value of that, too."""
    return sorted(matches, key=lambda match: not match.exact)


def source_of(match: CommandMatch) -> str:
    """The row of a command, see :func:`robosc.runtime.judge.matching.command_patterns`."""
    return ", ".join(map(literal, (match.key, match.exact, match.field)))


def _controller(config: Config) -> ControllerNode:
    known = [f.name for f in fields(ControllerNode)]
    for name, value in config.supervisor.items():
        if name not in known or not isinstance(value, str):
            raise UsageError(
                f"the section 'supervisor' of the configuration must give texts for"
                f" {', '.join(known)}; not {name}: {value!r}"
            )
    node = ControllerNode(**config.supervisor)
    file = node.launch_file
    # A name alone is that of a file where packages have their launch files.
    return replace(node, launch_file=f"launch/{file}") if file and "/" not in file else node
