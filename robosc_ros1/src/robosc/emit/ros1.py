"""A ROS 1 package from a supervisor."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pprint import pformat
from xml.sax.saxutils import escape

from robosc.emit.context import (
    ParameterView,
    ReadmeContext,
    parameter_views,
    readme_context,
)
from robosc.emit.controller import ControllerContext, controller_context
from robosc.emit.engine import render, verbatim
from robosc.emit.modeldata import model_document, plant_data
from robosc.emit.naming import file_of
from robosc.emit.package import File, Package, frozen_files, runtime_files
from robosc.model.entities import Communication, Kind, Robot
from robosc.supervisor import Supervisor

__all__ = ["emit"]

MAINTAINER = ("robosc", "robosc@robosc.dev")
ALWAYS_NEEDED = ("diagnostic_msgs", "rosgraph_msgs", "rospy", "std_msgs")


@dataclass(frozen=True)
class TopicView:
    """A topic, service or action; ``type`` as Python source, ``keys`` a tuple of communications."""

    name: str
    type: str
    keys: tuple[str, ...] = ()
    key: str = ""


@dataclass(frozen=True)
class PackageContext:
    """What all templates of ``ros1/`` see."""

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


def emit(supervisor: Supervisor, package: str) -> Package:
    """The package, ready to be written and built with catkin.

    ``package`` is a legal package name; the node has the same.
    """
    robot = supervisor.plant.robot
    source = file_of(robot.span)
    controller = controller_context(supervisor, source)
    context = _context(robot, package, source, controller)
    module = f"src/{package}"
    files = {
        "package.xml": File(render("ros1/package.xml.jinja", _escaped(context))),
        "CMakeLists.txt": File(render("ros1/CMakeLists.txt.jinja", context)),
        "setup.py": File(render("ros1/setup.py.jinja", context)),
        f"scripts/{package}": File(render("ros1/script.jinja", context), executable=True),
        f"launch/{package}.launch": File(render("ros1/launch.jinja", _escaped(context))),
        f"config/{package}.yaml": File(render("ros1/config.yaml.jinja", context)),
        f"{module}/__init__.py": File(_data_module(source, f"Controller of {robot.name}.", "")),
        f"{module}/controller.py": File(render("common/controller.py.jinja", controller)),
        f"{module}/node.py": File(render("ros1/node.py.jinja", context)),
        f"{module}/ros.py": File(verbatim("ros1/ros.py")),
        f"{module}/model.py": File(_model_module(supervisor, source)),
        f"test/{package}.test": File(render("ros1/rostest.jinja", _escaped(context))),
        "test/play_robot.py": File(render("ros1/play_robot.py.jinja", context), executable=True),
        "test/shadow.py": File(verbatim("common/shadow.py")),
        "test/plant_data.py": File(_plant_module(robot, source)),
        "README.md": File(_readme(supervisor, context)),
    }
    return Package(package, frozen_files({**files, **runtime_files(f"{module}/_runtime")}))


def _readme(supervisor: Supervisor, context: PackageContext) -> str:
    readme: ReadmeContext = readme_context(
        supervisor, context.package, context.source, context.parameters
    )
    return render("ros1/README.md.jinja", readme)


def _context(
    robot: Robot, package: str, source: str, controller: ControllerContext
) -> PackageContext:
    communications = robot.communications.values()
    actions = [c for c in communications if c.kind is Kind.ACTION]
    needed = {c.binding.package for c in communications} | set(ALWAYS_NEEDED)
    needed |= {"actionlib", "actionlib_msgs"}  # ros.py imports them always
    return PackageContext(
        package=package,
        node_name=package,
        robot=robot.name,
        source=source,
        version="0.1.0",
        maintainer=MAINTAINER[0],
        maintainer_email=MAINTAINER[1],
        licence="BSD-3-Clause",
        class_name=controller.class_name,
        dependencies=tuple(sorted(needed)),
        modules=tuple(sorted({_module(c) for c in communications})),
        subscriptions=_topics(c for c in communications if c.kind is Kind.OUTGOING),
        publications=_topics(c for c in communications if c.kind is Kind.INCOMING),
        services=tuple(
            TopicView(c.identifier, f"{_module(c)}.{c.binding.type}", key=c.key)
            for c in communications
            if c.kind is Kind.SERVICE
        ),
        actions=tuple(
            TopicView(c.identifier, f"{_module(c)}.{c.binding.type}Action", key=c.key)
            for c in actions
        ),
        parameters=parameter_views(robot),
    )


def _module(communication: Communication) -> str:
    kind = "srv" if communication.kind is Kind.SERVICE else "msg"
    return f"{communication.binding.package}.{kind}"


def _topics(communications: Iterable[Communication]) -> tuple[TopicView, ...]:
    """One entry per topic and type, whatever number of messages share it."""
    keys: dict[tuple[str, str], list[str]] = {}
    for communication in communications:
        type_ = f"{_module(communication)}.{communication.binding.type}"
        keys.setdefault((communication.identifier, type_), []).append(communication.key)
    return tuple(TopicView(name, type_, tuple(found)) for (name, type_), found in keys.items())


def _escaped(context: PackageContext) -> PackageContext:
    """The context with texts fit for XML."""
    parameters = tuple(replace(p, doc=escape(p.doc, {'"': "&quot;"})) for p in context.parameters)
    return replace(context, source=escape(context.source), parameters=parameters)


def _data_module(source: str, sentence: str, body: str) -> str:
    head = f"# This file was generated by robosc from {source}. Do not edit it: change the model.\n"
    return f'{head}"""{sentence}"""\n{body}'


def _model_module(supervisor: Supervisor, source: str) -> str:
    document = pformat(model_document(supervisor, source), width=98, sort_dicts=False)
    sentence = "The model as data, as it is published on ~model."
    return _data_module(source, sentence, f"\nMODEL = {document}\n")


def _plant_module(robot: Robot, source: str) -> str:
    data = pformat(plant_data(robot), width=98, sort_dicts=False)
    sentence = "The model as data, for the test that plays the robot."
    return _data_module(source, sentence, f"\nPLANT = {data}\n")
