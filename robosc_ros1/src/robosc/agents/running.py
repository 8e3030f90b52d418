"""Calls of an agent through a running node: what it publishes, and what the node says of it.

An agent is one more controller: what it sends goes to the names that a supervisor gives the
controller, or to calls that a controller serves. How that is done depends on the ROS
(:mod:`.ros1`, :mod:`.ros2`).
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol

from robosc.agents.outcomes import CallOutcome, CallWatch, blocked, sent, unsent
from robosc.agents.simulated import reasons_of, what_if
from robosc.agents.tools import WHOLE, Tool
from robosc.emit.supervisor.supervisor_package import controller_name
from robosc.language.events import Kind
from robosc.simulate.faults import InvalidLine
from robosc.simulate.script.session import MakeMachine
from robosc.view.server import Unable

Json = Any

_KEPT = 50
_VERDICT = 2.0
"""Seconds for a supervisor to say what it made of a command."""
_OF_32_BITS = 1e-6
SILENT = 3.0
"""Seconds without a state after which nothing is sent: a state comes every second."""

End = tuple[str, Json]
"""How a call ended: "answered", "failed", "cancelled" or "refused", and what came with that."""


class Caller(Protocol):
    """How a version of ROS calls a service, and sends a goal; both may raise Unable."""

    def publish(self, topic: str, data: Json) -> None: ...

    def call(self, name: str, type_: str, data: Json, watch: CallWatch) -> End: ...

    def goal(self, name: str, type_: str, data: Json, watch: CallWatch) -> End: ...

    def close(self) -> None: ...


class Verdicts:
    """What a node tells of commands: its state, its events, and what it blocked.

    The callbacks may come in any thread.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._changed = threading.Condition()
        self._state: Json = None
        self._at = float("-inf")
        self._events: deque[Json] = deque(maxlen=_KEPT)
        self._told: deque[tuple[int, Json]] = deque(maxlen=_KEPT)
        self._count = 0

    def state(self, text: str) -> None:
        document = _read(text)
        if document is not None:
            with self._changed:
                self._state, self._at = document, self._now()
                self._changed.notify_all()

    def event(self, text: str) -> None:
        self._tell(_read(text), events=True)

    def blocked(self, text: str) -> None:
        self._tell(_read(text), events=False)

    def _tell(self, document: Json, *, events: bool) -> None:
        if document is None:
            return
        with self._changed:
            self._count += 1
            self._told.append((self._count, document))
            if events:
                self._events.append(document)
            self._changed.notify_all()

    @property
    def latest(self) -> Json:
        """The latest state; None: none is heard (any more)."""
        with self._changed:
            return self._state if self._now() - self._at < SILENT else None

    def events(self) -> list[Json]:
        with self._changed:
            return list(self._events)

    def mark(self) -> int:
        """Return the place in what is told after which something new comes."""
        with self._changed:
            return self._count

    def await_verdict(self, since: int, names: Sequence[str], data: Json) -> tuple[Json, int]:
        """Return the first document after ``since`` that judges a request of one of these names,
        with these data, and its place; None if none comes in time."""
        return self._await(since, lambda document: _is_about(document, names, data))

    def await_end(self, since: int, names: Sequence[str]) -> Json:
        """Return the first document after ``since`` that says how a call of one of these names
        ended; None if none comes in time."""
        return self._await(since, lambda d: _kind(d, names) in ("response", "error"))[0]

    def _await(self, since: int, wanted: Callable[[Json], bool]) -> tuple[Json, int]:
        end = self._now() + _VERDICT
        with self._changed:
            while True:
                for count, document in self._told:
                    if count > since and wanted(document):
                        return document, count
                left = end - self._now()
                if left <= 0:
                    return None, since
                self._changed.wait(left)


