"""The engine: one thread that owns the state, a queue before it, nothing that blocks.

Whatever the robot does is put into the queue by the middleware's threads. The engine takes each
input in order of arrival, applies it to the controller, settles, and when the queue is drained
performs the commands that are due (see :mod:`.pace`), settling after each. Between two commands it
looks into the queue again, so that no command is sent from an older state than need be.

``cycle`` does all of that once and never blocks; ``run`` calls it for ever.
"""

from __future__ import annotations

import threading
import time
import traceback
from queue import Empty, SimpleQueue
from typing import Any, Callable, Dict, List, Optional, Tuple, Union

from .calls import Calls
from .journal import Journal, Throttle
from .model import Controller, Input, Tau
from .pace import Pace, PacedCommand
from .port import Port
from .settings import Settings
from .values import Mismatch

__all__ = ["Engine"]

_ENDS = ("response", "error")


class _BoundInput:
    """An input with its methods bound, and what the queue needs to know of it."""

    __slots__ = ("apply", "call", "ends", "key", "kind", "name", "read")

    def __init__(self, controller: Controller, entry: Input, name: str, call: bool) -> None:
        self.key = entry.key
        self.kind = entry.kind
        self.name = name
        self.call = call  # belongs to a request of a service or an action
        self.ends = entry.key if call and entry.kind in _ENDS else None
        self.read: Optional[Callable[[Any], Any]] = (
            None if entry.read is None else getattr(controller, entry.read)
        )
        self.apply: Callable[[Any], None] = getattr(controller, entry.apply)


_Item = Union[Tuple[_BoundInput, Any, int], Callable[[], None], None]
"""An input with its message and token, something to do between two events, or just a reason to look
at the clock."""


