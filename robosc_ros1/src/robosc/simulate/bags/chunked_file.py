"""What the files of both formats have in common: records, some of them in chunks, with an index."""

from __future__ import annotations

import mmap
from abc import ABC, abstractmethod
from pathlib import Path
from typing import NamedTuple

from robosc.simulate.bags.storage import Contents, Damaged, unpack

Buffer = bytes | mmap.mmap

Entry = tuple[int, int, int]
"""A message in the index of a chunk: nanoseconds, number of the channel, place in the chunk."""


class Chunk(NamedTuple):
    """A chunk in the file: its form, place, and the size of what is in it."""

    form: str
    begin: int
    end: int
    size: int


class ChunkedFile(ABC):
    """An open file, walked once. A message outside of chunks is one of the chunk 0, which is the
    file itself."""

    def __init__(self, path: Path) -> None:
        self.contents = Contents()
        self._file = path.open("rb")
        self._data = mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)
        self._chunks = [Chunk("", 0, len(self._data), len(self._data))]
        try:
            self._walk()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        self._data.close()
        self._file.close()

    def load(self, chunk: int) -> Buffer:
        if not chunk:
            return self._data
        form, begin, end, size = self._chunks[chunk]
        # An exception would keep the view, and with it the file open.
        with memoryview(self._data)[begin:end] as packed:
            return unpack(form, packed, size)

    @abstractmethod
    def _walk(self) -> None:
        """Read all but the messages. A chunk has its index behind it; where that is missing, or its
        channels are not told elsewhere, it is unpacked."""

    @abstractmethod
    def _take_records(self, data: Buffer, number: int) -> None:
        """Take what is whole in a chunk that was loaded."""

    def _take_chunk(self, entries: list[Entry]) -> None:
        """Add the messages of the last chunk, from its index if it has one."""
        number = len(self._chunks) - 1
        if not entries:
            self._scan_chunk(number)
            return
        entries.sort(key=lambda entry: entry[2])
        add = self.contents.index.add
        for time, channel, place in entries:
            add(time, channel, number, place)

    def _scan_chunk(self, number: int) -> None:
        try:
            data = self.load(number)
        except Damaged as damage:
            self.contents.cut = self.contents.cut or str(damage)
            return
        self._take_records(data, number)
