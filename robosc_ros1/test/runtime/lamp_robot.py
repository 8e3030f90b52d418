"""A small controller as the generator would write it, and a port that a test plays.

The robot: a range sensor (clear or blocked), a motor with ``go`` and ``halt``, a lamp (service)
that may always be switched, and an arm (action) that may only run while blocked and mirrors its
phase.
"""

from __future__ import annotations

from typing import Any

from robosc.runtime.core.internal_transitions import Tau
from robosc.runtime.core.model import Command, Communication, Controller, Input, Requirement
from robosc.runtime.core.operations import in_range
from robosc.runtime.core.values import Mismatch
from robosc.runtime.judge.ports import SupervisorPort

SENSOR, GO, HALT, LAMP, ARM = "Sensor.range", "Motor.go", "Motor.halt", "Lamp.light", "Arm.reach"
ARM_FLAGS = ("arm_busy", "arm_cancelling")


class LampController(Controller):
    ROBOT = "LampRobot"
    SOURCE = "lamp.rscd"
    COMMUNICATIONS = (
        Communication(SENSOR, "range", "outgoing"),
        Communication(GO, "go", "incoming"),
        Communication(HALT, "halt", "incoming"),
        Communication(LAMP, "light", "service", ("lamp_busy",), ("idle", "busy")),
        Communication(ARM, "reach", "action", ARM_FLAGS, ("idle", "busy", "cancelling")),
    )
    STEP_BOUND = 3

    def __init__(self) -> None:
        self.undefined = {}
        self.clear = False
        self.speed = 0.0
        self.lamp_busy = False
        self.arm_busy = self.arm_cancelling = False
        self.arm = "idle"
        self.spin = 0
        self.lamp_allowed = True

    def components(self) -> dict[str, str]:
        return {"Arm": self.arm}

    def variables(self) -> dict[str, Any]:
        return {"Sensor.clear": self.clear, "Motor.speed": self.speed}

    def read_range(self, message: Any) -> float:
        return in_range(message, 0, 100, "range")

    def on_range(self, value: float) -> None:
        self.clear = value > 10
        self.speed = value / 10

    def read_light(self, message: Any) -> Any:
        if message == "nonsense":
            raise Mismatch("nonsense")
        return message

    def on_light_end(self, value: Any) -> None:
        self.lamp_busy = False

    def on_reach_end(self, value: Any) -> None:
        self.arm_busy = self.arm_cancelling = False
        self.arm = "idle"

    def on_reach_feedback(self, value: Any) -> None:
        pass

    def needs_clear(self) -> bool:
        return self.clear

    def needs_blocked(self) -> bool:
        return not self.clear

    can_go, can_halt, can_reach = needs_clear, needs_blocked, needs_blocked
    can_cancel = needs_clear

    def can_light(self) -> bool:
        return self.lamp_allowed

    def arm_idle(self) -> bool:
        return self.arm == "idle"

    def data_go(self) -> dict[str, Any]:
        return {"data": self.speed}

    def do_light(self) -> None:
        self.lamp_busy = True

    def do_reach(self) -> None:
        self.arm_busy, self.arm = True, "reaching"

    def on_cancel(self) -> None:
        self.arm_busy, self.arm_cancelling, self.arm = False, True, "stopping"

    def tau_settled(self) -> str | None:
        if self.spin == 0:
            return None
        self.spin -= 1
        return "a->b"

    INPUTS = (
        Input(SENSOR, "response", read_range, on_range, ("clear", "speed")),
        Input(LAMP, "response", read_light, on_light_end, ("lamp_busy",)),
        Input(LAMP, "error", None, on_light_end, ("lamp_busy",)),
        Input(ARM, "response", None, on_reach_end, (*ARM_FLAGS, "arm")),
        Input(ARM, "feedback", None, on_reach_feedback, ()),
        Input(ARM, "error", None, on_reach_end, (*ARM_FLAGS, "arm")),
        Input(ARM, "cancelled", None, on_reach_end, (*ARM_FLAGS, "arm")),
    )
    COMMANDS = (
        Command(GO, "request", can_go, None, data_go, None, ("clear",), (), (0,)),
        Command(HALT, "request", can_halt, None, None, None, ("clear",), (), (1,)),
        Command(
            LAMP, "request", can_light, None, None, do_light, ("lamp_allowed",),
            ("lamp_busy",), (), unless=("lamp_busy",),
        ),
        Command(
            ARM, "request", can_reach, arm_idle, None, do_reach, ("arm", "clear"),
            ("arm_busy", "arm"), (2,), unless=ARM_FLAGS, partners=(("Arm", arm_idle),),
        ),
        Command(
            ARM, "cancel", can_cancel, None, None, on_cancel, ("clear",),
            (*ARM_FLAGS, "arm"), (2,), during=("arm_busy",),
        ),
    )  # fmt: skip
    TAUS = (Tau("Sensor", 1, tau_settled, ("spin",), ("spin",)),)
    REQUIREMENTS = (
        Requirement("go needs clear", "lamp.rscd:1", needs_clear),
        Requirement("halt needs blocked", "lamp.rscd:2", needs_blocked),
        Requirement("reach needs blocked", "lamp.rscd:3", needs_blocked),
    )


class PlayedPort(SupervisorPort):
    """Notes what the engine asks for; time stands still until the test moves it."""

    def __init__(self) -> None:
        self.time = 0.0
        self.sent: list[tuple[str, Any]] = []
        self.tokens: dict[str, int] = {}
        self.cancelled: list[tuple[str, int]] = []
        self.abandoned: list[tuple[str, int]] = []
        self.logs: list[tuple[str, str]] = []
        self.exits: list[int] = []
        self.silent: float | None = None
        self.gone = False
        self.broken: set[str] = set()

    def now(self) -> float:
        return self.time

    def send(self, key: str, data: Any) -> None:
        if key in self.broken:
            raise ValueError("broken")
        self.sent.append((key, data))

    def call(self, key: str, data: Any, token: int) -> None:
        self.send(key, data)
        self.tokens[key] = token

    start = call

    def cancel(self, key: str, token: int) -> None:
        self.cancelled.append((key, token))

    def abandon(self, key: str, token: int) -> None:
        self.abandoned.append((key, token))

    def silence(self, key: str) -> float | None:
        return self.silent

    def lost(self, key: str) -> bool:
        return self.gone

    def log(self, level: str, text: str) -> None:
        self.logs.append((level, text))

    def exit(self, code: int) -> None:
        self.exits.append(code)

    def take(self) -> list[str]:
        """The keys of what was sent since the last call, in order."""
        keys = [key for key, _ in self.sent]
        self.sent.clear()
        return keys
