"""Putting a generated package on disk without harm to what is there.

Files that robosc did not write, or that somebody changed since, are never replaced unless that is
asked for, and folders not even then; files whose content does not change are not touched, so that
nothing is built again. What the user is meant to edit stays: files in ``config/`` that were
changed, and the lines that they have put into regions for that. The new package is made complete
beside the old one and takes its place in one step: whatever ends robosc meanwhile, the folder holds
the one or the other.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import re
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from difflib import unified_diff
from hashlib import sha256
from itertools import islice
from pathlib import Path

from robosc import errors, limits
from robosc.emit.package.package import MARKER, File, Package
from robosc.lazy_dataclasses import dataclass

# Regions of generated files that belong to the user and outlive the next generation.
#
# A region lies between two lines that say so, in whatever the file has for comments: dependencies
# and nodes of the user's own go there.


_REGION = re.compile(
    r"(begin of your own lines\b[^\n]*\n)(.*?)(^[^\n]*\bend of your own lines\b)",
    re.DOTALL | re.MULTILINE,
)


def own_lines(text: str) -> str:
    """Return what stands in the region of a text; empty if nothing does, or without a region."""
    found = _REGION.search(text)
    return "" if found is None else found[2]


def with_own_lines(text: str, lines: str) -> str:
    """Return the text with these lines in its region; the same text if it has none."""
    return _REGION.sub(lambda found: found[1] + lines + found[3], text, count=1)


def text_of(path: Path) -> str:
    """Return the content of a file; empty if there is no file, or no text in it."""
    try:
        return path.read_bytes().decode()
    except (OSError, UnicodeDecodeError):
        return ""


# What robosc wrote into a package, so that it knows later what is still as it left it.  The
# record is a file of the package. It has the layout of ``sha256sum``, so that ``sha256sum
# --check`` shows a person, too, which files were changed by hand.


RECORD = "generated.sha256"

_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


def record_of(package: Package) -> File:
    """The record of a package's files, as they are without lines of the user's own."""
    target = f" for {package.target}" if package.target else ""
    lines = [f"# What was {MARKER}{target}; it replaces and removes only what is still the same."]
    lines += [f"{_hash(file.content.encode())}  {path}" for path, file in package.files.items()]
    return File("\n".join(lines) + "\n")


def recorded_target(folder: Path) -> str:
    """The version of ROS that the package in a folder is for; empty if that is not recorded."""
    found = re.match(rf"# What was {MARKER} for (\w+);", text_of(folder / RECORD))
    return "" if found is None else found[1]


def read_record(folder: Path) -> dict[str, str] | None:
    """The hashes by path; empty without a record, None if the file is none.

    Lines that are not as robosc writes them count for nothing, as after a failed merge: what they
    spoke of is then a file that anybody may have written.
    """
    place = folder / RECORD
    if not place.is_symlink() and not place.exists():
        return {}
    if place.is_symlink() or not place.is_file():
        return None
    text = place.read_text(encoding="utf-8", errors="replace")
    if MARKER not in text.partition("\n")[0]:
        return None
    found = (_LINE.fullmatch(line) for line in text.splitlines())
    return {match[2]: match[1] for match in found if match and _is_below(match[2])}


def is_as_recorded(folder: Path, path: str, record: Mapping[str, str]) -> bool:
    """Whether a file of the package has the content that robosc gave it, the user's own lines
    apart."""
    place = folder / path
    if path not in record or not place.is_file():
        return False
    if any((folder / part).is_symlink() for part in (Path(path), *Path(path).parents)):
        return False  # it lies somewhere else, whatever it is
    own = with_own_lines(text_of(place), "").encode()
    return record[path] in (_hash(place.read_bytes()), _hash(own))


def _hash(content: bytes) -> str:
    return sha256(content).hexdigest()


def _is_below(path: str) -> bool:
    return not path.startswith("/") and ".." not in Path(path).parts


# Atomic replacement of a folder by another one.


_AT_FDCWD = -100
_RENAME_EXCHANGE = 2


def exchange(first: Path, second: Path) -> None:
    """Each takes the other's name, at once: nobody ever sees neither or a mixture (renameat2(2)).

    Raises OSError where the system or the file system cannot do this, as on a mount point.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    if not hasattr(libc, "renameat2"):
        raise OSError("this system cannot exchange two folders")
    names = os.fsencode(first), os.fsencode(second)
    if libc.renameat2(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number), str(second))


