"""Bags: recordings of ROS 1 (``.bag``) and of ROS 2 (``.mcap``, ``.db3``, their folders), read."""

from __future__ import annotations

import re
import sqlite3
import struct
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import yaml

from robosc.errors import UsageError
from robosc.progress import Progress
from robosc.simulate.bags import bag_storage, mcap_file, recorded_messages, ros1_file, sqlite_file
from robosc.simulate.bags.selected_fields import Path as FieldPath
from robosc.simulate.bags.storage import Channel, Damaged, Storage, unpack, unpacked_file

BEGINNINGS = {".bag": b"#ROSBAG V2", ".mcap": b"\x89MCAP", ".db3": b"SQLite format 3"}
"""How files begin."""
SUFFIXES = frozenset(BEGINNINGS)
_READERS: dict[str, Callable[[Path], Storage]] = {
    ".bag": ros1_file.Ros1File, ".mcap": mcap_file.McapFile, ".db3": sqlite_file.SqliteFile,
}  # fmt: skip
_PACKED = ".zstd"
_ACTIVE = ".active"
_POINTER = b"version https://git-lfs"
_METADATA = "metadata.yaml"


def is_bag(path: str) -> bool:
    """Whether a path names a bag, and no event log."""
    return Path(path).suffix in {*SUFFIXES, _PACKED, _ACTIVE} or Path(path).is_dir()


def target_of(log: str | None) -> Literal["ros1", "ros2"] | None:
    """The version of ROS of a bag; None for another log.

    Raises:
        UsageError: it cannot be read.
    """
    if log is None or not is_bag(log):
        return None
    with opened_bag(Path(log)) as bag:
        return "ros1" if bag.ros_1 else "ros2"


class Bag:
    """A bag that is open. ``topics`` are the types of its topics, ``counts`` its messages, by name.

    Times are in seconds since 1970, as the recorder had them; where its clock jumped, they go on.
    """

    def __init__(self, path: Path, storage: bag_storage.BagStorage) -> None:
        self.path = path
        self.storage = storage
        self.ros_1 = storage.ros_1
        self.types: dict[str, list[str]] = {}
        """All types of each topic."""
        self.counts: dict[str, int] = defaultdict(int)
        self._numbers = defaultdict[str, "list[int]"](list)
        for number, channel in storage.channels.items():
            self.counts[channel.topic] += storage.counts[number]
        for number, channel in storage.channels.items():
            types = self.types.setdefault(channel.topic, [])
            # One without messages counts only where no other has any.
            if storage.counts[number] or not self.counts[channel.topic]:
                types += [t for t in [recorded_messages.stored(channel.type)] if t not in types]
                self._numbers[channel.topic].append(number)
        self.topics = {topic: types[-1] for topic, types in self.types.items()}
        self.start, self.end = storage.span
        self._types: dict[Channel, recorded_messages.MessageTypes] = {}

    def messages(
        self,
        topics: Iterable[str],
        progress: Progress,
        fields: Mapping[str, Iterable[FieldPath]] = {},
    ) -> Iterator[tuple[str, float, float | None, Any]]:
        """The messages of some topics in order: topic, time, the seconds of the stamp (None: it has
        none), message. Those of topics in ``fields`` may have only the fields at these paths.

        Raises:
            UsageError: one of them cannot be read.
        """
        channels = self.storage.channels
        wanted = [number for topic in topics for number in self._numbers[topic]]
        names = {n: channels[n].topic for n in wanted}
        reads = {
            n: self._types_of(channels[n]).selected(fields.get(names[n]))
            for n in wanted
            if self.storage.counts[n]
        }
        for number, time, raw in self.storage.messages(frozenset(wanted), progress):
            try:
                stamp, message = reads[number](raw)
            except Exception as error:  # rosbags' of what is not in the form of its type
                channel = channels[number]
                raise UsageError(
                    f"cannot read {self.path}: a message of {channel.topic} is no"
                    f" {channel.type} as it was defined there: {_first_line(error)}"
                ) from error
            yield names[number], time, stamp, message

    def make(self, topic: str) -> Callable[[dict[str, Any]], Any]:
        """A function that makes messages of a topic from data, as they would arrive."""
        types = self._types_of(self.storage.channels[self._numbers[topic][-1]])
        blank = types.default()
        return lambda data: types.arrived(blank, data)

    def corrected(self, message: Any, data: dict[str, Any]) -> Any:
        """A copy of a message with other fields, as it would arrive."""
        types = next(t for t in self._types.values() if t.name == message.__msgtype__)
        return types.arrived(message, data)

    def _types_of(self, channel: Channel) -> recorded_messages.MessageTypes:
        """Each channel has its own: others may have other definitions of its types."""
        if channel not in self._types:
            with _reading(self.path):
                self._types[channel] = recorded_messages.MessageTypes(channel)
        return self._types[channel]


@contextmanager
def opened_bag(path: Path) -> Iterator[Bag]:
    """A bag, open.

    Raises:
        UsageError: it cannot be read, or a library for that is not installed.
    """
    with ExitStack() as stack:
        with _reading(path):
            recording = _opened(path, stack)
        yield Bag(path, recording)


