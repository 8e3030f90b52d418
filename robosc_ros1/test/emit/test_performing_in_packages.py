"""States that perform commands: the second reading, CIF, controllers, and tests of packages."""

from __future__ import annotations

import random

import pytest
from emit.generated_code import supervisor_of
from emit.scripted_controllers import faults_of
from emit.test_cif import check
from emit.test_controller_follows_the_plant import Twin, walk_through
from performing_models import PARTS, performing_text, random_machine
from quick import quick_first

from robosc.model.resolve import load
from robosc.source import Source

TOGETHER = """
    component Q {
        behaviour {
            initial marked state one performs go then goto two { on response from near goto two }
            state two performs ask then goto three
            state three performs task.error then goto one
        }
    }
"""
"""It performs with the other one: what each does alone, and what both must be ready for."""

MODEL = """
robot Patrol {
    component Base {
        outgoing message low with type: boolean
        incoming message speed with type: double
        action drive with request: none, response: integer, feedback: none links dock
        action dock with request: none, response: none, feedback: none links dock
        service undock with request: none, response: none links reset
        behaviour {
            variable tries: integer(0..3)
            initial marked state docked performs undock then goto patrol { retry every 100 ms }
            state patrol {
                on response from low if value goto docking
                initial state driving performs drive then goto turning {
                    on response from drive if value = 0 goto driving
                    on error from drive do tries := 3
                    after 5 s goto turning
                }
                state turning performs speed with 0.5 then do tries := 0 goto driving
            }
            state docking performs dock then goto docked {
                on response from low if !value goto stuck
                retry 2 times every 100 ms else do tries := 1 goto stuck
            }
            marked state stuck { on response from low if !value goto docking }
        }
    }
    provide speed with 0.25
    requirement drive needs Base.patrol.driving.performing or Base.tries < 3
    requirement dock needs Base.docking to start
    requirement possible Base.docked from Base.docking
    interface dock use Test from actionlib
    interface reset use Empty from std_srvs
}
"""


DUET = """
robot Duet {
    component P {
        outgoing message near with type: none
        action go with request: none, response: integer, feedback: none links dock
        service ask with request: none, response: none links reset
        behaviour {
            initial marked state one performs go then goto two {
                on response from go if value < 0 goto one
                on request to go do tries := 0
            }
            state two performs ask then goto one { retry 1 times else goto one }
            variable tries: integer(0..1)
        }
    }
    component Q {
        behaviour {
            initial marked state one performs go then goto two { on response from near goto two }
            state two performs ask then goto one
        }
    }
    interface dock use Test from actionlib
    interface reset use Empty from std_srvs
}
"""

SERVED = """
robot Errands {
    datatype object Wish { data: boolean }
    datatype object Told {
        success: boolean
        message: string
    }
    component Errand {
        outgoing service errand with request: Wish, response: Told links link
        outgoing message low with type: boolean
        behaviour {
            variable left: integer(0..2)
            initial marked state free {
                on request from errand if value.data do left := 2 goto busy
            }
            state busy {
                on response from low if value goto failed
                transition if left = 0 goto done
                transition if left > 0 do left := left - 1
            }
            state done performs errand with { success: true } then goto free {
                on response to errand do left := 1
                on response from low if value goto failed
            }
            state failed performs errand.error with { message: "low" } then goto free
        }
    }
    component Witness {
        behaviour {
            initial marked state one { on response from low if !value goto two }
            state two performs errand.error with { message: "seen" } then goto one { on response from low goto one }
        }
    }
    requirement errand needs !Witness.two
    interface link use SetBool from std_srvs
}
"""
"""Answers to a call, performed; two components give the error together."""


@pytest.mark.parametrize("seed", quick_first(range(4), 1))
def test_random_ones_are_read_twice_and_exported(seed: int) -> None:
    draw = random.Random(seed)
    robot = None
    while robot is None:  # from some state no marked one can be reached
        others = TOGETHER if seed % 2 else ""
        text = PARTS % performing_text(random_machine(draw))
        robot, _ = load(Source("model.rscd", f"robot Test {{ {text} {others} }}"))
    check(robot)


@pytest.mark.parametrize("text", [MODEL, SERVED], ids=["commands", "answers"])
@pytest.mark.parametrize("seed", range(2))
def test_the_controller_does_what_the_plant_does(seed: int, text: str) -> None:
    walk_through(Twin(text), random.Random(seed))


@pytest.mark.slow
@pytest.mark.parametrize("text", [MODEL, DUET, SERVED], ids=["alone", "together", "served"])
def test_the_test_of_the_package_agrees(text: str) -> None:
    assert faults_of(supervisor_of(text)) == []


@pytest.mark.parametrize(
    "guard", ["D.p", "D.around", "!D.p", "D.p => D.around", "any(x for x in [D.p, D.around.far])"]
)
def test_a_state_that_stands_for_several_is_one_operand(guard: str) -> None:
    """Such a guard is written out as a chain, which stands beside the state of the component."""
    text = f"""robot Pair {{
        component C {{
            incoming message say with type: none
            outgoing message near with type: none
            behaviour {{
                initial marked state a {{ on request to say if {guard} goto b }}
                marked state b {{ on response from near if {guard} goto a }}
            }}
        }}
        component D {{
            service ask with request: none, response: none links reset
            behaviour {{
                initial marked state p performs ask then goto around
                marked state around {{
                    initial marked state close {{ after 1 s goto far }}
                    state far {{ after 1 s goto p }}
                }}
            }}
        }}
        interface reset use Empty from std_srvs
    }}"""
    walk_through(Twin(text), random.Random(1))
