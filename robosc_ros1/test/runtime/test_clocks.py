"""Timeouts of messages and transitions after a delay, on a clock that the test moves."""

from __future__ import annotations

import random
import threading
from typing import Any

import pytest
from runtime.lamp_robot import PlayedPort
from runtime.played_engine import Played

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.inbox import LIMIT
from robosc.runtime.core.model import Command, Communication, Controller, Input
from robosc.runtime.core.port import BEFORE_TIME
from robosc.runtime.core.settings import read
from robosc.runtime.core.timers import After
from robosc.runtime.core.values import Mismatch
from robosc.runtime.judge.matching import command_patterns
from robosc.runtime.judge.supervising import supervisor_engine

SCAN, DRIVE, HALT = "Eye.scan", "Motor.drive", "Motor.halt"


class WatchController(Controller):
    """It drives while the scan is fresh and free, else halts; it rests 2 s after each halt."""

    ROBOT, SOURCE, STEP_BOUND = "Watch", "watch.rscd", 1

    def __init__(self) -> None:
        self.undefined = {}
        self.scan_fresh = False
        self.free = False
        self.motor = "rest"
        self.motor_entries = 0

    def components(self) -> dict[str, str]:
        return {"Motor": self.motor}

    def variables(self) -> dict[str, Any]:
        return {"Eye.free": self.free}

    def read_scan(self, message: Any) -> Any:
        return message

    def on_scan(self, value: Any) -> None:
        if value is None:
            raise Mismatch("nothing in it")
        self.free = value > 1
        self.scan_fresh = True

    def on_scan_timeout(self, _: Any) -> None:
        if not self.scan_fresh:
            raise Mismatch("scan is silent")
        self.scan_fresh = False

    def can_drive(self) -> bool:
        return self.scan_fresh and self.free

    def can_halt(self) -> bool:
        return not self.can_drive()

    def in_ready(self) -> bool:
        return self.motor == "ready"

    def do_halt(self) -> None:
        self.motor = "rest"
        self.motor_entries += 1

    def step_after(self) -> str | None:
        if self.motor != "rest" or not self.free:
            return None
        self.motor = "ready"
        self.motor_entries += 1
        return "rest->ready"

    COMMUNICATIONS = (
        Communication(SCAN, "scan", "outgoing", ("scan_fresh",), ("silent", "fresh"), 0.5),
        Communication(DRIVE, "drive", "incoming"),
        Communication(HALT, "halt", "incoming"),
    )
    INPUTS = (
        Input(SCAN, "response", read_scan, on_scan, ("free", "scan_fresh")),
        Input(SCAN, "timeout", None, on_scan_timeout, ("scan_fresh",)),
    )
    COMMANDS = (
        Command(
            DRIVE, "request", can_drive, in_ready, None, None,
            ("free", "motor", "scan_fresh"), (), (),
        ),
        Command(
            HALT, "request", can_halt, None, None, do_halt,
            ("free", "scan_fresh"), ("motor", "motor_entries"), (),
        ),
    )  # fmt: skip
    TAUS = ()
    AFTERS = (
        After(
            "Motor", 1, "rest", 2.0, "motor", "motor_entries", step_after,
            ("free", "motor"), ("motor", "motor_entries"),
        ),
    )  # fmt: skip
    REQUIREMENTS = ()


DEFAULTS, _ = read(WatchController.COMMUNICATIONS, {})


class Bench:
    """An engine whose clock goes on in steps of a millisecond."""

    def __init__(self, **settings: Any) -> None:
        self.port = PlayedPort()
        self.port.time = 100.0
        self.engine = controller_engine(WatchController(), self.port, DEFAULTS._replace(**settings))
        self.post = self.engine.poster([SCAN])
        self.engine.begin()
        self.engine.cycle()

    def wait(self, seconds: float) -> list[str]:
        """What happens meanwhile, with the milliseconds at which it did."""
        self.engine.recorder.take()
        start = self.port.time
        told = []
        for step in range(1, round(seconds * 1000) + 1):
            self.port.time = start + step / 1000
            left = self.engine.time_to_deadline()
            if left == 0.0:
                self.engine.cycle()
            told += [
                f"{step} {e.kind} {e.name}"
                for e in self.engine.recorder.take()
                if e.kind in ("timeout", "after")
            ]
        return told

    def hear(self, value: Any = 5.0) -> None:
        self.post(value)
        self.engine.cycle()


