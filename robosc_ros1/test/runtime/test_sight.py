"""A monitor that does not see what it must says so, and says nothing of what it sees."""

from __future__ import annotations

import json
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from runtime.schemas import validate

from robosc.runtime.core.interfaces import Outlet
from robosc.runtime.core.port import BEFORE_TIME
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import ERROR, Reporter
from robosc.runtime.judge.matching import CommandPattern
from robosc.runtime.judge.monitoring import monitor_engine
from robosc.runtime.judge.ports import MonitorPort
from robosc.runtime.judge.sight import NOTABLE, deciding_inputs
from robosc.runtime.judge.supervising import supervisor_engine

TOLERANCE = Settings().tolerance
PLAIN = """robot Plain {
    component Estop {
        outgoing message estop with identifier: "/estop", type: boolean
        behaviour {
            variable pressed: boolean
            on response from estop do pressed := value
            initial marked state on {}
        }
    }
    component Lamp {
        outgoing message dusk with identifier: "/dusk", type: boolean
        behaviour {
            variable dark: boolean
            on response from dusk do dark := value
            initial marked state on {}
        }
    }
    component Base { incoming message move with identifier: "/move", type: none }
    requirement move needs !Estop.pressed
}"""
TIMED = PLAIN.replace("estop with", "estop with timeout: 500 ms,").replace(
    "needs !Estop", "needs estop.fresh and !Estop"
)
AGED = (
    PLAIN.replace("estop with", "estop with max_age: 200 ms,")
    .replace("type: boolean", "type: sensor_msgs/Range", 1)
    .replace("pressed := value", "pressed := value.range > 1.0")
)
ESTOP, MOVE = "Estop.estop", "Base.move"
SETTINGS = Settings(timeout={ESTOP: 0.5})


class Port(MonitorPort):
    """Time of ROS and of the machine, and connections, that a test moves."""

    def __init__(self) -> None:
        self.time, self.seconds = 100.0, 0.0
        self.slowness = 0.0
        """The seconds that pass whenever the time is asked for."""
        self.missing: dict[str, str] = {}
        self.documents: list[dict[str, Any]] = []
        self.logs: list[str] = []

    def now(self) -> float:
        self.time += self.slowness
        self.seconds += self.slowness
        return self.time

    def unheard(self) -> dict[str, str]:
        return self.missing

    def found(self, text: str) -> None:
        document = json.loads(text)
        validate(document, "finding")
        self.documents.append(document)

    def blocked(self, text: str) -> None:
        """Do nothing."""

    def log(self, level: str, text: str) -> None:
        self.logs.append(text)

    def send(self, key: str, data: Any) -> None:
        """Do nothing."""


def shadow_engine(controller: Any, port: Any, settings: Settings, steady: Any) -> Any:
    return monitor_engine(controller, port, settings._replace(shadow=True), steady)


class Scene:
    """A node that judges; time goes on for ROS as for the machine while ``ros`` is true."""

    def __init__(self, text: str, engine_type: Any = monitor_engine) -> None:
        class_, _ = controller_class(supervisor_of(text))
        self.port = Port()
        self.ros = True
        self.engine = engine_type(class_(), self.port, SETTINGS, lambda: self.port.seconds)
        self.engine.recorder.now = lambda: self.port.seconds

    def begin(self) -> None:
        self.engine.begin()
        self.wait(0.1)

    def wait(self, seconds: float) -> None:
        end = self.port.seconds + seconds
        while self.port.seconds < end - 1e-9:
            self.port.seconds += 0.02
            self.port.time += 0.02 if self.ros else 0.0
            self.engine.cycle()
            self.engine.snapshot()

    def press(self, pressed: bool) -> None:
        self.engine.poster([ESTOP])(SimpleNamespace(data=pressed))
        self.engine.cycle()

    def move(self, times: int = 1) -> None:
        for _ in range(times):
            more = (None,) if self.engine.sends else ()  # what a supervisor passes on
            self.engine.role.offer("/move", (CommandPattern(MOVE),), SimpleNamespace(), *more)
            self.wait(0.1)

    @property
    def counts(self) -> tuple[int, int, int]:
        """How many commands were lawful, forbidden and undecided."""
        counters = self.engine.recorder.counters
        return counters["commands"], counters["forbidden"], counters["undecided"]

    @property
    def reason(self) -> str | None:
        found: str | None = self.engine.snapshot()["not_judging"]
        return found


def no_time(scene: Scene) -> None:
    scene.port.time, scene.ros = BEFORE_TIME, False


def time_stands(scene: Scene) -> None:
    scene.ros = False
    scene.wait(0.6)


def two_clocks(scene: Scene) -> None:
    for _ in range(3):
        scene.port.time -= 0.3
        scene.wait(0.1)


def clock_replaced(scene: Scene) -> None:
    scene.engine.restart_clocks("use_sim_time was changed")


def nobody(scene: Scene) -> None:
    scene.port.missing = {ESTOP: "/estop"}


