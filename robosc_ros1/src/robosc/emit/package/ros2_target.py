"""ROS 2 packages (ament_python): a controller, or a node that guards or monitors one.

``controller.py``, ``model.py`` and ``_runtime/`` are those of the ROS 1 package, byte for byte;
what is different is the wiring, and what the build tools want to see.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from robosc.emit.package import readme, target
from robosc.emit.package.config import DEFAULTS, Config, declared_communications, shared_topics
from robosc.emit.package.package import Mode, Package
from robosc.errors import UsageError
from robosc.model.entities import Communication, Robot
from robosc.runtime.core.qos import qos_parameters
from robosc.supervisor import Supervisor


def emit(
    supervisor: Supervisor,
    package: str,
    config: Config = DEFAULTS,
    mode: Mode = "controller",
    runs: Mapping[str, str] = MappingProxyType({}),
) -> Package:
    """The package, ready to be built with colcon.

    See :func:`robosc.emit.package.target.package_of`.

    Raises:
        UsageError: a topic has two types, too.
    """
    _demand_one_type_per_topic(supervisor.plant.robot)
    return target.package_of(_ROS2, supervisor, package, config, mode, runs)


def _demand_one_type_per_topic(robot: Robot) -> None:
    """Raises UsageError for topics that a node could not have: the middleware would refuse to start
    it, and not say why."""
    topics: dict[str, Communication] = {}
    for communication in robot.communications.values():
        if communication.sort.folder != "msg":
            continue
        other = topics.setdefault(communication.ros_name, communication)
        if _interface(other) != _interface(communication):
            span, type_ = communication.span, _interface(communication)
            raise UsageError(
                f"{span.source.path}:{span.line}: the topic {_name(communication)} carries {type_}"
                f" here and {_interface(other)} in {other.span.told_from(span)}; a node of ROS 2"
                " cannot have both"
            )


def _module(communication: Communication) -> str:
    return f"{communication.binding.package}.{communication.sort.folder}"


def _interface(communication: Communication) -> str:
    return f"{_module(communication)}.{communication.binding.type}".replace(".", "/")


def _name(communication: Communication) -> str:
    """The identifier as ROS 2 spells it: a private name has a slash behind the tilde."""
    name = communication.identifier
    return f"~/{name[1:]}" if name.startswith("~") and not name.startswith("~/") else name


def _parameters(robot: Robot, config: Config) -> tuple[readme.ParameterView, ...]:
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
    views = readme.parameter_views(robot, config, more)
    return tuple(
        replace(p, name=p.name.replace("/", "."), in_file=p.in_file and _in_file(p)) for p in views
    )


def _in_file(view: readme.ParameterView) -> bool:
    """Whether a parameter file of ROS 2 can say it: an array neither of objects nor empty."""
    return view.type != "array" or view.default[1:2] not in ("{", "[", "]")


_ROS2 = target.Target(
    name="ros2",
    modules="{package}",
    templates={
        "package.xml": "package.xml",
        "setup.py": "setup.py",
        "setup.cfg": "setup.cfg",
        "resource/{package}": "marker",
        "config/{package}.yaml": "config.yaml",
    },
    of_mode={
        "controller": {
            "launch/{package}.launch.py": "launch.py",
            "README.md": "README.md",
        },
        "supervisor": {
            "launch/{package}.launch.py": "supervisor.launch.py",
            "README.md": "supervisor_README.md",
        },
        "monitor": {
            "launch/{package}.launch.py": "monitor.launch.py",
            "README.md": "monitor_README.md",
        },
    },
    program="test_play_scripts",
    dependencies=(
        "action_msgs", "ament_index_python", "diagnostic_msgs", "launch", "launch_ros",
        "python3-yaml", "rcl_interfaces", "rclpy", "std_msgs",
    ),
    identifier=_name,
    module=_module,
    type=lambda communication: communication.binding.type,
    interface=_interface,
    parameters=_parameters,
    action_parts=tuple(
        f"/_action/{part}"
        for part in ("send_goal", "cancel_goal", "get_result", "feedback", "status")
    ),
    shows_results=False,
    has_qos=True,
    has_lifecycle=True,
)  # fmt: skip
