"""Fixtures of tests with ROS 2; see ros2_support.py."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest
import reflecting
from agents.agent_support import sdk, start_agent
from agents.tried import LIBRARIES, LIMITER, LINE_FOLLOWER
from emit.golden_packages import GOLDEN
from primitives import PRIMITIVES_OF_ROS2
from ros2.bed import HERE, REPOSITORY, Bed, Unavailable, test_bed
from ros2.ros2_support import Graph, Peer, Process, free_domain
from ros_support import built_once, run_robosc

__all__ = ["sdk", "start_agent"]

MODELS = {
    HERE / "models" / "guarded_arm.rscd": "guarded_arm",
    REPOSITORY
    / "examples"
    / "line_follower_first_edition"
    / "line_follower.rscd": "line_follower_controller",
    REPOSITORY / "examples" / "navigation" / "navigation.rscd": "navigation_controller",
    REPOSITORY / "examples" / "order" / "order.rscd": "order_controller",
    REPOSITORY / "examples" / "docking" / "docking.rscd": "docking_controller",
    REPOSITORY / "examples" / "zones" / "zones.rscd": "floor_controller",
    HERE / "models" / "workbench.rscd": "workbench_controller",
    HERE / "models" / "everything.rscd": "everything_controller",
    HERE / "models" / "tour.rscd": "tour_controller",
    GOLDEN / "models" / "watch.rscd": "watch_controller",
    GOLDEN / "models" / "shared.rscd": "shared_controller",
    GOLDEN / "models" / "thermostat.rscd": "thermostat_controller",
    GOLDEN / "models" / "orders.rscd": "orders_controller",
    GOLDEN / "models" / "dispatch.rscd": "dispatch_controller",
    GOLDEN / "models" / "missions.rscd": "missions_controller",
    GOLDEN / "models" / "hoist.rscd": "hoist_controller",
    GOLDEN / "models" / "sonar.rscd": "sonar_controller",
    GOLDEN / "models" / "sentry.rscd": "sentry_controller",
    GOLDEN / "models" / "courier.rscd": "courier_controller",
    GOLDEN / "models" / "bell.rscd": "bell_controller",
}


TESTED = {
    *((m, "controller") for m in ("guarded_arm", "shared", "hoist", "sonar", "everything")),
    *(
        (m, "controller")
        for m in ("workbench", "missions", "courier", "sentry", "mirror", "dispatch")
    ),
    *((m, "supervisor") for m in ("guarded_arm", "orders", "missions", "courier", "sentry")),
    *((m, "supervisor") for m in ("mirror", "crane")),
    *((m, "monitor") for m in ("guarded_arm", "mirror", "courier", "crane", "hoist")),
    ("line_follower", "monitor"),
}
"""Models and modes of packages of which somebody runs their own tests."""


@pytest.fixture(scope="session")
def bed() -> Bed:
    """The test bed; skips where it is not to be had."""
    try:
        return test_bed()
    except Unavailable as reason:
        pytest.skip(f"no ROS 2: {reason}")


@pytest.fixture
def graph(bed: Bed, tmp_path: Path) -> Iterator[Graph]:
    """A ROS graph of the test's own."""
    with free_domain() as domain:
        graph = Graph(bed, domain, tmp_path)
        try:
            yield graph
        finally:
            graph.close()


@dataclass(frozen=True)
class Built:
    """Generated packages, installed into one prefix each, one of each mode by colcon."""

    bed: Bed
    folder: Path

    def executable(self, package: str) -> Path:
        return self.folder / "install" / package / "lib" / package / package

    def environment(self, package: str) -> dict[str, str]:
        prefix = self.folder / "install" / package
        (site,) = prefix.glob("lib/python3*/site-packages")
        path = os.pathsep.join((str(site), self.bed.environment["PYTHONPATH"]))
        index = os.pathsep.join((str(prefix), self.bed.environment["AMENT_PREFIX_PATH"]))
        return {"PYTHONPATH": path, "AMENT_PREFIX_PATH": index}


