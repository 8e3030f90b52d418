"""``robosc replay`` of bags by models that decide on the data of commands, or correct them."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy
import pytest

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from ros_support import EXAMPLES, Completed
from runtime.schemas import validate
from simulate.recorded_runs import EVENT_2, GOAL, START, BagWriter

from robosc.errors import UsageError
from robosc.simulate.bags.bag_files import opened_bag
from robosc.simulate.bags.bag_run import BagRun, settings_of
from robosc.simulate.bags.judgement import Judgement, judge
from robosc.simulate.bags.recorded_messages import default_message, fill
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.recorded import Recording

Robosc = Callable[..., Completed]

LIMITER = EXAMPLES / "gallery" / "limiter" / "limiter.rscd"


@pytest.fixture(scope="module")
def limiter() -> Supervisor:
    return supervisor_of(LIMITER.read_text(), str(LIMITER))


def scan(writer: BagWriter, time: float, ahead: float) -> None:
    ranges = [*[ahead] * 61, *[3.0] * 238, *[ahead] * 61]
    seen = numpy.array(ranges, dtype="float32")
    data: dict[str, Any] = {"ranges": seen, "range_min": 0.1, "range_max": 10.0}
    writer.write("/scan", "sensor_msgs/msg/LaserScan", START + time, data)


def drive(writer: BagWriter, time: float, speed: float, turn: float) -> None:
    data = {"linear": {"x": speed}, "angular": {"z": turn}}
    writer.write("/cmd_vel", "geometry_msgs/msg/Twist", START + time, data)


def driven(folder: Path, kind: str, *commands: tuple[float, float, float]) -> Path:
    """Free until 5 s, then something stands 0.2 m ahead."""
    writer = BagWriter(folder / f"run.{kind}", {})
    for tick in range(200):
        scan(writer, tick * 0.05, 3.0 if tick < 100 else 0.2)
    for command in commands:
        drive(writer, *command)
    writer.close()
    return writer.path


def judged(supervisor: Supervisor, path: Path) -> Judgement:
    return judge(supervisor, path, (), lambda *_: None)


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_what_was_sent_and_what_a_supervisor_would_have_made_of_it(
    limiter: Supervisor, tmp_path: Path, kind: str
) -> None:
    path = driven(
        tmp_path,
        kind,
        (1.01, 0.3, 0.2),
        (2.01, 1.0, 0.6),
        (3.01, 0.5, 0.3),
        (4.01, -0.1, 0.0),
        (6.01, 0.1, 0.4),
        (7.01, 0.0, 0.4),
    )
    found = judged(limiter, path)
    assert [(f.sort, round(f.time - found.start, 3)) for f in found.findings] == [
        ("violation", 2.01),
        ("corrected", 2.01),
        ("violation", 4.01),
        ("violation", 6.01),
        ("corrected", 6.01),
    ]
    limited, backwards, near = (found.findings[i].reasons for i in (1, 2, 4))
    assert "linear.x 1.0 becomes 0.5, angular.z " in limited[0]
    assert "limiter.rscd:" in limited[0]
    assert backwards[0].startswith("requirement move needs value.linear.x >= 0.0")
    assert "linear.x 0.1" in near[0] and "becomes 0.0" in near[0]


def test_a_command_crosses_the_message_that_it_is_judged_by(
    limiter: Supervisor, tmp_path: Path
) -> None:
    # Just before and after what is ahead is seen, either may have been known to who sent it.
    path = driven(tmp_path, "bag", (4.98, 0.0, 0.4), (4.99, 0.4, 0.0), (5.02, 0.3, 0.0))
    assert judged(limiter, path).findings == []
    path.unlink()
    later = driven(tmp_path, "bag", (5.09, 0.3, 0.0))
    assert [f.sort for f in judged(limiter, later).findings] == ["violation", "corrected"]


def test_the_documents(limiter: Supervisor, tmp_path: Path, robosc: Robosc) -> None:
    path = driven(tmp_path, "bag", (2.01, 1.0, 0.6))
    done = robosc("replay", str(LIMITER), str(path), "--json")
    assert done.returncode == 1, done.stderr
    validate(document := json.loads(done.stdout), "judgement")
    assert [f["sort"] for f in document["findings"]] == ["violation", "corrected"]
    text = robosc("replay", str(LIMITER), str(path)).stdout
    assert "a supervisor would have corrected: move was sent: provide move with" in text
    assert "1 violation, 1 command to correct" in text


def test_the_page_follows_a_bag_whose_data_decide(tmp_path: Path) -> None:
    recording = Recording(supervisor_of(LIFTER, supervises=True), str(lifted(tmp_path, 2.5)), Hub())
    assert recording.overview({})["departures"] == []
    at = {d["event"]["name"]: n for n, d in enumerate(recording.documents, 1)}
    assert recording.documents[at["lift"] - 1]["event"]["value"] == {"angle": 2.5}
    state = recording.moment({"at": at["lift"]})["state"]
    assert state["variables"]["Lift.high"] is True


LIFTER = """
robot Lifter {
    component Lift {
        action lift with identifier: "/lift", request: Target, response: none, feedback: none
            links turn
        service lock with identifier: "/lock", type: std_srvs/SetBool
        behaviour {
            variable high: boolean
            initial marked state resting {
                on request to lift do high := value.angle > 1.0 goto lifting
            }
            state lifting {
                on response, error, cancelled from lift goto resting
            }
        }
    }
    requirement lift needs value.angle < 2.0
    requirement lock needs Lift.high => value.data
    datatype object Target { angle: double }
    interface turn use Turn from gallery_msgs
}
"""


def lifted(folder: Path, angle: float) -> Path:
    """A bag of ROS 1 with a goal."""
    name = "gallery_msgs/msg/Turn"
    definitions = {
        f"{name}Goal": "float64 angle\n",
        f"{name}ActionGoal": GOAL.format(type="gallery_msgs/Turn"),
    }
    writer = BagWriter(folder / f"goals{angle}.bag", definitions)
    data = {"goal_id": {"id": "1"}, "goal": {"angle": angle}}
    writer.write("/lift/goal", f"{name}ActionGoal", START, data)
    writer.close()
    return writer.path


def test_goals_are_judged_by_their_data(tmp_path: Path) -> None:
    supervisor = supervisor_of(LIFTER, supervises=True)
    assert judged(supervisor, lifted(tmp_path, 0.5)).findings == []
    (violation,) = judged(supervisor, lifted(tmp_path, 2.5)).findings
    assert violation.sort == "violation"
    assert violation.reasons[0].endswith("value.angle is 2.5")


@pytest.mark.parametrize("contents", [True, False])
def test_calls_of_ros_2_are_judged_by_their_data_where_they_are_recorded(
    tmp_path: Path, contents: bool
) -> None:
    type_ = "std_srvs/srv/msg/SetBool"
    definitions = {
        f"{type_}_Request": "bool data\n",
        f"{type_}_Response": "bool success\nstring message\n",
        f"{type_}_Event": EVENT_2.format(type=type_),
    }
    writer = BagWriter(tmp_path / "calls.mcap", definitions)
    for number, data in enumerate((True, False)):
        info = {"event_type": 0, "sequence_number": number}
        request = default_message(writer.store, f"{type_}_Request")
        fill(writer.store, request, {"data": data})
        event = {"info": info, "request": [request] if contents else []}
        writer.write("/lock/_service_event", f"{type_}_Event", START + number, event)
        answer = {"info": {**info, "event_type": 3}}
        writer.write("/lock/_service_event", f"{type_}_Event", START + number + 0.2, answer)
    writer.close()
    text = LIFTER.replace("Lift.high => value.data", "value.data")
    supervisor = supervisor_of(text, supervises=True)
    if not contents:
        with pytest.raises(UsageError, match="4 messages of /lock/_service_event tell of no event"):
            judged(supervisor, writer.path)
        return
    found = judged(supervisor, writer.path)
    assert [round(f.time - START, 3) for f in found.findings] == [1.0]


def test_goals_of_ros_2_are_not_judged_by_what_a_bag_does_not_show(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / "goals.mcap", {})
    writer.write("/lift/_action/status", "action_msgs/msg/GoalStatusArray", START, {})
    writer.write("/lamp", "std_msgs/msg/Empty", START, {})
    writer.close()
    lamp = 'incoming message lamp with identifier: "/lamp", type: none\n        behaviour {'
    found = judged(supervisor_of(LIFTER.replace("behaviour {", lamp), supervises=True), writer.path)
    assert "lift" in found.unseen and ("lift", "request") in found.unjudged


def test_an_error_of_the_engine_ends_the_replay(tmp_path: Path, limiter: Supervisor) -> None:
    with opened_bag(driven(tmp_path, "bag")) as bag:
        run = BagRun(limiter, bag, settings_of(limiter.plant.robot))
        run.engine.invoke(lambda: {}["missing"])
        with pytest.raises(KeyError, match="missing"):
            list(run.entries(lambda *_: None))


BEAT = """
robot Cart {{
    component Base {{
        outgoing message beat with identifier: "/beat", timeout: 10 s, type: {type}
        incoming message go with identifier: "/go", type: double
    }}
    requirement go needs beat.fresh
    provide go with 0.5
    datatype enum Level from double to {{ value > 0.5 -> high default -> low }}
}}
"""


@pytest.mark.parametrize("kind", ["bag", "mcap"])
@pytest.mark.parametrize(
    ("type_", "recorded", "data"),
    [
        ("boolean", "Bool", True),
        ("integer", "Int16", 7),
        ("integer(0..9)", "Int16", 7),
        ("double", "Float32", 0.5),
        ("string", "String", "on"),
        ("Level", "Float32", 0.5),
    ],
)
def test_a_heartbeat_whose_data_nobody_reads(
    tmp_path: Path, kind: str, type_: str, recorded: str, data: Any
) -> None:
    writer = BagWriter(tmp_path / f"run.{kind}", {})
    for second in range(3):
        writer.write("/beat", f"std_msgs/msg/{recorded}", START + second, {"data": data})
        writer.write("/go", "std_msgs/msg/Float32", START + second + 0.5, {"data": 0.5})
    writer.close()
    found = judged(supervisor_of(BEAT.format(type=type_)), writer.path)
    assert [(f.event, f.reasons) for f in found.findings] == []
    assert (found.events, found.commands) == (6, 3)


def test_a_number_outside_its_range_that_nobody_reads_is_found(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / "run.bag", {})
    writer.write("/beat", "std_msgs/msg/Int16", START, {"data": 11})
    writer.close()
    found = judged(supervisor_of(BEAT.format(type="integer(0..9)")), writer.path)
    assert [(f.sort, f.event) for f in found.findings] == [("departure", "beat.response")]


MOVER = """
robot Mover {{
    component Base {{
        incoming message move with identifier: "/move", type: {type}
    }}
    {statements}
    stop with nothing
}}
"""


def moved(folder: Path, kind: str, type_: str, *sent: Any) -> Path:
    writer = BagWriter(folder / f"run.{kind}", {})
    for second, data in enumerate(sent):
        writer.write("/move", f"std_msgs/msg/{type_}", START + 2 * second, {"data": data})
    writer.close()
    return writer.path


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_arrays_are_corrected_as_they_would_arrive(tmp_path: Path, kind: str) -> None:
    statements = """
        requirement move needs all(x <= 0.5 for x in value.data)
        provide move with { data: [min(x, 0.5) for x in value.data] }
    """
    model = MOVER.format(type="std_msgs/Float32MultiArray", statements=statements)
    sent = [numpy.array(one, dtype="float32") for one in ([], [0.25, 0.5], [0.25, 0.75])]
    path = moved(tmp_path, kind, "Float32MultiArray", *sent)
    found = judged(supervisor_of(model, supervises=True), path)
    assert [(f.sort, f.time - START) for f in found.findings] == [
        ("violation", 4.0),
        ("corrected", 4.0),
    ]
    assert found.findings[1].reasons[0].endswith("data [0.25, 0.75] becomes [0.25, 0.5]")


def test_what_was_sent_is_judged_by_its_own_data(tmp_path: Path) -> None:
    """A correction that is refused itself: what it makes of a command was never sent."""
    statements = "requirement move needs value <= 0.5 provide move with value * 2"
    model = MOVER.format(type="double", statements=statements)
    path = moved(tmp_path, "bag", "Float32", 0.125, 0.375, 0.625)
    found = judged(supervisor_of(model, supervises=True), path)
    assert [(f.sort, f.time - START) for f in found.findings] == [
        ("corrected", 0.0),
        ("blocked", 2.0),
        ("violation", 4.0),
    ]
    blocked, violated = (f.reasons[0] for f in found.findings[1:])
    assert blocked.startswith("data 0.375 becomes 0.75: requirement move needs value <= 0.5 (")
    assert blocked.endswith("value is 0.75")
    assert violated.endswith("value is 0.625")


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_arrays_of_messages_are_corrected_as_they_would_arrive(tmp_path: Path, kind: str) -> None:
    type_ = "trajectory_msgs/msg/JointTrajectory"
    statements = """
        provide move with {
            header: { stamp: now() },
            points: [
                { velocities: [min(v, 0.5) for v in p.velocities], time_from_start: 1.5 s }
                for p in value.points
            ]
        }
    """
    writer = BagWriter(tmp_path / f"run.{kind}", {})
    points = []
    for speeds in ([0.25], [0.25, 0.75]):
        one = default_message(writer.store, "trajectory_msgs/msg/JointTrajectoryPoint")
        points.append(fill(writer.store, one, {"velocities": numpy.array(speeds)}))
    writer.write("/move", type_, START, {"points": points})
    writer.write("/move", type_, START + 2, {"points": []})
    writer.close()
    model = MOVER.format(type="trajectory_msgs/JointTrajectory", statements=statements)
    (found,) = judged(supervisor_of(model, supervises=True), writer.path).findings
    assert (found.sort, found.time) == ("corrected", START)
    _, _, made = found.reasons[0].partition(" becomes ")
    empty = "{{'positions': [], 'velocities': {}, 'accelerations': [], 'effort': [], {}}}"
    time = "'time_from_start': {'sec': 1, 'nanosec': 500000000}"
    assert made == f"[{empty.format([0.25], time)}, {empty.format([0.25, 0.5], time)}]"


@pytest.mark.parametrize("header", ["", "std_msgs/Header header\n"])
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_basic_types_of_messages_that_only_the_recording_defines(
    tmp_path: Path, kind: str, header: str
) -> None:
    """Which field it is that a ``double`` links is not known when the controller is made."""
    model = """
        robot Cart {
            component Base {
                outgoing message level with identifier: "/level", type: double links number
                incoming message go with identifier: "/go", type: double links number
                behaviour {
                    variable level: double
                    initial marked state reading { on response from level do level := value }
                }
            }
            requirement go needs Base.level > 1.0
            provide go with min(value, 3.0)
            stop with nothing
            interface number use Number from unknown_number_msgs
        }
    """
    type_ = "unknown_number_msgs/msg/Number"
    writer = BagWriter(tmp_path / f"run.{kind}", {type_: f"{header}float64 x\n"})
    for second, (topic, number) in enumerate(
        [("level", 0.5), ("go", 2.0), ("level", 1.5), ("go", 2.0), ("go", 4.0)]
    ):
        writer.write(f"/{topic}", type_, START + second, {"x": number})
    writer.close()
    found = judged(supervisor_of(model, supervises=True), writer.path).findings
    assert [(f.sort, f.time - START) for f in found] == [("violation", 1.0), ("corrected", 4.0)]
    assert found[1].reasons[0].endswith("x 4.0 becomes 3.0")