class Engine:
    """Executes a controller against a port. All public methods may be called from any thread but
    ``run``, ``begin`` and ``cycle``, which are the engine thread's."""

    def __init__(
        self,
        controller: Controller,
        port: Port,
        settings: Optional[Settings] = None,
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        self.settings = settings or Settings()
        self.controller = controller
        self.journal = Journal()
        self.stopped: Optional[str] = None
        """Why a safe stop was made, or None."""
        self.changed = threading.Event()
        """Set after a cycle in which something happened, for a reporter."""
        self._port = port
        self._steady = steady
        self._names = {c.key: c.name for c in controller.COMMUNICATIONS}
        sorts = {c.key: c.sort for c in controller.COMMUNICATIONS}
        self._inputs = {
            (i.key, i.kind): _BoundInput(
                controller, i, self._names[i.key], sorts[i.key] in ("service", "action")
            )
            for i in controller.INPUTS
        }
        self._taus: List[Tuple[Tau, Callable[[], Optional[str]]]] = [
            (tau, getattr(controller, tau.step)) for tau in controller.TAUS
        ]
        self._pace = Pace(controller, self.settings.rate, self.settings.order, self.settings.seed)
        self._calls = Calls(
            self.settings.timeout_of,
            self.settings.goal_timeout_of,
            self.settings.server_lost_after,
            port.silence,
        )
        self._throttle = Throttle()
        self._queue: "SimpleQueue[_Item]" = SimpleQueue()
        self._undefined = 0
        self._closing = False

    # From any thread

    def post(self, key: str, kind: str, message: Any = None) -> None:
        """The robot sent a message; it is converted on the engine thread."""
        self._queue.put((self._inputs[key, kind], message, 0))

    def poster(self, key: str, kind: str) -> Callable[[Any], None]:
        """A function that posts messages of one sort: the quick way for subscribers."""
        put, entry = self._queue.put, self._inputs[key, kind]
        return lambda message: put((entry, message, 0))

    def report(self, key: str, token: int, kind: str, payload: Any = None) -> None:
        """A request went on: "accepted", "feedback", "response", or "error" with the reason."""
        if kind == "accepted":
            self._queue.put(lambda: self._calls.accept(key, token, self._steady()))
        else:
            self._queue.put((self._inputs[key, kind], payload, token))

    def invoke(self, function: Callable[[], None]) -> None:
        """Have the engine thread call the function between two events."""
        self._queue.put(function)

    def wake(self) -> None:
        """Have the engine look at its clock again: simulated time went on."""
        self._queue.put(None)

    def stop(self, reason: str) -> None:
        """Make a safe stop."""
        self._queue.put(lambda: self._safe_stop(reason))

    def close(self) -> None:
        """Cancel what runs, send the stop command, and let ``run`` return."""
        self._queue.put(self._close)

    @property
    def backlog(self) -> int:
        return self._queue.qsize()

    # The engine thread

    def run(self) -> None:
        """Execute until closed."""
        self.begin()
        while not self._closing:
            try:
                item = self._queue.get(timeout=self.patience())
            except Empty:
                item = None
            self.cycle(item)

    def begin(self) -> None:
        """Take the first steps, before any input. What is allowed at first is due at once."""
        self._guarded(self._begin)

    def _begin(self) -> None:
        for command in self._pace.commands:
            command.due = self._port.now()
        self._settle()
        self._pace.look(None, self._port.now())

    def patience(self) -> Optional[float]:
        """Seconds until the engine has to act on its own; None: not without an input."""
        pace = None if self.stopped else self._pace.wake(self._port.now())
        if self._calls.earliest is None:
            return pace
        call = max(0.0, self._calls.earliest - self._steady())
        return call if pace is None else min(pace, call)

    def cycle(self, item: _Item = None) -> None:
        """Handle the item and all that is queued, then perform each command that is due, once."""
        self._guarded(lambda: self._cycle(item))

    def _guarded(self, function: Callable[[], None]) -> None:
        """No exception ends the engine: one that is unforeseen makes a safe stop."""
        number = self.journal.number
        try:
            function()
        except Exception:
            self._log("error", "internal", "unexpected error:\n" + traceback.format_exc())
            try:
                self._safe_stop("internal error: " + traceback.format_exc(limit=0).strip())
            except Exception:
                self._log("error", "internal", traceback.format_exc())
        if self.journal.number != number and not self.changed.is_set():
            self.changed.set()

    def _cycle(self, item: _Item) -> None:
        if item is not None:
            self._take(item)
        performed: List[PacedCommand] = []
        while True:
            self._drain()
            if self.stopped is not None or self._closing:
                return
            command = self._pace.next(performed, self._port.now())
            if command is None:
                return
            performed.append(command)
            self._perform(command)

    def _drain(self) -> None:
        # Only what is there already: a flood of inputs must not keep commands from being sent.
        for _ in range(self._queue.qsize()):
            try:
                item = self._queue.get_nowait()
            except Empty:
                break
            if item is not None:
                self._take(item)
        earliest = self._calls.earliest
        if earliest is not None and earliest <= self._steady():
            for key, reason in self._calls.expired(self._steady()):
                self._end_by_deadline(key, reason)

    # Inputs

    def _take(self, item: Union[Tuple[_BoundInput, Any, int], Callable[[], None]]) -> None:
        if not isinstance(item, tuple):
            item()
            return
        entry, message, token = item
        if entry.call:
            if not self._calls.is_current(entry.key, token):
                self.journal.counters["late"] += 1
                return
            if entry.ends is not None:
                self._calls.end(entry.key)
        self._input(entry, message)

    def _end_by_deadline(self, key: str, reason: str) -> None:
        token = self._calls.end(key)
        if token is not None:
            self._port.abandon(key, token)
            self._input(self._inputs[key, "error"], reason)

    def _input(self, entry: _BoundInput, message: Any) -> None:
        value = None
        try:
            if entry.read is not None:
                value = entry.read(message)
            entry.apply(value)
        except Mismatch as mismatch:
            self._mismatch(entry, value, str(mismatch))
            return
        except (AttributeError, TypeError, ValueError, OverflowError, LookupError) as error:
            # The message is not what the model says it is.
            self._mismatch(entry, value, "%s: %s" % (type(error).__name__, error))
            return
        detail = None
        self.journal.counters["inputs"] += 1
        if entry.kind == "error":
            detail = str(message)
            self.journal.counters["errors"] += 1
            self._log("warning", entry.key, "%s failed: %s" % (entry.name, detail))
        self.journal.note(entry.kind, entry.name, value, "applied", detail)
        self._after(entry.ends)

    def _mismatch(self, entry: _BoundInput, value: Any, reason: str) -> None:
        counters = self.journal.counters
        counters["mismatches"] += 1
        self.journal.note(entry.kind, entry.name, value, "mismatch", reason)
        self._log("warning", entry.key, "%s from %s: %s" % (entry.kind, entry.name, reason))
        if entry.ends is not None and entry.kind != "error":
            # The request is over all the same, and must end in some way.
            self._input(self._inputs[entry.key, "error"], "unusable response: " + reason)
        elif entry.kind == "error":
            self._safe_stop("the end of %s cannot be applied: %s" % (entry.name, reason))
        if self.settings.on_mismatch == "stop":
            self._safe_stop("mismatch: " + reason)

    def _after(self, ended: Optional[str]) -> None:
        if self._taus:
            self._settle()
        undefined = self.controller.undefined
        if undefined:
            total = sum(undefined.values())
            if total != self._undefined:
                self._undefined = self.journal.counters["undefined"] = total
                self._log("warning", "undefined", "undefined value: an array was too short")
        self._pace.look(ended, self._port.now())

    def _settle(self) -> None:
        """Take enabled taus in source order until none is left."""
        steps = 0
        moved = True
        while moved:
            moved = False
            for tau, step in self._taus:
                path = step()
                if path is not None:
                    moved = True
                    steps += 1
                    self.journal.counters["taus"] += 1
                    self.journal.note("tau", tau.component, path, tau=tau.number)
                    if steps > self.controller.SETTLE_BOUND:
                        self._safe_stop("the components' own steps never end (%s)" % tau.component)
                        return

    # Commands

    def _perform(self, command: PacedCommand) -> None:
        now = self._port.now()
        name = self._names[command.key]
        data = None
        try:
            if command.data is not None:
                data = command.data()
            self._dispatch(command, data)
        except Exception as error:
            reason = "%s: %s" % (type(error).__name__, error)
            self.journal.counters["failed"] += 1
            self.journal.note(command.kind, name, data, "failed", reason)
            self._log("error", command.key, "%s could not be sent: %s" % (name, reason))
            self._pace.done(command, now)
            return
        if command.apply is not None:
            command.apply()
        command.count += 1
        self.journal.counters["commands"] += 1
        self.journal.note(command.kind, name, data)
        self._pace.done(command, now)
        self._after(command.key if command.kind == "cancel" else None)

    def _dispatch(self, command: PacedCommand, data: Any) -> None:
        if command.kind == "cancel":
            token = self._calls.end(command.key)
            if token is not None:
                self._port.cancel(command.key, token)
                self._port.abandon(command.key, token)
            return
        if command.sort == "incoming":
            self._port.send(command.key, data)
            return
        token = self._calls.begin(command.key, self._steady())
        start = self._port.call if command.sort == "service" else self._port.start
        try:
            start(command.key, data, token, self.settings.timeout_of(command.key))
        except Exception:
            self._calls.end(command.key)
            raise

    # Stopping

    def _safe_stop(self, reason: str) -> None:
        if self.stopped is not None:
            return
        self.stopped = reason
        self.journal.note("stop", "", None, "stopped", reason)
        self._log("error", "stop", "safe stop: " + reason)
        self._withdraw()
        if self.settings.exit_on_stop:
            self._port.exit(1)

    def _withdraw(self) -> None:
        """Cancel running goals and send the stop command.

        The goals still end by themselves, so that the state stays true.
        """
        sorts = {c.key: c.sort for c in self.controller.COMMUNICATIONS}
        for key, token in self._calls.running():
            if sorts[key] == "action":
                self._port.cancel(key, token)
        stop = self.settings.stop_command
        for command in self._pace.commands:
            if command.key == stop and command.kind == "request" and command.possible:
                self._send_stop(command)

    def _send_stop(self, command: PacedCommand) -> None:
        """Send the stop command, guard or not; the state follows only where it can."""
        name = self._names[command.key]
        try:
            data = None if command.data is None else command.data()
            self._dispatch(command, data)
        except Exception as error:
            self.journal.note("request", name, None, "failed", str(error))
            self._log("error", "stop", "the stop command %s failed: %s" % (name, error))
            return
        self.journal.counters["commands"] += 1
        self.journal.note("request", name, data)
        if command.apply is not None and (command.consent is None or command.consent()):
            command.apply()

    def _close(self) -> None:
        if not self._closing:
            self._closing = True
            if self.stopped is None:
                self._withdraw()

    def _log(self, level: str, subject: str, text: str) -> None:
        admitted = self._throttle(subject, text, self._steady())
        if admitted is not None:
            self._port.log(level, admitted)

    # For reporters, on the engine thread

    def snapshot(self) -> Dict[str, Any]:
        """The state with all that goes with it, to be looked at by another thread."""
        return {
            "controller": self.controller.copy(),
            "counters": dict(self.journal.counters),
            "number": self.journal.number,
            "stopped": self.stopped,
            "backlog": self.backlog,
            "counts": {(c.key, c.kind): c.count for c in self._pace.commands},
        }
