"""What every file of a recording gives: channels, an index of its messages, and the messages.

The files are walked record by record from their beginning, as they were written, so that one whose
recorder died is read up to there, and what its end says is compared with what it holds.
"""

from __future__ import annotations

from array import array
from bz2 import BZ2Decompressor
from collections.abc import Callable, Iterator
from dataclasses import field
from pathlib import Path
from typing import Any, Literal, Protocol

from robosc.lazy_dataclasses import dataclass

Encoding = Literal["cdr", "ros1"]
"""How messages are packed."""


@dataclass(frozen=True)
class Channel:
    """A topic with messages of one type from one or several nodes. ``type`` is spelled as it was
    recorded; ``schema`` is the language of the definition, ``ros1msg``, ``ros2msg`` or
    ``ros2idl``; ``node`` the one that sent, empty if that was not recorded."""

    topic: str
    type: str
    definition: str = ""
    schema: str = ""
    encoding: Encoding = "cdr"
    latched: bool = False
    node: str = ""


class Damaged(Exception):
    """A part of a file cannot be read; says what is wrong where."""


@dataclass
class MessageIndex:
    """The messages of a file in the order in which they were written, one place in each array:
    nanoseconds, number of the channel, number of the chunk, place in it."""

    times: array[int] = field(default_factory=lambda: array("Q"))
    channels: array[int] = field(default_factory=lambda: array("Q"))
    chunks: array[int] = field(default_factory=lambda: array("Q"))
    places: array[int] = field(default_factory=lambda: array("Q"))

    def add(self, time: int, channel: int, chunk: int, place: int) -> None:
        self.times.append(time)
        self.channels.append(channel)
        self.chunks.append(chunk)
        self.places.append(place)

    def extend(self, times: array[int], channels: array[int], places: array[int]) -> None:
        """Add messages that are in no chunk."""
        self.times += times
        self.channels += channels
        self.chunks += array("Q", bytes(8 * len(times)))
        self.places += places

    def __len__(self) -> int:
        return len(self.times)


@dataclass
class Contents:
    """What a file has. ``left_out`` are topics in other forms than those of ROS, each with its
    form; ``promised`` is the number of messages of each channel that the file itself states;
    ``cut`` says why it ends before its end, if it does."""

    channels: dict[int, Channel] = field(default_factory=dict)
    index: MessageIndex = field(default_factory=MessageIndex)
    left_out: dict[str, str] = field(default_factory=dict)
    promised: dict[int, int] = field(default_factory=dict)
    cut: str = ""


class Storage(Protocol):
    """An open file of a recording."""

    contents: Contents

    def load(self, chunk: int) -> Any:
        """A chunk, unpacked.

        Raises:
            Damaged: it cannot be.
        """

    def message(self, chunk: Any, place: int) -> bytes:
        """The bytes of a message at a place of a chunk that was loaded."""

    def close(self) -> None: ...


def unpack(form: str, data: bytes | memoryview, size: int) -> bytes:
    """The bytes that were compressed in a form; of data that were cut off, those that can be had.

    Raises:
        Damaged: the data are none of that form, or it is not known.
    """
    if form in ("", "none"):
        return bytes(data)
    if form not in _DECOMPRESSORS:
        raise Damaged(f"the compression {form!r} is not known")
    try:
        # In pieces, so that an error in a later one leaves what comes before it.
        return b"".join(_unpacked(_DECOMPRESSORS[form](), memoryview(data)))
    except ModuleNotFoundError:
        raise
    except Exception as error:  # each library has errors of its own
        raise Damaged(f"{size:,} bytes cannot be unpacked ({form}: {error})") from error


def _unpacked(decompressor: Any, data: memoryview) -> Iterator[bytes]:
    step = 1 << 20
    for begin in range(0, len(data), step):
        yield decompressor.decompress(data[begin : begin + step])
        if decompressor.eof:
            return


def _zstd() -> Any:
    try:
        from compression import zstd
    except ImportError:
        from backports import zstd
    return zstd.ZstdDecompressor()


def _lz4() -> Any:
    from lz4.frame import LZ4FrameDecompressor

    return LZ4FrameDecompressor()


_DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    "zstd": _zstd, "lz4": _lz4, "bz2": BZ2Decompressor,
}  # fmt: skip


def unpacked_file(path: Path, target: Path) -> None:
    """Unpack a file that is compressed as a whole (``.zstd``) to another one.

    Raises:
        Damaged: it cannot be unpacked.
    """
    decompressor = _zstd()
    with path.open("rb") as packed, target.open("wb") as whole:
        while not decompressor.eof and (piece := packed.read(1 << 20)):
            try:
                whole.write(decompressor.decompress(piece))
            except Exception as error:  # the library's own
                raise Damaged(f"it cannot be unpacked (zstd: {error})") from error
