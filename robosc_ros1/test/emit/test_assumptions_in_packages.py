"""Nodes treat what the robot is assumed not to do as a mismatch, and the test of a package knows."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from emit.generated_code import controller_class, supervisor_of
from emit.scripted_controllers import faults_of
from runtime.lamp_robot import PlayedPort

from robosc.plant.acceptance import gates_of
from robosc.runtime.core.commanding import controller_engine

MODEL = """
robot Lifter {
    datatype object Grip { force: integer(0..3) }
    datatype object Level { height: double }
    component Door {
        outgoing message door with identifier: "/door", type: integer(0..3)
        behaviour {
            variable gap: integer(0..3) = 0
            initial marked state watched { on response from door do gap := value }
        }
    }
    component Lift {
        action lift with identifier: "/lift", request: none, response: Grip,
            feedback: Grip links lift_it
        service level with identifier: "/level", request: none, response: Level links measure
        behaviour {
            variable height: double = 0.0
            initial marked state still {
                on request to lift goto moving
            }
            state moving {
                on response from lift goto still
                on error from lift goto still
                on cancelled from lift goto still
            }
            on response from level do height := value.height
        }
    }
    interface lift_it use Lift from lift_interfaces
    interface measure use Measure from lift_interfaces
    requirement never Door.gap > 1 and Lift.moving
    requirement lift needs Door.gap = 0 and Lift.height < 2
    assume always !(Door.gap > 1 and Lift.moving)
    assume never Lift.height > 5
    assume door needs value != 2
    assume lift needs Lift.moving and value.force > 0
}
"""


def test_what_is_assumed_away_is_not_played() -> None:
    assert faults_of(supervisor_of(MODEL)) == []


FAULTS = {
    "refuses what is not": ('value > 1 and self.lift == "moving"', "value > 1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_test_of_a_package_finds(fault: str) -> None:
    assert faults_of(supervisor_of(MODEL), *FAULTS[fault]) != []


HEARD = """
robot Rover {
    component Base {
        outgoing message fix with type: none
        outgoing message goal with type: boolean
        incoming message go with type: none
        behaviour {
            variable wanted: boolean = false
            initial marked state only {
                on response from goal do wanted := value
                on request to go
            }
        }
    }
    requirement go needs Base.wanted and fix.heard
    assume always fix.heard
    assume always fix.heard or !Base.wanted
}
"""


def test_what_was_heard_stays_so() -> None:
    """So nothing is excluded by assuming that, but that a goal comes before."""
    plant = supervisor_of(HEARD).plant
    found = {event.name: bool(gates_of(event)) for event in plant.events}
    assert found == {"fix": False, "goal": True, "go": False}


SCALE = """
robot Scale {
    datatype object Mass { grams: integer(0..9) }
    component Pan {
        service weigh with identifier: "/weigh", request: none, response: Mass links weigh_it
        action tip with identifier: "/tip", request: none, response: Mass, feedback: none
            links tip_it
        behaviour {
            variable told: integer(0..9) = 0
            on error from weigh if reason = refused goto odd
            on error from weigh else goto broken
            on error from tip if reason = refused do told := value.grams goto odd
            on error from tip else goto broken
            initial marked state idle {
                on request to weigh
                on request to tip
            }
            marked state odd {}
            marked state broken {}
        }
    }
    interface weigh_it use Weigh from scale_msgs
    interface tip_it use Tip from scale_msgs
    requirement weigh needs Pan.told = 0
    assume weigh needs value.grams > 3
    assume tip needs value.grams > 3
}
"""


@pytest.mark.parametrize(("call", "told"), [("weigh", 0), ("tip", 2)])
def test_an_answer_that_breaks_an_assumption_is_refused(call: str, told: int) -> None:
    """On the other side of the plant, where an error may then have that reason."""
    supervisor = supervisor_of(SCALE)
    (error,) = (e for e in supervisor.plant.events if (e.kind.word, e.name) == ("error", call))
    (reason,) = (p for p in error.parameters if "failed" in p.values)
    assert "refused" in reason.values
    port = PlayedPort()
    engine = controller_engine(controller_class(supervisor)[0](), port)
    engine.begin()
    engine.cycle()
    key = f"Pan.{call}"
    engine.report(key, port.tokens[key], "response", SimpleNamespace(grams=2))
    engine.cycle()
    assert engine.controller.components() == {"Pan": "odd"}
    assert engine.controller.variables()["Pan.told"] == told
    ends = [e for e in engine.recorder.take() if e.name == call and e.kind != "request"]
    assert [(e.kind, e.outcome) for e in ends] == [("response", "mismatch"), ("error", "applied")]
    assert ends[1].reason == "refused"
