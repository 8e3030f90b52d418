"""What the generated code does in each mode is what single events of the plant can do.

The reference is :class:`SingleEvents` (the plant's own step); the other side is the generated class
with the engine of a controller, of a supervisor and of a monitor, on random models and inputs.
"""

from __future__ import annotations

import json
import random
from collections.abc import Sequence
from typing import Any

import pytest
from emit.generated_code import supervisor_of
from quick import quick_first
from random_models import random_model
from runtime.lamp_robot import PlayedPort

from robosc.expr.tree import REASON
from robosc.language.events import EventKind
from robosc.plant.acceptance import phase_of
from robosc.plant.automaton import Event, Plant
from robosc.runtime.core.calls import FAILED, Failure
from robosc.runtime.core.settings import Settings
from robosc.runtime.judge.monitoring import monitor_engine
from robosc.runtime.judge.ports import MonitorPort
from robosc.simulate.machines.event_by_event import SingleEvents
from robosc.simulate.machines.execute import Execution, read_given
from robosc.simulate.machines.machine import Happening, event_of_document, label
from robosc.simulate.machines.state import make_controller, state_of_controller
from robosc.simulate.machines.supervised import SupervisedExecution
from robosc.simulate.values.event_data import Given, complete, random_raw
from robosc.supervisor import Supervisor

STEPS = 30


def random_supervisor(seed: int, supervises: bool) -> Supervisor:
    """The first of the seed's models that has a supervisor."""
    rng = random.Random(seed)
    while True:
        text = random_model(rng, 1 + seed % 3, served=bool(seed % 2), stays=seed % 5 == 0)
        supervisor = supervisor_of(text, supervises=supervises)
        if not supervisor.empty:
            return supervisor


def drawn_value(plant: Plant, event: Event, rng: random.Random) -> Given:
    """Any value that the event can carry; its numbers are near those of the models."""
    return complete(plant.robot, event, near(random_raw(plant.robot, event, rng)), label(event))


def near(raw: Any) -> Any:
    match raw:
        case bool() | str() | None:
            return raw
        case int():
            return raw if abs(raw) < 7 else raw % 13 - 6
        case float():
            return round(raw / 8) / 2
        case list():
            return [near(part) for part in raw]
    return {path: near(part) for path, part in raw.items()}


def same_state(single: SingleEvents, found: Any) -> None:
    expected = single.state
    assert repr(expected.components) == repr(found.components)
    assert repr(dict(expected.phases)) == repr(dict(found.phases))
    assert repr(dict(expected.variables)) == repr(dict(found.variables))


def follow(single: SingleEvents, happened: Happening) -> None:
    """Let the reference do what has happened, or see that it cannot."""
    event = event_of_document(single, happened.document()["event"])
    robot = single.plant.robot
    given: Given = {}
    if not event.kind.of_component and (not event.controllable or robot.supervises):
        given = complete(robot, event, happened.value, label(event))
    possible = single.can(event, given)
    if happened.outcome == "mismatch":
        assert not possible, happened
    elif happened.outcome == "applied":
        assert possible, happened
        single.fire(event, given)


def walk(machine: Execution, seed: int) -> None:
    rng = random.Random(seed)
    single = SingleEvents(machine.supervisor)
    happened: Sequence[Happening] = machine.beginning
    for _ in range(STEPS):
        for one in happened:
            if one.kind == "stop":
                return  # internal transitions without end
            if one.outcome != "blocked":
                follow(single, one)
        same_state(single, machine.state)
        step = machine.draw(rng)
        if isinstance(step, float):
            happened = machine.wait(step)
            continue
        if step is None:
            break
        event = step[0]
        given = drawn_value(single.plant, event, rng)
        possible = single.can(event, given)
        happened = machine.fire(event, given)
        blocked = [one for one in happened if one.outcome == "blocked"]
        if event.controllable and blocked and "corrected" not in (blocked[0].judged or {}):
            assert not possible, (event, given)


