"""Writes a file whole: what was there stays until all of its new content is written."""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path

_NOT_REPLACED = (errno.EACCES, errno.EPERM, errno.EBUSY)
"""Files in folders of somebody else, and those that are mounted, cannot be replaced."""


def write_whole(path: Path, data: bytes) -> None:
    """Write a file, so that one who is interrupted, or has no space left, keeps the one before.

    Raises OSError if that cannot be done.
    """
    if path.exists() and not path.is_file():  # a pipe, a terminal
        path.write_bytes(data)
        return
    place = path.resolve()  # links stay
    try:
        _replace(place, data)
    except OSError as error:
        if error.errno not in _NOT_REPLACED:
            raise
        place.write_bytes(data)


def _replace(place: Path, data: bytes) -> None:
    new = place.with_name(f".robosc-{os.getpid()}")
    try:
        with new.open("xb") as file:
            file.write(data)
        if place.exists():
            status = place.stat()
            shutil.copymode(place, new)
            os.chown(new, status.st_uid, status.st_gid)
        os.replace(new, place)  # noqa: PTH105 - atomic, over what is there
    except BaseException:
        new.unlink(missing_ok=True)
        raise
