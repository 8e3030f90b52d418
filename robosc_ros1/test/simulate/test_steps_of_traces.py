"""Each step of a trace, as it is printed, can be typed into the simulator."""

from __future__ import annotations

import random
from itertools import islice

import pytest
from data_models import data_model
from emit.generated_code import supervisor_of
from quick import quick_first
from ros_support import EXAMPLES
from simulate.players import play, session

from robosc import pipeline
from robosc.plant.automaton import Plant
from robosc.plant.build import lower
from robosc.plant.step import valuations
from robosc.simulate.faults import InvalidLine, Refused
from robosc.simulate.script.session import step_written
from robosc.supervisor import Step
from robosc.synthesis import explore
from robosc.synthesis.controlled_system import make_step
from robosc.synthesis.formatting import step_text


def misread(plant: Plant) -> list[str]:
    """Texts of steps that are read as something else."""
    found = []
    for event in plant.events:
        if event.parameters and not event.kind.of_component:
            for values in islice(valuations(event), 100):
                text = step_text(Step(event, values))
                if repr(step_written(plant, text)) != repr((event, values)):
                    found.append(text)
    return found


def test_a_transition_that_cannot_be_taken_now_is_known() -> None:
    player = session(pipeline.supervise(pipeline.load(EXAMPLES / "patrol" / "patrol.rscd").robot))
    with pytest.raises(Refused, match="Mission: patrol->returning cannot happen now"):
        play(player, "Mission: patrol->returning")
    play(player, "goto Mission.patrol and Battery.charge < 0.3", "Mission: patrol->returning")
    play(player, "expect Mission.returning")


@pytest.mark.parametrize("name", ["kobuki", "two_robots", "line_follower", "door"])
def test_steps_of_examples_are_read_back(name: str) -> None:
    robot = pipeline.load(EXAMPLES / name / f"{name}.rscd").robot
    assert robot is not None
    assert misread(lower(robot)) == []


@pytest.mark.parametrize("seed", quick_first(range(5), 1))
@pytest.mark.parametrize("extra", ["array", "failure", "enum"])
def test_a_part_that_is_missing_is_read_back(seed: int, extra: str) -> None:
    text = data_model(random.Random(seed), computed=True, extra=extra)
    assert misread(supervisor_of(text).plant) == []


@pytest.mark.parametrize("seed", quick_first(range(12), 4))
def test_a_typed_trace_leads_where_the_trace_does(seed: int) -> None:
    rng = random.Random(seed)
    supervisor = supervisor_of(data_model(rng, computed=seed % 2 == 1))
    if supervisor.empty:
        return
    graph, player = explore(supervisor), session(supervisor)
    here = 0
    for _ in range(25):
        transition = rng.choice([t for t in graph.transitions if t.source == here])
        event = graph.plant.events[transition.event]
        before, after = graph.states[here], graph.states[transition.target]
        play(player, step_text(make_step(graph.plant, event, transition.values, before, after)))
        assert player.machine.plant_state == after  # type: ignore[attr-defined]
        here = transition.target


def test_traces_are_of_single_events() -> None:
    player = session(supervisor_of(data_model(random.Random(0))), execute=True)
    with pytest.raises(InvalidLine):
        play(player, "sense.response(value > 0.1)")