@pytest.mark.parametrize("seed", quick_first(range(40), 10))
def test_controllers(seed: int) -> None:
    walk(Execution(random_supervisor(seed, supervises=False), Settings()), seed)


@pytest.mark.parametrize("seed", quick_first(range(40), 10))
def test_supervisors(seed: int) -> None:
    supervisor = random_supervisor(seed, supervises=True)
    walk(SupervisedExecution(supervisor, Settings(whole_values=True)), seed)


class SilentPort(PlayedPort, MonitorPort):
    """Keeps the findings."""

    def __init__(self) -> None:
        super().__init__()
        self.documents: list[dict[str, Any]] = []

    def found(self, text: str) -> None:
        self.documents.append(json.loads(text))


@pytest.mark.parametrize("seed", quick_first(range(40), 10))
def test_monitors(seed: int) -> None:
    """What another controller sends is found exactly where the supervisor would not have sent it."""
    supervisor = random_supervisor(seed, supervises=True)
    rng = random.Random(seed)
    single = SingleEvents(supervisor)
    plant = supervisor.plant
    heard = MonitoredRobot(supervisor)
    events = [e for e in plant.events if not (e.kind.of_component or e.kind.clocked or _unseen(e))]
    if not events:
        return
    happened = heard.happened()
    for _ in range(STEPS):
        for one in happened:
            if one.kind == "stop":
                return  # internal transitions without end
            follow(single, one)
        same_state(single, state_of_controller(heard.controller))
        happened = []
        event = rng.choice(events)
        phase = phase_of(event)
        if phase is not None and single.plant_state[phase.variable] not in phase.sources:
            continue  # it crosses what ends the call
        given = drawn_value(plant, event, rng)
        possible = single.can(event, given)
        if not possible and rng.random() < 0.8:
            continue
        heard.tell(event, given)
        if event.kind is EventKind.CANCEL and not possible:
            return  # it is no finding: the goal goes on until the robot says otherwise
        happened = heard.happened()
        wrong = "forbidden" if event.controllable else "mismatch"
        assert happened[0].outcome == ("applied" if possible else wrong), (event, given)
        stopped = any(one.kind == "stop" for one in happened)
        assert bool(heard.port.documents) is (stopped or not possible)
        if not possible:
            return  # what follows from it is for the monitor to say


def _unseen(event: Event) -> bool:
    """Whether it is an answer to what the robot calls, which no monitor sees by itself."""
    return event.kind.served or event.kind in (EventKind.CALL, EventKind.RECALL)


class MonitoredRobot:
    """A monitor, and what there is to be seen of the robot and of its controller."""

    def __init__(self, supervisor: Supervisor) -> None:
        self.port = SilentPort()
        self.controller = make_controller(supervisor)
        read_given(self.controller, supervisor.plant)
        settings = Settings(whole_values=True)
        self.monitor = monitor_engine(self.controller, self.port, settings, lambda: self.port.time)
        self.monitor.begin()

    def tell(self, event: Event, given: Given) -> None:
        role, key, kind = self.monitor.role, event.key, event.kind
        if event.controllable:
            role.see(key, kind.word, given)
        elif phase_of(event) is None:
            self.monitor.post(key, kind.word, given)
        elif kind in (EventKind.ERROR, EventKind.CANCELLED):
            role.answer(key, kind.word, Failure("simulated", given, given.get(REASON) or FAILED))
        else:
            role.answer(key, kind.word, given)

    def happened(self) -> list[Happening]:
        """Let time pass until nothing can have crossed; what the monitor has taken since."""
        for _ in range(3):
            self.monitor.cycle()
            self.port.time += 1.0
        self.monitor.cycle()
        return [
            Happening(e.kind, e.name, e.value, e.tau, e.outcome, e.detail)
            for e in self.monitor.recorder.take()
        ]
