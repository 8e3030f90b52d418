"""The test of a generated package, played without ROS: its judge and its guide beside a controller.

The controller runs as it is generated, on a port that plays the robot; the judge gets its events and
states as the node would publish them. So many faults can be planted in little time.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import importlib
import random
import sys
import threading
from collections import defaultdict, deque
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from emit.generated_code import controller_source, supervisor_of
from runtime.lamp_robot import PlayedPort

from robosc.emit.controller.whole_guards import whole_guards
from robosc.emit.package.package import File, own_test_files
from robosc.emit.package.target import plant_module
from robosc.runtime.calls import Failure
from robosc.runtime.commanding import controller_engine
from robosc.runtime.engine import Engine
from robosc.runtime.model import Controller
from robosc.runtime.port import WaitingCall
from robosc.runtime.settings import read
from robosc.runtime.telemetry import dump, event_document, state_document
from robosc.supervisor import Supervisor

__all__ = [
    "Robot",
    "class_of",
    "engine_of",
    "guide_of",
    "judged",
    "judging_model",
    "judging_modules",
    "message_of",
    "play",
]

SILENCE = 0.3
"""Seconds: the timeout of messages, as in the test of a package."""
MOMENTS = 50
"""So often the clock is looked at while the robot waits for a time of the model."""
_PLAYING = File(
    "from goals import Goals\nfrom guard_checker import GuardChecker\nfrom random_commands import RandomCommands\n"
    "from play_loop import play_round\nfrom run_report import coverage\n"
)
_FILES = own_test_files({"test/play.py": _PLAYING})
MODULES = ("plant_data", *(Path(path).stem for path in _FILES))


@contextlib.contextmanager
def judging_modules(folder: Path, supervisor: Supervisor) -> Iterator[Any]:
    """Give the module ``judge`` as it lies in the package of a supervisor.

    Those of another package, whose fixture may be alive still, are put away meanwhile.
    """
    others = {name: sys.modules.pop(name) for name in MODULES if name in sys.modules}
    for path, file in _FILES.items():
        (folder / Path(path).name).write_text(file.content, encoding="utf-8")
    (folder / "plant_data.py").write_text(
        plant_module(supervisor.plant.robot, "model.rscd", whole_guards(supervisor)),
        encoding="utf-8",
    )
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        judge = importlib.import_module("checker")
        judge.TIMEOUT = 0.01  # type: ignore[attr-defined]  # nothing is on its way here
        yield judge
    finally:
        sys.path.remove(str(folder))
        for name in MODULES:
            sys.modules.pop(name, None)
        sys.modules.update(others)


def message_of(data: Any) -> Any:
    """Data of the controller as a message."""
    if isinstance(data, list):
        return [message_of(part) for part in data]
    if not isinstance(data, dict):
        return data
    return SimpleNamespace(**{name: message_of(part) for name, part in data.items()})


_DEFAULTS = {"boolean": False, "integer": 0, "double": 0.0, "string": ""}


class _Message(SimpleNamespace):
    """A message, and for its arrays of messages what makes one."""


class _Waiting(WaitingCall):
    """A call of the robot; it gets one answer."""

    def __init__(self, robot: Robot, key: str, number: int) -> None:
        self.results, self.number = robot.results[key], number
        self.spoilt = robot.spoilt

    def answer(self, data: Any) -> None:
        assert self.results[self.number] is None
        self.results[self.number] = (True, message_of(self.spoilt(data or {})))

    def refuse(self, text: str, data: Any = None) -> None:
        assert self.results[self.number] is None and text
        self.results[self.number] = (False, None)


class Robot(PlayedPort):
    """The port, and what the judge wants to know of the robot."""

    def __init__(self, judging: Any, seed: int, spoilt: Callable[[Any], Any]) -> None:
        super().__init__()
        self.chance = random.Random(seed)
        self.plant_data = judging.PLANT
        self.enums = judging.PLANT["enums"]
        self.values = importlib.import_module("random_messages").Values(random.Random(seed))
        self.values.as_it_arrives = lambda message: message
        self.values.array_of = lambda owner, name: (0, None, owner.makers[name])
        self.plant = {c["key"]: c for c in judging.PLANT["communications"]}
        self.lock = threading.Lock()
        self.received: dict[str, deque[Any]] = defaultdict(deque)
        self.requests: dict[str, deque[Any]] = defaultdict(deque)
        self.told: dict[tuple[str, str], deque[Any]] = {}
        self.last: dict[str, tuple[list[str], Any]] = {}
        self.running: dict[str, int] = {}
        self.withdrawn: set[int] = set()
        self.spoilt = spoilt
        self.runs = importlib.import_module("goals").Goals(self.moment)
        self._moment = 0.0
        self.results: dict[str, list[Any]] = {
            key: [] for key, c in self.plant.items() if c["kind"] == "outgoing service"
        }
        topics: dict[str, list[str]] = defaultdict(list)
        for key, communication in self.plant.items():
            if communication["kind"] == "outgoing message":
                topics[communication["identifier"]].append(key)
        self.topics = list(topics.values())

    def moment(self) -> float:
        """The time, which differs from one event to the next as on a real clock."""
        self._moment = max(self.time, self._moment + 0.000001)
        return self._moment

    @property
    def cancels(self) -> dict[str, int]:
        """How many goals the robot cancelled, by their action: none."""
        return dict.fromkeys(self.results, 0)

    def unknown_reports(self, key: str, reports: Any) -> list[Any]:
        """The feedback that came and is not reported: none comes here."""
        return []

    @property
    def sent(self) -> Any:  # type: ignore[override]
        return self.told

    @sent.setter
    def sent(self, _: Any) -> None:
        """The base class keeps a list there."""

    def send(self, key: str, data: Any) -> None:
        self.received[self.plant[key]["identifier"]].append(message_of(self.spoilt(data or {})))

    def call(self, key: str, data: Any, token: int) -> None:
        self.requests[key].append(message_of(self.spoilt(data or {})))
        self.running[key] = token

    def start(self, key: str, data: Any, token: int) -> None:
        self.call(key, data, token)
        name = self.plant[key]["identifier"]
        others = [k for k, c in self.plant.items() if c["identifier"] == name]
        self.runs.begin(key, token, others)

    def cancel(self, key: str, token: int) -> None:
        self.withdrawn.add(token)

    def abandon(self, key: str, token: int) -> None:
        if self.running.pop(key, None) == token and self.plant[key]["kind"] == "action":
            self.runs.end(key, token, "error")

    def blank(self, type_: Any, field: str | None = None) -> Any:
        """A message of a type of the plant, or with a field of it."""
        while type_[0] == "enum":
            type_ = self.enums[type_[1]]["from"]
        fields = [(field, type_)] if field else type_[1] if type_[0] == "object" else []
        message = _Message(makers={})
        for name, inner in fields:
            while inner[0] == "enum":
                inner = self.enums[inner[1]]["from"]
            basic = inner[0] in _DEFAULTS
            usual = [] if inner[0] == "array" else self.blank(inner)
            setattr(message, name, _DEFAULTS[inner[0]] if basic else usual)
            made = inner[1] if inner[0] == "array" else None
            is_object = made is not None and made[0] == "object"
            message.makers[name] = (lambda made=made: self.blank(made)) if is_object else None
        return message

    def message(self, key: str, kind: str) -> Any:
        """A random message of a communication."""
        communication, part = self.plant[key], "request" if kind == "call" else kind
        make = lambda: self.blank(communication[part], communication[part + "_field"])  # noqa: E731
        return self.values.message(make, key, kind)

    def samples(self, count: int) -> dict[tuple[str, str], list[Any]]:
        """Random messages of each sort that the robot sends."""
        kinds = {
            (key, kind)
            for key, c in self.plant.items()
            for kind in ("response", "feedback")
            if c["kind"] not in ("incoming message", "outgoing service")
            and (kind == "response" or c["kind"] == "action")
        } | {(key, "call") for key in self.results}
        return {sort: [self.message(*sort) for _ in range(count)] for sort in sorted(kinds)}

    def boundaries(self, key: str, kind: str) -> Iterator[Any]:
        """Messages in which one field has a number of the model, and all others their defaults."""
        type_, field = self.plant[key][kind], self.plant[key][kind + "_field"]
        numbers = importlib.import_module("compared_values").literals(self.plant_data)
        numbers = {n for n in numbers if isinstance(n, int | float) and not isinstance(n, bool)}
        for path, sort in _numbers_in(type_, (field,) if field else ()):
            for number in sorted({float(n) if sort == "double" else n for n in numbers}):
                message = self.blank(type_, field)
                *outer, name = path
                setattr(functools.reduce(getattr, outer, message), name, number)
                yield message

    def act(self, engine: Engine[Any], step: Any, phase: dict[str, str]) -> None:
        """Do as the step says, or whatever comes, or fall silent for a while."""
        if step is not None and step[0] == "wait":
            for keys, message in list(self.last.values()):
                if step[1] not in keys and "fresh" in map(phase.get, keys):
                    self._publish(engine, keys, message)
        if step is None or step[0] in ("request", "cancel", "wait"):
            self.time += 0.11 if step else self.chance.choice([0.03, 0.03, 0.03, 0.11])
        if step is None and self.chance.random() < 0.03:
            self.time += 0.6
            return
        if step is None:
            step = self._random_step()
        if step[0] == "publish":
            self._publish(engine, step[1], step[2])
        elif step[0] == "call":
            self._call(engine, *step[1:])
        elif step[0] == "answer" and step[1] in self.running:
            if step[2] == "cancelled" and self.running[step[1]] not in self.withdrawn:
                return
            self._answer(engine, *step[1:])

    def _random_step(self) -> Any:
        called = [k for k in self.results if self.chance.random() < 0.3]
        if called:
            return "call", called[0], self.message(called[0], "call")
        running = [k for k in self.running if self.chance.random() < 0.3]
        if running:
            key = self.chance.choice(running)
            action = self.plant[key]["kind"] == "action"
            kinds = ["response", "error"] + ["feedback"] * action
            if self.running[key] in self.withdrawn:
                kinds += ["cancelled"] * 3
            kind = self.chance.choice(kinds)
            if kind == "cancelled":
                return "answer", key, kind, None
            if kind == "error":
                brings = action and self.plant[key]["response"] != ["none"]
                with_result = brings and self.chance.random() < 0.7
                return "answer", key, kind, self.message(key, "response") if with_result else None
            return "answer", key, kind, self.message(key, kind)
        if not self.topics:
            return ("wait",)
        keys = self.chance.choice(self.topics)
        return "publish", keys, self.message(keys[0], "response")

    def _publish(self, engine: Engine[Any], keys: list[str], message: Any) -> None:
        stamps = importlib.import_module("stamps")
        if any(key in stamps.DATED for key in keys):
            message.header = SimpleNamespace(stamp=_stamp_of(0.0))
            stamps.stamp(message, _stamp_of(self.time), self.chance)
        for key in keys:
            self.told.setdefault((key, "response"), deque()).append(message)
        self.last[keys[0]] = keys, message
        self.deliver(engine, keys, message)

    def deliver(self, engine: Any, keys: list[str], message: Any) -> None:
        """Bring a message that was published to the node."""
        engine.poster(keys)(message)

    def _call(self, engine: Engine[Any], key: str, message: Any) -> None:
        self.told.setdefault((key, "call"), deque()).append(message)
        self.results[key].append(None)
        engine.serve(key, message, _Waiting(self, key, len(self.results[key]) - 1))

    def are_answered(self, key: str, answers: list[Any]) -> bool:
        """Whether each call has got the answer that the controller reports."""
        carries = importlib.import_module("arrivals").carries

        def fits(answer: Any, result: Any) -> bool:
            if answer is None or result is None or not answer[0]:
                return answer == result
            return bool(result[0] and carries(result[1], answer[1] or {}))

        results = self.results[key]
        return len(results) == len(answers) and all(map(fits, answers, results))

    def _answer(self, engine: Engine[Any], key: str, kind: str, message: Any) -> None:
        self.told.setdefault((key, kind), deque()).append(message)
        token = self.running[key] if kind == "feedback" else self.running.pop(key)
        if kind != "feedback" and self.plant[key]["kind"] == "action":
            self.runs.end(key, token, kind, message)
        failed = kind in ("error", "cancelled")
        engine.report(key, token, kind, Failure("", message) if failed else message)


def _stamp_of(time: float) -> Any:
    """A time as ROS 1 has it."""
    seconds, parts = divmod(round(time * 10**9), 10**9)
    return SimpleNamespace(secs=seconds, nsecs=parts)


def _numbers_in(type_: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], str]]:
    """The paths of the numbers in messages of a type, with their sort; those in arrays and
    conversions apart."""
    if type_[0] in ("integer", "double"):
        yield path, type_[0]
    for name, inner in type_[1] if type_[0] == "object" else ():
        yield from _numbers_in(inner, (*path, name))


def class_of(source: str, called: set[str] | None = None) -> type[Controller]:
    """The class in the source of a controller; its methods put their names into ``called``."""
    namespace: dict[str, Any] = {"__name__": "controller", "_called": called}
    tree = ast.parse(source.replace("from ._runtime.", "from robosc.runtime."))
    for node in ast.walk(tree) if called is not None else ():
        if isinstance(node, ast.FunctionDef):
            node.body[:0] = ast.parse(f"_called.add({node.name!r})").body
    exec(compile(tree, "controller.py", "exec"), namespace)
    classes = [c for c in namespace.values() if isinstance(c, type)]
    (found,) = (c for c in classes if c.__base__ is Controller)
    return found


def judged(
    judging: Any,
    source: str,
    seed: int = 1,
    rounds: int = 150,
    spoilt: Callable[[Any], Any] = lambda data: data,
    kind: type[Robot] = Robot,
) -> Any:
    """The judge of a controller that has run for so many rounds, and on as the test of a package
    does, or until a fault was found.

    What the controller sends arrives ``spoilt``, at a robot of this ``kind``.
    """
    robot = kind(judging, seed, spoilt)
    engine = engine_of(controller_engine, source, robot)
    topics: dict[str, tuple[str, ...]] = defaultdict(tuple)
    for key, communication in robot.plant.items():
        if communication["kind"] == "incoming message":
            topics[communication["identifier"]] += (key,)
    publications = [(topic, None, keys) for topic, keys in topics.items()]
    judge = judging.Checker(robot, publications, guide_of(judging, robot))
    play(engine, robot, judge, rounds, robot.act)
    if not judge.faults:
        judge.compare_messages()
    return judge


def guide_of(judging: Any, robot: Robot) -> Any:
    """The guide of a robot as that of a package."""
    guiding = importlib.import_module("guide")
    draw = functools.partial(robot.samples, guiding.SAMPLES)
    return guiding.Guide(judging.PLANT, draw, robot.topics)


def engine_of(kind: Callable[..., Engine[Any]], source: str, robot: Robot) -> Any:
    """An engine with a controller, by the robot's clock."""
    controller = class_of(source)
    given = {f"timeout/{c.name}": SILENCE for c in controller.COMMUNICATIONS if c.timeout}
    settings, _ = read(controller.COMMUNICATIONS, given, controller.PARAMETERS)
    settings = settings._replace(whole_values=True)
    engine = kind(controller(), robot, settings, steady=lambda: robot.time)
    engine.recorder.now = robot.moment
    return engine


