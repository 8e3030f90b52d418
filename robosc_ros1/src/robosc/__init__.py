"""robosc: from a RoboSC model to a supervisor that is proven, and to a ROS node that runs it.

The names below are the whole public interface (docs/python.md); they are loaded on first use, so
that importing ``robosc`` costs nothing.
"""

# ruff: noqa: F403, F405 - the names are those of interface, which is loaded on first use
from __future__ import annotations

import sys

TYPE_CHECKING = False  # that of typing takes its time to load
if TYPE_CHECKING:
    from robosc.interface import *

__version__ = "0.1.0"
__all__ = [
    "Answer", "Diagnosis", "EmptySupervisorError", "Explored", "Generated", "LineFault",
    "LoadedRobot", "ModelError", "Options", "Output", "RoboscError", "Simulation",
    "StateSpaceError", "Synthesized", "ModelText", "UsageError", "Verified", "check", "explore",
    "export", "generate", "load", "simulate", "synthesize", "verify",
]  # fmt: skip


def __getattr__(name: str) -> object:
    if name in __all__:
        from robosc import interface

        return getattr(interface, name)
    raise AttributeError(f"module 'robosc' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


class _Package(type(sys)):  # type: ignore[misc]
    """The package as a module.

    The subpackage ``simulate`` has the name of the function; whenever it is imported, Python would
    put it in the function's place.
    """

    @property
    def simulate(self) -> object:
        return __getattr__("simulate")

    @simulate.setter
    def simulate(self, subpackage: object) -> None:
        pass


sys.modules[__name__].__class__ = _Package
