"""Copies of a component that are restricted alike have one warning, and a trace for each of them."""

from __future__ import annotations

import pytest
from synthesis.plants import plant_of, replay

from robosc.plant.automaton import Plant
from robosc.plant.step import Verdict
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")

engines = pytest.mark.parametrize("engine", ["explicit", "bdd"])

FLEET = """
    component Bot[1..4] {
        outgoing message order with type: none
        incoming message drive with type: none
        outgoing message arrived with type: none
        behaviour {
            initial marked state idle { on response from order goto due }
            state due { on request to drive goto driving }
            state driving { on response from arrived goto idle }
        }
    }
    requirement never count(b.driving for b in Bot) > 2
"""
FAVOURED = """
    component Gate {
        outgoing message opened with type: none
        behaviour {
            initial marked state closed { on response from opened goto open }
            marked state open {}
        }
    }
    requirement Bot[2].drive needs Gate.open
"""


def found(text: str, engine: str) -> tuple[Plant, Supervisor]:
    plant = plant_of(text)
    return plant, synthesize(plant, engine)


def violated(plant: Plant, explanation_number: int, supervisor: Supervisor) -> bool:
    """Whether a trace ends where three drive, and its last step is the command explained."""
    explanation = supervisor.explanations[explanation_number]
    assert explanation.trace[-1].event == explanation.event
    state = replay(plant, explanation.trace)
    assert not isinstance(state, Verdict)
    places = [
        variable.values[index] for variable, index in zip(plant.variables, state, strict=True)
    ]
    return places.count("driving") == 3


@engines
def test_one_warning_for_all(engine: str) -> None:
    plant, supervisor = found(FLEET, engine)
    (warning,) = supervisor.diagnostics
    assert warning.message.startswith(
        "drive.request of each Bot is restricted further, to count(b.driving for b in Bot) < 2:"
        " with Bot[1], after "
    )
    names = [e.event.name for e in supervisor.explanations if e.event is not None]
    assert names == [f"Bot[{number}].drive" for number in range(1, 5)]
    assert [e.told for e in supervisor.explanations] == [True, False, False, False]
    assert all(violated(plant, number, supervisor) for number in range(4))


@engines
def test_a_trace_of_another_copy_counts_only_if_it_is_one(engine: str) -> None:
    """The second waits for a gate, of which the trace of the first says nothing."""
    plant, supervisor = found(FLEET + FAVOURED, engine)
    second = supervisor.explanations[1]
    assert "opened" in [step.event.name for step in second.trace]
    assert all(violated(plant, number, supervisor) for number in range(4))
    assert [d.message.split(" is ")[0] for d in supervisor.diagnostics] == [
        "drive.request of 3 of Bot",
        "Bot[2].drive.request",
    ]


@engines
def test_guards_and_sizes_come_before_what_explains_them(engine: str) -> None:
    before: list[Supervisor] = []
    after = synthesize(plant_of(FLEET), engine, solved=before.append)
    (bare,) = before
    assert bare.explanations == () and bare.diagnostics == () and bare.properties == ()
    assert (bare.guards, bare.controlled_states) == (after.guards, after.controlled_states)
    assert len(after.explanations) == 4 and after.properties
