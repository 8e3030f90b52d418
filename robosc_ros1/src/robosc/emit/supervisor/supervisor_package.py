"""What the templates of supervisors see: both sides of each topic, service and action."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace

from robosc.emit.controller.python_literals import literal
from robosc.emit.package.config import Config
from robosc.emit.package.package_context import PackageContext, TopicView
from robosc.emit.supervisor.command_recognition import CommandMatch, command_matches
from robosc.errors import UsageError
from robosc.lazy_dataclasses import dataclass
from robosc.supervisor import Supervisor

PREFIX = "supervised"
"""First part of the names that the guarded controller uses instead of the robot's."""


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
    """What all templates of a supervisor see: those of a controller, with both names."""

    prefix: str
    controller: ControllerNode
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
    known = {f.name: getattr(base, f.name) for f in fields(base)}
    known["title"] = "Supervisor"
    known["heavy"] = False  # it passes on bytes
    known["parameters"] = tuple(
        p for p in base.parameters if re.split("[./]", p.name)[0] not in _IDLE
    )
    known |= {kind: _on_both_sides(getattr(base, kind)) for kind in (*_PLAIN, *_ACTIONS)}
    matches = command_matches(supervisor.plant.robot)
    known["publications"] = with_commands(known["publications"], matches)
    parts = {**dict.fromkeys(_PLAIN, ("",)), **dict.fromkeys(_ACTIONS, action_parts)}
    pairs = [
        (view.name + part, view.controller + part)
        for kind, ends in parts.items()
        for view in known[kind]
        for part in ends
    ]
    return RelayContext(
        **known,
        prefix=PREFIX,
        controller=_controller(config),
        # A private name is the supervisor's own; the controller's node has no such.
        remaps=tuple(dict.fromkeys(pair for pair in pairs if not pair[0].startswith("~"))),
    )


_PLAIN = ("subscriptions", "publications", "services", "served_services")
_ACTIONS = ("actions", "served_actions")


def _on_both_sides(views: tuple[TopicView, ...]) -> tuple[TopicView, ...]:
    return tuple(replace(view, controller=controller_name(view.name)) for view in views)


def controller_name(name: str) -> str:
    """Return the name that the guarded controller uses instead of one of the robot's."""
    for start in ("~/", "~", "/"):
        if name.startswith(start):
            return f"{start}{PREFIX}/{name.removeprefix(start)}"
    return f"{PREFIX}/{name}"


def with_commands(
    topics: Iterable[TopicView], matches: Mapping[tuple[str, str], tuple[CommandMatch, ...]]
) -> tuple[TopicView, ...]:
    """Topics with the commands on them, see :func:`robosc.runtime.judge.matching.command_patterns`:
    exact data before a field, for they may have a value of that, too."""
    means = {match.key: match for found in matches.values() for match in found}
    return tuple(
        replace(
            topic,
            commands=tuple(
                ", ".join(map(literal, (match.key, match.exact, match.field)))
                for match in sorted((means[key] for key in topic.keys), key=lambda m: not m.exact)
            ),
        )
        for topic in topics
    )


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
