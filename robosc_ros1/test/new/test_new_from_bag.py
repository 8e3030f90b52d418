"""``new --from-bag``: recordings of both versions of ROS give models that pass ``check``."""

from __future__ import annotations

import random
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from ros_support import Completed

from robosc.errors import UsageError
from robosc.new.from_bag import read
from robosc.simulate.bags.bag_files import opened_bag

rosbag2 = pytest.importorskip("rosbags.rosbag2")
from rosbags.interfaces import (  # noqa: E402
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402

Robosc = Callable[..., Completed]
Topic = tuple[str, str, str]  # name, type, node

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND
TEXT = {"msgdef": "string data\n", "rihs01": "RIHS01_" + "0" * 64, "md5sum": "0" * 32}
"""Definitions are not read: those of the installed packages count."""
DRIVE = [
    ("/drive/goal", "p_msgs/msg/DriveActionGoal", "/rover_controller"),
    ("/drive/result", "p_msgs/msg/DriveActionResult", "/base"),
    ("/drive/feedback", "p_msgs/msg/DriveActionFeedback", "/base"),
    ("/drive/status", "actionlib_msgs/msg/GoalStatusArray", "/base"),
]
ROBOT = [
    ("/scan", "sensor_msgs/msg/LaserScan", "/laser"),
    ("/rover/battery", "sensor_msgs/msg/BatteryState", "/base"),
    ("/rover/arm/command", "std_msgs/msg/Float64", "/teleop"),
    ("/cmd_vel", "geometry_msgs/msg/Twist", "/teleop"),
    ("/rover_controller/state", "std_msgs/msg/String", "/rover_controller"),
    ("/rover_controller/model", "std_msgs/msg/String", "/rover_controller"),
    ("/rover_controller/events", "std_msgs/msg/String", "/rover_controller"),
    ("/tf", "tf2_msgs/msg/TFMessage", "/base"),
]
OF_ROS_2 = [
    ("/drive/_action/feedback", "p_msgs/action/Drive_FeedbackMessage", ""),
    ("/drive/_action/status", "action_msgs/msg/GoalStatusArray", ""),
    ("/reset/_service_event", "std_srvs/srv/Empty_Event", ""),
]
LATCHED = Qos(
    QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL,
    QosTime(0, 0), QosTime(0, 0), QosLiveliness.AUTOMATIC, QosTime(0, 0), False,
)  # fmt: skip


def bag_of_ros_1(folder: Path, topics: Iterable[Topic], seconds: float = 2.0) -> Path:
    """Each topic every 0.1 s; ``/map`` is latched."""
    file = folder / "rover.bag"
    with Writer1(file) as writer:
        for name, type_, node in topics:
            latching = int(name == "/map")
            connection = writer.add_connection(
                name,
                type_,
                msgdef=TEXT["msgdef"],
                md5sum=TEXT["md5sum"],
                callerid=node,
                latching=latching,
            )
            for number in range(int(seconds * 10)):
                writer.write(connection, START + number * SECOND // 10, bytes(8))
    return file


def bag_of_ros_2(folder: Path, topics: Iterable[Topic], storage: str, seconds: float = 2.0) -> Path:
    plugin = rosbag2.StoragePlugin[storage]
    bag = folder / "rover"
    with rosbag2.Writer(bag, version=9, storage_plugin=plugin) as writer:
        for name, type_, _ in topics:
            profiles = [LATCHED] if name == "/map" else []
            connection = writer.add_connection(
                name,
                type_,
                msgdef=TEXT["msgdef"],
                rihs01=TEXT["rihs01"],
                offered_qos_profiles=profiles,
            )
            for number in range(int(seconds * 10)):
                writer.write(connection, START + number * SECOND // 10, bytes(8))
    return bag


@pytest.fixture(autouse=True)
def definitions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The package with the robot's action."""
    package = tmp_path / "ros" / "p_msgs"
    (package / "action").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>p_msgs</name></package>")
    (package / "action" / "Drive.action").write_text("float64 x\n---\n---\n")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))


def model(robosc: Robosc, folder: Path, bag: Path) -> str:
    """The text of the model that is made; it has been checked."""
    done = robosc("new", "Rover", "--from-bag", str(bag.relative_to(folder)))
    assert done.returncode == 0, done.stderr
    checked = robosc("check", "rover.rscd")
    assert checked.stdout.startswith("1 file: 0 errors"), checked.stderr
    assert robosc("format", "--check", "rover.rscd").returncode == 0
    return " ".join((folder / "rover.rscd").read_text(encoding="utf-8").split())


def test_recording_of_ros_1(robosc: Robosc, tmp_path: Path) -> None:
    """The nodes that sent are known; a controller of robosc is no part of the robot."""
    text = model(robosc, tmp_path, bag_of_ros_1(tmp_path, [*ROBOT, *DRIVE]))
    assert text.startswith("// Made from the recording rover.bag: all that")
    assert "component Laser { // node /laser // usually every 0.1 s" in text
    assert 'scan with identifier: "/scan", timeout: 0.3 s, type: sensor_msgs/LaserScan' in text
    assert 'incoming message cmd_vel with identifier: "/cmd_vel", type: geometry_msgs/Twist' in text
    assert "component Drive { // node /base action drive" in text
    assert 'action drive with identifier: "/drive", type: p_msgs/Drive' in text
    assert "rover_controller" not in text and "tf" not in text.split()


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
def test_recording_of_ros_2(robosc: Robosc, tmp_path: Path, storage: str) -> None:
    """Who sent is not known: topics of a namespace are one component."""
    bag = bag_of_ros_2(tmp_path, [*ROBOT, *OF_ROS_2], storage)
    text = model(robosc, tmp_path, bag)
    assert "component Rover_2 { // its node is not known; the topics below /rover" in text
    assert "// a command by its type or name? if it is data of the robot: outgoing" in text
    assert 'incoming message command with identifier: "/rover/arm/command"' in text
    assert 'action drive with identifier: "/drive", type: p_msgs/Drive' in text
    assert 'service reset with identifier: "/reset", type: std_srvs/Empty' in text
    assert "rover_controller" not in text and "_action" not in text
    (file,) = [*bag.glob("*.mcap"), *bag.glob("*.db3")]
    assert read(file) == read(bag)


@pytest.mark.parametrize("storage", ["ROS 1", "MCAP"])
def test_types_that_are_not_defined_here_are_left_out(
    robosc: Robosc, tmp_path: Path, storage: str
) -> None:
    """Recordings are often looked at on another machine than the robot's."""
    foreign = [
        ("/horn", "horn_msgs/msg/Horn", "/horn"),
        ("/scan2", "sensor_msgs/msg/OfTomorrow", "/laser"),
        ("/lift/feedback", "lift_msgs/msg/LiftActionFeedback", "/lift"),
    ]
    topics = [*foreign, *ROBOT]
    ros_1 = storage == "ROS 1"
    bag = bag_of_ros_1(tmp_path, topics) if ros_1 else bag_of_ros_2(tmp_path, topics, storage)
    text = model(robosc, tmp_path, bag)
    assert text.endswith(
        "// packages, or source the workspace that has them, and make the model again."
        " // /scan2: sensor_msgs/OfTomorrow // /lift: lift_msgs/Lift }"
    )
    assert "interface horn_type use Horn from horn_msgs" in text  # as it was recorded


LINE = "=" * 80 + "\n"
HORN = (
    "q_msgs/Tone[] tones\nuint8 LOUD=1\nuint8 state\nstring[2] names\nq_msgs/Nothing nothing\n"
    + LINE + "MSG: q_msgs/Tone\nfloat64 hertz\nq_msgs/Horn owner\n" + LINE + "MSG: q_msgs/Nothing\n"
)  # fmt: skip


@pytest.mark.parametrize("storage", ["ROS 1", "MCAP", "SQLITE3"])
def test_types_that_only_the_recording_has_are_declared(
    robosc: Robosc, tmp_path: Path, storage: str
) -> None:
    topics = [("/horn", "q_msgs/msg/Horn", HORN), ("/bell", "q_msgs/msg/Nothing", "")]
    if storage == "ROS 1":
        topics.append(
            (
                "/go/goal",
                "q_msgs/msg/GoActionGoal",
                "GoGoal goal\n" + LINE + "MSG: q_msgs/GoGoal\nint8 to\n",
            )
        )
        topics.append(
            (
                "/go/result",
                "q_msgs/msg/GoActionResult",
                "GoResult result\n" + LINE + "MSG: q_msgs/GoResult\n",
            )
        )
        writer: Any = Writer1(tmp_path / "rover.bag")
    else:
        topics.append(
            ("/ring/_service_event", "q_msgs/srv/Ring_Event", "bool on\n---\nint8 times\n")
        )
        writer = rosbag2.Writer(
            tmp_path / "rover", version=9, storage_plugin=rosbag2.StoragePlugin[storage]
        )
    with writer:
        for name, type_, text in topics:
            more = {"md5sum": "0" * 32} if storage == "ROS 1" else {"rihs01": TEXT["rihs01"]}
            connection = writer.add_connection(name, type_, msgdef=text, **more)
            for number in range(5):
                writer.write(connection, START + number * SECOND, bytes(8))
    text = model(robosc, tmp_path, writer.path)
    assert (
        'message horn with identifier: "/horn", timeout: 3 s, type: Horn_2 links horn_type' in text
    )
    assert (
        'message bell with identifier: "/bell", timeout: 3 s, type: none links nothing_type' in text
    )
    assert "datatype object Tone { hertz: double }" in text
    assert (
        "datatype object Horn_2 { tones: array(Tone) state: integer names: array(string) }" in text
    )
    assert "interface horn_type use Horn from q_msgs" in text
    if storage == "ROS 1":
        assert (
            'action go with identifier: "/go", request: GoGoal, response: none, feedback: none links go_type'
            in text
        )
    else:
        assert "request: RingRequest, response: RingResponse links ring_type" in text


def test_what_is_left_out_is_told_by_name(robosc: Robosc, tmp_path: Path) -> None:
    topics = [("/horn", "horn_msgs/msg/Horn", "/horn"), ROBOT[0]]
    bag = bag_of_ros_2(tmp_path, topics, "MCAP")
    (file,) = bag.glob("*.mcap")
    content = file.read_bytes()
    file.write_bytes(content.replace(b"string data\n", b"not { of us\n"))
    done = robosc("new", "Rover", "--from-bag", "rover")
    assert done.returncode == 0
    assert "left out, since their types are not defined here: /horn\n" in done.stdout


@pytest.mark.parametrize("version", ["1", "2"])
def test_names_that_ros_does_not_allow_are_left_out(
    robosc: Robosc, tmp_path: Path, version: str
) -> None:
    """Those who write recordings without ROS name topics as they like."""
    wrong = ["/front-laser/scan", '/the "scan"', "/1st/scan", "/scans//all", "/tëst", "/s/{index}"]
    topics = [ROBOT[0], *((name, "sensor_msgs/msg/LaserScan", "") for name in wrong)]
    made = bag_of_ros_1(tmp_path, topics) if version == "1" else (
        bag_of_ros_2(tmp_path, topics, "MCAP")
    )  # fmt: skip
    text = model(robosc, tmp_path, made)
    assert text.count("outgoing message") == 1
    _, _, left_out = text.partition(
        "// Left out, since ROS 1 or ROS 2 does not allow these names: "
    )
    assert all(repr(name) in left_out for name in wrong)


@pytest.mark.parametrize("version", ["1", "2"])
def test_what_is_sent_for_those_who_come_later_has_no_timeout(tmp_path: Path, version: str) -> None:
    topics = [("/map", "nav_msgs/msg/OccupancyGrid", "/maps"), *ROBOT]
    bag = (
        bag_of_ros_1(tmp_path, topics) if version == "1" else bag_of_ros_2(tmp_path, topics, "MCAP")
    )
    graph, pauses, *_ = read(bag)
    assert "/map" in graph.publishers and "/map" not in pauses
    assert pauses["/scan"].longest == pytest.approx(0.1)


def test_pauses_are_measured_at_the_beginning_of_long_recordings(tmp_path: Path) -> None:
    """After a minute a topic ends and another begins: the first is steady, the other has no rate."""
    bag = tmp_path / "rover.bag"
    with Writer1(bag) as writer:
        for name, times in (("/scan", [*range(61), 100]), ("/late", range(61, 70))):
            connection = writer.add_connection(
                name, "std_msgs/msg/Bool", msgdef="bool data\n", md5sum="0" * 32
            )
            for seconds in times:
                writer.write(connection, START + seconds * SECOND, b"\x01")
    graph, pauses, *_ = read(bag)
    assert set(graph.publishers) == {"/scan", "/late"}
    assert {topic: p.longest for topic, p in pauses.items()} == {"/scan": 1.0}


@pytest.mark.ros
def test_recording_by_ros_1_itself(robosc: Robosc, tmp_path: Path) -> None:
    rosbag = pytest.importorskip("rosbag")
    from geometry_msgs.msg import Twist
    from rospy import Time
    from std_msgs.msg import Float32

    with rosbag.Bag(str(tmp_path / "rover.bag"), "w", compression="bz2") as bag:
        for number in range(20):
            bag.write("/distance", Float32(1.0), Time(1000 + number / 4))
            bag.write("/cmd_vel", Twist(), Time(1000 + number / 4))
    text = model(robosc, tmp_path, tmp_path / "rover.bag")
    assert 'identifier: "/distance", timeout: 0.8 s, type: std_msgs/Float32' in text
    assert "requirement cmd_vel needs permitted and distance.fresh" in text


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("nowhere.bag", "cannot read nowhere.bag: there is no such file"),
        ("notes.txt", "notes.txt is no bag: .bag, .mcap, .db3, or the folder of a bag of ROS 2"),
        ("folder", "cannot read folder as a bag of ROS 2: it has no file .mcap or .db3"),
        ("empty.bag", "empty.bag is no file of the format .bag: it is empty"),
        ("text.mcap", "text.mcap is no file of the format .mcap: it was not recorded by ROS"),
        ("folder.bag", "cannot read folder.bag as a bag of ROS 2: it has no file .mcap or .db3"),
    ],
)
def test_what_is_no_bag(robosc: Robosc, tmp_path: Path, name: str, expected: str) -> None:
    for folder in ("folder", "folder.bag"):
        (tmp_path / folder).mkdir()
    for file in ("notes.txt", "text.mcap"):
        (tmp_path / file).write_text("This is no recording.\n" * 20)
    (tmp_path / "empty.bag").touch()
    done = robosc("new", "Rover", "--from-bag", name)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: {expected}")
    assert not (tmp_path / "rover.rscd").exists()


