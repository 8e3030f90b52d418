"""Search for ROS packages, and the relevant content of their manifests.

The first package of a name is taken from, in this order:

1. the ROS package path (``ROS_PACKAGE_PATH``, as rospkg reads it) and ``share`` of each folder of
   ``AMENT_PREFIX_PATH`` and ``CMAKE_PREFIX_PATH``, as ROS 2 and ROS 1 themselves do;
2. the folder of the model and the one above it: packages directly in them;
3. ``src`` of every catkin or colcon workspace around the model, and the folder that holds the
   package which the model is part of;
4. ``/opt/ros/*/share`` and ``/usr/share``, where distributions and Debian install them.

rospkg finds them and catkin_pkg reads their manifests. In a Python without these, packages are
found by the names of their folders, and taken for packages of ROS 1 without exports.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from robosc.model.ros.interfaces import KINDS

_MANIFEST = "package.xml"
_BUILT = ("build", "devel", "install", "log")
"""Folders of a package without definitions of its own."""


class Place(NamedTuple):
    """A folder with packages: at any depth if ``deep``, else directly in it."""

    folder: Path
    deep: bool = False


class Packages:
    """The packages in some places, each of which is searched at most once.

    ``sourced`` is the version of ROS that is sourced, from ``ROS_VERSION``; None if none is.
    """

    def __init__(self, places: Iterable[Place] = (), sourced: str | None = None) -> None:
        self.places = tuple(dict.fromkeys(places))
        self.sourced = sourced
        self._found: dict[str, Path | None] = {}
        self._searched: dict[Place, Mapping[str, Path]] = {}
        self._library_folders: tuple[Path, ...] | None = None
        self._definitions: dict[tuple[Path, str, str | None], Mapping[str, Path]] = {}

    @classmethod
    def for_model(cls, model: Path, environment: Mapping[str, str] | None = None) -> Packages:
        """The packages that a model file may use, in the places that the module lists."""
        env = os.environ if environment is None else environment
        return cls(_places(model, env), env.get("ROS_VERSION"))

    def find(self, name: str) -> Path | None:
        """The folder of a package; None if it is not found."""
        if name not in self._found:
            self._found[name] = self._find(name)
        return self._found[name]

    def definition(
        self, home: Path, type_: str, suffix: str, folder: str | None = None
    ) -> Path | None:
        """The file of a definition in a package; see :meth:`definitions`."""
        direct = home / (folder or suffix[1:]) / f"{type_}{suffix}"
        if direct.is_file():
            return direct
        return self.definitions(home, suffix, folder).get(type_)

    def definitions(self, home: Path, suffix: str, folder: str | None = None) -> Mapping[str, Path]:
        """The files of definitions in a package, by the names of their types. Their folders may
        have any names, and lie at any depth: the package's CMakeLists.txt lists them. IDL tells
        only by its ``folder`` what it is of."""
        key = (home, suffix, folder if suffix == ".idl" else None)
        if key not in self._definitions:
            self._definitions[key] = _files_below(home, *key[1:])
        return self._definitions[key]

    def _find(self, name: str) -> Path | None:
        for place in self.places:
            direct = place.folder / name
            if (direct / _MANIFEST).is_file() and not (direct / "CATKIN_IGNORE").exists():
                return direct
            if place.deep or not is_share(place.folder):
                folder = self._search(place).get(name)
                if folder is not None:
                    return folder
        # Debian installs definitions without the manifest, which comes with what C++ needs.
        shares = (place.folder / name for place in self.places if is_share(place.folder))
        return next((s for s in shares if any((s / kind).is_dir() for kind in KINDS)), None)

    def _search(self, place: Place) -> Mapping[str, Path]:
        if place not in self._searched:
            search = _packages_below if place.deep else _packages_in
            self._searched[place] = search(place.folder)
        return self._searched[place]

    def all(self) -> Mapping[str, Path]:
        """The folder of each package that can be found, by its name."""
        packages: dict[str, Path] = {}
        for folder, deep in self.places:
            for name, home in self._search(Place(folder, deep and not is_share(folder))).items():
                packages.setdefault(name, home)
        return packages

    def with_file(self, file: str) -> list[str]:
        """Names of packages that have a definition file such as ``msg/Twist.msg``, for hints."""
        names = {p.parents[1].name for place in self.places for p in place.folder.glob(f"*/{file}")}
        return sorted(names)

    def library_folders(self) -> Sequence[Path]:
        """The folders that packages export with ``<robosc libraries="…"/>``."""
        if self._library_folders is None:
            folders = (_exported_libraries(folder) for folder in self.all().values())
            self._library_folders = tuple(f for f in folders if f is not None)
        return self._library_folders


def _files_below(home: Path, suffix: str, folder: str | None) -> Mapping[str, Path]:
    """The files with a suffix in a package, those in the usual folder first; not those of other
    packages in it, nor in hidden folders, nor what a build has made."""
    found: dict[str, Path] = {}
    usual = folder or suffix[1:]
    for where, folders, files in os.walk(home):
        place = Path(where)
        folders[:] = sorted(
            name
            for name in folders
            if not name.startswith(".")
            and name not in _BUILT
            and not (place / name / _MANIFEST).exists()
        )
        if folder is None or folder in place.relative_to(home).parts:
            for name in sorted(files):
                if name.endswith(suffix):
                    found.setdefault(name.removesuffix(suffix), place / name)
    direct = {file.stem: file for file in (home / usual).glob(f"*{suffix}")}
    return {**found, **direct}


def is_share(folder: Path) -> bool:
    """Whether a folder is an install space, with packages directly in it, in folders by name."""
    return folder.name == "share"


def is_ros2_package(folder: Path, ros_version: str) -> bool:
    """Whether the package in a folder is built by ament.

    Conditions in its manifest can make it a package of both versions of ROS (REP 149):
    ``ros_version`` is the value of ``$ROS_VERSION`` in them.

    Raises:
        ValueError: its manifest is faulty; says in what.
    """
    manifest = _manifest(folder, mentions="ament_")
    if manifest is None:
        return False
    try:
        manifest.evaluate_conditions({**os.environ, "ROS_VERSION": ros_version})
        return bool(manifest.get_build_type().startswith("ament_"))
    except Exception as error:  # a condition that cannot be parsed, several build types
        raise ValueError(f"{folder / _MANIFEST}: {error}") from error


def _exported_libraries(folder: Path) -> Path | None:
    """The library folder that a package exports; ``${prefix}`` stands for the package's folder."""
    try:
        manifest = _manifest(folder, mentions="<robosc")
    except ValueError:
        return None
    for export in manifest.exports if manifest is not None else ():
        path = export.attributes.get("libraries")
        if export.tagname == "robosc" and path is not None:
            return folder / str(path).replace("${prefix}/", "").replace("${prefix}", ".")
    return None


