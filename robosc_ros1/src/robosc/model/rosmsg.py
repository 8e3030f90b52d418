"""Real definitions of messages, services and actions, found and read without anything being built.

Definitions are read by genmsg from ``.msg``, ``.srv`` and ``.action`` files, so a package in a
source workspace serves as well as an installed one. Where only generated Python bindings are
installed, they serve too, and without genmsg (a Python that is not the one of ROS) only these do.
Packages of ROS 2 are read by :mod:`robosc.model.rosidl`, for which nothing need be installed.

Packages are looked for, the first find winning, in:

1. the ROS package path (``ROS_PACKAGE_PATH``, as rospkg reads it) and ``share`` of each folder of
   ``AMENT_PREFIX_PATH`` and ``CMAKE_PREFIX_PATH``, as ROS 2 and ROS 1 themselves do;
2. the folder of the model and the one above it: packages that lie directly in them;
3. ``src`` of every catkin or colcon workspace around the model, and the folder that holds the
   package which the model is part of;
4. ``/opt/ros/*/share`` and ``/usr/share``, where distributions and Debian install them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from robosc.model import rosbindings, rosidl

__all__ = [
    "BASIC", "Definition", "Field", "FieldType", "INTEGERS", "Interface", "MessageDefinitions",
    "Missing", "install_advice",
]  # fmt: skip

INTEGERS: Mapping[str, tuple[int, int]] = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
    "byte": (-128, 127),
    "char": (0, 255),
}
"""The least and greatest value of each integer type; byte and char are int8 and uint8 in ROS 1."""


@dataclass(frozen=True, slots=True)
class FieldType:
    """``base`` is a built-in type or ``package/Type``; ``length`` only for fixed arrays."""

    base: str
    is_array: bool = False
    length: int | None = None

    def __str__(self) -> str:
        if not self.is_array:
            return self.base
        return f"{self.base}[{'' if self.length is None else self.length}]"

    @property
    def element(self) -> FieldType:
        return FieldType(self.base)

    @property
    def is_message(self) -> bool:
        return "/" in self.base or self.base in ("time", "duration")


@dataclass(frozen=True, slots=True)
class Field:
    name: str
    type: FieldType


@dataclass(frozen=True, slots=True)
class Definition:
    """The fields of one message, or of one part of a service or action; constants by name."""

    name: str
    fields: tuple[Field, ...]
    constants: tuple[str, ...] = ()

    def field(self, name: str) -> Field | None:
        return next((f for f in self.fields if f.name == name), None)


@dataclass(frozen=True, slots=True)
class Interface:
    """A definition with its parts: a message has one, a service two, an action three.

    ``type`` is the stem of the file, without the suffix ``Action`` that the model may have.
    """

    package: str
    type: str
    parts: tuple[Definition, ...]


@dataclass(frozen=True, slots=True)
class Missing:
    """Why a definition is not to be had.

    ``reason`` is ``package`` (there is none of that name), ``file`` (it has no such file; ``names``
    are those that it has), ``faulty`` (the file cannot be read; ``detail`` tells why) or ``genmsg``
    (this Python cannot read definitions).
    """

    reason: str
    package: str
    names: tuple[str, ...] = ()
    detail: str = ""


def _std(name: str, base: str | None) -> Interface:
    fields = () if base is None else (Field("data", FieldType(base)),)
    return Interface("std_msgs", name, (Definition(f"std_msgs/{name}", fields),))


BASIC: Mapping[str, Interface] = {
    "none": _std("Empty", None),
    "boolean": _std("Bool", "bool"),
    "integer": _std("Int16", "int16"),
    "double": _std("Float32", "float32"),
    "string": _std("String", "string"),
}
"""What carries a basic type that is not linked (LANGUAGE section 6); known without ROS."""

_TIMES = {
    "time": Definition(
        "time", (Field("secs", FieldType("uint32")), Field("nsecs", FieldType("uint32")))
    ),
    "duration": Definition(
        "duration", (Field("secs", FieldType("int32")), Field("nsecs", FieldType("int32")))
    ),
}

_IN_DEBIAN = frozenset({
    "actionlib_msgs", "diagnostic_msgs", "geometry_msgs", "map_msgs", "move_base_msgs", "nav_msgs",
    "pcl_msgs", "rosgraph_msgs", "sensor_msgs", "shape_msgs", "std_msgs", "std_srvs", "stereo_msgs",
    "tf2_msgs", "trajectory_msgs", "visualization_msgs",
})  # fmt: skip


def install_advice(package: str) -> str:
    """What to install for a package that is not there, by rosdep key and, if known, Debian name."""
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
    """Finds and reads definitions; each package and file is looked at once.

    ``deep`` roots are searched with all their folders, ``shallow`` ones only for packages that lie
    directly in them. ``MessageDefinitions()`` knows none, ``for_model`` where to look.
    """

    def __init__(self, deep: Sequence[Path] = (), shallow: Sequence[Path] = ()) -> None:
        self._deep = tuple(dict.fromkeys(deep))
        self._shallow = tuple(dict.fromkeys(shallow))
        self._order: tuple[tuple[Path, bool], ...] = (
            *((r, True) for r in self._deep),
            *((r, False) for r in self._shallow),
        )
        self._packages: dict[str, Path | None] = {}
        self._crawled: dict[Path, dict[str, Path]] = {}
        self._interfaces: dict[tuple[str, str, str], Interface | Missing] = {}
        self._library_folders: tuple[Path, ...] | None = None

    @classmethod
    def for_model(
        cls, path: Path, environment: Mapping[str, str] | None = None
    ) -> MessageDefinitions:
        """The places of the module's description, for a model file."""
        env = os.environ if environment is None else environment
        found = cls()
        found._order = tuple(dict.fromkeys(_places(path, env)))
        return found

    # --- packages --------------------------------------------------------------------------------

    def package(self, name: str) -> Path | None:
        """The folder of a package."""
        if name not in self._packages:
            self._packages[name] = self._find(name)
        return self._packages[name]

    def _find(self, name: str) -> Path | None:
        for root, deep in self._order:
            direct = root / name
            if (direct / "package.xml").is_file() and not (direct / "CATKIN_IGNORE").exists():
                return direct
            if deep or not _is_share(root):
                found = self._crawl(root, deep).get(name)
                if found is not None:
                    return found
        return None

    def _crawl(self, root: Path, deep: bool) -> dict[str, Path]:
        if root not in self._crawled:
            self._crawled[root] = _packages_in(root) if deep else _packages_beside(root)
        return self._crawled[root]

    def packages_with(self, file: str) -> list[str]:
        """Packages that have a definition file such as ``msg/Twist.msg``, for advice."""
        found = {p.parents[1].name for root, _ in self._order for p in root.glob(f"*/{file}")}
        return sorted(found)

    def packages(self) -> Mapping[str, Path]:
        """All packages that can be found, by name."""
        packages: dict[str, Path] = {}
        for root, deep in self._order:
            for name, folder in self._crawl(root, deep and not _is_share(root)).items():
                packages.setdefault(name, folder)
        return packages

    def library_folders(self) -> Sequence[Path]:
        """The folders that packages offer by ``<robosc libraries="…"/>`` in their exports."""
        if self._library_folders is None:
            found = (_exported(folder) for folder in self.packages().values())
            self._library_folders = tuple(f for f in found if f is not None)
        return self._library_folders

    # --- definitions -----------------------------------------------------------------------------

    def message(self, package: str, type_: str) -> Interface | Missing:
        return self._interface(package, type_, "msg")

    def service(self, package: str, type_: str) -> Interface | Missing:
        """Parts: request, response."""
        return self._interface(package, type_, "srv")

    def action(self, package: str, type_: str) -> Interface | Missing:
        """Parts: goal, result, feedback. ``TAction`` also finds ``T.action``."""
        found = self._interface(package, type_, "action")
        if isinstance(found, Missing) and found.reason == "file" and len(type_) > len("Action"):
            stem = type_.removesuffix("Action")
            if stem != type_:
                shorter = self._interface(package, stem, "action")
                if isinstance(shorter, Interface) or shorter.reason != "file":
                    return shorter
        return found

    def fields(self, type_: FieldType) -> Definition | Missing | None:
        """The definition behind a field that is a message itself; None for built-in types."""
        if type_.base in _TIMES:
            return _TIMES[type_.base]
        if not type_.is_message:
            return None
        package, _, name = type_.base.partition("/")
        found = self.message(package, name)
        return found if isinstance(found, Missing) else found.parts[0]

    def _interface(self, package: str, type_: str, folder: str) -> Interface | Missing:
        key = (package, type_, folder)
        if key not in self._interfaces:
            self._interfaces[key] = self._read(package, type_, folder)
        return self._interfaces[key]

    def _read(self, package: str, type_: str, folder: str) -> Interface | Missing:
        home = self.package(package)
        if home is not None and rosidl.is_package(home):
            return self._read_ros2(home, package, type_, folder)
        file = home / folder / f"{type_}.{folder}" if home is not None else None
        if file is None or not file.is_file():
            return self._generated(package, type_, folder, home)
        if _genmsg() is None:
            generated = self._generated(package, type_, folder, home)
            return generated if isinstance(generated, Interface) else Missing("genmsg", package)
        try:
            text = file.read_text(encoding="utf-8", errors="replace")
            return Interface(package, type_, tuple(_parts(text, package, type_, folder)))
        except (OSError, ValueError) as error:
            return Missing("faulty", package, detail=f"{package}/{folder}/{file.name} {error}")

    def _read_ros2(self, home: Path, package: str, type_: str, folder: str) -> Interface | Missing:
        try:
            parts = rosidl.read(home, package, type_, folder)
        except (OSError, ValueError) as error:
            return Missing("faulty", package, detail=f"{package}/{folder}/{type_} {error}")
        if parts is None:
            files = (*(home / folder).glob(f"*.{folder}"), *(home / folder).glob("*.idl"))
            return Missing("file", package, tuple(sorted({file.stem for file in files})))
        definitions = (
            replace(_slotted(f"{package}/{type_}{name}", part.fields), constants=part.constants)
            for part, name in zip(parts, _PARTS[folder], strict=True)
        )
        return Interface(package, type_, tuple(definitions))

    def _generated(
        self, package: str, type_: str, folder: str, home: Path | None
    ) -> Interface | Missing:
        """A definition from installed Python bindings, or what there is instead of it."""
        names = {p.stem for p in (home / folder).glob(f"*.{folder}")} if home is not None else set()
        for root, _ in self._order:
            bindings = root.parent / "lib" / "python3" / "dist-packages" / package
            if not _is_share(root) or not bindings.is_dir():
                continue
            parts = rosbindings.read(bindings, type_, folder)
            if parts is not None:
                named = zip(parts, _PARTS[folder], strict=True)
                definitions = (_slotted(f"{package}/{type_}{part}", p) for p, part in named)
                return Interface(package, type_, tuple(definitions))
            names.update(rosbindings.names(bindings, folder))
        if home is None and not names:
            return Missing("package", package)
        return Missing("file", package, tuple(sorted(names)))


