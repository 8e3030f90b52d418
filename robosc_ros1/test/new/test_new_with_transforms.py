"""``new --from-bag`` of a recording with transforms: the model asks where the robot is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from ros_support import Completed

pytest.importorskip("rosbags")
from simulate.recorded_runs import START, BagWriter

Links = list[tuple[str, str]]


def write(bag: BagWriter, topic: str, time: float, links: Links) -> None:
    bag.write_links(topic, START + time, *((parent, child, 0.0) for parent, child in links))


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_where_each_robot_is(tmp_path: Path, kind: str, robosc: Callable[..., Completed]) -> None:
    bag = BagWriter(tmp_path / f"run.{kind}", {})
    write(bag, "/tf_static", 0.0, [("one/base_link", "one/laser"), ("map", "dock")])
    for step in range(20):
        write(bag, "/tf", 0.05 * step, [("/one/odom", "/one/base_link")])
        write(bag, "/tf", 0.05 * step + 0.01, [("map", "two/base_link"), ("a b", "base_link")])
    for step in range(5):
        write(bag, "/tf", 0.2 * step, [("map", "one/odom")])
        bag.write("/cmd_vel", "geometry_msgs/msg/Twist", START + step, {})
    bag.close()
    model = tmp_path / "found.rscd"
    done = robosc("new", "Found", "--from-bag", str(bag.path))
    assert done.returncode == 0, done.stderr
    assert "2 transforms" in done.stdout
    text = model.read_text(encoding="utf-8")
    assert text.count("outgoing transform") == 2
    # The longest pause between links of the chain, times three.
    assert 'from: "map", to: "one/base_link", timeout: 0.2 s' in text
    assert 'from: "map", to: "two/base_link", timeout: 0.2 s' in text
    assert "frames: map, dock, one/base_link, one/laser, one/odom, two/base_link" in text
    done = robosc("check", str(model))
    assert done.stderr.count("error[") == 0, done.stderr
