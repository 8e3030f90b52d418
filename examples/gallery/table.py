"""What the robots did in many worlds: one row per run in worlds.csv, the sums in README.md."""

from __future__ import annotations

import csv
import fcntl
import subprocess
from math import fsum  # sum() of floats depends on Python's version
from pathlib import Path
from typing import Any

__all__ = ["Table"]

HERE = Path(__file__).resolve().parent
RESULTS = "README.md", "worlds.csv"
COLUMNS = [
    "ros", "robot", "world", "done", "simulated", "judgements", "violations", "faults", "commit",
]  # fmt: skip
BEGIN, END = "<!-- begin: ./dev gallery --table -->\n", "<!-- end -->\n"
HEAD = """| robot | done, ROS 1 | done, ROS 2 | simulated time, mean | judgements | violations |
|---|---|---|---|---|---|
"""

Row = dict[str, str]


class Table:
    """The rows in a folder; a run that has a row need not be made again."""

    def __init__(self, folder: Path = HERE) -> None:
        self._readme, self._file = (folder / name for name in RESULTS)
        self.rows = self._read()

    def _read(self) -> list[Row]:
        if not self._file.is_file():
            return []
        with self._file.open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def has(self, ros: int, robot: str, seed: int) -> bool:
        key = [str(ros), robot, str(seed)]
        return any([row["ros"], row["robot"], row["world"]] == key for row in self.rows)

    def add(self, ros: int, run: dict[str, Any]) -> None:
        """Add the record of a run, and write both files anew."""
        values = (
            ros, run["world"], run["seed"], "yes" if run["succeeded"] else "no", run["simulated"],
            run["judgements"], sum(run["violations"].values()), "; ".join(run["faults"]), commit(),
        )  # fmt: skip
        with self._file.open("a", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.rows = self._read()  # another command may have added some meanwhile
            self.rows.append(dict(zip(COLUMNS, map(str, values), strict=True)))
            self.rows.sort(key=lambda row: (row["ros"], row["robot"], int(row["world"])))
            self.write()

    def write(self) -> None:
        with self._file.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows)
        before, _, rest = self._readme.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        self._readme.write_text(before + BEGIN + self.text() + END + after, encoding="utf-8")

    def text(self) -> str:
        """Return the sums as a table."""
        lines = []
        for robot in dict.fromkeys(row["robot"] for row in self.rows):
            rows = [row for row in self.rows if row["robot"] == robot]
            mean = fsum(float(row["simulated"]) for row in rows) / len(rows)
            cells = [f"[{robot}]({robot})", done(rows, "1"), done(rows, "2"), f"{mean:.0f} s"]
            cells += [total(rows, "judgements"), total(rows, "violations")]
            lines.append(f"| {' | '.join(cells)} |\n")
        sums = [done(self.rows, "1"), done(self.rows, "2"), ""]
        sums += [total(self.rows, "judgements"), total(self.rows, "violations")]
        lines.append(f"| all | {' | '.join(sums)} |\n")
        commits = ", ".join(dict.fromkeys(row["commit"] for row in self.rows))
        return f"{HEAD}{''.join(lines)}\nAt {commits}.\n"


def done(rows: list[Row], ros: str) -> str:
    """How many did their task, of how many, on a version of ROS."""
    ran = [row["done"] == "yes" for row in rows if row["ros"] == ros]
    return f"{sum(ran)} of {len(ran)}"


def total(rows: list[Row], column: str) -> str:
    return str(sum(int(row[column]) for row in rows))


def commit() -> str:
    """Return the commit that runs, with a plus if something was changed besides the results."""
    short = ["git", "rev-parse", "--short", "HEAD"]
    name = subprocess.run(short, cwd=HERE, capture_output=True, text=True, check=True).stdout
    changed = ["git", "diff", "--quiet", "HEAD", "--", ":/", *(f":!{name}" for name in RESULTS)]
    return name.strip() + ("+" if subprocess.run(changed, cwd=HERE).returncode else "")