def link_tree(source: Path, target: Path, left_out: Collection[str]) -> None:
    """The files below ``source``, but those left out, below ``target`` too: hard links, no copies.

    Raises OSError where something cannot be linked or owned, as across mounts.
    """
    folders = []
    for name, below, files in os.walk(source, onerror=_fail):
        here = Path(name).relative_to(source)
        folders.append(here)
        (target / here).mkdir(exist_ok=True)
        links = [folder for folder in below if (source / here / folder).is_symlink()]
        for path in (here / file for file in files + links):
            if path.as_posix() not in left_out:
                os.link(source / path, target / path, follow_symlinks=False)
    for here in reversed(folders):  # at last, because a folder may be read-only
        status = (source / here).stat()
        os.chown(target / here, status.st_uid, status.st_gid)
        shutil.copystat(source / here, target / here)


def rescue(old: Path, new: Path, left_out: Collection[str]) -> None:
    """Move to ``new`` what somebody saved in ``old`` while ``new`` was being made from it."""
    for folder, _, files in os.walk(old):
        for name in files:
            source = Path(folder) / name
            path = source.relative_to(old)
            place = new / path
            same = place.exists() and os.path.samestat(source.lstat(), place.lstat())
            if not same and path.as_posix() not in left_out and place.parent.is_dir():
                os.replace(source, place)  # noqa: PTH105 - atomic, over what is there


def _fail(error: OSError) -> None:
    raise error


@dataclass(frozen=True)
class Written:
    """What happened: paths below ``folder``, each list in order.

    ``edited`` are configuration files that were changed by hand and stay as they are, each with
    the settings in which it differs from the package, as lines of a diff; ``kept`` are files that
    are no part of the package any more, but were changed by hand.
    """

    folder: Path
    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    removed: tuple[str, ...]
    edited: Mapping[str, tuple[str, ...]]
    kept: tuple[str, ...]


def write(
    package: Package, folder: Path, force: bool = False, location: Path | None = None
) -> Written:
    """Write the package into ``folder/<its name>`` and remove generated files that it lost.

    ``location`` is another folder that shall become the package itself.

    Raises:
        UsageError: something that robosc did not write, or that was changed since, is in the way,
            or the folder cannot be written. Nothing has been changed then.
    """
    target = folder / package.name if location is None else location
    try:
        with _undisturbed():
            return _write(package, target, force)
    except OSError as error:
        reason = error.strerror or str(error)
        place = str(error.filename or target)
        if _STAGE.format(target.name) in place:  # a name that is none of the user's business
            place = str(target)
        raise errors.UsageError(f"cannot write {place}: {reason}") from error


def difference(
    package: Package, folder: Path, force: bool = False, location: Path | None = None
) -> str:
    """What :func:`write` would change, as a unified diff; it writes nothing.

    Raises:
        UsageError: as :func:`write`.
    """
    target = folder / package.name if location is None else location
    _demand_folders(target)
    present = target.resolve()
    plan = _plan(package, target, present, force)
    wanted = {path: file.content for path, file in plan.fresh.items()}
    wanted.update(dict.fromkeys(plan.stale, ""))
    lines: list[str] = []
    for path in sorted(wanted.keys() - {RECORD}):
        name = str(target / path)
        is_there = (present / path).is_file()
        lines += unified_diff(
            text_of(present / path).splitlines(keepends=True),
            wanted[path].splitlines(keepends=True),
            name if is_there else os.devnull,
            os.devnull if path in plan.stale else name,
        )
    return "".join(line if line.endswith("\n") else f"{line}\n" for line in lines)


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


@dataclass(frozen=True)
class _Change:
    """What is to be done to the package in ``folder``, links followed.

    ``fresh`` are the files that are new or different, ``gone`` the paths whose present content
    shall not be there any more, replaced or removed.
    """

    folder: Path
    fresh: Mapping[str, File]
    gone: frozenset[str]


def _demand_folders(target: Path) -> None:
    for parent in target.parents:
        if (parent.exists() or parent.is_symlink()) and not parent.is_dir():
            raise errors.UsageError(
                f"{parent} is no folder: name the one that is to get the package {target.name}"
            )


def _write(package: Package, target: Path, force: bool) -> Written:
    _demand_folders(target)
    if target.is_symlink() and not target.exists():
        raise errors.UsageError(f"{target} is a dangling link")
    folder = target.resolve()
    folder.parent.mkdir(parents=True, exist_ok=True)
    with _alone(folder.parent):
        _sweep(folder)
        return _update(package, target, folder, force)


