"""A ROS 1 package from a supervisor."""

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
from robosc.emit.config import DEFAULTS, Config
from robosc.emit.controller import ControllerContext, controller_context
from robosc.emit.literals import literal
from robosc.emit.naming import file_of
from robosc.emit.package import File, Package, frozen_files, own_test_files, runtime_files
from robosc.emit.readme import ParameterView, ReadmeContext, parameter_views, readme_context
from robosc.emit.rendering import render
from robosc.model.entities import Communication, Kind, Robot
from robosc.model.parameters import with_parameters
from robosc.names import rostest_name
from robosc.runtime.settings import GENERAL_RATE
from robosc.supervisor import Supervisor

__all__ = ["WIRING", "emit", "package_context", "spelling"]

WIRING = (
    "ros1/ros.py",
    "ros1/ros_calls.py",
    "ros1/ros_connections.py",
    "common/ros_headers.py",
    "ros1/ros_messages.py",
    "ros1/ros_watch.py",
)
"""What is the same in every package."""
ALWAYS_NEEDED = ("diagnostic_msgs", "rosgraph_msgs", "rospy", "std_msgs")


def emit(supervisor: Supervisor, package: str, config: Config = DEFAULTS) -> Package:
    """The package, ready to be written and built with catkin.

    ``package`` is a legal package name; the node has the same.

    Raises:
        UsageError: parameters of the configuration do not fit the robot.
    """
    robot = supervisor.plant.robot
    source = file_of(robot.span)
    configured = with_parameters(robot, config.parameters)
    controller = controller_context(supervisor, source)
    context = package_context(robot, package, source, controller, config.checked(robot))
    module = f"src/{package}"
    files = {
        "package.xml": File(render("ros1/package.xml.jinja", escaped(context))),
        "CMakeLists.txt": File(render("ros1/CMakeLists.txt.jinja", context)),
        "setup.py": File(render("ros1/setup.py.jinja", context)),
        f"scripts/{package}": File(render("ros1/script.jinja", context), executable=True),
        f"launch/{package}.launch": File(render("ros1/launch.jinja", escaped(context))),
        f"config/{package}.yaml": File(render("ros1/config.yaml.jinja", context)),
        f"{module}/__init__.py": File(data_module(source, f"Controller of {robot.name}.")),
        f"{module}/controller.py": File(render("common/controller.py.jinja", controller)),
        f"{module}/node.py": File(render("ros1/node.py.jinja", context)),
        **copies(module, WIRING),
        f"{module}/model.py": File(model_module(supervisor, source)),
        f"test/{rostest_name(package)}.test": File(render("ros1/rostest.jinja", escaped(context))),
        "test/play_robot.py": File(render("ros1/play_robot.py.jinja", context), executable=True),
        "test/plant_data.py": File(plant_module(configured, source, supervisor.guards)),
        "README.md": File(_readme(supervisor, context)),
    }
    files |= own_test_files(files)
    files |= runtime_files(f"{module}/_runtime", files)
    return Package(package, frozen_files(files), "ros1")


def _readme(supervisor: Supervisor, context: PackageContext) -> str:
    readme: ReadmeContext = readme_context(
        supervisor, context.package, context.source, context.parameters, spelling
    )
    return render("ros1/README.md.jinja", readme)


def package_context(
    robot: Robot, package: str, source: str, controller: ControllerContext, config: Config
) -> PackageContext:
    communications = robot.communications.values()
    actions = [c for c in communications if c.kind is Kind.ACTION]
    needed = {c.binding.package for c in communications} | set(ALWAYS_NEEDED)
    needed |= {"actionlib", "actionlib_msgs"}  # ros_calls.py imports them always
    parameters = _parameters(robot, config)
    timeouts = {
        f"timeout/{robot.display_names[c.key]}"
        for c in communications
        if c.kind is Kind.OUTGOING and c.timeout is not None
    }
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
        dependencies=tuple(sorted(needed)),
        modules=tuple(sorted({_module(c) for c in communications})),
        subscriptions=topics((c for c in communications if c.kind is Kind.OUTGOING), _name, _type),
        publications=topics((c for c in communications if c.kind is Kind.INCOMING), _name, _type),
        services=tuple(
            TopicView(c.identifier, f"{_module(c)}.{c.binding.type}", key=c.key)
            for c in communications
            if c.kind is Kind.SERVICE
        ),
        actions=tuple(
            TopicView(c.identifier, f"{_module(c)}.{c.binding.type}Action", key=c.key)
            for c in actions
        ),
        parameters=parameters,
        watched=tuple(p.argument for p in parameters if p.name in timeouts),
        defaults=literal({n: v for n, v in config.parameters.items() if not n.startswith("qos/")}),
    )


def _parameters(robot: Robot, config: Config) -> tuple[ParameterView, ...]:
    """All parameters; ``rate`` is in the group with the rates of commands, if there are such."""
    views = tuple(map(_as_xml_rpc_can, parameter_views(robot, config)))
    if not any(p.name.startswith("rate/") for p in views):
        return views
    return tuple(replace(p, name=GENERAL_RATE) if p.name == "rate" else p for p in views)


def _as_xml_rpc_can(view: ParameterView) -> ParameterView:
    """The parameter with its default as the parameter server can carry it: integers of 32 bits."""
    if view.type not in ("integer", "number") or not view.default.lstrip("-").isdigit():
        return view
    if -(2**31) <= int(view.default) < 2**31:
        return view
    wide = f'"{view.default}"' if view.type == "integer" else f"{view.default}.0"
    return replace(view, default=wide)


def _module(communication: Communication) -> str:
    kind = "srv" if communication.kind is Kind.SERVICE else "msg"
    return f"{communication.binding.package}.{kind}"


def _name(communication: Communication) -> str:
    return communication.identifier


def _type(communication: Communication) -> str:
    return f"{_module(communication)}.{communication.binding.type}"


def spelling(communication: Communication) -> tuple[str, str]:
    binding = communication.binding
    suffix = "Action" if communication.kind is Kind.ACTION else ""
    return communication.identifier, f"{binding.package}/{binding.type}{suffix}"