_PARTS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


def _slotted(name: str, slots: rosbindings.Slots) -> Definition:
    return Definition(name, tuple(Field(field, _parse_type(type_)) for field, type_ in slots))


def _parse_type(text: str) -> FieldType:
    base, bracket, length = text.rstrip("]").partition("[")
    return FieldType(base, bool(bracket), int(length) if length else None)


def _parts(text: str, package: str, type_: str, folder: str) -> Iterator[Definition]:
    names = _PARTS[folder]
    texts = [text] if folder == "msg" else re.split(r"^---.*$", text, flags=re.MULTILINE)
    if len(texts) != len(names):
        raise ValueError(f"has {len(texts)} parts instead of {len(names)}, separated by ---")
    for part, name in zip(texts, names, strict=True):
        yield _definition(part, f"{package}/{type_}{name}")


def _definition(text: str, name: str) -> Definition:
    genmsg: Any = _genmsg()
    context = genmsg.msg_loader.MsgContext.create_default()
    try:
        spec = genmsg.msg_loader.load_msg_from_string(context, text, name)
    except genmsg.InvalidMsgSpec as error:
        raise ValueError(str(error)) from error
    fields = (Field(field.name, _parse_type(field.type)) for field in spec.parsed_fields())
    return Definition(name, tuple(fields), tuple(c.name for c in spec.constants))


