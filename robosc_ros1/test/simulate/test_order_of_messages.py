"""``robosc replay`` of bags in which messages overtook each other, and the robot's state depends on
their order: no order that is possible is a fault, and faults are found in all of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from quick import quick_first

pytest.importorskip("rosbags")

from emit.generated_code import supervisor_of
from runtime.schemas import validate
from simulate.recorded_runs import START, BagWriter, Fault, Robot, Run
from simulate.test_judged_bags import MODEL, TOLERANCE, definitions, judged, robot

from robosc.emit.supervisor.commuting import not_commuting
from robosc.simulate.bags.bag_files import opened_bag
from robosc.simulate.bags.bag_run import BagRun, settings_of
from robosc.simulate.bags.judgement import Finding, Judgement, judge
from robosc.supervisor import Supervisor
from robosc.view.hub import Hub
from robosc.view.recorded import Recording

JITTER = 0.9 * TOLERANCE

CART = """\
robot Cart {
    component Sensor {
        outgoing message range with identifier: "/range", timeout: 300 ms, type: double
        outgoing message light with identifier: "/light", type: boolean
        behaviour {
            variable near: boolean
            variable bright: boolean
            on response from range do near := value < 1.0
            on response from light do bright := value
            initial marked state only {}
        }
    }
    component Mode {
        outgoing message order with identifier: "/order", type: integer(0..1)
        behaviour {
            initial marked state waiting {
                on response from order if value = 1 and !Sensor.near goto driving
                on response from order if value = 1 and Sensor.near goto creeping
            }
            state driving {
                on response from order if value = 0 goto waiting
                after 700 ms goto creeping
            }
            state creeping {
                on response from order if value = 0 goto waiting
                on timeout from range goto waiting
            }
        }
    }
    component Wheels {
        incoming message fast with identifier: "/fast", type: none
        incoming message slow with identifier: "/slow", type: none
    }
    component Lamp {
        incoming message shine with identifier: "/shine", type: none
    }
    component Grabber {
        action grab with identifier: "/grab", type: robot_common/Grabber
        behaviour {
            initial marked state idle {
                on request to grab goto grabbing
            }
            state grabbing {
                on response from grab goto looking
                on error from grab goto looking
                on cancelled from grab goto looking
            }
            state looking {
                on response from range goto idle
            }
        }
    }
    requirement grab needs Mode.waiting and range.fresh
    requirement fast needs Mode.driving and range.fresh
    requirement slow needs Mode.creeping
    requirement shine needs !Sensor.bright
}
"""


def cart() -> Robot:
    """Orders come now and then, and the sensor falls silent for a while."""
    return Robot(
        {
            "/range": (0.05, lambda time, random: None if 8 < time % 20 < 9 else {
                "data": random.choice([0.5, 0.5, 2.0])}),
            "/light": (0.25, lambda _, random: {"data": random.random() < 0.5}),
            "/order": (0.11, lambda _, random: {
                "data": random.choice([0, 1, 1])} if random.random() < 0.5 else None),
        },
        call_seconds=(0.05, 0.3),
    )  # fmt: skip


ROBOTS = {"cart": (CART, cart, "fast"), "line": (MODEL.read_text(), robot, "move")}


@pytest.fixture(scope="module", params=ROBOTS)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def supervisor(name: str) -> Supervisor:
    return supervisor_of(ROBOTS[name][0], str(MODEL))


@pytest.mark.parametrize("seed", quick_first(range(8), 2))
def test_messages_that_overtake_each_other_are_no_faults(
    name: str, supervisor: Supervisor, tmp_path: Path, seed: int
) -> None:
    played = ROBOTS[name][1]()
    run = Run(supervisor, tmp_path / "run.bag", played, definitions("bag"), seed, JITTER)
    recorded = run.play(30.0)
    found = judged(supervisor, recorded.path)
    assert found.findings == []
    assert found.reordered or name == "line"  # there, the next scan mostly makes up for it


@pytest.mark.parametrize("seed", quick_first(range(8), 2))
def test_faults_among_messages_that_overtake_each_other(
    name: str, supervisor: Supervisor, tmp_path: Path, seed: int
) -> None:
    _, played, lawless = ROBOTS[name]
    path = tmp_path / "run.bag"
    run = Run(
        supervisor, path, played(), definitions("bag"), seed, JITTER, (lawless,),
        lambda time: 5 < time % 10 < 7,
    )  # fmt: skip
    recorded = run.play(30.0)
    found = judged(supervisor, recorded.path)

    def about(fault: Fault, finding: Finding) -> bool:
        low, high = finding.time - START - 2 * JITTER, finding.until - START + 2 * JITTER
        return low <= fault.time <= high

    lasting = recorded.lasting(TOLERANCE + 2 * JITTER)
    assert lasting
    assert all(any(about(fault, finding) for finding in found.findings) for fault in lasting)
    assert all(
        any(about(fault, finding) for fault in recorded.faults) for finding in found.findings
    )


def two_orders(folder: Path, apart: float) -> tuple[Supervisor, Path]:
    """The order to drive comes before the sensor says that the way is free, and then the cart
    drives fast: it had heard the sensor first."""
    bag = BagWriter(folder / "run.bag", {})
    bag.write("/range", "std_msgs/msg/Float64", START, {"data": 0.5})
    bag.write("/order", "std_msgs/msg/Int64", START + 0.2, {"data": 1})
    for number in range(4):
        time = START + 0.2 + apart + 0.1 * number
        bag.write("/range", "std_msgs/msg/Float64", time, {"data": 2.0})
        bag.write("/fast", "std_msgs/msg/Empty", time + 0.06, {})
    bag.close()
    return supervisor_of(CART, str(MODEL)), bag.path


@pytest.mark.parametrize("apart", [0.8 * TOLERANCE, 1.2 * TOLERANCE])
def test_messages_overtake_each_other_by_no_more_than_the_tolerance(
    tmp_path: Path, apart: float
) -> None:
    supervisor, path = two_orders(tmp_path, apart)
    found: Judgement = judged(supervisor, path)
    is_possible = apart < TOLERANCE
    assert [f.count for f in found.findings] == ([] if is_possible else [4])
    assert found.reordered == is_possible


@pytest.mark.parametrize("apart", [0.8 * TOLERANCE, 1.2 * TOLERANCE])
def test_a_requirement_on_states_that_is_violated_for_a_moment(
    tmp_path: Path, apart: float
) -> None:
    """The light goes out when the cart begins to drive; it may be heard a little later."""
    model = CART.replace(
        "    requirement shine needs",
        "    requirement never (Mode.driving and Sensor.bright)\n    requirement shine needs",
    )
    bag = BagWriter(tmp_path / "run.bag", {})
    bag.write("/range", "std_msgs/msg/Float64", START, {"data": 2.0})
    bag.write("/light", "std_msgs/msg/Bool", START, {"data": True})
    bag.write("/order", "std_msgs/msg/Int64", START + 1.0, {"data": 1})
    bag.write("/light", "std_msgs/msg/Bool", START + 1.0 + apart, {"data": False})
    bag.close()
    found = judged(supervisor_of(model, str(MODEL)), bag.path)
    times = [round(f.time - START, 3) for f in found.findings]
    assert times == ([] if apart < TOLERANCE else [1.0])


def test_a_silence_is_not_before_the_message_that_it_follows(tmp_path: Path) -> None:
    """Also where messages may cross by more than the timeout: the silence goes on."""
    model = """