@dataclass(frozen=True)
class _Plan:
    """What the package and what is in its folder call for. ``files`` are all that belong there,
    ``fresh`` those of them that are new or different."""

    files: Mapping[str, File]
    fresh: Mapping[str, File]
    gone: tuple[str, ...]
    stale: tuple[str, ...]
    edited: Mapping[str, tuple[str, ...]]
    kept: tuple[str, ...]


def _plan(package: Package, target: Path, folder: Path, force: bool) -> _Plan:
    record = read_record(folder) or {}
    if not force:
        _demand_target(package, target, folder)
    files = {**package.files, RECORD: record_of(package)}
    edited = {
        path: tuple(_differences(text_of(folder / path), file.content))
        for path, file in files.items()
        if not force and _is_edited(folder, path, record)
    }
    files = {
        path: replace(file, content=with_own_lines(file.content, own_lines(text_of(folder / path))))
        for path, file in files.items()
        if path not in edited
    }
    fresh = {path: file for path, file in files.items() if not _is_same(folder / path, file)}
    gone = _make_way(folder, target, list(fresh), record, force)
    lost = [p for p in sorted(record) if p not in package.files and (folder / p).exists()]
    stale = [
        path
        for path in lost
        if is_as_recorded(folder, path, record) and not own_lines(text_of(folder / path))
    ]
    kept = [path for path in lost if path not in stale]
    return _Plan(files, fresh, tuple(gone), tuple(stale), edited, tuple(kept))


def _update(package: Package, target: Path, folder: Path, force: bool) -> Written:
    plan = _plan(package, target, folder, force)
    if plan.fresh or plan.stale:
        _apply(_Change(folder, plan.fresh, frozenset(plan.gone + plan.stale)))
    unchanged = tuple(path for path in plan.files if path not in plan.fresh)
    return Written(target, tuple(plan.fresh), unchanged, plan.stale, plan.edited, plan.kept)


def _demand_target(package: Package, target: Path, folder: Path) -> None:
    """Raise UsageError if the package in the folder is for another version of ROS."""
    present = recorded_target(folder)
    if present and package.target and present != package.target:
        raise errors.UsageError(
            f"{target} holds a package for {present}, and this one is for {package.target}: choose"
            " another folder with --output, or another name with --package\n"
            "(--force replaces the package)"
        )


def _is_edited(folder: Path, path: str, record: Mapping[str, str]) -> bool:
    """Whether a file is one that its user may change, and did."""
    place = folder / path
    return (
        path.startswith("config/")
        and path in record
        and place.is_file()
        and not place.is_symlink()
        and not is_as_recorded(folder, path, record)
    )


def _differences(present: str, wanted: str) -> Iterator[str]:
    """Yield the lines of a diff between two files of settings, but for blank ones and comments."""

    def settings(text: str) -> list[str]:
        return [line for line in text.splitlines() if line.strip() and line.lstrip()[0] != "#"]

    diff = unified_diff(settings(present), settings(wanted), n=0, lineterm="")
    return (line for line in islice(diff, 2, None) if not line.startswith("@@"))


def _is_same(path: Path, file: File) -> bool:
    if path.is_symlink() or not path.is_file():
        return False
    executable = bool(path.stat().st_mode & 0o100)
    return executable == file.executable and path.read_bytes() == file.content.encode()


# --- what is in the way --------------------------------------------------------------------------


def _make_way(
    folder: Path, target: Path, fresh: Sequence[str], record: Mapping[str, str], force: bool
) -> list[str]:
    """What is replaced by the fresh files.

    Raises UsageError if robosc may not replace it.
    """
    found = {path: fault for name in fresh for path, fault in _in_the_way(folder, name, record)}
    refused = {p: fault for p, fault in found.items() if (fault and not force) or fault == _FOLDER}
    if refused:
        lines = [f"  {target / path}: {fault}" for path, fault in refused.items()]
        raise errors.UsageError(
            "\n".join([f"in the way of package {target.name}:", *lines, _remedy(refused)])
        )
    return list(found)


_FOLDER = "a folder where a file must go"


def _remedy(refused: Mapping[str, str]) -> str:
    if _FOLDER in refused.values():
        return "(move folders away yourself; --force replaces files only)"
    return "\n".join((*_places_for_changes(refused), "(--force replaces what is there)"))


