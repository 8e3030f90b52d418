"""Four robots in eight zones, of which one is killed and started again."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import pytest
from fleet_of_four import play
from ros1.stage import Node, Puppet, Stage
from ros_support import EXAMPLES, Master, Workspace, run_robosc

NODE = "floor_controller"
TYPES = {"zone": "std_msgs/Int16", "wants": "std_msgs/Bool"}


class Puppets:
    """A puppet for each robot."""

    def __init__(self, stage: Stage, node: Node) -> None:
        self._stage, self._node = stage, node
        self._robots: dict[str, tuple[Puppet, ExitStack]] = {}

    def start(self, robot: str) -> None:
        stack = ExitStack()
        puppet = stack.enter_context(self._stage.puppet())
        self._robots[robot] = puppet, stack
        for what in ("go", "wait"):
            puppet.do("listen", topic=f"/{robot}/{what}", type="std_msgs/Int16")

    def kill(self, robot: str) -> None:
        self._robots[robot][1].close()

    def say(self, robot: str, what: str, value: int | bool) -> None:
        self._robots[robot][0].steadily(f"/{robot}/{what}", TYPES[what], value)

    def hears(self, robot: str, what: str, value: int) -> None:
        puppet = self._robots[robot][0]
        puppet.hears(f"/{robot}/{what}", lambda m: m["data"] == value, since=puppet.mark)

    def told(self, robot: str, what: str) -> set[int]:
        return {m["data"] for m in self._robots[robot][0].all_heard(f"/{robot}/{what}")}

    def falls_silent(self, robot: str) -> None:
        side, number = robot.split("_")
        name = f"{side.capitalize()}[{number}].place"
        self._node.shows(lambda s: s["communications"][name] == "silent", since=self._node.ear.mark)

    def close(self) -> None:
        for _, stack in self._robots.values():
            stack.close()


@pytest.mark.once
def test_no_robot_enters_a_zone_of_another(
    make_workspace: Callable[[], Workspace], shared_master: Master
) -> None:
    workspace = make_workspace()
    model = EXAMPLES / "zones" / "zones.rscd"
    words = ("generate", str(model), "--output", str(workspace.folder / "src"))
    assert run_robosc(words, workspace.folder, {}, tested=False).returncode == 0
    workspace.build()
    stage = Stage(workspace, shared_master)
    with stage.puppet() as ear, stage.controller(ear, NODE) as node:
        fleet = Puppets(stage, node)
        try:
            play(fleet)
        finally:
            fleet.close()