@cache
def _genmsg() -> Any | None:
    """genmsg, or None on a machine without ROS."""
    try:
        import genmsg
        import genmsg.msg_loader
    except ImportError:
        return None
    return genmsg


def _places(model: Path, env: Mapping[str, str]) -> Iterator[tuple[Path, bool]]:
    for entry in env.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if entry:
            yield Path(entry), not _is_share(Path(entry))
    for variable in ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH"):
        for entry in env.get(variable, "").split(os.pathsep):
            if entry:
                yield Path(entry) / "share", False
    folder = Path(os.path.abspath(model)).parent  # noqa: PTH100 (resolve() would follow links)
    yield folder, False
    yield folder.parent, False
    for above in (folder, *folder.parents):
        if (above / "package.xml").is_file():
            yield above.parent, False
        if (above / "src").is_dir() and _is_workspace(above):
            yield above / "src", True
    yield from ((share, False) for share in sorted(Path("/opt/ros").glob("*/share")))
    yield Path("/usr/share"), False


def _is_workspace(folder: Path) -> bool:
    marks = (
        ".catkin_workspace", ".catkin_tools", "src/CMakeLists.txt", "src/.rosinstall",
        "install/.colcon_install_layout",
    )  # fmt: skip
    return any((folder / mark).exists() for mark in marks)


