"""A ROS 2 package (ament_python) whose node guards a controller that somebody else wrote."""

from __future__ import annotations

from robosc.emit.common import copies, data_module, escaped, model_module, plant_module
from robosc.emit.config import DEFAULTS, Config
from robosc.emit.controller import controller_context
from robosc.emit.naming import file_of
from robosc.emit.package import File, Package, frozen_files, own_test_files, runtime_files
from robosc.emit.readme import readme_context
from robosc.emit.relaying import relay_context
from robosc.emit.rendering import render, verbatim
from robosc.emit.ros2 import WIRING, package_context, spelling
from robosc.model.parameters import with_parameters
from robosc.supervisor import Supervisor

__all__ = ["emit"]

_ACTION_PARTS = tuple(
    f"/_action/{part}" for part in ("send_goal", "cancel_goal", "get_result", "feedback", "status")
)


def emit(supervisor: Supervisor, package: str, config: Config = DEFAULTS) -> Package:
    """The package, ready to be written and built with colcon.

    Raises:
        ModelError: a supervisor cannot do what it must with the topics of the model.
        UsageError: the configuration does not fit.
    """
    robot = supervisor.plant.robot
    source = file_of(robot.span)
    configured = with_parameters(robot, config.parameters)
    controller = controller_context(supervisor, source)
    base = package_context(robot, package, source, controller, config.checked(robot))
    context = relay_context(base, supervisor, config, _ACTION_PARTS)
    readme = readme_context(supervisor, package, source, context.parameters, spelling)
    files = {
        "package.xml": render("ros2/package.xml.jinja", escaped(context)),
        "setup.py": render("ros2/setup.py.jinja", context),
        "setup.cfg": render("ros2/setup.cfg.jinja", context),
        f"resource/{package}": render("ros2/marker.jinja", context),
        f"launch/{package}.launch.py": render("ros2/supervisor.launch.py.jinja", context),
        f"config/{package}.yaml": render("ros2/config.yaml.jinja", context),
        f"{package}/__init__.py": data_module(source, f"Supervisor of {robot.name}."),
        f"{package}/controller.py": render("common/controller.py.jinja", controller),
        f"{package}/model.py": model_module(supervisor, source),
        f"{package}/node.py": render("ros2/supervisor_node.py.jinja", context),
        "test/test_play_both.py": render("ros2/test_play_both.py.jinja", context),
        # A module for that one, no test of its own here.
        "test/play_robot.py": render("ros2/test_play_robot.py.jinja", context),
        "test/action_client.py": verbatim("ros2/action_client.py"),
        "test/plant_data.py": plant_module(configured, source, supervisor.guards),
        "README.md": render("ros2/supervisor_README.md.jinja", readme),
    }
    texts = {path: File(text) for path, text in files.items()}
    texts |= copies(package, (*WIRING, "ros2/relay.py"))
    if context.lifecycle:
        texts[f"{package}/ros_lifecycle.py"] = File(verbatim("ros2/ros_lifecycle.py"))
    texts |= own_test_files(texts)
    texts |= runtime_files(f"{package}/_runtime", texts)
    return Package(package, frozen_files(texts), "ros2")
