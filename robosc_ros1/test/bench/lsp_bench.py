"""How soon the language server knows what is wrong after a key, for a model of 500 lines.

Target: diagnostics within 200 ms, the pause of 50 ms that the server makes included.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from large_model import large_model

from robosc.lsp.analysis import Analysis, Desk
from robosc.lsp.completion import complete
from robosc.lsp.tokens import encoded

PAUSE = 50.0
TARGET = 200.0
TYPED = "\n    requirement "


def milliseconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - start)


def main(arguments: list[str]) -> int:
    text = large_model(25)
    with tempfile.TemporaryDirectory() as folder:
        worst = _measure(text, str(Path(folder, "model.rscd")))
    return int(PAUSE + worst > TARGET)


def _measure(text: str, path: str) -> float:
    desk = Desk()
    rows: dict[str, list[float]] = {"diagnostics": [], "completion": [], "semantic tokens": []}
    lines = [i for i, c in enumerate(text) if c == "\n"]
    for end in lines[10 :: len(lines) // 40]:
        desk.put(path, text[:end] + TYPED + text[end:])

        def analysis() -> Analysis:
            found = desk.analysis(path)
            assert found is not None
            return found

        offset = end + len(TYPED)
        rows["diagnostics"].append(milliseconds(analysis))
        rows["completion"].append(milliseconds(lambda at=offset: complete(desk, path, at)))
        rows["semantic tokens"].append(milliseconds(lambda: encoded(analysis())))
    print(f"a key in a model of {len(lines)} lines, milliseconds (median, most)")
    for name, times in rows.items():
        print(f"  {name:16} {statistics.median(times):6.1f} {max(times):6.1f}")
    return statistics.median(rows["diagnostics"])
