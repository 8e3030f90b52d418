"""The limit on the processor time of a check stops also what tells no progress."""

from __future__ import annotations

import signal
import threading
import time
from contextlib import suppress
from types import FrameType

import pytest

from robosc.errors import StateSpaceError
from robosc.synthesis.bdd.manager import Manager
from robosc.synthesis.time_limit import processor_time


def test_work_without_progress_is_stopped() -> None:
    with (
        pytest.raises(StateSpaceError, match=r"takes more than 0\.05 s"),
        processor_time(0.05, None),
    ):
        while True:
            sum(range(1000))


def test_an_error_that_is_swallowed_comes_again() -> None:
    """As one is that arises while an object is finalised."""
    caught = 0
    with pytest.raises(StateSpaceError), processor_time(0.05, None):
        while True:
            try:
                while True:
                    sum(range(1000))
            except StateSpaceError:
                caught += 1
                if caught > 1:
                    raise


def test_no_error_is_lost_in_the_library_of_diagrams() -> None:
    """It calls Python from an operation, and the error of a signal there becomes one of types."""
    pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")
    manager = Manager(2)
    some, cube = manager.literal(0, True), manager.cube([1])

    interrupts = 0

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal interrupts
        interrupts += 1
        raise KeyboardInterrupt

    # A function, since Python 3.13 can pass over the handler around a loop when a signal's error
    # arises between two rounds of it.
    def work(until: int) -> None:
        while interrupts < until:
            manager.and_exists(some, some, cube)

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        for number in range(50):
            with pytest.raises(StateSpaceError), processor_time(0.001, None):
                work(until=51)
            with suppress(KeyboardInterrupt):  # no TypeError
                signal.setitimer(signal.ITIMER_REAL, 0.001)
                work(until=number + 1)
    finally:
        signal.signal(signal.SIGALRM, before)


def test_afterwards_nothing_goes_off() -> None:
    with processor_time(0.05, None):
        pass
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGPROF) is signal.SIG_DFL


def test_other_threads_are_stopped_where_they_tell_progress() -> None:
    found: list[StateSpaceError] = []

    def work() -> None:
        try:
            with processor_time(0.05, None) as progress:
                while True:
                    sum(range(1000))
                    progress("synthesis", 0, 1)
        except StateSpaceError as error:
            found.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert len(found) == 1


def test_a_timer_of_somebody_else_is_left_alone() -> None:
    def theirs(signum: int, frame: object) -> None: ...

    before = signal.signal(signal.SIGPROF, theirs)
    try:
        with pytest.raises(StateSpaceError), processor_time(0.01, None) as progress:
            assert signal.getsignal(signal.SIGPROF) is theirs
            end = time.process_time() + 0.02
            while time.process_time() < end:
                sum(range(1000))
            progress("synthesis", 0, 1)
    finally:
        signal.signal(signal.SIGPROF, before)
