"""``./dev demo --ros2``: the line follower drives on real rclpy, with the report of that on ROS 1."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from ros2.bed import REPOSITORY, Bed


def test_the_line_follower_drives_and_violates_nothing(bed: Bed, tmp_path: Path) -> None:
    demo = REPOSITORY / "examples" / "line_follower" / "demo.py"
    # A busy machine hands messages to the observer late, and not in the order of their topics.
    options = ("--ros2", "--folder", tmp_path, "--metres", "3.0", "--tolerance", "0.5")
    done = subprocess.run([sys.executable, demo, *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["metres"] >= 3.0 and summary["grabs"] >= 1 and summary["commands_judged"] > 50
    assert set(summary["violations"].values()) == {0}
    assert (tmp_path / "path.png").stat().st_size > 1000
    told = done.stdout.partition("== What happened\n")[2].splitlines()
    assert [line.split()[0] for line in told[:5]] == [
        "distance", "stops", "grabs", "light", "violations",
    ]  # fmt: skip
