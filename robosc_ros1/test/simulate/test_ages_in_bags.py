"""``robosc replay`` of bags in which messages are too old: they count as not arrived there, too."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from emit.golden_packages import model_path
from simulate.recorded_runs import START, BagWriter

from robosc.simulate.bags.judgement import judge

KINDS = ("bag", "mcap", "db3")


def recorded(path: Path, old_after: float, age: float) -> Path:
    """Depths every 100 ms, from some time on with an age, and a drive after one second."""
    bag = BagWriter(path, {})
    for number in range(12):
        time = START + 0.1 * number
        stamped = time - (age if 0.1 * number > old_after else 0.0)
        header = {"stamp": {"sec": int(stamped), "nanosec": int(stamped % 1 * 1e9)}}
        data = {"header": header, "point": {"z": 5.0}}
        bag.write("/depth", "geometry_msgs/msg/PointStamped", time, data)
    bag.write("/drive", "std_msgs/msg/Empty", START + 1.05, {})
    bag.close()
    return bag.path


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("age", "violations"),
    [(0.0, 0), (0.3, 0), (0.6, 1), (-0.3, 0), (-0.6, 1)],
    ids=["fresh", "not too old", "too old", "a little ahead", "of the future"],
)
def test_a_message_that_is_too_old_keeps_nothing_fresh(
    tmp_path: Path, kind: str, age: float, violations: int
) -> None:
    text = model_path("sonar").read_text(encoding="utf-8")
    path = recorded(tmp_path / f"run.{kind}", 0.35, age)
    found = judge(supervisor_of(text), path, (), lambda *_: None)
    told = [(finding.name, finding.sort) for finding in found.findings]
    # Each message that does not count leaves the model, and so does the command after them.
    assert told == [("depth", "departure"), ("drive", "violation")][: 2 * violations], told
