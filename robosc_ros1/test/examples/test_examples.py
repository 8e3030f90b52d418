"""Every example says what its README promises."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from ros_support import EXAMPLES, Completed

Robosc = Callable[..., Completed]

LIBRARIES = sorted(EXAMPLES.glob("*/libraries/*.rscd"))
MODELS = sorted({*EXAMPLES.glob("*/*.rscd"), *EXAMPLES.glob("gallery/*/*.rscd")} - {*LIBRARIES})
SCRIPTS = sorted(EXAMPLES.glob("*/*.sim"))
FORGOTTEN = EXAMPLES / "tutorial" / "6_forgotten.rscd"
UNHANDLED = EXAMPLES / "line_follower_unhandled" / "line_follower_unhandled.rscd"
RESTRICTED = (EXAMPLES / "two_robots" / "two_robots.rscd", EXAMPLES / "zones" / "zones.rscd")
"""Their warnings are what they show."""


def test_there_are_examples() -> None:
    assert len(MODELS) >= 2
    assert SCRIPTS


@pytest.mark.parametrize(
    "model",
    [m for m in MODELS if m not in (FORGOTTEN, UNHANDLED, *RESTRICTED)],
    ids=lambda m: m.stem,
)
def test_example_is_clean(model: Path, robosc: Robosc) -> None:
    done = robosc("check", str(model))
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.stem)
def test_supervisor_of_the_example_is_proven(model: Path, robosc: Robosc) -> None:
    done = robosc("verify", str(model))
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda s: s.stem)
def test_controller_of_the_example_does_what_its_script_expects(
    script: Path, robosc: Robosc
) -> None:
    own = script.with_suffix(".rscd")
    model = own if own.exists() else script.parent / f"{script.parent.name}.rscd"
    done = robosc("simulate", str(model), "--execute", "--script", str(script))
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.stem)
def test_example_has_a_readme(model: Path) -> None:
    assert (model.parent / "README.md").is_file()


def test_unhandled_error_forbids_the_grab(robosc: Robosc) -> None:
    done = robosc("check", str(UNHANDLED))
    assert done.returncode == 0
    assert "warning[never-allowed]: grab.request can never be allowed" in done.stderr
    assert "grab.error" in done.stderr
    assert "ObstacleGrabber.grabbing" in done.stderr
    assert "on error from grab goto idle" in done.stderr


def test_readme_shows_what_is_told(robosc: Robosc) -> None:
    done = robosc("check", str(UNHANDLED))
    readme = (UNHANDLED.parent / "README.md").read_text(encoding="utf-8")
    told = done.stderr.replace(str(UNHANDLED), UNHANDLED.name) + done.stdout
    assert " ".join(told.split()) in " ".join(readme.split())


@pytest.mark.parametrize("model", MODELS + LIBRARIES, ids=lambda m: m.stem)
def test_example_has_the_canonical_layout(model: Path, robosc: Robosc) -> None:
    assert robosc("format", "--check", str(model)).returncode == 0


def test_the_remedy_that_is_told_helps(robosc: Robosc, tmp_path: Path) -> None:
    text = UNHANDLED.read_text(encoding="utf-8")
    handled = "on response from grab goto idle\n on error from grab goto idle"
    mended = text.replace("on response from grab goto idle", handled)
    assert mended != text
    (tmp_path / "mended.rscd").write_text(mended, encoding="utf-8")
    assert "grab.request can never be allowed" not in robosc("check", "mended.rscd").stderr


def test_the_door_of_the_readme_is_the_example() -> None:
    """Which the page completes by a line, in the course of its story."""
    readme = (EXAMPLES.parent / "README.md").read_text(encoding="utf-8")
    shown = readme[readme.index("robot Door {") :].partition("\n```")[0] + "\n"
    door = (EXAMPLES / "door" / "door.rscd").read_text(encoding="utf-8")
    missing = "                on error from turn goto resting\n"
    assert missing in readme
    assert shown == door.replace(missing, "")
