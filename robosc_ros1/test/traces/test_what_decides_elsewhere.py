"""What scripts show of answers that are refused, of chosen elements, of edges elsewhere, and to monitors."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.scripted_controllers import faults_of, scripts_of, tells_apart
from ros_support import EXAMPLES, REPOSITORY

from robosc import pipeline
from robosc.traces.scripts import choose

REFUSED = """
robot Refused {
    interface heat use Heat from own_msgs
    datatype object Nothing { x: integer }
    datatype object Answer { success: boolean message: string }
    component Oven {
        service heat with expect: value.success, request: Nothing, response: Answer links heat
        incoming message lamp with type: boolean
        behaviour {
            initial marked state asking {
                on error from heat if reason = refused and value.message = "hot" goto hot
                on error from heat else goto other
            }
            marked state hot {}
            marked state other {}
        }
    }
    requirement lamp needs Oven.hot
    provide lamp with true
    provide heat with { x: 1 }
}
"""


def test_numbers_and_texts_of_refused_answers_are_sent() -> None:
    assert any("expect sent lamp.request" in text for text in scripts_of(supervisor_of(REFUSED)))


CHOSEN = """
robot Chosen {
    interface scan use Scan from own_msgs
    datatype object Scan { ranges: array(double) }
    component Laser {
        outgoing message scan with type: Scan links scan
        behaviour {
            variable front: double
            initial marked state on_ {
                on response from scan do
                    front := min(r for r in value.ranges if r > 0.05) else 0.0
            }
        }
    }
    component Base { incoming message drive with type: boolean }
    requirement drive needs Laser.front > 0.4
    provide drive with true
}
"""


def test_what_chooses_elements_is_tried_at_its_number() -> None:
    """The drive depends on 0.4 alone, so only the variable tells."""
    assert faults_of(supervisor_of(CHOSEN), "r_ > 0.05", "r_ >= 0.05")
    assert faults_of(supervisor_of(CHOSEN), "r_ > 0.05", "r_ > 0.11")


AROUND = """
robot Around {
    component Laser {
        outgoing message scan with identifier: "/scan", type: sensor_msgs/LaserScan
        behaviour {
            variable front: double
            variable rear: double
            variable rays: integer
            initial marked state on_ {
                on response from scan do
                    front := min(r for r in sector(value, -0.5, 0.5) if r > 0.05) else 0.0,
                    rear := min(r for r in sector(value, 2.64, -2.64) if r > 0.05) else 0.0,
                    rays := length(sector(value, -0.5, 0.5))
            }
        }
    }
    component Base { incoming message drive with type: boolean }
    requirement drive needs Laser.front > 0.4
    provide drive with true
}
"""


def test_scans_that_go_around_show_where_a_sector_ends() -> None:
    """The ray before it is at -1.0; of the second time around, one is at -0.57."""
    assert faults_of(supervisor_of(AROUND), "-0.5, 0.5)", "-0.65, 0.5)")


OVERLAP = """
robot Overlap {
    interface trip use Trip from own_msgs
    datatype object Nothing { x: integer }
    component Battery {
        outgoing message charge with type: double
        behaviour {
            variable level: double = 1.0
            initial marked state on_ { on response from charge do level := value }
        }
    }
    component Mission {
        action go with request: Nothing, response: Nothing, feedback: Nothing links trip
        action dock with request: Nothing, response: Nothing, feedback: Nothing links trip
        behaviour {
            initial marked state driving performs go with { x: 1 } then goto driving {
                transition if Battery.level < 0.2 goto docking
                retry goto driving
            }
            state docking performs dock with { x: 2 } then goto docked { retry goto docking }
            marked state docked { transition if Battery.level >= 0.9 goto driving }
        }
    }
}
"""


def test_edges_on_one_line_are_looked_at_one_by_one_where_they_would_show() -> None:
    """Beside a low battery, an internal transition leads on to the right state at once."""
    right = 'if self.mission == "driving performing" and self.go_cancelling:'
    assert faults_of(supervisor_of(OVERLAP), right, "if self.go_cancelling:")


ENDING = """
robot Ending {
    component F {
        outgoing action task with identifier: "/task", type: move_base_msgs/MoveBase
        outgoing message ok with identifier: "/ok", type: boolean
        behaviour {
            variable may: boolean
            on response from ok do may := value
            initial marked state free { on request from task goto work }
            state work { on response to task goto free on cancel from task goto over }
            state over { on error to task if may goto free on response to task goto free }
        }
    }
}
"""


def test_reasons_are_told_again_where_guards_of_other_places_hold() -> None:
    """In work, only that F blocks the error tells that may does not suffice."""
    supervisor = supervisor_of(ENDING, supervises=True)
    assert faults_of(supervisor, 'return self.f == "over" and self.f_may', "return self.f_may")


CRANE = REPOSITORY / "robosc_ros1" / "test" / "ros2" / "models" / "crane.rscd"
LIMITER = EXAMPLES / "gallery" / "limiter" / "limiter.rscd"


@pytest.mark.parametrize("model", [CRANE, LIMITER], ids=lambda model: model.stem)
def test_monitors_of_corrected_commands_have_runs(model: Path) -> None:
    """What synthesis takes apart by what commands carry is one command again."""
    libraries = (EXAMPLES / "gallery" / "libraries",)
    options = pipeline.Options(supervises=True, library_path=libraries)
    traces = choose(pipeline.synthesize(pipeline.load(model, options).robot), follows=True)
    assert any(run.cases for run in traces.runs)


def test_what_decides_corrections_is_shown() -> None:
    """Each condition of a correction, and each piece of its data, where it makes a difference."""
    libraries = (EXAMPLES / "gallery" / "libraries",)
    options = pipeline.Options(supervises=True, library_path=libraries)
    supervisor = pipeline.synthesize(pipeline.load(LIMITER, options).robot)
    source, scripts = controller_source(supervisor), scripts_of(supervisor)
    for right, wrong in (
        ('value["linear.x"] > 0.0 and self.laser_ahead', "self.laser_ahead"),
        ("self.laser_ahead < 0.25:", "self.laser_ahead <= 0.25:"),
        ('        if value["linear.x"] > 0.0:', '        if value["linear.x"] >= 0.0:'),
        ("self.laser_ahead - 0.15, 0.5)", "self.laser_ahead - 0.15, 0.7)"),
        ("self.laser_beside),", "self.laser_ahead),"),
    ):
        assert right in source
        assert tells_apart(supervisor, scripts, source.replace(right, wrong)), wrong


RETRIES = """
robot Mission {
    interface link use Work from some_package
    component Far {
        action go with request: integer, response: none, feedback: none links link
        outgoing message near with type: none
        behaviour {
            initial marked state out {
                initial state there performs go with 1 then goto back {
                    retry 2 times else goto lost
                }
                marked state back performs go with 2 then goto there { retry 1 times else goto lost }
                on response from near goto lost
            }
            marked state lost { on response from near goto out }
        }
    }
}
"""


def test_counts_of_errors_are_told_where_they_begin_anew() -> None:
    """They would show only after all further tries; where they are 0, nothing sets them to 0."""
    supervisor = supervisor_of(RETRIES)
    source, scripts = controller_source(supervisor), scripts_of(supervisor)
    begins_anew = [found.end() - 1 for found in re.finditer(r"retries = 0(?=\n)", source)]
    for at in begins_anew:
        assert tells_apart(supervisor, scripts, f"{source[:at]}1{source[at + 1 :]}"), source[:at]
    assert len(begins_anew) == 8


def test_time_passes_for_monitors() -> None:
    robot = pipeline.load(EXAMPLES / "door" / "door.rscd", pipeline.Options(supervises=True)).robot
    traces = choose(pipeline.synthesize(robot), follows=True)
    shown = {text for case, text in traces.cases.items() if case in traces.shown}
    assert "position.timeout while fresh" in shown
    silent = [line for run in traces.runs for line in run.lines if line.text.startswith("wait")]
    assert any("position.silent" in line.expected for line in silent)
