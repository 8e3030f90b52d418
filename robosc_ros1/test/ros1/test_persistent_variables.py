"""What stays when a ROS 1 node is killed and started again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from ros1.stage import Puppet
from ros_support import Master, Workspace, await_condition, run_robosc

MODES = ("controller", "supervisor", "monitor")
NODE = "tour_controller"
MODEL = Path(__file__).parents[1] / "ros2" / "models" / "tour.rscd"


@pytest.fixture(scope="module")
def tour(make_workspace: Callable[[], Workspace]) -> Workspace:
    workspace = make_workspace()
    where = ("--output", str(workspace.folder / "src"))
    for mode in MODES:
        words = ("generate", str(MODEL), "--mode", mode, *where)
        done = run_robosc(words, workspace.folder, {})
        assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.mark.once
def test_a_killed_node_goes_on(
    tour: Workspace, shared_master: Master, puppet: Puppet, tmp_path: Path
) -> None:
    file = tmp_path / "tour.json"
    puppet.do("listen", topic="/go_on", type="std_msgs/Int16")

    @contextmanager
    def running(*given: str) -> Iterator[int]:
        """A node that runs until it is killed; the first number that it sends."""
        mark = puppet.mark
        command = ("rosrun", NODE, NODE, f"_persistent_file:={file}", *given)
        with tour.start(*command, master=shared_master) as process:
            yield int(puppet.hears("/go_on", since=mark)["data"])
            process.kill()
            process.wait(20)
        shared_master.forget(f"/{NODE}")
        tour.run("rosparam", "delete", f"/{NODE}", master=shared_master)

    with running() as first:
        assert first == 2
        puppet.begin(
            "publish", topic="/arrived", type="std_msgs/Empty", fields={}, times=3, rate=20.0
        )
        puppet.hears("/go_on", lambda message: message["data"] == 5)
        await_condition(lambda: '"Tour.next": 5' in file.read_text(), "the write")
    with running() as first:
        assert first == 5
    with running("_forget:=true") as first:
        assert first == 2
    file.write_text(file.read_text()[:-9])
    with running() as first:
        assert first == 2


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
def test_the_package_has_a_test_that_begins_anew(tour: Workspace, mode: str) -> None:
    for _ in range(2):
        done = tour.own_test(f"tour_{mode}")
        assert done.returncode == 0, done.stdout
