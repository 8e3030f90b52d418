"""The gallery's table: rows are kept, and added to by the next command."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import table
from table import Table


def run(world: str, seed: int, succeeded: bool = True) -> dict[str, Any]:
    return {
        "world": world, "seed": seed, "succeeded": succeeded, "simulated": 12.0,
        "judgements": 100, "violations": {} if succeeded else {"stays": 2}, "faults": ["silent"],
    }  # fmt: skip


def test_second_command_adds_rows_to_those_of_the_first(tmp_path: Path) -> None:
    readme = tmp_path / "README.md"
    readme.write_text(f"# Gallery\n\n{table.BEGIN}{table.END}\nMore.\n", encoding="utf-8")
    Table(tmp_path).add(1, run("maze", 2))
    second = Table(tmp_path)
    assert second.has(1, "maze", 2) and not second.has(2, "maze", 2)
    second.add(2, run("maze", 2, succeeded=False))
    second.add(1, run("maze", 10))
    assert [row["world"] for row in Table(tmp_path).rows] == ["2", "10", "2"]
    text = readme.read_text(encoding="utf-8")
    assert "| [maze](maze) | 2 of 2 | 0 of 1 | 12 s | 300 | 2 |" in text
    assert text.startswith("# Gallery\n") and text.endswith("\nMore.\n")
    assert table.commit() in text


def test_tables_sums_are_those_of_its_rows() -> None:
    kept = Table()
    assert kept.rows
    readme = (Path(table.__file__).parent / "README.md").read_text(encoding="utf-8")
    assert kept.text() in readme
