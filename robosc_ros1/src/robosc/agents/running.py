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
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from robosc.agents.calls import CallWatch, Gateway, Json, outcome_of, unsent
from robosc.agents.tools import WHOLE, Tool
from robosc.emit.supervisor.supervisor_package import controller_name
from robosc.language.events import Kind
from robosc.simulate.faults import InvalidLine
from robosc.simulate.script.session import MakeMachine
from robosc.simulate.values.literals import by_path
from robosc.view import listening, server
from robosc.view.hub import Hub

_KEPT = 50
_VERDICT = 2.0
"""Seconds for a supervisor to say what it made of a command."""
_LOOK = 0.02
_LEAVING = 5.0
"""Seconds for the end of a goal that was cancelled."""
_OF_32_BITS = 1e-6

End = tuple[str, Json]
"""How a call ended: "answered", "failed", "cancelled", "refused" or "unknown", and what came with
that."""


class RequestNews:
    """What a node tells from now on of one request: of these names, with these data.

    Not to be shared between threads.
    """

    def __init__(
        self, hub: Hub, names: Sequence[str], data: Mapping[str, Json], watch: CallWatch
    ) -> None:
        self.watch = watch
        self._names = names
        self._data = by_path(dict(data))
        self._documents: list[Json] = []
        self._is_live = True
        self._follower = hub.follow()
        self._follower.take(0.0)

    def request(self) -> Json:
        """What judges the request; None if nothing comes in time."""
        return self._find(self._is_it)

    def end(self) -> Json:
        """How it ended, after :meth:`request`; None if nothing comes in time."""
        return self._find(lambda d: self._kind(d, self._names) in ("response", "error"))

    def wait(self, done: Callable[[], bool], cancel: Callable[[], Any] | None = None) -> End | None:
        """Wait until a call is done; return why nobody waits any longer if it is not.

        If the client gives up, ``cancel`` is called, which is to end the call soon.
        """
        until = math.inf
        while not done():
            if not self._is_live:
                return "unknown", "the node is silent: nobody knows what becomes of it"
            if self.watch.cancelled and cancel is None:
                return "failed", "nobody waits for the answer any more"
            if self.watch.cancelled and cancel is not None and until == math.inf:
                cancel()
                until = time.monotonic() + _LEAVING
            if time.monotonic() > until:
                return "failed", "it was cancelled, and has not ended"
            self._take(_LOOK)
        return None

    def _find(self, wanted: Callable[[Json], bool]) -> Json:
        end = time.monotonic() + _VERDICT
        timeout = 0.0
        while timeout >= 0.0:
            self._take(timeout)
            for number, document in enumerate(self._documents):
                if wanted(document):
                    del self._documents[: number + 1]
                    return document
            timeout = end - time.monotonic()
        return None

    def _take(self, timeout: float) -> None:
        news = json.loads(self._follower.take(timeout) or "{}")
        self._is_live = news.get("status", {}).get("good", self._is_live)
        known = ("", *self._names)
        self._documents += [d for d in news.get("events", ()) if self._kind(d, known)]

    def _kind(self, document: Json, names: Sequence[str]) -> str | None:
        event = document.get("event")
        return event.get("kind") if isinstance(event, dict) and event.get("name") in names else None

    def _is_it(self, document: Json) -> bool:
        """Whether a document judges the request; of other data it is another's."""
        if self._kind(document, ("", *self._names)) != "request":
            return False
        told = document["event"].get("value")
        if document.get("corrected") or not isinstance(told, dict):
            return True
        return all(_alike(self._data.get(path, value), value) for path, value in told.items())


def _alike(sent: Json, told: Json) -> bool:
    """Whether a value is what was sent: on its way, a number may become one of 32 bits."""
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (sent, told))
    return math.isclose(sent, told, rel_tol=_OF_32_BITS) if numbers else bool(sent == told)


class Caller(listening.Listener, Protocol):
    """A listener that also calls a service, and sends a goal; both may raise Unable."""

    def call(self, name: str, type_: str, data: Json, told: RequestNews) -> End: ...

    def goal(self, name: str, type_: str, data: Json, told: RequestNews) -> End: ...


