"""The judge of a package's own test checks which command comes first: preferences, and cancels."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import Any

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.judged_controllers import judged, judging_modules
from emit.mutants import mutants

from robosc.runtime import scheduler

MODEL = """\
robot Porter {
    interface dock use Fibonacci from actionlib_tutorials

    component Eye {
        outgoing message near with identifier: "/near", timeout: 0.5 s, type: boolean
        outgoing message night with identifier: "/night", type: boolean

        behaviour {
            variable blocked: boolean
            variable dark: boolean
            on response from near do blocked := value
            on response from night do dark := value
            initial marked state watching {}
        }
    }

    component Base {
        incoming message halt with identifier: "/halt", type: none
        incoming message drive with identifier: "/drive", type: none
        incoming message creep with identifier: "/creep", type: none
        incoming message beep with identifier: "/beep", type: none
        action approach with identifier: "/approach", request: none, response: none, feedback: none
            links dock
    }

    requirement drive needs near.fresh and !Eye.blocked
    requirement creep needs near.fresh
    requirement approach needs near.fresh and !Eye.blocked
    requirement approach needs !Eye.dark to start
    prefer drive over creep
    prefer { drive, creep } over halt
}
"""


@pytest.fixture(scope="module")
def source() -> str:
    return controller_source(supervisor_of(MODEL))


@pytest.fixture(scope="module")
def judging(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with judging_modules(tmp_path_factory.mktemp("order"), supervisor_of(MODEL)) as judge:
        yield judge


@pytest.mark.parametrize("seed", range(3))
def test_it_is_content_with_the_controller(judging: Any, source: str, seed: int) -> None:
    judge = judged(judging, source, seed)
    assert judge.faults == []
    assert judge.events["cancel", "approach", 0] > 5


def test_it_finds_cancels_for_what_only_the_start_needs(judging: Any, source: str) -> None:
    command = "return not self.requirement_3()"
    assert source.count(command) == 1
    wrong = source.replace(command, command + " or not self.requirement_4()")
    (fault,) = judged(judging, wrong).faults
    assert fault.startswith("cancel of approach is reported, reason: nothing; wrong: the require")


def test_it_finds_preferences_that_are_not_kept(judging: Any, source: str) -> None:
    planted = [mutant for mutant in mutants(source) if mutant.kind == "preference"]
    found = [judged(judging, mutant.source).faults[0].partition(": ")[2] for mutant in planted]
    assert found == [
        "request of Base.halt while Base.drive is enabled, which is preferred",
        "request of Base.creep while Base.drive is enabled, which is preferred",
    ]


def test_it_finds_cancels_that_come_too_late(
    judging: Any, source: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    push = scheduler.heappush

    def requests_first(heap: list[Any], entry: tuple[Any, ...]) -> None:
        push(heap, (not entry[0], *entry[1:]) if len(entry) == 3 else entry)

    monkeypatch.setattr(scheduler, "heappush", requests_first)
    faults = judged(judging, source).faults
    due = " requested before the cancel of Base.approach, which was due"
    assert faults and all(fault.endswith(due) for fault in faults)


def test_a_supervisor_leaves_preferences_to_the_other_controller(
    judging: Any,
) -> None:
    guarding = importlib.import_module("guard_checker")
    for make in (judging.Checker, guarding.GuardChecker):
        shadow = make(None, (), None).shadow
        shadow.phase["Eye.near"] = "fresh"
        assert shadow.is_enabled("request", "Base.drive")
        if make is judging.Checker:
            with pytest.raises(judging.Wrong, match="which is preferred"):
                shadow.happen("request", "Base.halt", None)
        else:
            shadow.happen("request", "Base.halt", None)
