"""Reading real definitions: installed ones, and source packages that were never built."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest
from model_text import faults

from robosc.model.ros.definitions import MessageDefinitions, install_advice
from robosc.model.ros.interfaces import FieldType, Folder, Interface, Missing
from robosc.model.ros.packages import Packages, Place

ROS_2 = """<package format='3'><name>{}</name><version>1.0.0</version><description>d</description>
<maintainer email='a@example.org'>a</maintainer><license>MIT</license>
<export><build_type>ament_cmake</build_type></export></package>"""
MANIFEST = "<package format='3'><name>{}</name></package>"


def package(root: Path, name: str, **files: str) -> Path:
    """A source package; ``msg__Name`` is msg/Name.msg."""
    folder = root / name
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(MANIFEST.format(name))
    for key, text in files.items():
        kind, _, stem = key.partition("__")
        (folder / kind).mkdir(exist_ok=True)
        (folder / kind / f"{stem}.{kind}").write_text(text)
    return folder


def found(result: Interface | Missing) -> Interface:
    assert isinstance(result, Interface), result
    return result


def around(model: Path, **environment: str) -> MessageDefinitions:
    return MessageDefinitions.for_model(model, environment)


# --- reading -------------------------------------------------------------------------------------


def test_all_kinds_of_field_are_read(tmp_path: Path) -> None:
    text = """
    # a comment
    int8 LIMIT=5   # constants are no fields
    string NAME=a # b
    Header header
    uint64 big
    char c
    byte b
    time stamp
    duration took
    float64[] list
    float32[3] three
    Part part
    geometry_msgs/Point[2] points
    """
    package(tmp_path, "p", msg__All=dedent(text), msg__Part="bool on\n")
    (definition,) = found(around(tmp_path / "m.rscd").interface("p", "All", "msg")).parts
    assert definition.constants == (("LIMIT", 5), ("NAME", "a # b"))
    assert [(f.name, str(f.type)) for f in definition.fields] == [
        ("header", "std_msgs/Header"),
        ("big", "uint64"),
        ("c", "char"),
        ("b", "byte"),
        ("stamp", "time"),
        ("took", "duration"),
        ("list", "float64[]"),
        ("three", "float32[3]"),
        ("part", "p/Part"),
        ("points", "geometry_msgs/Point[2]"),
    ]


def test_a_time_is_a_message_of_seconds_and_nanoseconds() -> None:
    stamp = MessageDefinitions().fields(FieldType("time"))
    assert not isinstance(stamp, Missing) and stamp is not None
    assert [f.name for f in stamp.fields] == ["secs", "nsecs"]


def test_both_spellings_of_an_action(tmp_path: Path) -> None:
    package(tmp_path, "p", action__Grab="---\n---\n", action__MoveAction="int8 a\n---\n---\n")
    definitions = around(tmp_path / "m.rscd")
    assert found(definitions.interface("p", "GrabAction", "action")).type == "Grab"
    assert found(definitions.interface("p", "Grab", "action")).type == "Grab"
    assert found(definitions.interface("p", "MoveAction", "action")).type == "MoveAction"
    missing = definitions.interface("p", "Move", "action")
    assert isinstance(missing, Missing) and missing.names == ("Grab", "MoveAction")


def test_a_definition_that_cannot_be_read_says_why(tmp_path: Path) -> None:
    package(tmp_path, "p", msg__Bad="int8\n", srv__Bad="int8\n", msg__Odd="int8 a b c\n")
    definitions = around(tmp_path / "m.rscd")
    for result in (
        definitions.interface("p", "Bad", "msg"),
        definitions.interface("p", "Bad", "srv"),
    ):
        assert isinstance(result, Missing) and result.reason == "faulty"
        assert "Bad" in result.detail


def test_a_service_of_ros_1_without_a_response(tmp_path: Path) -> None:
    """As genmsg reads it, which gives all that follows a first --- to the response."""
    package(tmp_path, "p", srv__One="int8 a\n", srv__Three="int8 a\n---\nint8 b\n---\nint8 c\n")
    definitions = around(tmp_path / "m.rscd")
    found = [definitions.interface("p", name, "srv") for name in ("One", "Three")]
    names = [[[f.name for f in part.fields] for part in one.parts] for one in found]
    assert names == [[["a"], []], [["a"], ["b", "c"]]]


@pytest.mark.parametrize(
    ("file", "kind"),
    [
        ("msg/traffic/Lamp.msg", "msg"),
        ("signal/msg/Lamp.msg", "msg"),
        ("srvs/Lamp.srv", "srv"),
        ("Lamp.action", "action"),
        ("test/msg/Lamp.msg", "msg"),
    ],
)
@pytest.mark.parametrize("manifest", [MANIFEST, ROS_2])
def test_definitions_that_lie_elsewhere_in_a_package(
    tmp_path: Path, file: str, kind: Folder, manifest: str
) -> None:
    """They are found without a build; not those of a package in it, nor of what was built."""
    home = package(tmp_path, "p", msg__Other="int8 a\n")
    (home / "package.xml").write_text(manifest.format("p"))
    for place, text in ((file, "int8 right\n---\n---\n"), (f"build/{file}", "int8 wrong\n"),
                        (f"inner/{file}", "int8 wrong\n")):  # fmt: skip
        (home / place).parent.mkdir(parents=True, exist_ok=True)
        (home / place).write_text(text.partition("---")[0] if kind == "msg" else text)
    if kind == "srv":
        (home / file).write_text("int8 right\n---\n")
    (home / "inner" / "package.xml").write_text(manifest.format("inner"))
    definitions = around(tmp_path / "m.rscd")
    first = found(definitions.interface("p", "Lamp", kind)).parts[0]
    assert [f.name for f in first.fields] == ["right"]
    missing = definitions.interface("p", "Lam", kind)
    assert isinstance(missing, Missing) and "Lamp" in missing.names


def test_a_package_of_a_field_that_only_passes_through(tmp_path: Path) -> None:
    """It is missing: a warning. What is read of it is an error."""
    package(tmp_path, "p", msg__Way="int8 a\nabsent_msgs/Point[] points\nInner b\n",
            msg__Inner="absent_msgs/Point point\nint8 c\n")  # fmt: skip
    text = """
        component Arm {
            outgoing message way with type: p/Way
            behaviour {
                variable a: integer
                initial marked state on { on response from way do a := %s }
            }
        }
        component Leg { incoming message go with type: none }
        requirement go needs Arm.a > 1
    """
    definitions = around(tmp_path / "m.rscd")
    absent = ("package-not-found", "p")
    assert absent in faults(text % "value.a + value.b.c", definitions)
    told = [code for code, _ in faults(text % "value.a + value.b.c", definitions)]
    assert told.count("package-not-found") == 1 and "ros-type-unknown" not in told
    told = [code for code, _ in faults(text % "value.b.point.x", definitions)]
    assert "unknown-member" in told


# --- where packages are found --------------------------------------------------------------------


@pytest.mark.parametrize(
    "place",
    [
        ".",  # beside the model
        "..",  # beside the model's folder
        "../../src/deep/down",  # in the workspace
        "../../other",  # ROS_PACKAGE_PATH
        "../../other/deep",
        "../../install/share",  # CMAKE_PREFIX_PATH
    ],
)
def test_places(tmp_path: Path, place: str) -> None:
    model = tmp_path / "src" / "robots" / "one" / "model.rscd"
    model.parent.mkdir(parents=True)
    (tmp_path / ".catkin_workspace").touch()
    root = (model.parent / place).resolve()
    if place.startswith("../../"):
        root = (tmp_path / place.removeprefix("../../")).resolve()
    package(root, "p", msg__M="int8 a\n")
    definitions = around(
        model,
        ROS_PACKAGE_PATH=str(tmp_path / "other"),
        CMAKE_PREFIX_PATH=str(tmp_path / "install"),
    )
    assert found(definitions.interface("p", "M", "msg")).parts[0].fields[0].name == "a"


def test_a_package_beside_the_one_that_holds_the_model(tmp_path: Path) -> None:
    package(tmp_path, "p", msg__M="int8 a\n")
    holder = package(tmp_path, "holder")
    (holder / "models" / "deep").mkdir(parents=True)
    assert found(around(holder / "models" / "deep" / "m.rscd").interface("p", "M", "msg"))


def test_the_name_counts_not_the_folder_and_ignored_packages_do_not_count(tmp_path: Path) -> None:
    package(tmp_path, "p", msg__M="int8 a\n").rename(tmp_path / "renamed")
    package(tmp_path, "q", msg__M="int8 a\n")
    (tmp_path / "q" / "CATKIN_IGNORE").touch()
    definitions = around(tmp_path / "m.rscd")
    assert found(definitions.interface("p", "M", "msg"))
    assert definitions.interface("q", "M", "msg") == Missing("package", "q")


def test_a_broken_manifest_does_not_hide_other_packages(tmp_path: Path) -> None:
    package(tmp_path / "ws", "p", msg__M="int8 a\n")
    (tmp_path / "ws" / "a").mkdir()
    (tmp_path / "ws" / "a" / "package.xml").write_text("<package")
    definitions = around(tmp_path / "x" / "m.rscd", ROS_PACKAGE_PATH=str(tmp_path / "ws"))
    assert found(definitions.interface("p", "M", "msg"))


def test_the_environment_comes_before_what_lies_around(tmp_path: Path) -> None:
    package(tmp_path, "p", msg__M="int8 near\n")
    package(tmp_path / "env", "p", msg__M="int8 far\n")
    definitions = around(tmp_path / "m.rscd", ROS_PACKAGE_PATH=str(tmp_path / "env"))
    assert found(definitions.interface("p", "M", "msg")).parts[0].fields[0].name == "far"


def test_advice_names_the_debian_packages() -> None:
    assert "ros-geometry-msgs python3-geometry-msgs" in install_advice("geometry_msgs")
    assert "rosdep resolve my_msgs" in install_advice("my_msgs")


# --- what is really installed --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("type_", "fields"),
    [
        ("geometry_msgs/Twist", {"linear": "geometry_msgs/Vector3"}),
        ("sensor_msgs/LaserScan", {"ranges": "float32[]", "header": "std_msgs/Header"}),
        ("sensor_msgs/Imu", {"orientation_covariance": "float64[9]"}),
        ("std_msgs/Int64", {"data": "int64"}),
    ],
)
def test_installed_messages(ros: None, type_: str, fields: dict[str, str]) -> None:
    package_name, _, name = type_.partition("/")
    (definition,) = found(around(Path("m.rscd")).interface(package_name, name, "msg")).parts
    types = {f.name: str(f.type) for f in definition.fields}
    assert fields.items() <= types.items()


def test_installed_services(ros: None) -> None:
    request, response = found(around(Path("m.rscd")).interface("std_srvs", "SetBool", "srv")).parts
    assert [f.name for f in request.fields] == ["data"]
    assert [f.name for f in response.fields] == ["success", "message"]


def test_actions_of_actionlib_are_found_though_only_their_bindings_are_installed(ros: None) -> None:
    interface = found(around(Path("m.rscd")).interface("actionlib", "TestAction", "action"))
    assert interface.type == "Test"
    assert [[f.name for f in part.fields] for part in interface.parts] == [
        ["goal"],
        ["result"],
        ["feedback"],
    ]
    missing = around(Path("m.rscd")).interface("actionlib", "Tst", "action")
    assert isinstance(missing, Missing) and "TwoInts" in missing.names


def test_bindings_tell_what_definitions_tell(ros: None, tmp_path: Path) -> None:
    share = tmp_path / "share"
    share.mkdir()
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "python3").symlink_to("/usr/lib/python3")
    bare = MessageDefinitions(Packages([Place(share)]))
    real = around(Path("m.rscd"))
    for name in ("Twist", "PoseWithCovarianceStamped", "Polygon"):
        assert (
            found(bare.interface("geometry_msgs", name, "msg")).parts[0].fields
            == found(real.interface("geometry_msgs", name, "msg")).parts[0].fields
        )
    assert [p.fields for p in found(bare.interface("nav_msgs", "GetPlan", "srv")).parts] == [
        p.fields for p in found(real.interface("nav_msgs", "GetPlan", "srv")).parts
    ]


def test_debian_installs_definitions_without_a_manifest(tmp_path: Path) -> None:
    """A folder with a manifest is still the better one, wherever it is."""
    share = tmp_path / "usr" / "share"
    for name in ("p", "q"):
        (package(share, name, srv__Set="bool far\n---\n") / "package.xml").unlink()
    package(tmp_path / "ws" / "src", "q", srv__Set="bool near\n---\n")
    (tmp_path / "ws" / ".catkin_workspace").touch()
    model = tmp_path / "ws" / "src" / "m" / "m.rscd"
    model.parent.mkdir()
    definitions = around(model, ROS_PACKAGE_PATH=str(share))
    names = [found(definitions.interface(n, "Set", "srv")).parts[0].fields[0].name for n in "pq"]
    assert names == ["far", "near"]
