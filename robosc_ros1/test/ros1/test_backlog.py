"""What waits in sockets has been handed over when a backlog says so, on real sockets."""

from __future__ import annotations

import io
import random
import socket
import struct
import threading
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import pytest
from ros1.test_prompt_connections import TEMPLATES
from ros_support import await_condition


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(TEMPLATES))
    return import_module("ros_backlog")


class Reader:
    """A connection of which a thread hands over what it receives, as slowly as it is allowed to."""

    def __init__(self, backlog: Any, chance: random.Random, size: int | None = None) -> None:
        with socket.create_server(("127.0.0.1", 0)) as server:
            self.theirs = socket.create_connection(server.getsockname())
            self.ours, _ = server.accept()
        self.handed = 0
        self.sent = 0
        self.may_go_on = threading.Event()
        self.may_go_on.set()
        self._backlog = backlog
        self._size = size or chance.choice([20, 100, 65536])
        self.thread = threading.Thread(target=self._read, daemon=True)
        self.thread.start()

    def _read(self) -> None:
        while True:
            buffer = io.BytesIO()
            try:
                count = self._backlog.receive(self.ours, buffer, self._size)
            except Exception:  # the other end has gone
                return
            self.may_go_on.wait()
            self.handed += count

    def send(self, size: int) -> None:
        self.theirs.sendall(bytes(size))
        self.sent += size

    def await_arrival(self) -> None:
        """Wait until the kernel has passed on what was sent, which may take a while under load."""
        info = b""
        while not info or struct.unpack_from("=Q", info, 128)[0] < self.sent:
            info = self.ours.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 136)


@pytest.mark.parametrize("seed", range(10))
def test_all_that_waited_was_handed_over(module: Any, seed: int) -> None:
    chance = random.Random(seed)
    backlog = module.Backlog()
    readers = [Reader(backlog, chance) for _ in range(5)]
    await_condition(lambda: len(backlog._open) == len(readers), "five threads that receive")
    for _ in range(40):
        for reader in chance.sample(readers, 2):
            reader.may_go_on.clear()
        for reader in readers:
            reader.send(chance.choice([0, 1, 50, 3000]))
        for reader in readers:
            reader.await_arrival()
        sent = [reader.sent for reader in readers]
        found: list[list[int]] = []
        over = threading.Event()

        def done(found: list[list[int]] = found, over: threading.Event = over) -> None:
            found.append([reader.handed for reader in readers])
            over.set()

        backlog.await_taken(done)
        if chance.random() < 0.5:
            readers[0].send(5000)  # more may come meanwhile
        for reader in readers:
            reader.may_go_on.set()
        assert over.wait(20)
        (handed,) = found
        assert all(h >= s for h, s in zip(handed, sent, strict=True)), (handed, sent)
    for reader in readers:
        reader.theirs.close()
        reader.thread.join(20)


def test_what_was_handed_over_before_is_over_at_once(module: Any) -> None:
    backlog = module.Backlog()
    reader = Reader(backlog, random.Random(0))
    reader.send(10)
    reader.await_arrival()
    await_condition(lambda: reader.handed == 10, "what was sent")
    over = threading.Event()
    backlog.await_taken(over.set)
    assert over.wait(20)
    reader.theirs.close()


def test_a_connection_that_ends_keeps_nobody_waiting(module: Any) -> None:
    backlog = module.Backlog()
    reader, other = (Reader(backlog, random.Random(n)) for n in range(2))
    await_condition(lambda: len(backlog._open) == 2, "two threads that receive")
    reader.may_go_on.clear()
    reader.send(10)
    reader.await_arrival()
    over = threading.Event()
    backlog.await_taken(over.set)
    assert not over.is_set()
    reader.theirs.close()
    reader.may_go_on.set()
    assert over.wait(20)
    other.theirs.close()


def test_small_messages_are_gathered_and_large_ones_are_not_held_up(
    module: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    slept: list[float] = []
    clock = SimpleNamespace(monotonic=lambda: 1.0, sleep=slept.append)
    monkeypatch.setattr(module, "time", clock)
    backlog = module.Backlog()
    backlog.gathering = 0.5
    reader = Reader(backlog, random.Random(0), size=65536)
    for _ in range(3):
        reader.send(20)
        await_condition(lambda: reader.handed == reader.sent, "a small message")
    assert slept == [0.5] * len(slept) and len(slept) >= 2

    def receive_all(sock: socket.socket, buffer: io.BytesIO, size: int) -> int:
        """On a busy machine a large message comes in scraps, some of them small."""
        return buffer.write(sock.recv(size, socket.MSG_WAITALL))

    monkeypatch.setattr(module, "_receive", receive_all)
    for size in (20, 65536):  # the first one ends the call that receives scraps
        reader.send(size)
        await_condition(lambda: reader.handed == reader.sent, "the next message")
    slept.clear()
    for _ in range(20):
        reader.send(16 * 65536)
        await_condition(lambda: reader.handed == reader.sent, "a large message")
    assert slept == []
    monkeypatch.undo()
    reader.theirs.close()
