"""Monitors and shadows of models that decide on the data of commands or correct them, on a real
roscore."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from emit.golden_packages import GOLDEN
from ros1.stage import Puppet, Stage, event
from ros_support import EXAMPLES, Workspace, run_robosc
from runtime.schemas import validate

HERE = Path(__file__).parent
MODELS = {
    "limiter_monitor": EXAMPLES / "gallery" / "limiter" / "limiter.rscd",
    "crane_monitor": HERE / "crane.rscd",
    "carriage_monitor": HERE / "carriage.rscd",
}
FLOAT = "std_msgs/Float32"
FINDINGS = "/crane_monitor/findings"


@pytest.fixture(scope="module")
def data_workspace(make_workspace: Callable[[], Workspace]) -> Workspace:
    workspace = make_workspace()
    workspace.add(GOLDEN / "models" / "gauntlet_interfaces")
    env = {"ROS_PACKAGE_PATH": str(GOLDEN / "models")}
    for package, model in MODELS.items():
        mode = package.rpartition("_")[2]
        where = ("--output", str(workspace.folder / "src"), "--mode", mode, "--package", package)
        done = run_robosc(("generate", str(model), *where), workspace.folder, env)
        assert done.returncode == 0, done.stderr
    workspace.build()
    return workspace


@pytest.fixture
def stage(data_workspace: Workspace, shared_master: Any) -> Stage:
    return Stage(data_workspace, shared_master)


@pytest.fixture
def driver(stage: Stage) -> Iterator[Puppet]:
    with stage.puppet() as running:
        running.do("listen", topic=FINDINGS, type="std_msgs/String")
        yield running


def lift(driver: Puppet, height: float) -> None:
    driver.do("publish", topic="/hoist", type=FLOAT, fields={"data": height})


@pytest.mark.parametrize("package", [name for name in MODELS if name.endswith("_monitor")])
def test_its_own_test_passes(data_workspace: Workspace, package: str) -> None:
    done = data_workspace.own_test(package)
    assert done.returncode == 0, done.stdout


def test_what_was_sent_and_what_it_would_have_become(stage: Stage, driver: Puppet) -> None:
    with stage.controller(driver, "crane_monitor") as monitor:
        driver.steadily("/limit", FLOAT, 2.0)
        monitor.shows(lambda s: s["variables"]["Limit.most"] == 2.0)
        lift(driver, 1.5)
        monitor.tells(event("request", "hoist", outcome="applied", value=1.5))
        lift(driver, 5.0)
        lift(driver, -1.0)
        monitor.tells(event("request", "hoist", outcome="forbidden", value=-1.0))
    documents = [json.loads(m["data"]) for m in driver.all_heard(FINDINGS)]
    for document in documents:
        validate(document, "finding")
    assert [(d["sort"], d["event"]["value"]["data"]) for d in documents] == [
        ("corrected", 5.0), ("violation", -1.0)
    ]  # fmt: skip
    assert documents[0]["reasons"][0]["because"] == ["data 5.0 becomes 2.0"]


def test_a_shadow_judges_data_and_leaves_to_others_what_they_decide(
    stage: Stage, driver: Puppet
) -> None:
    with stage.controller(driver, "carriage_monitor", shadow=True) as shadow:
        driver.steadily("/wish", FLOAT, 3.0)
        shadow.shows(lambda s: s["variables"]["Wish.speed"] == 3.0)
        for speed, outcome in ((4.0, "applied"), (40.0, "forbidden")):
            driver.do("publish", topic="/drive", type=FLOAT, fields={"data": speed})
            shadow.tells(event("request", "drive", outcome=outcome, seen=True))
        state = shadow.shows(lambda s: s["counters"]["forbidden"] == 1)
        assert (state["counters"]["commands"], state["counters"]["withheld"]) == (1, 0)
