"""Interface definitions as ROS 2 has them, and models checked against them."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from ros2.bed import HERE, Bed
from ros_support import Completed

from robosc.model.ros import rosidl
from robosc.model.ros.interfaces import Definition, Folder
from robosc.model.ros.packages import Packages, is_ros2_package

PACKAGE = """
<package format="3">
  <name>shapes</name><version>1.0.0</version><description>Shapes.</description>
  <maintainer email="ada@example.org">Ada</maintainer><license>MIT</license>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""


def read(home: Path, package: str, type_: str, folder: Folder) -> tuple[Definition, ...] | None:
    """The parts of a definition in the folder of its package; None if there is none."""
    packages = Packages()
    files = (packages.definition(home, type_, s, folder) for s in (f".{folder}", ".idl"))
    file = next((file for file in files if file is not None), None)
    return None if file is None else rosidl.read(file, package, type_, folder)


@pytest.fixture
def shapes(tmp_path: Path) -> Path:
    """An empty ROS 2 package."""
    folder = tmp_path / "shapes"
    folder.mkdir()
    (folder / "package.xml").write_text(PACKAGE)
    return folder


def write(package: Path, name: str, text: str) -> None:
    file = package / name
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)


def test_a_message_with_all_that_ros_1_has_not(shapes: Path) -> None:
    write(shapes, "msg/Shape.msg", """
# A shape.
uint8 ROUND=1
string NAME = "a b"  # quoted
string<=10 name "round # thing"  # bounded, with a default
int32[<=5] corners [1, 2]
wstring[3] labels
Point centre
builtin_interfaces/Time stamp
float64 area 1.5
""")  # fmt: skip
    assert read(shapes, "shapes", "Shape", "msg") == (
        Definition.of(
            "shapes/Shape",
            (
                ("name", "string<=10", "round # thing"), ("corners", "int32[<=5]", (1, 2)),
                ("labels", "wstring[3]"),
                ("centre", "shapes/Point"), ("stamp", "builtin_interfaces/Time"),
                ("area", "float64", 1.5),
            ),
            (("ROUND", 1), ("NAME", "a b")),
        ),
    )  # fmt: skip


def test_services_and_actions_have_their_parts(shapes: Path) -> None:
    write(shapes, "srv/Cut.srv", "bool now\n---\nint32 pieces\n")
    write(shapes, "action/Turn.action", "float64 angle\n---\n---\nfloat64 done\n")
    assert read(shapes, "shapes", "Cut", "srv") == (
        Definition.of("shapes/CutRequest", (("now", "bool"),)),
        Definition.of("shapes/CutResponse", (("pieces", "int32"),)),
    )
    assert read(shapes, "shapes", "Turn", "action") == (
        Definition.of("shapes/TurnGoal", (("angle", "float64"),)),
        Definition.of("shapes/TurnResult", ()),
        Definition.of("shapes/TurnFeedback", (("done", "float64"),)),
    )


@pytest.mark.parametrize(
    ("text", "fault"),
    [("bool", "line 1: 'bool' is neither a field"), ("bool a\n---\n", "has 2 parts instead of 1")],
)
def test_faulty_files_say_where(shapes: Path, text: str, fault: str) -> None:
    write(shapes, "msg/Bad.msg", text)
    with pytest.raises(ValueError, match=fault):
        read(shapes, "shapes", "Bad", "msg")


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("struct Bad { @default (value=much) long a; };", "the default of a: 'much' is not of"),
        (
            "module Bad_Constants { const long A = much; };",
            "constant A: 'much' is not of type int32",
        ),
    ],
)
def test_faulty_idl_says_what(shapes: Path, text: str, fault: str) -> None:
    write(shapes, "msg/Bad.idl", text)
    with pytest.raises(ValueError, match=fault):
        read(shapes, "shapes", "Bad", "msg")


def test_what_is_not_there_is_none(shapes: Path) -> None:
    assert read(shapes, "shapes", "Nothing", "msg") is None


