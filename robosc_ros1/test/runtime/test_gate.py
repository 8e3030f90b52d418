"""What leaves the node is allowed in the moment in which it leaves, whatever the servers do.

An observer on the wire judges all that a port is given, by what the robot has said until then and by
how the node stands, over the product of kinds of requests, servers, what happens meanwhile, and
controllers and supervisors.
"""

from __future__ import annotations

import sys
from typing import Any

import pytest
from runtime.lamp_robot import ARM, GO, HALT, LAMP, SENSOR, LampController
from runtime.test_supervisor_engine import GuardedPort

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.engine import HELD
from robosc.runtime.core.model import Command, Requirement
from robosc.runtime.core.port import NotTaken
from robosc.runtime.core.recorder import Entry
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.values import Undefined
from robosc.runtime.judge.matching import CommandPattern
from robosc.runtime.judge.supervising import supervisor_engine

CLEAR, BLOCKED = 50.0, 5.0
EVENT, APPEARS, TIMEOUT = 1.0, 1.5, 4.0
SERVERS = ["absent", "late", "slow", "refusing", "dying", "foreign"]
UNREADY = ["absent", "late", "foreign"]
EVENTS = ["e-stop", "hold", "safe stop", "deactivate", "signal"]
NAMES = {ARM: "reach", LAMP: "light"}


def aim(robot: LampController) -> dict[str, Any]:
    """What the arm and the lamp are told."""
    return {"speed": robot.speed}


def with_data(row: Command) -> Command:
    if row.key == LAMP:
        row = row._replace(guard=LampController.can_halt, reads=("clear",), requirements=(3,))
    return row._replace(data=aim) if row.key in NAMES and row.kind == "request" else row


class Robot(LampController):
    """The lamp, too, may only be switched while blocked."""

    COMMANDS = tuple(map(with_data, LampController.COMMANDS))
    REQUIREMENTS = (
        *LampController.REQUIREMENTS,
        Requirement("light needs blocked", "lamp.rscd:4", LampController.needs_blocked),
    )


class Wire(GuardedPort):
    """A port whose servers are as ``server`` says, which judges what leaves."""

    def __init__(self, server: str) -> None:
        super().__init__()
        self.server = server
        self.engine: Any = None
        self.left: list[tuple[float, str, Any]] = []
        self.wrong: list[str] = []
        self._is_dying = server == "dying"
        self.connected = 0.0
        """When a connection to the lamp will have been made."""

    def connects(self, key: str) -> bool:
        return key == LAMP and self.connected > 0.0

    def ready(self, key: str) -> bool:
        if key == LAMP and self.time < self.connected:
            return False
        return self.server not in UNREADY or (self.server != "absent" and self.time >= APPEARS)

    def send(self, key: str, data: Any) -> None:
        engine = self.engine
        if not key == HALT == engine.settings.stop_command:
            if engine.stopped is not None or engine.closing:
                self.wrong.append(f"{self.time}: {key} while {engine.stopped or 'closing'}")
            if engine.controller.clear is not (key == GO):
                self.wrong.append(f"{self.time}: {key} while clear is {engine.controller.clear}")
        self.left.append((self.time, key, data))

    def call(self, key: str, data: Any, token: int) -> None:
        if self._is_dying:
            self._is_dying = False
            raise NotTaken
        self.send(key, data)
        self.tokens[key] = token
        if self.server in ("refusing", "dying"):
            self.engine.report(key, token, "error", self.server)

    start = call

    def times(self, key: str) -> list[float]:
        return [time for time, sent, _ in self.left if sent == key]


