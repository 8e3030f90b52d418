"""The observer of the gallery: what it takes for right, and what for a violation."""

from __future__ import annotations

from physics.faults import Faults
from physics.observer import TOLERANCE, Observer

STEP = 0.05


def stopped(observer: Observer, at: float, until: float) -> None:
    """Let time pass with the stop pressed from a time on."""
    now = 0.0
    while now < until:
        now += STEP
        observer.tick(now)
        if now >= at:
            observer.note(stopped=True)


def test_command_just_after_the_stop_is_right() -> None:
    observer = Observer()
    observer.note(stopped=False)
    stopped(observer, at=1.0, until=1.0 + TOLERANCE / 2)
    observer.judge("moves only while released", lambda m: not m["stopped"])
    assert not observer.violations


def test_command_long_after_the_stop_is_a_violation() -> None:
    observer = Observer()
    observer.note(stopped=False)
    stopped(observer, at=1.0, until=1.0 + 2 * TOLERANCE)
    observer.judge("moves only while released", lambda m: not m["stopped"])
    assert observer.violations == {"moves only while released": 1}
    assert observer.times["moves only while released"][0] > 1.0


def test_topic_that_was_heard_long_ago_is_not_fresh() -> None:
    observer = Observer()
    observer.tick(STEP)
    observer.hear("/line")
    observer.tick(2 * STEP)
    observer.judge("sees", lambda m: m.fresh("/line", 0.3))
    assert not observer.violations
    observer.tick(1.0)
    observer.judge("sees", lambda m: m.fresh("/line", 0.3))
    assert observer.violations["sees"] == 1


def test_faults_of_a_seed_are_the_same_every_time() -> None:
    faults = Faults.planted(5, ["/line", "/scan"], ["/drive"], ["/scan"])
    assert faults == Faults.planted(5, ["/scan", "/line"], ["/drive"], ["/scan"])
    assert faults != Faults.planted(6, ["/line", "/scan"], ["/drive"], ["/scan"])
    ((topic, begin, end),) = faults.silences
    assert end - begin == 2.0
    assert faults.is_silent(topic, begin) and not faults.is_silent(topic, end)
    assert faults.kills and faults.late > 0.0
    ((scanner, first),) = faults.unusable
    scans = [faults.ranges(scanner, first + 0.4 * number + 0.1) for number in range(-1, 6)]
    assert repr(scans) == "[None, [], [nan], [0.0], [0.01], [inf], None]"
    assert faults.ranges("/line", first) is None
    assert not Faults.planted(5, ["/line"], [], []).late


def test_unusable_scan_is_worse_than_none() -> None:
    observer = Observer()
    observer.tick(STEP)
    observer.hear("/scan")
    observer.tick(STEP + 1.1 * TOLERANCE)
    observer.hear("/scan", usable=False)
    observer.tick(STEP + 2.5 * TOLERANCE)
    observer.judge("sees", lambda m: m.fresh("/scan", 10.0))
    assert observer.violations["sees"] == 1