class Running(Gateway):
    """A node that is listened to. ``guarded``: it is a supervisor."""

    def __init__(self, ros: Caller, hub: Hub, make: MakeMachine, *, guarded: bool) -> None:
        super().__init__(make)
        self._ros = ros
        self._hub = hub
        self._guarded = guarded
        self._busy: dict[str, CallWatch] = {}
        self._lock = threading.Lock()
        self._judging = threading.Lock()

    def state(self) -> Json:
        news = self._news()
        if not news["status"]["good"]:
            raise InvalidLine(f"{self._ros.heard.node} is silent: {news['status']['text']}")
        return news["state"]

    def events(self) -> Sequence[Json]:
        found: list[Json] = self._news().get("events", [])
        return found[-_KEPT:]

    def _news(self) -> Json:
        return json.loads(self._hub.follow().take(0.0) or "{}")

    def ask(self, tool: Tool, arguments: Mapping[str, Any], watch: CallWatch) -> Json:
        data = dict(tool.data if tool.data is not None else arguments)
        try:
            if tool.communication.kind is Kind.INCOMING:
                return self._send(tool, data, watch)
            with self._lock:
                if tool.key in self._busy:
                    raise server.Unable(f"{tool.name} is under way: cancel it first, or wait")
                self._busy[tool.key] = watch
            try:
                return self._call(tool, data, watch)
            finally:
                with self._lock:
                    del self._busy[tool.key]
        except server.Unable as fault:
            return unsent("refused", str(fault))

    def _send(self, tool: Tool, data: Json, watch: CallWatch) -> Json:
        """Publish a command; one at a time, so that each verdict has its command."""
        with self._judging:
            told = RequestNews(self._hub, tool.alike, data, watch)
            self._ros.publish(self._name(tool), _fields(data))
            verdict = told.request()
        if verdict is None:
            return unsent("unknown", "the supervisor says nothing of it: is it on these names?")
        return outcome_of(verdict)

    def _call(self, tool: Tool, data: Json, watch: CallWatch) -> Json:
        told = RequestNews(self._hub, tool.alike, data, watch)
        binding = tool.communication.binding
        act = self._ros.goal if tool.is_action else self._ros.call
        name, type_ = self._name(tool), f"{binding.package}/{binding.type}"
        word, answer = act(name, type_, _fields(data), told)
        verdict = told.request() if word != "unknown" else None
        judged = {"outcome": "unknown"} if verdict is None else outcome_of(verdict)
        if judged["outcome"] in ("blocked", "refused", "failed"):
            return judged  # a service of ROS 2 answers also then
        more = {"corrected": judged["corrected"]} if "corrected" in judged else {}
        if word == "answered" and not tool.is_action:  # so may a call that failed
            end = told.end() if verdict is not None else None
            if end is None:
                word, why = "unknown", "the node does not say what became of it"
            elif end["event"]["kind"] == "error":
                word, why = "failed", str(end.get("detail") or "it ended with an error")
            if word != "answered":
                return unsent(word, why, answer=answer, **more)
        if word in ("answered", "cancelled"):
            return {"outcome": word, "answer": answer, **more}
        return unsent(word, str(answer), **more)

    def cancel(self, tool: Tool) -> Json:
        if not tool.is_action:
            return unsent("refused", f"{tool.name} is no action: there is nothing to cancel")
        with self._lock:
            watch = self._busy.get(tool.key)
        if watch is None:
            return unsent("refused", f"{tool.name} was not begun here")
        watch.cancel()
        return {"outcome": "sent"}

    def close(self) -> None:
        """End what was begun here: each call cancels its own goal."""
        with self._lock:
            for watch in self._busy.values():
                watch.cancel()
        self._ros.close()

    def _name(self, tool: Tool) -> str:
        """The full name on the side of whoever commands."""
        name = tool.communication.identifier
        return full_name(controller_name(name) if self._guarded else name, self._ros.heard.node)


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
