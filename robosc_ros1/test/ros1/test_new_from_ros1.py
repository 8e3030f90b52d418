"""``new --from-ros``: a model of the navigation example, whose controller runs as well."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from ros1.stage import Stage
from ros_support import Master, Workspace


@pytest.mark.once
def test_a_model_of_what_runs(
    example_workspace: Workspace, roscore: Master, tmp_path: Path
) -> None:
    launch = ("roslaunch", "navigation_example", "navigation.launch")
    with example_workspace.start(*launch, master=roscore):
        with Stage(example_workspace, roscore).puppet() as puppet:
            for topic, type_ in (
                ("/navigation_controller/state", "std_msgs/String"),
                ("/emergency_stop", "std_msgs/Bool"),
            ):
                puppet.do("listen", topic=topic, type=type_)
                puppet.hears(topic)
        env = example_workspace.environment(master=roscore)
        for words in (("new", "Found", "--from-ros"), ("check", "found.rscd")):
            done = subprocess.run(
                ["rosrun", "robosc", *words], cwd=tmp_path, env=env, capture_output=True, text=True
            )
            assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("1 file: 0 errors")
    text = " ".join((tmp_path / "found.rscd").read_text().split())
    assert 'action navigate with identifier: "/navigate", type: robot_common/Navigate' in text
    assert 'outgoing message emergency_stop with identifier: "/emergency_stop", timeout: ' in text
    assert 'incoming message press with identifier: "/press", type: std_msgs/Bool' in text
    assert "navigation_controller" not in text