robot Rover {
    component Sensor {
        outgoing message depth with identifier: "/depth", timeout: 0.3 s, type: double
        outgoing message order with identifier: "/order", type: boolean
        behaviour {
            initial marked state idle {
                on response from order if value goto busy
                on response from depth if value > 9.0 goto busy
            }
            marked state busy {
                on response from order if !value goto idle
            }
        }
    }
    component Motor { incoming message move with identifier: "/move", type: none }
    requirement move needs Sensor.busy and depth.fresh
}
"""
    bag = BagWriter(tmp_path / "run.bag", {})
    for step in range(60):
        time = START + 0.05 * step
        if step < 20 or step > 50:
            bag.write("/depth", "std_msgs/msg/Float64", time, {"data": 1.0})
        if step % 5 == 0:
            bag.write("/order", "std_msgs/msg/Bool", time + 0.01, {"data": True})
        if step > 5:
            bag.write("/move", "std_msgs/msg/Empty", time + 0.02, {})
    bag.close()
    found = judge(supervisor_of(model), bag.path, ["tolerance=0.325"], lambda *_: None)
    (violation,) = found.findings
    # The last depth came at 0.95 s, the next at 2.55 s.
    assert violation.time - START == pytest.approx(0.95 + 0.3 + 0.325, abs=0.06)
    assert violation.until - START == pytest.approx(2.55 - 0.325, abs=0.06)
    assert not found.reordered


def test_the_picture_shows_the_state_after_the_order_that_is_possible(tmp_path: Path) -> None:
    supervisor, path = two_orders(tmp_path, 0.8 * TOLERANCE)
    recording = Recording(supervisor, str(path), Hub())
    assert recording.overview({})["departures"] == []
    (document,) = [d for d in recording.documents if d.get("reordered")]
    validate(document, "event")
    assert document["effect"] == {"components": {"Mode": "driving"}}
    last = recording.moment({"at": len(recording.documents)})["state"]
    with opened_bag(path) as bag:
        run = BagRun(supervisor, bag, settings_of(supervisor.plant.robot))
        for _ in run.entries(lambda *_: None):
            pass
    assert last["components"] == run.engine.controller.components()
    assert last["components"]["Mode"] == "driving"


def test_what_commutes_is_in_no_group_or_in_another() -> None:
    """The light is read by a requirement alone; what a command with a state needs belongs to it."""
    groups = not_commuting(supervisor_of(CART, str(MODEL)))
    (group,) = groups
    assert group == (
        "Grabber.grab", "Mode", "Mode.order", "Sensor.range", "Wheels.fast", "Wheels.slow",
    )  # fmt: skip
    line = not_commuting(supervisor_of(MODEL.read_text(), str(MODEL)))
    assert len(line) == 2  # the lamp has nothing to do with the wheels
