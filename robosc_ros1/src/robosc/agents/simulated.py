"""Calls of an agent in the simulator: the generated code, and whoever plays the robot around it."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from robosc.agents.calls import CallWatch, Gateway, Json, fire, whole_state
from robosc.agents.tools import Tool
from robosc.simulate.script.session import MakeMachine, Session

_KEPT = 50


class Simulated(Gateway):
    """A robot that is played by lines of ``robosc simulate``, and commanded by an agent."""

    def __init__(self, make: MakeMachine, parameters: Mapping[str, Any]) -> None:
        super().__init__(make)
        self._parameters = dict(parameters)
        self._session = Session(make, parameters)
        self._lock = threading.Lock()
        self._latest: deque[Json] = deque(maxlen=_KEPT)
        self._note(self._session.latest)

    def state(self) -> Json:
        with self._lock:
            return {**whole_state(self._session), "parameters": self._parameters}

    def events(self) -> Sequence[Json]:
        with self._lock:
            return list(self._latest)

    def ask(self, tool: Tool, arguments: Mapping[str, Any], watch: CallWatch) -> Json:
        return self._fire(tool, arguments)

    def cancel(self, tool: Tool) -> Json:
        return self._fire(tool, {}, cancels=True)

    def play(self, line: str) -> Json:
        """Do a line of the simulator: what the robot sends, or ``wait 2``.

        Raises:
            LineFault: it was not done.
        """
        with self._lock:
            done = self._session.do(line)
            return {"text": done.text, "happened": self._note(done.happenings)}

    def _fire(self, tool: Tool, arguments: Mapping[str, Any], *, cancels: bool = False) -> Json:
        with self._lock:
            before = self._session.latest
            outcome = fire(self._session, tool, arguments, cancels=cancels)
            if self._session.latest is not before:
                self._note(self._session.latest)
        return outcome

    def _note(self, happenings: Sequence[Any]) -> list[Json]:
        documents = [happening.document() for happening in happenings]
        self._latest.extend(documents)
        return documents
