"""The scripts of scripted.py through generated ROS 2 nodes; ROS 1 has a test of the same kind."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from ros2.ros2_support import Graph, Peer, Process
from scripted import SCENES, SLOW, Script, drawn, play

from robosc.language.events import Kind
from robosc.model.entities import Communication

_FOLDERS = {Kind.SERVICE: "srv", Kind.ACTION: "action"}
_ENDS = {"response": "succeed", "error": "abort", "cancelled": "canceled"}


class Ros2Side:
    """The robot of a script, played by a peer."""

    def __init__(self, peer: Peer, script: Script, node: str) -> None:
        self._peer = peer
        self._node = node
        self._requests: dict[str, list[dict[str, Any]]] = defaultdict(list)
        self._cancels: dict[str, list[str]] = defaultdict(list)
        heard: set[str] = set()
        for communication in script.robot.communications.values():
            name, type_ = self._resolved(communication.identifier), _type(communication)
            if communication.kind is Kind.INCOMING and name not in heard:
                heard.add(name)
                peer.subscribe(name, type_)
            elif communication.kind is Kind.SERVICE:
                peer.serve(name, type_)
            elif communication.kind is Kind.ACTION:
                peer.act(name, type_)

    def _resolved(self, name: str) -> str:
        return f"{self._node}/{name[1:]}" if name[0] == "~" else name

    def publish(self, communication: Communication, message: dict[str, Any]) -> None:
        name = self._resolved(communication.identifier)
        self._peer.publish(name, _type(communication), message)

    def end(self, _: str, communication: Communication, kind: str, message: dict[str, Any]) -> None:
        number = self._requests[communication.identifier][-1]["id"]
        if communication.kind is Kind.SERVICE:
            self._peer.order("tell_server", id=number, data=message)
        elif kind == "feedback":
            self._peer.order("tell_server", id=number, feedback=message)
        else:
            self._peer.order("tell_server", id=number, end=_ENDS[kind], result=message)

    def requests(self, identifier: str) -> Sequence[dict[str, Any]]:
        found = self._requests[identifier]
        name = self._resolved(identifier)
        for event in ("request", "goal"):
            for asked in self._peer.events(event, name=name)[len(found) :]:
                found.append(asked)
        return [asked["data"] for asked in found]

    def cancels(self, identifier: str) -> int:
        found = self._cancels[identifier]
        for cancel in self._peer.events("cancel", name=self._resolved(identifier))[len(found) :]:
            found.append(cancel["id"])
        return len(found)

    def messages(self, identifier: str) -> Sequence[dict[str, Any]]:
        heard = self._peer.events("message", name=self._resolved(identifier))
        return [message["data"] for message in heard]


def _type(communication: Communication) -> str:
    folder = _FOLDERS.get(communication.kind, "msg")
    return f"{communication.binding.package}/{folder}/{communication.binding.type}"


@pytest.mark.once
@pytest.mark.parametrize("scene", SCENES)
def test_the_node_does_what_the_script_says(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path, scene: str
) -> None:
    script, package = drawn(scene), SCENES[scene].package
    side = Ros2Side(graph.peer(), script, package)
    log = tmp_path / "events.jsonl"
    parameters = {"event_log": str(log), **SLOW}
    parameters |= {f"timeout__{name}": 600.0 for name in script.timed}
    inputs = (c for c in script.robot.communications.values() if c.kind is Kind.OUTGOING)
    for communication in inputs:
        parameters[f"qos__{script.robot.display_names[communication.key]}__reliability"] = (
            "reliable"
        )
    controller(package, **parameters)
    play(script, log, side)
