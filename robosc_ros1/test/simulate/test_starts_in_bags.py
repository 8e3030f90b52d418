"""``robosc replay BAG --start next=3``: a recording does not say what the node had kept."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from simulate.recorded_runs import START, BagWriter

from robosc.cli import main
from robosc.simulate.bags.judgement import judge
from robosc.simulate.start import started

MODEL = Path(__file__).parents[1] / "ros2" / "models" / "tour.rscd"
"""It goes on only from the second stop."""


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_what_was_kept_decides_what_is_lawful(tmp_path: Path, kind: str) -> None:
    bag = BagWriter(tmp_path / f"run.{kind}", {})
    for number in range(4):
        time = START + 0.5 * number
        bag.write("/go_on", "std_msgs/msg/Int16", time, {"data": 1})
        bag.write("/arrived", "std_msgs/msg/Empty", time + 0.25, {})
    bag.close()
    supervisor = supervisor_of(MODEL.read_text(encoding="utf-8"))
    told = {}
    for first in (0, 1, 2, 9):
        judgement = judge(started(supervisor, [f"next={first}"]), bag.path, (), lambda *_: None)
        told[first] = [round(f.time - START, 2) for f in judgement.of("violation")]
    assert told == {0: [0.0], 1: [0.0], 2: [], 9: [0.5]}
    for start, code in (("next=0", 1), ("Tour.next=2", 0), ("next=10", 2), ("lap=1", 2)):
        assert main(["replay", str(MODEL), str(bag.path), "--start", start]) == code