def test_a_message_turns_silent_once_and_fresh_again() -> None:
    bench = Bench()
    assert bench.wait(3.0) == [], "it was never heard"
    bench.hear()
    assert bench.engine.controller.scan_fresh
    assert bench.wait(3.0)[0] == "500 timeout scan"
    assert bench.wait(3.0) == []
    bench.hear()
    bench.wait(0.4)
    bench.hear()
    assert "500 timeout scan" in bench.wait(0.6)


def test_what_could_not_be_applied_is_no_sign_of_life() -> None:
    bench = Bench()
    bench.hear()
    bench.wait(0.3)
    bench.hear(None)
    assert bench.wait(0.3) == ["200 timeout scan"]


def test_silence_counts_from_the_arrival_of_a_message() -> None:
    bench = Bench()
    bench.post(5.0)
    bench.port.time += 0.3  # the engine is busy
    bench.engine.cycle()
    assert bench.wait(0.3) == ["200 timeout scan"]


def test_no_timeout_is_announced_while_a_message_waits() -> None:
    bench = Bench()
    bench.hear()
    bench.port.time += 0.6
    bench.post(5.0)
    bench.engine.recorder.take()
    bench.engine.cycle()
    assert next(e.kind for e in bench.engine.recorder.take()) == "response"
    assert bench.engine.controller.scan_fresh


def test_what_is_due_is_done_within_the_millisecond() -> None:
    bench = Bench()
    bench.hear()
    assert bench.engine.time_to_deadline() == pytest.approx(0.5)
    bench.wait(0.499)
    assert bench.engine.time_to_deadline() == pytest.approx(0.001)


def test_a_transition_after_a_delay_is_taken_once_per_entry() -> None:
    bench = Bench(rate=0.01)
    # It is in rest since the beginning, but its guard does not hold without a scan.
    assert bench.wait(2.5) == []
    bench.hear()
    assert bench.engine.controller.motor == "ready", "time had passed, now the guard holds"
    assert [key for key, _ in bench.port.sent][-1] == DRIVE
    told = bench.wait(4.0)
    assert told[0] == "500 timeout scan"
    # Silence makes it halt, so that it is in rest again from 500 ms on.
    assert told[1:] == ["2500 after Motor"]
    assert bench.wait(5.0) == []


def test_entering_a_state_again_starts_its_time_anew() -> None:
    bench = Bench(rate=1.0)  # halts every second, which enters rest again
    bench.hear(0.5)
    for _ in range(40):
        bench.wait(0.2)
        bench.hear(0.5)
    told = []
    for number in range(11):
        bench.hear(5.0)
        told += [200 * number + int(line.split()[0]) for line in bench.wait(0.2) if "after" in line]
    assert len(told) == 1
    assert told[0] >= 1000, "two seconds after the last halt, not after the first"


def test_a_clock_that_jumps_back_starts_all_anew() -> None:
    bench = Bench()
    bench.hear()
    bench.wait(0.4)
    bench.port.time -= 50.0
    assert bench.wait(1.0)[0] == "501 timeout scan"


def test_a_small_step_back_moves_deadlines_by_the_step() -> None:
    bench = Bench()
    bench.hear()
    bench.wait(0.4)
    bench.port.time -= 1.9  # less than the two seconds of the transition
    assert bench.wait(1.0)[0] == "101 timeout scan"


@pytest.mark.parametrize("seed", range(30))
def test_silence_is_noticed_however_many_clocks_there_are(seed: int) -> None:
    """Each source tells its own time; all run as fast as the time of the wall."""
    chance = random.Random(seed)
    far = chance.choice([0.002, 0.02, 0.3, 1.9, 5.0, 1e4])
    sources = [chance.uniform(0.0, far) for _ in range(chance.randint(1, 3))]
    bench = Bench()
    silent_at = 0.0
    for step in range(400):
        wall = step / 100
        bench.port.time = 1e4 + wall + chance.choice(sources)
        if wall < 1.0:
            bench.hear()
        else:
            bench.engine.cycle()
        if wall >= 1.0 and not bench.engine.controller.scan_fresh and not silent_at:
            silent_at = wall
    if len(sources) == 1:
        assert 1.48 <= silent_at <= 1.51
    else:
        assert 1.0 <= silent_at <= 1.51 + (far >= 2.0)


