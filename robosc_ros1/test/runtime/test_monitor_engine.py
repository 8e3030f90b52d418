"""The monitor: what another controller does is judged, sent or not, and nothing is sent."""

from __future__ import annotations

import json
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_class, supervisor_of
from emit.golden_packages import GOLDEN
from runtime.lamp_robot import ARM, GO, HALT, LAMP, SENSOR, LampController, PlayedPort
from runtime.schemas import validate

from robosc.runtime.core.settings import Settings
from robosc.runtime.judge.gathering import ArrivalTime
from robosc.runtime.judge.matching import CommandPattern
from robosc.runtime.judge.monitoring import monitor_engine
from robosc.runtime.judge.observation import SeenAction, SeenActionOfRos2
from robosc.runtime.judge.ports import MonitorPort

TOLERANCE = Settings().tolerance
DRIVE = (CommandPattern(HALT, lambda message: message == 0), CommandPattern(GO))
CLEAR, BLOCKED = 20.0, 5.0


class SilentPort(PlayedPort, MonitorPort):
    def __init__(self) -> None:
        super().__init__()
        self.documents: list[dict[str, Any]] = []
        self.meanwhile: Callable[[], None] = lambda: None
        """What comes while something is handled that is a finding."""

    def found(self, text: str) -> None:
        document = json.loads(text)
        validate(document, "finding")
        self.documents.append(document)
        self.meanwhile()


class Bench:
    """A monitor that hears what the test says."""

    def __init__(self, **settings: Any) -> None:
        self.port = SilentPort()
        self.controller = LampController()
        self.monitor = monitor_engine(
            self.controller, self.port, Settings(**settings), lambda: self.port.time
        )
        self.monitor.role.leave_out({LAMP})
        self.monitor.begin()

    def hear(self, distance: float) -> None:
        self.monitor.poster([SENSOR])(distance)
        self.monitor.cycle()

    def command(self, speed: float) -> None:
        self.monitor.role.offer("/drive", DRIVE, speed)
        self.monitor.cycle()

    def wait(self, seconds: float) -> None:
        self.port.time += seconds
        self.monitor.cycle()

    def found(self) -> list[tuple[str, str, list[str]]]:
        """The findings since the last call: sort, event, reasons."""
        documents, self.port.documents = self.port.documents, []
        return [
            (d["sort"], f"{d['event']['name']}.{d['event']['kind']}", [r["text"] for r in d["reasons"]])
            for d in documents
        ]  # fmt: skip

    @property
    def told(self) -> list[tuple[str, str, str]]:
        return [(e.kind, e.name, e.outcome) for e in self.monitor.recorder.take()]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_command_that_stays_forbidden_is_found(bench: Bench) -> None:
    bench.hear(BLOCKED)
    bench.command(0.3)
    assert bench.found() == []
    bench.wait(TOLERANCE)
    assert bench.found() == [("violation", "go.request", ["go needs clear"])]
    assert bench.told[-1] == ("request", "go", "forbidden")
    assert bench.port.sent == []


def test_only_what_a_stop_sends_may_be_sent_at_any_time() -> None:
    bench = Bench(stop_command=GO)
    bench.hear(BLOCKED)
    drive = (CommandPattern(GO, None, lambda data: data.get("data", 0.0)),)
    for speed, found in ((0.3, 1), (0.0, 0), (bench.controller.speed, 0), (-0.3, 1)):
        bench.monitor.role.offer("/drive", drive, speed)
        bench.wait(2 * TOLERANCE)
        assert len(bench.found()) == found


@pytest.mark.parametrize("before", [True, False])
def test_a_command_that_crosses_what_decides_is_not(bench: Bench, before: bool) -> None:
    bench.hear(BLOCKED if before else CLEAR)
    if before:
        bench.command(0.3)
        bench.hear(CLEAR)
    else:
        bench.hear(BLOCKED)
        bench.wait(TOLERANCE / 2)
        bench.command(0.3)
    bench.wait(TOLERANCE)
    assert bench.found() == []


def test_what_waited_is_judged_as_when_it_came(bench: Bench) -> None:
    bench.hear(BLOCKED)
    bench.port.time += 1.0
    bench.monitor.role.offer("/drive", DRIVE, 0.3)
    bench.port.time += 2 * TOLERANCE
    bench.monitor.poster([SENSOR])(CLEAR)
    bench.wait(TOLERANCE)
    assert bench.found() == [("violation", "go.request", ["go needs clear"])]


def test_what_comes_while_another_message_is_handled_has_a_time_of_its_own(bench: Bench) -> None:
    bench.port.meanwhile = lambda: bench.monitor.poster([SENSOR])(CLEAR)
    bench.hear(1000.0)
    bench.monitor.cycle()
    first, second = (e.time for e in bench.monitor.recorder.take())
    assert first < second


