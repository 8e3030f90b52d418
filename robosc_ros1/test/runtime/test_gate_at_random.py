"""What leaves the node is allowed in the moment in which it leaves, in any order of what happens.

Sensors, servers that come and go, ends of requests, an operator, a lifecycle manager, a safe stop and the
end of the node, in random order; the port judges each command by what the robot has said until then.
"""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from runtime.lamp_robot import ARM, GO, HALT, LAMP, SENSOR
from runtime.test_gate import BLOCKED, CLEAR, Replacing, Robot
from runtime.test_supervisor_engine import GO_ONLY, GuardedPort

from robosc.runtime.core.calls import Failure
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.port import NotTaken
from robosc.runtime.core.settings import Settings
from robosc.runtime.judge.supervising import supervisor_engine

ORDERS = ("hold", "release", "step", "suspend", "resume")
KEYS = (ARM, LAMP)
TIMEOUT = 4.0


class Judge(GuardedPort):
    """A port that says what is wrong. It knows the robot and who stopped the node, not the engine."""

    def __init__(self, replaces: bool) -> None:
        super().__init__()
        self.replaces = replaces
        self.up = dict.fromkeys(KEYS, True)
        self.refuses = dict.fromkeys(KEYS, False)
        self.running: dict[int, str] = {}
        """The requests that servers carry out, by token."""
        self.was_cancelled: set[int] = set()
        self.let_through: set[int] = set()
        self.begun: dict[int, float] = {}
        self.accepted: set[int] = set()
        self.newest = 0
        """The latest goal that was accepted or has ended: those before it are to end."""
        self.clear = True
        self.holds = 0
        self.is_active = True
        self.is_over = False
        self.credit = 0
        self.wrong: list[str] = []

    @property
    def stands(self) -> bool:
        return self.is_over or self.holds > 0 or not self.is_active

    def judge(self, key: str) -> None:
        if self.stands and key != HALT:  # the stop command
            if not self.credit:
                self.wrong.append(f"{key} while the node stands still")
            self.credit = 0
        if self.clear is not (key == GO) and not (self.stands and key == HALT):
            self.wrong.append(f"{key} while clear is {self.clear}")

    def ready(self, key: str) -> bool:
        """As those of ROS, it knows of a goal that goes on though the engine has given it up."""
        going_on = [t for t, k in self.running.items() if k == key]
        return self.up[key] and self.was_cancelled.isdisjoint(going_on)

    def send(self, key: str, data: Any) -> None:
        self.judge(key)

    def call(self, key: str, data: Any, token: int) -> None:
        if not self.ready(key) or self.refuses[key]:
            raise NotTaken
        if key in self.running.values() and not self.replaces:
            self.wrong.append(f"{key} beside one that goes on")
        if self.stands:
            self.let_through.add(token)
        self.judge(key)
        self.running[token] = key
        self.begun[token] = self.time

    start = call

    def cancel(self, key: str, token: int) -> None:
        self.was_cancelled.add(token)

    def abandon(self, key: str, token: int) -> None:
        self.was_cancelled.add(token)
        if key == LAMP:
            self.running.pop(token, None)  # its answer is not waited for

    def unended(self) -> bool:
        """Whether a goal goes on that should have been cancelled."""
        goals = {token for token, key in self.running.items() if key == ARM} - self.was_cancelled
        # With one that is to replace it, another time counts.
        late = not self.replaces and any(
            self.time - self.begun[token] > TIMEOUT + 0.001 for token in goals - self.accepted
        )
        replaced = any(token < self.newest for token in goals)
        stands = self.stands and not goals <= self.let_through
        return late or replaced or stands or (bool(goals) and self.clear)


