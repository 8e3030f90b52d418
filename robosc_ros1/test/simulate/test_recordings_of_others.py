"""Recordings as other recorders, converters and crashes leave them: each judged like the same run
recorded well, and what is special about it is told."""

from __future__ import annotations

import shutil
import sqlite3
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from rosbags import rosbag1, rosbag2
from simulate.recorded_runs import START, BagWriter

from robosc.errors import UsageError
from robosc.simulate.bags.bag_files import target_of
from robosc.simulate.bags.judgement import Judgement, judge
from robosc.simulate.bags.judgement_report import judgement_junit, judgement_text
from robosc.supervisor import Supervisor

SECOND = 1_000_000_000
BEGIN = int(START) * SECOND
MODEL = """
robot Rover {
    component Laser {
        outgoing message distance with identifier: "/distance", timeout: 1 s, type: std_msgs/Float32
        behaviour {
            variable d: double = 0.0
            initial marked state on { on response from distance do d := value.data }
        }
    }
    component Motor {
        incoming message move with identifier: "/cmd_vel", type: geometry_msgs/Twist
    }
    requirement move needs distance.fresh and Laser.d > 0.5
    provide move with { linear: { x: 0.2 } }
}
"""
TWIST = """geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
VECTOR_IDL = "struct Vector3 { double x; double y, z; };"
TWIST_IDL = f"""================================================================================
IDL: geometry_msgs/msg/Twist
#include "geometry_msgs/msg/Vector3.idl"
module geometry_msgs {{ module msg {{ struct Twist {{
    geometry_msgs::msg::Vector3 linear; geometry_msgs::msg::Vector3 angular; }}; }}; }};
