"""The guard: what another controller does passes or is blocked, and the state follows both sides."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest
from runtime.lamp_robot import ARM, GO, HALT, LAMP, SENSOR, LampController, PlayedPort
from runtime.schemas import validate

from robosc.runtime.core.inbox import LIMIT
from robosc.runtime.core.model import Command, Requirement
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.telemetry import event_document, state_document
from robosc.runtime.core.values import Undefined
from robosc.runtime.judge.matching import CommandPattern
from robosc.runtime.judge.supervising import supervisor_engine

GO_ONLY = (CommandPattern(GO),)
DRIVE = (CommandPattern(HALT, lambda message: message == 0), CommandPattern(GO))


class GuardedPort(PlayedPort):
    def __init__(self) -> None:
        super().__init__()
        self.blocks: list[tuple[str, str, list[str]]] = []
        self.documents: list[dict[str, Any]] = []

    def blocked(self, text: str) -> None:
        document = json.loads(text)
        validate(document, "blocked")
        self.documents.append(document)
        reasons = [reason["text"] for reason in document["blocked_by"]]
        self.blocks.append((document["event"]["name"], document["event"]["kind"], reasons))

    def corrected(self, message: Any, data: dict[str, Any]) -> Any:
        made = copy.copy(message)
        for name, value in data.items():
            setattr(made, name, value)
        return made


class Bench:
    """A guard whose inputs are played one by one."""

    def __init__(self, controller: LampController | None = None, **settings: Any) -> None:
        self.port = GuardedPort()
        self.controller = controller or LampController()
        self.forwarded: list[Any] = []
        self.answers: list[tuple[str, Any]] = []
        self.time = 0.0
        settings = Settings(**settings)
        self.guard = supervisor_engine(self.controller, self.port, settings, lambda: self.time)
        self.guard.begin()

    def sense(self, distance: Any) -> None:
        self.guard.role.follow([SENSOR], distance, lambda: self.forwarded.append(distance))
        self.guard.cycle()

    def offer(self, payload: Any, choices: Any = GO_ONLY) -> list[tuple[str, Any]]:
        self.guard.role.offer("/drive", choices, payload, payload)
        self.guard.cycle()
        sent, self.port.sent = self.port.sent, []
        return sent

    def request(self, key: str, payload: Any = None) -> None:
        answer = lambda kind, what: self.answers.append((kind, what))  # noqa: E731
        self.guard.role.request(key, payload, payload, answer)
        self.guard.cycle()

    def report(self, key: str, kind: str, what: Any = None) -> None:
        self.guard.report(key, self.port.tokens[key], kind, what)
        self.guard.cycle()


def test_what_is_allowed_passes_untouched() -> None:
    bench = Bench()
    bench.sense(50)
    payload = b"as it came"
    assert bench.offer(payload) == [(GO, payload)]
    assert bench.port.blocks == []


def test_what_is_forbidden_is_blocked_with_the_requirements() -> None:
    bench = Bench()
    assert bench.offer(b"x") == []
    assert bench.port.blocks == [("go", "request", ["go needs clear"])]


def test_inputs_update_the_state_and_are_forwarded() -> None:
    bench = Bench()
    bench.sense(50)
    assert bench.controller.clear
    bench.sense("nonsense")
    assert bench.forwarded == [50, "nonsense"]
    assert bench.guard.recorder.counters["mismatches"] == 1


def test_nothing_is_sent_unasked() -> None:
    bench = Bench()
    bench.sense(50)
    bench.port.time = 100.0
    bench.guard.cycle()
    assert bench.port.sent == []
    assert bench.guard.time_to_deadline() is None


def test_messages_of_one_topic_are_told_apart() -> None:
    bench = Bench()
    assert bench.offer(0, DRIVE) == [(HALT, 0)]
    assert bench.offer(3, DRIVE) == []
    bench.sense(50)
    assert bench.offer(3, DRIVE) == [(GO, 3)]
    assert bench.offer(0, DRIVE) == []


def test_a_flood_of_the_controller_is_bounded_and_its_latest_message_passes() -> None:
    bench = Bench()
    bench.sense(50)
    for number in range(3 * LIMIT):
        bench.guard.role.offer("/drive", GO_ONLY, number, number)
    assert bench.guard.snapshot()["backlog"] == LIMIT
    while bench.guard.snapshot()["backlog"]:
        bench.guard.cycle()
    assert bench.port.sent == [(GO, number) for number in [*range(LIMIT), 3 * LIMIT - 1]]
    assert bench.guard.snapshot()["counters"]["dropped"] == 2 * LIMIT - 1


@pytest.mark.parametrize("requirements", [(), (1,)])
def test_a_preference_neither_blocks_nor_lets_pass(requirements: tuple[int, ...]) -> None:
    """While ``go`` is enabled, ``halt`` is blocked if a requirement forbids it, and only then."""

    class Preferring(LampController):
        COMMANDS = (
            LampController.COMMANDS[0],
            Command(
                HALT, "request", lambda _: True, None, None, None, (), (), requirements,
                yields_to=(0,),
            ),
        )  # fmt: skip

    bench = Bench(Preferring())
    bench.sense(50)
    assert bench.offer(0, DRIVE) == ([] if requirements else [(HALT, 0)])
    state = state_document(bench.guard.snapshot(), [])
    assert all(command["waits_for"] == [] for command in state["commands"])


def test_a_message_that_means_nothing_is_blocked() -> None:
    bench = Bench()
    bench.sense(50)
    assert bench.offer(7, (CommandPattern(GO, lambda message: message == 1),)) == []
    assert bench.port.blocks == [("", "request", ["its data match none of go"])]


class Speed:
    """A message as both versions of ROS make them."""

    __slots__ = ("label", "parts", "x")

    def __init__(self, x: float = 0.0, parts: Any = ()) -> None:
        self.label, self.x, self.parts = "nan", x, parts


NAN = float("nan")


@pytest.mark.parametrize(
    ("message", "told"),
    [
        (Speed(NAN), "x is nan"),
        (Speed(0.0, [0.0, -float("inf")]), "parts[1] is -inf"),
        (Speed(0.0, [Speed(0.0), Speed(1.0, (NAN,))]), "parts[1].parts[0] is nan"),
        (Speed(1.0, [Speed(0.0)]), None),
        (Speed(1.0, b"any"), None),
        (Speed(1.0, [1, 2]), None),
    ],
)
def test_numbers_that_are_not_finite_never_reach_the_robot(
    message: Speed, told: str | None
) -> None:
    bench = Bench()
    bench.sense(50)
    passed = [] if told else [(GO, message)]
    assert bench.offer(message) == passed
    bench.request(LAMP, message)
    assert [kind for kind, _ in bench.answers] == ["blocked" if told else "passed"]
    reports = [("go", "request", [told]), ("light", "request", [told])]
    assert bench.port.blocks == (reports if told else [])
    assert bench.guard.recorder.counters["blocked"] == len(bench.port.blocks)
    careless = Bench(refuse_not_finite=False)
    careless.sense(50)
    assert careless.offer(message) == [(GO, message)]


def test_a_service_call_is_passed_on_and_answered() -> None:
    bench = Bench()
    bench.request(LAMP, "on")
    assert bench.port.sent == [(LAMP, "on")]
    assert bench.controller.lamp_busy
    bench.report(LAMP, "response", "done")
    assert bench.answers == [("passed", None), ("response", "done")]
    assert not bench.controller.lamp_busy


def test_a_blocked_call_is_answered_at_once() -> None:
    bench = Bench()
    bench.controller.lamp_allowed = False
    bench.request(LAMP)
    assert [kind for kind, _ in bench.answers] == ["blocked"]
    assert bench.port.sent == []


def test_a_second_call_is_blocked_while_the_first_is_under_way() -> None:
    bench = Bench()
    bench.request(LAMP)
    bench.request(LAMP)
    assert [kind for kind, _ in bench.answers] == ["passed", "blocked"]
    assert bench.port.blocks == [("light", "request", ["it is busy"])]


def test_a_call_that_the_robot_does_not_answer_ends_as_an_error() -> None:
    bench = Bench()
    bench.request(LAMP)
    assert bench.guard.time_to_deadline() == 5.0
    bench.time = 5.0
    bench.guard.cycle()
    assert bench.answers[-1] == ("error", "no answer in time")
    assert not bench.controller.lamp_busy


def test_a_call_that_cannot_be_sent_is_answered() -> None:
    bench = Bench()
    bench.port.broken.add(LAMP)
    bench.request(LAMP)
    bench.guard.cycle()
    assert [kind for kind, _ in bench.answers] == ["passed", "error"]
    assert not bench.controller.lamp_busy


def test_the_controller_cancels_where_the_model_has_it() -> None:
    bench = Bench()
    bench.request(ARM)
    bench.sense(50)
    bench.guard.role.withdraw(ARM)
    bench.guard.cycle()
    assert bench.port.cancelled == [(ARM, 1)]
    assert not bench.controller.arm_busy


def test_any_other_cancel_goes_on_to_the_robot_and_ends_there() -> None:
    bench = Bench()
    bench.request(ARM)
    bench.guard.role.withdraw(ARM)
    bench.guard.cycle()
    assert bench.port.cancelled == [(ARM, 1)]
    assert bench.controller.arm_busy
    bench.report(ARM, "error", "cancelled")
    assert not bench.controller.arm_busy


def test_a_message_in_effect_is_stopped_when_it_becomes_forbidden() -> None:
    bench = Bench(stop_command=HALT)
    bench.sense(50)
    bench.offer(3, DRIVE)
    bench.sense(2)
    assert bench.port.take() == [HALT]
    bench.sense(1)
    assert bench.port.take() == []


def test_what_the_stop_command_has_in_effect_is_stopped_too() -> None:
    """One command for all speeds: the stop is the message of zeros."""
    bench = Bench(stop_command=GO)
    bench.sense(50)
    assert bench.offer(3) == [(GO, 3)]
    bench.sense(2)
    assert bench.port.take() == [GO]
    bench.sense(1)
    assert bench.port.take() == []


def test_a_goal_is_cancelled_when_it_becomes_forbidden() -> None:
    bench = Bench(stop_command=HALT)
    bench.request(ARM)
    bench.sense(50)
    assert bench.port.cancelled == [(ARM, 1)]


def test_a_goal_that_becomes_forbidden_is_cancelled_after_a_pause_too() -> None:
    bench = Bench(stop_command=HALT)
    bench.request(ARM)
    bench.guard.pauses.holds = True  # as while the messages are applied that waited
    bench.sense(50)
    assert bench.port.cancelled == [(ARM, 1)]


@pytest.mark.parametrize("distance", [50, 2])
def test_nothing_is_stopped_unless_a_stop_command_is_set(distance: int) -> None:
    bench = Bench()
    bench.sense(50)
    bench.offer(3, DRIVE)
    bench.sense(distance)
    assert bench.port.sent == []


def test_after_a_safe_stop_everything_is_blocked() -> None:
    bench = Bench()
    bench.sense(50)
    bench.guard.stop("enough")
    bench.guard.cycle()
    assert bench.offer(3) == []
    assert bench.port.blocks == [("go", "request", ["safe stop: enough"])]


class OnceController(LampController):
    """Going forbids to go again; that is no reason to stop it."""

    def __init__(self) -> None:
        super().__init__()
        self.goes = False

    def is_standing(self) -> bool:
        return not self.goes

    def can_go_once(self) -> bool:
        return self.clear and not self.goes

    def do_go(self) -> None:
        self.goes = True

    COMMANDS = (
        Command(
            GO, "request", can_go_once, None, None, do_go, ("clear", "goes"), ("goes",), (0, 3)
        ),
        *LampController.COMMANDS[1:],
    )  # fmt: skip
    REQUIREMENTS = (
        *LampController.REQUIREMENTS,
        Requirement("go needs standing", "lamp.rscd:4", is_standing),
    )


class JoinedController(OnceController):
    """The same in one requirement: ``go needs clear and standing``."""

    REQUIREMENTS = (
        Requirement("go needs clear and standing", "lamp.rscd:1", OnceController.can_go_once),
        *OnceController.REQUIREMENTS[1:],
    )


@pytest.mark.parametrize("spelling", [OnceController, JoinedController])
def test_what_a_command_forbids_by_itself_does_not_end_it(spelling: type[OnceController]) -> None:
    bench = Bench(spelling(), stop_command=HALT)
    bench.sense(50)
    assert bench.offer(3, DRIVE) == [(GO, 3)]
    bench.sense(60)
    assert bench.port.take() == []
    assert bench.offer(3, DRIVE) == []
    bench.sense(2)
    assert bench.port.take() == [HALT]


@pytest.mark.parametrize("spelling", [OnceController, JoinedController])
def test_what_others_change_back_is_no_effect_of_the_command(
    spelling: type[OnceController],
) -> None:
    controller = spelling()
    bench = Bench(controller, stop_command=HALT)
    bench.sense(50)
    assert bench.offer(3, DRIVE) == [(GO, 3)]
    controller.goes = False  # as an event of the robot does it
    bench.sense(60)
    controller.goes = True
    bench.sense(70)
    assert bench.port.take() == [HALT]


def test_a_stop_of_the_controller_is_not_stopped_again() -> None:
    bench = Bench(stop_command=HALT)
    assert bench.offer(0, DRIVE) == [(HALT, 0)]
    bench.sense(50)
    assert bench.port.take() == []


class ShortController(LampController):
    """A guard that leaves out a requirement, because it follows in all states of the system."""

    def can_go(self) -> bool:
        return True


def test_requirements_hold_also_where_guards_mean_nothing() -> None:
    bench = Bench(ShortController(), stop_command=HALT)
    assert bench.offer(3, DRIVE) == []
    assert bench.port.blocks == [("go", "request", ["go needs clear"])]
    bench.sense(50)
    assert bench.offer(3, DRIVE) == [(GO, 3)]
    bench.sense(2)
    assert bench.port.take() == [HALT]


def test_a_stop_by_a_service_waits_for_the_one_under_way() -> None:
    bench = Bench(stop_command=LAMP)
    for expected in ([LAMP], []):
        bench.sense(50)
        bench.offer(3, DRIVE)
        bench.sense(2)
        assert bench.port.take() == expected
    bench.report(LAMP, "response")
    assert bench.port.take() == [LAMP]
    bench.report(LAMP, "response")
    assert bench.port.take() == []


def test_a_goal_that_ended_is_not_cancelled() -> None:
    bench = Bench(stop_command=HALT)
    bench.request(ARM)
    bench.report(ARM, "response")
    bench.sense(50)
    assert bench.port.cancelled == []


def test_how_often_something_was_blocked_is_counted_and_shown() -> None:
    bench = Bench()
    bench.offer(3)
    bench.offer(3)
    assert bench.guard.recorder.counters["blocked"] == 2
    assert bench.guard.changed.is_set()


class Correcting(LampController):
    """Halves what is too fast; then more than 4 is forbidden."""

    COMMANDS = (
        LampController.COMMANDS[0]._replace(
            guard=lambda self, value: value <= 4.0,
            read=lambda self, message: message.x,
            correct=lambda self, value: (
                ({"x": value / 2}, "provide go with value / 2", "m.rscd:3") if value > 2.0 else None
            ),
            requirements=(3,),
        ),
        *LampController.COMMANDS[1:],
    )
    REQUIREMENTS = (
        *LampController.REQUIREMENTS,
        Requirement(
            "requirement go needs value <= 4.0", "m.rscd:4", lambda self, v: v <= 4.0, on_data=True
        ),
    )


def test_a_correction_is_judged_and_told() -> None:
    bench = Bench(Correcting())
    slow, fast = Speed(1.0), Speed(3.0)
    assert bench.offer(slow) == [(GO, slow)]
    ((key, made),) = bench.offer(fast)
    assert (key, made.x, fast.x) == (GO, 1.5, 3.0)
    documents = [event_document(entry) for entry in bench.guard.recorder.take()]
    for document in documents:
        validate(document, "event")
    assert [d["event"]["value"] for d in documents] == [1.0, 1.5]
    corrected = {
        "by": "provide go with value / 2",
        "place": "m.rscd:3",
        "fields": {"x": {"sent": 3.0, "made": 1.5}},
    }
    assert [d.get("corrected") for d in documents] == [None, corrected]
    assert bench.guard.recorder.counters["corrected"] == 1


def test_a_correction_that_is_not_enough_is_blocked_and_told() -> None:
    bench = Bench(Correcting())
    assert bench.offer(Speed(12.0)) == []
    assert bench.port.blocks == [("go", "request", ["requirement go needs value <= 4.0"])]
    (document,) = bench.port.documents
    assert document["event"]["value"] == 6.0
    assert document["corrected"]["fields"] == {"x": {"sent": 12.0, "made": 6.0}}
    assert bench.guard.recorder.counters["corrected"] == 0


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        (Undefined(), "what its correction reads is not there"),
        (OverflowError("too large"), "too large"),
    ],
)
def test_a_correction_that_cannot_be_made_is_blocked(fault: Exception, told: str) -> None:
    def faulty(self: Any, value: Any) -> Any:
        raise fault

    class Faulty(Correcting):
        COMMANDS = (
            Correcting.COMMANDS[0]._replace(correct=faulty),
            *Correcting.COMMANDS[1:],
        )

    bench = Bench(Faulty())
    assert bench.offer(Speed(1.0)) == []
    assert bench.port.blocks == [("go", "request", [told])]


def test_what_is_in_effect_is_judged_by_its_data() -> None:
    """A stop command ends a command whose data become forbidden, and not one with other data."""

    class Narrow(Correcting):
        COMMANDS = (
            Correcting.COMMANDS[0]._replace(
                guard=lambda self, value: value <= (4.0 if self.clear else 1.0), requirements=()
            ),
            *Correcting.COMMANDS[1:],
        )

    for speed, stops in ((1.0, 0), (2.0, 1)):
        bench = Bench(Narrow(), stop_command=HALT)
        bench.sense(50)
        bench.offer(Speed(speed))
        bench.sense(0)
        assert [key for key, _ in bench.port.sent] == [HALT] * stops
