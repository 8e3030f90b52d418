"""A service that speaks ROS's protocol only so far, and then does as it should not."""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from xmlrpc.client import ServerProxy

from ros_support import Master

__all__ = ["ANSWERS", "BrokenService"]

ANSWERS = {
    "part": b"\1\xe8\3\0\0abc",
    "nothing": b"\1\0\0\0\0",
    "too much": b"\1\3\0\0\0abc",
    "endless": b"\1\xff\xff\xff\xffabc",
    "refusal without a reason": b"\0\0\0\0\0",
    "refusal in no language": b"\0\3\0\0\0\xff\xfe\xfd",
    "two answers": b"\1\1\0\0\0\1" * 2,
}
"""What it answers: whether it went well, the length of what follows, and that."""


class BrokenService:
    """``fault`` is "hang up", "nonsense", "hang up in the call", "reset", or one of the answers."""

    def __init__(self, listener: socket.socket) -> None:
        self.fault = "hang up"
        self._listener = listener
        threading.Thread(target=self._run, daemon=True).start()

    @classmethod
    @contextmanager
    def at(cls, master: Master, name: str) -> Iterator[BrokenService]:
        with socket.create_server(("localhost", 0)) as listener:
            uri = f"rosrpc://localhost:{listener.getsockname()[1]}"
            owner = "/broken_service"
            ServerProxy(master.uri).registerService(owner, name, uri, "http://localhost:9")
            try:
                yield cls(listener)
            finally:
                ServerProxy(master.uri).unregisterService(owner, name, uri)

    def _run(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return  # the test is over
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        # The other side may have given up meanwhile.
        with connection, suppress(OSError, struct.error):
            if self.fault == "hang up":
                return
            if self.fault == "nonsense":
                connection.sendall(b"\xff" * 100)
                time.sleep(1)  # keep the connection; the end is not awaited
                return
            fields = dict(field.split(b"=", 1) for field in parts(block(connection)))
            reply = sized(b"md5sum=" + fields[b"md5sum"]) + sized(b"type=any/Type")
            connection.sendall(sized(reply))
            block(connection)
            if self.fault == "reset":
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            elif self.fault != "hang up in the call":
                connection.sendall(ANSWERS[self.fault])
                if self.fault == "endless":
                    time.sleep(1)


def sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def block(connection: socket.socket) -> bytes:
    """What comes next, after its length."""
    (size,) = struct.unpack("<I", connection.recv(4, socket.MSG_WAITALL))
    return connection.recv(size, socket.MSG_WAITALL)


def parts(data: bytes) -> Iterator[bytes]:
    while data:
        (size,) = struct.unpack("<I", data[:4])
        yield data[4 : 4 + size]
        data = data[4 + size :]
