"""robosc: from a RoboSC model to a supervisor that is proven, and to a ROS node that runs it.

The functions below are the whole public interface; each is loaded on first use, so that importing
``robosc`` costs nothing.
"""

from __future__ import annotations

TYPE_CHECKING = False  # that of typing takes its time to load
if TYPE_CHECKING:
    from robosc.pipeline import (
        Options,
        Output,
        check,
        explore,
        export,
        generate,
        load,
        supervise,
        synthesize,
        verify,
    )

__version__ = "0.1.0"
__all__ = [
    "Options",
    "Output",
    "check",
    "explore",
    "export",
    "generate",
    "load",
    "supervise",
    "synthesize",
    "verify",
]


def __getattr__(name: str) -> object:
    if name in __all__:
        from robosc import pipeline

        return getattr(pipeline, name)
    raise AttributeError(f"module 'robosc' has no attribute {name!r}")
