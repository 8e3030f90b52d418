"""Search for libraries (docs/language.md, "Libraries and prefixes").

The name of a library is the one in its file, not that of the file.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from robosc import errors, resources
from robosc.lazy_dataclasses import dataclass
from robosc.names import IDENTIFIER
from robosc.source import MODEL_SUFFIXES, Source
from robosc.syntax.parser import read_source

Reader = Callable[[str], tuple[Source | None, tuple[errors.Diagnostic, ...]]]
"""Reads a model file, as :func:`robosc.syntax.parser.read_source` does."""

_OWN = tuple(filter(None, [resources.libraries_folder()]))
"""The folder of the libraries that come with robosc."""
_HEAD = re.compile(rf"(?:\s|//[^\n]*|/\*.*?\*/)*library\s+\^?({IDENTIFIER})", re.DOTALL | re.ASCII)


@dataclass(frozen=True)
class Search:
    """The files that declare a library, by their text, and the folders that were searched."""

    files: Mapping[str, str]
    folders: tuple[str, ...]


class LibraryFinder:
    """Finds libraries; reads each folder once. ``share_folders`` are those of ROS packages."""

    def __init__(
        self,
        library_path: Sequence[str],
        share_folders: Callable[[], Sequence[Path]],
        reader: Reader = read_source,
    ) -> None:
        self._reader = reader
        self._library_path = tuple(map(Path, library_path))
        self._share_folders = share_folders
        self._folders: dict[Path, dict[str, list[tuple[str, str]]]] = {}

    def find(self, name: str, importer: str) -> Search:
        """All files that declare the library; ``importer`` is the path of the importing file.

        A library that comes with robosc is that only if there is no other of its name.
        """
        folders = self._folders_for(importer)
        found: dict[str, str] = {}
        seen: set[Path] = set()
        for folder in (*folders, *_OWN):
            if folder in _OWN and found:
                break
            for file, text in self._index(folder).get(name, ()):
                real = Path(file).resolve()
                if real not in seen:
                    seen.add(real)
                    found.setdefault(text, file)
        return Search(found, tuple(dict.fromkeys(map(str, folders))))

    def names(self, importer: str) -> Sequence[str]:
        """The libraries that can be imported from a file, in alphabetical order."""
        folders = (*self._folders_for(importer), *_OWN)
        return sorted({name for folder in folders for name in self._index(folder)})

    def _folders_for(self, importer: str) -> list[Path]:
        home = Path(importer).parent
        return [
            home,
            _above(home) / "shared",
            _above(home) / "libraries",
            *self._library_path,
            *self._share_folders(),
        ]

    def _index(self, folder: Path) -> dict[str, list[tuple[str, str]]]:
        """The libraries of a folder by name: path and text of each."""
        if folder not in self._folders:
            index: dict[str, list[tuple[str, str]]] = {}
            for file in _model_files(folder):
                try:
                    source, _ = self._reader(str(file))
                except errors.UsageError:
                    continue
                match = _HEAD.match(source.text) if source is not None else None
                if source is not None and match:
                    index.setdefault(match[1], []).append((str(file), source.text))
            self._folders[folder] = index
        return self._folders[folder]


def _above(folder: Path) -> Path:
    """The parent of a folder; a relative path stays relative."""
    return folder / ".." if folder.name in ("", "..") and folder != Path("/") else folder.parent


def _model_files(folder: Path) -> list[Path]:
    try:
        return sorted(p for p in folder.iterdir() if p.suffix in MODEL_SUFFIXES and p.is_file())
    except OSError:
        return []