def test_recording_without_a_robot(robosc: Robosc, tmp_path: Path) -> None:
    bag_of_ros_1(tmp_path, [("/rosout", "rosgraph_msgs/msg/Log", "/rosout")])
    done = robosc("new", "Rover", "--from-bag", "rover.bag")
    assert (done.returncode, done.stderr) == (2, "error: rover.bag has no topic of a robot\n")


@pytest.mark.parametrize("kind", ["ROS 1", "MCAP", "SQLITE3"])
def test_damaged_recordings_are_refused_or_read(tmp_path: Path, kind: str) -> None:
    """Cut off anywhere, or with any byte changed: a message, and never another exception."""
    if kind == "ROS 1":
        good = bag_of_ros_1(tmp_path, ROBOT[:3], 0.5)
    else:
        bag = bag_of_ros_2(tmp_path, ROBOT[:3], kind, 0.5)
        (good,) = [*bag.glob("*.mcap"), *bag.glob("*.db3")]
    content = good.read_bytes()
    random_ = random.Random(5)
    damaged = tmp_path / f"damaged{good.suffix}"
    messages = set()
    for _ in range(60):
        place = random_.randrange(len(content))
        changed = bytearray(content)
        changed[place] ^= 1 << random_.randrange(8)
        for text in (content[:place], bytes(changed)):
            damaged.write_bytes(text)
            try:
                read(damaged)
            except UsageError as error:
                messages.add(str(error))
    assert any(re.match(r"cannot read .*: ", message) for message in messages)


def test_without_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The graph needs none; what unpacks messages is rosbags."""
    file = bag_of_ros_1(tmp_path, ROBOT[:3], 0.5)
    monkeypatch.setitem(sys.modules, "rosbags.typesys", None)
    assert "/scan" in read(file).graph.publishers
    with (
        opened_bag(file) as bag,
        pytest.raises(UsageError, match="needs the Python library 'rosbags'"),
    ):
        next(bag.messages(["/scan"], lambda *_: None))
