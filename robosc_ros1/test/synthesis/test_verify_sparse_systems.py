"""Few states under control of a plant that has too many: verified one by one."""

from __future__ import annotations

from dataclasses import replace

import pytest
from emit.generated_code import supervisor_of

from robosc.expr.tree import Literal
from robosc.expr.types import BooleanType
from robosc.supervisor import Supervisor
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
    assert "plant states" not in [check.name for check in report.checks]


@pytest.mark.parametrize(("value", "failing"), [(False, "maximally permissive"), (True, "safe")])
def test_a_wrong_guard_is_found(supervisor: Supervisor, value: bool, failing: str) -> None:
    first, *others = supervisor.guards
    wrong = replace(first, expr=Literal(value, BooleanType()))
    report = verify(replace(supervisor, guards=(wrong, *others)))
    assert next(check.name for check in report.checks if not check.holds) == failing
