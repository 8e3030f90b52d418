"""Recorded messages, read with the definitions that were recorded with them.

The project's own readers of definitions take what ROS takes; rosbags gets the types in its own
form, and unpacks the messages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from dataclasses import fields
from functools import partial
from typing import Any

from robosc.errors import UsageError
from robosc.model.ros import interfaces, recorded
from robosc.runtime.core import ages, values
from robosc.simulate.bags.selected_fields import TIME, Definitions, Path, Selected, selecting
from robosc.simulate.bags.storage import Channel

_NO_FIELD = "structure_needs_at_least_one_member"
_IN_ROS_1 = {
    "byte": "int8", "char": "uint8", "time": "builtin_interfaces/Time",
    "duration": "builtin_interfaces/Duration",
}  # fmt: skip
"""What rosbags calls types of ROS 1."""
_PARTS_OF_TIMES = {"secs": "sec", "nsecs": "nanosec"}


def stored(type_: str) -> str:
    """The name that rosbags gives a type: that of a service's or action's part gets ``msg``."""
    folder, _, name = type_.rpartition("/")
    return type_ if folder.endswith("/msg") else f"{folder}/msg/{name}"


class MessageTypes:
    """The types of a channel's messages."""

    def __init__(self, channel: Channel) -> None:
        from rosbags.typesys import Stores, get_typestore

        self.name = stored(channel.type)
        self.is_ros_1 = channel.encoding == "ros1"
        latest: Any = get_typestore(Stores.ROS1_NOETIC if self.is_ros_1 else Stores.LATEST)
        known = latest.fielddefs
        wanted: dict[str, Any] = {}
        self._wide: dict[str, list[str]] = {}
        if channel.definition.strip() or self.name not in known:
            found = {} if not channel.schema else _definitions(channel)
            own = f"{channel.type.partition('/')[0]}/{channel.type.rpartition('/')[2]}"
            if own not in found:
                raise UsageError(
                    f"{channel.topic}: its type {channel.type} is recorded without its definition"
                )
            for name, definition in found.items():
                of_rosbags = self.name if name == own else _message(name)
                wanted[of_rosbags] = ([], [*self._fields(of_rosbags, definition)])
        else:
            wanted[self.name] = known[self.name]
        self.store: Any = get_typestore(Stores.EMPTY)
        types = _with_needed(wanted, known, channel)
        self.store.register(types if self.is_ros_1 else _with_unsigned_bytes(types))
        for name, type_ in self.store.types.items():
            _as_in_ros(name, type_)
        if self.is_ros_1:
            self._name_times()
        self._steps = _PlainTypes(self.store, self._wide).of(self.name)
        deserialise = self.store.deserialize_ros1 if self.is_ros_1 else self.store.deserialize_cdr
        self._deserialise: Callable[[bytes, str], Any] = deserialise

    def read(self, raw: bytes) -> Any:
        """A message, as it would arrive."""
        return _apply(self._steps, self._deserialise(raw, self.name))

    def selected(self, paths: Iterable[Path] | None) -> Selected:
        """What reads messages with the fields at some paths, if they can be read without all others
        (None: all are wanted)."""
        from rosbags.interfaces import Nodetype

        known = Definitions(self.store.fielddefs, Nodetype, self._wide, self.is_ros_1)
        quick = None if paths is None else selecting(known, self.name, paths)

        def whole(raw: bytes) -> tuple[float | None, Any]:
            message = self.read(raw)
            return stamp_of(message), message

        def read(raw: bytes) -> tuple[float | None, Any]:
            try:
                return quick(raw)  # type: ignore[misc]
            except Exception:  # the reader of the whole says what is wrong
                return whole(raw)

        return read if quick else whole

    def default(self) -> Any:
        """A message with all fields at their defaults. From now on its class can be called without
        arguments, as those of ROS can: so the runtime learns which fields messages have."""
        message = default_message(self.store, self.name)
        type(message).__init__.__defaults__ = tuple(vars(message).values())
        return _apply(self._steps, message)

    def arrived(self, message: Any, data: dict[str, Any]) -> Any:
        """The message with other fields, as it would arrive."""
        message = deepcopy(message)
        fill(self.store, message, data)
        pack = self.store.serialize_ros1 if self.is_ros_1 else self.store.serialize_cdr
        return self.read(bytes(pack(_with_arrays(self.store, message, self._wide), self.name)))

    def _fields(self, name: str, definition: interfaces.Definition) -> list[tuple[str, Any]]:
        if not definition.fields and not self.is_ros_1:
            return [(_NO_FIELD, _single("uint8"))]
        wide = [f.name for f in definition.fields if f.type.wide and not f.type.is_array]
        if wide:
            self._wide[name] = wide
        return [(field.name, self._type(field.type)) for field in definition.fields]

    def _type(self, type_: interfaces.FieldType) -> Any:
        from rosbags.interfaces import Nodetype

        base = _IN_ROS_1.get(type_.base, type_.base) if self.is_ros_1 else type_.base
        element = (Nodetype.NAME, _message(base)) if "/" in base else _single(base)
        if type_.wide:  # a sequence of characters, which rosbags does not know
            element = (Nodetype.SEQUENCE, (_single("uint32"), 0))
        if not type_.is_array:
            return element
        if type_.length is None:
            return (Nodetype.SEQUENCE, (element, 0))
        return (Nodetype.ARRAY, (element, type_.length))

    def _name_times(self) -> None:
        """ROS 1 has other names for the parts of times."""
        for name in ("Time", "Duration"):
            type_ = self.store.types.get(f"builtin_interfaces/msg/{name}")
            if type_ is not None:
                type_.secs = property(lambda self: self.sec)
                type_.nsecs = property(lambda self: self.nanosec)


