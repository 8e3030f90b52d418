"""Where the files lie that robosc brings along beside its code."""

from __future__ import annotations

from pathlib import Path

__all__ = ["templates_folder"]


def templates_folder() -> Path:
    """The folder with ``common/``, ``ros1/`` and ``ros2/``.

    In a checkout, and so in a catkin devel space, whose modules are those of the checkout, it lies
    beside ``src``. Installed by pip or catkin it lies in ``share/robosc`` of the prefix whose
    ``lib/pythonX.Y/site-packages`` (catkin: ``lib/python3/dist-packages``) holds this module.
    """
    package = Path(__file__).resolve().parent
    checkout = package.parents[1] / "templates"
    places = [checkout]
    if len(package.parents) > 3:
        places.append(package.parents[3] / "share" / "robosc" / "templates")
    places.append(package.parent / "share" / "robosc" / "templates")  # pip install --target
    for place in places:
        if (place / "common").is_dir():
            return place
    looked = ", ".join(map(str, places))
    raise FileNotFoundError(f"robosc's templates are missing; looked in {looked}")
