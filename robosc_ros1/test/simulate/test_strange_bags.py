"""Bags that were recorded in other ways than expected: read as they are, or one clear error each."""

from __future__ import annotations

import os
import shutil
import sqlite3
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore
from simulate.recorded_runs import START, BagWriter
from simulate.test_judged_bags import MODEL

from robosc.errors import UsageError
from robosc.simulate.bags.bag_files import opened_bag
from robosc.simulate.bags.judgement import Judgement, judge
from robosc.supervisor import Supervisor

Make = Callable[[Path], Path]
TWIST, FLOAT, STRING = "geometry_msgs/msg/Twist", "std_msgs/msg/Float32", "std_msgs/msg/String"


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(MODEL.read_text(), str(MODEL))


def written(path: Path, *messages: tuple[str, str, Any], start: float = START) -> Path:
    bag = BagWriter(path, {})
    for number in range(60):
        for topic, type_, data in messages:
            bag.write(topic, type_, start + number * 0.05, data)
    bag.close()
    return bag.path


BELOW = (("/left/distance", FLOAT, {"data": 0.9}), ("/left/vel", TWIST, {}))
RIGHT = (("/distance", FLOAT, {"data": 0.9}), ("/vel", TWIST, {}))


def right(kind: str) -> Make:
    return lambda folder: written(folder / f"run.{kind}", *RIGHT)


def cut(kind: str, part: float) -> Make:
    def make(folder: Path) -> Path:
        whole = written(folder / f"run.{kind}", *RIGHT)
        file = next(whole.glob("*.db3")) if whole.is_dir() else whole
        path = folder / f"cut.{kind}"
        path.write_bytes(file.read_bytes()[: int(file.stat().st_size * part)])
        return path

    return make


def renamed(kind: str, name: str) -> Make:
    def make(folder: Path) -> Path:
        whole = right(kind)(folder)
        file = next(whole.glob("*.db3")) if whole.is_dir() else whole
        return Path(shutil.copy(file, folder / name))

    return make


def text(name: str, content: str = "This is no recording.\n" * 20) -> Make:
    def make(folder: Path) -> Path:
        (folder / name).write_text(content)
        return folder / name

    return make


def changed(change: Callable[[Path], object]) -> Make:
    """The folder of a bag of ROS 2, changed."""

    def make(folder: Path) -> Path:
        bag = right("db3")(folder)
        change(bag)
        return bag

    return make


def of_types(name: str, *types: str) -> Make:
    """A topic with messages of some types, by as many publishers."""

    def make(folder: Path) -> Path:
        store = get_typestore(Stores.ROS2_JAZZY)
        path = folder / "types"
        with rosbag2.Writer(path, version=9) as writer:
            for type_ in types:
                connection = writer.add_connection(name, type_, typestore=store)
                message = store.types[type_](*([""] if type_ == STRING else [0.9]))
                writer.write(connection, int(START * 1e9), store.serialize_cdr(message, type_))
        return path

    return make


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (text("run.bag"), "run.bag is no file of the format .bag: it was not recorded by ROS"),
        (text("run.mcap", ""), "run.mcap is no file of the format .mcap: it is empty"),
        (renamed("bag", "x.mcap"), "no file of the format .mcap: its name should end in .bag"),
        (renamed("mcap", "x.db3"), "no file of the format .db3: its name should end in .mcap"),
        (text("run.mcap", "version https://git-lfs.github.com/spec/v1\noid sha256:00\n"),
         "run.mcap is no file of the format .mcap: it only points to one in Git LFS, which 'git lfs pull'"),
        (cut("db3", 0.2), "cannot read .*: database disk image is malformed; the command '.recover'"),
        (renamed("db3", "run_0.db3.zstd"), "cannot read .*: it is damaged: it cannot be unpacked"),
        (changed(lambda bag: next(bag.glob("*.db3")).unlink()), "run.db3 is missing"),
        (of_types("/distance", STRING),
         r"/distance has messages of std_msgs/String, but the model expects std_msgs/Float32: correct"
         r" the model, or give the name that is meant: --remap /distance:=/OTHER"),
        (of_types("/distance", FLOAT, STRING), "std_msgs/Float32 and std_msgs/String, .* keep only those"),
        (of_types("/grab/_action/status", STRING), "--remap /grab:=/OTHER"),
        (of_types("/left/distance", FLOAT), "--remap /distance:=/left/distance$"),
        (lambda folder: written(folder / "run.bag", *BELOW),
         "give --remap /distance:=/left/distance --remap /vel:=/left/vel$"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_has_one_error_with_a_remedy(
    supervisor: Supervisor, tmp_path: Path, make: Make, expected: str
) -> None:
    path = make(tmp_path)
    with pytest.raises(UsageError, match=expected) as found:
        judge(supervisor, path, (), lambda *_: None)
    assert "\n" not in str(found.value)
    assert str(path) in str(found.value)


def test_a_database_without_messages(supervisor: Supervisor, tmp_path: Path) -> None:
    bag = right("db3")(tmp_path)
    with sqlite3.connect(next(bag.glob("*.db3"))) as database:
        database.execute("drop table messages")
    database.close()
    with pytest.raises(UsageError, match=r"no such table: messages; the command '\.recover'"):
        judge(supervisor, bag, (), lambda *_: None)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (cut("bag", 0.5), "cut.bag is read as far as it goes: it was not ended: it breaks off at byte"),
        (cut("bag", 0.99), "cut.bag is read as far as it goes: it was not ended"),
        (cut("mcap", 0.5), "cut.mcap is read as far as it goes: it was not ended"),
        (cut("mcap", 0.99), "cut.mcap is read as far as it goes: it was not ended"),
        (cut("db3", 0.9), "cut.db3 is read as far as it goes: it is damaged behind row"),
        (renamed("bag", "run.bag.active"), None),
        (changed(lambda bag: (bag / "metadata.yaml").unlink()), "metadata.yaml is missing or damaged"),
        (changed(lambda bag: (bag / "metadata.yaml").write_text("a: [b\n")), "metadata.yaml is missing"),
    ],
)  # fmt: skip
def test_what_can_be_read_is_read(
    supervisor: Supervisor, tmp_path: Path, make: Make, told: str | None
) -> None:
    """The recorder died, or its files were damaged: what they hold is judged, and that is told."""
    found = judged(supervisor, make(tmp_path))
    assert 20 < found.messages <= 120 and found.events >= found.messages / 2
    assert [*map(str, found.notes)] == [] if told is None else found.notes[0].startswith(told)


