"""``robosc replay`` of recordings with transforms: the robot of examples/docking, judged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from ros_support import EXAMPLES
from simulate.recorded_runs import START, BagWriter

from robosc.cli import main
from robosc.simulate.bags.judgement import Judgement, judge

MODEL = EXAMPLES / "docking" / "docking.rscd"
SUPERVISOR = supervisor_of(MODEL.read_text(encoding="utf-8"))
SPEEDS = {"approach": 0.4, "creep": 0.1, "halt": 0.0}
KINDS = ("bag", "mcap", "db3")


class Run:
    """A recording of a robot whose base drives along the x axis of the map; the dock is at 5 m."""

    def __init__(self, path: Path, dock: float = 5.0) -> None:
        self.bag = BagWriter(path, {})
        self._tell("/tf_static", 0.0, ("map", "dock"), dock)

    def place(self, time: float, x: float) -> None:
        """Localisation stands still, odometry tells where the base is."""
        self._tell("/tf", time, ("map", "odom"), 1.0)
        self._tell("/tf", time, ("odom", "base_link"), x - 1.0)

    def move(self, time: float, name: str) -> None:
        data: dict[str, Any] = {"linear": {"x": SPEEDS[name]}}
        self.bag.write("/cmd_vel", "geometry_msgs/msg/Twist", START + time, data)

    def tell(self, time: float, parent: str, child: str) -> None:
        self._tell("/tf", time, (parent, child), 0.0)

    def judged(self) -> Judgement:
        self.bag.close()
        return judge(SUPERVISOR, self.bag.path, (), lambda *_: None)

    def _tell(self, topic: str, time: float, pair: tuple[str, str], x: float) -> None:
        self.bag.write_links(topic, START + time, (*pair, x))


def wrong(judgement: Judgement) -> list[tuple[float, str]]:
    return [(round(f.time - START, 2), f.name) for f in judgement.of("violation")]


@pytest.mark.parametrize("kind", KINDS)
def test_commands_are_judged_by_where_the_dock_is(tmp_path: Path, kind: str) -> None:
    run = Run(tmp_path / f"run.{kind}")
    for step in range(80):
        run.place(0.1 * step, 0.1 * step)
    # Away are 5 m less what was driven, 1 m per second.
    for time, name in (
        (1.04, "approach"), (2.04, "creep"), (3.54, "approach"), (4.54, "approach"),
        (4.34, "creep"), (4.84, "creep"), (4.94, "halt"),
    ):  # fmt: skip
        run.move(time, name)
    judgement = run.judged()
    assert wrong(judgement) == [(2.04, "creep"), (4.54, "approach"), (4.84, "creep")]
    assert (judgement.absent, judgement.unjudged) == ((), ())


@pytest.mark.parametrize("kind", KINDS)
def test_an_old_link_is_silence(tmp_path: Path, kind: str) -> None:
    run = Run(tmp_path / f"run.{kind}")
    run.place(0.0, 0.0)
    for step in range(1, 12):  # odometry goes on, and localisation does not
        run.tell(0.1 * step, "odom", "base_link")
        run.move(0.1 * step + 0.05, "approach")
    # At 0.6 s the link is too old; the last one that was not came at 0.5 s, and counts for 0.5 s.
    assert [time for time, _ in wrong(run.judged())] == [1.05]


def test_two_parents_are_told_and_silent(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = Run(tmp_path / "run.mcap")
    for step in range(20):
        run.place(0.1 * step, 0.0)
        if step == 5:
            run.tell(0.51, "map", "base_link")
        run.move(0.1 * step + 0.05, "approach")
    judgement = run.judged()
    # The last transform came at 0.5 s, and counts for half a second.
    assert wrong(judgement)[0] == (1.05, "approach")
    assert any("base_link has two parents, odom" in note for note in judgement.notes)
    assert main(["replay", str(MODEL), str(run.bag.path)]) == 1
    assert "two parents" in capsys.readouterr().out


def test_a_recording_without_transforms_shows_nothing_of_them(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "run.bag", {})
    bag.write("/cmd_vel", "geometry_msgs/msg/Twist", START, {"linear": {"x": 0.4}})
    bag.close()
    judgement = judge(SUPERVISOR, bag.path, (), lambda *_: None)
    assert judgement.absent == ("/tf",)
    assert judgement.of("violation") == []
    # Whether one that is preferred to 'halt' was allowed is not known, either.
    assert {name for name, _ in judgement.unjudged} == {"approach", "creep", "halt"}


@pytest.mark.parametrize("kind", KINDS)
def test_another_type_on_tf_is_told(
    tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = BagWriter(tmp_path / f"run.{kind}", {})
    bag.write("/tf", "std_msgs/msg/String", START, {})
    bag.close()
    assert main(["replay", str(MODEL), str(bag.path)]) == 2
    assert "tf2_msgs/TFMessage" in capsys.readouterr().err