def test_the_clock_of_arrivals_does_not_go_back_with_them_but_with_its_own() -> None:
    times = iter((5.0, 7.0, 7.0, 2.0, 2.0, 2.5))
    clock = ArrivalTime(lambda: next(times))
    assert clock() == 5.0
    for arrival, expected in ((6.0, 6.0), (5.5, 6.0), (2.0, 2.0)):
        clock.go_back(arrival)
        assert clock() == expected
    clock.go_on()
    assert clock() == 2.0


def test_a_mismatch_is_a_departure_with_the_number_of_its_event(bench: Bench) -> None:
    bench.hear(CLEAR)
    bench.hear(1000.0)
    (document,) = bench.port.documents
    entries = {e.number: e for e in bench.monitor.recorder.take()}
    assert entries[document["number"]].outcome == "mismatch"
    assert bench.found()[0][:2] == ("departure", "range.response")


def test_numbers_that_are_not_finite_would_have_been_blocked(bench: Bench) -> None:
    bench.hear(CLEAR)
    bench.command(float("nan"))
    assert [f[:2] for f in bench.found()] == [("blocked", "go.request")]


def test_what_waited_during_a_pause_is_not_judged(bench: Bench) -> None:
    bench.hear(BLOCKED)
    bench.wait(1.0)
    bench.monitor.pauses.holds = True  # the order of what waits now is not known
    bench.command(0.3)
    bench.monitor.pauses.holds = False
    bench.wait(TOLERANCE)
    assert bench.found() == []


def test_nothing_is_sent_whatever_happens(bench: Bench) -> None:
    bench = Bench(stop_command=HALT, on_mismatch="stop")
    bench.hear(1000.0)
    bench.monitor.stop("because")
    bench.wait(1.0)
    bench.monitor.close()
    bench.wait(1.0)
    assert (bench.port.sent, bench.port.cancelled, bench.port.exits) == ([], [], [])
    assert bench.monitor.stopped is None


# --- actions of ROS 1 -----------------------------------------------------------------------------


def time(seconds: int) -> SimpleNamespace:
    return SimpleNamespace(secs=seconds, nsecs=0)


def goal(number: int) -> Any:
    goal_id = SimpleNamespace(id=f"goal {number}", stamp=time(number))
    return SimpleNamespace(goal_id=goal_id, header=SimpleNamespace(stamp=time(number)), goal=None)


def result(number: int, status: int = 3) -> Any:
    told = SimpleNamespace(goal_id=goal(number).goal_id, status=status)
    return SimpleNamespace(status=told, result=None)


def test_a_result_that_overtakes_its_goal_ends_it(bench: Bench) -> None:
    action = SeenAction(bench.monitor.role, ARM).handlers
    bench.hear(BLOCKED)
    for number in (1, 2):
        action["/result"](result(number))
        action["/goal"](goal(number))
        bench.monitor.cycle()
        assert not bench.controller.arm_busy
    action["/result"](result(1))  # of a goal that has ended
    action["/goal"](goal(3))
    bench.monitor.cycle()
    assert bench.controller.arm_busy
    assert bench.told.count(("response", "reach", "applied")) == 2
    assert bench.found() == []


def status(now: int, *goals: tuple[int, int]) -> Any:
    listed = [SimpleNamespace(goal_id=goal(number).goal_id, status=s) for number, s in goals]
    return SimpleNamespace(header=SimpleNamespace(stamp=time(now)), status_list=listed)


def test_a_goal_of_which_the_server_knows_nothing_any_more_is_lost(bench: Bench) -> None:
    action = SeenAction(bench.monitor.role, ARM).handlers
    bench.hear(BLOCKED)
    action["/goal"](goal(1))
    action["/status"](status(1))  # it was sent before the goal came
    bench.monitor.cycle()
    assert bench.controller.arm_busy
    action["/status"](status(2, (1, 1)))
    action["/status"](status(3))  # of a server that was started anew
    bench.monitor.cycle()
    assert not bench.controller.arm_busy
    assert bench.told[-1] == ("error", "reach", "applied")
    action["/goal"](goal(2))
    bench.monitor.cycle()
    assert bench.controller.arm_busy and bench.found() == []


def test_a_goal_whose_server_keeps_silent_is_lost_as_for_the_controller(bench: Bench) -> None:
    action = SeenAction(bench.monitor.role, ARM).handlers
    limit = Settings().server_lost_after
    bench.hear(BLOCKED)
    action["/status"](status(1))
    bench.wait(2 * limit)
    action["/goal"](goal(1))  # nothing was awaited of the server before
    bench.monitor.cycle()
    bench.wait(limit / 2)
    action["/status"](status(2, (1, 1)))
    bench.wait(limit - 0.1)
    assert bench.controller.arm_busy
    assert bench.monitor.time_to_deadline() == pytest.approx(0.1)
    bench.wait(0.1)
    assert not bench.controller.arm_busy
    assert bench.told[-1] == ("error", "reach", "applied")
    action["/result"](result(1))  # comes late
    action["/status"](status(3))  # of a server that was started anew
    action["/goal"](goal(2))
    bench.monitor.cycle()
    assert bench.controller.arm_busy and bench.found() == []


