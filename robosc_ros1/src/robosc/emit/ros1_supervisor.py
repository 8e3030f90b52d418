"""A ROS 1 package whose node guards a controller that somebody else wrote."""

from __future__ import annotations

from robosc.emit.common import copies, data_module, escaped, model_module, plant_module
from robosc.emit.config import DEFAULTS, Config
from robosc.emit.controller import controller_context
from robosc.emit.naming import file_of
from robosc.emit.package import File, Package, frozen_files, own_test_files, runtime_files
from robosc.emit.readme import readme_context
from robosc.emit.relaying import relay_context
from robosc.emit.rendering import render
from robosc.emit.ros1 import WIRING, package_context, spelling
from robosc.model.parameters import with_parameters
from robosc.names import rostest_name
from robosc.supervisor import Supervisor

__all__ = ["emit"]

_ACTION_PARTS = ("/goal", "/cancel", "/status", "/feedback", "/result")


def emit(supervisor: Supervisor, package: str, config: Config = DEFAULTS) -> Package:
    """The package, ready to be written and built with catkin.

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
    module = f"src/{package}"
    files = {
        "package.xml": render("ros1/package.xml.jinja", escaped(context)),
        "CMakeLists.txt": render("ros1/CMakeLists.txt.jinja", context),
        "setup.py": render("ros1/setup.py.jinja", context),
        f"launch/{package}.launch": render("ros1/supervisor.launch.jinja", escaped(context)),
        f"config/{package}.yaml": render("ros1/config.yaml.jinja", context),
        f"{module}/__init__.py": data_module(source, f"Supervisor of {robot.name}."),
        f"{module}/controller.py": render("common/controller.py.jinja", controller),
        f"{module}/model.py": model_module(supervisor, source),
        f"{module}/node.py": render("ros1/supervisor_node.py.jinja", context),
        f"test/{rostest_name(package)}.test": render(
            "ros1/supervisor_rostest.jinja", escaped(context)
        ),
        "test/plant_data.py": plant_module(configured, source, supervisor.guards),
        "README.md": render("ros1/supervisor_README.md.jinja", readme),
    }
    programs = {
        f"scripts/{package}": "ros1/script.jinja",
        "test/play_robot.py": "ros1/play_robot.py.jinja",
        "test/play_both.py": "ros1/play_both.py.jinja",
    }
    texts = {path: File(text) for path, text in files.items()}
    texts |= copies(module, (*WIRING, "ros1/relay.py"))
    texts |= {p: File(render(t, context), executable=True) for p, t in programs.items()}
    texts |= own_test_files(texts)
    texts |= runtime_files(f"{module}/_runtime", texts)
    return Package(package, frozen_files(texts), "ros1")
