"""One behaviour on both targets: scripts of inputs, and what they must make a generated node do.

A script is drawn at random (seeded) while the generated controller runs here, on a port that only
takes notes; so it is known which events each input must lead to, and which data each command must
carry. The ROS 1 node and the ROS 2 node then get the same inputs, each once the events of the one
before are in the node's event log and its requests with the robot. They must log the very same
events, and the robot must receive the very same data.
"""

from __future__ import annotations

import json
import math
import random
import struct
from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cache
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from emit.generated_code import controller_class
from ros_support import EXAMPLES, REPOSITORY, await_condition

from robosc import pipeline
from robosc.language.events import Kind
from robosc.model.entities import Communication, Robot
from robosc.runtime.core.calls import Failure
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.interfaces import Port
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import dump, event_document
from robosc.supervisor import Supervisor

__all__ = ["SCENES", "SLOW", "Scene", "Script", "Side", "Step", "drawn", "play", "supervisor_of"]

Json = dict[str, Any]
_FORMATS = {"Int8": "b", "Float32": "<f"}
"""Of the messages here that cannot carry every value: a command with another one fails."""
STEPS = 120
SEED = 6

SLOW = {"rate": 0.001, "server_lost_after": 600.0, "state_rate": 200.0, "whole_values": True}
"""Parameters with which only inputs make commands, never the passing of time."""


@dataclass(frozen=True)
class Scene:
    """A robot, and what it may say: messages by communication, and by ``name.feedback``."""

    model: Path
    says: Mapping[str, Sequence[Json]]

    @property
    def package(self) -> str:
        return f"{self.model.stem}_controller"


def data(*values: Any) -> list[Json]:
    return [{"data": value} for value in values]


NUMBERS = [n / 4 for n in range(-100, 100, 7)]
SCENES = {
    "line_follower": Scene(
        EXAMPLES / "line_follower_first_edition" / "line_follower.rscd",
        {
            "distance": data(0.125, 2.0),
            "correction": data(*NUMBERS),
            "no_line": [{}],
            "set_light_state": [{}],
            "grab": [{}],
            "grab.feedback": [{}],
        },
    ),
    "navigation": Scene(
        EXAMPLES / "navigation" / "navigation.rscd",
        {
            "clicked_point": [
                {"header": {"frame_id": "map"}, "point": {"x": n, "y": -n, "z": 9.0}}
                for n in NUMBERS
            ],
            "emergency_stop": data(True, False),
            "navigate": [{"distance": 0.5}],
            "navigate.feedback": [{"distance": n} for n in NUMBERS],
        },
    ),
    "workbench": Scene(
        REPOSITORY / "robosc_ros1" / "test" / "ros2" / "models" / "workbench.rscd",
        {
            "scan": data([0.25], [-1.0, 2.0], [0.75, 0.5, 9.0], [], [math.nan, 2.0]),
            "outline": [
                {"points": [{"x": 1.0, "y": 2.0}, {"x": x, "y": 0.0, "z": 4.0}]}
                for x in (0.0, 1.5, -7.25)
            ]
            + [{"points": []}],
            "label": data("", 'a "b" \\ c', "größer 漢字 🤖", "line\nline"),
            "up": [{}],
            "level": data(-2, 0, 1, 2, 3, 4, 4, 5, -300),
            "switch": [
                {"success": True, "message": "it's on"},
                {"success": False, "message": "nö"},
            ],
            "go": [{"distance": 0.125}, {"distance": 3.0}],
            "go.feedback": [{"distance": d} for d in (1.25, 1e300, math.inf)],
        },
    ),
}


class Step(NamedTuple):
    """What the robot does, and what there is in all when the controller is done with it: events, and
    requests and cancels by communication."""

    name: str
    kind: str  # "response", "feedback", "error" or "cancelled"
    message: Json
    events: int
    requests: Mapping[str, int]
    cancels: Mapping[str, int]