# --- files ---------------------------------------------------------------------------------------


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Within it, whatever goes wrong is that the bag cannot be read.

    Raises:
        UsageError: the bag cannot be read, or a library is not installed.
    """
    try:
        yield
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from error
    except ModuleNotFoundError as error:
        library = str(error.name).partition(".")[0]
        raise UsageError(
            f"reading bags needs the Python library {library!r}: ./dev setup fetches it, or"
            " pip install rosbags"
        ) from error
    except sqlite3.Error as error:
        raise UsageError(
            f"cannot read {path}: {_first_line(error)}; the command '.recover' of sqlite3 saves"
            " what can be read of a damaged database"
        ) from error
    except (Damaged, struct.error, LookupError, ValueError, OverflowError) as error:
        raise UsageError(f"cannot read {path}: it is damaged: {_first_line(error)}") from error


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].rstrip(".:")


def _opened(path: Path, stack: ExitStack) -> bag_storage.BagStorage:
    if not path.exists():
        unnamed = path.with_name(path.name + _ACTIVE)
        raise UsageError(
            f"cannot read {path}: there is no such file"
            + f", but {unnamed.name}: rosbag has not completed it" * unnamed.exists()
        )
    if path.is_dir():
        return _folder(path, stack)
    return bag_storage.BagStorage([(path.name, _storage(path, stack))], {})


def _storage(path: Path, stack: ExitStack, *, packed: bool = False) -> Storage:
    """A file of a recording, open; with ``packed`` messages, each is unpacked."""
    kind = path
    if path.suffix == _PACKED:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        kind = folder / path.stem
        unpacked_file(path, kind)
        path = kind
    elif path.suffix == _ACTIVE:
        kind = path.with_suffix("")
    _demand_format(path, kind.suffix)
    storage = _READERS[kind.suffix](path)
    stack.callback(storage.close)
    return _PackedMessages(storage) if packed else storage


class _PackedMessages:
    """A file whose messages are compressed one by one."""

    def __init__(self, storage: Storage) -> None:
        self._storage = storage
        self.contents = storage.contents
        self.load = storage.load
        self.close = storage.close

    def message(self, chunk: Any, place: int) -> bytes:
        raw = self._storage.message(chunk, place)
        return unpack("zstd", raw, len(raw))


def _demand_format(path: Path, suffix: str) -> None:
    """Raises UsageError if a file is no bag, or one of another format than its name says."""
    if suffix not in SUFFIXES:
        raise UsageError(f"{path} is no bag: .bag, .mcap, .db3, or the folder of a bag of ROS 2")
    with path.open("rb") as file:
        beginning = file.read(max(map(len, (*BEGINNINGS.values(), _POINTER))))
    if beginning.startswith(BEGINNINGS[suffix]):
        return
    found = [s for s, expected in BEGINNINGS.items() if beginning.startswith(expected)]
    what = f"its name should end in {found[0]}" if found else "it was not recorded by ROS"
    if not beginning:
        what = "it is empty"
    if beginning == _POINTER:
        what = "it only points to one in Git LFS, which 'git lfs pull' fetches"
    raise UsageError(f"{path} is no file of the format {suffix}: {what}")


def _folder(folder: Path, stack: ExitStack) -> bag_storage.BagStorage:
    """The recording in the folder of a bag of ROS 2; what its metadata.yaml does not tell, its
    files do."""
    notes, missing = [], []
    description = _description(folder)
    if description is None:
        notes.append(f"{_METADATA} is missing or damaged: all files of the folder are read")
        description = {}
    told = [Path(str(name)).name for name in description.get("relative_file_paths") or ()]
    names = list(dict.fromkeys(told)) or _files_in(folder)
    there = [name for name in names if (folder / name).exists()]
    if not there:
        raise UsageError(
            f"cannot read {folder} as a bag of ROS 2: " + (f"{names[0]} is missing" if names else
            "it has no file .mcap or .db3")
        )  # fmt: skip
    absent = [name for name in names if name not in there]
    if absent:
        # What follows a gap is judged in a state that nobody knows.
        begin = names.index(there[0])
        end = next((n for n in range(begin, len(names)) if names[n] not in there), len(names))
        there = names[begin:end]
        missing.append(
            f"{', '.join(absent)} is not in the folder: only {', '.join(there)} could be read"
        )
    packed = str(description.get("compression_mode") or "").lower() == "message"
    files = [(name, _storage(folder / name, stack, packed=packed)) for name in there]
    promised = {} if absent else _promised(description)
    return bag_storage.BagStorage(files, promised, notes=notes, missing=missing)


def _promised(description: dict[str, Any]) -> dict[str, int]:
    """The number of messages of each topic; empty if it is not told, or in another way."""
    try:
        topics = description["topics_with_message_count"]
        return {t["topic_metadata"]["name"]: int(t["message_count"]) for t in topics}
    except (KeyError, TypeError, ValueError):
        return {}


def _description(folder: Path) -> dict[str, Any] | None:
    """What metadata.yaml says; None if there is none, or none that can be read."""
    try:
        text = (folder / _METADATA).read_text(encoding="utf-8", errors="replace")
        found = yaml.safe_load(text)["rosbag2_bagfile_information"]
    except (FileNotFoundError, yaml.YAMLError, KeyError, TypeError):
        return None
    return found if isinstance(found, dict) else None


def _files_in(folder: Path) -> list[str]:
    """The files of a recording in a folder, in the order of their numbers."""
    names = [
        file.name
        for file in folder.iterdir()
        if Path(file.name.removesuffix(_PACKED)).suffix in (".mcap", ".db3")
    ]
    return sorted(
        names, key=lambda n: [int(p) if p.isdigit() else p for p in re.split(r"(\d+)", n)]
    )