class Running:
    """A node, as :class:`~robosc.agents.server.Gateway` has it. ``guarded``: it is a supervisor."""

    def __init__(
        self,
        node: str,
        caller: Caller,
        verdicts: Verdicts,
        make: MakeMachine,
        *,
        guarded: bool,
    ) -> None:
        self._node = node
        self._caller = caller
        self._verdicts = verdicts
        self._make = make
        self._guarded = guarded
        self._busy: dict[str, CallWatch] = {}
        self._lock = threading.Lock()
        self._judging = threading.Lock()

    def state(self) -> Json:
        state = self._verdicts.latest
        if state is None:
            raise InvalidLine(f"{self._node} is silent: nothing is known of its state")
        return state

    def events(self) -> Sequence[Json]:
        return self._verdicts.events()

    def held(self) -> str | None:
        state = self._verdicts.latest
        if state is None:
            return f"{self._node} is silent"
        stopped: str | None = state.get("stopped")
        return stopped

    def ask(self, tool: Tool, arguments: Mapping[str, Any], watch: CallWatch) -> CallOutcome:
        data = dict(tool.data if tool.data is not None else arguments)
        try:
            if tool.communication.kind is Kind.INCOMING:
                return self._send(tool, data)
            return self._call(tool, data, watch)
        except Unable as fault:
            return unsent("refused", str(fault))

    def _send(self, tool: Tool, data: Json) -> CallOutcome:
        """Publish a command; one at a time, so that each verdict has its command."""
        with self._judging:
            since = self._verdicts.mark()
            self._caller.publish(self._name(tool), _fields(data))
            verdict, _ = self._verdicts.await_verdict(since, tool.alike, data)
        return _outcome(verdict)

    def _call(self, tool: Tool, data: Json, watch: CallWatch) -> CallOutcome:
        with self._lock:
            if tool.key in self._busy:
                return unsent("refused", f"{tool.name} is under way: cancel it first, or wait")
            self._busy[tool.key] = watch
        since = self._verdicts.mark()
        binding = tool.communication.binding
        type_ = f"{binding.package}/{binding.type}"
        is_goal = tool.communication.kind in (Kind.ACTION, Kind.SERVED_ACTION)
        act = self._caller.goal if is_goal else self._caller.call
        try:
            word, answer = act(self._name(tool), type_, _fields(data), watch)
        finally:
            with self._lock:
                del self._busy[tool.key]
        if word == "cancelled":
            return CallOutcome(word, {"answer": answer})
        verdict, place = self._verdicts.await_verdict(since, tool.alike, data)
        if verdict is not None and "blocked_by" in verdict:
            return _outcome(verdict)
        if word != "answered":
            return CallOutcome(word, {"why": [str(answer)]})
        return self._answered(tool, answer, verdict, place)

    def _answered(self, tool: Tool, answer: Json, verdict: Json, place: int) -> CallOutcome:
        """What an answer is: a service of ROS 2 gives one also where its call was not passed on, or
        failed, so that only the node can say."""
        told = f"; the answer was {json.dumps(answer)}"
        if verdict is not None and verdict.get("outcome") != "applied":
            word = "refused" if verdict.get("outcome") == "refused" else "failed"
            return unsent(word, str(verdict.get("detail") or "it was not passed on") + told)
        end = None if verdict is None else self._verdicts.await_end(place, tool.alike)
        if end is None:
            return unsent("unknown", "the node does not say what became of it" + told)
        if _kind(end, tool.alike) == "error":
            return unsent("failed", str(end.get("detail") or "it ended with an error") + told)
        return CallOutcome("answered", {"answer": answer})

    def cancel(self, tool: Tool) -> CallOutcome:
        if tool.communication.kind not in (Kind.ACTION, Kind.SERVED_ACTION):
            return unsent("refused", f"{tool.name} is no action: there is nothing to cancel")
        with self._lock:
            watch = self._busy.get(tool.key)
        if watch is None:
            return unsent("refused", f"{tool.name} was not begun here")
        watch.cancelled.set()
        return sent()

    def why(self, name: str) -> str:
        reasons = reasons_of(self.state(), name)
        return "\n".join(reasons) if reasons else "allowed now"

    def what_if(self, calls: Iterable[tuple[Tool, Mapping[str, Any]]]) -> Json:
        return what_if(self._make, {}, self.state(), calls)

    def play(self, line: str) -> Json:
        raise InvalidLine("this robot is real: nobody plays it")

    def close(self) -> None:
        """End what was begun here: each call cancels its own goal."""
        with self._lock:
            watches = list(self._busy.values())
        for watch in watches:
            watch.cancelled.set()
        self._caller.close()

    def _name(self, tool: Tool) -> str:
        """The full name on the side of whoever commands."""
        name = tool.communication.identifier
        return full_name(controller_name(name) if self._guarded else name, self._node)


def full_name(name: str, node: str) -> str:
    """Return a name of a node as ROS resolves it."""
    if name.startswith("/"):
        return name
    if name.startswith("~"):
        return f"{node}/{name.lstrip('~/')}"
    return f"{node.rpartition('/')[0]}/{name}"


def _fields(data: Json) -> Json:
    """Arguments as a message takes them: its only field, or fields by name."""
    return data[WHOLE] if set(data) == {WHOLE} else data


def _outcome(verdict: Json) -> CallOutcome:
    if verdict is None:
        return unsent("unknown", "the supervisor says nothing of it: is it on these names?")
    more = {"corrected": verdict["corrected"]} if "corrected" in verdict else {}
    if "blocked_by" in verdict:
        return blocked(verdict["blocked_by"], **more)
    if verdict.get("outcome") == "failed":
        return unsent("failed", str(verdict.get("detail") or "it could not be sent"))
    return sent(more.get("corrected"))


def _is_about(document: Json, names: Sequence[str], data: Json) -> bool:
    """Whether a document judges a request of these names; of other data it is another's."""
    event = document.get("event", {})
    if _kind(document, ("", *names)) != "request":
        return False
    if data is None or document.get("corrected") or not isinstance(event.get("value"), dict):
        return True
    flat = dict(_leaves(data))
    return all(_alike(flat.get(path, value), value) for path, value in event["value"].items())


def _alike(sent: Json, told: Json) -> bool:
    """Whether a value is what was sent: on its way, a number may become one of 32 bits."""
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (sent, told))
    return math.isclose(sent, told, rel_tol=_OF_32_BITS) if numbers else bool(sent == told)


def _kind(document: Json, names: Sequence[str]) -> str | None:
    event = document.get("event", {})
    return event.get("kind") if event.get("name") in names else None


def _leaves(data: Mapping[str, Any], path: str = "") -> Iterable[tuple[str, Any]]:
    for name, value in data.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{path}{name}.")
        else:
            yield path + name, value


def _read(text: str) -> Json:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) and document.get("version") == 1 else None