class Rig:
    """A controller, or a supervisor with a controller that asks for everything, on such a port."""

    def __init__(self, mode: str, server: str, key: str, **settings: Any) -> None:
        self.key = key
        self.port = Wire(server)
        self.robot = Robot()
        self.robot.clear = True
        made = Settings(timeout={ARM: TIMEOUT, LAMP: TIMEOUT}, **settings)
        self._guards = mode == "supervisor"
        engine = supervisor_engine if self._guards else controller_engine
        self.engine: Any = engine(self.robot, self.port, made, lambda: self.port.time)
        self.port.engine = self.engine
        self.answers: list[str] = []
        self.entries: list[Entry] = []
        self.engine.begin()
        self.engine.cycle()
        self.see(BLOCKED)
        if self._guards:
            self.engine.role.request(
                key, None, {"speed": 0.5}, lambda kind, _: self.answers.append(kind)
            )
            self.engine.cycle()

    def see(self, value: float) -> None:
        if self._guards:
            self.engine.role.follow([SENSOR], value, lambda: None)
        else:
            self.engine.post(SENSOR, "response", value)
        self.engine.cycle()

    def happens(self, event: str) -> None:
        if event == "e-stop":
            self.see(CLEAR)
            return
        {
            "hold": lambda: self.engine.operate("hold"),
            "safe stop": lambda: self.engine.stop("enough"),
            "deactivate": self.engine.suspend,
            "signal": self.engine.close,
        }[event]()
        self.engine.cycle()

    def wait_until(self, time: float) -> None:
        while self.port.time < time:
            left = self.engine.time_to_deadline()
            step = time - self.port.time if left is None else max(0.001, left)
            self.port.time = min(time, self.port.time + step)
            self.engine.cycle()
        self.entries += self.engine.recorder.take()

    def ends(self) -> list[tuple[str, str | None]]:
        """How the requests ended, with what the model calls the reason."""
        self.entries += self.engine.recorder.take()
        own = [e for e in self.entries if e.name == NAMES[self.key] and e.outcome == "applied"]
        return [(e.kind, e.reason) for e in own if e.kind in ("response", "error", "cancelled")]


@pytest.mark.parametrize("mode", ["controller", "supervisor"])
@pytest.mark.parametrize("event", EVENTS)
@pytest.mark.parametrize("server", SERVERS)
@pytest.mark.parametrize("key", [ARM, LAMP])
def test_nothing_leaves_that_is_not_allowed(key: str, server: str, event: str, mode: str) -> None:
    rig = Rig(mode, server, key, stop_command=HALT)
    rig.wait_until(EVENT)
    was_open = rig.key in rig.engine.parts.calls.open
    assert was_open == (server in UNREADY)
    rig.happens(event)
    if was_open and event != "e-stop":
        rig.engine.cycle()
        assert rig.ends() == [("error", "absent")], "what waits ends at once"
    rig.wait_until(8.0)
    assert rig.port.wrong == []
    assert not rig.engine.parts.calls.open
    if was_open:
        assert rig.port.times(key) == []
        is_cancelled = (event, key) == ("e-stop", ARM)
        assert rig.ends() == [("cancelled", None) if is_cancelled else ("error", "absent")]
        assert rig.port.cancelled == []
    elif server == "slow" and key == ARM:
        assert set(rig.port.cancelled) == {(ARM, rig.port.tokens[ARM])}, "it must not go on"


@pytest.mark.parametrize("mode", ["controller", "supervisor"])
@pytest.mark.parametrize("key", [ARM, LAMP])
def test_what_is_allowed_when_a_server_appears_is_sent_once(key: str, mode: str) -> None:
    rig = Rig(mode, "late", key, rate=0.1)
    rig.wait_until(2.0)
    (time,) = rig.port.times(key)
    assert APPEARS <= time <= APPEARS + 0.021
    rig.engine.report(key, rig.port.tokens[key], "response", None)
    rig.wait_until(2.1)
    assert rig.ends() == [("response", None)]


def test_a_forbidden_request_that_is_allowed_again_is_sent() -> None:
    rig = Rig("controller", "late", LAMP, rate=0.1)
    rig.wait_until(0.5)
    rig.see(CLEAR)
    rig.wait_until(1.0)
    rig.see(BLOCKED)
    rig.wait_until(2.0)
    assert len(rig.port.times(LAMP)) == 1


def test_data_are_those_of_the_moment() -> None:
    rig = Rig("controller", "late", LAMP, rate=0.1)
    rig.see(3.0)
    rig.wait_until(2.0)
    assert [data for _, key, data in rig.port.left if key == LAMP] == [{"speed": 0.3}]