CAUSES = {
    no_time: "ROS time has not begun",
    time_stands: "ROS time stands still",
    two_clocks: "ROS time steps back again and again",
    clock_replaced: "use_sim_time was changed",
    nobody: "nobody is connected that publishes /estop",
}


@pytest.mark.parametrize("engine_type", [monitor_engine, shadow_engine])
@pytest.mark.parametrize("pressed", [False, True])
@pytest.mark.parametrize("cause", CAUSES)
def test_what_comes_while_it_is_blind_is_neither_lawful_nor_forbidden(
    cause: Callable[[Scene], None], pressed: bool, engine_type: Any
) -> None:
    scene = Scene(TIMED if cause is not nobody else PLAIN, engine_type)
    scene.begin()
    scene.press(pressed)
    cause(scene)
    scene.wait(0.2)
    scene.move(5)
    assert scene.counts == (0, 0, 5)
    assert CAUSES[cause] in (scene.reason or "")
    (found,) = scene.port.documents
    assert (found["sort"], found["event"]["kind"]) == ("undecided", "span")
    assert CAUSES[cause] in found["reasons"][0]["text"]
    assert [e.outcome for e in scene.engine.recorder.take() if e.name == "move" and e.seen] == [
        "undecided"
    ] * 5


@pytest.mark.parametrize("engine_type", [monitor_engine, supervisor_engine])
def test_time_goes_on_while_what_came_is_handled_as_at_the_time_when_it_came(
    engine_type: Any,
) -> None:
    """On a machine that is slow."""
    scene = Scene(TIMED, engine_type)
    scene.begin()
    scene.press(False)
    more = (None,) if scene.engine.sends else ()
    for _ in range(40):
        scene.engine.role.offer("/move", (CommandPattern(MOVE),), SimpleNamespace(), *more)
    scene.port.slowness = 0.02
    scene.engine.cycle()
    assert scene.reason is None
    assert [text for text in scene.port.logs if "stands still" in text] == []
    assert scene.port.documents == []


def test_a_span_is_told_with_its_end_and_judging_goes_on() -> None:
    scene = Scene(PLAIN)
    scene.begin()
    before = scene.port.seconds
    nobody(scene)
    scene.wait(NOTABLE + 0.5)
    scene.move(3)
    scene.port.missing = {}
    scene.wait(0.3)
    after = scene.port.seconds
    scene.move()
    first, last = (f["event"]["value"] for f in scene.port.documents)
    assert first["end"] is None and first["commands"] == 0
    assert last["commands"] == 3 and before - 0.2 <= last["begin"] < last["end"] <= after
    assert scene.reason is None
    assert scene.counts == (1, 0, 3)
    scene.press(True)
    scene.wait(2 * TOLERANCE)
    scene.move()
    assert scene.counts == (1, 1, 3)
    assert [f["sort"] for f in scene.port.documents] == ["undecided", "undecided", "violation"]


def test_before_it_has_seen_all_only_commands_are_told() -> None:
    """A monitor is started before the robot."""
    scene = Scene(PLAIN)
    nobody(scene)
    scene.begin()
    scene.wait(2 * NOTABLE)
    assert scene.reason is not None and scene.port.documents == []
    scene.move()
    assert [f["event"]["value"]["commands"] for f in scene.port.documents] == [1]


@pytest.mark.parametrize("cause", [no_time, time_stands])
def test_a_model_without_durations_is_judged_by_the_clock_of_the_machine(
    cause: Callable[[Scene], None],
) -> None:
    scene = Scene(PLAIN)
    scene.begin()
    cause(scene)
    scene.move(3)
    scene.press(True)
    scene.wait(2 * TOLERANCE)
    scene.move(4)
    assert scene.counts == (3, 4, 0)


def test_ages_need_ros_time() -> None:
    scene = Scene(AGED)
    no_time(scene)
    scene.begin()
    assert "ROS time has not begun" in (scene.reason or "")


def test_silence_of_a_message_with_a_timeout_is_judged_once_it_was_heard() -> None:
    """The sensor's node has died, and the controller drives on."""
    scene = Scene(TIMED)
    scene.begin()
    scene.press(False)
    scene.move()
    nobody(scene)
    scene.wait(1.0)
    scene.move()
    assert scene.reason is None
    assert scene.counts == (1, 1, 0)


def test_only_what_decides_must_be_heard() -> None:
    scene = Scene(PLAIN)
    assert deciding_inputs(scene.engine.controller) == {ESTOP}
    scene.port.missing = {"Lamp.dusk": "/dusk"}
    scene.begin()
    assert scene.reason is None
    whole = Scene(
        PLAIN.replace(
            "    requirement", "    requirement always Lamp.dark or !Lamp.dark\n    requirement"
        )
    )
    assert deciding_inputs(whole.engine.controller) == {ESTOP, "Lamp.dusk"}


