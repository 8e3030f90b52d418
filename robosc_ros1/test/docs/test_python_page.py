"""The page about Python is a notebook that runs: its blocks, in order, print what it shows."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import pytest

import robosc

PAGE = Path(__file__).parents[3] / "docs" / "python.md"
CELL = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", re.M | re.S)


def test_cells_print_what_the_page_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = PAGE.read_text(encoding="utf-8")
    cells = list(CELL.finditer(text))
    assert len(cells) == text.count("```python\n") and len(cells) > 5
    names: dict[str, Any] = {}
    for cell in cells:
        out = io.StringIO()
        line = text.count("\n", 0, cell.start()) + 1
        with redirect_stdout(out):
            exec(compile("\n" * line + cell[1], str(PAGE), "exec"), names)
        # '…' stands for the rest of a line, and alone on a line for any number of lines.
        pattern = re.escape(cell[2] or "")
        pattern = re.sub(r"^…\\\n", "(?:.*\n)*", pattern, flags=re.M).replace("…", ".*")
        assert re.fullmatch(pattern, out.getvalue()), f"line {line}: {out.getvalue()}"
    assert (tmp_path / "src" / "cart_controller" / "package.xml").is_file()


def test_the_page_names_all_that_there_is() -> None:
    text = PAGE.read_text(encoding="utf-8")
    results = {"Answer"}  # what do() returns, of which the page shows the fields
    assert [n for n in robosc.__all__ if f"{n}" not in text and n not in results] == []