@pytest.mark.parametrize("lack", ["nan", "undefined"])
def test_a_request_whose_data_are_lost_meanwhile_is_not_sent(lack: str) -> None:
    rig = Rig("controller", "late", LAMP, rate=0.1)

    def aim() -> dict[str, Any]:
        if lack == "undefined":
            raise Undefined
        return {"speed": float("nan")}

    rig.engine.parts.commands[LAMP, "request"].data = aim
    rig.wait_until(2.0)
    assert (rig.port.times(LAMP), rig.ends()) == ([], [("error", "absent")])


@pytest.mark.parametrize("mode", ["controller", "supervisor"])
def test_what_an_operator_lets_through_is_cancelled_where_it_is_forbidden(mode: str) -> None:
    """Held, one step, and then the e-stop: a node that stands still cancels what runs."""
    rig = Rig(mode, "slow", ARM, stop_command=HALT)
    rig.engine.report(ARM, rig.port.tokens[ARM], "error", "over")
    rig.engine.cycle()
    rig.happens("hold")
    for _ in range(3):  # the lamp and the stop command are commands, too
        rig.engine.operate("step")
        if mode == "supervisor":
            rig.engine.role.request(ARM, None, {"speed": 0.5}, lambda *_: None)
        rig.engine.cycle()
    token = rig.port.tokens[ARM]
    assert rig.robot.arm_busy and rig.engine.stopped == HELD
    rig.see(CLEAR)
    assert rig.port.cancelled == [(ARM, token)]
    assert rig.robot.arm_cancelling, "it is shown"
    rig.engine.operate("release")
    rig.engine.cycle()
    assert rig.port.cancelled == [(ARM, token)]


@pytest.mark.parametrize("mode", ["controller", "supervisor"])
@pytest.mark.parametrize(("seconds", "end"), [(0.4, None), (1.4, "absent"), (0.4, "held again")])
def test_what_an_operator_lets_through_waits_a_second_for_a_connection(
    seconds: float, end: str | None, mode: str
) -> None:
    """A service of ROS 1 is connected to when it is to be called."""
    rig = Rig(mode, "slow", LAMP, stop_command=HALT)
    rig.engine.report(LAMP, rig.port.tokens[LAMP], "response", None)
    rig.happens("hold")
    rig.port.left, rig.port.connected = [], rig.port.time + seconds
    while not rig.engine.parts.calls.open:
        rig.engine.operate("step")
        if mode == "supervisor":
            rig.engine.role.request(LAMP, None, {"speed": 0.5}, lambda *_: None)
        rig.engine.cycle()
    if end == "held again":
        rig.happens("hold")
    rig.wait_until(rig.port.time + 2.0)
    assert len(rig.port.times(LAMP)) == (end is None)
    assert (rig.ends()[-1] == ("error", "absent")) is (end is not None)


def test_what_was_let_through_is_cancelled_when_the_node_ends() -> None:
    rig = Rig("supervisor", "slow", ARM, stop_command=HALT)
    rig.engine.operate("hold")
    rig.engine.operate("release")
    rig.engine.cycle()
    assert rig.port.cancelled == [(ARM, rig.port.tokens[ARM])]


@pytest.mark.parametrize("server", ["late", "absent"])
def test_a_stop_service_that_is_absent_is_called_only_while_the_node_stands(server: str) -> None:
    """The stop command may be a service: it is sent when its server appears, unless the operator
    has released the robot by then."""
    for released in (False, True):
        rig = Rig("controller", server, ARM, stop_command=LAMP, rate=0.01)
        rig.port.server = "slow"
        rig.engine.report(LAMP, rig.engine.parts.calls._calls[LAMP].token, "response", None)
        rig.engine.cycle()
        rig.port.server, rig.port.left = server, []
        rig.engine.operate("hold")
        rig.engine.cycle()
        rig.wait_until(1.2)
        if released:
            rig.see(CLEAR)
            rig.engine.operate("release")
            rig.engine.cycle()
        rig.wait_until(6.0)
        times = rig.port.times(LAMP)
        assert len(times) == (server == "late" and not released)


