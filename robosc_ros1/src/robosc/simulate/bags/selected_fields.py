"""Some fields of recorded messages, read without all others.

A function is made for each type: it passes over what nobody wants, and builds no objects for it.
Whatever it cannot do is left to the reader of whole messages.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Callable, Collection, Iterable, Mapping
from keyword import iskeyword
from types import SimpleNamespace
from typing import Any

from robosc.lazy_dataclasses import dataclass

Path = tuple[str, ...]
"""The names of fields, from the outside."""
Selected = Callable[[bytes], "tuple[float | None, Any]"]
"""Returns the seconds of a message's stamp, None if it has none, and the message with the fields
that were selected, in which arrays of numbers are those of Python's ``array``. It raises some
exception wherever rosbags does, and where a message of ROS 2 has the most significant bytes first.
"""

_FORMATS = {
    "bool": "?", "byte": "b", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H",
    "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip
_STAMP = (("header", "stamp", "sec"), ("header", "stamp", "nanosec"))
TIME = "builtin_interfaces/msg/Time"
_HEAD = 4
"""Bytes before a message of ROS 2, which say how it is packed: here, the least byte first."""
_LITTLE = b"\x00\x01"


class _Unreadable(Exception):
    """A field is not there, or in no form that can be read here."""


@dataclass(frozen=True)
class Definitions:
    """Types as rosbags has them: the fields of each, the ``kinds`` of these, and which of each are
    wide texts."""

    fields: Any
    kinds: Any
    wide: Mapping[str, Collection[str]]
    is_ros_1: bool


def selecting(definitions: Definitions, type_: str, paths: Iterable[Path]) -> Selected | None:
    """Return a reader of the fields at some paths of a type. None: there is none, since they are
    not all numbers, texts, or arrays of numbers."""
    try:
        return _Reader(definitions, frozenset(paths)).made(type_)
    except _Unreadable:
        return None


class _Reader:
    """The text of a function that reads a type.

    The place of the next field is ``place`` plus ``_offset``; ``place`` is a multiple of
    ``_aligned``, behind the first bytes, in all messages.
    """

    def __init__(self, definitions: Definitions, wanted: frozenset[Path]) -> None:
        self._kinds = definitions.kinds
        self._fields = definitions.fields
        self._wide = definitions.wide
        self._is_ros_1 = definitions.is_ros_1
        self._head = 0 if self._is_ros_1 else _HEAD
        self._wanted = wanted
        self._offset = 0
        self._aligned = 8
        self._lines: list[str] = []
        self._indent = 1
        self._names: dict[Path, str] = {}
        self._stamp: list[str] = []
        self._used: dict[str, Any] = {"N": SimpleNamespace, "array": array}

    def made(self, type_: str) -> Selected:
        self._message(type_, ())
        is_native = sys.byteorder == "little"
        if not is_native or not self._wanted <= self._names.keys():
            raise _Unreadable
        self._settle()
        head = ["def read(raw):", f" place, size = {self._head}, len(raw)"]
        rest = 0
        if not self._is_ros_1:
            head.append(f" if raw[:2] != {_LITTLE!r}: raise ValueError")
            rest = 3  # bytes that fill up the last word
        self._add(f"if not place <= size <= place + {rest}: raise ValueError")
        seconds = "{} + {} * 1e-9 or None".format(*self._stamp) if self._stamp else "None"
        self._add(f"return {seconds}, {self._built(())}")
        exec(compile("\n".join([*head, *self._lines]), f"<{type_}>", "exec"), self._used)
        read: Selected = self._used["read"]
        return read

    # --- the walk through the fields -------------------------------------------------------------

    def _message(self, type_: str, path: Path | None) -> None:
        """Read a message at a path; None: it is an element of an array, and passed over."""
        for name, (kind, what) in self._fields[type_][1]:
            inner = None if path is None else (*path, name)
            if kind == self._kinds.BASE:
                self._single(what[0], self._name(inner, type_))
            elif kind == self._kinds.NAME:
                self._message(what, inner)
            else:
                self._array(what[0], what[1] if kind == self._kinds.ARRAY else None,
                            self._name(inner, type_))  # fmt: skip

    def _name(self, path: Path | None, owner: str) -> str | None:
        """The name of the variable that gets a field; None: nobody wants it."""
        if path is None:
            return None
        is_stamp = owner == TIME and path in _STAMP
        if path not in self._wanted and not is_stamp:
            return None
        if iskeyword(path[-1]) or path[-1] in self._wide.get(owner, ()):
            raise _Unreadable
        self._names[path] = f"v{len(self._names)}"
        if is_stamp:
            self._stamp.append(self._names[path])
        return self._names[path]

    def _single(self, base: str, name: str | None) -> None:
        if base == "string":
            self._string(name)
            return
        size = self._size(base)
        self._align(size)
        if name is not None:
            self._add(f"({name},) = {self._unpacker(base)}(raw, {self._place()})")
        self._offset += size

    def _string(self, name: str | None) -> None:
        self._count()
        end = "place + count"
        if not self._is_ros_1:
            end = "place + count - 1"
            self._add(f"if not count or raw[{end}]: raise ValueError")
        # Decoded in any case: what is no text is no message of this type.
        text = f"raw[place:{end}].decode()"
        self._add(text if name is None else f"{name} = {text}")
        self._add("place += count")
        self._aligned = 1

    def _array(self, element: Any, length: int | None, name: str | None) -> None:
        kind, what = element
        is_number = kind == self._kinds.BASE and what[0] != "string"
        if name is not None and not (is_number and what[0] != "bool"):
            raise _Unreadable
        if length is None:
            self._count()
        if is_number:
            self._numbers(what[0], length, name)
            return
        self._settle()
        self._add(f"for _ in range({'count' if length is None else length}):")
        self._indent += 1
        self._aligned = 1
        if kind == self._kinds.BASE:
            self._string(None)
        else:
            self._message(what, None)
        self._settle()
        self._add("pass")
        self._indent -= 1
        self._aligned = 1

    def _numbers(self, base: str, length: int | None, name: str | None) -> None:
        size = self._size(base)
        if length is None:
            if not self._is_ros_1 and size > self._aligned:
                self._add(f"if count: place = {self._multiple(size)}")
            end = f"place + count * {size}"
        else:
            self._align(size)
            end = self._place(length * size)
        if name is not None:
            values = f"raw[{self._place()}:{end}]"
            form = _FORMATS[base]
            self._add(
                f"{name} = {values}" if base == "uint8" else f"{name} = array({form!r}, {values})"
            )
        if length is None:
            self._add(f"place = {end}")
            self._aligned = min(4, size)
        else:
            self._offset += length * size

    def _count(self) -> None:
        """Read the number of elements; no element takes less than a byte."""
        self._align(4)
        self._add(f"(count,) = {self._unpacker('uint32')}(raw, {self._place()})")
        self._offset += 4
        self._settle()
        self._add("if place + count > size: raise ValueError")
        self._aligned = min(self._aligned, 4)

    # --- places ----------------------------------------------------------------------------------

    def _align(self, size: int) -> None:
        if self._is_ros_1:
            return
        if size > self._aligned:
            self._settle()
            self._add(f"place = {self._multiple(size)}")
            self._aligned = size
        self._offset += -self._offset % size

    def _settle(self) -> None:
        """Go to the next field."""
        if self._offset:
            self._add(f"place += {self._offset}")
            while self._offset % self._aligned:
                self._aligned //= 2
            self._offset = 0

    def _multiple(self, size: int) -> str:
        return f"(place + {size - 1 - self._head} & -{size}) + {self._head}"

    def _place(self, more: int = 0) -> str:
        return f"place + {self._offset + more}" if self._offset + more else "place"

    def _size(self, base: str) -> int:
        if base not in _FORMATS:
            raise _Unreadable
        return struct.calcsize(f"<{_FORMATS[base]}")

    def _unpacker(self, base: str) -> str:
        name = f"unpack_{base}"
        self._used[name] = struct.Struct(f"<{_FORMATS[base]}").unpack_from
        return name

    def _add(self, line: str) -> None:
        self._lines.append(f"{' ' * self._indent}{line}")

    def _built(self, path: Path) -> str:
        """The expression that builds the message at a path, of what is wanted of it."""
        inner = dict.fromkeys(p[len(path)] for p in self._wanted if p[: len(path)] == path)
        parts = {name: (*path, name) for name in inner}
        values = (f"{n}={self._names.get(p) or self._built(p)}" for n, p in parts.items())
        return f"N({', '.join(values)})"