class Script(NamedTuple):
    """``sent`` has the data of all commands in order, by topic, service or action."""

    robot: Robot
    steps: Sequence[Step]
    events: Sequence[tuple[Any, ...]]
    sent: Mapping[str, Sequence[Json]]
    sent_at_first: Mapping[str, int]
    events_at_first: int

    @property
    def timed(self) -> Sequence[str]:
        """The names of what has a timeout: services, actions, and some messages."""
        found = (c for c in self.robot.communications.values() if c.phases is not None)
        return [self.robot.display_names[c.key] for c in found]


class Notes(Port):
    """A middleware that only notes what it is to do."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.pending: dict[str, int] = {}
        self.cancelling: set[str] = set()
        self.sent: dict[str, list[Json]] = {}
        self.requests: Counter[str] = Counter()
        self.cancels: Counter[str] = Counter()

    def now(self) -> float:
        return 0.0

    def send(self, key: str, data: Any) -> None:
        communication = self.robot.communications[key]
        if communication.binding.type in _FORMATS:
            struct.pack(_FORMATS[communication.binding.type], only_value(data))
        self.sent.setdefault(communication.identifier, []).append(data or {})

    def call(self, key: str, data: Any, token: int) -> None:
        self.send(key, data)
        self.pending[key] = token
        self.cancelling.discard(key)
        self.requests[self.robot.display_names[key]] += 1

    start = call

    def cancel(self, key: str, token: int) -> None:
        if key not in self.cancelling:
            self.cancelling.add(key)
            self.cancels[self.robot.display_names[key]] += 1

    def log(self, level: str, text: str) -> None:
        pass


def only_value(data: Json) -> Any:
    (value,) = data.values()
    return value


@cache
def supervisor_of(scene: str) -> Supervisor:
    return pipeline.synthesize(pipeline.load(SCENES[scene].model).robot)


@cache
def drawn(name: str) -> Script:
    """The script of a scene."""
    supervisor = supervisor_of(name)
    robot = supervisor.plant.robot
    port = Notes(robot)
    engine = controller_engine(controller_class(supervisor)[0](), port, Settings(rate=SLOW["rate"]))
    chance = random.Random(SEED)
    engine.begin()
    engine.cycle()
    at_first = {topic: len(sent) for topic, sent in port.sent.items()}, engine.recorder.number
    steps = []
    while len(steps) < STEPS:
        communication, kind = _chosen(robot, port, chance)
        key, called = communication.key, robot.display_names[communication.key]
        says = SCENES[name].says[called if kind != "feedback" else f"{called}.feedback"]
        message = chance.choice(says)
        if communication.kind is Kind.OUTGOING:
            engine.post(key, kind, _object(message))
        else:
            token = port.pending[key] if kind == "feedback" else port.pending.pop(key)
            said = _object(message)
            failed = kind in ("error", "cancelled")
            engine.report(key, token, kind, Failure("", said) if failed else said)
        engine.cycle()
        happened = engine.recorder.number, dict(port.requests), dict(port.cancels)
        steps.append(Step(called, kind, message, *happened))
    events = [_told(json.loads(dump(event_document(e)))) for e in engine.recorder.take()]
    _demand_coverage(robot, {(e["kind"], e["name"]) for e, told in events if told == "applied"})
    return Script(robot, steps, events, port.sent, *at_first)


def _demand_coverage(robot: Robot, seen: Set[tuple[str, str]]) -> None:
    """A script that leaves out a sort of event would hold nobody to it."""
    call = ("request", "response")
    kinds = {
        Kind.OUTGOING: ("response",),
        Kind.INCOMING: ("request",),
        Kind.SERVICE: call,
        Kind.ACTION: (*call, "feedback", "error", "cancel", "cancelled"),
    }
    for communication in robot.communications.values():
        name = robot.display_names[communication.key]
        assert {(kind, name) for kind in kinds[communication.kind]} <= seen


def _chosen(robot: Robot, port: Notes, chance: random.Random) -> tuple[Communication, str]:
    """What the robot does next: often something about a request that is under way."""
    under_way = [robot.communications[key] for key in port.pending]
    if under_way and chance.random() < 0.5:
        communication = chance.choice(under_way)
        if communication.kind is not Kind.ACTION:
            return communication, "response"
        if communication.key in port.cancelling:
            return communication, chance.choice(["response", "error", "cancelled", "cancelled"])
        return communication, chance.choice(["response", "feedback", "feedback", "error"])
    inputs = [c for c in robot.communications.values() if c.kind is Kind.OUTGOING]
    return chance.choice(inputs), "response"


def _object(message: Any) -> Any:
    """A message as its fields."""
    if isinstance(message, dict):
        made = type("Message", (), {"__slots__": tuple(message)})()
        for name, value in message.items():
            setattr(made, name, _object(value))
        return made
    return [_object(part) for part in message] if isinstance(message, list) else message


def _told(document: Json) -> tuple[Any, ...]:
    return document["event"], document["outcome"]


class Side(Protocol):
    """The robot on one version of ROS."""

    def publish(self, communication: Communication, message: Json) -> None: ...

    def end(self, name: str, communication: Communication, kind: str, message: Json) -> None:
        """End the call or goal under way, or give feedback of it."""

    def requests(self, identifier: str) -> Sequence[Json]:
        """What was asked of a service or action so far."""

    def cancels(self, identifier: str) -> int:
        """How many goals were to be cancelled so far."""

    def messages(self, identifier: str) -> Sequence[Json]:
        """What came on a topic so far."""


def play(script: Script, log: Path, robot: Side) -> None:
    """Do each step in its turn, and compare what came of it."""
    called = {script.robot.display_names[c.key]: c for c in script.robot.communications.values()}

    def lines() -> list[str]:
        return log.read_text(encoding="utf-8").splitlines() if log.exists() else []

    await_condition(lambda: len(lines()) >= script.events_at_first, "what comes before any input")
    for number, step in enumerate(script.steps):
        what = f"step {number}, {step.kind} of {step.name}"
        communication = called[step.name]
        if communication.kind is Kind.OUTGOING:
            robot.publish(communication, step.message)
        else:
            robot.end(step.name, communication, step.kind, step.message)
        await_condition(lambda s=step: len(lines()) >= s.events, f"{step.events} events at {what}")
        for name, count in step.requests.items():
            asked = called[name].identifier
            await_condition(lambda a=asked, c=count: len(robot.requests(a)) >= c, f"{asked} {what}")
        for name, count in step.cancels.items():
            asked = called[name].identifier
            await_condition(lambda a=asked, c=count: robot.cancels(a) >= c, f"cancel {what}")
    logged = [_told(json.loads(line)) for line in lines()]
    pairs = zip_longest(logged, script.events)
    differ = [(n, *pair) for n, pair in enumerate(pairs) if pair[0] != pair[1]]
    assert not differ, differ[:5]
    for communication in called.values():
        if communication.kind is not Kind.OUTGOING:
            _compare(script, communication, robot)


def _compare(script: Script, communication: Communication, robot: Side) -> None:
    """What the robot got of a communication, with what was sent.

    A subscriber may miss what is sent at the very start.
    """
    name = communication.identifier
    incoming = communication.kind is Kind.INCOMING
    sent = script.sent.get(name, ())
    missable = script.sent_at_first.get(name, 0) if incoming else 0
    came = robot.messages if incoming else robot.requests
    await_condition(
        lambda: len(sent) - missable <= len(came(name)) <= len(sent), f"all commands of {name}"
    )
    found = came(name)
    for message, wanted in zip(found, sent[len(sent) - len(found) :], strict=True):
        assert _carries(message, wanted), f"{name}: {message} instead of {wanted}"


def _carries(message: Any, wanted: Any) -> bool:
    """Whether a message has the data; a field without a name is the only one."""
    if isinstance(wanted, dict):
        return all(
            _carries(message[name] if name else only_value(message), value)
            for name, value in wanted.items()
        )
    if isinstance(wanted, float) and math.isnan(wanted):
        return message == "NaN" or math.isnan(message)
    return bool(message == wanted)