================================================================================
IDL: geometry_msgs/msg/Vector3
module geometry_msgs {{ module msg {{ {VECTOR_IDL} }}; }};
"""


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(MODEL, "rover.rscd")


def judged(supervisor: Supervisor, path: Path) -> Judgement:
    return judge(supervisor, path, (), lambda *_: None)


# --- a run, and MCAP files with it ---------------------------------------------------------------


@dataclass(frozen=True)
class Message:
    topic: str
    time: int
    raw: bytes


def run(start: int = BEGIN) -> list[Message]:
    """Three seconds in the open, then three near a wall, in which it goes on: one fault."""
    messages = []
    for number in range(60):
        time = start + number * SECOND // 10
        distance = struct.pack("<f", 1.0 if number < 30 else 0.3)
        messages.append(Message("/distance", time, b"\0\1\0\0" + distance))
        twist = struct.pack("<6d", 0.2, 0, 0, 0, 0, 0)
        messages.append(Message("/cmd_vel", time + SECOND // 20, b"\0\1\0\0" + twist))
    return messages


def text(content: str | bytes) -> bytes:
    raw = content.encode() if isinstance(content, str) else content
    return struct.pack("<I", len(raw)) + raw


def record(code: int, content: bytes) -> bytes:
    return struct.pack("<BQ", code, len(content)) + content


@dataclass
class Mcap:
    """A file, written from the specification of the format."""

    profile: str = "ros2"
    encoding: str = "cdr"
    schema: str = "ros2msg"
    types: Sequence[str] = ("std_msgs/msg/Float32", "geometry_msgs/msg/Twist")
    definitions: Sequence[str] = ("float32 data\n", TWIST)
    topics: Sequence[str] = ("/distance", "/cmd_vel")
    messages: list[Message] = field(default_factory=run)
    chunks: int = 3
    is_indexed: bool = True
    repeats: bool = True
    """The channels at the end, and how many messages there are."""
    foreign: bool = False
    promised: int | None = None

    def write(self, path: Path) -> Path:
        described = b""
        for number, (type_, definition) in enumerate(
            zip(self.types, self.definitions, strict=True), 1
        ):
            schema = "ros2idl" if "IDL: " in definition else self.schema
            content = struct.pack("<H", number) + text(type_) + text(schema) + text(definition)
            described += record(3, content)
            head = struct.pack("<HH", number, number)
            topic = self.topics[number - 1]
            described += record(4, head + text(topic) + text(self.encoding) + text(b""))
        if self.foreign:
            described += record(
                3, struct.pack("<H", 9) + text("Log") + text("jsonschema") + text("{}")
            )
            described += record(
                4, struct.pack("<HH", 9, 9) + text("/log") + text("json") + text(b"")
            )
        body = record(1, text(self.profile) + text("test"))
        parts = max(1, self.chunks)
        size = -(-len(self.messages) // parts)
        for part in range(parts):
            body += self._part(described if not part else b"", self.messages[part * size :][:size])
        body += record(15, bytes(4))
        summary = b""
        if self.repeats:
            counts = {
                n: sum(m.topic == t for m in self.messages) for n, t in enumerate(self.topics, 1)
            }
            counts[1] = self.promised or counts[1]
            listed = b"".join(struct.pack("<HQ", *pair) for pair in counts.items())
            fixed = struct.pack("<QHIIIIQQ", sum(counts.values()), 2, 2, 0, 0, 0, 0, 0)
            summary = described + record(11, fixed + text(listed))
        begin = len(body) + 8 if summary else 0
        path.write_bytes(
            b"\x89MCAP0\r\n" + body + summary + record(2, struct.pack("<QQI", begin, 0, 0))
            + b"\x89MCAP0\r\n"
        )  # fmt: skip
        return path

    def _part(self, described: bytes, messages: list[Message]) -> bytes:
        content = described
        places: dict[int, list[tuple[int, int]]] = {}
        for message in messages:
            channel = self.topics.index(message.topic) + 1
            places.setdefault(channel, []).append((message.time, len(content)))
            raw = message.raw if self.encoding == "cdr" else message.raw[4:]
            head = struct.pack("<HIQQ", channel, 0, message.time, message.time)
            content += record(5, head + raw)
            if self.foreign:
                head = struct.pack("<HIQQ", 9, 0, message.time, message.time)
                content += record(5, head + b"{}")
        if not self.chunks:
            return content
        times = [message.time for message in messages]
        head = struct.pack("<QQQI", min(times), max(times), len(content), 0)
        chunk = record(6, head + text("") + struct.pack("<Q", len(content)) + content)
        if not self.is_indexed:
            return chunk
        for channel, entries in places.items():
            listed = b"".join(struct.pack("<QQ", *entry) for entry in entries)
            chunk += record(7, struct.pack("<H", channel) + text(listed))
        return chunk


CRLF = ("# distance\r\nfloat32 data\r\n", TWIST)
LOWER = ("uint8 left=0\nuint8 right = 1\nfloat32 data\n", TWIST)
WIDE = ('float32 data\nstring<=5 unit "m"\nuint8[<=3] x [1, 2]\nwstring<=4 w\n', TWIST)
OF_WIDE = struct.pack("<I2sxxI2sxxI", 2, b"m\0", 2, b"\1\2", 0)


def widened() -> list[Message]:
    """Messages with more fields behind the distance."""
    return [
        replace(m, raw=m.raw + OF_WIDE) if m.topic == "/distance" else m for m in run()
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("bag", "told"),
    [
        (Mcap(), ()),
        (Mcap(repeats=False), ()),
        (Mcap(repeats=False, is_indexed=False), ()),
        (Mcap(chunks=0), ()),
        (Mcap(chunks=0, repeats=False), ()),
        (Mcap(profile=""), ()),
        (Mcap(foreign=True), ("left out, since it is not in a form of ROS: /log (json)",)),
        (Mcap(foreign=True, is_indexed=False, repeats=False),
         ("left out, since it is not in a form of ROS: /log (json)",)),
        (Mcap("ros1", "ros1", "ros1msg", ("std_msgs/Float32", "geometry_msgs/Twist")), ()),
        (Mcap("", "ros1", "ros1msg", ("std_msgs/Float32", "geometry_msgs/Twist")), ()),
        (Mcap(topics=("distance", "cmd_vel"),
              messages=[replace(m, topic=m.topic[1:]) for m in run()]), ()),
        (Mcap(definitions=CRLF), ()),
        (Mcap(definitions=LOWER), ()),
        (Mcap(definitions=WIDE, messages=widened()), ()),
        (Mcap(definitions=("float32 data", TWIST_IDL)), ()),
        (Mcap(definitions=("", ""), schema=""), ()),
    ],
)  # fmt: skip
def test_mcap_files_of_other_writers(
    supervisor: Supervisor, tmp_path: Path, bag: Mcap, told: Sequence[str]
) -> None:
    path = bag.write(tmp_path / "run.mcap")
    found = judged(supervisor, path)
    (finding,) = found.findings
    assert (finding.name, round(finding.time - START, 3), finding.count) == ("move", 3.05, 30)
    assert (found.messages, found.events, found.notes, found.missing) == (120, 120, told, ())
    assert found.ros == (1 if bag.encoding == "ros1" else 2)
    assert target_of(str(path)) == f"ros{found.ros}"


@pytest.mark.parametrize("chunks", [0, 1, 7])
@pytest.mark.parametrize("is_indexed", [True, False])
def test_a_file_that_breaks_off_anywhere(
    supervisor: Supervisor, tmp_path: Path, chunks: int, is_indexed: bool
) -> None:
    """Every whole message before that place is read, and no other."""
    whole = Mcap(chunks=chunks, is_indexed=is_indexed, repeats=False).write(tmp_path / "run.mcap")
    content = whole.read_bytes()
    places = [content.index(m.raw, 0) for m in run()[:2]]
    assert places[0] > 0
    for part in (0.3, 0.5, 0.77, 0.9):
        cut = content[: int(len(content) * part)]
        (tmp_path / "cut.mcap").write_bytes(cut)
        found = judged(supervisor, tmp_path / "cut.mcap")
        heads = [struct.pack("<QQ", m.time, m.time) + m.raw for m in run()]
        assert found.messages == sum(head in cut for head in heads)
        (note,) = found.notes
        assert note.startswith(
            "cut.mcap is read as far as it goes: it was not ended: it breaks off"
        )


def test_a_channel_of_another_type_without_messages(supervisor: Supervisor, tmp_path: Path) -> None:
    bag = Mcap(
        types=("std_msgs/msg/Float32", "geometry_msgs/msg/Twist", "std_msgs/msg/String"),
        definitions=("float32 data", TWIST, "string data"),
        topics=("/distance", "/cmd_vel", "/distance"),
    )
    assert len(judged(supervisor, bag.write(tmp_path / "run.mcap")).findings) == 1


def test_fewer_messages_than_a_file_states(supervisor: Supervisor, tmp_path: Path) -> None:
    found = judged(supervisor, Mcap(promised=200).write(tmp_path / "run.mcap"))
    assert found.missing == ("fewer messages than the recording states: /distance (60 of 200)",)


# --- folders -------------------------------------------------------------------------------------


def folder(tmp_path: Path, kind: str, parts: int = 1) -> Path:
    """The folder of a bag with the run; split into parts."""
    messages = run()
    size = len(messages) // parts
    target = tmp_path / "run"
    for part in range(parts):
        writer = BagWriter(tmp_path / f"part{part}.{kind}", {})
        for message in messages[part * size :][:size]:
            values = struct.unpack("<f" if message.topic == "/distance" else "<6d", message.raw[4:])
            type_, data = "std_msgs/msg/Float32", {"data": values[0]}
            if message.topic == "/cmd_vel":
                type_, data = "geometry_msgs/msg/Twist", {"linear": {"x": values[0]}}  # type: ignore[dict-item]
            writer.write(message.topic, type_, message.time / SECOND, data)
        writer.close()
        own = tmp_path / f"part{part}"
        if not part:
            own.rename(target)
            (file,) = target.glob(f"*.{kind}")
            file.rename(target / f"run_0.{kind}")
        else:
            (file,) = own.glob(f"*.{kind}")
            file.rename(target / f"run_{part}.{kind}")
    lines = (target / "metadata.yaml").read_text().splitlines()
    found = []
    for line in lines:
        if line.strip() in (f"- part0.{kind}", f"- run.{kind}"):
            line = "\n".join(f"{line.partition('-')[0]}- run_{n}.{kind}" for n in range(parts))
        found.append(line.replace("message_count: 60", f"message_count: {60}"))
    changed = "\n".join(found)
    if parts > 1:
        changed = changed.replace(f"message_count: {60 // parts}", "message_count: 60")
    (target / "metadata.yaml").write_text(changed)
    return target


def edited(*changes: tuple[str, str]) -> Callable[[Path], None]:
    """Change what metadata.yaml says."""

    def change(bag: Path) -> None:
        content = (bag / "metadata.yaml").read_text()
        for old, new in changes:
            assert old in content, content
            content = content.replace(old, new)
        (bag / "metadata.yaml").write_text(content)

    return change


def listed_twice(bag: Path) -> None:
    """Let metadata.yaml name its file a second time."""
    content = (bag / "metadata.yaml").read_text()
    (line,) = (one for one in content.splitlines(keepends=True) if "- run_0." in one)
    (bag / "metadata.yaml").write_text(content.replace(line, 2 * line))


QOS = """offered_qos_profiles:
      - history: keep_last
        depth: 3
        reliability: best_effort
        durability: volatile
        deadline: {sec: 0, nsec: 0}
        lifespan: {sec: 0, nsec: 0}
        liveliness: automatic
        liveliness_lease_duration: {sec: 0, nsec: 0}
        avoid_ros_namespace_conventions: false"""


@pytest.mark.parametrize("kind", ["mcap", "db3"])
@pytest.mark.parametrize(
    "change",
    [
        edited(("offered_qos_profiles: []", QOS)),
        edited(("version: 9", "version: 23")),
        edited(("storage_identifier: mcap", 'storage_identifier: ""')),
        edited(("message_count: 60", "message_count: 5")),
        edited(("topics_with_message_count:", "topics_in_another_way:")),
        listed_twice,
        lambda bag: (bag / "metadata.yaml").unlink(),
    ],
)  # fmt: skip
def test_folders_whose_description_differs_from_their_files(
    supervisor: Supervisor, tmp_path: Path, kind: str, change: Callable[[Path], None]
) -> None:
    bag = folder(tmp_path, kind)
    if kind == "db3":
        edited(("storage_identifier: sqlite3", "storage_identifier: mcap"))(bag)
    change(bag)
    found = judged(supervisor, bag)
    assert (found.messages, found.events, len(found.findings)) == (120, 120, 1)
    assert not found.missing


@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_a_description_that_promises_more_than_there_is(
    supervisor: Supervisor, tmp_path: Path, kind: str
) -> None:
    bag = folder(tmp_path, kind)
    edited(("message_count: 60", "message_count: 80"))(bag)
    found = judged(supervisor, bag)
    lacking = "fewer messages than the recording states: /cmd_vel (60 of 80), /distance (60 of 80)"
    assert (found.missing, found.exit_code) == ((lacking,), 1)


@pytest.mark.parametrize("kind", ["mcap", "db3"])
@pytest.mark.parametrize(("gone", "read", "code"), [(1, 40, 2), (0, 80, 1), (2, 80, 1)])
def test_a_file_of_several_is_missing(
    supervisor: Supervisor, tmp_path: Path, kind: str, gone: int, read: int, code: int
) -> None:
    """What lies behind the gap is not judged: nobody knows the state in which it began."""
    bag = folder(tmp_path, kind, parts=3)
    assert judged(supervisor, bag).messages == 120
    (bag / f"run_{gone}.{kind}").unlink()
    found = judged(supervisor, bag)
    assert (found.messages, found.exit_code) == (read, code)
    (missing,) = found.missing
    assert missing.startswith(f"run_{gone}.{kind} is not in the folder: only run_")


def test_what_a_recorder_had_not_yet_put_into_its_database(
    supervisor: Supervisor, tmp_path: Path
) -> None:
    """One that died leaves the last messages in a file beside it."""
    (file,) = folder(tmp_path, "db3").glob("*.db3")
    database = sqlite3.connect(file)
    database.execute("PRAGMA journal_mode = WAL")
    database.execute("PRAGMA wal_autocheckpoint = 0")
    database.execute("UPDATE messages SET timestamp = timestamp + 1000000000")
    database.commit()
    crashed = tmp_path / "crashed"
    crashed.mkdir()
    for part in file.parent.glob("*.db3*"):
        shutil.copy(part, crashed)
    database.close()
    assert [*crashed.glob("*-wal")]
    found = judged(supervisor, crashed)
    assert (found.messages, found.start) == (120, START + 1)


def test_bags_of_ros_1_without_an_index(supervisor: Supervisor, tmp_path: Path) -> None:
    """As the recorder leaves it when it dies: its head tells of no index, and there is none."""
    path = tmp_path / "run.bag"
    writer = rosbag1.Writer(path)
    writer.set_compression(writer.CompressionFormat.BZ2)
    writer.chunk_threshold = 1000
    with writer:
        ways = {}
        for topic, type_, definition in (
            ("/distance", "std_msgs/msg/Float32", "float32 data\n"),
            ("/cmd_vel", "geometry_msgs/msg/Twist", TWIST),
        ):
            ways[topic] = writer.add_connection(topic, type_, msgdef=definition, md5sum="0" * 32)
        for message in run():
            writer.write(ways[message.topic], message.time, message.raw[4:])
    content = path.read_bytes()
    place = content.index(b"index_pos=") + len(b"index_pos=")
    (index,) = struct.unpack_from("<Q", content, place)
    died = content[:place] + bytes(8) + content[place + 8 : index]
    (tmp_path / "run.bag.active").write_bytes(died)
    assert judged(supervisor, path).messages == 120
    found = judged(supervisor, tmp_path / "run.bag.active")
    assert (found.messages, len(found.findings)) == (120, 1)
    assert found.notes[0].startswith("run.bag.active is read as far as it goes: it was not ended")


# --- times ---------------------------------------------------------------------------------------


def moved(numbers: Sequence[int], by: float) -> list[Message]:
    """The run, some of whose messages the recorder's clock gave other times."""
    chosen = set(numbers)
    return [
        replace(m, time=max(0, min(2**64 - 1, m.time + int(by * SECOND)))) if n in chosen else m
        for n, m in enumerate(run())
    ]


