"""Fields that are read without the rest of a message are those of the whole, and where the bytes are
no message of the type, both say so."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any

import pytest
from quick import quick_first

pytest.importorskip("rosbags")

from robosc.simulate.bags.recorded_messages import MessageTypes, stamp_of
from robosc.simulate.bags.storage import Channel

NUMBERS = (
    "bool", "byte", "char", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64",
    "uint64", "float32", "float64",
)  # fmt: skip
TEXTS = ("", "a", "frönt", "abcdefg")
HEADERS = {
    True: "uint32 seq\ntime stamp\nstring frame_id",
    False: "builtin_interfaces/Time stamp\nstring frame_id",
}
TIME = "int32 sec\nuint32 nanosec"


def random_type(rng: random.Random, inner: list[str], header: bool) -> str:
    """The fields of a type that may have others in it."""
    lines = ["std_msgs/Header header"] if header else []
    for number in range(rng.randint(1, 7)):
        base = rng.choice([*NUMBERS, "string", "string", *(f"test_msgs/{name}" for name in inner)])
        array = rng.choice(["", "", "", "[]", "[3]"])
        lines.append(f"{base}{array} f{number}")
    return "\n".join(lines)


def random_definition(rng: random.Random, is_ros_1: bool) -> str:
    """The definition of test_msgs/Outer, as it is recorded."""
    innermost = random_type(rng, [], header=False)
    inner = random_type(rng, ["Innermost"], header=False)
    parts = [random_type(rng, ["Inner", "Innermost"], header=rng.random() < 0.6)]
    parts += [f"MSG: test_msgs/Inner\n{inner}", f"MSG: test_msgs/Innermost\n{innermost}"]
    parts.append(f"MSG: std_msgs/Header\n{HEADERS[is_ros_1]}")
    if not is_ros_1:
        parts.append(f"MSG: builtin_interfaces/Time\n{TIME}")
    return f"\n{'=' * 80}\n".join(parts)


def fill(rng: random.Random, types: MessageTypes, type_: str) -> Any:
    """A message of a type with random data, of which numbers are small."""
    from rosbags.interfaces import Nodetype

    def single(base: str) -> Any:
        if base == "string":
            return rng.choice(TEXTS)
        if base.startswith("float"):
            return rng.choice([0.0, 1.5, -2.25, math.inf])
        return rng.random() < 0.5 if base == "bool" else rng.randrange(100)

    def value(field: Any) -> Any:
        kind, what = field
        if kind == Nodetype.BASE:
            return single(what[0])
        if kind == Nodetype.NAME:
            return fill(rng, types, what)
        element, length = what
        count = length if kind == Nodetype.ARRAY else rng.randrange(4)
        if element[0] == Nodetype.BASE and element[1][0] != "string":
            import numpy
            from rosbags.serde.utils import ndtype

            numbers = [single(element[1][0]) for _ in range(count)]
            return numpy.array(numbers, dtype=getattr(numpy, ndtype(element[1][0])))
        return [value(element) for _ in range(count)]

    fields = types.store.fielddefs[type_][1]
    return types.store.types[type_](*(value(field) for _, field in fields))


Path = tuple[str, ...]


def paths(types: MessageTypes, type_: str, outer: Path = ()) -> Iterator[tuple[Path, bool]]:
    """All paths through a type, but for those behind arrays; and whether one leads to a number, a
    text, or an array of numbers."""
    from rosbags.interfaces import Nodetype

    for name, (kind, what) in types.store.fielddefs[type_][1]:
        path = (*outer, name)
        element = what[0]
        is_array = kind in (Nodetype.ARRAY, Nodetype.SEQUENCE)
        yield (
            path,
            kind == Nodetype.BASE
            or (
                is_array and element[0] == Nodetype.BASE and element[1][0] not in ("string", "bool")
            ),
        )
        if kind == Nodetype.NAME:
            yield from paths(types, what, path)


def at(message: Any, path: Path) -> Any:
    for name in path:
        message = getattr(message, name)
    return list(message) if hasattr(message, "typecode") else message


@pytest.mark.parametrize("seed", quick_first(range(120), 40))
def test_any_fields_of_any_type(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(seed)
    is_ros_1 = seed % 2 == 0
    schema, encoding = ("ros1msg", "ros1") if is_ros_1 else ("ros2msg", "cdr")
    definition = random_definition(rng, is_ros_1)
    channel = Channel("/outer", "test_msgs/msg/Outer", definition, schema, encoding)  # type: ignore[arg-type]
    types = MessageTypes(channel)
    pack = types.store.serialize_ros1 if is_ros_1 else types.store.serialize_cdr
    raw = bytes(pack(fill(rng, types, types.name), types.name))
    whole = types.read(raw)
    known = dict(paths(types, types.name))
    for _ in range(4):
        wanted = rng.sample(sorted(known), rng.randint(0, min(4, len(known))))
        read = types.selected(wanted)
        with monkeypatch.context() as patched:
            if all(known[path] for path in wanted):
                patched.setattr(types, "read", pytest.fail)
            stamp, message = read(raw)
        assert stamp == stamp_of(whole)
        for path in wanted:
            # Of a message in it, the type's own equality tells.
            assert repr(at(message, path)) == repr(at(whole, path))
        for _ in range(6):
            other = damaged(rng, raw)
            assert outcome(read, other, wanted) == outcome(types.selected(None), other, wanted)


def damaged(rng: random.Random, raw: bytes) -> bytes:
    """Bytes of which some are lost, changed, or too many."""
    place = rng.randrange(len(raw)) if raw else 0
    return rng.choice([
        raw[:place], raw + bytes(rng.randint(1, 8)),
        raw[:place] + bytes([rng.choice([0, 1, 2, 255])]) + raw[place + 1 :],
    ])  # fmt: skip


def outcome(read: Any, raw: bytes, wanted: list[Path]) -> str:
    try:
        stamp, message = read(raw)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return repr((stamp, [at(message, path) for path in wanted]))


@pytest.mark.parametrize("path", [("header", "seq"), ("f",), ("class",), ("seq", "deep")])
def test_what_is_in_no_simple_form_is_looked_for_in_the_whole(path: Path) -> None:
    definition = "uint32 seq\nstring class\nstring[] f"
    types = MessageTypes(Channel("/x", "test_msgs/msg/X", definition, "ros1msg", "ros1"))
    _, message = types.selected([path])(b"\x07\0\0\0\x01\0\0\0c\0\0\0\0")
    assert (message.seq, message.class_, message.f) == (7, "c", [])
