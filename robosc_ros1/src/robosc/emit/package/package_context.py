"""What the templates of a package see of it: names, topics, parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import field, replace
from xml.sax.saxutils import escape

from robosc.emit.controller.python_literals import literal
from robosc.emit.package.readme import ParameterView
from robosc.errors import UsageError
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import Communication
from robosc.resources import templates_folder

_TEST_DATA = ("robot_tables", "players", "shown")
"""The generated modules of a package's test."""


@dataclass(frozen=True)
class TopicView:
    """A topic, service or action; ``type`` as Python source, ``keys`` a tuple of communications.

    ``controller`` is its name for the controller that a supervisor guards, ``commands`` are those
    that others send on a topic, as Python source.
    """

    name: str
    type: str
    keys: tuple[str, ...] = ()
    key: str = ""
    controller: str = ""
    commands: tuple[str, ...] = ()

    @property
    def row(self) -> str:
        """What stands for it in the table of ``node.py``."""
        names = [self.controller, self.name] if self.controller else [self.name]
        return ", ".join([*map(literal, names), self.type, literal(self.keys or self.key)])


@dataclass(frozen=True)
class TransformView:
    """The transform between two frames."""

    source: str
    target: str
    keys: tuple[str, ...]


@dataclass(frozen=True)
class HeardView:
    """What whoever listens can hear of the commands of a robot; keys of communications.

    ``by_data`` are those of the commands that are not judged since their data decide; ``orders``
    are groups of which the order of events matters.
    """

    commands: tuple[TopicView, ...] = ()
    actions: tuple[TopicView, ...] = ()
    unseen: tuple[str, ...] = ()
    unjudged: tuple[str, ...] = ()
    by_data: tuple[str, ...] = ()
    orders: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True)
class PackageContext:
    """What all templates of a target see."""

    package: str
    node_name: str
    robot: str
    source: str
    version: str
    maintainer: str
    maintainer_email: str
    licence: str
    class_name: str
    dependencies: tuple[str, ...]
    modules: tuple[str, ...]
    subscriptions: tuple[TopicView, ...]
    publications: tuple[TopicView, ...]
    services: tuple[TopicView, ...]
    actions: tuple[TopicView, ...]
    parameters: tuple[ParameterView, ...]
    defaults: str
    """The configuration's own defaults of parameters, as Python source."""
    transforms: tuple[TransformView, ...] = field(default=(), kw_only=True)
    served_services: tuple[TopicView, ...] = field(default=(), kw_only=True)
    served_actions: tuple[TopicView, ...] = field(default=(), kw_only=True)
    title: str = field(default="Controller", kw_only=True)
    heavy: bool = field(default=False, kw_only=True)
    """Whether inputs may be of any size."""
    heard: HeardView = field(default=HeardView(), kw_only=True)
    """Of a monitor."""
    examples: tuple[str, ...] = field(default=(), kw_only=True)
    """What the test of a package of ROS 2 gives for the parameters that must be given."""
    lifecycle: bool = field(default=False, kw_only=True)
    """Whether a node of ROS 2 is a managed one."""

    def __post_init__(self) -> None:
        """Raises UsageError if the package would stand in the way of one that it needs, or one of
        its test's modules in the way of the package."""
        fault = None
        if self.package in self.dependencies:
            fault = "it needs the package of that name"
        elif self.package in _TEST_DATA or any(templates_folder().rglob(f"{self.package}.py")):
            fault = "the package's test has a module of that name"
        if fault is not None:
            raise UsageError(f"{self.package!r} is not a valid name for a package: {fault}")


def topics(
    communications: Iterable[Communication],
    name: Callable[[Communication], str],
    type_: Callable[[Communication], str],
) -> tuple[TopicView, ...]:
    """One entry per topic and type, whatever number of messages share it."""
    shared: dict[tuple[str, str], list[Communication]] = {}
    for communication in communications:
        place = (communication.ros_name, type_(communication))
        shared.setdefault(place, []).append(communication)
    return tuple(
        TopicView(name(messages[0]), kind, tuple(message.key for message in messages))
        for (_, kind), messages in shared.items()
    )


def escaped(context: PackageContext) -> PackageContext:
    """The context with texts fit for XML."""
    quotes = {'"': "&quot;"}
    parameters = tuple(
        replace(p, doc=escape(p.doc, quotes), default=escape(p.default, quotes))
        for p in context.parameters
    )
    return replace(
        context,
        source=escape(context.source),
        maintainer=escape(context.maintainer),
        licence=escape(context.licence),
        parameters=parameters,
    )
