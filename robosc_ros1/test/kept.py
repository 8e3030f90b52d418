"""Outputs that the repository keeps byte for byte, and how ``./dev renew`` writes them anew."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Kept"]


@dataclass(frozen=True)
class Kept:
    """Compares outputs with the files that keep them, or writes these files where ``renew`` is set."""

    renew: bool

    def text(self, path: Path, output: str) -> None:
        if self.renew:
            path.write_text(output, encoding="utf-8")
        assert output == path.read_text(encoding="utf-8"), f"wanted? then ./dev renew ({path.name})"

    def folder(self, path: Path, output: Mapping[str, str]) -> None:
        """All files below a folder; ``output`` maps their relative paths to their contents."""
        if self.renew:
            shutil.rmtree(path, ignore_errors=True)
            for name, content in output.items():
                (path / name).parent.mkdir(parents=True, exist_ok=True)
                (path / name).write_text(content, encoding="utf-8")
        kept = {
            file.relative_to(path).as_posix(): file.read_text(encoding="utf-8")
            for file in path.rglob("*")
            if file.is_file()
        }
        assert output == kept, f"wanted? then ./dev renew ({path.name})"
