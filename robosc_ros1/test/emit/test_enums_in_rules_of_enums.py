"""Enums that are functions in the rules of other enums, in generated controllers."""

from __future__ import annotations

from emit.generated_code import supervisor_of
from emit.scripted_controllers import faults_of
from simulate.players import play, session

MODEL = """
robot R {
    interface link use Report from nowhere_msgs
    datatype object Report { levels: array(double) }
    datatype enum Level from double to { value > 1 -> high default -> low }
    datatype enum Trend from Report to {
        Level(value.levels[0]) = low and Level(value.levels[1]) = high -> up
        default -> down
    }
    component A {
        outgoing message reported with type: Trend links link
        incoming message go with type: none
        behaviour {
            variable trend: Trend
            initial marked state on { on response from reported do trend := value }
        }
    }
    requirement go needs A.trend = up
}
"""
"""Nothing but a rule converts to Level."""


def test_an_enum_that_only_rules_convert_to_has_a_function() -> None:
    supervisor = supervisor_of(MODEL)
    player = session(supervisor, execute=True)
    play(player, "reported levels: [0.5, 2]", "expect enabled go", "reported levels: [0.5]")
    play(player, "expect disabled go")
    assert faults_of(supervisor) == []