JUMPS = {
    "two messages in 1970": moved([50, 51], -1e12),
    "the first message in 1970": moved([0], -1e12),
    "two messages at the greatest time": moved([50, 51], 1e12),
    "a message in 2182": moved([100], 5e9),
    "the last two in 2182": moved([118, 119], 5e9),
    "the clock is set from 1970 to now": moved(range(40), -START),
    "the clock is set back by half an hour": moved(range(70, 120), -1800),
    "the clock is set back by three seconds": moved(range(70, 120), -3),
    "the clock is set back for a while": moved(range(20, 40), -1800),
    "a pause of a day": moved(range(70, 120), 86_400),
}


@pytest.mark.parametrize("kind", ["chunks", "no chunks", "a chunk for each"])
@pytest.mark.parametrize("name", JUMPS)
def test_times_that_jump(supervisor: Supervisor, tmp_path: Path, name: str, kind: str) -> None:
    """Time goes on from there: the topic did not fall silent, and nothing else is found."""
    chunks = {"chunks": 3, "no chunks": 0, "a chunk for each": 120}[kind]
    found = judged(
        supervisor, Mcap(messages=JUMPS[name], chunks=chunks).write(tmp_path / "run.mcap")
    )
    assert [(f.sort, f.name, f.count) for f in found.findings] == [("violation", "move", 30)]
    assert not found.silences
    assert 5.5 < found.end - found.start < 6.0
    assert found.notes[0].startswith("the recorded times jump by ")
    assert found.events == 120