@pytest.mark.parametrize("mode", ["controller", "supervisor"])
@pytest.mark.parametrize("event", ["hold", "safe stop", "signal"])
def test_a_stop_service_that_waits_for_its_server_already_becomes_the_stop_command(
    event: str, mode: str
) -> None:
    """That the requirements forbid it then holds back nothing: it is to stop the robot."""
    rig = Rig(mode, "late", LAMP, stop_command=LAMP, rate=0.1)
    rig.wait_until(EVENT)
    assert rig.engine.parts.calls.open
    rig.see(CLEAR)
    rig.happens(event)
    assert rig.ends() == []
    rig.port.engine = Rig("controller", "slow", LAMP, stop_command=HALT).engine  # not judged
    rig.wait_until(2.0)
    assert len(rig.port.times(LAMP)) == 1


def test_a_supervisor_that_ends_passes_nothing_on() -> None:
    """Its stop command may have been sent, or waits for its server."""
    rig = Rig("supervisor", "slow", LAMP, stop_command=HALT)
    rig.engine.close()
    answers: list[str] = []
    rig.engine.role.request(ARM, None, {"speed": 0.5}, lambda kind, _: answers.append(kind))
    rig.engine.role.offer("/drive", [CommandPattern(HALT)], 0, 0)
    rig.engine.cycle()
    assert answers == ["blocked"]
    assert rig.port.times(ARM) == [] and len(rig.port.times(HALT)) == 1
    assert rig.port.wrong == []


@pytest.mark.parametrize("key", [ARM, LAMP])
def test_whose_request_waits_is_told_when_the_supervisor_ends(key: str) -> None:
    rig = Rig("supervisor", "absent", key)
    rig.engine.close()
    rig.engine.run()
    assert rig.answers == ["passed", "error"]
    assert rig.ends() == [("error", "absent")]


class Replacing(Robot):
    """A goal of the arm may replace one that goes on."""

    COMMUNICATIONS = tuple(
        row._replace(goals="replace") if row.key == ARM else row for row in Robot.COMMUNICATIONS
    )
    COMMANDS = tuple(
        row._replace(unless=("arm_cancelling",), synchronisation=None)
        if (row.key, row.kind) == (ARM, "request")
        else row
        for row in Robot.COMMANDS
    )


def test_a_goal_that_is_replaced_before_it_was_sent_ends_for_the_controller(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys.modules[__name__], "Robot", Replacing)
    rig = Rig("supervisor", "late", ARM)
    second: list[str] = []
    rig.engine.role.request(ARM, None, {"speed": 0.7}, lambda kind, _: second.append(kind))
    rig.engine.cycle()
    assert (rig.answers, second) == (["passed", "cancelled"], ["passed"])
    rig.wait_until(2.0)
    assert [data for _, key, data in rig.port.left if key == ARM] == [{"speed": 0.7}]


class Narrow(GuardedPort):
    """A port whose messages have a field of one byte."""

    def check(self, key: str, kind: str, data: Any) -> None:
        if data and data["data"] > 255:
            raise OverflowError("it does not fit")

    def send(self, key: str, data: Any) -> None:
        self.check(key, "request", data)
        super().send(key, data)


SPEEDS = {"nan": float("nan"), "undefined": None, "too large": 300.0}


@pytest.mark.parametrize("lack", SPEEDS)
def test_what_cannot_be_sent_holds_nothing_back(lack: str) -> None:
    """A preferred command that cannot be sent is counted as failed on its beat; what it is
    preferred to is sent, until it can be sent again."""

    def data(robot: LampController) -> dict[str, Any]:
        speed = SPEEDS[lack] if robot.spin else 0.5
        if speed is None:
            raise Undefined
        return {"data": speed}

    class Preferring(LampController):
        """Going is preferred to halting, which is always allowed."""

        COMMANDS = (
            LampController.COMMANDS[0]._replace(data=data),
            LampController.COMMANDS[1]._replace(
                guard=lambda _: True, reads=(), requirements=(), yields_to=(0,)
            ),
        )
        TAUS = ()

    robot, port = Preferring(), Narrow()
    engine = controller_engine(robot, port, Settings(rate=10.0), lambda: port.time)
    engine.begin()
    for spin, expected in ((0, {GO}), (1, {HALT}), (0, {GO})):
        robot.spin = spin
        engine.post(SENSOR, "response", CLEAR)
        engine.cycle()
        port.take()
        for _ in range(5):
            port.time += 0.1
            engine.cycle()
        assert set(port.take()) == expected
    assert engine.recorder.counters["failed"] >= 4
