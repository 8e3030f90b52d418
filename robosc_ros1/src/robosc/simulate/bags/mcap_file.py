"""Files of the format MCAP (https://mcap.dev/spec), of ROS 2 and of ROS 1."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path

from robosc.simulate.bags import chunked_file, storage

_MAGIC = b"\x89MCAP0\r\n"
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _MESSAGE_INDEX, _STATISTICS = 3, 4, 5, 6, 7, 11
_DATA_END, _FOOTER = 15, 2

_RECORD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_ENTRY = struct.Struct("<QQ")
_BEFORE_DATA = _RECORD.size + _MESSAGE_HEAD.size
_ENCODINGS: dict[str, storage.Encoding] = {"cdr": "cdr", "ros1": "ros1"}
_SCHEMAS = {"ros1msg": "ros1msg", "ros2msg": "ros2msg", "ros2idl": "ros2idl", "omgidl": "ros2idl"}
_DURABLE = re.compile(r"durability:\s*(?:1\b|transient_local)", re.IGNORECASE)


def is_latched(profiles: str) -> bool:
    """Whether the profiles of quality of service, as a recorder writes them, keep messages for
    who comes late."""
    return bool(_DURABLE.search(profiles))


class McapFile(chunked_file.ChunkedFile):
    """An MCAP file. A message outside of chunks is one of the chunk 0, which is the file itself."""

    def __init__(self, path: Path) -> None:
        self._schemas: dict[int, tuple[str, str, str]] = {}
        self._foreign: set[int] = set()
        super().__init__(path)

    def message(self, chunk: chunked_file.Buffer, place: int) -> bytes:
        _, length = _RECORD.unpack_from(chunk, place)
        return bytes(chunk[place + _BEFORE_DATA : place + _RECORD.size + length])

    # --- the walk --------------------------------------------------------------------------------

    def _walk(self) -> None:
        """Read all but the messages. A chunk has its index behind it; where that is missing, or
        its channels are not told elsewhere, it is unpacked."""
        entries: list[chunked_file.Entry] = []
        is_open = ended = False
        for code, begin, end in _records(self._data, len(_MAGIC), len(self._data)):
            if is_open and code != _MESSAGE_INDEX:
                self._take_chunk(entries)
                is_open = False
            if end > len(self._data):
                self._cut(begin)
                if code == _CHUNK and begin + 40 <= len(self._data):
                    self._open_chunk(begin, len(self._data))
                    is_open = True
                break
            if code == _CHUNK:
                self._open_chunk(begin, end)
                entries, is_open = [], True
            elif code == _MESSAGE_INDEX:
                channel, size = struct.unpack_from("<HI", self._data, begin)
                for time, place in _ENTRY.iter_unpack(self._data[begin + 6 : begin + 6 + size]):
                    entries.append((time, channel, place))
            elif code == _MESSAGE:
                self._message(self._data, begin, 0)
            else:
                self._describe(self._data, code, begin)
            ended = ended or code in (_DATA_END, _FOOTER)
        if is_open:  # its index may be cut off, too
            self._scan_chunk(len(self._chunks) - 1)
        if not ended and not self.contents.cut:
            self._cut(len(self._data))
        for chunk in self._chunks_of_unknown():
            data = self.load(chunk)
            for code, begin, _ in _records(data, 0, len(data)):
                self._describe(data, code, begin)
        known = self.contents.channels
        promised = self.contents.promised.items()
        self.contents.promised = {n: count for n, count in promised if n in known}

    def _cut(self, place: int) -> None:
        self.contents.cut = f"it was not ended: it breaks off at byte {place:,}"

    def _open_chunk(self, begin: int, end: int) -> None:
        _, _, size, _, length = struct.unpack_from("<QQQII", self._data, begin)
        form = self._data[begin + 32 : begin + 32 + length].decode()
        self._chunks.append(chunked_file.Chunk(form, begin + 40 + length, end, size))

    def _take_records(self, data: chunked_file.Buffer, number: int) -> None:
        for code, begin, end in _records(data, 0, len(data)):
            if end > len(data):
                break
            if code == _MESSAGE:
                self._message(data, begin, number)
            else:
                self._describe(data, code, begin)

    def _message(self, data: chunked_file.Buffer, begin: int, chunk: int) -> None:
        channel, _, time, _ = _MESSAGE_HEAD.unpack_from(data, begin)
        self.contents.index.add(time, channel, chunk, begin - _RECORD.size)

    def _chunks_of_unknown(self) -> list[int]:
        """The chunks with messages of channels that are told nowhere else."""
        known = self.contents.channels.keys() | self._foreign
        index = self.contents.index
        if known.issuperset(index.channels):
            return []
        return sorted({c for c, n in zip(index.chunks, index.channels, strict=True)
                       if n not in known})  # fmt: skip

    def _describe(self, data: chunked_file.Buffer, code: int, begin: int) -> None:
        if code == _SCHEMA:
            (number,) = struct.unpack_from("<H", data, begin)
            name, encoding, text = _strings(data, begin + 2, 3)
            self._schemas[number] = name, encoding, text
        elif code == _CHANNEL:
            number, schema = struct.unpack_from("<HH", data, begin)
            topic, encoding = _strings(data, begin + 4, 2)
            metadata = _mapping(data, begin + 12 + len(topic.encode()) + len(encoding.encode()))
            self._channel(number, schema, topic, encoding, metadata)
        elif code == _STATISTICS:
            (size,) = struct.unpack_from("<I", data, begin + 42)
            counts = struct.iter_unpack("<HQ", data[begin + 46 : begin + 46 + size])
            self.contents.promised = dict(counts)

    def _channel(
        self, number: int, schema: int, topic: str, encoding: str, metadata: dict[str, str]
    ) -> None:
        if encoding not in _ENCODINGS:
            self._foreign.add(number)
            self.contents.left_out[topic] = encoding or "of no form"
            return
        type_, language, text = self._schemas.get(schema, ("", "", ""))
        latched = is_latched(metadata.get("offered_qos_profiles", ""))
        self.contents.channels[number] = storage.Channel(
            topic, type_, text, _SCHEMAS.get(language, ""), _ENCODINGS[encoding],
            latched or metadata.get("latching") == "1", metadata.get("callerid", ""),
        )  # fmt: skip


def _records(data: chunked_file.Buffer, begin: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Code, begin and end of each record; of one that is cut off, the end lies behind ``end``."""
    while begin + _RECORD.size <= end:
        code, length = _RECORD.unpack_from(data, begin)
        if not code:
            return
        begin += _RECORD.size
        yield code, begin, begin + length
        begin += length


def _strings(data: chunked_file.Buffer, place: int, count: int) -> list[str]:
    """Strings one after the other, each behind its length."""
    found = []
    for _ in range(count):
        (length,) = struct.unpack_from("<I", data, place)
        found.append(bytes(data[place + 4 : place + 4 + length]).decode("utf-8", "replace"))
        place += 4 + length
    return found


def _mapping(data: chunked_file.Buffer, place: int) -> dict[str, str]:
    """The map of a channel's metadata."""
    (size,) = struct.unpack_from("<I", data, place)
    found: dict[str, str] = {}
    end = place + 4 + size
    place += 4
    while place < end:
        key, value = _strings(data, place, 2)
        found[key] = value
        place += 8 + len(key.encode()) + len(value.encode())
    return found