class Wall:
    """A bench whose port has a clock of its own, beside that of the machine."""

    def __init__(
        self, start: float, engine_type: Any = controller_engine, port: Any = PlayedPort
    ) -> None:
        self.seconds = 0.0
        self.port = port()
        self.port.time = start
        self.engine = engine_type(
            WatchController(), self.port, DEFAULTS, steady=lambda: self.seconds
        )
        self.engine.begin()

    def faults(self, *times: float) -> list[str]:
        """What is shown after these times of the port, each half a second after the one before."""
        for time in times:
            self.seconds += 0.5
            self.port.time = time
            self.engine.cycle()
            faults: list[str] = self.engine.snapshot()["faults"]
        return [fault.split(":")[0] for fault in faults]


def test_time_that_does_not_begin_is_shown() -> None:
    wall = Wall(BEFORE_TIME)
    assert wall.faults(BEFORE_TIME) == []
    assert wall.faults(BEFORE_TIME, BEFORE_TIME) == ["ROS time has not begun"]
    assert wall.port.logs == [("warning", wall.engine.snapshot()["faults"][0])]
    assert wall.faults(1.7e9) == []


def test_time_that_stands_still_is_shown() -> None:
    wall = Wall(5.0)
    assert wall.faults(5.5, 6.0, 6.0) == []
    assert wall.faults(6.0) == ["ROS time stands still"]
    assert wall.faults(6.1) == []
    assert wall.faults(6.0, 5.9) == ["ROS time stands still", "ROS time steps back again and again"]


@pytest.mark.parametrize("engine_type", [controller_engine, supervisor_engine])
def test_silence_is_noticed_while_time_that_has_begun_stands_still(engine_type: Any) -> None:
    """Whoever published /clock is gone, and the scan with it, or later."""
    wall = Wall(5.0, engine_type)
    post = wall.engine.poster([SCAN])

    def fresh(seconds: float, scan: bool = False, going_on: bool = False) -> bool:
        for _ in range(round(seconds * 10)):
            wall.seconds += 0.1
            wall.port.time += 0.02 * going_on  # of a simulation at a fifth of its speed
            if scan:
                post(5.0)
            wall.engine.cycle()
        return bool(wall.engine.controller.scan_fresh)

    assert fresh(1.0, scan=True, going_on=True)
    assert fresh(2.4, going_on=True), "0.48 s of ROS time"
    assert fresh(5.0, scan=True)
    assert fresh(0.4)
    assert not fresh(0.2)
    assert fresh(0.1, scan=True, going_on=True)
    assert fresh(1.9)
    assert not fresh(0.3)
    assert fresh(0.1, scan=True, going_on=True)
    wall.seconds += 100.0
    assert fresh(0.1), "this process stood still, too"


def test_several_clocks_are_shown_but_not_a_recording_that_is_played_again() -> None:
    wall = Wall(5.0)
    assert wall.faults(5.5, 5.48, 6.0, 5.0, 7.0) == ["ROS time steps back again and again"]
    assert wall.faults(*range(8, 40)) == []
    assert wall.faults(0.0, *range(30), 0.0, 1.0) == []


def test_a_controller_without_clocks_does_not_mind_time() -> None:
    played = Played()
    for _ in range(3):
        assert played.engine.snapshot()["faults"] == []
        played.port.time -= 3.0


def test_what_seems_to_have_passed_when_time_begins_has_not() -> None:
    port = PlayedPort()
    port.time = BEFORE_TIME
    engine = controller_engine(WatchController(), port, DEFAULTS)
    engine.begin()
    post = engine.poster([SCAN])
    post(5.0)
    engine.cycle()
    post(5.0)
    port.time = 1.7e9  # the first message of /clock
    engine.cycle()
    controller = engine.controller
    assert (controller.scan_fresh, controller.motor) == (True, "rest")
    port.time += 0.499
    engine.cycle()
    assert controller.scan_fresh
    port.time += 0.002
    engine.cycle()
    assert not controller.scan_fresh