def play(
    engine: Engine[Any], robot: Robot, judge: Any, rounds: int, act: Callable[..., None]
) -> None:
    """Have the robot ``act`` for so many rounds, and on while they cover new cases, or until a
    fault was found: as in the test of a package, with a clock that counts rounds."""
    number = 0

    def tell() -> None:
        for entry in engine.recorder.take():
            judge.on_event(SimpleNamespace(data=dump(event_document(entry))))
        document = state_document(engine.snapshot(), []) | {"time": robot.time}
        judge.on_state(SimpleNamespace(data=dump(document)))

    engine.begin()
    tell()
    engine.cycle()
    tell()
    for topic in robot.received.values():
        topic.clear()  # nobody compares what was sent before the judge began

    def play_one() -> None:
        nonlocal number
        number += 1
        step = judge.next_step() if number % 4 else None
        is_waiting = step is not None and step[0] == "wait"
        has_lapsed, text = judge.lapse(step[1]) if is_waiting else (lambda: True, "")
        for _ in range(MOMENTS):
            act(engine, step, judge.shadow.phase)
            engine.cycle()
            tell()
            if has_lapsed():
                break
        else:
            judge.wait(has_lapsed, text)

    importlib.import_module("play_loop").play_rounds(judge, rounds, play_one, now=lambda: number)


@contextlib.contextmanager
def judging_model(folder: Path, model: str) -> Iterator[tuple[Any, str]]:
    """The judge of a model, and its controller, in which the judge finds no fault."""
    supervisor = supervisor_of(model)
    with judging_modules(folder, supervisor) as judge:
        source = controller_source(supervisor)
        assert judged(judge, source).faults == []
        yield judge, source
