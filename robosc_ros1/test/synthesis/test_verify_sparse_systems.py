"""Few states under control of a plant that has too many: verified one by one."""

from __future__ import annotations

from dataclasses import replace

import pytest
from emit.generated_code import supervisor_of
from robot_families import zones, zones_by_hand
from synthesis.plants import plant_of

from robosc.expr.tree import Literal
from robosc.expr.types import BooleanType
from robosc.supervisor import Supervisor
from robosc.synthesis import compute
from robosc.synthesis.verify.verification import verify

SWITCHES = """robot Switches {
    component Switch[1..21] {
        incoming message on with type: none
        incoming message off with type: none
        behaviour {
            initial marked state out { on request to on goto lit }
            state lit { on request to off goto out }
        }
    }
    for i in 1..21 { requirement Switch[i].on needs count(s.lit for s in Switch) < 1 }
    stop with nothing
}"""


@pytest.fixture(scope="module")
def supervisor() -> Supervisor:
    return supervisor_of(SWITCHES)


def test_it_is_verified_without_sets_of_states(supervisor: Supervisor) -> None:
    assert supervisor.plant_states == 2**21
    assert supervisor.engine == "explicit"
    report = verify(supervisor)
    assert (report.verified, report.method) == (True, "explicit")
    assert (report.states, report.transitions) == (22, 42)
    assert "plant states" in [check.name for check in report.checks]
    wrong = verify(replace(supervisor, plant_states=2**21 - 1))
    assert [check.name for check in wrong.checks if not check.holds] == ["plant states"]


def test_zones_are_searched_as_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few states in a plant of millions; given on to the symbolic engine where they are many."""
    states, steps = zones_by_hand(5, 9)
    for most in (2**13, states - 1):
        monkeypatch.setattr(compute, "_FEW_NODES", 0)
        for name in ("_FEW_GUARDED", "_MOST_GUARDED"):
            monkeypatch.setattr(compute, name, most)
        supervisor = compute.synthesize(plant_of(zones(5, 9)))
        assert supervisor.engine == ("explicit" if most > states else "bdd")
        assert supervisor.controlled_states == states
        assert supervisor.controlled_transitions == steps
        report = verify(supervisor)
        assert (report.verified, report.method) == (True, "explicit")


@pytest.mark.parametrize(("value", "failing"), [(False, "maximally permissive"), (True, "safe")])
def test_a_wrong_guard_is_found(supervisor: Supervisor, value: bool, failing: str) -> None:
    first, *others = supervisor.guards
    wrong = replace(first, expr=Literal(value, BooleanType()))
    report = verify(replace(supervisor, guards=(wrong, *others)))
    assert next(check.name for check in report.checks if not check.holds) == failing
