"""The frames of a robot, as its nodes tell them on ``/tf`` and ``/tf_static``."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any, NamedTuple

from robosc.names import is_frame
from robosc.runtime.core.transforms import plain

TOPICS = {"/tf": False, "/tf_static": True}
"""Whether what comes there is static."""
_BASES = ("base_link", "base_footprint")
"""How the frames of robots that drive end (REP 105)."""


class RobotFrame(NamedTuple):
    """The transform from the frame above all others to that of the robot; ``arrivals`` are the
    times of its links that are not static, ``frames`` all frames of the tree."""

    source: str
    target: str
    arrivals: list[float]
    frames: tuple[str, ...]

    @property
    def name(self) -> str:
        return f"/tf from {self.source} to {self.target}"


class Frames:
    """The links that were heard."""

    def __init__(self) -> None:
        self._parents: dict[str, str] = {}
        self._arrivals = defaultdict[str, "list[float]"](list)

    def hear(self, message: Any, time: float, *, is_static: bool) -> None:
        for link in getattr(message, "transforms", ()):
            child, parent = plain(link.child_frame_id), plain(link.header.frame_id)
            if is_frame(child) and is_frame(parent):
                self._parents[child] = parent
                if not is_static:
                    self._arrivals[child].append(time)

    def chains(self) -> tuple[RobotFrame, ...]:
        """Those from which a robot knows where it is: one for each robot."""
        found = {frame: [*self._above(frame)] for frame in self._parents}
        trees = {frame: above for frame, above in found.items() if above[-1] not in self._parents}
        named = ([f for f in trees if f.endswith(end)] for end in _BASES)
        bases = next((frames for frames in named if frames), [])
        return tuple(
            RobotFrame(
                trees[base][-1],
                base,
                sorted(time for frame in trees[base] for time in self._arrivals[frame]),
                (trees[base][-1], *sorted(f for f in trees if trees[f][-1] == trees[base][-1])),
            )
            for base in bases
        )

    def _above(self, frame: str) -> Iterator[str]:
        """The frame and those above it, each once."""
        seen: set[str] = set()
        while frame not in seen:
            seen.add(frame)
            yield frame
            frame = self._parents.get(frame, frame)
