"""What arrives at a robot whose node is stopped in any way: an observer on the wire of both ROS.

``./dev bench wire``, ``-- --ros 2`` for one of them. A table of what was wrong, for each server and
each way of stopping, controllers and supervisors; see ``wire.py``. About ten minutes.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import ros_support
import wire
from ros1 import wired
from ros2 import wired2
from ros2.bed import Unavailable, test_bed

__all__ = ["main"]

Worlds = Callable[[str, str], contextlib.AbstractContextManager[wire.World]]
"""Makes the world of a mode and an event."""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--ros", type=int, choices=(1, 2), help="only this one")
    only = parser.parse_args(arguments).ros
    count = 0
    for ros, worlds in ((1, worlds1), (2, worlds2)):
        if only not in (None, ros):
            continue
        with tempfile.TemporaryDirectory(prefix="robosc-wire-") as name:
            folder = Path(name)
            with worlds(folder) as make:
                events = [e for e in wire.EVENTS if ros == 2 or e != "deactivate"]
                count += sum(
                    judged(ros, make, *cell)
                    for cell in itertools.product(wire.MODES, wire.SERVERS, events)
                )
    print(f"wire: {count} of the cells are wrong")
    return int(count > 0)


def judged(ros: int, make: Worlds, mode: str, server: str, event: str) -> bool:
    """Print what is wrong in a cell; whether there is anything."""
    try:
        with make(mode, event) as world:
            found = wire.faults(world, server, event)
    except AssertionError as error:  # waited in vain
        found = [str(error)[:200]]
    print(f"ROS {ros}  {mode:10}  {server:8}  {event:10}  {'; '.join(found) or 'ok'}", flush=True)
    return bool(found)


@contextlib.contextmanager
def worlds1(folder: Path) -> Iterator[Worlds]:
    missing = ros_support.missing_ros()
    if missing is not None:
        raise SystemExit(f"wire: no ROS 1: {missing}")
    wired.packages(folder)
    with ros_support.master(folder) as master:
        yield lambda mode, event: wired.world(folder, mode, master, folder)


@contextlib.contextmanager
def worlds2(folder: Path) -> Iterator[Worlds]:
    try:
        bed = test_bed()
    except Unavailable as reason:
        raise SystemExit(f"wire: no ROS 2: {reason}") from None
    wired2.packages(bed, folder)
    yield lambda mode, event: wired2.world(folder, mode, event, bed, folder)


if __name__ == "__main__":
    raise SystemExit(main())
