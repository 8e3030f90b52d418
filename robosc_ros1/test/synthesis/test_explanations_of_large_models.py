"""One missing line in a robot with many parts: the reason and the line, found in time.

Each model is known by hand. What stands beside the fault (sensors with timeouts, a mission) makes
the states very many, and must not keep the reason from being found.
"""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from synthesis.plants import event_of, plant_of, supervisor_of

from robosc.errors import listing
from robosc.plant.automaton import PlantState
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.faults import UNSAFE, ExplicitFaults, Round, way_through_rounds
from robosc.synthesis.time_limit import ExplanationTime

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")

SENSOR = """
    component Sensor{0} {{
        outgoing message sensed{0} with identifier: "/sensed{0}", timeout: 1 s, type: double
        behaviour {{
            variable value_of: double
            initial marked state on_ {{ on response from sensed{0} do value_of := value }}
        }}
        condition near = value_of < 0.5
    }}
"""
TOUR = """
    interface act use Test from actionlib
    interface set use SetBool from std_srvs
    component Base {
        action go with identifier: "/go", request: none, response: none, feedback: none links act
    }
    component Tour {
        behaviour {
            initial marked state home { transition if sensed0.fresh goto tour }
            state tour {
                initial state a performs go then goto b { retry 2 times every 3 s else goto back }
                state b performs go then goto back { retry 2 times every 3 s else goto back }
            }
            state back performs go then goto home { retry every 3 s }
        }
    }
"""
LAMP = """
    component Lamp {
        service lamp with identifier: "/lamp", request: none, response: none links set
        behaviour {
            initial marked state dark { on request to lamp goto switching }
            state switching { on response from lamp goto lit }
            state lit { on request to lamp goto dimming }
            state dimming {
                on response from lamp goto dark
                on error from lamp goto lit
            }
        }
    }
"""
ARM = """
    component Arm {
        action tuck with identifier: "/tuck", request: none, response: none, feedback: none links act
        action pick with identifier: "/pick", request: none, response: none, feedback: none links act
        outgoing message order with identifier: "/order", type: none
        behaviour {
            initial state out { on request to tuck goto moving }
            state moving {
                on request to tuck
                on response from tuck goto tucked
                on error, cancelled from tuck goto out
                on request to pick
                on response from pick goto out
                on error, cancelled from pick goto out
            }
            marked state tucked {
                on request to tuck goto moving
                on request to pick goto moving
            }
        }
        requirement tuck needs pick.idle
    }
    component Job {
        behaviour {
            initial marked state free { on response from order goto tucking }
            state tucking performs tuck then goto picking { retry every 5 s }
            state picking performs pick then goto stowing
            state stowing performs tuck then goto free { retry every 5 s }
        }
    }
"""
CALLED = """
    component Called {
        outgoing message bell with identifier: "/bell", type: none
        incoming message call with identifier: "/call", type: none
        behaviour {
            initial marked state free { on response from bell goto waiting }
            state waiting { on request to call goto free }
        }
    }
"""


def robot(parts: str, sensors: int, requirement: str = "") -> str:
    beside = "".join(SENSOR.format(number) for number in range(sensors))
    needs = listing([f"sensed{n}.fresh" for n in range(sensors)], "and").replace(",", " and")
    return f"robot Many {{{beside}{parts}\n    requirement go needs {needs}\n{requirement}}}"


def told(found: Supervisor) -> dict[str | None, tuple[str, str | None]]:
    return {e.event and e.event.name: (e.reason, e.remedy) for e in found.explanations}


@pytest.mark.parametrize("sensors", [1, 8])
def test_a_forgotten_error_among_many_sensors(sensors: int) -> None:
    found = supervisor_of(robot(TOUR + LAMP, sensors), "bdd")
    assert told(found) == {
        "lamp": (
            "lamp.request can never be allowed: after lamp.request the controller cannot prevent"
            " lamp.error; then Lamp is stuck in Lamp.switching, from where no marked state can be"
            " reached",
            "add 'on error from lamp goto dark' in state switching of Lamp",
        )
    }


@pytest.mark.parametrize("sensors", [1, 8])
def test_a_requirement_that_a_mission_cannot_keep(sensors: int) -> None:
    never = "    requirement never Sensor0.near and go.busy\n"
    found = supervisor_of(robot(TOUR, sensors, never), "bdd")
    reason, remedy = told(found)["Tour"]
    assert reason.endswith("'requirement never Sensor0.near and go.busy' fails")
    assert remedy is not None
    assert "relax the requirement" in remedy


