"""Definitions of messages, services and actions of ROS packages, read without building them.

Definitions are read from ``.msg``, ``.srv`` and ``.action`` files, in source workspaces as well as
installed packages, by :mod:`robosc.model.ros.genmsg_text` for ROS 1 and
:mod:`robosc.model.ros.rosidl` for ROS 2, which need nothing of ROS. Where these files are not
installed, generated Python bindings are used. :mod:`robosc.model.ros.packages` lists where packages
are searched for.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from robosc.model.ros import genmsg_text, rosidl
from robosc.model.ros.interfaces import PARTS, Definition, FieldType, Folder, Interface, Missing
from robosc.model.ros.packages import Packages, is_ros2_package, is_share

# Definitions from the Python bindings that genpy generates. Some Debian packages install
# bindings without definition files (those of actionlib's actions are an example). The
# bindings have all fields and types, but not the constants. They are read as text: nothing is
# imported.


def read(bindings: Path, package: str, type_: str, folder: Folder) -> tuple[Definition, ...] | None:
    """The parts of a message, service or action; None if it is not there or not readable."""
    # TAction's bindings exist beside TGoal's; an action T is only what has both.
    if folder == "action" and not (bindings / "msg" / f"_{type_}Action.py").is_file():
        return None
    found = []
    for part in PARTS[folder]:
        # The bindings of a service are in one file, those of an action's parts in one each.
        file = f"srv/_{type_}.py" if folder == "srv" else f"msg/_{type_}{part}.py"
        fields = _fields(bindings / file, f"{type_}{part}")
        if fields is None:
            return None
        found.append(Definition.of(f"{package}/{type_}{part}", fields))
    return tuple(found)


def generated_names(package: Path, folder: str) -> Iterator[str]:
    """The messages, services or actions that a package has bindings for."""
    where = package / ("srv" if folder == "srv" else "msg")
    for file in sorted(where.glob("_[A-Za-z]*.py")):
        name = file.stem[1:]
        if folder != "action":
            yield name
        elif name.endswith("ActionGoal"):
            yield name.removesuffix("ActionGoal")


def _fields(file: Path, name: str) -> list[tuple[str, str]] | None:
    """Name and type of each field of a class."""
    try:
        module = ast.parse(file.read_bytes())
        (found,) = (n for n in module.body if isinstance(n, ast.ClassDef) and n.name == name)
        values = {
            ast.unparse(statement.targets[0]): statement.value
            for statement in found.body
            if isinstance(statement, ast.Assign)
        }
        slots, types = (ast.literal_eval(values[key]) for key in ("__slots__", "_slot_types"))
        return list(zip(slots, types, strict=True))
    except (OSError, SyntaxError, ValueError, KeyError):
        return None


def _std(name: str, base: str | None) -> Interface:
    fields = () if base is None else (("data", base),)
    return Interface("std_msgs", name, (Definition.of(f"std_msgs/{name}", fields),))


BASIC: Mapping[str, Interface] = {
    "none": _std("Empty", None),
    "boolean": _std("Bool", "bool"),
    "integer": _std("Int16", "int16"),
    "double": _std("Float32", "float32"),
    "string": _std("String", "string"),
}
"""The default message for each basic type (docs/language.md, "ROS interfaces").

