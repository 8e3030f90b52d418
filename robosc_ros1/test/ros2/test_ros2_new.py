"""``new --from-ros``: a model of the navigation example on ROS 2, whose controller runs as well."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from ros2.bed import REPOSITORY
from ros2.ros2_support import Graph, Process
from ros_support import SOURCES, run_robosc

BASE = REPOSITORY / "examples" / "navigation" / "nodes" / "simulated_base_ros2.py"


@pytest.mark.once
def test_a_model_of_what_runs(
    graph: Graph, controller: Callable[..., Process], tmp_path: Path
) -> None:
    graph.fork(BASE)
    controller("navigation_controller")
    peer = graph.peer("person")
    peer.watch("navigation_controller")
    peer.subscribe("/emergency_stop", "std_msgs/msg/Bool")
    peer.expect("message", name="/emergency_stop")
    peer.process.end()
    path = os.pathsep.join((str(SOURCES), graph.environment["PYTHONPATH"]))
    command = (
        "sh",
        "-c",
        f"cd {tmp_path} && exec {graph.bed.python} -m robosc new Found --from-ros",
    )
    new = graph.start(*command, PYTHONPATH=path)
    assert new.wait() == 0, new.output
    done = run_robosc(
        ("check", "found.rscd"),
        tmp_path,
        {"AMENT_PREFIX_PATH": graph.environment["AMENT_PREFIX_PATH"]},
    )
    assert (done.returncode, done.stdout[:17]) == (0, "1 file: 0 errors,"), done.stderr
    # What commands carry is left to the user, and that is all.
    codes = set(re.findall(r"warning\[([\w-]+)\]", done.stderr))
    assert codes == {"provide-missing"}
    text = " ".join((tmp_path / "found.rscd").read_text().split())
    assert 'action navigate with identifier: "/navigate", type: robot_common/Navigate' in text
    assert 'outgoing message emergency_stop with identifier: "/emergency_stop", timeout: ' in text
    assert 'incoming message press with identifier: "/press", type: std_msgs/Bool' in text
    assert "navigation_controller" not in text
