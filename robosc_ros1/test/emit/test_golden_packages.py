"""Generated packages byte for byte. ``./dev renew`` writes them anew after a wanted change."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest
from emit.golden_packages import MODELS, PACKAGES, TARGETS, golden_folder, kept_files, package_of
from kept import Kept
from quick import quick_first

import robosc.runtime
from robosc.emit.package.package import MARKER

GROUP = "golden"
"""One process makes the packages, for all tests that look at them."""

RUNTIME = Path(robosc.runtime.__file__).parent


@cache
def parsed(content: str) -> ast.Module:
    """Return the tree of a file; most files are in several packages."""
    return ast.parse(content, feature_version=(3, 8))


@cache
def imported_by(content: str) -> set[str]:
    """Return the names of modules as a file imports them."""
    found = set()
    for node in ast.walk(parsed(content)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(node.module or "")
    return found


@cache
def imported_in_vain(content: str) -> set[str]:
    """Return the names that a file imports and does not use."""
    imported, used = set(), set()
    for node in ast.walk(parsed(content)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            imported |= {(a.asname or a.name).split(".")[0] for a in node.names}
        elif isinstance(node, ast.Name):
            used.add(node.id)
        elif isinstance(node, ast.Assign) and ast.unparse(node.targets) == "__all__":
            used |= set(ast.literal_eval(node.value))
    # Annotations in the runtime's comments and strings do not count.
    return imported - used - {"annotations"}


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_the_package_is_the_golden_one(model: str, target: str, mode: str, kept: Kept) -> None:
    files = kept_files(package_of(model, target, mode), target, mode)
    kept.folder(golden_folder(model, target, mode), {p: f.content for p, f in files.items()})


def test_generation_is_deterministic() -> None:
    anew = package_of.__wrapped__
    assert anew("lantern").files == anew("lantern").files


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_every_file_carries_the_marker(model: str, target: str, mode: str) -> None:
    for path, file in package_of(model, target, mode).files.items():
        assert MARKER in file.content[:600], path


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_all_python_parses_as_3_8_and_imports_nothing_of_robosc(
    model: str, target: str, mode: str
) -> None:
    for path, file in package_of(model, target, mode).files.items():
        if path.endswith(".py") or path.startswith("scripts/"):
            names = imported_by(file.content)
            assert not any(name.split(".")[0] == "robosc" for name in names), path


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_the_runtime_is_copied_as_it_is(model: str, target: str, mode: str) -> None:
    files = package_of(model, target, mode).files
    copies = {path: file for path, file in files.items() if "/_runtime/" in path}
    assert copies
    for path, copy in copies.items():
        source = RUNTIME / path.partition("/_runtime/")[2]
        assert copy.content == source.read_text(encoding="utf-8"), path


@pytest.mark.parametrize("model", quick_first(MODELS, 2))
def test_the_controller_is_the_same_for_all_targets(model: str) -> None:
    package = f"{model}_controller"
    first = package_of(model, "ros1").files
    second = package_of(model, "ros2").files
    shared = [f"{package}/{name}" for name in ("__init__.py", "controller.py", "model.py")]
    for path in shared:
        assert first[f"src/{path}"] == second[path], path
    own = {"play_scripts.py", "test_play_scripts.py", "ros_player.py", "robot_tables.py"}
    # How many inputs were tried: a service of ROS 2 fails by time alone.
    own |= {"node_program.py", "action_client.py", "shown.py"}
    checked, others = (
        {path for path in files if path.startswith("test/") and path.endswith(".py")}
        - {f"test/{name}" for name in own}
        for files in (first, second)
    )
    assert checked == others
    for path in checked:
        assert first[path] == second[path], path


@pytest.mark.parametrize("mode", ["supervisor", "monitor"])
@pytest.mark.parametrize("target", TARGETS)
def test_all_modes_have_the_model_and_the_robot_of_the_controller(target: str, mode: str) -> None:
    guard = package_of("gauntlet", target, mode, tested=False).files
    controller = package_of("gauntlet", target, tested=False).files
    module = "src/" if target == "ros1" else ""
    shared = [f"{module}gauntlet_controller/{name}.py" for name in ("controller", "model")]
    for path in shared:
        other = path.replace("gauntlet_controller", f"gauntlet_{mode}")
        assert guard[other].content == controller[path].content, path


def test_the_controller_knows_no_ros() -> None:
    for path, file in package_of("lantern").files.items():
        if "_runtime" in path or path.endswith("controller.py"):
            assert "import rospy" not in file.content, path
            assert "rclpy." not in file.content.replace("rclpy's own", ""), path


@pytest.mark.parametrize(("model", "target", "mode"), PACKAGES)
def test_nothing_is_imported_in_vain(model: str, target: str, mode: str) -> None:
    for path, file in package_of(model, target, mode).files.items():
        if path.endswith(".py"):
            assert imported_in_vain(file.content) == set(), path
