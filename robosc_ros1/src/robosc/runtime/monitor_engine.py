# In no generated package: robosc itself judges recordings with it.
"""The runtime monitor: follows what the robot and its controller do, and judges it; sends nothing.

It applies the robot's events like every engine. Each command that is seen is checked like one that
asks a supervisor to be passed on. It was sent all the same, so it is applied, too, as far as the
components allow; the outcome "forbidden" tells that a supervisor would have blocked it.

Messages of different topics cross on their way: whoever listens may see a command before the
message that allowed it, or after the one that forbade it. So a command counts as allowed if it is
so at any time in :data:`TOLERANCE` seconds before or after it was seen, as far as other topics
decide: until then a forbidden one waits, and those behind it on its topic with it.
"""

from __future__ import annotations

from typing import Any, Callable, Container, Dict, FrozenSet, List, NamedTuple, Optional, Set, Tuple

from .calls import Failure
from .intake import BoundInput
from .matching import matching_command
from .model import Controller, Requirement
from .offers import Reasons, Repack
from .port import Port, steady_time
from .reasons import reason_text, violation
from .recorder import STOP_COMMAND
from .scheduler import ScheduledCommand
from .settings import Settings
from .supervisor_engine import SupervisorEngine

TOLERANCE = 0.05
"""Seconds by which messages may cross."""
_NEVER = float("-inf")
_REPLACED = "another goal took its place"


class _Seen(NamedTuple):
    """A command, or the answer to one (``entry`` is its input), in the order in which they were
    seen; ``time`` is that of the port, ``stamp`` that of the recorder. ``excused``: it is allowed,
    or was a moment ago."""

    key: str
    kind: str
    message: Any
    time: float
    stamp: float
    excused: bool = True
    entry: Optional[BoundInput] = None


