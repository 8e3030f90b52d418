"""Robots of the gallery, driven by controllers with planted faults and recorded by ROS's own means:
``robosc replay`` finds each fault when the gallery's observer, which knows no model, sees it, and
nothing else."""

from __future__ import annotations

import contextlib
import json
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rosbags")

from ros2.bed import Unavailable
from ros2.ros2_support import Graph
from ros_support import REPOSITORY, await_condition
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

import gallery
from robosc import pipeline
from robosc.simulate.bags.judgement import Finding, Judgement, judge

pytestmark = pytest.mark.slow

HERE = Path(__file__).parent
TICK = 0.05
CROSSED = 2.5 * TICK
"""Seconds by which messages cross where the clock goes in steps."""
FASTER = 0.35
"""The observer's own tolerance, and a step: by so much more it may excuse."""
CLOCK = {"/clock": "rosgraph_msgs/msg/Clock"}
"""Recorded too: it shows how late the recorder was, for which simulated time does not wait."""

STOP = {"/stop": "std_msgs/msg/Bool", "/continue": "std_msgs/msg/Empty"}
WHEELS = {"/cmd_vel": "geometry_msgs/msg/Twist"}


@dataclass(frozen=True)
class Planted:
    """What is taken out of a model, by what; the topics to record; the observer's rules that are
    broken then, each with a part of the requirement; whether sensors fail, too."""

    changes: Mapping[str, str]
    topics: Mapping[str, str]
    rules: Mapping[str, str]
    faults: bool = True


PLANTED = {
    "line_follower": Planted(
        {"requirement move needs line.fresh and Button.released\n": ""},
        {"/line": "std_msgs/msg/Float32", "/alive": "std_msgs/msg/Empty", **STOP, **WHEELS},
        {"moves only while released": "line.fresh", "moves only if it sees": "line.fresh"},
    ),
    "follow_person": Planted(
        {"battery.fresh and Battery.charge > empty": "true", " and Button.released": ""},
        {"/person": "geometry_msgs/msg/PointStamped", "/battery": "sensor_msgs/msg/BatteryState",
         **STOP, **WHEELS},
        {"moves only while released": "Button.released", "moves only if it sees": "battery.fresh",
         "moves only while charged": "Battery.charge"},
    ),
    # Its goals end as the controller wants; that one goes on too long is no command.
    "go_to_pose": Planted(
        {},
        {"/scan": "sensor_msgs/msg/LaserScan", "/clicked_point": "geometry_msgs/msg/PointStamped",
         "/alive": "std_msgs/msg/Empty", **dict.fromkeys(
             (f"/drive/{part}" for part in ("goal", "cancel", "feedback", "result", "status")), ""),
         **STOP},
        {},
        # A server that is killed tells nobody when, and its loss begins a delay of the model.
        faults=False,
    ),
}  # fmt: skip


RECORDED = [robot for robot, planted in PLANTED.items() if planted.changes]
"""What drives without a planted fault, too, as other robots do that nobody records."""
SECONDS = 20.0
"""Of simulated time, which each robot has at most."""


