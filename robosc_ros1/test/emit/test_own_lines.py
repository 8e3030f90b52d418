"""What users add to a generated package stays when it is generated again."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from emit.golden_packages import package_of

from robosc.emit.package.package import File, Package, frozen_files
from robosc.emit.write.writer import write
from robosc.errors import UsageError

GROUP = "golden"

BEGIN, END = "# begin of your own lines: here\n", "# end of your own lines\n"


def package(before: str, **files: str) -> Package:
    contents = {name.replace("__", "/"): File(text) for name, text in files.items()}
    return Package("demo", frozen_files({"a": File(f"{before}\n{BEGIN}{END}after\n"), **contents}))


@pytest.mark.parametrize("force", [False, True])
def test_own_lines_stay(tmp_path: Path, force: bool) -> None:
    write(package("1"), tmp_path)
    file = tmp_path / "demo" / "a"
    file.write_text(f"1\n{BEGIN}mine \\1\n{END}after\n")
    assert "a" in write(package("1"), tmp_path, force).unchanged
    for version in ("2", "3"):
        assert "a" in write(package(version), tmp_path, force).written
        assert file.read_text() == f"{version}\n{BEGIN}mine \\1\n{END}after\n"


@pytest.mark.parametrize("content", [f"1 mine\n{BEGIN}{END}after\n", f"1\n{BEGIN}mine\nafter\n"])
def test_other_lines_are_guarded_as_before(tmp_path: Path, content: str) -> None:
    write(package("1"), tmp_path)
    (tmp_path / "demo" / "a").write_text(content)
    with pytest.raises(UsageError, match="demo/a: changed since it was generated"):
        write(package("2"), tmp_path)


def test_a_file_with_own_lines_outlives_its_generation(tmp_path: Path) -> None:
    write(package("1"), tmp_path)
    file = tmp_path / "demo" / "a"
    file.write_text(f"1\n{BEGIN}mine\n{END}after\n")
    done = write(Package("demo", frozen_files({"b": File("")})), tmp_path)
    assert (done.removed, done.kept) == ((), ("a",))
    assert "mine" in file.read_text()


def test_configuration_that_was_changed_stays(tmp_path: Path) -> None:
    write(package("1", config__demo="rate: 10"), tmp_path)
    file = tmp_path / "demo" / "config" / "demo"
    file.write_text("rate: 20")
    for _ in range(2):
        done = write(package("2", config__demo="rate: 10\norder: rotate"), tmp_path)
        told = ("-rate: 20", "+rate: 10", "+order: rotate")
        assert (done.edited, file.read_text()) == ({"config/demo": told}, "rate: 20")
    assert (tmp_path / "demo" / "a").read_text().startswith("2")
    done = write(package("2", config__demo="rate: 10\norder: rotate"), tmp_path, force=True)
    assert (done.edited, file.read_text()) == ({}, "rate: 10\norder: rotate")


def test_comments_and_blank_lines_are_no_settings(tmp_path: Path) -> None:
    write(package("1", config__demo="# the rate\nrate: 10"), tmp_path)
    (tmp_path / "demo" / "config" / "demo").write_text("rate: 10\n\n  # mine\n")
    assert write(package("2", config__demo="# a rate\nrate: 10"), tmp_path).edited == {
        "config/demo": ()
    }


def test_somebody_else_s_configuration_is_not_replaced(tmp_path: Path) -> None:
    file = tmp_path / "demo" / "config" / "demo"
    file.parent.mkdir(parents=True)
    file.write_text("mine")
    with pytest.raises(UsageError, match="config/demo: not written by robosc"):
        write(package("1", config__demo="rate: 10"), tmp_path)


def test_a_package_for_the_other_version_of_ros_is_not_replaced(tmp_path: Path) -> None:
    first, second = (package_of("lantern", target) for target in ("ros1", "ros2"))
    write(first, tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(UsageError, match="lantern_controller holds a package for ros1"):
        write(second, tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    write(second, tmp_path, force=True)
    assert not (tmp_path / "lantern_controller" / "CMakeLists.txt").exists()
    assert "setup.cfg" in write(second, tmp_path).unchanged


@pytest.mark.parametrize("mode", ["controller", "supervisor"])
@pytest.mark.parametrize("target", ["ros1", "ros2"])
def test_dependencies_and_nodes_of_one_s_own(tmp_path: Path, target: str, mode: str) -> None:
    package = package_of("gauntlet", target, mode, tested=False)
    folder = write(package, tmp_path).folder

    def add(name: str, line: str) -> None:
        text = (folder / name).read_text(encoding="utf-8")
        head, end, tail = text.partition("end of your own lines")
        at = head.rindex("\n") + 1
        (folder / name).write_text(f"{head[:at]}{line}\n{head[at:]}{end}{tail}", encoding="utf-8")

    add("package.xml", "<exec_depend>tf2_ros</exec_depend>")
    if target == "ros1":
        add("CMakeLists.txt", "catkin_install_python(PROGRAMS scripts/mine)")
    else:
        add("setup.py", 'SCRIPTS.append("mine = mine:main")')
    done = write(package, tmp_path)
    assert (done.written, done.edited, done.removed) == ((), {}, ())
    manifest = ElementTree.parse(folder / "package.xml")
    assert "tf2_ros" in [element.text for element in manifest.findall("exec_depend")]
    if target == "ros2":
        program = (
            "import setuptools; setuptools.setup = lambda **k: print(k['entry_points']);"
            "exec(open('setup.py').read())"
        )
        shown = subprocess.run(
            [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=True
        )
        assert "mine = mine:main" in shown.stdout
