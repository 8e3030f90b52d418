"""When which command is sent.

A command is *allowed* where its guard holds and the components consent, whatever the phase of its
own service or action. When an event makes it allowed (an *edge*) it is due at once; while it stays
allowed it is due again every period. Two rules keep a command that is always allowed from flooding
the robot:

* the end of a request (response, error, cancel) is no edge for the next request of the same
  communication, even where a component mirrors its phase; that one waits for the period;
* an edge that comes while the communication's phase forbids the command, or after the command was
  already performed in this round, waits for the period as well.

Periods count from the last time that the command was performed.
"""

from __future__ import annotations

import random
from typing import Any, Callable, List, Optional

from .model import Command, Controller

__all__ = ["Pace", "PacedCommand"]


class PacedCommand:
    """One command: its methods bound to the controller, and where it stands in time."""

    __slots__ = (
        "_state", "allowed", "apply", "busy", "consent", "count", "data", "due", "edge", "key",
        "kind", "requirements", "sort", "was", "when_busy",
    )  # fmt: skip

    def __init__(self, controller: Controller, command: Command, sort: str) -> None:
        def method(name: Optional[str]) -> Optional[Callable[[], Any]]:
            return None if name is None else getattr(controller, name)

        guard: Callable[[], bool] = getattr(controller, command.guard)
        consent = method(command.consent)
        self.allowed = guard if consent is None else _both(consent, guard)
        self.consent = consent
        self.key = command.key
        self.kind = command.kind
        self.sort = sort
        self.busy = command.busy
        self.when_busy = command.kind == "cancel"
        self.data = method(command.data)
        self.apply = method(command.apply)
        self.requirements = command.requirements
        self.was = False  # allowed when last looked at
        self.edge = False
        self.due = 0.0
        self.count = 0
        self._state = controller.__dict__

    @property
    def possible(self) -> bool:
        """Whether the phase of its own communication lets it happen."""
        return self.busy is None or bool(self._state[self.busy]) is self.when_busy


def _both(consent: Callable[[], bool], guard: Callable[[], bool]) -> Callable[[], bool]:
    return lambda: consent() and guard()


class Pace:
    """The order and the times of all commands. Times are those of the port's clock."""

    def __init__(
        self, controller: Controller, rate: float, order: str, seed: Optional[int]
    ) -> None:
        sorts = {c.key: c.sort for c in controller.COMMUNICATIONS}
        self.commands = [PacedCommand(controller, c, sorts[c.key]) for c in controller.COMMANDS]
        self._order = list(self.commands)
        self._period = 1.0 / rate
        self._mode = order
        self._random = random.Random(seed)
        self._edges = False

    def look(self, ended: Optional[str], now: float) -> None:
        """Evaluate every guard after an event; ``ended`` is the key of the request it ended."""
        for command in self.commands:
            if command.allowed():
                if not command.was:
                    command.was = True
                    if command.possible and not (ended == command.key and not command.when_busy):
                        command.edge = self._edges = True
            elif command.was:
                command.was = command.edge = False
            if ended == command.key and command.due <= now:
                command.due += self._period * (1 + (now - command.due) // self._period)

    def next(self, performed: List[PacedCommand], now: float) -> Optional[PacedCommand]:
        """The command to perform now, or None. Forgets edges that cannot be served when None."""
        found = None
        due = []
        for command in self._order:
            is_due = command.was and (command.edge or command.due <= now)
            if is_due and command.possible and command not in performed:
                found = command
                if self._mode != "random":
                    break
                due.append(command)
        if due:
            found = self._random.choice(due)
        if found is None and self._edges:
            self._edges = False
            for command in self.commands:
                command.edge = False
        return found

    def done(self, command: PacedCommand, now: float) -> None:
        """The command was performed, or tried: it rests for a period and queues up last."""
        late = now - command.due
        # On time by the period: keep its beat, so that the rate is met on average.
        on_beat = not command.edge and 0.0 <= late < self._period
        command.due = (command.due if on_beat else now) + self._period
        command.edge = False
        if self._mode == "rotate":
            self._order.remove(command)
            self._order.append(command)

    def wake(self, now: float) -> Optional[float]:
        """Seconds until the next command is due, or None. Survives a clock that was set back."""
        earliest = None
        for command in self.commands:
            if command.was and command.possible:
                if command.due > now + self._period:  # time jumped back
                    command.due = now + self._period
                if earliest is None or command.due < earliest:
                    earliest = command.due
        return None if earliest is None else max(0.0, earliest - now)
