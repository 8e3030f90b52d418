"""What robosc does with the definitions and recordings below some folders, such as repositories:
``./dev bench corpus -- FOLDER...``

Of each definition, whether it is read; of each recording, whether ``new --from-bag`` makes a model
of it, ``check`` accepts that, and ``replay`` judges the recording by it. One line for each that is
refused or not judged, with the reason, then the numbers. Nothing is written beside the folders.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from robosc.cli import main as robosc
from robosc.model.ros.definitions import MessageDefinitions
from robosc.model.ros.interfaces import KINDS, Missing
from robosc.model.ros.packages import Packages, Place
from robosc.simulate.bags.bag_files import SUFFIXES

_REFUSED = 2


class Result(NamedTuple):
    what: str
    path: Path
    outcome: str
    reason: str = ""


def definitions(root: Path) -> Iterator[Result]:
    """Each definition of the packages below a folder, read as its package is built."""
    packages = Packages([Place(root, deep=True)])
    read = MessageDefinitions(packages)
    for name, home in sorted(packages.all().items()):
        for folder in KINDS:
            for file in sorted(home.rglob(f"{folder}/**/*.*")):
                if file.suffix not in (f".{folder}", ".idl"):
                    continue
                found = read.interface(name, file.stem, folder)
                if isinstance(found, Missing):
                    yield Result("definition", file, "refused", found.detail or found.reason)
                else:
                    doubts = "; ".join(doubt for part in found.parts for doubt in part.doubts)
                    yield Result("definition", file, "doubted" if doubts else "read", doubts)


def bags(root: Path) -> Iterator[Path]:
    """The recordings below a folder: those of several files once."""
    folders = {file.parent for file in root.rglob("metadata.yaml")}
    yield from sorted(folders)
    for file in sorted(root.rglob("*")):
        known = {*SUFFIXES, ".active"}
        if file.is_file() and file.suffix in known and file.parent not in folders:
            yield file


def recording(bag: Path) -> Iterator[Result]:
    """What becomes of a recording, verb by verb, until one refuses."""
    before = Path.cwd()
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for words, done in (
                (("new", "Robot", "--from-bag", str(bag)), "made"),
                (("check", "robot.rscd"), "accepted"),
                (("replay", "robot.rscd", str(bag)), "judged"),
            ):
                code, said = _robosc(*words)
                refused = code == _REFUSED or (code and words[0] != "replay")
                yield Result(words[0], bag, "refused" if refused else done, said)
                if refused:
                    return
        finally:
            os.chdir(before)


def _robosc(*words: str) -> tuple[int, str]:
    """Exit code, and what is said first of errors, last of anything else."""
    out, err = StringIO(), StringIO()
    try:
        with redirect_stdout(out), redirect_stderr(err):
            code = robosc([*words])
    except Exception as error:  # a bug, which one of many recordings shows
        return _REFUSED, f"BUG {type(error).__name__}: {error}"
    lines = (err if code else out).getvalue().strip().splitlines()
    errors = [line for line in lines if "error" in line]
    return code, (errors or lines[-1:] or [""])[0]


def _all(root: Path) -> Iterator[Result]:
    yield from definitions(root)
    for bag in bags(root):
        yield from recording(bag)


def main(arguments: list[str]) -> int:
    """Print what is refused of some folders, and how many are not. It has no target."""
    counts = Counter[tuple[str, str]]()
    for result in (r for folder in arguments for r in _all(Path(folder).resolve())):
        counts[result.what, result.outcome] += 1
        if result.outcome in ("refused", "doubted"):
            print(f"{result.what} {result.outcome}: {result.path}: {result.reason}", flush=True)
    for (what, outcome), number in sorted(counts.items()):
        print(f"{number:7,} {what} {outcome}")
    return 0