@pytest.mark.parametrize(
    ("start", "told"),
    [
        (0, "the recorded times begin at 1970-01-01: simulated time, or a clock that was not set"),
        (BEGIN * 4, "the recorded times lie in the future: they begin at 2185-"),
    ],
)
def test_times_that_lie_elsewhere(
    supervisor: Supervisor, tmp_path: Path, start: int, told: str
) -> None:
    found = judged(supervisor, Mcap(messages=run(start)).write(tmp_path / "run.mcap"))
    (note,) = found.notes
    assert note.startswith(told)
    assert [f.count for f in found.findings] == [30]


def test_a_file_that_was_written_topic_by_topic(supervisor: Supervisor, tmp_path: Path) -> None:
    """As converters do: nothing jumps, and the messages are put in order."""
    messages = sorted(run(), key=lambda m: m.topic)
    found = judged(supervisor, Mcap(messages=messages).write(tmp_path / "run.mcap"))
    assert (found.notes, [f.count for f in found.findings]) == ((), [30])


# --- no evidence ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("messages", "reason"),
    [
        ([], "nothing could be judged: there is no message of /distance, /cmd_vel"),
        (run()[:1], None),
    ],
)
def test_no_evidence_is_no_success(
    supervisor: Supervisor, tmp_path: Path, messages: list[Message], reason: str | None
) -> None:
    path = Mcap(messages=messages, chunks=0).write(tmp_path / "run.mcap")
    if reason is None:
        assert judged(supervisor, path).exit_code == 0
        return
    with pytest.raises(UsageError, match=reason):
        judged(supervisor, path)


