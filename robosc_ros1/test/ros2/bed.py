"""The test bed: a virtual environment with ROS 2 as wheels, and interface packages for it."""

from __future__ import annotations

import fcntl
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import reaper

__all__ = ["Bed", "Unavailable", "build_interfaces", "test_bed"]

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[2]
_OTHER = os.environ.get("ROBOSC_ROS2", "")
"""Another ROS 2 than that of requirements.txt, for which there is a file with its wheels: kilted."""
_SUFFIX = f"-{_OTHER}" if _OTHER else ""
CACHE = REPOSITORY / ".cache" / f"ros2{_SUFFIX}"
REQUIREMENTS = HERE / f"requirements{_SUFFIX}.txt"
INTERFACES = (
    HERE / "interfaces" / "robosc_testing",
    HERE / "interfaces" / "sensor_msgs",
    HERE / "interfaces" / "tf2_msgs",
    REPOSITORY / "examples" / "robot_common",
)
GENERATORS = HERE / "interfaces" / "rosidl_default_generatorsConfig.cmake"
# What the wheels' CMake packages ask for, and only exists to be found.
_EMPTY_PACKAGES = ("python_cmake_module", "PythonExtra", "ament_cmake_ros", "ament_cmake_ros_core")
_DEBIAN_PYTHON = Path("/usr/lib/python3/dist-packages")
_NOT_TO_BE_HAD = (
    "No matching distribution found",
    "Could not find a version that satisfies",
    "Connection",
    "Temporary failure in name resolution",
    "is not a supported wheel",
)


class Unavailable(Exception):
    """Why there can be no test bed here."""


