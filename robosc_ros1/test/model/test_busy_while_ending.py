"""A served action that was cancelled is busy until it is answered."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from simulate.players import play, session

from robosc.plant.automaton import Plant, PlantState
from robosc.plant.model_text import to_dsl
from robosc.plant.step import holds
from robosc.synthesis.explore import explore
from robosc.synthesis.verify.verification import verify

ROBOT = """
robot Ending {
    interface goal use Go from some_msgs
    component F {
        outgoing action task with identifier: "/task", request: none, response: none, feedback: none
            links goal
        incoming message lamp with type: none
        behaviour {
            initial marked state free { on request from task goto work }
            state work { on response to task goto free on cancel from task goto over }
            state over { on error to task goto free on response to task goto free }
        }
    }
    requirement lamp needs %s
}
"""


def phases(plant: Plant, states: list[PlantState], condition: str) -> set[str]:
    """The phases of the action in which a requirement of the model holds."""
    (number,) = (n for n, v in enumerate(plant.variables) if v.name == "F.task")
    (requirement,) = (r for r in plant.robot.requirements if condition in r.text)
    return {
        str(plant.variables[number].values[state[number]])
        for state in states
        if holds(plant, plant.view.met(requirement), state)
    }


@pytest.mark.parametrize(
    ("condition", "where"),
    [
        ("task.busy", {"busy", "ending"}),
        ("!task.busy", {"idle"}),
        ("task.idle", {"idle"}),
        ("task.ending", {"ending"}),
        ("task.busy and !task.ending", {"busy"}),
    ],
)
def test_the_phases_of_each_name(condition: str, where: set[str]) -> None:
    supervisor = supervisor_of(ROBOT % condition)
    states = list(explore(supervisor).states)
    assert phases(supervisor.plant, states, condition) == where
    assert verify(supervisor).verified


def test_what_needs_it_idle_waits_for_its_end() -> None:
    player = session(supervisor_of(ROBOT % "!task.busy"))
    play(player, "expect enabled lamp.request", "task.request", "task.cancel")
    play(player, "expect task.busy and task.ending", "expect disabled lamp.request")
    play(player, "task.error", "expect enabled lamp.request")


def test_guards_tell_the_phases_apart() -> None:
    """What synthesis finds of one of the phases alone is read again as that one."""
    plant = supervisor_of(ROBOT % "task.idle").plant
    (variable,) = (v for v in plant.variables if v.name == "F.task")
    texts = [to_dsl(variable.phase(n), plant.robot) for n in range(3)]
    assert texts == ["!task.busy", "(task.busy and !task.ending)", "task.ending"]
