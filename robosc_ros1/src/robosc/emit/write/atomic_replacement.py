"""Atomic replacement of a folder by another one."""

from __future__ import annotations

import ctypes
import os
import shutil
from collections.abc import Collection
from pathlib import Path

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
