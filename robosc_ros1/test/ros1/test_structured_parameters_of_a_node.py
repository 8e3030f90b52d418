"""Parameters that are arrays and objects, as ROS 1 gives them: files, launch arguments, names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from ros1.stage import Puppet, Stage
from ros_support import Master, Workspace, run_robosc

NODE = "guide_controller"
POINT = "geometry_msgs/Point"
NUMBER = "std_msgs/Int16"


@pytest.fixture(scope="module")
def guide_workspace(make_workspace: Callable[[], Workspace]) -> Workspace:
    workspace = make_workspace()
    model = str(Path(__file__).with_name("guide.rscd"))
    where = ("--output", str(workspace.folder / "src"))
    done = run_robosc(("generate", model, *where), workspace.folder, {}, tested=False)
    assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.fixture
def guide(guide_workspace: Workspace, shared_master: Master) -> Stage:
    return Stage(guide_workspace, shared_master)


def asked_for(guide: Stage, puppet: Puppet, number: int, *launched: str) -> dict[str, float]:
    """Where the controller goes when it is launched with arguments, and asked for a spot."""
    puppet.do("listen", topic="/go", type=POINT)
    mark = puppet.mark
    command = ("roslaunch", NODE, f"{NODE}.launch", *launched)
    with guide.workspace.start(*command, master=guide.master):
        fields = {"data": number}
        puppet.begin("publish", topic="/ask", type=NUMBER, fields=fields, times=600, rate=10.0)
        point: dict[str, float] = puppet.hears("/go", since=mark)
    guide.master.forget(f"/{NODE}")
    guide.workspace.run("rosparam", "delete", f"/{NODE}", master=guide.master)
    return point


def test_a_file_tells_lists_of_objects(guide: Stage, puppet: Puppet, tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(
        "spots:\n  - {x: 1.0, y: 2.0}\n  - x: 4\nlevels: [7, 8.5]\nhome: {y: 6}\n"
    )
    found = asked_for(guide, puppet, 1, f"config:={tmp_path / 'mine.yaml'}")
    assert found == {"x": 4.0, "y": 7.0, "z": 6.0}


def test_arguments_of_the_launch_file_come_before_the_file(guide: Stage, puppet: Puppet) -> None:
    given = ("spots:=[{x: 1.0}, {x: 2.0}, {x: 5, y: 1}]", "levels:=[3]", "home:={x: 0, y: 2.5}")
    assert asked_for(guide, puppet, 2, *given) == {"x": 5.0, "y": 3.0, "z": 2.5}


def test_what_the_model_has_no_value_for_must_be_given(guide: Stage, puppet: Puppet) -> None:
    assert asked_for(guide, puppet, 0, "home:={y: -1}") == {"x": 3.0, "y": 1.5, "z": -1.0}
    done = guide.workspace.run("rosrun", NODE, NODE, master=guide.master, check=False)
    assert done.returncode == 2
    told = done.stdout + done.stderr
    assert "parameter ~home must be given: the model has no value for it" in told


@pytest.mark.parametrize(
    ("name", "value", "complaint"),
    [
        ("spots", "[{x: 1}, {z: 2}]", "~spots[1] must be an object with x, y"),
        ("spots", "[1]", "~spots[0] must be an object with x, y, not 1"),
        ("levels", "[1, true]", "~levels[1] must be a number, not True"),
        ("levels", "3", "~levels must be an array, not 3"),
        ("home", "[1, 2]", "~home must be an object with x, y"),
        ("home", "{x: far}", "~home.x must be a number, not 'far'"),
    ],
)
def test_wrong_shapes_are_refused_by_name(
    guide: Stage, name: str, value: str, complaint: str
) -> None:
    alias = f"refused_{name}_{abs(hash(value))}"
    guide.workspace.run("rosparam", "set", f"/{alias}/{name}", value, master=guide.master)
    done = guide.workspace.run(
        "rosrun", NODE, NODE, f"__name:={alias}", master=guide.master, check=False
    )
    told = done.stdout + done.stderr
    assert done.returncode == 2
    assert complaint in told and "Traceback" not in told
