"""The duration of a package's own test: it goes on while its rounds cover new cases."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from emit.generated_code import controller_source
from emit.golden_packages import package_of
from emit.judged_controllers import Robot, guide_of, judged, judging_model, judging_modules
from ros_support import EXAMPLES

from robosc import pipeline

SWITCH = """
robot Switch {
    component Lamp {
        incoming message shine with identifier: "/shine", type: none
        outgoing message level with identifier: "/level", type: double
        behaviour {
            initial marked state off { on response from level if value > 3 goto on }
            marked state on { on response from level if value <= 1 goto off }
        }
    }
    requirement shine needs Lamp.on
}
"""


@pytest.fixture(scope="module")
def switch(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    with judging_model(tmp_path_factory.mktemp("switch"), SWITCH) as judging:
        yield judging


def played(new_at: Callable[[int], bool], fault_at: int | None = None, least: int = 0) -> int:
    """The seconds of a test of ten whose rounds last one each; some cover a new case."""
    judge = SimpleNamespace(faults=[], guide=SimpleNamespace(news=0))
    time = 0

    def play() -> None:
        nonlocal time
        time += 1
        judge.guide.news += new_at(time)
        judge.faults += ["a fault"] * (time == fault_at)

    play_rounds = importlib.import_module("play_loop").play_rounds
    play_rounds(judge, 10, play, least, now=lambda: time)
    return time


@pytest.mark.parametrize(
    ("new_at", "duration"),
    [
        (lambda time: False, 10),
        (lambda time: time <= 3, 10),
        (lambda time: time == 4, 11),
        (lambda time: time in (9, 15, 21), 28),
        (lambda time: time in (9, 15, 23), 22),
        (lambda time: True, 40),
    ],
)
def test_it_goes_on_while_there_are_new_cases_up_to_a_limit(
    switch: tuple[Any, str], new_at: Callable[[int], bool], duration: int
) -> None:
    assert played(new_at) == duration


@pytest.mark.parametrize("fault_at", [1, 15, 40])
def test_it_ends_at_a_fault(switch: tuple[Any, str], fault_at: int) -> None:
    assert played(lambda time: True, fault_at, least=50) == fault_at


def test_it_plays_the_least_number_of_rounds(switch: tuple[Any, str]) -> None:
    assert played(lambda time: False, least=12) == 12
    assert played(lambda time: True, least=50) == 50


def test_a_small_model_needs_no_more_and_a_large_one_gets_it(
    switch: tuple[Any, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the real guide: the same rounds, and more where they cover something."""

    def news(judging: Any, source: str, patience: float) -> int:
        rounds = importlib.import_module("play_loop")
        monkeypatch.setattr(rounds, "PATIENCE", patience)
        judge = judged(judging, source, rounds=40)
        assert judge.faults == []
        return int(judge.guide.news)

    assert news(*switch, 0.7) == news(*switch, 0.0) > 0
    kobuki = pipeline.synthesize(pipeline.load(EXAMPLES / "kobuki/kobuki.rscd").robot)
    with judging_modules(tmp_path, kobuki) as judging:
        source = controller_source(kobuki)
        assert news(judging, source, 0.7) > news(judging, source, 0.0)


def test_a_case_that_was_given_up_and_comes_back_is_not_new(switch: tuple[Any, str]) -> None:
    judging, _ = switch
    robot = Robot(judging, 1, lambda data: data)
    guide = guide_of(judging, robot)
    shadow = importlib.import_module("reference_model").ReferenceModel(judging.PLANT)
    other = guide_of(judging, robot)
    steps = []
    while (step := guide.next(shadow)) is not None:
        steps.append(step)  # but nothing happens
    for kind, keys, message in steps:
        assert kind == "publish"
        for key in keys:
            content = shadow.content(key, "response", message)
            guide.see_event(shadow, "response", key, content)
            other.see_event(shadow, "response", key, content)
    assert other.news > 0
    assert guide.news == 0


@pytest.mark.parametrize("mode", ["supervisor", "monitor"])
@pytest.mark.parametrize("seconds", [0.0, 10.0, 600.0])
def test_rostest_waits_for_the_longest_test(
    switch: tuple[Any, str], mode: str, seconds: float
) -> None:
    """And for an answer that does not come, and for what has to start."""
    package = package_of("gauntlet", mode=mode)
    text = package.files[f"test/gauntlet_{mode}.test"].content
    found = re.search(r'time-limit="\$\(eval (.*?)\)"', text)
    assert found is not None
    longest = importlib.import_module("play_loop").LIMIT * seconds
    assert eval(found[1], {"arg": {"seconds": seconds}.__getitem__}) > longest + 120
