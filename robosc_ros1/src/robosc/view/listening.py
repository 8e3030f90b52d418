"""A running controller as a source: what it publishes on ``~model``, ``~state`` and ``~events``.

How it is listened to depends on the ROS (:mod:`~robosc.view.ros1`, :mod:`~robosc.view.ros2`); what
is heard, and whether it still comes, is the same.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

from robosc.runtime.core.telemetry import dump
from robosc.view.hub import Hub

_SILENT = 3.0
"""Seconds; a state comes once per second at least."""
CHECK = 0.5
"""Seconds between two looks at how things stand."""


class Listener(Protocol):
    """A node of ROS that only listens: it publishes nothing of the robot's and calls nobody, unless
    an operator's hand does (:class:`~robosc.view.operating.Hand`). Where the page is it tells on
    ``/diagnostics``.

    It may be there before the node it listens to, and stays when that goes.
    """

    TOPICS: tuple[str, ...] = ("model", "state", "events")
    """What it listens to, of the topics that :class:`Heard` takes."""
    heard: Heard

    def start(self, page: str | None) -> None:
        """Listen; ``page`` is the address of the page, which is told; None: there is none."""

    def order(self, word: str) -> None:
        """Publish an order on the node's ``~operate``. Raises Unable."""
        self.publish(f"{self.heard.node}/operate", word)

    def publish(self, topic: str, data: Any) -> None:
        """Publish a message with these data: the fields to set by name, or the only one. Raises
        Unable."""

    def close(self) -> None:
        """Leave without a trace."""


class Heard:
    """What is heard of one node, passed on to a hub. The callbacks may come in any thread.

    After ``silent`` seconds without a state the node is gone.
    """

    def __init__(self, node: str, hub: Hub, silent: float = _SILENT) -> None:
        self.node = node
        self._hub = hub
        self._model: dict[str, Any] | None = None
        self._at = float("-inf")
        self._silent = silent
        self.otherwise = f"waiting for {node}"
        """What there is to say while nothing is heard."""
        hub.put("hello", dump({"source": "ros", "title": node}))
        self._tell()

    @property
    def topics(self) -> Mapping[str, Callable[[str], None]]:
        """Topics of a node that carry a text, and who takes it."""
        events = {"events": self.event, "blocked": self.blocked}
        return {"model": self.model, "state": self.state, **events}

    def waits(self, topics: Iterable[str]) -> None:
        """There is nothing to say but which other controllers publish on these topics."""
        there = set(topics)
        names = sorted(topic.removesuffix("/model") for topic in there if topic.endswith("/model"))
        others = [n for n in names if {f"{n}/state", f"{n}/events"} <= there and n != self.node]
        hint = f"; also running: {', '.join(others)}" if others else ""
        self.otherwise = f"waiting for {self.node}{hint}"

    def watch(self) -> None:
        """Begin to report how things stand, whatever else in this process hangs."""
        threading.Thread(target=self._run, name="watch", daemon=True).start()

    def model(self, text: str) -> None:
        document = _document(text, "components")
        if document is not None:
            self._model = json.loads(document)
            self._hub.put("model", document)

    def document(self) -> dict[str, Any] | None:
        """The latest model."""
        return self._model

    def state(self, text: str) -> None:
        document = _document(text, "commands")
        if document is not None:
            self._at = time.monotonic()
            self._hub.put("state", document)
            self._tell()

    def blocked(self, text: str) -> None:
        self.event(text, "blocked_by")

    def event(self, text: str, field: str = "outcome") -> None:
        document = _document(text, field)
        if document is not None:
            self._hub.add([document])

    def _run(self) -> None:
        while True:
            time.sleep(CHECK)
            self._tell()

    def _tell(self) -> None:
        silence = time.monotonic() - self._at
        if silence < self._silent:
            status = {"good": True, "text": "live"}
        else:
            status = {"good": False, "text": self.otherwise}
            if silence < float("inf"):
                status["stale"] = True
        self._hub.put("status", dump(status))


def diagnosis(messages: Any, node: str, page: str, stamp: Any, fine: Any) -> Any:
    """Return what ``/diagnostics`` says of the page of a node: ``messages`` is ROS's module of
    them, ``fine`` its level for it."""
    told = [messages.KeyValue(key="node", value=node), messages.KeyValue(key="page", value=page)]
    status = messages.DiagnosticStatus(
        level=fine, name=f"{node.lstrip('/')}: page", message=page, values=told
    )
    array = messages.DiagnosticArray(status=[status])
    array.header.stamp = stamp
    return array


def _document(text: str, field: str) -> str | None:
    """The same document on one line, as a stream needs it; None if it is not what it should be."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(document, dict) or document.get("version") != 1 or field not in document:
        return None
    return dump(document)