def test_a_cancelled_goal_whose_server_keeps_silent_is_awaited(bench: Bench) -> None:
    action = SeenAction(bench.monitor.role, ARM).handlers
    bench.hear(BLOCKED)
    action["/goal"](goal(1))
    action["/status"](status(1, (1, 1)))
    action["/cancel"](goal(1).goal_id)
    bench.monitor.cycle()
    bench.wait(3 * Settings().server_lost_after)
    assert ("error", "reach", "applied") not in bench.told
    assert bench.controller.arm_busy


@pytest.mark.parametrize("ended", [2, 3, 4])
def test_an_end_whose_result_was_not_recorded(bench: Bench, ended: int) -> None:
    action = SeenAction(bench.monitor.role, ARM).handlers
    bench.hear(BLOCKED)
    action["/goal"](goal(1))
    if ended == 2:
        action["/cancel"](goal(1).goal_id)
    for second in (1, 2):
        bench.monitor.cycle()
        assert bench.controller.arm_busy
        action["/status"](status(second, (1, ended)))
    bench.wait(TOLERANCE)
    assert not bench.controller.arm_busy
    action["/result"](result(1, ended))  # comes late
    action["/goal"](goal(2))
    bench.monitor.cycle()
    assert bench.controller.arm_busy and bench.found() == []


@pytest.mark.parametrize(("ended", "kind"), [(3, "response"), (4, "error"), (8, "error")])
def test_the_next_goal_follows_an_end_whose_result_was_not_recorded(
    bench: Bench, ended: int, kind: str
) -> None:
    """Who records is connected to a server that starts after who sends the goals."""
    action = SeenAction(bench.monitor.role, ARM).handlers
    bench.hear(BLOCKED)
    action["/goal"](goal(1))
    action["/status"](status(1, (1, ended)))
    action["/goal"](goal(2))
    action["/result"](result(1, ended))  # comes late
    bench.monitor.cycle()
    bench.wait(TOLERANCE)
    assert bench.controller.arm_busy and bench.found() == []
    assert [told[0] for told in bench.told if told[1] == "reach"] == ["request", kind, "request"]


def listed(*goals: tuple[int, int]) -> Any:
    """A status of ROS 2: goals, by number, with the status of each."""
    infos = (SimpleNamespace(goal_id=SimpleNamespace(uuid=[n] * 16)) for n, _ in goals)
    rows = zip(infos, goals, strict=True)
    return SimpleNamespace(
        status_list=[SimpleNamespace(goal_info=info, status=s) for info, (_, s) in rows]
    )


def test_a_goal_that_vanishes_in_ros_2_is_lost(bench: Bench) -> None:
    listen = SeenActionOfRos2(bench.monitor.role, ARM).handlers["/_action/status"]
    bench.hear(BLOCKED)
    listen(listed((1, 2)))
    bench.monitor.cycle()
    assert bench.controller.arm_busy
    listen(listed((2, 2)))
    bench.monitor.cycle()
    assert bench.controller.arm_busy and bench.found() == []
    assert bench.told.count(("error", "reach", "applied")) == 1


def test_a_replaced_goal_that_ends_does_not_end_the_action_of_one_that_waits() -> None:
    text = (GOLDEN / "models" / "courier.rscd").read_text()
    class_, _ = controller_class(supervisor_of(text.replace("expect: value.distance < 5.0,", "")))
    port, controller = SilentPort(), class_()
    monitor = monitor_engine(controller, port, Settings(), lambda: port.time)
    listen = SeenActionOfRos2(monitor.role, "Base.go").handlers["/_action/status"]
    monitor.begin()

    def want(wanted: bool) -> None:
        monitor.poster(["Desk.wanted"])(SimpleNamespace(data=wanted))
        monitor.cycle()

    def told() -> list[tuple[str, str]]:
        monitor.cycle()
        events = (e for e in monitor.recorder.take() if e.name == "go")
        return [(e.kind, e.outcome) for e in events]

    want(True)
    listen(listed((1, 2)))
    assert told() == [("request", "applied")]
    want(False)
    port.time += 2 * TOLERANCE
    listen(listed((1, 2), (2, 2), (3, 2)))
    listen(listed((1, 6), (2, 4), (3, 2)))
    assert told() == []
    want(True)
    assert told() == [("request", "applied")] * 2
    listen(listed((1, 6), (2, 4), (3, 4)))
    assert told() == [("response", "applied")]


def test_the_end_of_a_cancelled_goal_crosses_the_next_goal(bench: Bench) -> None:
    action = SeenAction(bench.monitor.role, ARM).handlers
    bench.hear(BLOCKED)
    action["/goal"](goal(1))
    action["/cancel"](goal(1).goal_id)
    bench.monitor.cycle()
    action["/goal"](goal(2))
    action["/cancel"](goal(1).goal_id)  # once more: it is not meant for the second goal
    bench.monitor.cycle()
    action["/result"](result(1, 2))
    bench.monitor.cycle()
    bench.wait(TOLERANCE)
    assert bench.controller.arm_busy and bench.found() == []
    assert bench.told.count(("request", "reach", "applied")) == 2