def generate(
    folder: Path, model: Path, *arguments: str, prefix: str = "", tested: bool = True
) -> None:
    """``prefix`` are the AMENT_PREFIX_PATH, where definitions are looked up."""
    where = ("--target", "ros2", "--output", str(folder / "src"))
    env = {"AMENT_PREFIX_PATH": prefix} if prefix else {}
    words = ("generate", str(model), *where, *arguments)
    done = run_robosc(words, folder, env, tested=tested)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="session")
def built(bed: Bed, tmp_path_factory: pytest.TempPathFactory) -> Built:
    """Controllers, supervisors and monitors of some robots, generated as a user does it."""
    return Built(bed, built_once(tmp_path_factory, "colcon", partial(_build, bed)))


def _build(bed: Bed, folder: Path) -> None:
    known = bed.environment["AMENT_PREFIX_PATH"]
    (folder / "src").mkdir()
    arm, mirror = HERE / "models" / "guarded_arm.rscd", HERE / "models" / "mirror.rscd"
    reflector = folder / "reflector.rscd"
    reflector.write_text(reflecting.model(PRIMITIVES_OF_ROS2), encoding="utf-8")
    # Results cannot be heard, so a monitor would leave out an action of which one is expected.
    seen, text = folder / "courier.rscd", (GOLDEN / "models" / "courier.rscd").read_text()
    seen.write_text(text.replace("expect: value.distance < 5.0,", ""))
    managed = folder / "managed.yaml"
    managed.write_text("lifecycle: true\n", encoding="utf-8")
    called = [GOLDEN / "models" / f"{name}.rscd" for name in ("orders", "missions")]
    packages = [(model, "controller", ("--package", name)) for model, name in MODELS.items()]
    packages += [
        (arm, "supervisor", ()),
        (arm, "monitor", ()),
        (REPOSITORY / "examples" / "line_follower" / "line_follower.rscd", "monitor", ()),
        (LINE_FOLLOWER, "supervisor", ()),
        (LIMITER, "supervisor", ("--library-path", str(LIBRARIES))),
        (HERE / "models" / "crane.rscd", "supervisor", ()),
        (HERE / "models" / "crane.rscd", "monitor", ()),
        (GOLDEN / "models" / "fleet.rscd", "controller", ()),
        (GOLDEN / "models" / "hoist.rscd", "monitor", ()),
        (HERE.parent / "ros1" / "trolley.rscd", "monitor", ()),
        (seen, "monitor", ("--package", "courier_monitor")),
    ]
    packages += [(reflector, mode, ()) for mode in ("controller", "supervisor")]
    for mode in ("controller", "supervisor", "monitor"):
        packages.append((mirror, mode, ("--package", f"mirror_{mode}")))
    for model in (*called, *(GOLDEN / "models" / f"{name}.rscd" for name in ("courier", "sentry"))):
        packages.append((model, "supervisor", ("--package", f"{model.stem}_supervisor")))
    for model, mode in (
        (arm, "controller"), (arm, "supervisor"), *((model, "controller") for model in called)
    ):  # fmt: skip
        name = ("--package", f"{model.stem}_managed_{mode}", "--config", str(managed))
        packages.append((model, mode, name))
    for model, mode, arguments in packages:
        tested = (model.stem, mode) in TESTED and "--config" not in arguments
        generate(folder, model, "--mode", mode, *arguments, prefix=known, tested=tested)
    bed.run("colcon", "build", "--packages-select", *BY_COLCON, folder=folder, timeout=600)
    for package in (folder / "src").iterdir():
        if package.name not in BY_COLCON:
            install(bed, package, folder / "install" / package.name)
    bed.compile(folder / "install")


BY_COLCON = ("guarded_arm", "guarded_arm_supervisor", "guarded_arm_monitor")
"""One of each mode: the files that tell colcon what to do differ in nothing but names."""