def test_a_message_that_arrived_by_a_later_clock_counts_from_when_it_is_taken() -> None:
    bench = Bench()
    bench.hear()
    bench.port.time = 40.0
    bench.engine.cycle()
    bench.port.time = 99.0
    bench.post(5.0)
    bench.port.time = 40.1
    bench.engine.cycle()
    bench.port.time = 99.0
    bench.engine.cycle()
    assert not bench.engine.controller.scan_fresh


def test_another_clock_starts_all_anew() -> None:
    bench = Bench()
    bench.hear()
    bench.wait(0.4)
    bench.port.time = 1.7e9
    bench.engine.restart_clocks("replaced")
    assert bench.engine.snapshot()["faults"] == ["replaced"]
    assert bench.wait(1.0)[0] == "500 timeout scan"


@pytest.mark.parametrize("replaced", [True, False])
def test_silence_is_noticed_however_often_all_starts_anew(replaced: bool) -> None:
    """Somebody sets use_sim_time to and fro, or ROS time goes back further each time."""
    bench = Bench()
    bench.hear()
    for _ in range(3):
        assert bench.wait(0.2) == []
        if replaced:
            bench.engine.restart_clocks("replaced")
        else:
            bench.port.time -= 50.0
    (told,) = bench.wait(0.4)
    assert 100 <= int(told.split()[0]) <= 103, "a millisecond of each change is lost"
    bench.hear()
    assert bench.wait(0.2) == []


class TwinController(WatchController):
    """Two transitions are due at once; the first one enters its state anew."""

    left = False

    def again(self) -> str | None:
        self.motor_entries += 1
        return "rest->rest"

    def leave(self) -> str | None:
        self.left = True
        return "rest->rest"

    AFTERS = tuple(
        After("Motor", number, "rest", 1.0, "motor", "motor_entries", step, ("motor",), ("motor", "motor_entries"))
        for number, step in ((1, again), (2, leave))
    )  # fmt: skip


def test_a_transition_whose_state_was_entered_anew_meanwhile_is_not_taken() -> None:
    port = PlayedPort()
    engine = controller_engine(TwinController(), port, DEFAULTS._replace(rate=0.01))
    engine.begin()
    for _ in range(4000):
        port.time += 0.001
        engine.cycle()
    assert engine.controller.motor_entries >= 4
    assert not engine.controller.left


def test_a_clock_that_stands_still_ends_nothing() -> None:
    bench = Bench()
    bench.hear()
    for _ in range(100):
        bench.engine.cycle()
    assert bench.engine.controller.scan_fresh


def test_the_time_that_is_left_is_told() -> None:
    bench = Bench()
    bench.hear()
    bench.wait(0.1)
    left = bench.engine.snapshot()["clocks"]
    assert left == {"scan": pytest.approx(0.4), "Motor.rest": pytest.approx(1.9)}