def _manifest(folder: Path, mentions: str) -> Any | None:
    """The manifest of a package as catkin_pkg's ``Package``, if it contains a certain text.

    Most manifests do not, and loading catkin_pkg takes longer than checking a small model.

    Raises:
        ValueError: it is faulty.
    """
    file = folder / _MANIFEST
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    if mentions not in text:
        return None
    try:
        from catkin_pkg.package import InvalidPackage, parse_package_string
    except ImportError:
        return None
    try:
        return parse_package_string(text, str(file), warnings=[])
    except InvalidPackage as error:
        raise ValueError(str(error)) from error


def _places(model: Path, env: Mapping[str, str]) -> Iterator[Place]:
    for entry in env.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if entry:
            yield Place(Path(entry), deep=not is_share(Path(entry)))
    for variable in ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH"):
        for entry in env.get(variable, "").split(os.pathsep):
            if entry:
                yield Place(Path(entry) / "share")
    folder = Path(os.path.abspath(model)).parent  # noqa: PTH100 (resolve() would follow links)
    yield Place(folder)
    yield Place(folder.parent)
    for above in (folder, *folder.parents):
        if (above / _MANIFEST).is_file():
            yield Place(above.parent)
        if (above / "src").is_dir() and _is_workspace(above):
            yield Place(above / "src", deep=True)
    yield from (Place(share) for share in sorted(Path("/opt/ros").glob("*/share")))
    yield Place(Path("/usr/share"))


def _is_workspace(folder: Path) -> bool:
    marks = (
        ".catkin_workspace", ".catkin_tools", "src/CMakeLists.txt", "src/.rosinstall",
        "install/.colcon_install_layout",
    )  # fmt: skip
    return any((folder / mark).exists() for mark in marks)


def _packages_below(root: Path) -> Mapping[str, Path]:
    """All packages below a folder."""
    # One unreadable manifest ends rospkg's search; those directly in the folder are still found.
    return {**_packages_in(root), **_listed(root)}


def _packages_in(root: Path) -> Mapping[str, Path]:
    """The packages directly in a folder."""
    try:
        homes = sorted(file.parent for file in root.glob(f"*/{_MANIFEST}"))
        homes = [home for home in homes if not (home / "CATKIN_IGNORE").exists()]
    except OSError:
        return {}
    packages: dict[str, Path] = {}
    for home in homes:
        names = {home.name: home} if is_share(root) else _listed(home)
        for name in names:
            packages.setdefault(name, home)
    return packages


def _listed(root: Path) -> Mapping[str, Path]:
    """The packages that rospkg finds in a folder, itself included."""
    rospack = _rospack()
    if rospack is None:
        return {root.name: root} if (root / _MANIFEST).is_file() else {}
    folders: dict[str, str] = {}
    from xml.etree.ElementTree import ParseError  # which rospkg has loaded

    # rospkg raises these for unreadable manifests, and for those without a name.
    with contextlib.suppress(ParseError, OSError, AttributeError):
        rospack.list_by_path(_MANIFEST, str(root), folders)
    return {name: Path(path) for name, path in folders.items()}


@cache
def _rospack() -> Any | None:
    """``rospkg.rospack``, or None on a machine without ROS."""
    try:
        from rospkg import rospack
    except ImportError:
        return None
    return rospack
