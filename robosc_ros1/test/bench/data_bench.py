"""What a sector of a laser scan of 1,080 points costs the engine, per message."""

from __future__ import annotations

import array
import random
import time
from statistics import median
from types import SimpleNamespace
from typing import Any

from bench.runtime_bench import NullPort
from emit.generated_code import controller_class, supervisor_of

from robosc.runtime.core.commanding import controller_engine

__all__ = ["main"]

LIMIT = 60.0
"""Microseconds of processor time."""
MOST_OF_ANGLES = 1.2
"""What a sector by angle may cost of what the same slice costs, in one run."""
SLICE, SECTOR = "value.ranges[-90..90]", "sector(value, -0.5, 0.5)"
POINTS = 1080
SECTORS = {
    "nearer than, 181 points": "near := any(r < 0.5 and r > value.range_min for r in %s)",
    "least, 181 points": "near := min(r for r in %s) < 0.5",
    "how many, 181 points": "near := count(r < 0.5 for r in %s if !isnan(r)) > 3",
}
MODEL = """
robot Scanner {
    component Laser {
        outgoing message scan with type: Scan links scan
        behaviour {
            variable near: boolean = true
            initial marked state on { on response from scan do ACTION }
        }
    }
    component Base { incoming message drive with type: none }
    requirement drive needs !Laser.near
    interface scan use Scan from nowhere_msgs
    datatype object Scan {
        ranges: array(double) range_min: double angle_min: double angle_increment: double
    }
}
"""


def main(arguments: list[str] | None = None) -> int:
    missed = False
    chance = random.Random(1)
    far = [chance.uniform(1.0, 30.0) for _ in range(POINTS)]
    for what, action in SECTORS.items():
        for kind, ranges in (("tuple", tuple(far)), ("array", array.array("f", far))):
            texts = [MODEL.replace("ACTION", action % part) for part in (SLICE, SECTOR)]
            pairs = [[cost(text, ranges) for text in texts] for _ in range(5)]
            taken, ratio = min(pairs)[0], median(sector / slice_ for slice_, sector in pairs)
            print(f"  {what}, as {kind}: {taken:.1f} us per message  (at most {LIMIT:g})")
            print(f"    by angle {ratio:.2f} of that  (at most {MOST_OF_ANGLES:g})")
            missed = missed or taken > LIMIT or ratio > MOST_OF_ANGLES
    return int(missed)


def cost(text: str, ranges: Any, count: int = 2000) -> float:
    """Microseconds of processor time per scan."""
    made, _ = controller_class(supervisor_of(text))
    engine = controller_engine(made(), NullPort())
    engine.begin()
    post = engine.poster(["Laser.scan"])
    message = SimpleNamespace(
        ranges=ranges, range_min=0.05, angle_min=0.0, angle_increment=0.5 / 90
    )
    start = time.process_time()
    for _ in range(count):
        post(message)
        engine.cycle()
    return (time.process_time() - start) / count * 1e6