class Stage:
    """An engine on such a port, and everything that may happen to it."""

    def __init__(self, mode: str, robot: Robot) -> None:
        self.port = Judge(isinstance(robot, Replacing))
        self.guards = mode == "supervisor"
        made = Settings(timeout=dict.fromkeys(KEYS, TIMEOUT), stop_command=HALT, rate=2.0)
        engine = supervisor_engine if self.guards else controller_engine
        robot.clear = True
        self.engine: Any = engine(robot, self.port, made, lambda: self.port.time)
        self.engine.begin()
        self.cycle()

    def cycle(self) -> None:
        self.engine.cycle()
        assert self.port.wrong == []
        assert not self.port.unended()

    def happens(self, what: str, key: str, time: float) -> None:
        getattr(self, what.replace(" ", "_"))(key)
        self.cycle()
        self.port.time += time
        self.cycle()

    def see(self, value: float) -> None:
        if self.guards:
            self.engine.role.follow([SENSOR], value, lambda: None)
        else:
            self.engine.post(SENSOR, "response", value)
        self.port.clear = value == CLEAR

    def clear(self, _: str) -> None:
        self.see(CLEAR)

    def block(self, _: str) -> None:
        self.see(BLOCKED)

    def want(self, key: str) -> None:
        """The controller that is guarded asks for something."""
        if self.guards:
            self.engine.role.request(key, None, {"speed": 0.5}, lambda *_: None)
            self.engine.role.offer("/drive", GO_ONLY, 1.0, 1.0)

    def hold(self, _: str) -> None:
        self.engine.operate("hold")
        if not self.port.is_over:
            self.port.holds += 1
            self.port.credit = 0
            if self.port.is_active:
                self.port.let_through.clear()

    def release(self, _: str) -> None:
        self.engine.operate("release")
        if not self.port.is_over and self.port.holds:
            self.port.holds -= 1
        if not self.port.stands:
            self.port.credit = 0

    def step(self, _: str) -> None:
        if self.port.holds and self.port.is_active and not self.port.is_over:
            self.port.credit = 1
        self.engine.operate("step")
        if not self.guards:
            self.engine.cycle()
            self.port.credit = 0

    def suspend(self, _: str) -> None:
        self.engine.suspend()
        if not self.port.is_over:
            self.port.is_active = False
            self.port.credit = 0
            self.port.let_through.clear()

    def resume(self, _: str) -> None:
        self.engine.resume()
        if not self.port.is_over:
            self.port.is_active = True

    def stop(self, _: str) -> None:
        self.engine.stop("enough")
        self.port.is_over, self.port.credit = True, 0
        self.port.let_through.clear()

    def close(self, _: str) -> None:
        self.engine.close()
        self.port.is_over, self.port.credit = True, 0
        self.port.let_through.clear()

    def come(self, key: str) -> None:
        self.port.up[key], self.port.refuses[key] = True, False

    def go(self, key: str) -> None:
        self.port.up[key] = False

    def refuse(self, key: str) -> None:
        self.port.refuses[key] = True

    def finish(self, key: str) -> None:
        self._end(key, "response", None)

    def fail(self, key: str) -> None:
        self._end(key, "error", Failure("it failed"))

    def _end(self, key: str, kind: str, payload: Any) -> None:
        token = self.latest(key)
        if token is not None:
            del self.port.running[token]
            self.engine.report(key, token, kind, payload)
            if key == ARM:
                self.port.newest = max(self.port.newest, token)

    def accept(self, key: str) -> None:
        token = self.latest(key)
        if token is not None:
            self.engine.report(key, token, "accepted")
            if key == ARM:
                self.port.accepted.add(token)
                self.port.newest = max(self.port.newest, token)

    def latest(self, key: str) -> int | None:
        return max((token for token, k in self.port.running.items() if k == key), default=None)

    def finish_first(self, key: str) -> None:
        """The end of the oldest goal, which may have been replaced."""
        token = min((token for token, k in self.port.running.items() if k == key), default=None)
        if token is not None:
            del self.port.running[token]
            self.engine.report(key, token, "response", None)


ROBOT = ["clear", "block", "come", "go", "want", "accept"]
ENDS = ["finish", "fail", "finish first", "refuse"]
HAPPENING = st.tuples(
    st.sampled_from([*ROBOT * 3, *ENDS, *ORDERS, "step"]),
    st.sampled_from(KEYS),
    st.sampled_from([0.0, 0.1, 0.6, 5.0]),
)


def at_once(*happenings: str, key: str = ARM) -> list[tuple[str, str, float]]:
    return [(what, key, 0.0) for what in happenings]


LET_THROUGH = [
    ("block", ARM, 5.0),
    ("block", ARM, 5.0),
    *at_once("want", "hold", "step", "want", "finish"),
]
"""What was let through while the server carried out a cancelled goal; then that ends."""
PRESSED = [
    *at_once("block", "finish", "hold"), *at_once("finish", key=LAMP),
    *at_once("step", "want", "step", "want", "step", "want", "clear"),
]  # fmt: skip
"""Goals that were let through, and then the e-stop."""
REPLACED = at_once("block", "want", "accept", "want", "accept", "want", "fail")


@pytest.mark.parametrize("robot", [Robot, Replacing])
@pytest.mark.parametrize("mode", ["controller", "supervisor"])
@settings(max_examples=300, derandomize=True, deadline=None)
@given(
    happenings=st.lists(HAPPENING, min_size=20, max_size=80), end=st.sampled_from(["stop", "close"])
)
@example(happenings=LET_THROUGH, end="stop")
@example(happenings=PRESSED, end="stop")
@example(happenings=REPLACED, end="close")
def test_nothing_leaves_that_is_not_allowed(
    mode: str, robot: type[Robot], happenings: list[tuple[str, str, float]], end: str
) -> None:
    stage = Stage(mode, robot())
    for what, key, time in happenings:
        stage.happens(what, key, time)
    stage.happens(end, ARM, 0.1)
    for key in KEYS:
        stage.happens("come", key, 1.0)
