"""The operator's hand: what the page may do in ROS, where ``robosc view --operate`` allows it.

It publishes messages of the components that stand for persons, and orders that the node takes as
an input like any other. There is no way from here to the commands of the robot.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from robosc.view.listening import Listener
from robosc.view.server import Answers, Unable

ORDERS = ("hold", "release", "step")
PATIENCE = 5.0
"""Seconds for which a message waits until it is known that somebody hears it."""

UNHEARD = "nobody hears %s; orders are heard by a node that was started with operate:=true"

Seen = TypeVar("Seen")


def awaited(topic: str, look: Callable[[], Seen | None]) -> Seen:
    """What is seen of those who hear a topic, once it is anything. Raises Unable."""
    end = time.monotonic() + PATIENCE
    while not (seen := look()):
        if time.monotonic() > end:
            raise Unable(UNHEARD % topic)
        time.sleep(0.01)
    return seen


class OperatorDesk:
    """What a page may ask; ``persons`` are the components whose messages it may send, ``model``
    returns the document of ``~model``."""

    def __init__(
        self,
        hand: Listener,
        persons: Iterable[str],
        model: Callable[[], dict[str, Any] | None],
        log: Callable[[str], None] = lambda text: print(text, file=sys.stderr, flush=True),
    ) -> None:
        self._hand = hand
        self._persons = tuple(persons)
        self._model = model
        self._log = log

    @property
    def answers(self) -> Answers:
        return {"/operate": self.do}

    def do(self, document: Any) -> dict[str, Any]:
        """``{"order": "hold"}``, ``{"send": "Operator.go", "text": "true"}``. Raises Unable."""
        match document:
            case {"order": str(word)} if word in ORDERS:
                self._tell(word, lambda: self._hand.order(word))
            case {"send": str(name), "text": str(text)}:
                topic, data = self._topic_of(name), _data(text)
                self._tell(f"{name} {text}".strip(), lambda: self._hand.publish(topic, data))
            case _:
                raise Unable("there is no such request")
        return {}

    def _tell(self, what: str, act: Callable[[], None]) -> None:
        at = time.strftime("%H:%M:%S")
        try:
            act()
        except Unable as fault:
            self._log(f"{at} operator: {what}: {fault}")
            raise
        self._log(f"{at} operator: {what}")

    def _topic_of(self, name: str) -> str:
        model = self._model()
        if model is None:
            raise Unable("the node has not told its model yet")
        found = [c for c in model.get("communications", ()) if c["name"] == name]
        if not found or found[0]["kind"] != "outgoing message":
            raise Unable(f"the model has no message {name!r} of the robot")
        if found[0]["component"] not in self._persons:
            raise Unable(f"{found[0]['component']} does not stand for a person here: --operate")
        topic = model.get("topics", {}).get(name)
        if topic is None:
            raise Unable(f"the node does not tell on which topic it hears {name}: generate it anew")
        return str(topic)


def _data(text: str) -> Any:
    """The data of a message as they are typed: JSON. Raises Unable."""
    try:
        return json.loads(text) if text.strip() else {}
    except (ValueError, RecursionError):
        known = '0.4, true, "text", or {"x": 0.4, "y": 2}'
        raise Unable(f"cannot read {text[:80]!r}: write {known}") from None