Built in, so that models can be checked without ROS.
"""


TIMES = {
    "1": {
        "time": Definition.of("time", [("secs", "uint32"), ("nsecs", "uint32")]),
        "duration": Definition.of("duration", [("secs", "int32"), ("nsecs", "int32")]),
    },
    "2": {
        of: Definition.of(f"builtin_interfaces/{name}", [("sec", "int32"), ("nanosec", "uint32")])
        for of, name in (("time", "Time"), ("duration", "Duration"))
    },
}
"""The definitions of points in time and durations in both versions of ROS."""

_IN_ROS_1 = {"builtin_interfaces/Time": "time", "builtin_interfaces/Duration": "duration"}

_IN_DEBIAN = frozenset({
    "actionlib_msgs", "diagnostic_msgs", "geometry_msgs", "map_msgs", "move_base_msgs", "nav_msgs",
    "pcl_msgs", "rosgraph_msgs", "sensor_msgs", "shape_msgs", "std_msgs", "std_srvs", "stereo_msgs",
    "tf2_msgs", "trajectory_msgs", "visualization_msgs",
})  # fmt: skip


def install_advice(package: str) -> str:
    """The hint for a missing package: its rosdep key and, if known, its Debian packages."""
    if package == "actionlib":
        return "install it: apt install python3-actionlib libactionlib-dev (rosdep key actionlib)"
    if package in _IN_DEBIAN:
        name = package.replace("_", "-")
        return (
            f"install it: apt install ros-{name} python3-{name} (rosdep key {package}),"
            " or put its sources into the workspace"
        )
    return f"put it into the workspace or on ROS_PACKAGE_PATH (rosdep resolve {package})"


class MessageDefinitions:
    """Finds and reads definitions in ``packages``; each file is read at most once.

    ``MessageDefinitions()`` finds none; use ``for_model``. ``ros_version`` (``"1"`` or ``"2"``) is
    the version of ROS for which code is generated: times and headers have the fields of that
    version, whichever version the package is written for. If it is None, definitions are taken as
    they are, and packages for both versions as those of the version that is sourced.
    """

    def __init__(self, packages: Packages | None = None, ros_version: str | None = None) -> None:
        self.packages = Packages() if packages is None else packages
        self._ros_version = ros_version
        self._manifests = ros_version or self.packages.sourced
        self._interfaces: dict[tuple[str, str, str], Interface | Missing] = {}

    @classmethod
    def for_model(
        cls,
        path: Path,
        environment: Mapping[str, str] | None = None,
        ros_version: str | None = None,
    ) -> MessageDefinitions:
        """The definitions that a model file may use, see :mod:`robosc.model.ros.packages`."""
        return cls(Packages.for_model(path, environment), ros_version)

    @property
    def are_for_ros2(self) -> bool:
        """Whether code is generated for ROS 2, or, if that is not known, ROS 2 is sourced."""
        return self._manifests == "2"

    def interface(self, package: str, type_: str, folder: Folder) -> Interface | Missing:
        """The definition of ``package/folder/type_``.

        Its parts are the message; request and response of a service; or goal, result and feedback
        of an action, of which the type ``TAction`` also finds ``T.action``.
        """
        definition = self._interface(package, type_, folder)
        stem = type_.removesuffix("Action")
        if folder == "action" and stem not in ("", type_) and _has_no_file(definition):
            shorter = self._interface(package, stem, folder)
            return definition if _has_no_file(shorter) else shorter
        return definition

    def fields(self, type_: FieldType) -> Definition | Missing | None:
        """The definition of a field's type, if that is a message; None for built-in types."""
        if type_.base in TIMES["1"]:
            return TIMES[self._ros_version or "1"][type_.base]
        if not type_.is_message:
            return None
        if self._ros_version is not None and type_.base in _IN_ROS_1:
            return TIMES[self._ros_version][_IN_ROS_1[type_.base]]
        package, _, name = type_.base.partition("/")
        interface = self.interface(package, name, "msg")
        return interface if isinstance(interface, Missing) else interface.parts[0]

    def _interface(self, package: str, type_: str, folder: Folder) -> Interface | Missing:
        key = (package, type_, folder)
        if key not in self._interfaces:
            interface = self._read(package, type_, folder)
            if key == ("std_msgs", "Header", "msg") and self._ros_version == "2":
                interface = _without_sequence(interface)
            self._interfaces[key] = interface
        return self._interfaces[key]

    def _is_ros2_package(self, folder: Path) -> bool:
        """Whether the package in a folder is one of ROS 2.

        Raises:
            ValueError: its manifest is faulty.
        """
        return is_ros2_package(folder, self._manifests or "1")

    def _read(self, package: str, type_: str, folder: Folder) -> Interface | Missing:
        home = self.packages.find(package)
        try:
            if home is not None and self._is_ros2_package(home):
                return self._read_ros2(home, package, type_, folder)
        except ValueError as error:
            return Missing("faulty", package, detail=str(error))
        file = None if home is None else self.packages.definition(home, type_, f".{folder}")
        if file is None:
            return self._generated(package, type_, folder, home)
        try:
            text = file.read_text(encoding="utf-8", errors="replace")
            return Interface(package, type_, tuple(genmsg_text.parts(text, package, type_, folder)))
        except (OSError, ValueError) as error:
            return Missing("faulty", package, detail=f"{package}/{folder}/{file.name} {error}")

    def _read_ros2(
        self, home: Path, package: str, type_: str, folder: Folder
    ) -> Interface | Missing:
        suffixes = (f".{folder}", ".idl")
        found = (self.packages.definition(home, type_, s, folder) for s in suffixes)
        file = next((file for file in found if file is not None), None)
        if file is None:
            names = {n for s in suffixes for n in self.packages.definitions(home, s, folder)}
            return Missing("file", package, tuple(sorted(names)))
        try:
            return Interface(package, type_, rosidl.read(file, package, type_, folder))
        except (OSError, ValueError) as error:
            return Missing("faulty", package, detail=f"{package}/{folder}/{type_} {error}")

    def _generated(
        self, package: str, type_: str, folder: Folder, home: Path | None
    ) -> Interface | Missing:
        """A definition from installed Python bindings, or why there is none."""
        names = set(self.packages.definitions(home, f".{folder}")) if home is not None else set()
        for root, _ in self.packages.places:
            bindings = root.parent / "lib" / "python3" / "dist-packages" / package
            if not is_share(root) or not bindings.is_dir():
                continue
            parts = read(bindings, package, type_, folder)
            if parts is not None:
                return Interface(package, type_, parts)
            names.update(generated_names(bindings, folder))
        if home is None and not names:
            return Missing("package", package)
        return Missing("file", package, tuple(sorted(names)))


def _has_no_file(interface: Interface | Missing) -> bool:
    return isinstance(interface, Missing) and interface.reason == "file"


def _without_sequence(header: Interface | Missing) -> Interface | Missing:
    """``std_msgs/Header`` without the field ``seq``, which only ROS 1 has."""
    if isinstance(header, Missing):
        return header
    (part,) = header.parts
    fields = tuple(field for field in part.fields if field.name != "seq")
    return replace(header, parts=(replace(part, fields=fields),))