def judged(supervisor: Supervisor, path: Path) -> Judgement:
    return judge(supervisor, path, (), lambda *_: None)


@pytest.mark.parametrize("mode", [rosbag2.CompressionMode.FILE, rosbag2.CompressionMode.MESSAGE])
def test_a_compressed_bag_of_ros_2(
    supervisor: Supervisor, tmp_path: Path, mode: rosbag2.CompressionMode
) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    path = tmp_path / "compressed"
    writer = rosbag2.Writer(path, version=9)
    writer.set_compression(mode, rosbag2.CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/distance", FLOAT, typestore=store)
        raw = store.serialize_cdr(store.types[FLOAT](0.9), FLOAT)
        for number in range(100):
            writer.write(connection, int((START + number * 0.1) * 1e9), raw)
    found = judged(supervisor, path)
    assert (found.messages, found.exit_code) == (100, 0)


def test_a_number_of_another_size(supervisor: Supervisor, tmp_path: Path) -> None:
    path = written(tmp_path / "run.bag", ("/distance", "std_msgs/msg/Float64", {"data": 0.9}))
    assert judged(supervisor, path).exit_code == 0


def test_two_definitions_of_one_type(supervisor: Supervisor, tmp_path: Path) -> None:
    """As of two publishers of different workspaces; each message is read by its own."""
    path = tmp_path / "run.bag"
    with rosbag1.Writer(path) as writer:
        for number, (kind, pack) in enumerate((("float32", "<f"), ("float64", "<d"))):
            connection = writer.add_connection(
                "/distance", FLOAT, msgdef=f"{kind} data\n", md5sum=str(number) * 32
            )
            writer.write(connection, int((START + number) * 1e9), struct.pack(pack, 0.9))
    found = judged(supervisor, path)
    assert (found.tracks["/distance"].count, found.exit_code) == (2, 0)


@pytest.mark.parametrize("plugin", rosbag2.StoragePlugin)
@pytest.mark.parametrize("definition", ["", "not { a definition"])
def test_definitions_that_are_not_there_or_of_no_use(
    supervisor: Supervisor, tmp_path: Path, plugin: rosbag2.StoragePlugin, definition: str
) -> None:
    """Those that are not there are as in the latest ROS 2; of other topics none is needed."""
    store = get_typestore(Stores.ROS2_JAZZY)
    hash_ = store.hash_rihs01(FLOAT)
    with rosbag2.Writer(tmp_path / "bag", version=9, storage_plugin=plugin) as writer:
        other = writer.add_connection("/odd", "odd/msg/Odd", msgdef=definition, rihs01=hash_)
        writer.write(other, int(START * 1e9), b"\0\1\0\0????")
        connection = writer.add_connection("/distance", FLOAT, msgdef="", rihs01=hash_)
        raw = store.serialize_cdr(store.types[FLOAT](0.9), FLOAT)
        writer.write(connection, int(START * 1e9), raw)
    found = judged(supervisor, tmp_path / "bag")
    assert (found.tracks["/distance"].count, found.exit_code) == (1, 0)


@pytest.mark.parametrize("definition", ["", "byte data\n"])
def test_a_byte_of_ros_2_has_no_sign(tmp_path: Path, definition: str) -> None:
    type_ = "std_msgs/msg/Byte"
    with rosbag2.Writer(tmp_path / "run", version=9) as writer:
        byte = writer.add_connection("/level", type_, msgdef=definition, rihs01="0" * 64)
        writer.write(byte, int(START * 1e9), b"\0\1\0\0\xc8")
    with opened_bag(tmp_path / "run") as bag:
        assert [message.data for *_, message in bag.messages(["/level"], lambda *_: None)] == [200]


def test_the_parts_of_a_split_bag_are_put_together(supervisor: Supervisor, tmp_path: Path) -> None:
    """As the page of the documentation says."""
    parts = [written(tmp_path / f"run_{n}.bag", *RIGHT, start=START + 3.0 * n) for n in range(2)]
    whole = tmp_path / "whole.bag"
    command = [sys.executable, "-m", "rosbags.convert", "--src", *parts, "--dst", whole]
    path = {"PYTHONPATH": str(Path(rosbag2.__file__).parents[2])}
    subprocess.run(command, check=True, env=os.environ | path)
    found = judged(supervisor, whole)
    assert (found.messages, found.exit_code) == (240, 0)


def test_the_library_that_unpacks_is_named_where_it_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A chunk without an index is unpacked when the file is opened: the file is closed again."""
    monkeypatch.setitem(sys.modules, "backports", None)
    monkeypatch.setitem(sys.modules, "compression", None)
    chunk = struct.pack("<QQQII4sQ8x", 0, 0, 100, 0, 4, b"zstd", 8)
    path = tmp_path / "run.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(chunk)) + chunk)
    with (
        pytest.raises(UsageError, match=r"needs the Python library 'backports': .*pip install"),
        opened_bag(path),
    ):
        pass
