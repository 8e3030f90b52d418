"""ROS 1 packages (catkin): a controller, or a node that guards or monitors somebody else's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from robosc.emit.package import readme, target
from robosc.emit.package.config import DEFAULTS, Config
from robosc.emit.package.package import Mode, Package
from robosc.model.entities import Communication, Robot
from robosc.runtime.core.settings import GENERAL_RATE
from robosc.supervisor import Supervisor


def emit(
    supervisor: Supervisor,
    package: str,
    config: Config = DEFAULTS,
    mode: Mode = "controller",
    runs: Mapping[str, str] = MappingProxyType({}),
) -> Package:
    """The package, ready to be built with catkin.

    See :func:`robosc.emit.package.target.package_of`.
    """
    return target.package_of(_ROS1, supervisor, package, config, mode, runs)


def _parameters(robot: Robot, config: Config) -> tuple[readme.ParameterView, ...]:
    """All parameters; ``rate`` is in the group with the rates of commands, if there are such."""
    views = tuple(map(_as_xml_rpc_can, readme.parameter_views(robot, config)))
    if not any(p.name.startswith("rate/") for p in views):
        return views
    return tuple(replace(p, name=GENERAL_RATE) if p.name == "rate" else p for p in views)


def _as_xml_rpc_can(view: readme.ParameterView) -> readme.ParameterView:
    """The parameter with its default as the parameter server can carry it: integers of 32 bits."""
    if view.type not in ("integer", "number") or not view.default.lstrip("-").isdigit():
        return view
    if -(2**31) <= int(view.default) < 2**31:
        return view
    wide = f'"{view.default}"' if view.type == "integer" else f"{view.default}.0"
    return replace(view, default=wide)


def _module(communication: Communication) -> str:
    kind = "srv" if communication.sort.folder == "srv" else "msg"
    return f"{communication.binding.package}.{kind}"


def _type(communication: Communication) -> str:
    return communication.binding.type + "Action" * (communication.sort.folder == "action")


_ROS1 = target.Target(
    name="ros1",
    modules="src/{package}",
    templates={
        "package.xml": "package.xml",
        "CMakeLists.txt": "CMakeLists.txt",
        "setup.py": "setup.py",
        "scripts/{package}": "script",
        "config/{package}.yaml": "config.yaml",
    },
    of_mode={
        "controller": {
            "launch/{package}.launch": "launch",
            "test/{rostest}.test": "rostest",
            "README.md": "README.md",
        },
        "supervisor": {
            "launch/{package}.launch": "supervisor.launch",
            "test/{rostest}.test": "rostest",
            "README.md": "supervisor_README.md",
        },
        "monitor": {
            "launch/{package}.launch": "launch",
            "test/{rostest}.test": "rostest",
            "README.md": "monitor_README.md",
        },
    },
    program="play_scripts",
    dependencies=(  # actions: ros_actions.py imports them always
        "actionlib", "actionlib_msgs", "diagnostic_msgs", "rosgraph_msgs", "rospy", "std_msgs",
    ),
    identifier=lambda communication: communication.identifier,
    module=_module,
    type=_type,
    interface=lambda communication: f"{communication.binding.package}/{_type(communication)}",
    parameters=_parameters,
    action_parts=("/goal", "/cancel", "/status", "/feedback", "/result"),
    shows_results=True,
    has_qos=False,
    has_lifecycle=False,
)  # fmt: skip