@dataclass(frozen=True)
class Bed:
    """A virtual environment with rclpy, and the prefix of the interface packages built for it."""

    folder: Path

    @property
    def python(self) -> str:
        return str(self.folder / "venv" / "bin" / "python")

    @property
    def interfaces(self) -> Path:
        return self.folder / "interfaces"

    @property
    def prefix(self) -> Path:
        return self.folder / "venv"

    @cached_property
    def environment(self) -> dict[str, str]:
        """What every process of the bed needs, inherited from nothing but what belongs to a run.

        The wheels' start-up hook would restart each Python to set LD_LIBRARY_PATH; it is set here.
        """
        libraries = [self.prefix / "lib", self.interfaces / "lib"]
        libraries += sorted(self.prefix.glob("lib/python3*/site-packages/ros_*.libs"))
        path = [self.prefix / "bin", Path("/usr/bin"), Path("/bin")]
        return {
            "PATH": os.pathsep.join(map(str, path)),
            "HOME": str(self.folder / "home"),
            "LANG": "C.UTF-8",
            "LD_LIBRARY_PATH": os.pathsep.join(map(str, libraries)),
            "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
            "PYTHONPATH": str(self.interfaces / "lib" / "python"),
            "AMENT_PREFIX_PATH": os.pathsep.join(map(str, (self.interfaces, self.prefix))),
            # Not shared memory: processes that are killed would leave files in /dev/shm.
            "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "PYTHONDONTWRITEBYTECODE": "1",
            **{n: value for n, value in os.environ.items() if n in (reaper.MARK, "TMPDIR")},
        }

    def run(self, *command: str | Path, folder: Path, timeout: float = 120.0) -> str:
        """Run a command that belongs to no graph (colcon, for one); its output."""
        done = subprocess.run(
            command, cwd=folder, env=self.environment, text=True, timeout=timeout,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        assert done.returncode == 0, f"{' '.join(map(str, command))}:\n{done.stdout}"
        return done.stdout

    def compile(self, folder: Path) -> None:
        """Write the byte code of modules, which processes of the bed read and do not write. Their
        source decides whether it is used, not its time: tests plant faults."""
        how = ("-m", "compileall", "-q", "--invalidation-mode", "checked-hash")
        self.run(self.python, *how, folder, folder=folder)


# --- Making the bed ------------------------------------------------------------------------------


def test_bed() -> Bed:
    """The bed, made if it is not there or no longer what it should be.

    Raises:
        Unavailable: the wheels or the build tools cannot be had here.
    """
    CACHE.mkdir(parents=True, exist_ok=True)
    bed = Bed(CACHE)
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        _once(CACHE / "venv", [REQUIREMENTS], lambda: _make_venv(bed))
        sources = [file for package in INTERFACES for file in _sources(package)]
        inputs = [REQUIREMENTS, GENERATORS, *sources]
        _once(bed.interfaces, inputs, lambda: _make_interfaces(bed))
        (CACHE / "home").mkdir(exist_ok=True)
    return bed


def _once(folder: Path, inputs: list[Path], make: Callable[[], None]) -> None:
    """Make the folder anew unless it was made from just these files, by the bed's Python."""
    version = [_python(), "-c", "import sys; print(sys.version, end='')"]
    digest = hashlib.sha256(subprocess.run(version, capture_output=True, check=True).stdout)
    for file in inputs:
        digest.update(file.name.encode() + file.read_bytes())
    stamp = folder / "made-from"
    if stamp.is_file() and stamp.read_text() == digest.hexdigest():
        return
    shutil.rmtree(folder, ignore_errors=True)
    make()
    stamp.write_text(digest.hexdigest())


def _make_venv(bed: Bed) -> None:
    if platform.machine() != "x86_64":
        raise Unavailable(f"there are no ROS 2 wheels for {platform.machine()}")
    done = subprocess.run([_python(), "-m", "venv", bed.prefix], capture_output=True, text=True)
    if done.returncode:
        raise Unavailable(f"no virtual environment (apt install python3-venv): {done.stdout}")
    pip = [bed.python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    # empy, which generates the interfaces' code, comes as source; nothing else may.
    pip += ["--no-deps", "--only-binary=:all:", "--no-binary=empy", "-r", REQUIREMENTS]
    # Without its variable the wheels' hook may restart this pip, which then finds itself replaced.
    env = os.environ | {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}
    env.pop("PYTHONPATH", None)
    done = subprocess.run(pip, env=env, capture_output=True, text=True, timeout=600)
    if done.returncode:
        errors = [line for line in done.stderr.splitlines() if "ERROR" in line] or [done.stderr]
        if any(sign in done.stderr for sign in _NOT_TO_BE_HAD):
            raise Unavailable(f"the ROS 2 wheels cannot be had: {errors[-1].strip()}")
        raise AssertionError(done.stderr)


def _python() -> str:
    """Debian's Python where there is one: its headers are those that ``./dev setup`` installs."""
    system = Path("/usr/bin/python3")
    return str(system) if system.is_file() else sys.executable


def _sources(package: Path) -> list[Path]:
    definitions = [f for kind in ("msg", "srv", "action") for f in package.glob(f"{kind}/*.{kind}")]
    return [package / "CMakeLists.txt", package / "package.xml", *sorted(definitions)]


def _make_interfaces(bed: Bed) -> None:
    missing = [tool for tool in ("cmake", "make", "g++") if not shutil.which(tool)]
    missing += [] if Path("/usr/share/ament_cmake").is_dir() else ["ament-cmake"]
    if missing:
        raise Unavailable(f"not installed: {', '.join(missing)} (./dev setup installs them)")
    build_interfaces(bed, INTERFACES, bed.interfaces)
    bed.compile(bed.interfaces)


def build_interfaces(
    bed: Bed, packages: Iterable[Path], prefix: Path, generators: Path = GENERATORS
) -> None:
    """Build interface packages into a prefix; what they depend on is in the bed's environment."""
    with tempfile.TemporaryDirectory() as scratch:
        stubs = _stubs(Path(scratch), generators)
        for package in packages:
            _build_interface(bed, package, Path(scratch), stubs, prefix)


def _stubs(scratch: Path, generators: Path) -> Path:
    stubs = scratch / "stubs"
    for name in _EMPTY_PACKAGES:
        config = stubs / "share" / name / "cmake" / f"{name}Config.cmake"
        config.parent.mkdir(parents=True)
        config.write_text(f"set({name}_FOUND TRUE)\n")
    config = stubs / "share" / "rosidl_default_generators" / "cmake" / GENERATORS.name
    config.parent.mkdir(parents=True)
    config.symlink_to(generators)
    # ament's CMake runs Python of the environment, which must see this one module of Debian's.
    (stubs / "python").mkdir()
    (stubs / "python" / "ament_package").symlink_to(_DEBIAN_PYTHON / "ament_package")
    return stubs


def _build_interface(bed: Bed, package: Path, scratch: Path, stubs: Path, prefix: Path) -> None:
    build = scratch / f"build-{package.name}"
    env = bed.environment | {"PYTHONPATH": str(stubs / "python"), "ROS_VERSION": "2"}
    found = env["AMENT_PREFIX_PATH"].replace(os.pathsep, ";")
    configure = [
        "cmake", "-S", package, "-B", build,
        f"-DCMAKE_PREFIX_PATH={stubs};{found}", f"-DCMAKE_INSTALL_PREFIX={prefix}",
        "-DPYTHON_INSTALL_DIR=lib/python", f"-DPython3_EXECUTABLE={bed.python}",
        "-DPython3_FIND_VIRTUALENV=ONLY", "-DBUILD_TESTING=OFF",
    ]  # fmt: skip
    for command in (configure, ["cmake", "--build", build, "-j2", "--target", "install"]):
        done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"


if __name__ == "__main__":
    start = time.monotonic()
    try:
        print(f"{test_bed().folder} stands ({time.monotonic() - start:.1f} s)")
    except Unavailable as reason:
        sys.exit(f"no ROS 2: {reason}")