def stamp_of(message: Any) -> float | None:
    """The seconds of a message's stamp; None if it has none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return ages.seconds_of(stamp) or None if getattr(stamp, "__msgtype__", "") == TIME else None


def _definitions(channel: Channel) -> Mapping[str, interfaces.Definition]:
    try:
        return recorded.definitions(channel.definition, channel.type, channel.schema)
    except ValueError as error:
        raise UsageError(f"{channel.topic}: {error}") from None


def _with_unsigned_bytes(types: dict[str, Any]) -> dict[str, Any]:
    """The types of ROS 2: the bytes of those that rosbags knows itself have a sign, as in ROS 1."""
    return {
        name: (constants, [(field, _unsigned(type_)) for field, type_ in members])
        for name, (constants, members) in types.items()
    }


def _unsigned(type_: Any) -> Any:
    kind, what = type_
    if what == ("byte", 0):
        return _single("uint8")
    return (kind, (_unsigned(what[0]), what[1])) if isinstance(what[0], tuple) else type_


def _with_needed(
    wanted: dict[str, Any], known: Mapping[str, Any], channel: Channel
) -> dict[str, Any]:
    """The types with those that they need; what the recording lacks is as in the latest ROS."""
    pending = [*wanted]
    while pending:
        for _, type_ in wanted[pending.pop()][1]:
            name = _named(type_)
            if name is None or name in wanted:
                continue
            if name not in known:
                raise UsageError(
                    f"{channel.topic}: the recorded definition of {channel.type} lacks that of"
                    f" {name.replace('/msg/', '/')}"
                )
            wanted[name] = known[name]
            pending.append(name)
    return wanted


def _named(type_: Any) -> str | None:
    """The message that a type of rosbags has; None if it has none."""
    from rosbags.interfaces import Nodetype

    kind, what = type_
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return _named(what[0])
    return str(what) if kind == Nodetype.NAME else None


def _single(base: str) -> Any:
    from rosbags.interfaces import Nodetype

    return (Nodetype.BASE, (base, 0))


def _message(name: str) -> str:
    package, _, type_ = name.partition("/")
    return f"{package}/msg/{type_}"


def _as_in_ros(name: str, type_: Any) -> None:
    """Give a class the names that those of ROS have, by which the runtime knows headers, too."""
    type_.__module__ = name.rpartition("/")[0].replace("/", ".")
    type_.__name__ = name.rpartition("/")[2]
    own = (_NO_FIELD, "__msgtype__")  # of rosbags
    type_.__slots__ = tuple(f.name for f in fields(type_) if f.name not in own)


def default_message(store: Any, type_: str) -> Any:
    """A message with all fields at their defaults, which are all zeros in the bytes of ROS 1."""
    definition = store.get_msgdef(type_)
    message, _ = definition.deserialize_ros1(bytes(_ENOUGH), 0, definition.cls, store)
    return message


Plain = Callable[[Any], Any]
"""Makes the arrays of a value lists, or bytes: their elements count like those in ROS, where a
number is one of 64 bits. What it returns takes the place of the value."""


class _PlainTypes:
    """How the messages of a store become plain; of each type only the fields that need it."""

    def __init__(self, store: Any, wide: Mapping[str, list[str]]) -> None:
        self._store = store
        self._wide = wide
        self._steps: dict[str, list[tuple[str, Plain]]] = {}

    def of(self, type_: str) -> list[tuple[str, Plain]]:
        """The fields of a message that are not plain yet, with what makes them so."""
        if type_ not in self._steps:
            steps = self._steps[type_] = []
            names = [f.name for f in fields(self._store.types[type_])]
            wide = self._wide.get(type_, ())
            for name, (field, what) in zip(names, self._store.fielddefs[type_][1], strict=False):
                step = _wide_text if field in wide else self._field(what)
                if step is not None:
                    steps.append((name, step))
        return self._steps[type_]

    def _field(self, what: Any) -> Plain | None:
        from rosbags.interfaces import Nodetype

        kind, inner = what
        if kind == Nodetype.BASE:
            return None
        if kind == Nodetype.NAME:
            return self._message(inner)
        kind, element = inner[0]
        if kind == Nodetype.NAME:
            step = self._message(element)
            return None if step is None else lambda parts: [step(part) for part in parts]
        if kind != Nodetype.BASE or element[0] == "string":
            return None
        return bytes if element[0] == "uint8" else _listed

    def _message(self, type_: str) -> Plain | None:
        steps = self.of(type_)
        return partial(_apply, steps) if steps else None


def _listed(array: Any) -> Any:
    return array.tolist()


def _wide_text(characters: Any) -> str:
    return "".join(map(chr, characters))


def _apply(steps: list[tuple[str, Plain]], message: Any) -> Any:
    for name, step in steps:
        setattr(message, name, step(getattr(message, name)))
    return message


def _with_arrays(store: Any, message: Any, wide: Mapping[str, list[str]]) -> Any:
    """The message with arrays again, as they are packed."""
    for name in wide.get(message.__msgtype__, ()):
        setattr(message, name, [*map(ord, getattr(message, name))])
    for name, blank in vars(default_message(store, message.__msgtype__)).items():
        value = getattr(message, name)
        if hasattr(blank, "dtype"):
            made = blank.copy()  # that of a default is a view of bytes
            made.resize(len(value), refcheck=False)
            made[:] = list(value)
            setattr(message, name, made)
        elif hasattr(value, "__msgtype__"):
            _with_arrays(store, value, wide)
        elif isinstance(value, list):
            for part in value:
                if hasattr(part, "__msgtype__"):
                    _with_arrays(store, part, wide)
    return message


_ENOUGH = 2**16
"""Bytes of a message whose arrays of any length are empty."""


def fill(store: Any, message: Any, data: Any) -> Any:
    """Return the message with the given fields set, as nodes fill those of ROS; or the data, if
    they are such a message."""
    if getattr(data, "__msgtype__", None) == message.__msgtype__:
        return data
    types = dict(store.fielddefs[message.__msgtype__][1])
    for name, value in values.fields_of(data, types):
        name = _PARTS_OF_TIMES.get(name, name) if name not in types else name
        name = name or values.only_field(message)
        name = name if name in types else f"{name}_"
        setattr(message, name, _field_value(store, types[name], getattr(message, name), value))
    return message


def _field_value(store: Any, type_: Any, old: Any, value: Any) -> Any:
    from rosbags.interfaces import Nodetype

    kind, what = type_
    if value is values.NOW:
        return old  # a recording does not tell when its correction would have been sent
    if kind == Nodetype.NAME:
        return fill(store, old, value)
    if kind != Nodetype.BASE and what[0][0] == Nodetype.NAME:
        name = what[0][1]
        return [fill(store, default_message(store, name), element) for element in value]
    return value