def test_the_readers_agree_with_rosbags(tmp_path: Path) -> None:
    """Another reader of the same files finds the same messages."""
    from robosc.simulate.bags.bag_files import opened_bag

    for kind in ("mcap", "db3"):
        path = folder(tmp_path / kind, kind, parts=3)
        with rosbag2.Reader(path) as reader:
            expected = [(c.topic, t / SECOND, bytes(raw)) for c, t, raw in reader.messages()]
        with opened_bag(path) as bag:
            numbers = bag.storage.channels
            read = [
                (numbers[n].topic, t, raw)
                for n, t, raw in bag.storage.messages(numbers, lambda *_: None)
            ]
        assert read == expected and len(read) == 120


def test_what_could_not_be_read_fails_a_test_case(supervisor: Supervisor, tmp_path: Path) -> None:
    lawful = [m for m in run() if m.time < BEGIN + 3 * SECOND]
    for promised, failures in ((None, "0"), (200, "1")):
        path = Mcap(messages=lawful, promised=promised).write(tmp_path / "run.mcap")
        found = judged(supervisor, path)
        suite = ElementTree.fromstring(judgement_junit(found))
        assert suite.get("failures") == failures
        assert found.exit_code == (2 if promised else 0)
        text = judgement_text(found)
        assert ("as far as the recording could be read" in text) is bool(promised)
