"""Bags: recordings of ROS 1 (``.bag``) and of ROS 2 (``.mcap``, ``.db3``, their folders), read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from copy import deepcopy
from dataclasses import fields
from pathlib import Path
from typing import Any, Literal

from robosc.errors import UsageError
from robosc.progress import Progress
from robosc.runtime.values import only_field

BEGINNINGS = {".bag": b"#ROSBAG V2", ".mcap": b"\x89MCAP", ".db3": b"SQLite format 3"}
"""How files begin."""
SUFFIXES = frozenset(BEGINNINGS)

_UNFIT = {
    ".active": "its recording was not ended: call 'rosbag reindex' for it, and take .active off its"
    " name",
    ".zstd": "it is a compressed part of a bag: give the folder that it is in",
}
"""What has to be done before a file with such a name can be read."""
_REPAIRS = {
    ".bag": "'rosbag reindex' repairs a recording that was not ended",
    ".mcap": "'mcap recover' repairs a recording that was not ended",
    ".db3": "the command '.recover' of sqlite3 repairs a recording that was not ended",
}


def is_bag(path: str) -> bool:
    """Whether a path names a bag, and no event log."""
    return Path(path).suffix in {*SUFFIXES, *_UNFIT} or Path(path).is_dir()


def is_of_ros_1(path: Path) -> bool:
    return path.suffix == ".bag" and path.is_file()


def target_of(log: str | None) -> Literal["ros1", "ros2"] | None:
    """The version of ROS of a bag; None for another log."""
    if log is None or not is_bag(log):
        return None
    return "ros1" if is_of_ros_1(Path(log)) else "ros2"


def bag_reader(path: Path) -> AbstractContextManager[Any]:
    """The reader of ``rosbags`` for a bag, to be used within :func:`bag_errors`.

    Raises:
        UsageError: the path names no bag.
    """
    from rosbags import rosbag1, rosbag2

    if not path.exists():
        raise UsageError(f"cannot read {path}: there is no such file")
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise UsageError(
            f"cannot read {path} as a bag of ROS 2: it has no metadata.yaml; 'ros2 bag reindex'"
            " makes it of the files of a recording"
        )
    if path.suffix in _UNFIT:
        raise UsageError(f"cannot read {path}: {_UNFIT[path.suffix]}")
    if path.is_file():
        _demand_format(path)
    reader: Any = rosbag1.Reader if is_of_ros_1(path) else rosbag2.Reader
    found: AbstractContextManager[Any] = reader(path)
    return found


def _demand_format(path: Path) -> None:
    """Raises UsageError if a file is no bag, or one of another format than its name says."""
    if path.suffix not in SUFFIXES:
        raise UsageError(f"{path} is no bag: .bag, .mcap, .db3, or the folder of a bag of ROS 2")
    with path.open("rb") as file:
        beginning = file.read(max(map(len, BEGINNINGS.values())))
    if beginning.startswith(BEGINNINGS[path.suffix]):
        return
    found = [s for s, expected in BEGINNINGS.items() if beginning.startswith(expected)]
    what = f"its name should end in {found[0]}" if found else "it was not recorded by ROS"
    if not beginning:
        what = "it is empty"
    raise UsageError(f"{path} is no file of the format {path.suffix}: {what}")


@contextmanager
def bag_errors(path: Path) -> Iterator[None]:
    """Within it, whatever goes wrong is that the bag cannot be read.

    Raises:
        UsageError: the bag cannot be read, or rosbags is not installed.
    """
    try:
        yield
    except UsageError:
        raise
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror or error}") from error
    except ModuleNotFoundError as error:
        raise UsageError(
            f"reading bags needs the Python library {error.name!r}: ./dev setup fetches it, or"
            " pip install rosbags"
        ) from error
    except Exception as error:  # what a library raises for a damaged file is not documented
        repair = _REPAIRS.get(path.suffix, "'ros2 bag reindex' writes its metadata anew")
        what = str(error).partition("\n")[0].rstrip(".:")
        raise UsageError(f"cannot read {path} as a bag: {what}; {repair}") from error


class Bag:
    """A bag that is open. ``topics`` are the types of its topics, ``counts`` its messages, by name.

    Times are in seconds since 1970, as the recorder had them.
    """

    def __init__(self, path: Path, reader: Any) -> None:
        self.path = path
        self._reader = reader
        self.ros_1 = is_of_ros_1(path)
        self.topics: dict[str, str] = {c.topic: _stored(c.msgtype) for c in reader.connections}
        self.types: dict[str, list[str]] = {}
        """All types of each topic."""
        for connection in reader.connections:
            types = self.types.setdefault(connection.topic, [])
            types += [t for t in [_stored(connection.msgtype)] if t not in types]
        self.counts = dict.fromkeys(self.topics, 0)
        for connection in reader.connections:
            self.counts[connection.topic] += connection.msgcount
        self.start, self.end = 0.0, 0.0
        if reader.message_count:
            self.start, self.end = reader.start_time / 1e9, reader.end_time / 1e9
        self._stores: dict[tuple[str, str], Any] = {}

    def messages(
        self, topics: Iterable[str], progress: Progress
    ) -> Iterator[tuple[str, float, Any]]:
        """The messages of some topics in order: topic, time, message.

        Raises:
            UsageError: the bag is damaged.
        """
        wanted = set(topics)
        chosen = [c for c in self._reader.connections if c.topic in wanted]
        most = sum(c.msgcount for c in chosen)
        with bag_errors(self.path):
            reads = {c.id: self._deserialise(self._store(c)) for c in chosen}
            found = self._reader.messages(chosen) if chosen else ()
            for number, (connection, time, raw) in enumerate(found):
                if not number % 256:
                    progress("reading messages", number, most)
                message = _plain(reads[connection.id](raw, _stored(connection.msgtype)))
                yield connection.topic, time / 1e9, message

    def make(self, type_: str) -> Callable[[dict[str, Any]], Any]:
        """A function that makes messages of a type from data, as they would arrive."""

        store = self._store_of(type_)
        return lambda data: self._arrived(_plain(default_message(store, type_)), data)

    def corrected(self, message: Any, data: dict[str, Any]) -> Any:
        """A copy of a message with other fields, as it would arrive."""
        return self._arrived(deepcopy(message), data)

    def _arrived(self, message: Any, data: dict[str, Any]) -> Any:
        fill(message, data)
        type_ = message.__msgtype__
        store = self._store_of(type_)
        pack = store.serialize_ros1 if self.ros_1 else store.serialize_cdr
        raw = pack(_with_arrays(store, message), type_)
        return _plain(self._deserialise(store)(raw, type_))

    def _deserialise(self, store: Any) -> Callable[[Any, str], Any]:
        name = "deserialize_ros1" if self.ros_1 else "deserialize_cdr"
        found: Callable[[Any, str], Any] = getattr(store, name)
        return found

    def _store_of(self, type_: str) -> Any:
        one = next(c for c in self._reader.connections if _stored(c.msgtype) == type_)
        with bag_errors(self.path):
            return self._store(one)

    def _store(self, connection: Any) -> Any:
        """The types of a connection. Each has its own: others may have other definitions of them,
        or some that nobody can read."""
        place = connection.msgtype, connection.msgdef.data
        if place not in self._stores:
            self._stores[place] = _types_of(connection, self.ros_1)
        return self._stores[place]


@contextmanager
def opened_bag(path: Path) -> Iterator[Bag]:
    """A bag, open.

    Raises:
        UsageError: it cannot be read, or rosbags is not installed.
    """
    with bag_errors(path):
        context = bag_reader(path)
        reader = context.__enter__()
    try:
        yield Bag(path, reader)
    finally:
        context.__exit__(None, None, None)


def _stored(type_: str) -> str:
    """The name that rosbags gives a type: that of a service's or action's part gets ``msg``."""
    folder, _, name = type_.rpartition("/")
    return type_ if folder.endswith("/msg") else f"{folder}/msg/{name}"


def _types_of(connection: Any, ros_1: bool) -> Any:
    """The types as they were recorded; without definitions, those of the latest ROS 2."""
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

    defined: dict[str, Any] = {}
    text = connection.msgdef.data
    latest: Any = get_typestore(Stores.LATEST)
    if not text.strip() and _stored(connection.msgtype) in latest.fielddefs:
        pass  # it was recorded without, unless it is one that has no fields there either
    elif connection.msgdef.format == MessageDefinitionFormat.MSG:
        defined.update(get_types_from_msg(text, connection.msgtype))
    elif connection.msgdef.format == MessageDefinitionFormat.IDL:
        line = "=" * 80 + "\n"
        for part in text.split(line)[1:] if text.startswith(line) else [f"\n{text}"]:
            defined.update(get_types_from_idl(part.partition("\n")[2]))
    store: Any = get_typestore(Stores.EMPTY) if defined else latest
    store.register(defined)
    for name, type_ in store.types.items():
        _as_in_ros(name, type_)
    time = store.types.get("builtin_interfaces/msg/Time")
    if ros_1 and time is not None:
        # ROS 1 has other names for these.
        time.secs = property(lambda self: self.sec)
        time.nsecs = property(lambda self: self.nanosec)
    return store


_NO_FIELD = "structure_needs_at_least_one_member"


def _as_in_ros(name: str, type_: Any) -> None:
    """Give a class the names that those of ROS have, by which the runtime knows headers, too."""
    type_.__module__ = name.rpartition("/")[0].replace("/", ".")
    type_.__name__ = name.rpartition("/")[2]
    type_.__slots__ = tuple(f.name for f in fields(type_) if f.name != _NO_FIELD)


def default_message(store: Any, type_: str) -> Any:
    """A message with all fields at their defaults, which are all zeros in the bytes of ROS 1."""
    definition = store.get_msgdef(type_)
    message, _ = definition.deserialize_ros1(bytes(_ENOUGH), 0, definition.cls, store)
    return message


def _plain(message: Any) -> Any:
    """The message with lists, or bytes, in place of arrays: their elements count like those in ROS,
    where a number is one of 64 bits."""
    for name in type(message).__slots__:
        value = getattr(message, name)
        if hasattr(value, "dtype"):
            setattr(message, name, bytes(value) if value.dtype == "uint8" else value.tolist())
        elif hasattr(value, "__msgtype__"):
            _plain(value)
        elif isinstance(value, list):
            for part in value:
                if hasattr(part, "__msgtype__"):
                    _plain(part)
    return message


def _with_arrays(store: Any, message: Any) -> Any:
    """The message with arrays again, as they are packed."""
    for name, blank in vars(default_message(store, message.__msgtype__)).items():
        value = getattr(message, name)
        if hasattr(blank, "dtype"):
            blank.resize(len(value), refcheck=False)
            blank[:] = list(value)
            setattr(message, name, blank)
        elif hasattr(value, "__msgtype__"):
            _with_arrays(store, value)
        elif isinstance(value, list):
            for part in value:
                if hasattr(part, "__msgtype__"):
                    _with_arrays(store, part)
    return message


_ENOUGH = 2**16
"""Bytes of a message whose arrays of any length are empty."""


def fill(message: Any, data: dict[str, Any]) -> None:
    for name, value in data.items():
        name = name or only_field(message)
        name = name if hasattr(message, name) else f"{name}_"
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)
