"""A ROS 2 package (ament_python) from a supervisor.

``controller.py``, ``model.py`` and ``_runtime/`` are those of the ROS 1 package, byte for byte;
what is different is the wiring, and what the build tools want to see.
"""

from __future__ import annotations

from dataclasses import replace

from robosc.emit.common import (
    PackageContext,
    TopicView,
    copies,
    data_module,
    escaped,
    model_module,
    plant_module,
    topics,
)
from robosc.emit.config import DEFAULTS, Config, declared_communications, shared_topics
from robosc.emit.controller import ControllerContext, controller_context
from robosc.emit.literals import literal
from robosc.emit.naming import file_of
from robosc.emit.package import File, Package, frozen_files, own_test_files, runtime_files
from robosc.emit.readme import ParameterView, parameter_views, readme_context
from robosc.emit.rendering import render, verbatim
from robosc.errors import UsageError
from robosc.model.entities import Communication, Kind, Robot
from robosc.model.parameters import with_parameters
from robosc.runtime.qos import qos_parameters
from robosc.supervisor import Supervisor

__all__ = ["WIRING", "emit", "package_context", "spelling"]

ALWAYS_NEEDED = (
    "action_msgs", "ament_index_python", "diagnostic_msgs", "launch", "launch_ros",
    "python3-yaml", "rcl_interfaces", "rclpy", "std_msgs",
)  # fmt: skip

WIRING = (
    "ros2/ros.py",
    "ros2/ros_calls.py",
    "ros2/ros_executor.py",
    "common/ros_headers.py",
    "ros2/ros_messages.py",
    "ros2/ros_parameters.py",
    "ros2/ros_watch.py",
)
"""What is the same in every package."""

_FOLDERS = {Kind.SERVICE: "srv", Kind.ACTION: "action"}


def emit(supervisor: Supervisor, package: str, config: Config = DEFAULTS) -> Package:
    """The package, ready to be written and built with colcon.

    ``package`` is a legal package name; the node has the same.

    Raises:
        UsageError: parameters of the configuration do not fit the robot, or a topic has two types.
    """
    robot = supervisor.plant.robot
    source = file_of(robot.span)
    configured = with_parameters(robot, config.parameters)
    controller = controller_context(supervisor, source)
    context = package_context(robot, package, source, controller, config.checked(robot))
    templates = {
        "setup.py": "setup.py",
        "setup.cfg": "setup.cfg",
        f"resource/{package}": "marker",
        f"launch/{package}.launch.py": "launch.py",
        f"config/{package}.yaml": "config.yaml",
        f"{package}/node.py": "node.py",
        "test/test_play_robot.py": "test_play_robot.py",
    }
    readme = readme_context(supervisor, package, source, context.parameters, spelling)
    files = {
        **{path: File(render(f"ros2/{name}.jinja", context)) for path, name in templates.items()},
        "package.xml": File(render("ros2/package.xml.jinja", escaped(context))),
        f"{package}/__init__.py": File(data_module(source, f"Controller of {robot.name}.")),
        f"{package}/controller.py": File(render("common/controller.py.jinja", controller)),
        f"{package}/model.py": File(model_module(supervisor, source)),
        "README.md": File(render("ros2/README.md.jinja", readme)),
        "test/plant_data.py": File(plant_module(configured, source, supervisor.guards)),
        **copies(package, WIRING),
    }
    if context.lifecycle:
        files[f"{package}/ros_lifecycle.py"] = File(verbatim("ros2/ros_lifecycle.py"))
    files |= own_test_files(files)
    files |= runtime_files(f"{package}/_runtime", files)
    return Package(package, frozen_files(files), "ros2")


def package_context(
    robot: Robot, package: str, source: str, controller: ControllerContext, config: Config
) -> PackageContext:
    communications = robot.communications.values()
    _demand_one_type_per_topic(robot)

    def messages(kind: Kind) -> tuple[TopicView, ...]:
        return topics((c for c in communications if c.kind is kind), _name, _type)

    def servers(kind: Kind) -> tuple[TopicView, ...]:
        return tuple(
            TopicView(_name(c), _type(c), key=c.key) for c in communications if c.kind is kind
        )

    return PackageContext(
        package=package,
        node_name=package,
        robot=robot.name,
        source=source,
        version=config.version,
        maintainer=config.maintainer,
        maintainer_email=config.email,
        licence=config.licence,
        class_name=controller.class_name,
        dependencies=tuple(sorted({c.binding.package for c in communications} | {*ALWAYS_NEEDED})),
        modules=tuple(sorted({_module(c) for c in communications})),
        subscriptions=messages(Kind.OUTGOING),
        publications=messages(Kind.INCOMING),
        services=servers(Kind.SERVICE),
        actions=servers(Kind.ACTION),
        parameters=_parameters(robot, config),
        defaults=literal(dict(config.parameters)),
        lifecycle=config.lifecycle,
    )


def _demand_one_type_per_topic(robot: Robot) -> None:
    """Raises UsageError for topics that a node could not have: the middleware would refuse to start
    it, and not say why."""
    topics: dict[str, Communication] = {}
    for communication in robot.communications.values():
        if communication.kind in _FOLDERS:
            continue
        other = topics.setdefault(communication.identifier, communication)
        if _type(other) != _type(communication):
            span, (name, type_) = communication.span, spelling(communication)
            raise UsageError(
                f"{span.source.path}:{span.line}: the topic {name} carries {type_} here and"
                f" {spelling(other)[1]} in line {other.span.line}; a node of ROS 2 cannot have both"
            )


def _module(communication: Communication) -> str:
    return f"{communication.binding.package}.{_FOLDERS.get(communication.kind, 'msg')}"


def _type(communication: Communication) -> str:
    return f"{_module(communication)}.{communication.binding.type}"


def _name(communication: Communication) -> str:
    """The identifier as ROS 2 spells it: a private name has a slash behind the tilde."""
    name = communication.identifier
    return f"~/{name[1:]}" if name.startswith("~") and not name.startswith("~/") else name


def spelling(communication: Communication) -> tuple[str, str]:
    return _name(communication), _type(communication).replace(".", "/")


def _parameters(robot: Robot, config: Config) -> tuple[ParameterView, ...]:
    """Those of ROS 1 with dots for slashes, and the quality of service of each topic.

    The quality goes by the first message on the topic; that of others may be left out, for it is
    the same.
    """
    others = {keys[0]: keys[1:] for _, keys in shared_topics(robot)}
    more = []
    for message in declared_communications(robot):
        also = "".join(f", {robot.display_names[key]}" for key in others.get(message.key, ()))
        for parameter in qos_parameters([message]) if message.key in others else ():
            more.append(parameter._replace(meaning=parameter.meaning + also))
    views = parameter_views(robot, config, more)
    return tuple(replace(p, name=p.name.replace("/", ".")) for p in views)
