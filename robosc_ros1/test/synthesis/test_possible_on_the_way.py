"""*Always possible* under control: states that run to completion passes through are on the way."""

from __future__ import annotations

import pytest
from synthesis.subject import oracle_of, robot_of
from synthesis.test_oracle_differential import engines

from robosc import pipeline

ROBOT = """
robot Transient {
    component C {
        outgoing message m with type: none
        outgoing message n with type: none
        behaviour {
            initial marked state a { on response from m goto b }
            state b {
                transition goto x
                transition goto c
            }
            state x { transition goto c }
            marked state c { on response from n goto a }
        }
    }
    requirement possible %s
}
"""


@pytest.mark.parametrize(
    ("goal", "holds"),
    [
        ("C.c from C.a while !C.x", False),
        ("C.c from C.a while !C.b", False),
        ("C.c from C.a", True),
        ("C.x from C.a", True),
        ("C.x from C.a while !C.c", True),
        ("C.a from C.c while !C.x", True),
        ("C.x from C.c while !C.b", False),
    ],
)
@engines
def test_what_is_passed_through(engine: str, goal: str, holds: bool) -> None:
    supervisor = pipeline.synthesize(robot_of(ROBOT % goal), engine)
    if supervisor.empty:  # not even the controlled system can
        assert not holds
        return
    assert dict(supervisor.properties)["always possible"] is holds
    assert oracle_of(ROBOT % goal).properties()["always possible"] is holds
