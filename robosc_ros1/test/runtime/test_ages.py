"""Messages that are too old on arrival, by the stamps of their headers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from runtime.lamp_robot import PlayedPort
from runtime.test_clocks import SCAN, WatchController

from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.model import Communication, Parameter
from robosc.runtime.core.port import BEFORE_TIME
from robosc.runtime.core.settings import read
from robosc.runtime.judge.supervising import supervisor_engine

SEEN = "Eye.seen"
MOST = Parameter("Eye/most", "number", 0.2, "the greatest age", attribute="eye_most")


class DatedController(WatchController):
    """The scan is dated by a parameter, ``seen`` is the same message and is not."""

    COMMUNICATIONS = (
        *(
            c._replace(max_age="Eye/most") if c.key == SCAN else c
            for c in WatchController.COMMUNICATIONS
        ),
        Communication(SEEN, "seen", "outgoing"),
    )
    INPUTS = (
        *(
            row._replace(read=lambda self, m: m.range) if row.kind == "response" else row
            for row in WatchController.INPUTS
        ),
        WatchController.INPUTS[0]._replace(
            key=SEEN,
            read=lambda self, m: m.range,
            apply=lambda self, value: setattr(self, "shown", value),
            writes=("shown",),
        ),
    )
    shown = 0.0


def message(stamp: float, value: float = 5.0, ros: int = 1) -> Any:
    """A scan as either version of ROS has it."""
    names = ("secs", "nsecs") if ros == 1 else ("sec", "nanosec")
    parts = divmod(round(stamp * 10**9), 10**9)
    header = SimpleNamespace(stamp=SimpleNamespace(**dict(zip(names, parts, strict=True))))
    return SimpleNamespace(header=header, range=value)


class Bench:
    """An engine whose clock the test moves; the scan has the topic for itself, or not."""

    def __init__(self, keys: tuple[str, ...] = (SCAN,), begun: float = 100.0, **more: Any) -> None:
        self.port = PlayedPort()
        self.port.time = begun
        settings, _ = read(DatedController.COMMUNICATIONS, more, (MOST,))
        self.controller = DatedController()
        self.engine = controller_engine(self.controller, self.port, settings, steady=lambda: 7.0)
        self.post = self.engine.poster(keys)
        self.engine.begin()
        self.engine.cycle()
        self.engine.recorder.take()

    def hear(self, heard: Any) -> list[tuple[str, str, str | None]]:
        """What the node tells of a message."""
        self.post(heard)
        self.engine.cycle()
        entries = self.engine.recorder.take()
        return [(e.name, e.outcome, e.detail) for e in entries if e.kind == "response"]


@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize(
    ("stamp", "detail"),
    [
        (99.85, None),
        (100.0, None),
        (100.15, None),
        (99.75, "it was 0.250 s old when it arrived"),
        (100.25, "its stamp lies 0.250 s in the future"),
        (0.0, "its age is not known: no stamp"),
    ],
)
def test_what_is_too_old_counts_as_not_arrived(ros: int, stamp: float, detail: str | None) -> None:
    bench = Bench()
    outcome = "applied" if detail is None else "mismatch"
    assert bench.hear(message(stamp, ros=ros)) == [("scan", outcome, detail)]
    assert bench.controller.scan_fresh is (detail is None)
    assert bench.controller.free is (detail is None)
    assert bench.engine.recorder.counters["mismatches"] == (detail is not None)


def test_the_timeout_runs_on() -> None:
    bench = Bench()
    bench.hear(message(100.0))
    bench.port.time = 100.4
    bench.hear(message(100.0))
    assert bench.engine.time_to_deadline() == pytest.approx(0.1, abs=1e-6)
    bench.port.time = 100.5
    bench.engine.cycle()
    assert not bench.controller.scan_fresh


def test_what_counts_is_the_arrival_not_when_the_engine_has_time() -> None:
    bench = Bench()
    bench.post(message(100.0))
    bench.port.time = 100.4  # the engine was busy
    bench.engine.cycle()
    assert bench.controller.scan_fresh


def test_each_communication_of_a_topic_judges_the_age_by_itself() -> None:
    bench = Bench((SCAN, SEEN))
    told = bench.hear(message(1.0, 3.0))
    assert [(name, outcome) for name, outcome, _ in told] == [
        ("scan", "mismatch"), ("seen", "applied"),
    ]  # fmt: skip
    assert (bench.controller.shown, bench.controller.free) == (3.0, False)


def test_a_parameter_says_how_old_a_message_may_be() -> None:
    bench = Bench(**{"Eye/most": 30.0})
    assert bench.hear(message(80.0)) == [("scan", "applied", None)]
    assert bench.hear(message(69.0))[0][1] == "mismatch"


def test_before_ros_time_starts_no_age_is_known() -> None:
    bench = Bench(begun=BEFORE_TIME)
    told = bench.hear(message(7.0))  # the time of the machine
    assert told == [("scan", "mismatch", "its age is not known: no time yet")]
    bench.port.time = 50.0
    bench.engine.cycle()
    assert bench.hear(message(49.9)) == [("scan", "applied", None)]


def test_a_message_without_a_header_is_a_mismatch_and_no_internal_error() -> None:
    bench = Bench()
    assert bench.hear(SimpleNamespace(range=5.0))[0][1] == "mismatch"
    assert bench.engine.stopped is None


def test_a_supervisor_passes_it_on_and_does_not_count_it() -> None:
    port = PlayedPort()
    port.time = 100.0
    settings, _ = read(DatedController.COMMUNICATIONS, {}, (MOST,))
    engine = supervisor_engine(DatedController(), port, settings)
    passed: list[Any] = []
    engine.begin()
    for stamp in (1.0, 99.9):
        one = message(stamp)
        engine.role.follow([SCAN], one, lambda one=one: passed.append(one))
        engine.cycle()
        assert passed[-1] is one
        assert engine.controller.scan_fresh is (stamp > 99.0)  # type: ignore[attr-defined]


def test_stamps_have_another_clock_than_the_node_where_time_is_not_simulated() -> None:
    bench = Bench()
    bench.port.stamp_time = lambda: bench.port.time + 5000.0  # type: ignore[method-assign]
    bench.post(message(5100.0))
    bench.port.time = 100.4  # the engine was busy
    bench.engine.cycle()
    assert bench.controller.scan_fresh
    assert bench.hear(message(5100.0))[-1][1:] == ("mismatch", "it was 0.400 s old when it arrived")
