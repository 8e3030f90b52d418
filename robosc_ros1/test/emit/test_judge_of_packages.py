"""The judge of a package's own test: it is content with the controller, and with no faulty one.

The controller runs here as it is generated, on a port that plays the robot; the judge gets its
events and states as the node would publish them. So many faults can be planted in little time.
"""

from __future__ import annotations

import importlib
import random
import re
import sys
import threading
from collections import defaultdict, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_source, supervisor_of
from ros_support import EXAMPLES
from runtime.lamp_robot import PlayedPort

from robosc.emit.common import plant_module
from robosc.emit.engine import verbatim
from robosc.model.entities import Robot as ModelRobot
from robosc.runtime.engine import Engine
from robosc.runtime.model import Controller
from robosc.runtime.report import dump, event_document, state_document
from robosc.runtime.settings import read

MODEL = EXAMPLES / "line_follower_first_edition" / "line_follower.rscd"
ROUNDS = 400
MODULES = ("judge", "shadow", "plant_data")


@pytest.fixture(scope="module")
def source() -> str:
    return controller_source(supervisor_of(MODEL.read_text(encoding="utf-8")))


@pytest.fixture(scope="module")
def judging(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The module ``judge`` as it lies in the package."""
    robot = supervisor_of(MODEL.read_text(encoding="utf-8")).plant.robot
    with judging_of(robot, tmp_path_factory.mktemp("package_test")) as judge:
        yield judge


@contextmanager
def judging_of(model: ModelRobot, folder: Path) -> Iterator[Any]:
    """The module ``judge`` of a package of this model."""
    for name in ("judge.py", "shadow.py"):
        (folder / name).write_text(verbatim(f"common/{name}"), encoding="utf-8")
    (folder / "plant_data.py").write_text(plant_module(model, "model.rscd"), encoding="utf-8")
    sys.path.insert(0, str(folder))
    try:
        judge = importlib.import_module("judge")
        judge.PATIENCE = 0.01  # type: ignore[attr-defined]  # nothing is on its way here
        yield judge
    finally:
        sys.path.remove(str(folder))
        for name in MODULES:
            sys.modules.pop(name, None)


def message_of(data: Any) -> Any:
    """Data of the controller as a message."""
    if not isinstance(data, dict):
        return data
    return SimpleNamespace(**{name: message_of(part) for name, part in data.items()})


def blank(type_: Any, field: str | None) -> Any:
    """A message of a type of the plant, or with a field of it."""
    if field:
        return SimpleNamespace(**{field: blank(type_, None)})
    if type_[0] == "object":
        return SimpleNamespace(**{name: blank(inner, None) for name, inner in type_[1]})
    return SimpleNamespace()


class Robot(PlayedPort):
    """The port, and what the judge wants to know of the robot."""

    def __init__(self, judging: Any, seed: int, spoilt: Callable[[Any], Any]) -> None:
        super().__init__()
        self.chance = random.Random(seed)
        self.values = judging.Values(random.Random(seed))
        self.values.as_it_arrives = lambda message: message
        self.plant = {c["key"]: c for c in judging.PLANT["communications"]}
        self.lock = threading.Lock()
        self.received: dict[str, deque[Any]] = defaultdict(deque)
        self.requests: dict[str, deque[Any]] = defaultdict(deque)
        self.told: dict[tuple[str, str], deque[Any]] = {}
        self.running: dict[str, int] = {}
        self.spoilt = spoilt

    @property
    def sent(self) -> Any:  # type: ignore[override]
        return self.told

    @sent.setter
    def sent(self, _: Any) -> None:
        """The base class keeps a list there."""

    def send(self, key: str, data: Any) -> None:
        self.received[self.plant[key]["identifier"]].append(message_of(self.spoilt(data or {})))

    def call(self, key: str, data: Any, token: int, timeout: float) -> None:
        self.requests[key].append(message_of(self.spoilt(data or {})))
        self.running[key] = token

    start = call

    def cancel(self, key: str, token: int) -> None:
        self.running.pop(key)

    def act(self, engine: Engine) -> None:
        """Say something, go on with a request, or fall silent for a while."""
        if self.chance.random() < 0.03:
            self.time += 0.6
            return
        self.time += 0.03
        key = self.chance.choice(
            [*self.running, *(k for k, c in self.plant.items() if c["kind"] == "outgoing message")]
        )
        kind = "response"
        if key in self.running:
            action = self.plant[key]["kind"] == "action"
            kind = self.chance.choice(["response", "error"] + ["feedback"] * action)
        message = (
            None
            if kind == "error"
            else self.values.message(
                lambda: blank(self.plant[key][kind], self.plant[key][kind + "_field"]), key, kind
            )
        )
        self.told.setdefault((key, kind), deque()).append(message)
        if key not in self.running:
            engine.post(key, kind, message)
        elif kind == "feedback":
            engine.report(key, self.running[key], kind, message)
        else:
            engine.report(key, self.running.pop(key), kind, message)


def judged(
    judging: Any, source: str, seed: int = 1, spoilt: Callable[[Any], Any] = lambda data: data
) -> Any:
    """The judge of a controller that has run for a while, or until a fault was found.

    What the controller sends arrives ``spoilt``.
    """
    namespace: dict[str, Any] = {"__name__": "controller"}
    exec(source.replace("from ._runtime.", "from robosc.runtime."), namespace)
    (controller,) = (
        c for c in namespace.values() if isinstance(c, type) and c.__base__ is Controller
    )
    robot = Robot(judging, seed, spoilt)
    settings, _ = read(controller.COMMUNICATIONS, {})
    engine = Engine(controller(), robot, settings, steady=lambda: robot.time)
    topics: dict[str, tuple[str, ...]] = defaultdict(tuple)
    for key, communication in robot.plant.items():
        if communication["kind"] == "incoming message":
            topics[communication["identifier"]] += (key,)
    judge = judging.Judge(robot, [(topic, None, keys) for topic, keys in topics.items()])

    def tell() -> None:
        for entry in engine.recorder.take():
            judge.on_event(SimpleNamespace(data=dump(event_document(entry))))
        judge.on_state(SimpleNamespace(data=dump(state_document(engine.snapshot(), []))))

    engine.begin()
    tell()
    tell()
    for _ in range(ROUNDS):
        robot.act(engine)
        engine.cycle()
        tell()
        if judge.faults:
            return judge
    judge.compare_messages()
    return judge


@pytest.mark.parametrize("seed", range(5))
def test_it_is_content_with_the_controller(judging: Any, source: str, seed: int) -> None:
    judge = judged(judging, source, seed)
    assert judge.faults == []
    assert [row for row in judging.coverage(judge) if not row[2]] == []


FAULTS = (
    # what must be, where it is looked for, what is made of it
    (r"self\.\w+ [!=]= \"\w+\"", r"    def (?:requirement|can_request|synchronises)_.*", "True"),
    (r"self\.requirement_\d+\(\)", r"    def can_request_.*", "True"),
    (r"= (?:\"\w+\"|True|False)$", r"    def (?:on|request|cancel)_.*", '= "elsewhere"'),
    (r"(?<=: )\d\.\d", r"    def data_for_.*", "7.5"),
    (r"0\.35", r"def clearance.*", "0.36"),
    (r">=", r"def clearance.*", ">"),
)


HARMLESS = [
    'self.distance_fresh = "elsewhere"',  # as good as True
    'return True and self.motor == "stopped"',  # the first grab comes after the first distance
    'self.grab_busy = "elsewhere"',  # as the first
    'return True or self.light_bulb == "known"',  # its service is busy in the third state
    'return self.light_bulb == "unknown" or True',
    'self.set_light_state_busy = "elsewhere"',
]
"""Faults that let nothing happen that must not, here."""


def mutants(source: str) -> Iterator[tuple[str, str]]:
    """The controller with one fault each, and the line that has it."""
    lines = source.splitlines()
    place = ""
    for number, line in enumerate(lines):
        if line.lstrip().startswith("def "):
            place = line
        for pattern, where, wrong in FAULTS:
            for match in re.finditer(pattern, line.partition("  #")[0]):
                if re.fullmatch(where, place) and line.startswith(" " * 8):
                    spoilt = line[: match.start()] + wrong + line[match.end() :]
                    yield "\n".join([*lines[:number], spoilt, *lines[number + 1 :]]), spoilt


@pytest.mark.slow
def test_it_finds_every_fault_that_matters(judging: Any, source: str) -> None:
    tried = [(line, judged(judging, faulty).faults) for faulty, line in mutants(source)]
    assert [line.strip() for line, faults in tried if not faults] == HARMLESS
    assert len(tried) > 40


def faster(data: dict[str, Any]) -> dict[str, Any]:
    return {**data, "linear": {"x": 7.5}} if "linear" in data else data


def dark(data: dict[str, Any]) -> dict[str, Any]:
    return {**data, "state": not data["state"]} if "state" in data else data


@pytest.mark.parametrize(
    ("spoilt", "complaint"),
    [
        (faster, "waited in vain for /vel to carry what the events say"),
        (dark, "LightBulb.set_light_state was not asked for what the events say"),
    ],
)
def test_what_arrives_must_be_what_the_events_say(
    judging: Any, source: str, spoilt: Callable[[Any], Any], complaint: str
) -> None:
    assert judged(judging, source, spoilt=spoilt).faults == [complaint]