def _places_for_changes(refused: Iterable[str]) -> Iterator[str]:
    """Where what people change in generated files has a place that stays."""
    names = {Path(path).name for path in refused}
    if names & {"package.xml", "setup.py"}:
        yield "maintainer, email, license and version are set in robosc.yaml, beside the model"
    if names & {"package.xml", "setup.py", "CMakeLists.txt"}:
        yield "dependencies and nodes of your own go between the lines 'of your own lines'"
    if any(path.startswith("launch/") for path in refused):
        yield "a launch file of your own, which includes the generated one, stays"


def _in_the_way(folder: Path, name: str, record: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """What has to go for the file ``name``, with what speaks against it; empty if nothing does."""
    for parent in reversed(Path(name).parents):
        if os.path.lexists(folder / parent) and not _is_plain_folder(folder / parent):
            yield parent.as_posix(), "not a plain folder, but files must go below it"
            return
    place = folder / name
    if _is_plain_folder(place):
        yield name, _FOLDER
    elif os.path.lexists(place):
        yield name, _objection(folder, name, record)


def _is_plain_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _objection(folder: Path, name: str, record: Mapping[str, str]) -> str:
    if is_as_recorded(folder, name, record):
        return ""
    if name == RECORD and read_record(folder) is not None:
        return ""
    return "changed since it was generated" if name in record else "not written by robosc"


# --- doing it ------------------------------------------------------------------------------------


def _apply(change: _Change) -> None:
    folder = change.folder
    with _stage(folder, folder.parent) as stage:
        new = stage / folder.name
        _fill(new, change.fresh)
        if not os.path.lexists(folder):
            new.rename(folder)
            return
        if _take_place(new, change):
            rescue(new, folder, change.gone)
            return
    _one_by_one(change)


def _take_place(new: Path, change: _Change) -> bool:
    """Let the folder ``new`` and the present one change places, if they can."""
    folder = change.folder
    try:
        if folder.is_dir():
            link_tree(folder, new, change.gone)
            _remove_empty(new, change)
        exchange(new, folder)
    except OSError:
        return False  # a mount point, files of somebody else: the other way reports what is wrong
    return True


def _one_by_one(change: _Change) -> None:
    """File by file, each at once, where the whole folder cannot be exchanged."""
    folder = change.folder
    if not folder.is_dir():
        folder.unlink()
        folder.mkdir()
    with _stage(folder, folder) as stage:
        _fill(stage, change.fresh)
        for path in sorted(change.gone - change.fresh.keys()):
            (folder / path).unlink(missing_ok=True)
        for path in change.fresh:
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            os.replace(stage / path, folder / path)  # noqa: PTH105 - atomic, over what is there
    _remove_empty(folder, change)


def _fill(folder: Path, files: Mapping[str, File]) -> None:
    folder.mkdir(exist_ok=True)
    for path, file in files.items():
        place = folder / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(file.content.encode())
        place.chmod(0o755 if file.executable else 0o644)


def _remove_empty(folder: Path, change: _Change) -> None:
    """Remove the folders that hold nothing any more since their files are gone."""
    for path in sorted(change.gone - change.fresh.keys()):
        for parent in list(Path(path).parents)[:-1]:
            place = folder / parent
            if place.is_dir() and not any(place.iterdir()):
                place.rmdir()


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One robosc at a time writes packages into a folder, where its file system has locks.

    Raises UsageError if another one does not come to an end.
    """
    place = os.open(folder, os.O_RDONLY)
    try:
        _lock(place, folder)
        yield
    finally:
        os.close(place)


def _lock(place: int, folder: Path) -> None:
    deadline = time.monotonic() + limits.WRITING_SECONDS
    while True:
        try:
            fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > deadline:
                message = f"another robosc is writing a package into {folder}"
                raise errors.UsageError(message) from None
            time.sleep(0.02)
        except OSError:
            return  # this file system has none
        else:
            return


_STAGE = ".robosc-{}-"


@contextmanager
def _stage(folder: Path, place: Path) -> Iterator[Path]:
    """A hidden folder for the new files; tools that search for packages pass it over."""
    with tempfile.TemporaryDirectory(prefix=_STAGE.format(folder.name), dir=place) as name:
        yield Path(name)


def _sweep(folder: Path) -> None:
    """Remove what a robosc left behind that was killed."""
    for place in (folder.parent, folder):
        for left in place.glob(f"{_STAGE.format(folder.name)}*"):
            shutil.rmtree(left, ignore_errors=True)
