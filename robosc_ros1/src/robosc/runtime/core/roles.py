# Read by who writes robosc, and by what checks types: no package needs it.
"""What an engine asks of the role of a node."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

from .engine_parts import BoundInput, Inputs
from .timers import Timer


class NodeRole(Protocol):
    """The role of an engine, which calls it in the thread that has the turn."""

    @property
    def sends(self) -> bool:
        """Whether it sends commands, which an operator may hold."""

    def begin(self) -> None:
        """Begin in the present state: at the start, and after each :meth:`stand_still`."""

    def observed(self, entries: Inputs, message: Any) -> list[BoundInput]:
        """Apply the events that a message is; return those that were applied."""

    def delayed(self, timer: Timer) -> None:
        """Take a transition whose delay is over."""

    def after(self, writes: frozenset[str], ended: str | None) -> None:
        """Take notice of an event, which wrote these attributes and ended a request (by key), if
        any, when all internal transitions after it were taken."""

    def due(self) -> float | None:
        """Return the seconds until :meth:`act` has something to do; None: it has not."""

    def act(self) -> bool:
        """Apply what is ready by the clock, and do the next that is due; whether there was any."""

    def stand_still(self) -> None:
        """Cancel running goals, whose end is still reported, refuse calls, and send the stop
        command."""

    def let_through(self) -> str | None:
        """Let one command through, though all are held; return why not, if so."""

    def snapshot(self) -> dict[str, Any]:
        """Return what there is to tell of it, beside the state, for use in another thread."""


R = TypeVar("R", bound=NodeRole)
