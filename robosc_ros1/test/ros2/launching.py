"""What a ROS 2 launch file would start, found without the packages launch and launch_ros.

Of those there are no wheels. The classes here take what theirs take (Jazzy) and nothing else, and a
node becomes the command line that launch_ros makes of it, with files of parameters by PyYAML.
"""

from __future__ import annotations

import json
import runpy
import sys
import types
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest.mock import patch

__all__ = [
    "AnyLaunchDescriptionSource", "GroupAction", "IncludeLaunchDescription", "Node",
    "PushRosNamespace", "SetRemap", "given_to", "started",
]  # fmt: skip


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: str | None = field(default=None, kw_only=True)
    description: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        assert all(isinstance(t, str) for t in (self.name, self.default_value, self.description))


@dataclass
class LaunchConfiguration:
    name: str
    default: str = field(kw_only=True)

    def perform(self, context: dict[str, str]) -> str:
        return context.get(self.name, self.default)


@dataclass(kw_only=True)
class OpaqueFunction:
    function: Callable[[dict[str, str]], list[Node] | None]


@dataclass
class AnyLaunchDescriptionSource:
    location: str


@dataclass
class IncludeLaunchDescription:
    source: AnyLaunchDescriptionSource


@dataclass
class GroupAction:
    actions: Sequence[Any]


@dataclass
class PushRosNamespace:
    namespace: str


@dataclass(kw_only=True)
class SetRemap:
    src: str
    dst: str


@dataclass(kw_only=True)
class Node:
    executable: str
    package: str
    name: str | None = None
    namespace: str | None = None
    parameters: Sequence[str | dict[str, Any]] = ()
    remappings: Sequence[tuple[str, str]] = ()
    arguments: Sequence[str] = ()
    output: str = "log"
    respawn: bool = False

    def command(self, prefix: Path, folder: Path) -> list[str]:
        """The process's words, for a package that is installed under ``prefix``."""
        program = prefix / self.package / "lib" / self.package / self.executable
        words = [str(program), *self.arguments, "--ros-args"]
        if self.name is not None:
            words += ["-r", f"__node:={self.name}"]
        if self.namespace:
            words += ["-r", f"__ns:={self.namespace}"]
        for number, given in enumerate(self.parameters):
            file = given
            if isinstance(given, dict):
                import yaml  # some Pythons that this is tested with have none

                file = str(folder / f"{self.name}-{number}.yaml")
                content = yaml.dump({"/**": {"ros__parameters": given}})
                Path(file).write_text(content, encoding="utf-8")
            words += ["--params-file", str(file)]
        for name, other in self.remappings:
            words += ["-r", f"{name}:={other}"]
        return words


def given_to(node: Node, name: str) -> dict[str, Any]:
    """The parameters that a node is given beside its parameter file, under its full ``name``."""
    if len(node.parameters) == 1:
        return {}
    _, file = node.parameters
    (section, content), *others = json.loads(Path(str(file)).read_text(encoding="utf-8")).items()
    assert (section, others) == (name, [])
    (given,) = content.values()
    return dict(given)


def modules_folder(file: Path) -> Path:
    """The folder with the Python package of a launch file, in its sources or where it is installed."""
    sources = file.parents[1]
    if (sources / file.name.removesuffix(".launch.py")).is_dir():
        return sources
    (folder,) = file.parents[3].glob("lib/python3*/site-packages")
    return folder


def started(file: Path, share: Callable[[str], str], **arguments: str) -> list[Any]:
    """What a launch file starts with these arguments, in their order: nodes, groups."""
    parts: dict[str, dict[str, Any]] = {
        "ament_index_python.packages": {"get_package_share_directory": share},
        "launch": {"LaunchDescription": list},
        "launch.actions": {
            "DeclareLaunchArgument": DeclareLaunchArgument,
            "GroupAction": GroupAction,
            "IncludeLaunchDescription": IncludeLaunchDescription,
            "OpaqueFunction": OpaqueFunction,
        },
        "launch.launch_description_sources": {
            "AnyLaunchDescriptionSource": AnyLaunchDescriptionSource
        },
        "launch.substitutions": {"LaunchConfiguration": LaunchConfiguration},
        "launch_ros.actions": {
            "Node": Node,
            "PushRosNamespace": PushRosNamespace,
            "SetRemap": SetRemap,
        },
    }
    modules = {name: types.ModuleType(name) for name in parts}
    for name, content in parts.items():
        modules[name].__dict__.update(content)
    path = [str(modules_folder(file)), *sys.path]
    with patch.dict(sys.modules, modules), patch.object(sys, "path", path):
        description = runpy.run_path(str(file))["generate_launch_description"]()
        values: dict[str, str] = {}
        actions: list[Any] = []
        for action in description:
            if isinstance(action, DeclareLaunchArgument):
                assert action.name not in values, f"{action.name} is declared twice"
                assert action.default_value is not None
                values[action.name] = arguments.get(action.name, action.default_value)
        assert set(arguments) <= set(values)
        for action in description:
            if isinstance(action, OpaqueFunction):
                actions += action.function(values) or []
    return actions
