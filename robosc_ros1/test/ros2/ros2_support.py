"""Helpers for tests that need ROS 2: real rclpy processes, without an installation of ROS 2.

How to use them
---------------
The *bed* is a virtual environment with ROS 2 as wheels (``requirements.txt``), colcon, and
interface packages built for it: ``robosc_testing`` and the examples' ``robot_common``. It lies in
``.cache/ros2`` of the checkout and is made once. Tests run under the usual Python and start
processes of the bed's; the fixture ``graph`` is a ROS graph of the test's own, that is, a
``ROS_DOMAIN_ID``::

    def test_something(graph):
        robot = graph.peer()                        # a node that does as told, see peer.py
        robot.subscribe("vel", "geometry_msgs/msg/Twist")
        with graph.start(graph.bed.python, "node.py") as node:
            robot.publish("distance", "std_msgs/msg/Float32", {"data": 3.0}, matched=1)
            robot.expect("message", name="vel")

A test is skipped, saying why, only where the wheels are not to be had (another processor, no
network) or Debian's ament-cmake packages are not installed; everything else that goes wrong fails.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, Any

__all__ = [
    "Bed", "Graph", "Peer", "Process", "Unavailable", "build_interfaces", "free_domain",
    "test_bed",
]  # fmt: skip

PATIENCE = 60.0
"""Seconds after which something that must come has not come, even on a machine that is busy."""

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[2]
CACHE = REPOSITORY / ".cache" / "ros2"
INTERFACES = (
    HERE / "interfaces" / "robosc_testing",
    REPOSITORY / "examples" / "robot_common",
)
GENERATORS = HERE / "interfaces" / "rosidl_default_generatorsConfig.cmake"
# What the wheels' CMake packages ask for, and only exists to be found.
_EMPTY_PACKAGES = ("python_cmake_module", "PythonExtra", "ament_cmake_ros")
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
        """What every process of the bed needs, inherited from nothing but the locale and HOME.

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
        }

    def run(self, *command: str | Path, folder: Path, timeout: float = 120.0) -> str:
        """Run a command that belongs to no graph (colcon, for one); its output."""
        done = subprocess.run(
            command, cwd=folder, env=self.environment, text=True, timeout=timeout,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        assert done.returncode == 0, f"{' '.join(map(str, command))}:\n{done.stdout}"
        return done.stdout


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
        _once(CACHE / "venv", [HERE / "requirements.txt"], lambda: _make_venv(bed))
        sources = [file for package in INTERFACES for file in _sources(package)]
        inputs = [HERE / "requirements.txt", GENERATORS, *sources]
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
    pip += ["--no-deps", "--only-binary=:all:", "--no-binary=empy", "-r", HERE / "requirements.txt"]
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


# --- Running in it -------------------------------------------------------------------------------


@contextlib.contextmanager
def free_domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID that no other test on this machine uses now."""
    locks = Path(tempfile.gettempdir()) / "robosc-ros2-domains"
    locks.mkdir(exist_ok=True)
    for domain in range(1, 101):
        with (locks / str(domain)).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    raise AssertionError("all ROS domains are in use")


class Process:
    """A process of a graph; what it prints goes to the file ``log``."""

    def __init__(self, command: list[str], env: dict[str, str], log: Path, **pipes: Any) -> None:
        self.log = log
        with log.open("wb") as output:
            pipes.setdefault("stdout", output)
            self.popen = subprocess.Popen(
                command, env=env, cwd=log.parent, stderr=output, start_new_session=True, **pipes
            )

    def signal(self, number: int) -> None:
        self.popen.send_signal(number)

    def wait(self, seconds: float = PATIENCE) -> int:
        """Its exit code, once it has ended by itself."""
        try:
            return self.popen.wait(seconds)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"still running after {seconds:g} s:\n{self.output}") from None

    def end(self) -> None:
        if self.popen.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self.popen.stdin.close()  # which is how a peer is told
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.popen.wait(10)
        for stop, seconds in ((self.popen.terminate, 10), (self.popen.kill, 5)):
            if self.popen.poll() is None:
                stop()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self.popen.wait(seconds)

    @property
    def output(self) -> str:
        return self.log.read_text(encoding="utf-8", errors="replace")


class Graph:
    """A ROS graph of its own: processes on one domain, ended with it."""

    def __init__(self, bed: Bed, domain: int, folder: Path) -> None:
        self.bed = bed
        self.folder = folder
        self.environment = bed.environment | {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": str(folder / "ros"),
        }
        self._processes: list[Process] = []

    def start(self, *command: str | Path, **environment: str) -> Process:
        words = [str(word) for word in command]
        return self._add(words, environment)

    def peer(self, name: str = "robot", **environment: str) -> Peer:
        """A node that does as it is told; see peer.py."""
        command = [self.bed.python, str(HERE / "peer.py"), name]
        process = self._add(command, environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        return Peer(process)

    def _add(self, command: list[str], environment: dict[str, str], **pipes: Any) -> Process:
        log = self.folder / f"{len(self._processes)}-{Path(command[-1]).stem}.log"
        process = Process(command, self.environment | environment, log, **pipes)
        self._processes.append(process)
        return process

    def close(self) -> None:
        for process in reversed(self._processes):
            process.end()


class Peer:
    """The test's end of a peer (see peer.py): orders go there, events come back."""

    def __init__(self, process: Process) -> None:
        self.process = process
        assert process.popen.stdin is not None and process.popen.stdout is not None
        self._orders: IO[bytes] = process.popen.stdin
        self._news = threading.Condition()
        self._events: list[dict[str, Any]] = []
        self._count = 0
        threading.Thread(target=self._read, args=(process.popen.stdout,), daemon=True).start()

    def _read(self, stream: IO[bytes]) -> None:
        for line in stream:
            with self._news:
                self._events.append(json.loads(line))
                self._news.notify_all()

    def order(self, do: str, seconds: float = PATIENCE, **arguments: Any) -> Any:
        """Have something done; what the peer answers to it."""
        self._count += 1
        text = json.dumps({"do": do, "order": self._count, **arguments})
        self._orders.write(text.encode() + b"\n")
        self._orders.flush()
        answer = self.expect("done", seconds, order=self._count)
        assert "fault" not in answer, answer["fault"]
        return answer.get("result")

    def expect(
        self,
        event: str,
        seconds: float = PATIENCE,
        where: Callable[[Any], object] = lambda data: True,
        **fields: Any,
    ) -> dict[str, Any]:
        """Wait for an event with these fields, and such ``data`` if ``where`` is given.

        It and those before it of its kind are used up.
        """
        wanted = {"event": event, **fields}
        end = time.monotonic() + seconds
        with self._news:
            while True:
                for index, found in enumerate(self._events):
                    if wanted.items() <= found.items() and where(found.get("data")):
                        same = ("event", "name")
                        self._events = [
                            e for i, e in enumerate(self._events)
                            if i > index or any(e.get(f) != found.get(f) for f in same)
                        ]  # fmt: skip
                        return found
                if not self._news.wait(end - time.monotonic()):
                    last = "".join(f"\n  {str(e)[:1000]}" for e in self._events[-5:])
                    raise AssertionError(
                        f"no {wanted} within {seconds:g} s; the last were{last}\n"
                        + self.process.output
                    )

    def events(self, event: str, **fields: Any) -> list[dict[str, Any]]:
        """The events of this kind that nobody has expected yet; they stay."""
        wanted = {"event": event, **fields}
        with self._news:
            return [e for e in self._events if wanted.items() <= e.items()]

    def watch(self, node: str) -> None:
        """Listen to a controller's own topic ``~/state``."""
        self.subscribe(f"{node}/state", "std_msgs/msg/String", durability="transient_local")

    def expect_state(
        self, node: str, where: Callable[[dict[str, Any]], object], seconds: float = PATIENCE
    ) -> dict[str, Any]:
        """Wait for a state of a watched controller."""
        documents: list[dict[str, Any]] = []

        def fits(data: dict[str, str]) -> object:
            documents.append(json.loads(data["data"]))
            return where(documents[-1])

        self.expect("message", seconds, where=fits, name=f"{node}/state")
        return documents[-1]

    def subscribe(self, name: str, type: str, **qos: Any) -> None:
        self.order("subscribe", name=name, type=type, qos=qos)

    def publish(self, name: str, type: str, data: Any = None, matched: int = 1, **qos: Any) -> None:
        """Publish once there are ``matched`` subscribers.

        Only a reliable subscriber is then sure to get the message: the two sides of a match do not
        come to know of each other at the same moment.
        """
        self.order("publish", name=name, type=type, data=data or {}, matched=matched, qos=qos)

    def serve(self, name: str, type: str, reply: Any = None) -> None:
        """Offer a service that replies so at once; without a reply it waits to be told."""
        self.order("serve", name=name, type=type, reply=reply)

    def act(self, name: str, type: str, **policy: Any) -> None:
        """Offer an action; see peer.py for the policy."""
        self.order("act", name=name, type=type, **policy)


if __name__ == "__main__":
    start = time.monotonic()
    try:
        print(f"{test_bed().folder} stands ({time.monotonic() - start:.1f} s)")
    except Unavailable as reason:
        sys.exit(f"no ROS 2: {reason}")