def test_idl_with_constants_typedefs_and_annotations(shapes: Path) -> None:
    write(shapes, "msg/Shape.idl", """
#include "shapes/msg/Point.idl"
module shapes { module msg {
  typedef shapes::msg::Point shapes__msg__Point;
  typedef shapes__msg__Point shapes__msg__Point__4[4];
  module Shape_Constants {
    const uint8 ROUND = 1;
    const string NAME = "struct Shape { long no; };";
  };
  @verbatim (language="comment", text="A shape; " "with (braces) { }")
  struct Shape {  // not a member;
    @default (value=3)
    long corners;
    unsigned long long id;
    string<10> name;
    sequence<double, 5> sides;
    shapes__msg__Point__4 box;
    builtin_interfaces::msg::Time stamp;
    @key octet flags;
  };
}; };
""")  # fmt: skip
    assert read(shapes, "shapes", "Shape", "msg") == (
        Definition.of(
            "shapes/Shape",
            (
                ("corners", "int32", 3), ("id", "uint64"), ("name", "string<=10"),
                ("sides", "float64[<=5]"), ("box", "shapes/Point[4]"),
                ("stamp", "builtin_interfaces/Time"), ("flags", "uint8"),
            ),
            (("ROUND", 1), ("NAME", "struct Shape { long no; };")),
        ),
    )  # fmt: skip


def test_idl_says_the_same_as_what_it_was_made_from(bed: Bed, tmp_path: Path) -> None:
    """For every interface of the bed: that written by hand, and the IDL that rosidl made of it."""
    seen = 0
    for share in (bed.prefix / "share", bed.interfaces / "share"):
        for idl in sorted(share.glob("*/*/*.idl")):
            package, kind, type_ = idl.parts[-3], idl.parts[-2], idl.stem
            if not idl.with_suffix(f".{kind}").is_file():
                continue
            alone = tmp_path / package
            write_copy(idl, alone / kind)
            by_hand = read(share / package, package, type_, kind)
            assert by_hand == read(alone, package, type_, kind), idl
            assert is_ros2_package(share / package, "2")
            seen += 1
    assert seen > 90


def test_idl_has_the_defaults_of_what_it_was_made_from(bed: Bed, shapes: Path) -> None:
    """rosidl writes the default of an array as a tuple of Python, in a string; in no interface of
    the bed is there one."""
    write(
        shapes,
        "msg/Shape.msg",
        """
int32[<=5] corners [1, 2]
string[] names ["a, b", "it's", 'say "x"']
float64[2] both [0.5, 4.0]
bool[] flags [true, false]
int8[] none []
string name "it's"
""",
    )
    made = (
        "import sys; from pathlib import Path; from rosidl_adapter.msg import convert_msg_to_idl;"
        "convert_msg_to_idl(Path(sys.argv[1]), 'shapes', Path('msg/Shape.msg'), Path(sys.argv[2]))"
    )
    alone = shapes.parent / "idl" / "shapes"
    subprocess.run([bed.python, "-c", made, shapes, alone / "msg"], check=True)
    (by_hand,) = read(shapes, "shapes", "Shape", "msg") or ()
    assert (by_hand,) == read(alone, "shapes", "Shape", "msg")
    assert [f.default for f in by_hand.fields] == [
        (1, 2), ("a, b", "it's", 'say "x"'), (0.5, 4.0), (True, False), (), "it's",
    ]  # fmt: skip


def write_copy(file: Path, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(file, folder)


@pytest.mark.parametrize("only_idl", [False, True])
def test_a_model_is_checked_against_the_ament_index(
    bed: Bed, tmp_path: Path, robosc: Callable[..., Completed], only_idl: bool
) -> None:
    prefix = tmp_path / "prefix"
    shutil.copytree(bed.interfaces / "share" / "robosc_testing", prefix / "share/robosc_testing")
    for file in (prefix / "share").rglob("*"):
        if only_idl and file.suffix in (".msg", ".srv", ".action"):
            file.unlink()
    path = f"{prefix}:{bed.prefix}"
    model = (HERE / "models" / "guarded_arm.rscd").read_text()
    (tmp_path / "good.rscd").write_text(model)
    bad = model.replace("distance: double", "distanc: double").replace(
        "value.distance", "value.distanc"
    )
    (tmp_path / "bad.rscd").write_text(bad)

    good = robosc("check", "good.rscd", AMENT_PREFIX_PATH=path)
    assert good.returncode == 0
    assert "package-not-found" not in good.stderr
    faulty = robosc("check", "bad.rscd", AMENT_PREFIX_PATH=path)
    assert faulty.returncode == 1
    assert "error[unknown-field]" in faulty.stderr
    assert "did you mean 'distance'?" in faulty.stderr
