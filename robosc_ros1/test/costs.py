"""What tests cost: kept for ``--quick`` and for how long a run may take, measured in every run.

``costs.csv`` beside this file has a row for each test function that takes long, all of its cases
together. Every run leaves the like in .cache/costs.csv, of what it ran::

    python3 robosc_ros1/test/costs.py          a table of the last run, per folder
    python3 robosc_ros1/test/costs.py --keep   and write costs.csv anew with it
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = [
    "ELSEWHERE", "KEPT", "LAST", "Cost", "function_of", "processor", "read", "seconds_of", "write",
]  # fmt: skip

KEPT = Path(__file__).with_name("costs.csv")
LAST = Path(__file__).resolve().parents[2] / ".cache" / "costs.csv"
LEAST = 0.1
"""Seconds of processor or of waiting below which a function has no row in ``costs.csv``."""
WITH_OTHERS = ("ros1/", "ros2/", "view/", "examples/")
"""Folders of which most tests that are not in a table wait for other programs."""
WAITING, COMPUTING = 4.0, 0.02
"""Seconds that such a test is thought to take, and any other one."""
ELSEWHERE: list[float] = []
"""Processor seconds of processes that others have waited for (``fork_server``)."""
COLUMNS = ("function", "size", "cases", "processor", "seconds")


@dataclass
class Cost:
    """Of the cases of a function: how many, their seconds of processor, and those that go by."""

    size: str
    cases: int = 0
    processor: float = 0.0
    seconds: float = 0.0

    def add(self, other: Cost) -> None:
        self.cases += other.cases
        self.processor += other.processor
        self.seconds += other.seconds


def processor() -> float:
    """Seconds that this process and those that it waited for have spent on a processor."""
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages) + sum(ELSEWHERE)


def function_of(nodeid: str) -> str:
    """``cli/test_x.py::test_y`` of the name of any of its cases."""
    test = nodeid.partition("[")[0].partition("@")[0]
    return test.rpartition("robosc_ros1/test/")[2]


def seconds_of(nodeid: str, known: Mapping[str, Cost]) -> float:
    """Return how long a test takes, as far as it is known."""
    function = function_of(nodeid)
    if (cost := known.get(function)) is not None:
        return cost.seconds / cost.cases
    return WAITING if function.startswith(WITH_OTHERS) else COMPUTING


def read(path: Path) -> dict[str, Cost]:
    """Return what each function costs; nothing if there is no such file."""
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8", newline="") as rows:
        return {
            row["function"]: Cost(
                row["size"], int(row["cases"]), float(row["processor"]), float(row["seconds"])
            )
            for row in csv.DictReader(rows)
        }


def write(path: Path, costs: dict[str, Cost]) -> None:
    """Write a table, whole or not at all: another run may read it meanwhile."""
    path.parent.mkdir(exist_ok=True)
    scratch = path.with_name(f"{path.name}.{os.getpid()}")
    with scratch.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(COLUMNS)
        for function, cost in sorted(costs.items()):
            row = function, cost.size, cost.cases, f"{cost.processor:.2f}", f"{cost.seconds:.2f}"
            rows.writerow(row)
    scratch.replace(path)


def table(costs: dict[str, Cost]) -> Iterable[str]:
    """Yield the lines of a table, per folder and size."""
    folders: dict[tuple[str, str], Cost] = defaultdict(lambda: Cost(""))
    for function, cost in costs.items():
        for key in ((function.partition("/")[0], cost.size), ("all", cost.size)):
            folders[key].add(cost)
    yield "| folder | size | cases | processor seconds | seconds |"
    yield "|---|---|---|---|---|"
    for (folder, size), cost in sorted(folders.items(), key=lambda row: (row[0][0] == "all", row)):
        numbers = f"{cost.cases} | {cost.processor:.0f} | {cost.seconds:.0f}"
        yield f"| {folder} | {size} | {numbers} |"


def main() -> None:
    parser = argparse.ArgumentParser(description="What tests cost in the last run.")
    parser.add_argument("--keep", action="store_true", help="write costs.csv anew with it")
    last = read(LAST)
    for line in table(last):
        print(line)
    if parser.parse_args().keep:
        known = read(KEPT)
        # A smaller run has taken only some of the cases, and with them what all of them share.
        whole = known | {f: c for f, c in last.items() if c.cases >= known.get(f, c).cases}
        dear = {f: c for f, c in whole.items() if max(c.processor, c.seconds) >= LEAST}
        write(KEPT, {f: c for f, c in dear.items() if is_there(f)})


def is_there(function: str) -> bool:
    """Whether it has not been renamed or moved."""
    file, _, name = function.partition("::")
    path = KEPT.parent / file
    return path.is_file() and f"\ndef {name}(" in path.read_text(encoding="utf-8")


if __name__ == "__main__":
    main()
