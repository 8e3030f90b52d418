"""One behaviour on both targets: what a script of inputs makes the generated nodes do.

The script is drawn at random (seeded) while the generated controller runs here, on a port that only
takes notes; so it is known which events each input must lead to. The ROS 1 node and the ROS 2 node
then get the same inputs, each once the events of the one before are in the node's event log, and
must have logged the very same events.
"""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest
from emit.generated_code import controller_class
from ros1.stage import Stage
from ros2.ros2_support import Graph, Peer, Process
from ros_support import EXAMPLES, Master, Workspace, await_condition

from robosc import pipeline
from robosc.runtime.engine import Engine
from robosc.runtime.port import Port
from robosc.runtime.report import event_document
from robosc.runtime.settings import Settings

MODEL = EXAMPLES / "line_follower" / "line_follower.rscd"
PACKAGE = "line_follower_controller"
SEED = 20_240_607
STEPS = 60
TOPICS = {"distance": "Float32", "correction": "Float32", "no_line": "Empty"}
KEYS = {
    "distance": "DistanceSensor.distance",
    "correction": "LineDetector.correction",
    "no_line": "LineDetector.no_line",
    "grab": "ObstacleGrabber.grab",
    "light": "LightBulb.set_light_state",
}
# So slow that only inputs make commands, never the passing of time.
SLOW = {"rate": 0.001, "timeout__grab": 100.0, "timeout__set_light_state": 100.0}


class Step(NamedTuple):
    """An input, and the events that there are in all when the controller is done with it."""

    subject: str
    value: Any
    events: int
    cancels: bool


class Notes(Port):
    """A middleware that only notes which requests are under way."""

    def __init__(self) -> None:
        self.pending: dict[str, int] = {}
        self.cancelled = False

    def now(self) -> float:
        return 0.0

    def send(self, key: str, data: Any) -> None:
        pass

    def call(self, key: str, data: Any, token: int, timeout: float) -> None:
        self.pending[key] = token

    start = call

    def cancel(self, key: str, token: int) -> None:
        self.cancelled = self.pending.pop(key, None) is not None

    def log(self, level: str, text: str) -> None:
        pass


def told(document: dict[str, Any]) -> tuple[Any, ...]:
    return document["event"], document["outcome"]


def draw(seed: int) -> tuple[list[Step], list[tuple[Any, ...]]]:
    """A script, and the events that it leads to, those before its first input included."""
    supervisor = pipeline.synthesize(pipeline.load(MODEL).robot)
    port = Notes()
    engine = Engine(controller_class(supervisor)[0](), port, Settings(rate=SLOW["rate"]))
    chance = random.Random(seed)
    engine.begin()
    engine.cycle()
    steps: list[Step] = []

    def take(subject: str, value: Any) -> None:
        key = KEYS[subject]
        port.cancelled = False
        if subject in TOPICS:
            engine.post(key, "response", SimpleNamespace(data=value))
        else:
            kind = "response" if value == "succeed" else "error"
            engine.report(key, port.pending.pop(key), kind, SimpleNamespace())
        engine.cycle()
        steps.append(Step(subject, value, engine.journal.number, port.cancelled))

    while len(steps) < STEPS:
        if KEYS["light"] in port.pending:
            take("light", "succeed")  # which the robot does by itself
            continue
        subject = chance.choice(["distance", "distance", "correction", "no_line", "grab"])
        if subject == "grab":
            if KEYS["grab"] in port.pending:
                take(subject, chance.choice(["succeed", "abort"]))
        else:
            value = {
                "distance": chance.choice([0.125, 2.0]),
                "correction": chance.randint(-100, 100) / 4,
                "no_line": None,
            }[subject]
            take(subject, value)
    return steps, [told(json.loads(json.dumps(event_document(e)))) for e in engine.journal.take()]


def follow(steps: Sequence[Step], log: Path, do: Callable[[Step], None]) -> list[tuple[Any, ...]]:
    """Have each step done in its turn; what the node logged."""

    def lines() -> list[str]:
        return log.read_text(encoding="utf-8").splitlines() if log.exists() else []

    for number, step in enumerate(steps):
        do(step)
        what = f"the {step.events} events after step {number}, {step.subject} {step.value}"
        await_condition(lambda step=step: len(lines()) >= step.events, what)
    return [told(json.loads(line)) for line in lines()]


@pytest.fixture(scope="module")
def script() -> tuple[list[Step], list[tuple[Any, ...]]]:
    steps, events = draw(SEED)
    kinds = {(event["kind"], event["name"]) for event, _ in events}
    commands = {("request", n) for n in ("move", "stop", "grab", "set_light_state")}
    assert commands | {("cancel", "grab"), ("error", "grab"), ("response", "grab")} <= kinds
    return steps, events


def test_the_ros_1_node_follows_the_script(
    example_workspace: Workspace, roscore: Master, tmp_path: Path, script: Any
) -> None:
    steps, events = script
    log = tmp_path / "events.jsonl"
    stage = Stage(example_workspace, roscore)

    def do(step: Step) -> None:
        if step.subject == "grab":
            robot.do("finish", name="/grab", mode=step.value)
        elif step.subject in TOPICS:
            robot.publish(f"/{step.subject}", f"std_msgs/{TOPICS[step.subject]}", step.value)

    with stage.puppet() as robot, stage.puppet() as ear:
        # Slow enough for all commands of a moment to be sent before the response to one.
        light = "robot_common/LightBulbService"
        robot.do("service", name="/set_light_state", type=light, delay=0.2)
        robot.do("action", name="/grab", type="robot_common/GrabberAction", mode="hold")
        with stage.controller(ear, PACKAGE, event_log=str(log), **SLOW):
            assert follow(steps, log, do) == events


def test_the_ros_2_node_follows_the_script(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path, script: Any
) -> None:
    steps, events = script
    log = tmp_path / "events.jsonl"
    robot = graph.peer()
    goals: list[str] = []

    def do(step: Step) -> None:
        if step.subject == "light":
            request = robot.expect("request", name="/set_light_state")
            robot.order("tell_server", id=request["id"], data={})
        elif step.subject == "grab":
            end_goal(robot, step.value)
        else:
            type_ = f"std_msgs/msg/{TOPICS[step.subject]}"
            data = {} if step.value is None else {"data": step.value}
            robot.publish(f"/{step.subject}", type_, data)
            if step.cancels:
                robot.expect("cancel", name="/grab")
                end_goal(robot, "canceled")

    def end_goal(robot: Peer, how: str) -> None:
        goals.append(robot.expect("goal", name="/grab")["id"])
        robot.order("tell_server", id=goals[-1], end=how)

    robot.serve("/set_light_state", "robot_common/srv/LightBulbService")
    robot.act("/grab", "robot_common/action/Grabber")
    reliable = {f"qos__{topic}__reliability": "reliable" for topic in TOPICS}
    controller(PACKAGE, event_log=str(log), **SLOW, **reliable)
    assert follow(steps, log, do) == events
    assert goals
