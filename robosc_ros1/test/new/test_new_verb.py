"""``new``: models to begin with pass ``check``, whatever runs in the graph."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros_support import REPOSITORY, SOURCES, Completed

from robosc.errors import has_errors
from robosc.language.keywords import KEYWORDS
from robosc.model.resolve import load
from robosc.model.ros.definitions import MessageDefinitions
from robosc.new.skeleton import from_survey
from robosc.new.survey import RosGraph, Spacing, pauses_of, survey
from robosc.source import Source

Robosc = Callable[..., Completed]

DRIVE = {
    f"/drive/{part}": "p_msgs/DriveAction" + part.title() for part in ("goal", "feedback", "result")
}
GRAPH = RosGraph(
    publishers={
        "/scan": ["/laser"],
        "/cmd_vel": ["/rover_controller"],
        "/speed": ["/teleop"],
        "/rover_controller/model": ["/rover_controller"],
        "/rover_controller/state": ["/rover_controller"],
        "/rover_controller/events": ["/rover_controller"],
        "/rover_controller/operate": ["/robosc_view_71_1700000000000"],
        "/rosout": ["/laser", "/rover_controller"],
        "/untyped": ["/laser"],
        "/drive/feedback": ["/base"],
        "/drive/result": ["/base"],
        "/drive/goal": ["/rover_controller"],
    },
    subscribers={
        "/scan": ["/rover_controller"],
        "/cmd_vel": ["/base"],
        "/speed": ["/base"],
        "/drive/goal": ["/base"],
        "/rover_controller/state": ["/robosc_view_71_1700000000000"],
        "/rover_controller/events": ["/rostopic_12_1700000000000"],
        "/old_controller/state": ["/robosc_view_72_1700000000000"],
        "/rover_controller/operate": ["/rover_controller"],
    },
    services={
        "/reset": ["/base"],
        "/base/get_loggers": ["/base"],
        "/rover_controller/stop": ["/rover_controller"],
    },
    actions={},
    types={
        "/scan": "sensor_msgs/LaserScan",
        "/cmd_vel": "geometry_msgs/Twist",
        "/speed": "std_msgs/Float32",
        "/rosout": "rosgraph_msgs/Log",
        "/untyped": "*",
        "/rover_controller/model": "std_msgs/String",
        "/rover_controller/state": "std_msgs/String",
        "/rover_controller/events": "std_msgs/String",
        "/rover_controller/operate": "std_msgs/String",
        "/old_controller/state": "std_msgs/String",
        "/reset": "std_srvs/Empty",
        "/rover_controller/stop": "std_srvs/Empty",
        "/base/get_loggers": "roscpp/GetLoggers",
        **DRIVE,
    },
)


def test_a_small_model(robosc: Robosc, tmp_path: Path) -> None:
    done = robosc("new", "SmallRover")
    assert done.stdout == "small_rover.rscd: written; next:\n    robosc check small_rover.rscd\n"
    assert "robot SmallRover {" in (tmp_path / "small_rover.rscd").read_text()
    assert robosc("check", "small_rover.rscd").stdout == "1 file: 0 errors, 0 warnings\n"
    assert robosc("format", "--check", "small_rover.rscd").returncode == 0


@pytest.mark.parametrize(("version", "run"), [("1", "rosrun"), ("2", "ros2 run")])
def test_the_next_command_is_one_that_is_there(tmp_path: Path, version: str, run: str) -> None:
    """Those who have robosc in a workspace start each verb by the executable of its name."""
    executable = REPOSITORY / "robosc_ros1" / "scripts" / "new"
    environment = {
        **os.environ,
        "PYTHONPATH": str(SOURCES),
        "ROS_VERSION": version,
    }
    told = subprocess.run(
        [sys.executable, executable, "Rover"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert told == f"rover.rscd: written; next:\n    {run} robosc check rover.rscd\n"


def test_nothing_is_overwritten(robosc: Robosc, tmp_path: Path) -> None:
    (tmp_path / "rover.rscd").write_text("mine")
    done = robosc("new", "Rover")
    assert (done.returncode, (tmp_path / "rover.rscd").read_text()) == (2, "mine")
    assert done.stderr == "error: rover.rscd is there already: take another name, or remove it\n"


def test_a_name_that_is_none(robosc: Robosc) -> None:
    done = robosc("new", "my-rover")
    assert done.returncode == 2
    assert "'my-rover' is not a name for a robot" in done.stderr


def test_a_controller_is_no_part_of_the_robot() -> None:
    """What it sends is what the robot receives; what every node has is left out."""
    found = survey(GRAPH)
    assert [(o.name, o.node, o.others) for o in found.outgoing] == [
        ("/scan", "/laser", ()),
        ("/speed", "/teleop", ("/base",)),
    ]
    assert [(o.name, o.node) for o in found.incoming] == [("/cmd_vel", "/base")]
    assert [(o.name, o.type) for o in found.services] == [("/reset", "std_srvs/Empty")]
    assert [(o.name, o.type, o.node) for o in found.actions] == [
        ("/drive", "p_msgs/Drive", "/base")
    ]


def test_a_pause_that_stands_out_is_a_question() -> None:
    pauses = pauses_of({"/scan": [0.0, 0.1, 0.2, 0.3, 0.9]})
    text = from_survey("Rover", survey(GRAPH), pauses, "what runs")
    assert "at the longest after 0.6 s: is a shorter timeout right, or none?\n" in text
    assert "timeout: 1.8 s" in text


def test_the_timeout_is_three_times_the_longest_pause() -> None:
    pauses = pauses_of({"/scan": [0.0, 0.1, 0.35, 0.4], "/speed": [1.0, 2.0]})
    text = from_survey("Rover", survey(GRAPH), pauses, "what runs")
    assert "// usually every 0.1 s, at the longest after 0.25 s\n" in text
    assert 'identifier: "/scan", timeout: 0.8 s, type: sensor_msgs/LaserScan' in text
    assert 'identifier: "/speed", type: std_msgs/Float32' in text
    assert "requirement cmd_vel needs permitted and scan.fresh\n" in text
    assert "// /base receives it; if the controller is to send it: incoming" in text


WORDS = st.sampled_from([*KEYWORDS, "scan", "Scan", "x1", "_a", "permitted", "Rover"])
NAMES = st.lists(WORDS, min_size=1, max_size=3).map(lambda words: "/" + "/".join(words))


@given(st.dictionaries(NAMES, st.tuples(NAMES, st.sampled_from("pqsa")), max_size=6))
def test_whatever_the_names_in_the_graph(ends: dict[str, tuple[str, str]]) -> None:
    """The model has no error: names are keywords of the language, and occur many times."""
    at = {kind: {n: [node] for n, (node, k) in ends.items() if k == kind} for kind in "pqsa"}
    types = dict.fromkeys(ends, "std_msgs/Bool")
    types.update(dict.fromkeys(at["s"], "std_srvs/Empty"), **dict.fromkeys(at["a"], "none"))
    found = survey(RosGraph(at["p"], at["q"], at["s"], {}, types))
    text = from_survey("Rover", found, dict.fromkeys(at["p"], Spacing(0.1, 0.2)), "what\nruns")
    _, diagnostics = load(
        Source("rover.rscd", text), definitions=MessageDefinitions.for_model(Path("rover.rscd"), {})
    )
    assert not has_errors(diagnostics), text