def install(bed: Bed, package: Path, prefix: Path) -> None:
    """Do what colcon does, which takes ten times as long as to generate a package."""
    name, (site,) = package.name, (prefix.parent / "guarded_arm").glob("lib/python3*/site-packages")
    shutil.copytree(package / name, prefix / site.relative_to(site.parents[2]) / name)
    for part in ("launch", "config", "package.xml"):
        place = prefix / "share" / name / part
        place.parent.mkdir(parents=True, exist_ok=True)
        place.symlink_to(package / part)
    index = prefix / "share" / "ament_index" / "resource_index" / "packages" / name
    index.parent.mkdir(parents=True)
    index.touch()
    program = prefix / "lib" / name / name
    program.parent.mkdir()
    program.write_text(f"#!{bed.python}\nfrom {name}.start import main\n\nmain()\n")
    program.chmod(0o755)


@pytest.fixture
def controller(built: Built, graph: Graph) -> Callable[..., Process]:
    """Starts a generated controller in the test's graph.

    Parameters go by their ROS 2 names, with ``__`` for the dot. The guarded arm's inputs are
    reliable, for a test sends many a message only once.
    """

    def start(
        package: str = "guarded_arm",
        remap: Sequence[str] = (),
        arguments: Sequence[str | Path] = (),
        **parameters: object,
    ) -> Process:
        words = [built.executable(package), "--ros-args", *arguments]
        for rule in remap:
            words += ["-r", rule]
        if package.startswith("guarded_arm"):
            inputs = ("zone", "go", "charge")
            parameters = {f"qos__{i}__reliability": "reliable" for i in inputs} | parameters
        for name, value in parameters.items():
            text = json.dumps(value) if isinstance(value, bool | int | float) else f"'{value}'"
            words += ["-p", f"{name.replace('__', '.')}:={text}"]
        return graph.fork(*words, **built.environment(package))

    return start


ACTION = ("send_goal", "cancel_goal", "get_result", "feedback", "status")
NAMES = {
    "orders": ("order", "switch", "door", "lamp"),
    "missions": ("step", "fault", "lamp", "mission", *(f"mission/_action/{p}" for p in ACTION)),
    "reflector": ("reflect", "shine", *(f"shine/_action/{p}" for p in ACTION)),
}
"""What the controllers of models that are called use, and have elsewhere behind a supervisor."""
INPUTS = {"orders": ("door",), "missions": ("step", "fault"), "reflector": ()}


@pytest.fixture
def guarded(controller: Callable[..., Process]) -> Callable[[str], dict[str, Process]]:
    """Starts the supervisor of a model that is called, which comes first, and its controller."""

    def start(model: str) -> dict[str, Process]:
        quality = {f"qos__{name}__reliability": "reliable" for name in INPUTS[model]}
        rules = [f"/{name}:=/supervised/{name}" for name in NAMES[model]]
        own = controller(f"{model}_controller", rules, **quality)
        first = controller(f"{model}_supervisor", **quality)
        return {f"{model}_supervisor": first, f"{model}_controller": own}

    return start


@pytest.fixture(params=["controller", "supervisor"])
def nodes(
    request: pytest.FixtureRequest,
    controller: Callable[..., Process],
    guarded: Callable[[str], dict[str, Process]],
    model: str,
) -> dict[str, Process]:
    """The controller of a model that is called; once more with its supervisor, which comes first."""
    if request.param == "supervisor":
        return guarded(model)
    quality = {f"qos__{name}__reliability": "reliable" for name in INPUTS[model]}
    return {f"{model}_controller": controller(f"{model}_controller", **quality)}


@pytest.fixture
def watcher(graph: Graph, nodes: dict[str, Process]) -> Peer:
    """Watches the nodes, once the supervisor, if there is one, knows its controller."""
    peer = graph.peer()
    for node in nodes:
        peer.watch(node)
        peer.expect_state(node, lambda s: "supervised" not in str(s["unconnected"]))
    return peer
