"""A recorder that is late is no fault of the robot: what it cannot know is not judged. That a
sensor is silent, and the controller goes on, is found all the same."""

from __future__ import annotations

import random
from itertools import pairwise
from pathlib import Path

import pytest

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from simulate.recorded_runs import START, BagWriter

from robosc.simulate.bags.judgement import Judgement, judge

MODEL = """
robot Rover {
    component Sensor {
        outgoing message depth with identifier: "/depth", timeout: 0.3 s, type: TYPE
    }
    component Motor {
        incoming message move with identifier: "/move", type: none
    }
    requirement move needs depth.fresh
}
"""
TYPES = {"stamped": "geometry_msgs/PointStamped", "bare": "std_msgs/Float32"}
PERIOD = 0.1
KINDS = ("bag", "mcap", "db3")


def bag(path: Path, kind: str, stall: tuple[float, float], *, silent: bool) -> Path:
    """Four seconds. In the stall the recorder takes no depths, or (``silent``) there are none;
    commands go on and are recorded in time."""
    begin, end = stall
    entries: list[tuple[float, str, float]] = []
    for number in range(40):
        made = number * PERIOD
        recorded = made + 0.01
        entries.append((made + 0.05, "/move", made))
        if begin < recorded < end:
            recorded = end
            if silent:
                continue
        entries.append((recorded, "/depth", made))
    entries.sort(key=lambda entry: entry[0])
    writer = BagWriter(path, {})
    for recorded, topic, made in entries:
        if topic == "/move":
            writer.write(topic, "std_msgs/msg/Empty", START + recorded, {})
            continue
        time = START + made
        stamp = {"header": {"stamp": {"sec": int(time), "nanosec": int(time % 1 * 1e9)}}}
        data = stamp if kind == "stamped" else {"data": made}
        type_ = TYPES[kind].replace("/", "/msg/")
        writer.write(topic, type_, START + recorded, data)
    writer.close()
    return writer.path


def judged(path: Path, kind: str) -> Judgement:
    return judge(supervisor_of(MODEL.replace("TYPE", TYPES[kind])), path, (), lambda *_: None)


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("storage", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_a_late_recorder(tmp_path: Path, kind: str, storage: str, seed: int) -> None:
    random_ = random.Random(seed)
    begin = random_.uniform(1.0, 2.0)
    stall = begin, begin + random_.uniform(0.6, 1.2)
    late = judged(bag(tmp_path / f"a.{storage}", kind, stall, silent=False), kind)
    assert not late.findings and not late.silences
    assert late.notes[-1].startswith(
        "not counted as silent, since a message that was recorded late"
    )
    silent = judged(bag(tmp_path / f"b.{storage}", kind, stall, silent=True), kind)
    assert [f.name for f in silent.findings] == ["move"]
    assert silent.silences == {"depth": 1} and not silent.notes


@pytest.mark.parametrize("storage", KINDS)
def test_a_sensor_that_is_always_old(tmp_path: Path, storage: str) -> None:
    """What it sends is 0.25 s old when it comes: none of it can have come before that."""
    writer = BagWriter(tmp_path / f"run.{storage}", {})
    times = [0.0, 0.1, 0.2, 0.3, 0.4, 0.8, 0.9, 1.0]
    for recorded in times:
        made = START + recorded - 0.25
        header = {"stamp": {"sec": int(made), "nanosec": int(made % 1 * 1e9)}}
        type_ = "geometry_msgs/msg/PointStamped"
        writer.write("/depth", type_, START + recorded, {"header": header})
    writer.write("/move", "std_msgs/msg/Empty", START + 0.77, {})
    writer.close()
    assert max(b - a for a, b in pairwise(times)) > 0.3
    found = judged(writer.path, "stamped")
    assert (found.silences, found.notes) == ({"depth": 1}, ())


def test_judgement_does_not_depend_on_the_order_of_equal_times(tmp_path: Path) -> None:
    """Recorders with a coarse clock give many messages one time, and write them as they like."""
    verdicts = set()
    for seed in range(12):
        order = random.Random(seed)
        entries = [
            (tick * 0.1, topic)
            for tick in range(40)
            for topic in ("/depth", "/move")
            if topic == "/move" or not 15 <= tick < 25
        ]
        order.shuffle(entries)
        entries.sort(key=lambda entry: entry[0])
        for storage in KINDS:
            writer = BagWriter(tmp_path / f"{storage}{seed}.{storage}", {})
            for time, topic in entries:
                depth = topic == "/depth"
                type_, data = (
                    ("std_msgs/msg/Float32", {"data": 1.0}) if depth else ("std_msgs/msg/Empty", {})
                )
                writer.write(topic, type_, START + time, data)
            writer.close()
            found = judged(writer.path, "bare")
            told = [(f.name, round(f.time - START, 3), f.count) for f in found.findings]
            verdicts.add((*told, found.silences.get("depth")))
    assert len(verdicts) == 1, verdicts
