"""The rostest that every generated package brings: it passes, and it finds a faulty controller."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from emit.golden_packages import package_of
from ros1.conftest import TESTED
from ros_support import Master, Workspace, run_robosc

from robosc.emit.write.writer import write


def results_of(workspace: Workspace, package: str) -> str:
    results = workspace.folder / "build" / "test_results" / package
    return "".join(path.read_text(encoding="utf-8") for path in results.glob("*.xml"))


BY_ROSTEST = ("lantern_controller", "sentry_supervisor", "hoist_monitor")
"""One of each mode: the files of catkin and rostest differ in nothing but names."""


def check(package: str, text: str) -> None:
    """It has played scripts, and tells what they showed."""
    assert re.search(r"\btest_run_0*1\b", text), package
    assert re.search(r"\btest_zz_commands_are_shown\b", text)
    assert re.search("requirement +met +violated$", text, re.MULTILINE)


def test_catkin_runs_them(generated_workspace: Workspace) -> None:
    tests = [f"run_tests_{package}" for package in BY_ROSTEST]
    generated_workspace.run("make", "-C", "build", *tests)
    generated_workspace.run("catkin_test_results", str(generated_workspace.folder / "build"))
    for package in BY_ROSTEST:
        check(package, results_of(generated_workspace, package))
    text = results_of(generated_workspace, "lantern_controller")
    rule = "shown +shown +requirement kindle needs Sky.light = dark$"
    assert re.search(rf"^lantern.rscd:\d+ +{rule}", text, re.MULTILINE)


@pytest.mark.parametrize("package", [name for name in TESTED if name not in BY_ROSTEST])
def test_they_pass_and_tell_what_was_reached(generated_workspace: Workspace, package: str) -> None:
    done = generated_workspace.own_test(package)
    assert done.returncode == 0, done.stdout
    check(package, done.stdout)


FAULTS = {
    "guard": ('return self.sky_light != "dark"\n', "return True\n"),
    "data": ('return {"data": True}', 'return {"data": False}'),
    "conversion": ("if value > 20:", "if value > 30:"),
    "state": ('self.flame = "cold"\n', 'self.flame = "burning"\n'),
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


UNKNOWN = """
robot Unknown {
    interface report use Primitives from robosc_testing
    datatype object Report { one_uint8: integer }
    component Server {
        outgoing message report with type: Report links report
        behaviour {
            variable last: integer
            initial marked state on_ { on response from report do last := value.one_uint8 }
        }
    }
    component Lamp { incoming message lamp with type: boolean }
    requirement lamp needs Server.last > 300
    provide lamp with true
}
"""


def test_a_script_that_does_not_fit_messages_unknown_when_it_was_made_is_skipped(
    generated_workspace: Workspace, roscore: Master, tmp_path: Path
) -> None:
    tmp_path.joinpath("unknown.rscd").write_text(UNKNOWN, encoding="utf-8")
    assert run_robosc(("generate", "unknown.rscd"), tmp_path, {}).returncode == 0
    package = tmp_path / "unknown_controller"
    path = f"{package / 'src'}:{generated_workspace.environment()['PYTHONPATH']}"
    player = ("python3", str(package / "test" / "play_scripts.py"), "--text")
    done = generated_workspace.run("env", f"PYTHONPATH={path}", *player, master=roscore)
    why = "Primitives: field one_uint8 exceeds specified width [uint8]"
    how = "generate this package again where the definitions of robosc_testing/Primitives are found"
    assert f"skipped '{why}; {how}'" in done.stdout + done.stderr


@pytest.mark.once
@pytest.mark.parametrize("fault", FAULTS)
def test_it_finds_a_faulty_controller(lantern: Workspace, fault: str) -> None:
    before, after = FAULTS[fault]
    module = "src/lantern_controller/src/lantern_controller/controller.py"
    source = package_of("lantern").files["src/lantern_controller/controller.py"].content
    assert before in source
    (lantern.folder / module).write_text(source.replace(before, after), encoding="utf-8")
    done = lantern.run(
        "rostest", "--text", "lantern_controller", "lantern_controller.test", check=False
    )
    output = done.stdout + done.stderr
    # With --text, rostest ends with 0 all the same.
    assert re.search(r"ERRORS: 1 \[test_run_\d+\]", output), output
    assert re.search(r"run_\d+\.sim, line \d+ \(after '.*'\): ", output), output
