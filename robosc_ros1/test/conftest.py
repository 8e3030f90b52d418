"""Fixtures for all tests; see ros_support.py for those that need ROS."""

from __future__ import annotations

import gc
import os
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import costs
import pytest
import reaper
import ros_support
import sizes
from hypothesis import HealthCheck, settings
from kept import Kept
from progress import Progress, Summary
from ros_support import EXAMPLES, REPOSITORY, Master, Workspace, built_once
from view.browser import Browser, headless, missing_browser

# The same examples in every run. How long it takes to draw one tells of the machine, not of robosc.
settings.register_profile(
    "robosc", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("robosc")

# One process runs all tests of the folder view, which share a browser, those that plant faults in the
# guarded workspace or run what is in it, and those that build the extension.
TOGETHER = ("extension", "view", "guarded_workspace")

# What takes long: ROS, browsers, editors and terminals. Other slow tests are marked where they stand.
SLOW = {"bed", "client", "extension", "ros", "shared_browser", "terminal"}


# A test's name goes from process to process with each of its reports, and into the environment.
LONGEST_ID = 100


def pytest_make_parametrize_id(val: object) -> str | None:
    """The beginning of a long text stands for it in the name of a test."""
    if isinstance(val, str | bytes) and len(val) > LONGEST_ID:
        return f"{val[:LONGEST_ID]!a}..."
    return None


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--renew", action="store_true", help="write the outputs anew that are kept")
    parser.addoption("--size", choices=sizes.SIZES, default="all", help="see sizes.py")


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    """Whatever ends this process also ends what tests started, and removes what they wrote."""
    worker = hasattr(config, "workerinput")
    reaper.watch(None if worker else own_folder())
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if not worker:
        config.pluginmanager.register(Summary())
    if not worker and reporter is not None and config.option.verbose == 0:
        workers = config.getoption("numprocesses", default=None) or 0
        config.pluginmanager.register(Progress(reporter, int(workers)))


FAILED = REPOSITORY / ".cache" / "failed-run"
"""Names the temporary folder of a run in which tests failed; it stays until the next run."""


def own_folder() -> Path:
    """Make the folder of all temporary files of this run."""
    if FAILED.is_file():
        shutil.rmtree(FAILED.read_text(encoding="utf-8"), ignore_errors=True)
        FAILED.unlink(missing_ok=True)
    folder = Path(tempfile.mkdtemp(prefix="robosc-"))
    os.environ["TMPDIR"] = tempfile.tempdir = str(folder)
    return folder


def pytest_keyboard_interrupt(excinfo: pytest.ExceptionInfo[BaseException]) -> None:
    """What runs ends now, not when each of its fixtures has done so in turn."""
    reaper.end(os.environ[reaper.MARK])
    late = threading.Timer(1.5, os._exit, [pytest.ExitCode.INTERRUPTED])
    late.daemon = True
    late.start()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep together, where tests run side by side, what shares a fixture: often that is a file.

    With ``--renew`` only the tests remain that compare with kept outputs.
    """
    if config.getoption("--renew", default=False):
        items[:] = [i for i in items if "kept" in getattr(i, "fixturenames", ())]
    for item in items:
        if SLOW.intersection(getattr(item, "fixturenames", ())) or item.get_closest_marker("once"):
            item.add_marker(pytest.mark.slow)
        item.add_marker(pytest.mark.xdist_group(group_of(item)))
    taken = sizes.take(config.getoption("--size"), items)
    if left := set(items).difference(taken):
        config.hook.pytest_deselected(items=[item for item in items if item in left])
    # What takes longest begins first, so that no process is left alone with it at the end.
    seconds = sizes.seconds_of_groups(taken, group_of)
    items[:] = sorted(taken, key=lambda item: (-seconds[group_of(item)], group_of(item)))


def pytest_collection_finish() -> None:
    """What was collected stays to the end; the garbage collector need not go through it again."""
    gc.freeze()


def group_of(item: pytest.Item) -> str:
    """Return the name of the tests that run in one process with this one."""
    shared = {item.path.parent.name, *getattr(item, "fixturenames", ())}.intersection(TOGETHER)
    return next(iter(shared), getattr(item.module, "GROUP", item.path.name))


@pytest.hookimpl(hookwrapper=True, tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    item.stash[BEGUN] = costs.processor()
    yield


@pytest.hookimpl(hookwrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    yield
    item.user_properties.append(("processor", costs.processor() - item.stash[BEGUN]))


BEGUN = pytest.StashKey[float]()


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Where changes are judged, a test that was skipped has failed."""
    # Side by side, each process has a reporter, of its own tests, and may end after the one of all.
    if hasattr(session.config, "workerinput"):
        return
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("CI") and reporter is not None and reporter.stats.get("skipped"):
        session.exitstatus = session.exitstatus or pytest.ExitCode.TESTS_FAILED
    if session.exitstatus == pytest.ExitCode.TESTS_FAILED:
        folder = tempfile.gettempdir()
        Path(folder, reaper.KEEP).touch()
        FAILED.parent.mkdir(exist_ok=True)
        FAILED.write_text(folder, encoding="utf-8")


@pytest.fixture(scope="session")
def kept(pytestconfig: pytest.Config) -> Kept:
    return Kept(renew=pytestconfig.getoption("--renew", default=False))


@pytest.fixture(scope="session")
def ros() -> None:
    """Skips what needs ROS 1 where there is none."""
    reason = ros_support.missing_ros()
    if reason is not None:
        pytest.skip(reason)


@pytest.fixture
def roscore(ros: None, tmp_path: Path) -> Iterator[Master]:
    """A master of the test's own."""
    folder = tmp_path / "roscore"
    folder.mkdir()
    with ros_support.master(folder) as running:
        yield running


@pytest.fixture(scope="session")
def make_workspace(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Callable[[], Workspace]:
    """Makes an empty catkin workspace in a temporary folder."""
    return lambda: Workspace(tmp_path_factory.mktemp("workspace") / "ws")


@pytest.fixture(scope="session")
def example_workspace(ros: None, tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """robosc, examples and what is generated from their models, built for devel space."""
    return Workspace(built_once(tmp_path_factory, "examples", _build_examples))


def _build_examples(folder: Path) -> None:
    """That rosrun generates the same is for test_catkin."""
    workspace = Workspace(folder)
    workspace.add_robosc()
    for example in ("robot_common", "line_follower", "navigation", "two_robots"):
        workspace.add(EXAMPLES / example)
    for example, mode in (
        ("line_follower", "controller"),
        ("line_follower", "supervisor"),
        ("navigation", "controller"),
        ("two_robots", "controller"),
        ("order", "controller"),
    ):
        words = (str(EXAMPLES / example / f"{example}.rscd"), "--mode", mode)
        where = ("--output", str(workspace.folder / "src"))
        known = {"ROS_PACKAGE_PATH": f"{EXAMPLES}:/usr/share"}
        words = ("generate", *words, *where)
        done = ros_support.run_robosc(words, folder, known, tested=False)
        assert done.returncode == 0, done.stderr
    workspace.build()


@pytest.fixture
def robosc(tmp_path: Path) -> Callable[..., ros_support.Completed]:
    """Runs the command line in the test's folder; environment variables are keyword arguments."""

    def run(*arguments: str, stdin: str | None = None, **environment: str) -> ros_support.Completed:
        return ros_support.run_robosc(arguments, tmp_path, environment, stdin)

    return run


@pytest.fixture(scope="session")
def shared_browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    reason = missing_browser()
    if reason is not None:
        pytest.skip(reason)
    with headless(tmp_path_factory.mktemp("browser")) as running:
        yield running


@pytest.fixture
def browser(shared_browser: Browser) -> Iterator[Browser]:
    """A headless browser. A test in which the page complains has failed."""
    shared_browser.look()
    shared_browser.complaints()
    yield shared_browser
    complaints = shared_browser.complaints()
    shared_browser.open("about:blank")
    assert not complaints
