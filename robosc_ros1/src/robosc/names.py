"""What may be a name: identifiers of the language, and graph and package names of ROS.

ROS names follow http://wiki.ros.org/Names for ROS 1 and the stricter rules of
https://design.ros2.org/articles/topic_and_service_names.html for ROS 2; package names follow
REP 144.
"""

from __future__ import annotations

import keyword
import re
import sys

from robosc import limits
from robosc.lazy_dataclasses import dataclass

IDENTIFIER = r"[A-Za-z_][A-Za-z0-9_]*"
"""An identifier as a regular expression, without the escape ``^``."""

_IDENTIFIER = re.compile(IDENTIFIER, re.ASCII)


def is_identifier(text: str) -> bool:
    return _IDENTIFIER.fullmatch(text) is not None


@dataclass(frozen=True, slots=True)
class Copy:
    """One copy of an indexed component: ``Station[3]`` is the third of the family ``Station``."""

    family: str
    index: int

    @property
    def name(self) -> str:
        return copy_name(self.family, self.index)

    @classmethod
    def of(cls, name: str) -> Copy | None:
        """The copy with this name; None if it is that of any other component."""
        family, _, index = name.partition("[")
        # A lasting condition of a copy, Station[1].still, is no copy.
        return cls(family, int(index[:-1])) if index.endswith("]") else None


def declared(name: str) -> str:
    """The name under which a component is declared: ``Station`` of ``Station[3]``."""
    copy = Copy.of(name)
    return name if copy is None else copy.family


def copy_name(family: str, index: int) -> str:
    """The name of one copy of an indexed component: ``Station[3]``."""
    return f"{family}[{index}]"


def without_index(name: str) -> str:
    """``Station[3]`` → ``Station_3``: the name of one of several of a kind as an identifier."""
    return re.sub(r"\[(-?)(\d+)\]", lambda m: f"_{'minus_' * len(m[1])}{m[2]}", name)


def snake_case(name: str) -> str:
    """``LineFollower2D`` → ``line_follower2_d``, ``HTTPServer`` → ``http_server``."""
    name = without_index(name)
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return re.sub(r"_{2,}", "_", words).strip("_").lower()


def package_name(name: str) -> str:
    """The name as a ROS package name (REP 144): lower case, begins with a letter, no ``__``."""
    snake = snake_case(name)
    return snake if snake[:1].isalpha() else f"robot_{snake}".rstrip("_")


def package_name_fault(name: str) -> str | None:
    """Why a generated package cannot be called so; None if it can.

    The package is a ROS package (REP 144) and a Python package in one, and stands on the path of
    everything that runs in its workspace: a name of Python's own library would take its place.
    """
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name):
        return "lower case, digits and single _, a letter first"
    if keyword.iskeyword(name) or name in sys.stdlib_module_names:
        return "Python has something of that name"
    if name == "robosc":
        return "that is robosc itself"
    if len(name) > limits.PACKAGE_NAME:
        return f"it is longer than {limits.PACKAGE_NAME} characters, which CMake cannot build"
    return None


def rostest_name(package: str) -> str:
    """The name of the test of a ROS 1 package, ``test/<name>.test``: the package's, shortened.

    catkin names a folder ``_run_tests_<package>_rostest_test_<name>.test.dir``, and file systems
    take 255 bytes.
    """
    return package[:90]


def ros_name_fault(name: str) -> str | None:
    """Why ROS does not allow ``name`` for a topic, service or action; None if it does.

    Accepted are relative (``a/b``), absolute (``/a/b``) and private (``~a``) names that are valid
    in ROS 1 and ROS 2 alike, so that one model serves both. ROS 1 takes no leading ``_``, ROS 2 no
    ``__``, and no part that begins with a digit; the text names the one that does not.
    """
    if not name:
        return "it is empty"
    if name in ("/", "~", "~/"):
        return "it names no topic"
    rest = name[2:] if name.startswith("~/") else name[1:] if name[0] in "/~" else name
    if bad := re.search(r"[^A-Za-z0-9_/]", rest):
        return f"{bad.group()!r} is not allowed: only letters, digits, '_' and '/' are"
    if name[0] == "_":
        return "it begins with '_' (ROS 1)"
    if rest.endswith("/"):
        return "it ends with '/'"
    for part in rest.split("/"):
        if not part:
            return "it contains '//'"
        if part[0].isdigit():
            return f"the part {part!r} begins with a digit (ROS 2)"
        if "__" in part:
            return f"the part {part!r} contains '__' (ROS 2)"
    return None


def is_frame(name: str) -> bool:
    """Whether tf could have a frame of this name, without a leading slash."""
    return bool(name) and name.isprintable() and not any(map(str.isspace, name))
