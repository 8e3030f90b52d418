"""The guide of a package's own test comes to boundaries, silences and delays, where faults show."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from emit.bisimulation import Recording, compare
from emit.generated_code import controller_source, supervisor_of
from emit.judged_controllers import Robot, class_of, judged, judging_model, judging_modules
from emit.judged_supervisors import judged_supervisor
from ros_support import EXAMPLES

from robosc import pipeline

pytestmark = pytest.mark.slow

WATCHED = """
robot Watched {
    component Eye {
        outgoing message scan with identifier: "/scan", timeout: 0.5 s, type: double
        outgoing message sound with identifier: "/sound", timeout: 0.5 s, type: double
        behaviour {
            variable volts: double
            initial marked state on { on response from scan do volts := value / 10 }
        }
    }
    component Motor {
        incoming message drive with identifier: "/drive", type: none
        incoming message halt with identifier: "/halt", type: none
        behaviour {
            initial marked state rest { after 1.5 s goto ready }
            marked state ready { on request to halt goto rest }
        }
    }
    requirement drive needs Eye.volts > 13.2 and scan.fresh and sound.fresh and Motor.ready
    requirement halt needs scan.silent and sound.fresh
}
"""
"""Two silences of which each decides alone, a boundary behind a division, and a delay."""


@pytest.fixture
def watched(tmp_path: Path) -> Iterator[tuple[Any, str]]:
    supervisor = supervisor_of(WATCHED)
    with judging_modules(tmp_path, supervisor) as judge:
        yield judge, controller_source(supervisor)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("self.eye_volts > 13.2", "self.eye_volts >= 13.2"),
        ("13.2 and self.scan_fresh and self.sound_fresh", "13.2 and self.sound_fresh"),
        ("13.2 and self.scan_fresh and self.sound_fresh", "13.2 and self.scan_fresh"),
        ("not self.scan_fresh and self.sound_fresh", "not self.scan_fresh"),
        ("self.motor_entries += 1", "pass"),
        ('if self.motor == "rest":', "if False:"),  # it never takes the transition
    ],
)
def test_it_comes_to_boundaries_silences_and_delays(
    watched: tuple[Any, str], before: str, after: str
) -> None:
    judging, source = watched
    assert before in source
    assert judged(judging, source).faults == []
    assert judged(judging, source.replace(before, after, 1)).faults != []


def test_a_transition_that_waits_is_wanted_for_its_own_sake(watched: tuple[Any, str]) -> None:
    judging, source = watched
    judge = judged(judging, source)
    wanted = [text for text, _ in judge.guide.cases.wanted(judge.shadow)]
    assert "after 1 of Motor" in wanted
    assert not [text for text in judge.guide.unseen(judge.shadow) if "after" in text]


def test_a_silence_that_came_while_the_guide_thought_is_not_awaited(
    watched: tuple[Any, str],
) -> None:
    judging, source = watched
    judge = judged(judging, source)
    for key in judge.shadow.watched:
        for is_fresh in (True, False):
            judge.shadow.phase[key] = "fresh" if is_fresh else "silent"
            has_lapsed, _ = judge.lapse(key)
            assert has_lapsed() != is_fresh


def test_mutants_without_a_difference_are_equivalent(watched: tuple[Any, str]) -> None:
    judging, source = watched
    robot = Robot(judging, 1, lambda data: data)
    samples = robot.samples(8)

    def comparison(after: str) -> Any:
        mutant = source.replace("self.motor_entries += 1", after)
        return compare(class_of(source)(), class_of(mutant)(), samples, robot.topics, 30.0)

    assert comparison("self.motor_entries += 2")[1:] == (True, None)
    assert comparison("self.motor_entries += 0").difference is not None


def test_mutants_are_compared_with_a_recording_where_they_differ(
    watched: tuple[Any, str],
) -> None:
    judging, source = watched
    robot = Robot(judging, 1, lambda data: data)
    samples = robot.samples(8)
    called: set[str] = set()
    recording = Recording(class_of(source, called), called, samples, robot.topics, 30.0)

    def comparison(before: str, after: str, method: str) -> Any:
        start, rest = source.split(f"    def {method}(", 1)
        assert before in rest
        faulty = f"{start}    def {method}({rest.replace(before, after, 1)}"
        return recording.compare(class_of(faulty), method)

    assert recording.is_complete
    assert comparison("+= 1", "+= 2", "request_halt")[1:] == (True, None)
    for before, after in (("+= 1", "+= 0"), ('self.motor = "rest"', "pass")):
        difference = comparison(before, after, "request_halt").difference
        assert difference.endswith("request of Motor.halt")
    guard = comparison("not self.scan_fresh and", "", "requirement_2")
    assert guard.difference is not None


LANE = """
robot Lane {
    component Car[1..2] {
        incoming message go with identifier: "/car_{index}/go", type: none
        outgoing message there with identifier: "/car_{index}/there", type: none
        behaviour {
            initial marked state away { on request to go goto coming }
            state coming { on response from there goto inside }
            marked state inside { on request to go goto leaving }
            state leaving { on response from there goto away }
        }
    }
    requirement never all(c.inside or c.leaving for c in Car)
}
"""
"""Synthesis forbids a car to come while the other one is not away."""


@pytest.mark.parametrize(
    "guard",
    ["False", "self.car_1 == 'away'", "self.car_1 == 'away' or self.car_2 == 'away'"],
)
def test_it_knows_what_synthesis_forbids(tmp_path: Path, guard: str) -> None:
    """More than it forbids is as wrong as less."""
    supervisor = supervisor_of(LANE)
    source = controller_source(supervisor)
    method = "    def can_request_car_1_go(self):\n"
    assert method in source
    faulty = source.replace(method, f"{method}        return {guard}\n")
    with judging_modules(tmp_path, supervisor) as judging:
        judge = judged(judging, source)
        assert judge.faults == []
        assert not [text for text in judge.guide.unseen(judge.shadow) if "on response" in text]
        assert judged(judging, faulty).faults != []


@pytest.fixture(scope="module")
def two_robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    model = EXAMPLES / "two_robots" / "two_robots.rscd"
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    with judging_modules(tmp_path_factory.mktemp("two_robots"), supervisor) as judge:
        yield judge, controller_source(supervisor, model.name)


@pytest.mark.parametrize(
    ("method", "before", "after"),
    [
        ("on_response_of_robot_1_battery", "value < 0.3", "value <= 0.3"),
        ("on_feedback_of_robot_1_undock", "if not self.", "if self."),
        ("on_cancelled_of_robot_2_cross", 'self.robot_2 = "held_to_left"', "pass"),
    ],
)
def test_it_comes_to_every_event_where_it_matters(
    two_robots: tuple[Any, str], method: str, before: str, after: str
) -> None:
    """At the ends of long ways, and where a transition changes something."""
    judging, source = two_robots
    start, rest = source.split(f"    def {method}(", 1)
    assert before in rest.partition("    def ")[0]
    faulty = f"{start}    def {method}({rest.replace(before, after, 1)}"
    assert judged(judging, faulty).faults != []


def test_it_follows_the_controller_from_its_first_event(tmp_path: Path) -> None:
    """What is sent before any input depends on what nothing was heard of yet."""
    supervisor = pipeline.synthesize(
        pipeline.load(EXAMPLES / "line_follower" / "line_follower.rscd").robot
    )
    source = controller_source(supervisor)
    part = 'and self.distance_sensor == "sensing"'
    assert part in source
    with judging_modules(tmp_path, supervisor) as judging:
        faults = judged(judging, source.replace(part, ""), rounds=0).faults
    assert [text for text in faults if "request of ObstacleGrabber.grab against" in text], faults


SECTIONS = """
robot Sections {
    component Eye {
        outgoing message scan with identifier: "/scan", type: sensor_msgs/LaserScan
        behaviour {
            variable side: double
            variable total: double
            on response from scan
                do side := min(r for r in value.ranges[50..60]),
                    total := sum(r for r in value.ranges[50..60])
            initial marked state free {
                on response from scan if any(r < 0.2 for r in value.ranges[30..35]) goto blocked
            }
            marked state blocked {
                on response from scan if all(r > 0.3 for r in value.ranges[-20..20]) goto free
            }
        }
    }
    component Motor {
        incoming message turn with identifier: "/turn", type: std_msgs/Float64
        incoming message halt with identifier: "/halt", type: none
    }
    requirement turn needs Eye.free
    requirement halt needs Eye.side > 1 or isnan(Eye.total)
    provide turn with { data: max(-1, min(1, 4 * (0.44 - Eye.side))) }
}
"""
"""Places in arrays that decide, numbers that matter only in some data, and what is no number."""


@pytest.fixture(scope="module")
def sections(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    with judging_model(tmp_path_factory.mktemp("sections"), SECTIONS) as judging:
        yield judging


@pytest.mark.parametrize(
    ("before", "after"),
    [
        *((", 30, 35)", f", {first}, {last})") for first, last in ((29, 35), (31, 35), (30, 36))),
        *((", -20, 20)", f", {first}, {last})") for first, last in ((-21, 20), (-20, 19))),
        ("r_ < 0.2", "r_ <= 0.2"),
        ("r_ > 0.3", "r_ >= 0.3"),
        (", 50, 60)", ", 51, 60)"),
        ("4 * (0.44", "4.1 * (0.44"),
        ("least(1, 4", "least(1.1, 4"),
        ("greatest(-1, ", "greatest(-1.1, "),
        (" or is_not_a_number(self.eye_total)", ""),
    ],
)
def test_it_comes_to_places_in_arrays_and_to_choices_of_data(
    sections: tuple[Any, str], before: str, after: str
) -> None:
    judging, source = sections
    assert before in source
    assert judged(judging, source.replace(before, after)).faults != []


def test_it_comes_near_a_bound_that_a_scaled_integer_passes_in_steps(tmp_path: Path) -> None:
    """Tenths of volts are never within a small fixed distance beside the bound."""
    model = EXAMPLES / "kobuki" / "kobuki.rscd"
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    source = controller_source(supervisor)
    with judging_modules(tmp_path, supervisor) as judging:
        assert judged(judging, source.replace("13.2", "15.89"), seed=5).faults != []


@pytest.mark.parametrize("play", [judged, judged_supervisor])
@pytest.mark.parametrize(
    "model",
    [
        pytest.param(path, id=path.stem)
        for path in sorted(EXAMPLES.glob("**/*.rscd"))
        # This robot calls services only; goals are sent by the package's own test, on ROS.
        if not re.search(
            "^library |^ *outgoing action ", path.read_text(encoding="utf-8"), re.MULTILINE
        )
    ],
)
def test_it_is_content_with_the_examples(tmp_path: Path, play: Any, model: Path) -> None:
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    with judging_modules(tmp_path, supervisor) as judging:
        assert play(judging, controller_source(supervisor, model.name), rounds=10).faults == []


@pytest.mark.parametrize(
    ("method", "guard"),
    [
        ("can_request_car_1_go", "False"),
        ("can_request_car_1_go", "True"),
        ("on_response_of_car_2_there", "None"),
    ],
)
def test_it_knows_what_a_supervisor_has_to_let_pass(
    tmp_path: Path, method: str, guard: str
) -> None:
    supervisor = supervisor_of(LANE)
    source = controller_source(supervisor)
    start = re.search(rf"    def {method}\(.*\n", source)
    assert start is not None
    faulty = f"{source[: start.end()]}        return {guard}\n{source[start.end() :]}"
    with judging_modules(tmp_path, supervisor) as judging:
        judge = judged_supervisor(judging, source)
        assert judge.faults == []
        assert min(judge.passed["Car[1].go"], judge.blocked["Car[1].go"]) > 0
        assert judged_supervisor(judging, faulty).faults != []


def test_it_knows_which_components_block(tmp_path: Path) -> None:
    model = EXAMPLES / "navigation" / "navigation.rscd"
    supervisor = pipeline.synthesize(pipeline.load(model).robot)
    source = controller_source(supervisor, model.name)
    start, rest = source.split("    def partner_2_in_request_of_navigate(", 1)
    faulty = f"{start}    def partner_2_in_request_of_navigate({rest.replace('==', '!=', 1)}"
    with judging_modules(tmp_path, supervisor) as judging:
        for play in (judged, judged_supervisor):
            assert play(judging, source).faults == []
            assert play(judging, faulty).faults != []


@pytest.mark.parametrize(
    ("model", "before", "after"),
    [
        # A clock that runs on where no command follows, which is told only while the button is
        # pressed: no way leads there through states in which a goal is to be cancelled.
        (
            str(Path(__file__).with_name("clicked_points.rscd")),
            '"waiting"\n        self.navigator_entries += 1',
            '"waiting"',
        ),
        # The next message would change what the request is to carry.
        ("gallery/ball/ball.rscd", "not (self.detector_x < 0.22", "not (self.detector_x <= 0.22"),
        # The length of a vector: its fields are seldom equal.
        ("gallery/follow_person/follow_person.rscd", "distance > 0.8", "distance >= 0.8"),
        # A number in an assignment: most messages with this bit have the first one as well.
        ("kobuki/kobuki.rscd", 'has_bits(value["bumper"], 4)', 'has_bits(value["bumper"], 5)'),
    ],
)
def test_it_comes_to_what_is_seldom_told(
    tmp_path: Path, model: str, before: str, after: str
) -> None:
    supervisor = pipeline.synthesize(pipeline.load(EXAMPLES / model).robot)
    source = controller_source(supervisor)
    assert before in source
    with judging_modules(tmp_path, supervisor) as judging:
        assert judged(judging, source.replace(before, after, 1)).faults != []


def test_what_was_given_up_is_tried_again_when_there_is_nothing_else(tmp_path: Path) -> None:
    supervisor = pipeline.synthesize(pipeline.load(EXAMPLES / "kobuki/kobuki.rscd").robot)
    with judging_modules(tmp_path, supervisor) as judging:
        judge = judged_supervisor(judging, controller_source(supervisor), seed=2)
        assert [t for t in judge.guide.unseen(judge.shadow) if "did not lead there" in t] == []


def test_it_comes_to_cases_that_are_not_near_where_numbers_differ_at_each_visit(
    tmp_path: Path,
) -> None:
    # Where wheels are asked for, too, some draws of the judge do not come to it.
    gallery, model = EXAMPLES / "gallery", tmp_path / "maze.rscd"
    text = (gallery / "maze/maze.rscd").read_text(encoding="utf-8")
    before, _, rest = text.partition("    component Wheels {")
    wheelless = before + rest.partition("\n    }\n\n")[2].replace(" and Wheels.standing", "")
    model.write_text(wheelless, encoding="utf-8")
    (tmp_path / "gallery_msgs").symlink_to(gallery / "gallery_msgs")
    options = pipeline.Options(library_path=(gallery / "libraries",))
    supervisor = pipeline.synthesize(pipeline.load(model, options).robot)
    source = controller_source(supervisor)
    right = "least_of(section(value.ranges, -105, -75)) > 0.7"
    assert right in source
    with judging_modules(tmp_path, supervisor) as judging:
        assert judged_supervisor(judging, source.replace(right, right.replace(">", ">="))).faults