@pytest.mark.parametrize("sensors", [1, 8])
def test_two_requirements_that_never_hold_together(sensors: int) -> None:
    """Of a large model no conflict is looked for, so the reason has to name both."""
    first, other = "requirement call needs sensed0.fresh", "requirement call needs sensed0.silent"
    found = supervisor_of(robot(TOUR + CALLED, sensors, f"{first}\n{other}\n"), "bdd")
    assert found.empty
    ((reason, remedy),) = told(found).values()
    assert reason.endswith(
        "Called is stuck in Called.waiting, from where no marked state can be reached"
    )
    assert remedy == (
        f"call.request would lead on, but '{first}' and '{other}' cannot hold together from there"
        " on: correct one of the conditions"
    )
    (explanation,) = found.explanations
    assert explanation.diagnostic.notes[0].span.text == first


@pytest.mark.parametrize("sensors", [1, 6])
def test_a_job_that_is_lost_by_an_error_later_on(sensors: int) -> None:
    """Where nothing that must be avoided follows at once, the ways back are followed."""
    text = robot(TOUR + ARM, sensors)
    found = supervisor_of(text, "bdd")
    assert found.empty
    ((reason, remedy),) = told(found).values()
    assert "each way back to a marked state passes through states that must be avoided" in reason
    assert "pick.request, pick.error, Job is stuck in Job.picking" in reason
    assert remedy == "add 'on error from pick goto free' in state picking of Job"


def test_without_time_guards_are_the_same_and_reasons_are_left_out() -> None:
    plant = plant_of(robot(TOUR + LAMP, 3))
    whole, bare = synthesize(plant, "bdd"), synthesize(plant, "bdd", explain_seconds=0)
    assert bare.guards == whole.guards
    assert bare.explanations == ()
    (left_out,) = (d for d in bare.diagnostics if d.code == "explanations-left-out")
    assert "lamp.request" in left_out.message


def test_an_empty_supervisor_is_told_without_time() -> None:
    plant = plant_of(robot(TOUR + ARM, 1))
    (explanation,) = synthesize(plant, "bdd", explain_seconds=0).explanations
    assert "--explain-seconds" in explanation.reason


def test_ways_end_in_states_with_the_fault() -> None:
    """Each step of a way is a step of the plant, and only its last state has the fault."""
    plant = plant_of(f"robot Arm {{ interface act use Test from actionlib {ARM} }}")
    stepper = Stepper(plant)
    search = ExplicitFaults(stepper, lambda state: False, ExplanationTime(math.inf))
    way = search.way(plant.initial, ("blocked",), forced=False)
    assert way is not None
    assert [search.has(state, "blocked") for state in way] == [False] * (len(way) - 1) + [True]
    for before, after in pairwise(way):
        assert any(after == t for e in stepper.required() for _, t in e.targets(before))
    path = list(way_through_rounds(search, plant.initial))
    assert search.round_of(path[0]) == max(map(search.round_of, path))
    assert search.way(path[-1], Round(0, "earlier"), forced=False) is None


def test_nothing_is_searched_behind_a_state_that_violates_a_requirement() -> None:
    """Half of the time of zones 8 11 went into what follows where two robots are in one zone."""
    plant = plant_of("""robot Two {
        component Bot[1..2] {
            incoming message go with identifier: "/r{index}/go", type: none
            outgoing message there with identifier: "/r{index}/there", type: none
            behaviour {
                initial marked state waits { on request to go goto drives }
                state drives { on response from there goto waits }
            }
        }
        requirement never Bot[1].drives and Bot[2].drives
    }""")
    looked: list[PlantState] = []

    def is_good(state: PlantState) -> bool:
        looked.append(state)
        return False

    stepper = Stepper(plant)
    search = ExplicitFaults(stepper, is_good, ExplanationTime(math.inf))
    drives = plant.initial
    for name in ("Bot[1].go.request", "Bot[2].go.request"):
        number = plant.events.index(event_of(plant, name))
        ((_, drives),) = stepper.compiled(number, None).targets(drives)
    assert search.way(drives, UNSAFE, forced=True) == (drives,)
    assert search.has(drives, "requirement") and not search.has(plant.initial, "requirement")
    assert not looked
    way = search.way(plant.initial, UNSAFE, forced=False)
    assert way is not None and len(way) == 3 and way[-1] == drives
    assert looked
