"""The rostest that every generated package brings: it passes, and it finds a faulty controller."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from emit.golden_packages import package_of
from ros_support import Workspace

from robosc.emit.write.writer import write

ROWS = {
    "lantern_controller": (
        "event +brightness response",
        "event +kindle request",
        "event +internal transition 1 of Flame",
        "state +Flame.burning",
        "allows +requirement kindle needs Sky.light = dark",
        "forbids +requirement Sky.light = dark disables snuff",
    ),
    "gauntlet_controller": (
        "event +spots response",
        "event +set_level request",
        "event +set_level response",
        "state +Lamp.working",
        "allows +requirement set_level needs Count.full or Count.items &gt;= 2",
        "forbids +requirement set_level needs Count.full or Count.items &gt;= 2",
    ),
    "thermostat_controller": (
        "event +reading response",
        "event +heat request",
        "event +say request",
        "state +Heater.hot",
        "allows +requirement say needs steps &gt; 1",
        "forbids +requirement rest needs Sensor.degrees &gt; wanted or Sensor.degrees &gt; limit",
    ),
    # Of this one something is assumed.
    "hoist_controller": (
        "event +door response",
        "event +rise request",
        "event +hold request",
        "event +height timeout",
    ),
    # Of this one the age of messages matters.
    "sonar_controller": (
        "event +depth response",
        "event +depth timeout",
        "event +drive request",
        "event +show request",
    ),
    # Its goals are replaced.
    "courier_controller": ("event +go request", "event +go response", "event +go cancel"),
    "courier_supervisor": ("event +go request", "event +go cancel"),
    # A mission, and conditions on what was heard and for how long.
    "sentry_controller": (
        "event +depth response",
        "event +unlock request",
        "event +drive request",
        "event +after 1 of Sight.near",
        "state +Watch.standing.unlocking performing",
    ),
    "sentry_supervisor": ("event +depth response", "event +unlock request"),
    # The robot calls, and the controller that is guarded answers.
    "orders_supervisor": ("event +order request", "state +Orders.asked"),
    "missions_supervisor": ("event +mission request", "state +Missions.running"),
    # Three services have one name, and two actions.
    "shared_controller": (
        "event +light request",
        "event +light response",
        "event +drive request",
        "state +Base.away",
    ),
}
"""Of the table of each, rows that no run misses, with a count."""


def test_it_passes_and_tells_what_was_reached(generated_workspace: Workspace) -> None:
    tests = [f"run_tests_{package}" for package in ROWS]
    generated_workspace.run("make", "-C", "build", *tests)
    generated_workspace.run("catkin_test_results", str(generated_workspace.folder / "build"))
    for package in ROWS:
        results = generated_workspace.folder / "build" / "test_results" / package
        texts = [path.read_text(encoding="utf-8") for path in results.glob("*.xml")]
        name = (
            "only_what_is_allowed_passes" if "supervisor" in package else "every_command_is_allowed"
        )
        assert any(f'name="test_{name}"' in text for text in texts)
        assert any("seed: 1" in text for text in texts)
        for row in ROWS[package]:
            assert any(re.search(f"^{row} +[1-9]", text, re.MULTILINE) for text in texts), row


FAULTS = {
    "guard": (
        'return self.sky_light != "dark"\n',
        "return True\n",
        "against: requirement Sky.light = dark disables snuff",
    ),
    "data": ('return {"data": True}', 'return {"data": False}', "is sent with"),
    "conversion": ("if value > 20:", "if value > 30:", "is read as"),
    "state": ('self.flame = "cold"\n', 'self.flame = "burning"\n', "Flame is "),
}


# The package of a robot with a name of 102 characters.
LONG = f"{'r' * 102}_controller"


@pytest.fixture(scope="module")
def lantern(make_workspace: Callable[[], Workspace]) -> Workspace:
    """A workspace of its own, for a controller in which faults are planted."""
    workspace = make_workspace()
    write(package_of("lantern"), workspace.folder / "src")
    write(package_of("lantern", name=LONG), workspace.folder / "src")
    workspace.build()
    return workspace


def test_a_long_name_can_be_tested(lantern: Workspace) -> None:
    lantern.build(f"run_tests_{LONG}")
    lantern.run("catkin_test_results", str(lantern.folder / "build"))


def test_a_python_without_rospy_is_told_before_the_test_begins(
    lantern: Workspace, tmp_path: Path
) -> None:
    python = tmp_path / "python3"
    python.write_text('#!/bin/sh\nexec /usr/bin/python3 -S "$@"\n')
    python.chmod(0o755)
    path = f"{tmp_path}:{lantern.environment()['PATH']}"
    make = ("make", "-C", "build", "run_tests_lantern_controller")
    done = lantern.run("env", f"PATH={path}", *make, check=False)
    assert done.returncode != 0
    assert "python3 cannot import rospy: put that of ROS first on PATH" in done.stderr


# What rospy does if it handles the answer to a subscription after an update that came later.
FORGETFUL = """
from rospy.impl.registration import RegManager
remember, begun = RegManager.publisher_update, time.monotonic()
def publisher_update(self, name, uris):
    if name != "/lantern_controller/events" or time.monotonic() > begun + 0.8 * STUCK:
        remember(self, name, uris)
RegManager.publisher_update = publisher_update
ROUNDS = 1
"""


def test_it_connects_where_rospy_forgets_who_publishes(lantern: Workspace) -> None:
    script = lantern.folder / "src/lantern_controller/test/ros_robot.py"
    source = script.read_text(encoding="utf-8")
    assert "\nROUNDS = 50\n" in source
    script.write_text(source.replace("\nROUNDS = 50\n", FORGETFUL), encoding="utf-8")
    try:
        lantern.run("rostest", "lantern_controller", "lantern_controller.test", "seconds:=0")
    finally:
        script.write_text(source, encoding="utf-8")


LATE = """
        import os, time
        while not os.path.exists(rospy.get_param("~log")):
            time.sleep(0.01)
"""


def test_it_judges_what_was_done_before_it_could_listen(lantern: Workspace) -> None:
    package = lantern.folder / "src/lantern_controller"
    script, module = (
        package / "test/play_robot.py",
        package / "src/lantern_controller/controller.py",
    )
    sources = {path: path.read_text(encoding="utf-8") for path in (script, module)}
    begin = "\n        robot = Robot(seed, TABLES)\n"
    initial = 'self.flame = "cold"  #'
    assert begin in sources[script]
    assert initial in sources[module]
    script.write_text(sources[script].replace(begin, LATE + begin), encoding="utf-8")
    module.write_text(sources[module].replace(initial, 'self.flame = "sparking"  #'), "utf-8")
    test = ("rostest", "--text", "lantern_controller", "lantern_controller.test")
    try:
        done = lantern.run(*test, check=False)
    finally:
        for path, source in sources.items():
            path.write_text(source, encoding="utf-8")
    assert "FAULT: event 1: internal transition 1 of Flame" in done.stdout + done.stderr


@pytest.mark.once
@pytest.mark.parametrize("fault", FAULTS)
def test_it_finds_a_faulty_controller(lantern: Workspace, fault: str) -> None:
    before, after, complaint = FAULTS[fault]
    module = "src/lantern_controller/src/lantern_controller/controller.py"
    source = package_of("lantern").files["src/lantern_controller/controller.py"].content
    assert before in source
    (lantern.folder / module).write_text(source.replace(before, after), encoding="utf-8")
    done = lantern.run(
        "rostest", "--text", "lantern_controller", "lantern_controller.test", check=False
    )
    output = done.stdout + done.stderr
    assert complaint in output, output
