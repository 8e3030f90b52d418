"""Putting a generated package on disk without harm to what is there.

Files that robosc did not write are never replaced, unless that is asked for; files whose content
does not change are not touched, so that nothing is built again; and everything new is complete in
a folder beside the target before the first file moves to its place.
"""

from __future__ import annotations

import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from robosc.emit.package import MARKER, File, Package
from robosc.errors import UsageError

__all__ = ["Written", "write"]

_HEAD = 600
"""The marker stands in the first so many bytes of a file."""


@dataclass(frozen=True)
class Written:
    """What happened: paths below ``folder``, each list in order."""

    folder: Path
    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    removed: tuple[str, ...]


def write(package: Package, folder: Path, force: bool = False) -> Written:
    """Write the package into ``folder/<its name>`` and remove generated files that it lost.

    Raises:
        UsageError: something that robosc did not write is in the way, or the folder cannot be
            written. Nothing has been changed then.
    """
    target = folder / package.name
    try:
        with _undisturbed():
            return _write(package, target, force)
    except OSError as error:
        reason = error.strerror or str(error)
        raise UsageError(f"cannot write {error.filename or target}: {reason}") from error


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Signals that end the program wait until the package is whole; it takes milliseconds."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread receives them
        return
    received: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: received.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for waiting in received:
            signal.raise_signal(waiting)


def _write(package: Package, target: Path, force: bool) -> Written:
    changed = [path for path, file in package.files.items() if not _is_same(target / path, file)]
    _check_way(package, target, changed, force)
    stale = _stale(package, target)
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{package.name}-", dir=target.parent) as name:
        stage = Path(name)
        for path in changed:
            _stage(stage / path, package.files[path])
        for path in changed:
            _clear(target / path)
            (target / path).parent.mkdir(parents=True, exist_ok=True)
            os.replace(stage / path, target / path)  # noqa: PTH105 - atomic, over what is there
    for path in stale:
        (target / path).unlink()
        _remove_empty((target / path).parent, target)
    unchanged = [path for path in package.files if path not in set(changed)]
    return Written(target, tuple(changed), tuple(unchanged), tuple(stale))


def _is_same(path: Path, file: File) -> bool:
    if path.is_symlink() or not path.is_file():
        return False
    executable = bool(path.stat().st_mode & 0o100)
    return executable == file.executable and path.read_bytes() == file.content.encode()


def _check_way(package: Package, target: Path, changed: list[str], force: bool) -> None:
    if force:
        return
    if target.exists() and not target.is_dir():
        raise UsageError(f"{target} is in the way and is no folder")
    strangers = [path for path in changed if _is_strange(target, path)]
    if strangers:
        names = "\n".join(f"  {target / path}" for path in strangers)
        raise UsageError(
            f"not written by robosc, and in the way of package {package.name}:\n{names}\n"
            "(--force replaces them)"
        )


def _is_strange(target: Path, path: str) -> bool:
    """Whether something that robosc did not write stands where a file shall go."""
    for parent in list(Path(path).parents)[:-1]:
        if (target / parent).exists() and not (target / parent).is_dir():
            return True
    place = target / path
    return os.path.lexists(place) and not _is_ours(place)


def _is_ours(path: Path) -> bool:
    if path.is_symlink() or not path.is_file():
        return False
    with path.open("rb") as file:
        return MARKER.encode() in file.read(_HEAD)


def _stale(package: Package, target: Path) -> list[str]:
    """Files that robosc wrote into the package before and that are no part of it any more."""
    if not target.is_dir():
        return []
    found = (path for path in target.rglob("*") if path.is_file() and not path.is_symlink())
    names = (path.relative_to(target).as_posix() for path in found)
    return sorted(
        name
        for name in names
        if name not in package.files and "/." not in f"/{name}" and _is_ours(target / name)
    )


def _stage(path: Path, file: File) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(file.content.encode())
    path.chmod(0o755 if file.executable else 0o644)


def _clear(path: Path) -> None:
    """Make way, which only ``force`` can make necessary: ``os.replace`` needs a file or nothing."""
    for parent in reversed(path.parents):
        if os.path.lexists(parent) and not parent.is_dir():
            parent.unlink()
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)


def _remove_empty(folder: Path, stop: Path) -> None:
    while folder != stop and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent
