"""Helpers for tests that need ROS 1: a workspace to build in, and a roscore of one's own.

How to use them
---------------
Ask for fixtures (they live in ``conftest.py`` beside this file, so every test folder has them); a
test that does is skipped, saying why, where ROS is not installed::

    def test_something(make_workspace, roscore):
        workspace = make_workspace()      # an empty catkin workspace in a temporary folder
        workspace.add(generated_package)  # links a package (a folder with package.xml) into src/
        workspace.build()                 # catkin_make; on failure its output is the message
        workspace.run("rostest", "my_controller", "controller.test")      # devel space sourced
        with workspace.start("rosrun", "my_controller", "my_controller", master=roscore) as node:
            ...                               # node is a Popen; it is ended in the end
        workspace.run("rosservice", "list", master=roscore)

``roscore`` is a master on a free port, one for each test. ``example_workspace`` is built once for all
processes of a run (by ``built_once``, as others are), so nothing is to be changed in it: robosc itself,
the examples and what is generated from their models.

``rostest`` starts its own master (and takes no ``master=``). ROS logs go to the folder ``log``.
Nothing of the caller's ROS setup (sourced workspaces, ROS_MASTER_URI) leaks into a workspace.
"""

from __future__ import annotations

import contextlib
import fcntl
import io
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
import ros_links
from fork_server import Forked, ForkServer
from free import free_port

from robosc.cli import main

__all__ = [
    "EXAMPLES", "REPOSITORY", "SOURCES", "Completed", "Master", "Workspace", "await_condition",
    "built_once", "forked_process", "free_port", "link_checkout", "master", "missing_ros", "plain_environment", "resident",
    "run_robosc", "stopped",
]  # fmt: skip

REPOSITORY = Path(__file__).resolve().parents[2]
SOURCES = REPOSITORY / "robosc_ros1" / "src"
EXAMPLES = REPOSITORY / "examples"
PYTHON = Path("/usr/bin/python3") if Path("/usr/bin/python3").is_file() else Path(sys.executable)

Completed = subprocess.CompletedProcess[str]

UNUSED_LANGUAGES = "gencpp:geneus:genlisp:gennodejs"
"""For which nobody here needs messages: to generate and compile them is most of a build."""

_ROS_VARIABLES = ("ROS_", "CMAKE_PREFIX_PATH", "PYTHONPATH", "PYTHONHOME", "ROSLISP_")


def missing_ros() -> str | None:
    """Why tests with ROS cannot run here; None if they can."""
    missing = [t for t in ("roscore", "catkin_make", "rosrun", "rostest") if not shutil.which(t)]
    if missing:
        return f"ROS 1 is not installed ({', '.join(missing)} not found; ./dev setup installs it)"
    probe = subprocess.run([PYTHON, "-c", "import rospy, actionlib"], capture_output=True)
    return None if probe.returncode == 0 else f"{PYTHON} cannot import rospy and actionlib"


def link_checkout(folder: Path) -> None:
    """Link this checkout into a new folder, as ./dev setup and not tests have left it.

    ``rosrun`` looks for executables in all folders of a package.
    """
    (folder / ".cache").mkdir(parents=True)
    (folder / ".cache" / "extras").symlink_to(REPOSITORY / ".cache" / "extras")
    for path in REPOSITORY.iterdir():
        if path.name not in (".cache", ".git"):
            (folder / path.name).symlink_to(path)


def plain_environment(**extra: str) -> dict[str, str]:
    """The caller's environment without its ROS setup, and with the Python that sees rospy first."""
    env = {k: v for k, v in os.environ.items() if not k.startswith(_ROS_VARIABLES)}
    env["PATH"] = f"{PYTHON.parent}{os.pathsep}{env.get('PATH', os.defpath)}"
    # Where ROS is not under /usr, its setup is what makes it found at all.
    if not Path("/usr/share/catkin").is_dir():
        env |= {k: v for k, v in os.environ.items() if k.startswith(_ROS_VARIABLES)}
    # What a node says is read in its log while it runs: rospy prints some of it.
    own = {"ROS_HOSTNAME": "localhost", "PYTHONDONTWRITEBYTECODE": "1", "PYTHONUNBUFFERED": "1"}
    return env | own | extra


@contextlib.contextmanager
def processor_clock() -> Iterator[Callable[[], float]]:
    """Give the seconds that a processor was to be had for one more process, from now on.

    Where a duration is what a test is about, it is taken by this clock, which goes the slower the
    busier the machine is.
    """
    with subprocess.Popen([PYTHON, "-c", "while True: pass"]) as busy:

        def seconds() -> float:
            stat = Path(f"/proc/{busy.pid}/stat").read_text(encoding="utf-8")
            user, system = stat.rpartition(")")[2].split()[11:13]
            return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

        try:
            yield seconds
        finally:
            busy.kill()


def await_condition(condition, what: str, seconds: float = 60.0):  # type: ignore[no-untyped-def]
    """Wait until ``condition()`` is true; what it returned, or an AssertionError if never.

    The longer it has waited the seldomer it looks, since to look costs the others processor time.
    """
    start = time.monotonic()
    while True:
        found = condition()
        if found:
            return found
        waited = time.monotonic() - start
        if waited > seconds:
            raise AssertionError(f"waited {seconds:g} s in vain for {what}")
        time.sleep(min(0.2, max(0.02, waited / 10)))


@contextlib.contextmanager
def stopped(pid: int) -> Iterator[None]:
    """A process that stands still for a while."""
    os.kill(pid, signal.SIGSTOP)
    try:
        # The signal has been sent, but each thread goes on until it takes notice.
        await_condition(lambda: _stands_still(pid), f"process {pid} to stand still")
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


def _stands_still(pid: int) -> bool:
    """Whether all threads of a process are stopped."""
    states = [state_of(int(task.name)) for task in Path("/proc", str(pid), "task").glob("*")]
    return {*states} - {""} == {"T"}


def state_of(pid: int) -> str:
    """The state of a process or thread: R (runs), S (waits), T (stopped), Z; empty: it has ended."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except (FileNotFoundError, ProcessLookupError):
        return ""
    return stat.rpartition(")")[2].split()[0]


def resident(pid: int) -> int:
    """The memory of a process, in kB."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    (line,) = (line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1])


def run_robosc(
    arguments: Sequence[str],
    folder: Path,
    environment: Mapping[str, str],
    stdin: str | None = None,
    tested: bool = True,
) -> Completed:
    """``python3 -m robosc …`` of this checkout in a folder.

    It runs in this process, which is ten times as fast, unless the environment is one that Python
    itself reads when it starts; an exception that would show a traceback comes out of here. A
    package whose own test nobody runs need not be ``tested``: to choose its runs takes longer than
    all else.
    """
    if any(name.startswith(("PYTHON", "LC_", "LANG")) for name in environment):
        env = os.environ | {"PYTHONPATH": str(SOURCES), "PYTHONDONTWRITEBYTECODE": "1"}
        return subprocess.run(
            [sys.executable, "-m", "robosc", *arguments],
            cwd=folder,
            env=env | environment,
            input=stdin,
            capture_output=True,
            text=True,
            timeout=600,
        )
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2)]
    with (
        contextlib.chdir(folder),
        pytest.MonkeyPatch.context() as process,
        contextlib.redirect_stdout(streams[0]),
        contextlib.redirect_stderr(streams[1]),
    ):
        for name, value in environment.items():
            process.setenv(name, value)
        if not tested:
            process.setattr("robosc.traces.scripts.test_files", lambda *_: {})
        if stdin is not None:
            process.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin.encode())))
        try:
            code = main(arguments)
        except SystemExit as end:
            code = int(end.code or 0)
    texts = []
    for stream in streams:
        stream.seek(0)
        texts.append(stream.read())
    return Completed(["robosc", *arguments], code, *texts)


@dataclass(frozen=True)
class Master:
    """A running ROS master with its parameter server."""

    port: int

    @property
    def uri(self) -> str:
        return f"http://localhost:{self.port}"

    @property
    def environment(self) -> dict[str, str]:
        return {"ROS_MASTER_URI": self.uri, "ROS_HOSTNAME": "localhost"}

    def set(self, parameter: str, value: object) -> None:
        proxy: Any = ServerProxy(self.uri)
        proxy.setParam("/ros_support", parameter, value)

    def forget(self, node: str) -> None:
        """Drop the registrations of a killed node, whose name begins so.

        Others would go on to call its ports. Some day a new node gets one of them for its messages,
        and takes no connection while it waits for the rest of a call that is none of its own.
        """
        proxy: Any = ServerProxy(self.uri)
        with contextlib.suppress(OSError):  # the master may have been killed, too
            publishers, subscribers, services = proxy.getSystemState("/ros_support")[2]
            for registrations, drop in (
                (publishers, proxy.unregisterPublisher),
                (subscribers, proxy.unregisterSubscriber),
            ):
                for topic, names in registrations:
                    for name in names:
                        if name.startswith(node):
                            drop(name, topic, proxy.lookupNode("/ros_support", name)[2])
            for service, names in services:
                for name in names:
                    if name.startswith(node):
                        api = proxy.lookupService("/ros_support", service)[2]
                        proxy.unregisterService(name, service, api)

    def await_links(self, node: str) -> None:
        """Wait until a node and those that run have connected all topics that they share.

        What one of them published before would be lost.
        """
        ros_links.await_links(self.uri, node)

    def answers(self) -> bool:
        try:
            code, _, _ = ServerProxy(self.uri).getPid("/ros_support")  # type: ignore[misc]
        except OSError:
            return False
        return code == 1


@contextlib.contextmanager
def master(folder: Path, port: int | None = None) -> Iterator[Master]:
    """The master that roscore starts, on a free port, logs in ``folder``."""
    running = Master(port or free_port())
    env = plain_environment(**running.environment, ROS_HOME=str(folder), ROS_LOG_DIR=str(folder))
    command = (str(shutil.which("rosmaster")), "--core", "-p", str(running.port))
    with forked_process(command, env, folder / "roscore.log") as process:
        await_condition(
            lambda: process.poll() is not None or running.answers(), f"a master on {running.uri}"
        )
        assert process.poll() is None, process.log.read_text(encoding="utf-8")
        yield running


@contextlib.contextmanager
def running_process(
    command: list[str], env: Mapping[str, str], log: Path
) -> Iterator[subprocess.Popen[bytes]]:
    with log.open("wb") as output:
        process = subprocess.Popen(
            command, env=env, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            yield process
        finally:
            _end(process)


@cache
def nodes() -> ForkServer:
    """What starts nodes and puppets, once per process of tests."""
    modules = ("rosmaster", "rospy", "actionlib", "diagnostic_msgs.msg", "rosgraph_msgs.msg")
    return ForkServer(PYTHON, ("ros_links", "std_srvs.srv", *modules), plain_environment())


@contextlib.contextmanager
def forked_process(
    command: Sequence[str], env: Mapping[str, str], log: Path, piped: bool = False
) -> Iterator[Forked]:
    """A program of Python, the words after ``python3``, that begins with ``rospy`` imported."""
    with log.open("wb") as output:
        process = nodes().start(command, env, output, piped=piped)
    process.log = log
    try:
        yield process
    finally:
        _end(process)


def _end(process: subprocess.Popen[bytes] | Forked) -> None:
    for how, seconds in ((signal.SIGINT, 15), (signal.SIGTERM, 5), (signal.SIGKILL, 5)):
        if process.poll() is not None:
            return
        process.send_signal(how)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds)


def built_once(factory: pytest.TempPathFactory, name: str, build: Callable[[Path], None]) -> Path:
    """The folder that ``build`` fills; whichever process of tests needs it first builds it for all.

    If that fails, it has failed for all.
    """
    base = factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / name
    folder.mkdir(exist_ok=True)
    built, failed = folder / "built", folder / "failed"
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert not failed.exists(), f"{folder} was not built: {failed.read_text(encoding='utf-8')}"
        if not built.exists():
            try:
                build(folder)
            except pytest.skip.Exception:
                raise
            except BaseException as error:  # also that it took too long
                failed.write_text(str(error), encoding="utf-8")
                raise
            built.touch()
    return folder


class Workspace:
    """A catkin workspace in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "src").mkdir(parents=True, exist_ok=True)
        (folder / "log").mkdir(exist_ok=True)
        self._sourced: dict[Path, dict[str, str]] = {}
        self._started = 0

    def add(self, package: Path) -> None:
        """Link a package into ``src``."""
        (self.folder / "src" / package.name).symlink_to(package.resolve())

    def add_robosc(self) -> None:
        """Link this checkout into ``src``."""
        link_checkout(self.folder / "src" / "robosc")

    def build(self, *arguments: str) -> str:
        """catkin_make with arguments (``install``, ``run_tests`` …); its output."""
        command = ["catkin_make", "-C", str(self.folder), f"-DPYTHON_EXECUTABLE={PYTHON}"]
        env = plain_environment(**self._places(), ROS_LANG_DISABLE=UNUSED_LANGUAGES)
        done = self._run([*command, *arguments], env, 600)
        self._sourced.clear()
        assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
        # Nodes write no bytecode; what is compiled here they need not compile at each start. The
        # source decides whether it is used, not its time: tests plant faults.
        compiling = [PYTHON, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash"]
        subprocess.run([*compiling, self.folder / "src", self.folder / "devel"], check=True)
        return done.stdout

    def environment(self, space: str = "devel", master: Master | None = None) -> dict[str, str]:
        """That of a shell that has sourced the workspace's ``devel`` or ``install`` space."""
        setup = self.folder / space / "setup.sh"
        if setup not in self._sourced:
            # Bash tells setup.sh where it lies; sh would have to be told.
            done = subprocess.run(
                ["bash", "-c", 'source "${0%.sh}.bash" && env -0', str(setup)],
                env=plain_environment(**self._places()),
                capture_output=True,
                text=True,
                check=True,
            )
            pairs = (line.partition("=") for line in done.stdout.split("\0") if line)
            self._sourced[setup] = {name: value for name, _, value in pairs}
        return self._sourced[setup] | (master.environment if master else {})

    def run(
        self,
        *command: str,
        space: str = "devel",
        master: Master | None = None,
        check: bool = True,
        timeout: float = 600.0,
    ) -> Completed:
        """Run a command in the sourced workspace; with ``check`` a failure shows its output."""
        done = self._run(list(command), self.environment(space, master), timeout)
        if check:
            shown = " ".join(command)
            assert done.returncode == 0, f"{shown}: {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done

    @contextlib.contextmanager
    def start(
        self, *command: str, space: str = "devel", master: Master | None = None
    ) -> Iterator[subprocess.Popen[bytes]]:
        """Run a command in the background; it is interrupted (SIGINT) in the end.

        What it prints is in ``process.log`` (a Path).
        """
        log = self._new_log()
        with running_process(list(command), self.environment(space, master), log) as process:
            process.log = log  # type: ignore[attr-defined]
            yield process

    @contextlib.contextmanager
    def recording(self, bag: Path, *topics: str, master: Master) -> Iterator[None]:
        """``rosbag record``, which begins when there is a time; the bag is whole in the end."""
        with self.start("rosbag", "record", "-O", str(bag), *topics, master=master):
            yield
        # ``rosbag`` may end before the program that it started to record.
        await_condition(bag.exists, "rosbag to complete its bag")

    @contextlib.contextmanager
    def fork(self, *command: str, master: Master, piped: bool = False) -> Iterator[Forked]:
        """The same with the words after ``python3``, in a process that need not import rospy."""
        environment = self.environment(master=master)
        with forked_process(command, environment, self._new_log(), piped) as process:
            yield process

    def own_test(self, package: str) -> Completed:
        """Run a package's own test as rostest does, which takes three seconds to start one."""
        program = str(self.folder / "src" / package / "test" / "play_scripts.py")
        with master(self.folder / "log") as own, self.fork(program, "--text", master=own) as test:
            return Completed([program], test.wait(300), test.log.read_text(encoding="utf-8"), "")

    def _new_log(self) -> Path:
        self._started += 1
        return self.folder / "log" / f"started-{os.getpid()}-{self._started}.log"

    def _places(self) -> dict[str, str]:
        return {"ROS_HOME": str(self.folder / "log"), "ROS_LOG_DIR": str(self.folder / "log")}

    def _run(self, command: list[str], env: Mapping[str, str], timeout: float) -> Completed:
        return subprocess.run(
            command, cwd=self.folder, env=env, capture_output=True, text=True, timeout=timeout
        )