@pytest.mark.parametrize("delays", [(1.0, 2.0, 5.0), (5.0, 2.0, 1.0)])
def test_of_several_delays_of_one_state_the_next_one_is_told(
    delays: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    (after,) = WatchController.AFTERS
    rows = tuple(after._replace(number=n, delay=time) for n, time in enumerate(delays, 1))
    monkeypatch.setattr(WatchController, "AFTERS", rows)
    bench = Bench(rate=0.01)
    for passed, left in ((0.5, 0.5), (1.0, 0.5), (1.0, 2.5), (3.0, 0.0)):
        bench.wait(passed)
        assert bench.engine.snapshot()["clocks"]["Motor.rest"] == pytest.approx(left)


def test_a_parameter_says_how_long() -> None:
    settings, warnings = read(WatchController.COMMUNICATIONS, {"timeout/scan": 2})
    assert warnings == []
    bench = Bench(timeout=settings.timeout)
    bench.hear()
    assert "2000 timeout scan" in bench.wait(2.5)


class PatientController(WatchController):
    """One that only waits for a message."""

    AFTERS, COMMANDS = (), ()


def test_a_timeout_may_be_longer_than_locks_can_wait() -> None:
    settings, warnings = read(WatchController.COMMUNICATIONS, {"timeout/scan": 1e300})
    assert warnings == []
    engine = controller_engine(PatientController(), PlayedPort(), settings)
    ended: list[None] = []
    thread = threading.Thread(target=lambda: ended.append(engine.run()))  # type: ignore[func-returns-value]
    thread.start()
    engine.close()
    thread.join(20)
    assert ended == [None]


def test_a_supervisor_follows_silence_too() -> None:
    port = PlayedPort()
    port.blocked = lambda text: None  # type: ignore[attr-defined]
    engine = supervisor_engine(WatchController(), port, DEFAULTS)  # type: ignore[arg-type]
    engine.begin()
    passed: list[float] = []
    engine.role.follow((SCAN,), 5.0, lambda: passed.append(port.time))
    engine.cycle()
    assert passed == [0.0]
    assert engine.time_to_deadline() == pytest.approx(0.5)
    port.time = 0.5
    engine.cycle()
    assert not engine.controller.scan_fresh  # type: ignore[attr-defined]


def test_a_flood_is_bounded_and_its_latest_message_arrives() -> None:
    bench = Bench()
    for number in range(3 * LIMIT):
        bench.post(float(number))
    assert bench.engine.snapshot()["backlog"] == LIMIT
    while bench.engine.snapshot()["backlog"]:
        bench.engine.cycle()
    assert bench.engine.controller.free
    entries = [e.value for e in bench.engine.recorder.take() if e.kind == "response"]
    assert entries == [*map(float, range(LIMIT)), 3 * LIMIT - 1.0]
    assert bench.engine.snapshot()["counters"]["dropped"] == 2 * LIMIT - 1


def test_commands_and_clocks_have_their_turn_within_a_flood() -> None:
    bench = Bench()
    bench.hear()
    bench.port.take()
    bench.port.time += 1.0
    for _ in range(LIMIT):
        bench.post(0.5)
    bench.engine.cycle()
    assert bench.port.take() == [HALT]
    assert bench.engine.snapshot()["backlog"] > LIMIT // 2


class WaitingPort(PlayedPort):
    """A port with messages that wait outside until the test hands them over."""

    def __init__(self) -> None:
        super().__init__()
        self.waits = True
        self.done: list[Any] = []

    def await_inputs(self, done: Any) -> bool:
        self.done.append(done)
        return self.waits


class Standing:
    """A supervisor or a controller that may stand still."""

    def __init__(self, engine_type: Any = controller_engine) -> None:
        self.port = WaitingPort()
        self.blocked: list[str] = []
        self.port.blocked = self.blocked.append  # type: ignore[attr-defined]
        self.engine = engine_type(
            WatchController(), self.port, DEFAULTS, steady=lambda: self.port.time
        )
        self.post = self.engine.poster([SCAN])
        self.engine.begin()
        self.engine.cycle()
        self.port.take()

    def hear(self, value: Any = 5.0) -> list[str]:
        self.engine.controller.motor = "ready"
        self.post(value)
        self.engine.cycle()
        return self.port.take()


def test_after_a_pause_nothing_is_commanded_on_messages_that_waited() -> None:
    standing = Standing()
    assert standing.hear() == [DRIVE]
    standing.port.time += 7.0
    standing.engine.cycle()
    assert standing.port.take() == [], "not even a command that silence allows"
    for _ in range(3):
        assert standing.hear() == []
        assert not standing.engine.controller.scan_fresh
        standing.port.time += 0.1
    (done,) = standing.port.done
    done()
    standing.engine.cycle()
    assert standing.port.take() == [HALT], "what waited is too old to drive on"
    assert standing.hear() == [DRIVE]
    assert "stood still for 7.0 s" in standing.port.logs[0][1]


@pytest.mark.parametrize(
    ("before", "after", "left"),
    [
        (5.0, 5.0, 0.5),
        (5.0, 5.1, 0.4),  # a simulation that goes on at a crawl
        (5.0, 5.5, 0.0),
        (5.0, 12.0, 0.0),
        (5.0, 4.9, 0.0),  # how much was lost by the step back is not known
        (5.0, 1.0, 0.0),
        (BEFORE_TIME, 900.0, 0.5),
        (5.0, BEFORE_TIME, 0.0),
    ],
)
def test_what_waited_counts_as_come_when_the_pause_began(
    before: float, after: float, left: float
) -> None:
    """By the clock of the port: a pause of the machine in which that stands makes nothing old."""
    wall = Wall(before, port=WaitingPort)
    post = wall.engine.poster([SCAN])
    post(5.0)
    wall.engine.cycle()
    wall.seconds += 7.0
    wall.port.time = after
    for _ in range(2):
        post(5.0)
        wall.engine.cycle()
    assert wall.engine.snapshot()["clocks"].get("scan", 0.0) == pytest.approx(left)
    assert bool(wall.engine.controller.scan_fresh) is (left > 0.0)


def test_a_pause_in_the_middle_of_a_cycle_is_noticed_before_a_command() -> None:
    standing = Standing()
    assert standing.hear() == [DRIVE]
    standing.post(5.0)
    standing.engine.invoke(lambda: setattr(standing.port, "time", standing.port.time + 7.0))
    standing.engine.cycle()
    assert standing.port.take() == []


def test_after_a_pause_no_operator_lets_a_command_through_on_messages_that_waited() -> None:
    standing = Standing()
    assert standing.hear() == [DRIVE]
    standing.engine.operate("hold")
    standing.engine.cycle()
    standing.port.take()
    standing.port.time += 7.0
    standing.engine.operate("step")
    assert standing.hear() == []
    (done,) = standing.port.done
    done()
    standing.engine.cycle()
    standing.engine.operate("step")
    standing.engine.cycle()
    assert len(standing.port.take()) == 1


def test_a_second_pause_begins_anew_and_a_hanging_connection_ends() -> None:
    standing = Standing()
    for _ in range(2):
        standing.port.time += 1.0
        standing.engine.cycle()
    first, _ = standing.port.done
    first()
    assert standing.hear() == [], "the second pause is not over"
    for _ in range(9):
        standing.port.time += 0.2
        assert standing.hear() == []
    standing.port.time += 0.4
    assert standing.hear() == [DRIVE]


def test_nothing_is_held_where_nothing_waits() -> None:
    standing = Standing()
    standing.port.waits = False
    standing.port.time += 7.0
    assert standing.hear() == [DRIVE]


def test_a_supervisor_blocks_what_it_cannot_judge_after_a_pause() -> None:
    standing = Standing(supervisor_engine)
    patterns = command_patterns([(DRIVE, None, None)], dict)

    def offer() -> list[str]:
        standing.engine.role.offer("drive", patterns, {}, b"")
        standing.engine.cycle()
        return standing.port.take()

    standing.hear()
    assert offer() == [DRIVE]
    standing.engine.invoke(lambda: setattr(standing.port, "time", standing.port.time + 7.0))
    assert offer() == [], "a pause in the middle of the cycle"
    standing.hear()
    assert offer() == []
    assert '"kind":"paused"' in standing.blocked[-1]
    standing.port.done[-1]()
    standing.engine.cycle()
    assert offer() == []
    standing.hear()
    assert offer() == [DRIVE]


def test_silence_is_noticed_before_time_begins() -> None:
    """Nobody publishes /clock, but the robot moves."""
    wall = Wall(BEFORE_TIME)
    post, controller = wall.engine.poster([SCAN]), wall.engine.controller
    wall.seconds = 10.0
    post(5.0)
    wall.seconds = 10.49
    wall.engine.cycle()
    assert controller.scan_fresh
    wall.seconds = 10.51
    wall.engine.cycle()
    assert not controller.scan_fresh


def test_a_message_that_waits_before_time_begins_counts_from_its_arrival() -> None:
    wall = Wall(BEFORE_TIME)
    post, controller = wall.engine.poster([SCAN]), wall.engine.controller
    wall.seconds = 10.0
    wall.engine.invoke(lambda: setattr(wall, "seconds", 10.4))
    post(5.0)
    wall.engine.cycle()
    assert controller.scan_fresh
    wall.seconds = 10.51
    wall.engine.cycle()
    assert not controller.scan_fresh