def _is_share(root: Path) -> bool:
    """An install space: packages lie directly in it, each in the folder of its name."""
    return root.name == "share"


def _packages_in(root: Path) -> dict[str, Path]:
    """All packages below a folder, as rospkg finds them."""
    from xml.etree.ElementTree import ParseError

    try:
        from rospkg import rospack
    except ImportError:
        return _packages_beside(root)
    found: dict[str, str] = {}
    try:
        rospack.list_by_path("package.xml", str(root), found)
    except (ParseError, OSError, AttributeError):
        # One unreadable package.xml ends rospkg's walk; what lies nearer is still to be had.
        return {**_packages_beside(root), **{n: Path(p) for n, p in found.items()}}
    return {name: Path(path) for name, path in found.items()}


_EXPORT = re.compile(r"""<robosc\s[^>]*?libraries\s*=\s*(?:"([^"]*)"|'([^']*)')""")


def _exported(package: Path) -> Path | None:
    """The library folder that a package exports; ``${prefix}`` is the package's own folder."""
    try:
        text = (package / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    match = _EXPORT.search(re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL))
    if match is None:
        return None
    return package / (match[1] or match[2]).replace("${prefix}/", "").replace("${prefix}", ".")


_PACKAGE_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")


def _packages_beside(root: Path) -> dict[str, Path]:
    """The packages that lie directly in a folder, by the name in their package.xml."""
    found: dict[str, Path] = {}
    try:
        manifests = sorted(root.glob("*/package.xml"))
    except OSError:
        return found
    for manifest in manifests:
        if (manifest.parent / "CATKIN_IGNORE").exists():
            continue
        try:
            text = manifest.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
        if match := _PACKAGE_NAME.search(text):
            found.setdefault(match[1], manifest.parent)
    return found
