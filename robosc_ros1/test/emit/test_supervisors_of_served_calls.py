"""Calls of the robot through a supervisor: to the controller that is guarded, and its answers back."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

from emit.generated_code import controller_class
from emit.golden_packages import model_path
from runtime.lamp_robot import PlayedPort

from robosc import pipeline
from robosc.runtime.core.calls import Failure
from robosc.runtime.core.settings import Settings
from robosc.runtime.judge.supervising import supervisor_engine
from robosc.runtime.served.waiting_call import WaitingCall

BUSY = "it serves one call at a time"


class GuardedPort(PlayedPort):
    def __init__(self) -> None:
        super().__init__()
        self.blocks: list[tuple[str, list[str]]] = []
        self.there = True
        self.working = True

    def blocked(self, text: str) -> None:
        document = json.loads(text)
        reasons = [reason["text"] for reason in document["blocked_by"]]
        self.blocks.append((document["event"]["kind"], reasons))

    def ready(self, key: str) -> bool:
        return self.there

    def absent(self, key: str) -> str | None:
        return None if self.there else "nobody serves it"

    def works(self, key: str) -> bool:
        return self.working


class Call(WaitingCall):
    def __init__(self) -> None:
        self.told: list[Any] = []

    def report(self, data: Any) -> None:
        self.told.append(("feedback", data))

    def answer(self, data: Any) -> None:
        self.told.append(("response", data))

    def refuse(self, text: str, data: Any = None) -> None:
        self.told.append(("refused", text))


class Bench:
    def __init__(self, model: str, key: str, **settings: Any) -> None:
        self.key = key
        self.port = GuardedPort()
        source = pipeline.synthesize(pipeline.load(model_path(model)).robot)
        self.controller = controller_class(source)[0]()
        self.engine = supervisor_engine(
            self.controller, self.port, Settings(**settings), lambda: self.port.time
        )
        self.engine.begin()

    def call(self, message: Any) -> Call:
        call = Call()
        self.engine.serve(self.key, message, call)
        self.engine.cycle()
        return call

    def report(self, kind: str, payload: Any = None) -> None:
        self.engine.report(self.key, self.port.tokens[self.key], kind, payload)
        self.engine.cycle()

    def hear(self, key: str, data: Any) -> None:
        self.engine.role.follow([key], SimpleNamespace(data=data), lambda: None)
        self.engine.cycle()

    def wait(self, seconds: float) -> None:
        end = self.port.time + seconds
        while (delay := self.engine.time_to_deadline()) is not None:
            if self.port.time + delay > end:
                break
            self.port.time += delay
            self.engine.cycle()
        self.port.time = end

    @property
    def phase(self) -> str:
        (own,) = (c for c in self.controller.COMMUNICATIONS if c.key == self.key)
        return str(self.controller.phase(own))


def orders(**settings: Any) -> Bench:
    return Bench("orders", "Orders.order", **settings)


def missions() -> Bench:
    return Bench("missions", "Missions.mission")


WANTED = SimpleNamespace(data=True)
UNWANTED = SimpleNamespace(data=False)
DONE = SimpleNamespace(success=True, message="done")
GOAL = SimpleNamespace(x=[2.0], y=[0.0])


def test_a_call_goes_to_the_controller_and_its_answer_to_the_robot() -> None:
    bench = orders()
    bench.hear("Door.door", True)
    call = bench.call(WANTED)
    assert bench.port.sent == [("Orders.order", WANTED)]
    assert call.told == [] and bench.phase == "busy"
    bench.report("response", DONE)
    assert call.told == [("response", DONE)] and bench.phase == "idle"


def test_what_no_component_takes_does_not_reach_the_controller() -> None:
    bench = orders()
    first, second = bench.call(WANTED), bench.call(WANTED)
    assert first.told == []
    ((kind, text),) = second.told
    assert kind == "refused" and BUSY in text
    assert len(bench.port.sent) == 1


def test_an_answer_that_is_not_allowed_waits_and_is_told_once() -> None:
    bench = orders()
    call = bench.call(WANTED)
    bench.report("response", DONE)
    assert call.told == []
    ((kind, reasons),) = bench.port.blocks
    assert kind == "response" and "requirement order needs Door.open" in reasons
    bench.hear("Door.door", False)
    assert call.told == []
    bench.hear("Door.door", True)
    assert call.told == [("response", DONE)] and bench.phase == "idle"
    assert len(bench.port.blocks) == 1


def test_an_answer_where_the_model_has_only_an_error_is_an_error() -> None:
    """As a controller of ROS 2 says it, whose services know no errors."""
    bench = orders()
    call = bench.call(UNWANTED)
    bench.report("response", SimpleNamespace(success=False, message="no"))
    ((kind, text),) = call.told
    assert kind == "refused" and "Orders in unwanted" in text
    assert bench.phase == "idle"


def test_an_error_of_the_controller_is_told_at_once() -> None:
    bench = orders()
    call = bench.call(UNWANTED)
    bench.report("error", Failure("no time"))
    assert call.told == [("refused", "no time")] and bench.phase == "idle"
    call = bench.call(WANTED)  # to which the model has no error
    bench.report("error", "no time")
    assert call.told == [("refused", "no time")] and bench.phase == "busy"


def test_an_error_where_the_model_has_none_is_told_and_logged() -> None:
    bench = Bench("orders", "Switch.switch")
    call = bench.call(WANTED)
    bench.report("error", "no time")
    assert call.told == [("refused", "no time")] and bench.phase == "busy"
    assert bench.port.blocks == []
    assert "the model has no 'on error to' for it" in bench.port.logs[-1][1]
    ((_, text),) = bench.call(UNWANTED).told
    assert BUSY in text


def test_a_controller_that_is_not_there_is_told() -> None:
    bench = orders()
    bench.port.there = False
    call = bench.call(UNWANTED)
    bench.wait(6)
    assert call.told == [("refused", "nobody serves it")] and bench.phase == "idle"


def test_a_controller_may_take_its_time() -> None:
    bench = orders()
    bench.hear("Door.door", True)
    call = bench.call(WANTED)
    bench.wait(600)
    assert call.told == []
    bench.report("response", DONE)
    assert call.told == [("response", DONE)]
    call = bench.call(UNWANTED)
    bench.port.working = False
    bench.wait(6)
    assert call.told == [("refused", "no answer in time")]


def test_an_answer_that_is_no_number_is_an_error() -> None:
    bench = missions()
    call = bench.call(GOAL)
    bench.hear("Legs.fault", True)  # where the model has an error
    bench.report("response", SimpleNamespace(reached=float("nan"), message=""))
    ((kind, text),) = call.told
    assert kind == "refused" and "reached is nan" in text


def test_feedback_passes_while_it_is_allowed() -> None:
    bench = missions()
    call = bench.call(GOAL)
    bench.report("accepted")
    near = SimpleNamespace(reached=1, distance=0.5)
    bench.report("feedback", near)
    assert call.told == [("feedback", near)]
    bench.hear("Legs.fault", True)
    bench.report("feedback", near)
    assert len(call.told) == 1
    assert bench.port.blocks[-1] == ("feedback", ["requirement mission needs !Legs.broken"])


def test_a_cancel_goes_on_and_the_goal_ends_as_the_controller_says() -> None:
    bench = missions()
    call = bench.call(GOAL)
    bench.report("accepted")
    bench.engine.recall(bench.key, call)
    bench.engine.cycle()
    assert bench.port.cancelled == [(bench.key, bench.port.tokens[bench.key])]
    assert call.told == [] and bench.phase == "ending"
    bench.report("cancelled", Failure("preempted"))
    assert call.told == [("refused", "preempted")] and bench.phase == "idle"


def test_a_goal_of_a_controller_that_is_lost_fails() -> None:
    bench = missions()
    call = bench.call(GOAL)
    bench.report("accepted")
    bench.hear("Legs.fault", True)
    bench.port.silent = 60.0
    bench.wait(60)
    ((kind, text),) = call.told
    assert kind == "refused" and "server lost" in text and bench.phase == "idle"


def test_at_a_safe_stop_the_robot_is_told_and_the_controller_called_off() -> None:
    bench = missions()
    call = bench.call(GOAL)
    bench.report("accepted")
    bench.engine.stop("test")
    bench.engine.cycle()
    assert call.told == [("refused", "the controller stopped: test")]
    assert len(bench.port.cancelled) == 1
    refused = bench.call(GOAL)
    assert "does not serve now" in refused.told[0][1]


def test_an_answer_while_the_operator_holds_waits_for_the_release() -> None:
    bench = orders(operate=True)
    bench.hear("Door.door", True)
    bench.call(WANTED)
    bench.engine.operate("hold")
    bench.engine.cycle()
    bench.report("response", DONE)
    assert bench.phase == "busy"  # what the robot was told when it was held
    bench.engine.operate("release")
    bench.engine.cycle()
    assert bench.phase == "idle"
