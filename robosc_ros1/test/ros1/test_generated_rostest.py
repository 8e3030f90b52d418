"""The rostest that every generated package brings: it passes, and it finds a faulty controller."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from emit.golden_packages import package_of
from ros_support import Workspace

from robosc.emit.writer import write


def test_it_passes_and_tells_what_was_reached(generated_workspace: Workspace) -> None:
    generated_workspace.build("run_tests_lantern_controller", "run_tests_gauntlet_controller")
    generated_workspace.run("catkin_test_results", str(generated_workspace.folder / "build"))
    for package in ("lantern_controller", "gauntlet_controller"):
        results = generated_workspace.folder / "build" / "test_results" / package
        texts = [path.read_text(encoding="utf-8") for path in results.glob("*.xml")]
        assert any('name="test_every_command_is_allowed"' in text for text in texts)
        assert any("seed: 1" in text for text in texts)


FAULTS = {
    "guard": (
        '            self.sky_light != "dark"\n',
        "            True\n",
        "requested against: requirement Sky.light = dark disables snuff",
    ),
    "data": ('return {"data": True}', 'return {"data": False}', "is sent with"),
    "conversion": ("if value > 20:", "if value > 30:", "is read as"),
    "state": ('            flame = "cold"', '            flame = "burning"', "Flame is "),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_it_finds_a_faulty_controller(make_workspace: Callable[[], Workspace], fault: str) -> None:
    before, after, complaint = FAULTS[fault]
    workspace = make_workspace()
    write(package_of("lantern"), workspace.folder / "src")
    controller = Path("src/lantern_controller/src/lantern_controller/controller.py")
    source = (workspace.folder / controller).read_text(encoding="utf-8")
    assert before in source
    (workspace.folder / controller).write_text(source.replace(before, after), encoding="utf-8")
    workspace.build()
    done = workspace.run(
        "rostest", "--text", "lantern_controller", "lantern_controller.test", check=False
    )
    output = done.stdout + done.stderr
    assert complaint in output, output
