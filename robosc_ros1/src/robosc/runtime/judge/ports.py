# Read by who writes robosc, and by what checks types: no package needs it.
"""What the engines of judges ask of the middleware."""

from __future__ import annotations

from typing import Any

from ..core.interfaces import Port
from .judge import JudgingPort


class MonitorPort(JudgingPort, Port):
    """A port that sends nothing to the robot."""

    def found(self, text: str) -> None:
        """Publish the document of a finding on ``~findings``."""


class SupervisorPort(JudgingPort, Port):
    """A port on which ``data`` are the payloads from the other controller, passed on unchanged."""

    def blocked(self, text: str) -> None:
        """Publish a document about a blocked command on ``~blocked``."""
        raise NotImplementedError

    def composed(self, key: str, data: dict[str, Any] | None) -> Any:
        """Return the message with the given fields that :meth:`send` would send, as it will
        arrive."""
        raise NotImplementedError
