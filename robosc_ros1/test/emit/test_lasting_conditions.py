"""Conditions that must have held for some time: ``condition still = E for 300 ms``."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.scripted_controllers import faults_of, scripts_of, tells_apart
from emit.test_cif import check
from emit.test_controller_follows_the_plant import Twin, walk_through

from robosc.model.resolve import load
from robosc.plant.model_text import to_dsl
from robosc.runtime.core.model import Controller
from robosc.source import Source

MODEL = """
robot Still {
    component Base {
        outgoing message speed with timeout: 200 ms, type: integer(0..3)
        outgoing message lifted with type: boolean
        incoming message grip with type: none
        incoming message drive with type: none
        incoming message warn with type: none
        service load with request: none, response: none links loading
        condition still = fast < 1 and !up for 300 ms
        behaviour {
            variable fast: integer(0..3) = 1
            variable up: boolean
            initial marked state on {
                on response from speed do fast := value
                on response from lifted do up := value
                on request to load goto loading
                transition if up and fast > 2 do up := false
            }
            marked state loading {
                on response, error from load goto on
                after 100 ms do up := false
            }
        }
    }
    condition safe = Base.still or Base.loading for 500 ms
    interface loading use Trigger from std_srvs
    requirement grip needs Base.still
    requirement drive needs !Base.still
    requirement warn needs safe
    requirement load needs Base.still and speed.fresh
}
"""


def test_it_is_read_twice_and_exported() -> None:
    robot, _ = load(Source("model.rscd", MODEL))
    assert robot is not None
    check(robot)


def test_guards_say_it_as_models_do() -> None:
    supervisor = supervisor_of(MODEL)
    texts = {g.event.name: to_dsl(g.expr, supervisor.plant.robot) for g in supervisor.guards}
    assert texts["grip"] == "Base.still"
    assert texts["drive"] == "!Base.still"
    assert texts["warn"] == "safe"


@pytest.mark.parametrize("seed", range(4))
def test_generated_code_follows_the_plant(seed: int) -> None:
    walk_through(Twin(MODEL), random.Random(seed))


def test_the_test_of_a_package_follows_it() -> None:
    assert faults_of(supervisor_of(MODEL)) == []


FAULTS = {
    "silence does not count": ("return self.speed_fresh and", "return"),
    "too early": ("delay=0.3", "delay=0.1"),
    "an event is forgotten": ('self.follow("Base.still", before_1)\n', "pass\n"),
    "another condition": ('"Base.still": (is_base_still,', '"Base.still": (is_safe,'),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_test_of_a_package_finds(fault: str) -> None:
    assert faults_of(supervisor_of(MODEL), *FAULTS[fault]) != []


def _never_set_back(self: Controller, name: str, before: bool) -> None:
    """Do nothing."""


def _holds_on(self: Controller, name: str, before: bool) -> None:
    holds, _, entries = self.LASTING[name]
    if holds(self) != before:
        setattr(self, entries, getattr(self, entries) + 1)


def _clock_goes_on(self: Controller, name: str, before: bool) -> None:
    holds, location, _ = self.LASTING[name]
    if before and not holds(self):
        setattr(self, location, "waiting")


@pytest.mark.parametrize("fault", [_never_set_back, _holds_on, _clock_goes_on])
def test_it_finds_a_fault_in_following(
    fault: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    supervisor = supervisor_of(MODEL)
    scripts = scripts_of(supervisor)
    monkeypatch.setattr(Controller, "follow", fault)
    assert tells_apart(supervisor, scripts, controller_source(supervisor)) != []


def test_a_library_holds_it_for_each_of_its_components(tmp_path: Path) -> None:
    (tmp_path / "wheels.rscd").write_text(
        """library wheels {
    component Wheel {
        outgoing message turns with identifier: "/turns", timeout: 1 s, type: integer(0..1)
        parameter calm: duration = 1 s
        condition still = turns_now = 0 for calm
        behaviour {
            variable turns_now: integer(0..1)
            initial marked state on { on response from turns do turns_now := value }
        }
    }
}
"""
    )
    text = """robot Cart {
    component Left from wheels import Wheel with prefix: "/left", calm: 2 s
    component Right from wheels import Wheel with prefix: "/right"
    component Ramp { incoming message lower with type: none }
    requirement lower needs Left.still and Right.still
}
"""
    (tmp_path / "cart.rscd").write_text(text)
    robot, found = load(Source(str(tmp_path / "cart.rscd"), text))
    assert robot is not None, found
    assert {one.name: one.delay.parameter.default for one in robot.lasting} == {  # type: ignore[attr-defined]
        "Left.still": 2.0,
        "Right.still": 1.0,
    }


@pytest.mark.parametrize(
    ("condition", "code"),
    [
        ("condition c = Base.on for 0 s", "out-of-range"),
        ("condition c = Base.on for Base.on", "type-mismatch"),
        ("condition c = c for 1 s", "initial-not-constant"),
        ("condition Base = Other.on for 1 s", "duplicate-name"),
        ("for i in 1..2 { condition c = Base.on for 1 s requirement go needs c }", "misplaced"),
    ],
)
def test_what_is_wrong_with_it_is_told(condition: str, code: str) -> None:
    text = "component Base { incoming message go with type: none\n"
    text += "behaviour { initial marked state on {} } }\n"
    text += "component Other { behaviour { initial marked state on {} } }\n"
    _, found = load(Source("model.rscd", f"robot R {{ {text} {condition} }}"))
    assert code in {d.code for d in found}


def test_a_statement_behind_a_condition_is_no_duration() -> None:
    text = """robot R {
    component Base { incoming message go with type: none
        behaviour { initial marked state on {} } }
    condition c = Base.on
    for i in 1..2 { requirement go needs c }
}
"""
    robot, found = load(Source("model.rscd", text))
    assert robot is not None, found
    assert robot.lasting == ()


STATIONS = """
robot Row {
    component Station[1..3] {
        outgoing message part with timeout: 1 s, type: boolean
        incoming message go with type: none
        condition settled = there and !resting for 1 s
        behaviour {
            variable there: boolean
            initial marked state working {
                on response from part do there := value
                after 1 s goto resting
            }
            marked state resting { after 2 s goto working }
        }
    }
    condition two = count(s.settled for s in Station) >= 2 for 3 s
    component Base { incoming message halt with type: none }
    for i in 1..3 { requirement Station[i].go needs Station[i].settled }
    requirement halt needs two
}
"""


def test_copies_have_one_each() -> None:
    robot, _ = load(Source("model.rscd", STATIONS))
    assert robot is not None
    assert sorted(one.name for one in robot.lasting) == [
        *(f"Station[{i}].settled" for i in (1, 2, 3)), "two",
    ]  # fmt: skip
    walk_through(Twin(STATIONS), random.Random(1))


def test_a_value_that_may_be_stale_is_told() -> None:
    text = MODEL.replace(
        "outgoing message speed with timeout: 200 ms,", "outgoing message speed with"
    )
    text = text.replace(" and speed.fresh", "")
    _, found = load(Source("model.rscd", text))
    assert "stale-data" in {d.code for d in found}
    _, found = load(Source("model.rscd", MODEL))
    assert "stale-data" not in {d.code for d in found}
