"""A robot docks by what tf2 tells, in packages of every mode."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from ros1.stage import Puppet, Stage
from ros_support import EXAMPLES, Master, Workspace, run_robosc

MODES = ("controller", "supervisor", "monitor")
NODE = "docking_controller"
MODEL = EXAMPLES / "docking" / "docking.rscd"
SPEEDS = {"approach": 0.4, "creep": 0.1, "halt": 0.0}


@pytest.fixture(scope="module")
def docking(make_workspace: Callable[[], Workspace]) -> Workspace:
    workspace = make_workspace()
    where = ("--output", str(workspace.folder / "src"))
    for mode in MODES:
        words = ("generate", str(MODEL), "--mode", mode, *where)
        done = run_robosc(words, workspace.folder, {})
        assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.mark.once
def test_it_docks(docking: Workspace, shared_master: Master, puppet: Puppet) -> None:
    stage = Stage(docking, shared_master)
    puppet.do("listen", topic="/cmd_vel", type="geometry_msgs/Twist")

    def stands_at(x: float) -> None:
        puppet.do("broadcast", links=[("map", "odom", 1.0), ("odom", "base_link", x - 1.0)])

    def moves(name: str) -> None:
        speed = SPEEDS[name]
        puppet.hears("/cmd_vel", lambda m: m["linear"]["x"] == speed, since=puppet.mark)

    with stage.puppet() as ear, stage.controller(ear, NODE) as node:
        moves("halt")
        for x, name in ((0.0, "approach"), (4.2, "creep"), (4.8, "halt"), (-1.0, "approach")):
            stands_at(x)
            moves(name)
        # Localisation dies, and odometry goes on.
        puppet.do("broadcast", links=[("odom", "base_link", 0.0)])
        moves("halt")
        stands_at(0.0)
        moves("approach")
        with stage.puppet() as stranger:
            stranger.do("broadcast", links=[("world", "base_link", 0.0)])
            moves("halt")
            state = ear.hears(f"/{NODE}/state", lambda s: "two parents" in str(s["faults"]))
        (fault,) = (f for f in state["faults"] if "two parents" in f)
        assert "from base_link to dock" in fault
        names = [part.split(")")[0] for part in fault.split("(from ")[1:]]
        assert len(set(names)) == 2
        assert all(name.startswith("/puppet") for name in names)
        # The stranger has gone.
        moves("approach")
        assert node.process.poll() is None


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
def test_the_package_has_a_test_of_its_own(docking: Workspace, mode: str) -> None:
    done = docking.own_test(f"docking_{mode}")
    assert done.returncode == 0, done.stdout
