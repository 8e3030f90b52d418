"""Few states under control of a plant that has too many: verified one by one."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
import steep_families
from emit.generated_code import supervisor_of
from random_models import random_model
from robot_families import track, zones, zones_by_hand
from synthesis.plants import plant_of

from robosc.expr.tree import Literal
from robosc.expr.types import BooleanType
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.step import Outcome, Values, Verdict, outcome
from robosc.supervisor import Supervisor
from robosc.synthesis import compute
from robosc.synthesis.verify import steps, verification
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
    """Few states in a plant of millions; given on to the symbolic engine where they are many.

    What that found is verified by sets, too, unless they take many nodes.
    """
    states, steps = zones_by_hand(5, 9)
    for most in (2**13, states - 1):
        monkeypatch.setattr(compute, "_FEW_NODES", 0)
        for name in ("_FEW_GUARDED", "_MOST_GUARDED"):
            monkeypatch.setattr(compute, name, most)
        supervisor = compute.synthesize(plant_of(zones(5, 9)))
        assert supervisor.engine == ("explicit" if most > states else "bdd")
        assert supervisor.controlled_states == states
        assert supervisor.controlled_transitions == steps
        for nodes, method in ((0, "explicit"), (2**24, "symbolic")):
            monkeypatch.setattr(verification, "_FEW_NODES", nodes)
            report = verify(supervisor)
            assert report.verified
            assert report.method == ("explicit" if supervisor.engine == "explicit" else method)


@pytest.mark.parametrize(("value", "failing"), [(False, "maximally permissive"), (True, "safe")])
def test_a_wrong_guard_is_found(supervisor: Supervisor, value: bool, failing: str) -> None:
    first, *others = supervisor.guards
    wrong = replace(first, expr=Literal(value, BooleanType()))
    report = verify(replace(supervisor, guards=(wrong, *others)))
    assert next(check.name for check in report.checks if not check.holds) == failing


def test_sets_of_a_plant_of_some_thousand_states_are_verified_as_sets() -> None:
    """Requirements leave few states of it: to count those of the plant alone took most of it."""
    supervisor = compute.synthesize(plant_of(steep_families.chain(14)), "bdd")
    assert supervisor.plant_states == 2**14
    report = verify(supervisor)
    assert (report.verified, report.method) == (True, "symbolic")
    assert verify(replace(supervisor, engine="explicit")).method == "explicit"


def test_what_the_automata_of_a_wide_event_do_is_computed_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Every block of a track reacts to a vehicle that leaves one: 2^8 combinations and its own."""
    supervisor = compute.synthesize(plant_of(track(3, 8)), "explicit")
    found = []

    def counted(plant: Plant, event: Event, values: Values, state: PlantState) -> Outcome:
        found.append(event)
        return outcome(plant, event, values, state)

    monkeypatch.setattr(steps, "outcome", counted)
    assert verify(supervisor).verified
    assert supervisor.controlled_transitions == 3_432
    assert len(found) < 2_000


def test_an_event_taken_apart_does_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(steps, "_CHUNK", 0)
    for seed in range(12):
        plant = plant_of(random_model(random.Random(seed), 1 + seed % 3))
        coding = steps.Coding(plant)
        states = {*plant.initial_states}
        left = list(states)
        each = [steps.EventSteps(plant, coding, event) for event in plant.events]
        for state in left[:200]:
            for one in each:
                here = coding.encode(state)
                expected = [
                    (number, outcome(plant, one.event, values, state))
                    for number, values in enumerate(one.valuations)
                ]
                got = {
                    n: None if c is None else coding.decode(here + c)
                    for n, c in one.successors(state)
                }
                for number, after in expected:
                    if isinstance(after, tuple):
                        assert got[number] == after
                        if after not in states:
                            states.add(after)
                            left.append(after)
                    else:
                        leaves = after is Verdict.OUT_OF_RANGE and not one.event.controllable
                        assert (number in got) == leaves
                        assert got.get(number) is None