class MonitorEngine(SupervisorEngine):
    """Judges what is seen. Its own public methods may be called from any thread."""

    def __init__(
        self,
        controller: Controller,
        port: Port,
        settings: Optional[Settings] = None,
        steady: Callable[[], float] = steady_time,
    ) -> None:
        super().__init__(controller, port, settings, steady)  # type: ignore[arg-type]
        del self.recorder.counters["blocked"]
        self.recorder.counters.update(forbidden=0, violations=0, crossed=0)
        self.tolerance = TOLERANCE
        self._seen: List[_Seen] = []
        self._topics: Dict[str, str] = {}  # by key, of the commands that were seen
        self._allowed: Dict[Tuple[str, str], bool] = {}
        self._allowed_until: Dict[Tuple[str, str], float] = {}
        self._withdrawn: Set[str] = set()
        """The actions whose goals were cancelled although the model does not say so."""
        self._own = ""  # the topic of the command that is being applied
        self._unknown: FrozenSet[str] = frozenset()
        on_commands = {i for row in controller.COMMANDS for i in row.requirements}
        self._on_states: Dict[int, Requirement] = {
            i: row for i, row in enumerate(controller.REQUIREMENTS) if i not in on_commands
        }
        self._violated: Set[int] = set()
        self.describe: Callable[[Any], Any] = lambda message: None
        """Returns what is recorded of the message of a command."""

    def leave_out(self, keys: Container[str]) -> None:
        """Tell before the start which communications cannot be seen.

        What may depend on them is not judged.
        """
        controller = self.controller
        events = [(row.key, row.writes) for row in controller.INPUTS]
        events += [(row.key, row.writes) for row in controller.COMMANDS]
        # What an event or a step writes is unknown if one thing is that decides on it.
        steps = [(writes, writes) for _, writes in events]
        steps += [((*row.reads, *row.writes), row.writes) for row in controller.TAUS]
        steps += [((*row.reads, *row.writes), row.writes) for row in controller.AFTERS]
        unknown = {name for key, writes in events if key in keys for name in writes}
        size = -1
        while size != len(unknown):
            size = len(unknown)
            for decides, writes in steps:
                if not unknown.isdisjoint(decides):
                    unknown.update(writes)
        self._unknown = frozenset(unknown)
        if unknown:
            self._on_states = {}

    @property
    def unjudged(self) -> List[Tuple[str, str]]:
        """The commands, by key and kind, that are not judged."""
        return [(c.key, c.kind) for c in self._scheduler.commands if self._is_unjudged(c)]

    def see(self, key: str, kind: str, message: Any = None) -> None:
        """Take a request or a cancel that was seen."""
        self._submit(lambda: self._take_command(key, kind, message))

    def answer(self, key: str, kind: str, message: Any = None, former: bool = False) -> None:
        """Take feedback, a response or an error (a :class:`~.calls.Failure`) that was seen.

        ``former``: it belongs to the request before the last one.
        """
        entry = self._inputs[key, kind]
        self._submit(lambda: self._take_answer(entry, message, former))

    # The thread that has the turn

    def _begin(self) -> None:
        super()._begin()
        for command in self._scheduler.commands:
            self._allowed[command.key, command.kind] = self._is_allowed(command)
        self._look_at_states()

    def time_to_deadline(self) -> Optional[float]:
        found = super().time_to_deadline()
        if not self._seen:
            return found
        left = max(0.0, self._seen[0].time + self.tolerance - self._port.now())
        return left if found is None else min(left, found)

    def _meet_deadlines(self) -> None:
        super()._meet_deadlines()
        if self._seen:
            self._judge()

    # What is seen

    def _offer(self, message: Any, payload: Any, topic: str, patterns: Any, repack: Repack) -> None:
        key = matching_command(patterns, message)
        if key is not None:
            self._topics[key] = topic
            self._take_command(key, "request", message)
            return
        self._forbid("request", "", self._unmatched(patterns), self.describe(message))

    def _take_command(self, key: str, kind: str, message: Any) -> None:
        command = self._scheduled[key, kind]
        now = self._port.now()
        until = self._allowed_until.get((key, kind), _NEVER)
        excused = (
            self._is_unjudged(command) or self._is_allowed(command) or now - until < self.tolerance
        )
        self._seen.append(_Seen(key, kind, message, now, self.recorder.now(), excused))
        self._judge()

    def _take_answer(self, entry: BoundInput, message: Any, former: bool) -> None:
        waits = any(seen.key == entry.key for seen in self._seen)
        if former:
            if waits:  # it crossed the request that waits for it; else another one took its place
                self._answer(entry, message)
        elif waits:
            now = self._port.now()
            self._seen.append(
                _Seen(entry.key, entry.kind, message, now, self.recorder.now(), entry=entry)
            )
        else:
            self._answer(entry, message)

    def _answer(self, entry: BoundInput, message: Any) -> None:
        request = self._scheduled[entry.key, "request"]
        if request.possible:
            self.recorder.counters["late"] += 1
            return
        if entry.ends is not None:
            self._withdrawn.discard(entry.key)
        self._input((entry,), message)

    def _judge(self) -> None:
        """Apply what was seen, in order on each topic, as far as it need not wait."""
        place: Optional[int] = 0
        while place is not None:
            place = self._next_decided()
            if place is not None:
                answered = self._seen.pop(place)
                if answered.entry is not None:
                    self._answer(answered.entry, answered.message)

    def _next_decided(self) -> Optional[int]:
        """Apply the first command that need not wait, and return its place; or that of an answer to
        one that was applied; None: all have to wait."""
        waiting = set()
        for place, seen in enumerate(self._seen):
            topic = self._topic(seen)
            if topic not in waiting and (seen.entry is not None or self._is_decided(seen)):
                return place
            waiting.add(topic)
        return None

    def _topic(self, seen: _Seen) -> str:
        return (
            seen.key + seen.kind if seen.kind == "cancel" else self._topics.get(seen.key, seen.key)
        )

    def _is_decided(self, seen: _Seen) -> bool:
        """Apply a command, unless it has to wait for what may come."""
        command = self._scheduled[seen.key, seen.kind]
        over = self._port.now() - seen.time >= self.tolerance
        if command.is_cancel:
            return self._is_cancelled(seen, command, over)
        if seen.key in self._withdrawn and not command.possible:
            self._replace(seen.key)
        fits = self._fits(command)
        unfit = self._unfit(seen.message)
        if fits and not unfit and (seen.excused or self._is_allowed(command)):
            self._happen(seen, command)
            return True
        if self._is_unjudged(command):
            return True
        reasons = unfit or self._reasons(seen.key, seen.kind)
        if not unfit and not over:
            return False
        if seen.key == self.settings.stop_command and fits and not unfit:
            self._happen(seen, command, detail=STOP_COMMAND)
        elif seen.excused and not unfit:
            self.recorder.counters["crossed"] += 1
        else:
            self._happen(seen, command, reasons=reasons)
        return True

    def _is_cancelled(self, seen: _Seen, command: ScheduledCommand, over: bool) -> bool:
        """Take a cancel, which a supervisor always passes on: where the model does not have it, the
        goal goes on until the robot says otherwise."""
        if not command.possible:
            return over or not any(s.key == seen.key and s.kind == "request" for s in self._seen)
        if self._fits(command) and (seen.excused or self._is_allowed(command)):
            self._happen(seen, command)
            return True
        if over:
            self._withdrawn.add(seen.key)
        return over

    def _replace(self, key: str) -> None:
        """End a cancelled goal whose end was not seen before the next one began."""
        self._withdrawn.discard(key)
        self._input((self._inputs[key, "error"],), Failure(_REPLACED))

    def _happen(
        self,
        seen: _Seen,
        command: ScheduledCommand,
        reasons: Optional[Reasons] = None,
        detail: Optional[str] = None,
    ) -> None:
        """Apply a command that was seen."""
        fits = self._fits(command)
        if fits and command.apply is not None:
            command.apply()
        command.count += 1
        name = self._names[seen.key]
        value = self.describe(seen.message)
        if reasons:
            self._forbid(seen.kind, name, reasons, value, seen.stamp, command.writes)
        else:
            self.recorder.counters["commands"] += 1
            self.recorder.record(
                seen.kind, name, value, detail=detail, writes=command.writes, time=seen.stamp,
                seen=True,
            )  # fmt: skip
        if fits:
            self._own = self._topic(seen)
            self._after(command.writes, None)
            self._own = ""

    def _forbid(
        self,
        kind: str,
        name: str,
        reasons: Reasons,
        value: Any,
        stamp: Optional[float] = None,
        writes: FrozenSet[str] = frozenset(),
    ) -> None:
        text = "; ".join(map(reason_text, reasons))
        self.recorder.counters["forbidden"] += 1
        self.recorder.record(
            kind, name, value, "forbidden", text, writes=writes, time=stamp, seen=True,
            blocked_by=reasons,
        )  # fmt: skip
        what = "%s of %s" % (kind, name) if name else "a message"
        self._log("warning", name + kind, "%s was sent, which is forbidden: %s" % (what, text))

    # What is allowed

    def _is_unjudged(self, command: ScheduledCommand) -> bool:
        return not self._unknown.isdisjoint(command.reads)

    @staticmethod
    def _fits(command: ScheduledCommand) -> bool:
        """Whether a command is possible in the components, whatever the requirements say."""
        if not command.possible:
            return False
        return command.synchronisation is None or bool(command.synchronisation())

    def _is_allowed(self, command: ScheduledCommand) -> bool:
        if not (command.possible and command.authorised()):
            return False
        if command.is_cancel:
            return True
        rows = (self.controller.REQUIREMENTS[i] for i in command.row.requirements)
        return all(row.holds(self.controller) for row in rows)

    def _after(self, writes: FrozenSet[str], ended: Optional[str]) -> FrozenSet[str]:
        written = super()._after(writes, ended)
        for command in self._scheduler.affected(written):
            place = command.key, command.kind
            allowed = self._is_allowed(command)
            if not allowed and self._own == self._topics.get(command.key, command.key):
                self._allowed_until.pop(place, None)
            elif self._allowed.get(place) and not allowed:
                self._allowed_until[place] = self._port.now()
            self._allowed[place] = allowed
        if self._on_states:
            self._look_at_states()
        return written

    def _look_at_states(self) -> None:
        """Report the requirements on all states that are violated from now on."""
        for number, row in self._on_states.items():
            if row.holds(self.controller):
                self._violated.discard(number)
            elif number not in self._violated:
                self._violated.add(number)
                reason = violation(self.controller, row)
                text = reason_text(reason)
                self.recorder.counters["violations"] += 1
                self.recorder.record("state", "", None, "violated", text, blocked_by=[reason])
                self._log("warning", row.place, "violated: " + text)

    def _mismatch(self, entry: BoundInput, message: Any, value: Any, reason: str) -> None:
        if self._unknown.isdisjoint(entry.writes):
            super()._mismatch(entry, message, value, reason)

    # Nothing is sent

    def _dispatch(self, command: ScheduledCommand, data: Any) -> None:
        raise AssertionError("a monitor sends nothing")

    def _withdraw(self) -> None:
        """Do nothing: goals and commands are those of others."""

    def _safe_stop(self, reason: str) -> None:
        """Report it; others go on, so this goes on, too."""
        self.recorder.record("stop", "", None, "stopped", reason)
        self._log("error", "stop", "the model cannot be followed: " + reason)
