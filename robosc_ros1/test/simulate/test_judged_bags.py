"""``robosc replay`` of bags: every fault that a recorded controller made is found, nothing else."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
from quick import quick_first

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from emit.golden_packages import GOLDEN
from ros_support import EXAMPLES, Completed
from runtime.schemas import validate
from simulate.recorded_runs import (
    EVENT_2,
    START,
    BagWriter,
    Recorded,
    Robot,
    Run,
    definitions_of,
)

from robosc.errors import UsageError
from robosc.runtime.core.recorder import Entry
from robosc.runtime.core.settings import Settings
from robosc.simulate.bags.bag_files import opened_bag
from robosc.simulate.bags.bag_run import BagRun, settings_of
from robosc.simulate.bags.judgement import Judgement, judge
from robosc.simulate.bags.judgement_report import judgement_document, judgement_text
from robosc.simulate.bags.recorded_messages import default_message, fill
from robosc.simulate.bags.recorded_names import recorded_names
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.recorded import Recording

Robosc = Callable[..., Completed]

MODEL = EXAMPLES / "line_follower" / "line_follower.rscd"
JITTER = 0.004
TOLERANCE = Settings().tolerance
KINDS = ("bag", "mcap", "db3")
LAWLESS = (
    ("move", "grab", "stop"),
    (),
    pytest.param(("move",), marks=pytest.mark.slow),
    pytest.param(("grab",), marks=pytest.mark.slow),
)
FOLLOWED = ("move", "stop", "grab")
"""What both versions of ROS show; services only with their events."""


def robot() -> Robot:
    """Obstacles come and go, and the sensor falls silent for a while."""
    return Robot(
        {
            "/distance": (0.05, lambda time, _: None if 8 < time < 9.5 else {
                "data": 0.2 if int(time * 0.7) % 3 == 0 else 0.8}),
            "/correction": (0.05, lambda _, random: {"data": random.uniform(-20, 20)}),
            "/no_line": (0.5, lambda _, random: {} if random.random() < 0.3 else None),
        }
    )  # fmt: skip


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(MODEL.read_text(), str(MODEL))


def definitions(kind: str) -> dict[str, str]:
    if kind == "bag":
        return dict(definitions_of("---\n---\n", "robot_common/Grabber", True))
    return dict(definitions_of("bool state\n---\n", "robot_common/LightBulbService", False))


def recorded(
    supervisor: Supervisor, folder: Path, kind: str, seconds: float = 20.0, **options: object
) -> Recorded:
    run = Run(supervisor, folder / f"run.{kind}", robot(), definitions(kind), **options)  # type: ignore[arg-type]
    return run.play(seconds)


def followed(supervisor: Supervisor, path: Path, tolerance: float) -> Iterator[Entry]:
    with opened_bag(path) as bag:
        run = BagRun(supervisor, bag, settings_of(supervisor.plant.robot))
        run.engine.role.tolerance = tolerance
        yield from run.entries(lambda *_: None)


def judged(supervisor: Supervisor, path: Path) -> Judgement:
    return judge(supervisor, path, (), lambda *_: None)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("lawless", LAWLESS)
def test_each_fault_of_a_controller_is_found_and_nothing_else(
    supervisor: Supervisor, tmp_path: Path, kind: str, lawless: tuple[str, ...]
) -> None:
    run = recorded(supervisor, tmp_path, kind, lawless=lawless, seed=3)
    # The stop command may be sent at any time.
    planted = [f for f in run.faults if f.name != "stop"]
    entries = followed(supervisor, run.path, tolerance=0.0)
    found = [e for e in entries if e.outcome != "applied"]
    assert [e.name for e in found] == [f.name for f in planted]
    assert [e.time - START for e in found] == pytest.approx([f.time for f in planted], abs=1e-3)
    assert bool(planted) is bool(lawless)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", quick_first(range(3), 1))
def test_messages_that_cross_are_no_faults(
    supervisor: Supervisor, tmp_path: Path, kind: str, seed: int
) -> None:
    run = recorded(supervisor, tmp_path, kind, jitter=JITTER, seed=seed)
    found = judged(supervisor, run.path)
    assert (found.findings, found.exit_code) == ([], 0)
    assert found.messages == run.messages
    assert not run.faults


def test_names_that_were_remapped(supervisor: Supervisor, tmp_path: Path) -> None:
    run = recorded(supervisor, tmp_path, "bag", lawless=("move", "grab"))
    text = MODEL.read_text()
    for name, other in (("/distance", "front"), ("/vel", "/base/vel"), ("/grab", "~grab")):
        assert f'"{name}"' in text
        text = text.replace(f'"{name}"', f'"{other}"')
    renamed = supervisor_of(text, str(MODEL))
    rules = ("front:=/distance", "/base/vel:=/vel", "~grab:=/grab")
    found = judge(renamed, run.path, (), lambda *_: None, rules)
    assert found.findings == judged(supervisor, run.path).findings != []
    with pytest.raises(UsageError, match="must be two names"):
        judge(renamed, run.path, (), lambda *_: None, ["/vel"])


def test_names_below_a_namespace(supervisor: Supervisor) -> None:
    names = recorded_names(supervisor.plant.robot, ["__ns:=/left", "__name:=driver"])
    assert [names.of(n) for n in ("/vel", "vel", "~vel", "~/vel")] == [
        "/vel", "/left/vel", "/left/driver/vel", "/left/driver/vel",
    ]  # fmt: skip
    assert recorded_names(supervisor.plant.robot).of("~vel") == "/line_follower_controller/vel"


@pytest.mark.parametrize("tolerance", [0.05, 0.2])
def test_messages_may_overtake_each_other_by_more(
    supervisor: Supervisor, tmp_path: Path, tolerance: float
) -> None:
    run = recorded(supervisor, tmp_path, "bag", jitter=0.09, seed=1)
    given = [f"tolerance={tolerance}"]
    found = judge(supervisor, run.path, given, lambda *_: None)
    assert bool(found.findings) is (tolerance < 0.1)


def test_faults_among_messages_that_cross(supervisor: Supervisor, tmp_path: Path) -> None:
    """What is forbidden for longer than messages cross is found, with its times and values."""
    run = recorded(supervisor, tmp_path, "bag", jitter=JITTER, lawless=("move",))
    found = judged(supervisor, run.path)
    spans = [(f.time - START - 0.01, f.until - START) for f in found.of("violation")]
    lasting = [fault.time for fault in run.lasting(TOLERANCE + 2 * JITTER)]
    assert lasting
    assert all(any(low <= time <= high for low, high in spans) for time in lasting)
    text = " ".join(found.of("violation")[0].reasons)
    assert "requirement move needs distance.fresh and free" in text
    assert "DistanceSensor.current is 0.2" in text


def test_what_the_command_line_tells(
    robosc: Robosc, supervisor: Supervisor, tmp_path: Path
) -> None:
    run = recorded(supervisor, tmp_path, "bag", lawless=("move",))
    done = robosc("replay", str(MODEL), "run.bag", "--json", "--junit", "run.xml")
    assert done.returncode == 1, done.stderr
    document = json.loads(done.stdout)
    validate(document, "judgement")
    assert document["messages"] == run.messages
    assert document["not_judged"] == [{"kind": "request", "name": "set_light_state"}]
    assert document["silences"] == {"distance": 1}
    suite = ElementTree.parse(tmp_path / "run.xml").getroot()
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    assert any("requirement move needs" in str(name) for name in failed)
    assert suite.get("failures") == str(len(failed))
    skipped = {str(case.get("name")): case.find("skipped") for case in suite}
    told = [reason for reason in skipped.values() if reason is not None]
    assert suite.get("skipped") == str(len(told))
    # The service is in no bag of ROS 1: nobody knows what was asked of it.
    for name, reason in skipped.items():
        if "requirement set_light_state" in name or name == "the run follows the model":
            assert reason is not None
            assert "the bag does not show set_light_state" in str(reason.get("message"))
    done = robosc("replay", str(MODEL), "run.bag")
    assert done.returncode == 1
    assert "violated: move was sent" in done.stdout


def test_commands_of_which_a_recording_has_nothing_are_not_called_kept(
    robosc: Robosc, tmp_path: Path
) -> None:
    """A message, a service or an action: only the sensor was recorded."""
    bag = BagWriter(tmp_path / "run.bag", {})
    for number in range(20):
        bag.write("/distance", "std_msgs/msg/Float32", START + number * 0.1, {"data": 2.0})
    bag.close()
    done = robosc("replay", str(MODEL), "run.bag", "--junit", "run.xml")
    assert done.returncode == 0, done.stderr
    suite = ElementTree.parse(tmp_path / "run.xml").getroot()
    passed = [str(case.get("name")) for case in suite if not len(case)]
    assert passed == ["the recording could be read as a whole"]
    told = {str(case.get("name")): case.find("skipped") for case in suite}
    (grab, *_) = [r for name, r in told.items() if name.startswith("LF-3 ")]
    assert grab is not None and grab.get("message") == "not in the recording: grab"


def test_a_run_without_faults(robosc: Robosc, supervisor: Supervisor, tmp_path: Path) -> None:
    recorded(supervisor, tmp_path, "bag", seconds=5.0)
    done = robosc("replay", str(MODEL), "run.bag")
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("follows the model\n")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("nowhere.bag",), "cannot read nowhere.bag: there is no such file"),
        (
            ("new.bag",),
            "cannot read new.bag: there is no such file, but new.bag.active: rosbag has not",
        ),
        (("text.mcap",), "text.mcap is no file of the format .mcap: it was not recorded by ROS"),
        (("run.bag", "--parameter", "speed=1"), "unknown parameter ~speed"),
        (
            ("events.log", "--junit", "x.xml"),
            "--junit, --parameter, --start and --remap are for bags",
        ),
    ],
)
def test_what_cannot_be_judged(
    robosc: Robosc, supervisor: Supervisor, tmp_path: Path, arguments: list[str], expected: str
) -> None:
    recorded(supervisor, tmp_path, "bag", seconds=0.5)
    (tmp_path / "text.mcap").write_text("This is no recording.\n" * 20)
    (tmp_path / "new.bag.active").touch()
    done = robosc("replay", str(MODEL), *arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: {expected}")


def test_a_bag_of_another_robot(supervisor: Supervisor, tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "other.bag", {})
    bag.write("/other", "std_msgs/msg/Float64", START, {"data": 1.0})
    bag.close()
    with pytest.raises(UsageError, match=r"no topic of LineFollower: it has /other"):
        judged(supervisor, tmp_path / "other.bag")


SMALL = """\
robot Small {
    component Sensor {
        outgoing message level with identifier: "/level", type: integer(0..3)
        outgoing message open with identifier: "/open", type: boolean
        behaviour {
            variable level: integer(0..3)
            on response from level do level := value
            initial marked state only {}
        }
    }
    component Lid {
        behaviour {
            initial marked state shut { on response from Sensor.open if value goto open }
            state open { on response from Sensor.open if !value goto shut }
        }
    }
    component Pump {
        incoming message slow with identifier: "/pump", type: double
        incoming message fast with identifier: "/pump", type: double
    }
    requirement slow needs Sensor.level < 2
    requirement fast needs Sensor.level = 0
    provide slow with 1.0
    provide fast with 2.0
}
"""


def small(tmp_path: Path, *messages: tuple[str, str, float, object]) -> Judgement:
    bag = BagWriter(tmp_path / "small.bag", {})
    for topic, type_, time, value in messages:
        bag.write(topic, f"std_msgs/msg/{type_}", START + time, {"data": value})
    bag.close()
    return judged(supervisor_of(SMALL, "small.rscd"), tmp_path / "small.bag")


def findings(found: Judgement) -> list[tuple[str, str, float, int]]:
    return [(f.sort, f.event, round(f.time - START, 3), f.count) for f in found.findings]


def test_where_a_run_leaves_the_model(tmp_path: Path) -> None:
    """A value outside its range, and data that are those of no command."""
    found = small(
        tmp_path,
        ("/level", "Int64", 0.0, 0),
        ("/level", "Int64", 1.0, 7),
        ("/pump", "Float64", 2.0, 1.0),
        ("/pump", "Float64", 3.0, 2.0),
        ("/level", "Int64", 4.0, 2),
        ("/pump", "Float64", 5.0, 1.0),
        ("/pump", "Float64", 5.1, 1.0),
    )
    assert findings(found) == [
        ("departure", "level.response", 1.0, 1),
        ("violation", "slow.request", 5.0, 2),
    ]
    assert found.findings[0].reasons == ["the value is 7, outside 0..3"]
    assert found.absent == ("/open",)


def test_a_command_before_what_allowed_it(tmp_path: Path) -> None:
    """Within the tolerance it counts as allowed; beyond it does not, and neither what came first
    when it was sent."""
    messages = [("/level", "Int64", 0.0, 2), ("/level", "Int64", 1.0, 0)]
    allowed = small(tmp_path, *messages, ("/pump", "Float64", 0.97, 1.0))
    assert findings(allowed) == []
    (tmp_path / "small.bag").unlink()
    refused = small(tmp_path, *messages, ("/pump", "Float64", 0.90, 1.0))
    assert findings(refused) == [("violation", "slow.request", 0.9, 1)]


def test_each_requirement_is_excused_by_itself(tmp_path: Path) -> None:
    """One that failed only just now is no reason against a command that another one forbids."""
    model = SMALL.replace(
        "    provide slow", "    requirement slow needs Lid.shut\n    provide slow"
    )
    bag = BagWriter(tmp_path / "small.bag", {})
    for topic, type_, time, value in (
        ("/level", "Int64", 0.0, 2),
        ("/open", "Bool", 2.0, True),
        ("/pump", "Float64", 2.02, 1.0),
        ("/pump", "Float64", 4.0, 1.0),
        ("/open", "Bool", 6.0, False),
        ("/pump", "Float64", 6.02, 1.0),
    ):
        bag.write(topic, f"std_msgs/msg/{type_}", START + time, {"data": value})
    bag.close()
    found = judged(supervisor_of(model, "small.rscd"), tmp_path / "small.bag")
    level, lid = "requirement slow needs Sensor.level < 2", "requirement slow needs Lid.shut"
    assert [f.about for f in found.findings] == [(level,), (level, lid), (level,)]


def test_a_bag_in_the_picture(supervisor: Supervisor, tmp_path: Path) -> None:
    """Its states are those of the monitor, and its forbidden commands have their reasons."""
    run = recorded(supervisor, tmp_path, "bag", lawless=("move",), seconds=8.0)
    recording = Recording(supervisor, str(run.path), Hub())
    documents = recording.documents
    for document in documents:
        validate(document, "event")
    assert recording.overview({})["departures"] == []
    forbidden = [d for d in documents if d["outcome"] == "forbidden"]
    assert forbidden and all(d["blocked_by"] for d in forbidden)
    sent = next(d for d in documents if d["event"]["name"] == "move")
    assert sent["event"]["value"]["linear"]["x"] in (0.2, 0.4)
    last = recording.moment({"at": len(documents)})["state"]
    with opened_bag(run.path) as bag:
        follower = BagRun(supervisor, bag, settings_of(supervisor.plant.robot))
        for _ in follower.entries(lambda *_: None):
            pass
    assert last["components"] == follower.engine.controller.components()


TWO = """\
robot Two {
    component Pump {
        incoming message start with identifier: "/start", type: none
        incoming message halt with identifier: "/halt", type: none
        behaviour {
            on request to halt goto off
            initial marked state off { on request to start goto running }
            state running {}
        }
    }
    component Arm {
        incoming message extend with identifier: "/extend", type: none
        incoming message retract with identifier: "/retract", type: none
        behaviour {
            on request to retract goto home
            initial marked state home { on request to extend goto extended }
            state extended {}
        }
    }
    requirement never Pump.running and Arm.extended
}
"""


def test_a_requirement_on_all_states(tmp_path: Path) -> None:
    """The command that breaks it would have been blocked, and it is violated from then on."""
    bag = BagWriter(tmp_path / "two.bag", {})
    for time, topic in [(0.0, "start"), (1.0, "extend"), (2.0, "halt"), (3.0, "retract")]:
        bag.write(f"/{topic}", "std_msgs/msg/Empty", START + time, {})
    bag.close()
    found = judged(supervisor_of(TWO, "two.rscd"), tmp_path / "two.bag")
    assert [(sort, event, count) for sort, event, _, count in findings(found)] == [
        ("blocked", "extend.request", 1),
        ("violation", "state", 1),
    ]
    assert "requirement never Pump.running and Arm.extended" in found.findings[1].reasons[0]


def test_requirements_on_all_states_that_are_not_judged_are_told(tmp_path: Path) -> None:
    """A bag of ROS 1 shows no services; whatever else the state depends on them is not known."""
    text = TWO.replace(
        "component Pump {",
        """component Valve {
        service open with identifier: "/open", type: std_srvs/Trigger
        behaviour {
            initial marked state shut { on request to open goto opening }
            state opening { on response, error from open goto shut }
        }
    }
    component Pump {""",
    )
    assert "Valve" in text
    bag = BagWriter(tmp_path / "two.bag", {})
    for time, topic in [(0.0, "start"), (2.0, "halt")]:
        bag.write(f"/{topic}", "std_msgs/msg/Empty", START + time, {})
    bag.close()
    found = judged(supervisor_of(text, "two.rscd"), tmp_path / "two.bag")
    never = "requirement never Pump.running and Arm.extended"
    assert f"not judged, since the whole state is not known: {never}" in judgement_text(found)
    document = judgement_document(found)
    validate(document, "judgement")
    assert {"kind": "state", "name": never} in document["not_judged"]
    whole = judged(supervisor_of(TWO, "two.rscd"), tmp_path / "two.bag")
    assert "not judged" not in judgement_text(whole)
    assert judgement_document(whole)["not_judged"] == []


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_what_the_controller_serves_is_not_followed(tmp_path: Path, kind: str) -> None:
    """The bag may have it nevertheless, and a call of the robot is no request of the controller."""
    model = GOLDEN / "models" / "orders.rscd"
    type_ = "std_srvs/srv/msg/SetBool"
    definitions = {
        f"{type_}_Request": "bool data\n",
        f"{type_}_Response": "bool success\nstring message\n",
        f"{type_}_Event": EVENT_2.format(type=type_),
    }
    bag = BagWriter(tmp_path / f"orders.{kind}", {} if kind == "bag" else definitions)
    bag.write("/door", "std_msgs/msg/Bool", START, {"data": True})
    if kind == "mcap":
        info = {"event_type": 0, "sequence_number": 1}
        bag.write("/order/_service_event", f"{type_}_Event", START + 1.0, {"info": info})
    bag.close()
    found = judged(supervisor_of(model.read_text(), str(model)), bag.path)
    assert found.unseen == ("order", "switch")
    assert found.absent == ("/lamp",)
    assert not found.findings and found.events == 1


@pytest.mark.ros
@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_a_bag_by_rosbag_itself(tmp_path: Path, compression: str) -> None:
    rosbag = pytest.importorskip("rosbag")
    from rospy import Duration, Time
    from std_msgs.msg import Float64, Int64

    path = tmp_path / "small.bag"
    with rosbag.Bag(str(path), "w", compression=compression) as bag:
        for number in range(200):
            time = Time.from_sec(START + number / 20)
            bag.write("/level", Int64(0 if number < 100 else 2), time)
            bag.write("/pump", Float64(1.0), time + Duration.from_sec(0.01))
    found = judged(supervisor_of(SMALL, "small.rscd"), path)
    # The first is too near to the message that forbids it.
    assert findings(found) == [("violation", "slow.request", 5.06, 99)]


WALKER = """\
robot Walker {
    component Legs {
        action walk with identifier: "/walk", within: 5 s, type: robot_common/Grabber
        behaviour {
            initial marked state standing { on request to walk goto walking }
            state walking {
                on response from walk goto standing
                on error from walk if reason = failed goto failed
                on error from walk if reason = rejected goto rejected
                on error from walk if reason = timeout goto late
                on error from walk if reason = lost goto lost
                on error from walk if reason in { absent, refused } goto standing
            }
            marked state failed { on request to walk goto walking }
            marked state rejected { on request to walk goto walking }
            marked state late { on request to walk goto walking }
            marked state lost { on request to walk goto walking }
        }
    }
}
"""


@pytest.mark.parametrize(
    ("statuses", "cancelled", "state"),
    [
        ([3], None, "standing"),
        ([4], None, "failed"),
        ([5], None, "rejected"),
        ([2], None, "failed"),  # others ended it
        ([2], 1.0, "failed"),
        ([2], 5.1, "late"),
        ([], None, "lost"),
    ],
)
def test_the_reason_of_an_error(
    tmp_path: Path, statuses: list[int], cancelled: float | None, state: str
) -> None:
    """By what the server told, and by the time after which it was cancelled."""
    bag = BagWriter(tmp_path / "walk.bag", definitions("bag"))
    goal = {"goal_id": {"id": "goal 1"}}
    bag.write("/walk/goal", "robot_common/msg/GrabberActionGoal", START, goal)
    array = "actionlib_msgs/msg/GoalStatusArray"
    one = default_message(bag.store, "actionlib_msgs/msg/GoalStatus")
    fill(bag.store, one, {**goal, "status": 1})
    for second in range(6):  # a server that keeps silent for 5 s is lost
        bag.write("/walk/status", array, START + 0.2 + second, {"status_list": [one]})
    if cancelled:
        bag.write("/walk/cancel", "actionlib_msgs/msg/GoalID", START + cancelled, goal["goal_id"])
    for status in statuses:
        ended = {"status": {**goal, "status": status}}
        bag.write("/walk/result", "robot_common/msg/GrabberActionResult", START + 5.3, ended)
    if not statuses:
        bag.write("/walk/status", array, START + 5.4, {"status_list": []})
    bag.write("/walk/status", array, START + 8.0, {"status_list": []})
    bag.close()
    supervisor = supervisor_of(WALKER, str(EXAMPLES / "walker.rscd"))
    with opened_bag(bag.path) as opened:
        run = BagRun(supervisor, opened, settings_of(supervisor.plant.robot))
        assert not run.unseen
        outcomes = {entry.outcome for entry in run.entries(lambda *_: None)}
    assert run.engine.controller.components() == {"Legs": state}
    assert outcomes == {"applied"}
