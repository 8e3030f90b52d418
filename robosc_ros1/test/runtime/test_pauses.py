"""When the other threads of a process have nothing to do any more."""

from __future__ import annotations

import os
import threading
import zlib

from ros_support import await_condition

from robosc.runtime.core.resting import others_rest


def test_a_thread_outside_of_python_is_waited_for() -> None:
    """As those of a middleware are, which do not hold the interpreter's lock."""
    content = os.urandom(1 << 20)
    enough = threading.Event()

    def work() -> None:
        while not enough.is_set():
            zlib.compress(content, 9)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        await_condition(lambda: not others_rest(), "a thread at work")
    finally:
        enough.set()
        thread.join()
    await_condition(others_rest, "rest")
