"""What docs/simulate.md and docs/bags.md show of runs is what robosc prints of such runs."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from emit.generated_code import supervisor_of
from ros_support import EXAMPLES, REPOSITORY, Completed
from simulate.players import MODEL, line_follower, session
from simulate.test_replay import changed, find, lines_of, run_of, write

Robosc = Callable[..., Completed]
DRIVES = ("distance 0.5", "set_light_state.response", "wait 0.4", "distance 0.5", "wait 0.4",
          "distance 0.2")  # fmt: skip


def shown(page: str, verb: str) -> str:
    """The output that a page shows of its only command that begins so."""
    text = (REPOSITORY / "docs" / page).read_text(encoding="utf-8")
    (found,) = re.findall(rf"^\$ robosc {verb} [^\n]*\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return str(found)


def test_an_expectation_that_fails(robosc: Robosc, tmp_path: Path) -> None:
    script = "distance 0.2\nstop\nexpect Motor.stopped\nexpect Motor.moving\n"
    (tmp_path / "obstacle.sim").write_text(script)
    done = robosc("simulate", str(MODEL), "--script", "obstacle.sim")
    assert done.stderr + done.stdout == shown("simulate.md", "simulate line_follower.rscd --script")


def test_a_log_that_leaves_the_model(robosc: Robosc, tmp_path: Path) -> None:
    log = lines_of(run_of(session(line_follower(), execute=True), *DRIVES))
    write(tmp_path / "events.log", changed(log, find(log, "stop"), name="move"))
    done = robosc("replay", str(MODEL), "events.log")
    assert done.stdout.replace(str(MODEL), MODEL.name) == shown("simulate.md", "replay")


def test_a_bag_of_a_controller_with_faults(robosc: Robosc, tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    from simulate.test_judged_bags import recorded

    model = EXAMPLES / "line_follower" / "line_follower.rscd"
    recorded(
        supervisor_of(model.read_text(), str(model)), tmp_path, "bag", seed=1,
        lawless=("move", "grab"),
        lawless_at=lambda time: 4.3 < time < 4.9 or 7.2 < time < 7.3,
    )  # fmt: skip
    done = robosc("replay", str(model), "run.bag")
    assert done.stdout.replace(str(model), model.name) == shown("bags.md", "replay")
