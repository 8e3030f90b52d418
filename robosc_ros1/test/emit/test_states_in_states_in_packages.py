"""States in states in generated controllers, in the tests of their packages, and in exports."""

from __future__ import annotations

import random

import pytest
from emit.generated_code import supervisor_of
from emit.scripted_controllers import faults_of
from emit.test_cif import check
from emit.test_controller_follows_the_plant import Twin, walk_through
from nested_models import PARTS, nested_text, random_behaviour

from robosc.emit.export.dot import dot_text
from robosc.model.resolve import load
from robosc.source import Source

MODEL = """
robot Porter {
    component Base {
        outgoing message low with type: boolean
        outgoing message stop with type: none
        action dock with request: none, response: none, feedback: none links dock
        behaviour {
            variable turns: integer(0..3)
            variable seen: boolean
            on response from stop do seen := true
            initial marked state idle { on response from low if value goto docking }
            state docking {
                on response from stop do turns := 0 goto idle
                on response from low do seen := value
                after 100 ms if seen do seen := false goto docking
                transition if turns = 3 do turns := 0 goto idle
                initial state near {
                    on request to dock do turns := turns + 1 goto moving
                    on response from low if !value goto idle
                }
                state moving {
                    on response from dock goto idle
                    on error, cancel from dock goto near
                }
            }
        }
    }
    component Light { incoming message shine with type: none }
    requirement shine needs Base.docking and !Base.seen
    requirement dock needs !Base.seen
    interface dock use Test from actionlib
}
"""


@pytest.mark.parametrize("seed", range(3))
def test_the_controller_does_what_the_plant_does(seed: int) -> None:
    walk_through(Twin(MODEL), random.Random(seed))


@pytest.mark.parametrize("seed", range(8))
def test_random_ones_are_read_twice_and_exported(seed: int) -> None:
    """The supervisor, and the plant in CIF, do what the second reading says."""
    draw = random.Random(seed)
    robot = None
    while robot is None:  # from some state no marked one can be reached
        whole = random_behaviour(draw)
        text = PARTS % nested_text(whole, {place.path for place in whole.all()})
        requirement = f"requirement go needs !P.{draw.choice(whole.states).path} or P.last"
        robot, _ = load(Source("model.rscd", f"robot Test {{ {text} {requirement} }}"))
    check(robot)


@pytest.mark.slow
def test_the_test_of_the_package_agrees() -> None:
    assert faults_of(supervisor_of(MODEL)) == []


def test_the_picture_has_a_box_in_the_box() -> None:
    lines = [line.strip() for line in dot_text(supervisor_of(MODEL).plant.robot).split("\n")]
    box = lines.index('subgraph "cluster Base.docking" {')
    inside = lines[box : lines.index("}", box)]
    assert '"Base.docking.near" [label="near", peripheries=1];' in inside
    assert any(
        '-> "Base.idle"' in line and 'ltail="cluster Base.docking"' in line for line in lines
    )
