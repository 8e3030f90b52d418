"""Where the files lie that robosc brings along beside its code."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path


def templates_folder() -> Path:
    """The folder with ``common/``, ``ros1/`` and ``ros2/``."""
    places = _places("robosc_ros1/templates", "templates")
    for place in places:
        if (place / "common").is_dir():
            return place
    looked = ", ".join(map(str, places))
    raise FileNotFoundError(f"robosc's templates are missing; looked in {looked}")


def libraries_folder() -> Path | None:
    """The folder with the libraries that come with robosc, if they were installed."""
    places = _places("robosc_ros1/libraries", "libraries")
    return next((place for place in places if place.is_dir()), None)


def diagnostics_page() -> Path | None:
    """The page that explains the codes of diagnostics, if it was installed."""
    places = _places("docs/diagnostics.md", "docs/diagnostics.md")
    return next((place for place in places if place.is_file()), None)


def section(page: str, code: str) -> str | None:
    """What the page about diagnostics says of a code, as text; None if it does not have it."""
    found = re.search(rf"^### {re.escape(code)}\n(.*?)(?=^##|\Z)", page, re.DOTALL | re.MULTILINE)
    return None if found is None else f"{code}, {_plain(found.group(1)).strip()}"


def _plain(markdown: str) -> str:
    """The text of such a section, as wide as a terminal, with its examples indented."""
    parts = re.split(r"^```.*\n((?:.*\n)*?)```$", markdown, flags=re.MULTILINE)
    text = "".join(
        textwrap.indent(part, "    ") if place % 2 else _filled(part)
        for place, part in enumerate(parts)
    )
    return re.sub(r"\n{3,}", "\n\n", text)


def _filled(prose: str) -> str:
    prose = re.sub(r"\[([^\]]+)\]\(([^)\s]+)\)", r"\1 (docs/\2)", prose)
    quoted = re.sub(r"`([^`\n]+)`", r"'\1'", re.sub(r"^\*(\w+)\*", r"\1", prose, flags=re.M))
    return "".join(
        part if part.isspace() else textwrap.fill(part, 88, break_on_hyphens=False)
        for part in re.split(r"(\n\s*\n|^\n|\n$)", quoted)
    )


def extras_folder() -> Path | None:
    """The folder with libraries that Debian does not package, if ./dev setup has made one."""
    places = _places(".cache/extras", "extras")
    return next((place for place in places if place.is_dir()), None)


def _places(in_checkout: str, installed: str) -> list[Path]:
    """Where something that is no module may lie.

    In a checkout, and so in a catkin devel space, whose modules are those of the checkout, it lies
    in the repository. Installed by pip or catkin it lies in ``share/robosc`` of the prefix whose
    ``lib/pythonX.Y/site-packages`` (catkin: ``lib/python3/dist-packages``) holds this module.
    """
    package = Path(__file__).resolve().parent
    places = []
    if package.parents[1].name == "robosc_ros1":
        places.append(package.parents[2] / in_checkout)
    if len(package.parents) > 3:
        places.append(package.parents[3] / "share" / "robosc" / installed)
    places.append(package.parent / "share" / "robosc" / installed)  # pip install --target
    return places
