"""No attribute of a class in generated packages has the name of one of its methods, and what an
engine calls has all that it calls: no package carries the interfaces.

Nobody checks the types of templates. ``self.x = …`` in a class that inherits a method ``x``, from
whatever file, hides the method: its callers call the value.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
from ros_support import SOURCES

from robosc.runtime.core import interfaces
from robosc.runtime.judge import ports

TEMPLATES = SOURCES.parent / "templates"
RUNTIME = SOURCES / "robosc" / "runtime"
TARGETS = ("ros1", "ros2")


@dataclass(frozen=True)
class Place:
    """A class of a package for one version of ROS."""

    target: str
    file: Path
    name: str


@cache
def tree(file: Path) -> ast.Module:
    return ast.parse(file.read_bytes())


@cache
def classes(file: Path) -> dict[str, ast.ClassDef]:
    return {node.name: node for node in tree(file).body if isinstance(node, ast.ClassDef)}


def files(target: str) -> Iterator[Path]:
    for folder in (TEMPLATES / "common", TEMPLATES / target, RUNTIME):
        yield from sorted(folder.rglob("*.py"))


def imported(module: str, level: int, place: Place) -> Path | None:
    """The file of a module that a file imports; None if it is no part of the package."""
    if RUNTIME in place.file.parents or module.startswith("_runtime."):
        folders = [*RUNTIME.glob("*/")]
    else:
        common = TEMPLATES / "common" / ("node" if level else "test")
        folders = [common, TEMPLATES / place.target]
    candidates = [folder / f"{module.rpartition('.')[2]}.py" for folder in folders]
    return next((file for file in candidates if file.exists()), None)


def base(name: str, place: Place) -> Place | None:
    """The class of the package that a name stands for in a file."""
    if name in classes(place.file):
        return Place(place.target, place.file, name)
    for node in tree(place.file).body:
        if isinstance(node, ast.ImportFrom):
            original = {alias.asname or alias.name: alias.name for alias in node.names}.get(name)
            if original is not None:
                file = imported(node.module or "", node.level, place)
                return None if file is None else Place(place.target, file, original)
    return None


def with_bases(place: Place) -> Iterator[Place]:
    yield place
    for node in classes(place.file)[place.name].bases:
        if isinstance(node, ast.Name) and (parent := base(node.id, place)) is not None:
            yield from with_bases(parent)


def methods(place: Place) -> set[str]:
    body = classes(place.file)[place.name].body
    return {node.name for node in body if isinstance(node, ast.FunctionDef)}


def attributes(place: Place) -> set[str]:
    """What methods assign to ``self``."""
    return {
        node.attr
        for node in ast.walk(classes(place.file)[place.name])
        if isinstance(node, ast.Attribute)
        and isinstance(node.ctx, ast.Store)
        and isinstance(node.value, ast.Name)
        and node.value.id == "self"
    }


def hidden(place: Place) -> set[str]:
    family = list(with_bases(place))
    return set().union(*map(methods, family)) & set().union(*map(attributes, family))


def places(target: str) -> list[Place]:
    return [Place(target, file, name) for file in files(target) for name in classes(file)]


@pytest.mark.parametrize("target", TARGETS)
def test_no_attribute_hides_a_method(target):
    assert {place: names for place in places(target) if (names := hidden(place))} == {}


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize(
    ("file", "name", "interface"),
    [
        ("ros.py", "RosPort", interfaces.Port),
        ("monitor.py", "MonitorPort", ports.MonitorPort),
        ("relay.py", "RelayPort", ports.SupervisorPort),
        ("ros.py", "RosOutlet", interfaces.Outlet),
    ],
)
def test_nodes_have_all_that_their_engines_call(
    target: str, file: str, name: str, interface: type
) -> None:
    family = list(with_bases(Place(target, TEMPLATES / target / file, name)))
    found = set().union(*map(methods, family), *map(attributes, family))
    called = {each for each in dir(interface) if not each.startswith("_")}
    assert called <= found, called - found


@pytest.mark.parametrize("target", TARGETS)
def test_classes_are_read_with_those_that_they_extend(target):
    """Through several files, and into the runtime."""
    robot = Place(target, TEMPLATES / "common" / "test" / "guarded_player.py", "GuardedRobot")
    family = ["GuardedRobot", "Robot", "PlayedRobot"]
    assert [place.name for place in with_bases(robot)] == family
    relay = Place(target, TEMPLATES / target / "relay.py", "RelayPort")
    assert RUNTIME / "judge" in {place.file.parent for place in with_bases(relay)}


def test_an_attribute_of_a_subclass_is_seen(tmp_path):
    file = tmp_path / "robots.py"
    file.write_text(
        "class Robot:\n"
        "    def answer(self): ...\n"
        "class Simulated(Robot):\n"
        "    def __init__(self): self.sent, self.answer = 0, None\n"
    )
    assert hidden(Place("ros1", file, "Simulated")) == {"answer"}
    assert hidden(Place("ros1", file, "Robot")) == set()
