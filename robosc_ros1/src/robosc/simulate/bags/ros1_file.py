"""Bags of ROS 1, version 2.0 (https://wiki.ros.org/Bags/Format/2.0), indexed or not."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from robosc.simulate.bags import chunked_file, storage

_MAGIC = b"#ROSBAG V2.0\n"
_MESSAGE, _BAG, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = 2, 3, 4, 5, 6, 7
_SIZE = struct.Struct("<I")
_ENTRY = struct.Struct("<III")
_COUNT = struct.Struct("<II")


class _Record(NamedTuple):
    """A record: its header, its place, and where its data are; they may end behind the file."""

    code: int
    header: Mapping[str, bytes]
    place: int
    begin: int
    end: int


class Ros1File(chunked_file.ChunkedFile):
    """A bag of ROS 1. A message outside of chunks is one of the chunk 0, the file itself: so are
    those of the last chunk where the recorder died in it."""

    def message(self, chunk: chunked_file.Buffer, place: int) -> bytes:
        (header,) = _SIZE.unpack_from(chunk, place)
        place += 4 + header
        (length,) = _SIZE.unpack_from(chunk, place)
        return bytes(chunk[place + 4 : place + 4 + length])

    # --- the walk --------------------------------------------------------------------------------

    def _walk(self) -> None:
        """Read all but the messages. A chunk has its index behind it; where that is missing, or
        its connections are not told elsewhere, it is unpacked."""
        data, contents = self._data, self.contents
        entries: list[chunked_file.Entry] = []
        is_open = is_indexed = False
        end = len(_MAGIC)
        for record in _records(data, end):
            if is_open and record.code != _INDEX:
                self._take_chunk(entries)
                is_open = False
            if record.end > len(data):
                if record.code == _CHUNK:
                    self._open_chunk(record, len(data))
                    entries, is_open = [], True
                break
            if record.code == _BAG:
                is_indexed = bool(int.from_bytes(record.header["index_pos"], "little"))
            elif record.code == _CHUNK and record.end > record.begin:
                self._open_chunk(record, record.end)
                entries, is_open = [], True
            elif record.code == _INDEX:
                connection = int.from_bytes(record.header["conn"], "little")
                for sec, nsec, place in _ENTRY.iter_unpack(data[record.begin : record.end]):
                    entries.append((sec * 10**9 + nsec, connection, place))
            elif record.code == _CHUNK_INFO:
                for connection, count in _COUNT.iter_unpack(data[record.begin : record.end]):
                    contents.promised[connection] = contents.promised.get(connection, 0) + count
            else:
                self._take(data, record, 0)
            end = record.end
        if is_open:  # its index may be cut off, too
            self._scan_chunk(len(self._chunks) - 1)
        if end < len(data) or not is_indexed:
            contents.cut = f"it was not ended: it breaks off at byte {end:,}"
        known = contents.channels.keys()
        places = zip(contents.index.chunks, contents.index.channels, strict=True)
        for chunk in sorted({c for c, n in places if n not in known}):
            for record in _records(self.load(chunk), 0):
                self._describe(self.load(chunk), record)

    def _open_chunk(self, record: _Record, end: int) -> None:
        form = record.header["compression"].decode()
        size = int.from_bytes(record.header["size"], "little")
        self._chunks.append(chunked_file.Chunk(form, record.begin, end, size))

    def _take_records(self, data: chunked_file.Buffer, number: int) -> None:
        for record in _records(data, 0):
            if record.end <= len(data):
                self._take(data, record, number)

    def _take(self, data: chunked_file.Buffer, record: _Record, chunk: int) -> None:
        if record.code == _MESSAGE:
            sec, nsec = struct.unpack("<II", record.header["time"])
            connection = int.from_bytes(record.header["conn"], "little")
            self.contents.index.add(sec * 10**9 + nsec, connection, chunk, record.place)
        else:
            self._describe(data, record)

    def _describe(self, data: chunked_file.Buffer, record: _Record) -> None:
        if record.code != _CONNECTION:
            return
        told = _header(bytes(data[record.begin : record.end]))
        text = {name: value.decode("utf-8", "replace") for name, value in told.items()}
        number = int.from_bytes(record.header["conn"], "little")
        self.contents.channels[number] = storage.Channel(
            record.header["topic"].decode(), text.get("type", ""),
            text.get("message_definition", ""), "ros1msg", "ros1", text.get("latching") == "1",
            text.get("callerid", ""),
        )  # fmt: skip


def _records(data: chunked_file.Buffer, place: int) -> Iterator[_Record]:
    """The records from a place on, until one whose header is cut off, or none."""
    size = len(data)
    while place + 4 <= size:
        (length,) = _SIZE.unpack_from(data, place)
        begin = place + 4 + length
        if begin + 4 > size:
            return
        header = _header(bytes(data[place + 4 : begin]))
        (count,) = _SIZE.unpack_from(data, begin)
        if len(header.get("op", b"")) != 1:
            return
        record = _Record(header["op"][0], header, place, begin + 4, begin + 4 + count)
        yield record
        place = record.end


def _header(data: bytes) -> dict[str, bytes]:
    """The fields of a header, each ``name=value`` behind its length."""
    found: dict[str, bytes] = {}
    place = 0
    while place + 4 <= len(data):
        (length,) = _SIZE.unpack_from(data, place)
        name, _, value = data[place + 4 : place + 4 + length].partition(b"=")
        found[name.decode("ascii", "replace")] = value
        place += 4 + length
    return found