def test_commands_that_do_not_depend_on_what_is_missing_are_judged() -> None:
    text = PLAIN.replace("requirement move needs", "requirement move needs Lamp.dark and")
    text = text.replace(
        "type: none }", 'type: none incoming message beep with identifier: "/beep", type: none }'
    )
    text = text.replace(
        "    requirement", "    requirement beep needs !Estop.pressed\n    requirement"
    )
    scene = Scene(text)
    scene.begin()
    scene.port.missing = {"Lamp.dusk": "/dusk"}
    scene.wait(0.2)
    assert scene.reason is not None
    for key in ("Base.beep", MOVE):
        scene.engine.role.offer("/" + key, (CommandPattern(key),), SimpleNamespace())
        scene.wait(0.2)
    assert scene.counts == (1, 0, 1)


class Told(Outlet):
    """Keeps what is reported."""

    def __init__(self) -> None:
        self.states: list[dict[str, Any]] = []
        self.levels: list[tuple[int, str]] = []

    def state(self, text: str) -> None:
        self.states.append(json.loads(text))
        validate(self.states[-1], "state")

    def events(self, texts: list[str]) -> None:
        for text in texts:
            validate(json.loads(text), "event")

    def diagnostics(self, level: int, message: str, values: list[tuple[str, str]]) -> None:
        self.levels.append((level, message))


@pytest.mark.parametrize("engine_type", [monitor_engine, shadow_engine, supervisor_engine])
def test_diagnostics_and_state_say_that_it_does_not_judge(engine_type: Any) -> None:
    scene, told = Scene(PLAIN, engine_type), Told()
    nobody(scene)
    scene.begin()
    scene.move()
    reporter = Reporter(scene.engine, told, {})
    reporter.close()  # so that it asks the engine from this thread
    for missing in ({ESTOP: "/estop"}, {}):
        scene.port.missing = missing
        scene.wait(0.2)
        reporter._report(periodic=True)
    reason = "nobody is connected that publishes /estop"
    assert told.levels[0] == (ERROR, "not judging: " + reason)
    assert told.levels[1][0] != ERROR
    assert [state["not_judging"] for state in told.states] == [reason, None]
    assert told.states[0]["faults"] == ["not judging: " + reason]


def test_a_supervisor_tells_it_too() -> None:
    scene = Scene(PLAIN, supervisor_engine)
    nobody(scene)
    scene.begin()
    assert "/estop" in (scene.reason or "")


@pytest.mark.parametrize("order", ["hold", "step", "release"])
@pytest.mark.parametrize("engine_type", [monitor_engine, shadow_engine])
def test_who_sends_nothing_cannot_be_operated(engine_type: Any, order: str) -> None:
    scene = Scene(PLAIN, engine_type)
    scene.begin()
    scene.engine.recorder.take()
    scene.engine.operate(order)
    scene.engine.cycle()
    (event,) = (e for e in scene.engine.recorder.take() if e.kind == "operator")
    assert (event.value, event.outcome, event.detail) == (
        order,
        "refused",
        "this node sends nothing",
    )
    assert scene.engine.stopped is None


# How late it is


@pytest.mark.parametrize("late", [0.0, 0.1, 0.4])
@pytest.mark.parametrize("first", ["the message that forbids", "the command"])
@pytest.mark.parametrize("share", [0.5, 1.5])
def test_what_only_lateness_excuses_is_undecided(late: float, first: str, share: float) -> None:
    """The two messages cross by a share of what lateness adds to the tolerance."""
    scene = Scene(PLAIN)
    scene.begin()
    scene.engine.role.lateness.note(late)
    apart = TOLERANCE + 0.04 + share * 2 * late
    offer = lambda: scene.engine.role.offer("/move", (CommandPattern(MOVE),), SimpleNamespace())  # noqa: E731
    if first == "the command":
        scene.press(True)
        scene.wait(5.0)
        scene.engine.role.lateness.note(late)
        offer()
        scene.wait(apart)
        scene.press(False)
    else:
        scene.press(True)
        scene.wait(apart)
        offer()
    scene.wait(2.0)
    is_excused = late > 0.0 and share < 1.0
    assert scene.counts == ((0, 0, 1) if is_excused else (0, 1, 0))
    assert [f["sort"] for f in scene.port.documents] == ([] if is_excused else ["violation"])


def test_what_crosses_within_the_tolerance_is_lawful_however_late_it_is() -> None:
    scene = Scene(PLAIN)
    scene.begin()
    scene.engine.role.lateness.note(0.4)
    scene.press(True)
    scene.move()
    assert scene.counts == (1, 0, 0)


def test_lateness_is_shown_and_forgotten() -> None:
    scene = Scene(PLAIN)
    scene.begin()
    for delay in (0.02, 0.3, 0.1):
        scene.engine.role.lateness.note(delay)
    assert scene.engine.snapshot()["late"] == 0.3
    scene.wait(6.0)
    scene.engine.role.lateness.note(0.05)
    scene.wait(6.0)
    assert scene.engine.snapshot()["late"] == 0.05
    scene.wait(12.0)
    assert scene.engine.snapshot()["late"] == 0.0
