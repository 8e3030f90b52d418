"""The scripts of scripted.py through generated ROS 1 nodes; ROS 2 has a test of the same kind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from ros1.stage import Puppet, Stage
from ros_support import PYTHON, Master, Workspace
from scripted import SCENES, SLOW, Script, drawn, play, supervisor_of

from robosc.emit.package import ros1_target
from robosc.emit.write.writer import write
from robosc.language.events import Kind
from robosc.model.entities import Communication


class Ros1Side:
    """The robot of a script, played by a puppet."""

    def __init__(self, puppet: Puppet, script: Script, node: str) -> None:
        self._puppet = puppet
        self._node = node
        heard: set[str] = set()
        for communication in script.robot.communications.values():
            name, type_ = self._resolved(communication.identifier), _type(communication)
            if communication.kind is Kind.INCOMING and name not in heard:
                heard.add(name)
                puppet.do("listen", topic=name, type=type_)
            elif communication.kind is Kind.SERVICE:
                puppet.do("service", name=name, type=type_, mode="hold")
            elif communication.kind is Kind.ACTION:
                puppet.do("action", name=name, type=type_, mode="go on")

    def _resolved(self, name: str) -> str:
        return f"/{self._node}/{name[1:]}" if name[0] == "~" else "/" + name.lstrip("/")

    def publish(self, communication: Communication, message: dict[str, Any]) -> None:
        topic, type_ = self._resolved(communication.identifier), _type(communication)
        self._puppet.do("publish", topic=topic, type=type_, fields=message)

    def end(self, _: str, communication: Communication, kind: str, message: dict[str, Any]) -> None:
        name = self._resolved(communication.identifier)
        if communication.kind is Kind.SERVICE:
            self._puppet.do("reply", name=name, fields=message)
        elif kind == "feedback":
            self._puppet.do("progress", name=name, fields=message)
        else:
            self._puppet.do("finish", name=name, mode=_ENDS[kind], fields=message)

    def requests(self, identifier: str) -> Sequence[dict[str, Any]]:
        return [line["message"] for line in self._lines("asked", identifier)]

    def cancels(self, identifier: str) -> int:
        return len(self._lines("cancelled", identifier))

    def messages(self, identifier: str) -> Sequence[dict[str, Any]]:
        return self._puppet.all_heard(self._resolved(identifier))

    def _lines(self, what: str, identifier: str) -> list[dict[str, Any]]:
        name = self._resolved(identifier)
        return [line for line in self._puppet.lines[: self._puppet.mark] if line.get(what) == name]


_ENDS = {"response": "succeed", "error": "abort", "cancelled": "preempt"}
"""How the puppet ends a goal."""


def _type(communication: Communication) -> str:
    suffix = "Action" if communication.kind is Kind.ACTION else ""
    return f"{communication.binding.package}/{communication.binding.type}{suffix}"


@pytest.fixture
def robot(example_workspace: Workspace, shared_master: Master) -> Iterator[Puppet]:
    with Stage(example_workspace, shared_master).puppet() as puppet:
        yield puppet


@pytest.mark.once
@pytest.mark.parametrize("scene", SCENES)
def test_the_node_does_what_the_script_says(
    example_workspace: Workspace, shared_master: Master, robot: Puppet, tmp_path: Path, scene: str
) -> None:
    package = SCENES[scene].package
    write(ros1_target.emit(supervisor_of(scene), package), tmp_path)
    side = Ros1Side(robot, drawn(scene), package)
    log = tmp_path / "events.jsonl"
    parameters = {"event_log": log, **SLOW}
    parameters |= {f"timeout/{name}": 600.0 for name in drawn(scene).timed}
    code = f"import sys; sys.path.insert(0, {str(tmp_path / package / 'src')!r});"
    code += f"from {package}.start import main; main()"
    arguments = [f"_{name}:={value}" for name, value in parameters.items()]
    robot.do("listen", topic=f"/{package}/state", type="std_msgs/String")
    with example_workspace.start(str(PYTHON), "-c", code, *arguments, master=shared_master):
        robot.hears(f"/{package}/state")
        shared_master.await_links(f"/{package}")
        play(drawn(scene), log, side)