@pytest.fixture(scope="module")
def models(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The gallery's models, with faults in them or as they are."""
    folder = tmp_path_factory.mktemp(request.param) / request.param
    shutil.copytree(gallery.HERE / "libraries", folder / "libraries")
    for robot, planted in PLANTED.items():
        text = model_of(robot).read_text(encoding="utf-8")
        for old, new in planted.changes.items() if request.param == "planted" else ():
            assert old in text
            text = text.replace(old, new)
        (folder / robot).mkdir()
        (folder / robot / f"{robot}.rscd").write_text(text, encoding="utf-8")
    return folder


def model_of(robot: str) -> Path:
    return gallery.HERE / robot / f"{robot}.rscd"


@pytest.fixture(scope="module")
def ros1(
    ros: None, models: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[gallery.Ros1]:
    if (reason := gallery.missing()) is not None:
        pytest.skip(reason)
    built = gallery.Ros1(tmp_path_factory.mktemp("gallery") / "ros1", models)
    built.build(list(PLANTED) if models.name == "planted" else RECORDED)
    yield built


@pytest.fixture(scope="module")
def ros2(models: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[gallery.Ros2]:
    if (reason := gallery.missing()) is not None:
        pytest.skip(reason)
    try:
        built = gallery.Ros2(tmp_path_factory.mktemp("gallery") / "ros2", models)
    except Unavailable as reason:
        pytest.skip(f"no ROS 2: {reason}")
    built.build(RECORDED)
    yield built


@contextlib.contextmanager
def rosbag(ros: gallery.Ros1, path: Path, robot: str) -> Iterator[None]:
    """``rosbag record``, which begins when there is a time."""
    run, master = ros.workspace.run, ros.master
    assert master is not None
    master.set("/use_sim_time", True)
    with ros.workspace.recording(path, *PLANTED[robot].topics, *CLOCK, master=master):
        first = "{clock: {nsecs: 1000000}}"
        run("rostopic", "pub", "-1", "/clock", "rosgraph_msgs/Clock", first, master=master)
        await_condition(path.with_suffix(".bag.active").exists, "rosbag to record")
        yield


@contextlib.contextmanager
def recorder(ros: gallery.Ros2, path: Path, robot: str) -> Iterator[None]:
    graph = Graph(ros.bed, ros.domain, path.parent)
    words = [word for pair in {**PLANTED[robot].topics, **CLOCK}.items() for word in pair]
    extras = REPOSITORY / ".cache" / "extras"
    environment = graph.environment | {"PYTHONPATH": f"{graph.environment['PYTHONPATH']}:{extras}"}
    command = [ros.bed.python, str(HERE / "record_ros2.py"), str(path), *words]
    with subprocess.Popen(
        command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        # The middleware tells of its shared memory there, too.
        assert b"records\n" in iter(process.stdout.readline, b"")
        yield
        process.stdin.close()
        assert process.wait(60) == 0


def lateness(path: Path) -> float:
    """By how many seconds of simulated time the recorder's clock and what it wrote were apart."""
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as bag:
        clocks = [c for c in bag.connections if c.topic in CLOCK]
        late = 0.0
        for connection, time, raw in bag.messages(clocks):
            sent: Any = bag.deserialize(raw, connection.msgtype)
            late = max(late, abs(time * 1e-9 - sent.clock.sec - sent.clock.nanosec * 1e-9))
    return late


def judged(robot: str, path: Path, late: float) -> Judgement:
    options = pipeline.Options((gallery.HERE / "libraries",))
    with pytest.MonkeyPatch.context() as process:
        process.setenv("ROS_PACKAGE_PATH", str(gallery.HERE))
        loaded = pipeline.load(model_of(robot), options)
    supervisor = pipeline.supervise(loaded.robot)
    return judge(supervisor, path, [f"tolerance={CROSSED + late}"], lambda *_: None)


def certain(times: list[float], late: float) -> list[float]:
    """Those times at which a rule was broken that no order of the messages excuses.

    Where the recorder was late by no more than where messages cross anyway, these are all; else a
    command may be excused by what the robot said so long before or after it.
    """
    stretches: list[list[float]] = []
    for time in times:
        if stretches and time - stretches[-1][-1] < 2.5 * TICK:
            stretches[-1].append(time)
        else:
            stretches.append([time])
    edge = CROSSED + late if late > 2 * TICK else 0.0
    return [t for some in stretches for t in some if some[0] + edge <= t <= some[-1] - edge]


def compare(
    robot: str, found: Judgement, seen: Mapping[str, list[float]], planted: bool, late: float
) -> None:
    """Each time at which a rule was broken lies in a finding of its requirement; each finding is
    of such a requirement and about such times; the recorder was late by so many seconds."""
    slack = FASTER + late

    def span(finding: Finding) -> tuple[float, float]:
        return finding.time - slack, finding.until + slack

    rules = PLANTED[robot].rules
    begin = found.start + slack  # what comes before was not recorded as a whole
    broken = {rule: [t for t in seen.get(rule, []) if t > begin] for rule in rules}
    assert {bool(times) for times in broken.values()} <= {planted}, broken
    for rule, times in broken.items():
        spans = [span(f) for f in found.findings if any(rules[rule] in r for r in f.reasons)]
        each = certain(times, late)
        missed = [t for t in each if not any(low <= t <= high for low, high in spans)]
        assert missed == [], (rule, spans)
    for finding in found.findings:
        assert finding.sort == "violation", finding
        low, high = span(finding)
        for reason in finding.reasons:
            parts = [rule for rule, part in rules.items() if part in reason]
            assert any(low <= t <= high for rule in parts for t in broken[rule]), finding


Recorder = Callable[[str, Path], AbstractContextManager[None]]


def did_its_task(run: Mapping[str, Any], far: float | None = None) -> None:
    """It did all of it, or moved so far, soon, with faults, and violated nothing."""
    assert run["faults"]
    assert run["violations"] == {}
    if far is not None:
        assert run["moved"] >= far, run["path"][-1]
    else:
        assert run["succeeded"], run["path"][-1]
    assert run["judgements"] > 20
    assert run["simulated"] <= SECONDS


def drive(ros: gallery.Ros1 | gallery.Ros2, robot: str, path: Path, records: Recorder) -> None:
    record = path.with_suffix(".json")
    awaited = {"awaited": "/recorder/ready"} if isinstance(ros, gallery.Ros2) else {}
    with ros.running(), records(robot, path):
        ros.drive(robot, 1, PLANTED[robot].faults, record, **awaited)
    run = json.loads(record.read_text(encoding="utf-8"))
    file = path.with_suffix("") if path.suffix != ".bag" else path
    late, planted = lateness(file), "planted" in ros._models.name
    compare(robot, judged(robot, file, late), run["times"], planted, late)
    if not planted and (robot == "follow_person" or isinstance(ros, gallery.Ros1)):
        did_its_task(run)


@pytest.mark.parametrize(
    ("models", "robot"),
    [*(("planted", robot) for robot in PLANTED), ("right", "follow_person")],
    indirect=["models"],
    scope="module",
)
def test_faults_recorded_by_rosbag(robot: str, ros1: gallery.Ros1, tmp_path: Path) -> None:
    drive(ros1, robot, tmp_path / "run.bag", lambda name, path: rosbag(ros1, path, name))


@pytest.mark.parametrize(
    ("models", "robot", "kind"),
    [("planted", "line_follower", "mcap"), ("right", "follow_person", "db3")],
    indirect=["models"],
    scope="module",
)
def test_faults_recorded_in_ros_2(
    robot: str, kind: str, ros2: gallery.Ros2, tmp_path: Path
) -> None:
    drive(ros2, robot, tmp_path / f"run.{kind}", lambda name, path: recorder(ros2, path, name))
