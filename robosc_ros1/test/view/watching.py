"""A server of a page in this process, and someone who follows its stream."""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Callable, Iterator
from functools import cache
from http.client import HTTPConnection, HTTPResponse
from typing import Any

from ros_support import EXAMPLES

from robosc import pipeline
from robosc.runtime.core.settings import Settings
from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.simulate.machines.execute import Execution
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.listening import Heard
from robosc.view.played import Played
from robosc.view.server import Answers, PageServer, Where

__all__ = [
    "MODEL", "Told", "Watcher", "ask", "command_is", "is_in", "line_follower", "link_says",
    "log_of", "serving",
]  # fmt: skip

MODEL = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"

Json = dict[str, Any]

BEGUN = 1_750_000_000.0
"""When logs begin, in seconds since 1970."""


@cache
def line_follower() -> Supervisor:
    return pipeline.supervise(pipeline.load(MODEL).robot)


@contextlib.contextmanager
def serving(
    hub: Hub, answers: Answers | None = None, token: str | None = None
) -> Iterator[PageServer]:
    """A server on any port of this machine."""
    with PageServer(Where(port=0), hub, answers or {}, token) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


class Told:
    """What a node tells whose robot is played at random: the documents of its three topics."""

    def __init__(self, supervisor: Supervisor) -> None:
        hub = Hub()
        self._robot = Played(SingleEvents(supervisor), hub)
        self._follower = hub.follow()
        self.model: Json = {}
        self.state: Json = {}
        self.event: Json = {}
        self._read()

    def step(self) -> None:
        self._robot.do({"random": 1})
        self._read()

    def to(self, heard: Heard) -> None:
        """Tell it to whoever hears the node."""
        heard.model(json.dumps(self.model))
        if self.event:
            heard.event(json.dumps(self.event))
        heard.state(json.dumps(self.state))

    def _read(self) -> None:
        news = json.loads(self._follower.take(0) or "")
        self.model = news.get("model", self.model)
        self.state = news["state"]
        for extra in ("choices", "undo", "marked"):
            del self.state[extra]
        if "events" in news:
            (self.event,) = news["events"]


def ask(
    server: PageServer, path: str, body: Any = None, **headers: str
) -> tuple[int, dict[str, str], bytes]:
    """Get a path, or post a document to it: code, headers, body."""
    connection = HTTPConnection(*server.server_address[:2], timeout=600)  # type: ignore[misc]
    try:
        text = None if body is None else json.dumps(body)
        sent = {name.replace("_", "-"): value for name, value in headers.items()}
        if text is not None:
            sent.setdefault("Content-Type", "application/json")
        connection.request("GET" if text is None else "POST", path, text, sent)
        answer = connection.getresponse()
        return answer.status, dict(answer.headers), answer.read()
    finally:
        connection.close()


class Watcher:
    """Follows the stream of a server on this machine; ``seen`` has the latest of each document."""

    def __init__(self, port: int) -> None:
        self._connection = HTTPConnection("127.0.0.1", port, timeout=600)
        self._connection.request("GET", "/stream")
        self._answer: HTTPResponse = self._connection.getresponse()
        self.seen: Json = {}
        self.events: list[Json] = []
        self.dropped = 0

    def until(self, condition: Callable[[Watcher], Any]) -> Any:
        """Read on until the condition holds; what it gave."""
        while not (found := condition(self)):
            line = self._answer.readline()
            assert line, "the stream has ended"
            if line.startswith(b"data:"):
                news = json.loads(line[5:])
                self.events += news.pop("events", [])
                self.dropped += news.pop("dropped", 0)
                self.seen |= news
        return found

    def close(self) -> None:
        self._answer.close()
        self._connection.close()


def log_of(supervisor: Supervisor, *lines: tuple[str, str, Any] | float) -> list[str]:
    """The event log of a controller that executes: events of the robot, or seconds to wait."""
    machine = Execution(supervisor, Settings())
    happened = list(machine.beginning)
    for line in lines:
        if isinstance(line, float):
            happened += machine.wait(line)
            continue
        name, kind, value = line
        event = next(e for e in machine.plant.events if (e.name, e.kind.word) == (name, kind))
        happened += machine.fire(event, {} if value is None else {(): value})
    documents = [happening.document() for happening in happened]
    return [
        json.dumps({"version": 1, "number": n, **d, "time": BEGUN + d["time"]})
        for n, d in enumerate(documents, 1)
    ]


# --- what a page shows, as expressions in it -----------------------------------------------------


def is_in(component: str, state: str) -> str:
    """A component's card tells the state, and lights it in the diagram."""
    card = f"[data-component='{component}']"
    lit = f'document.querySelector("{card} .state.active text")?.textContent === "{state}"'
    return f'document.querySelector("{card}")?.dataset.state === "{state}" && {lit}'


def command_is(command: str, word: str) -> str:
    return f"document.querySelector('[data-command=\"{command}\"]')?.dataset.is === '{word}'"


def link_says(words: str) -> str:
    """How things stand between the page and its source begins with these words."""
    return f"document.getElementById('link').textContent.startsWith('{words}')"
