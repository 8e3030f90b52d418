"""Plants and supervisors from model text, and what tests look up in them."""

from __future__ import annotations

from collections.abc import Sequence

from robosc.errors import render_all
from robosc.language.events import EventKind
from robosc.model.resolve import load
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.build import lower
from robosc.plant.model_text import to_dsl
from robosc.plant.step import Verdict, outcome
from robosc.source import Source
from robosc.supervisor import Explanation, Guard, Step, Supervisor
from robosc.synthesis import synthesize

__all__ = [
    "LINK", "event_of", "explanation_of", "guard_of", "guard_text", "plant_of", "replay",
    "supervisor_of", "trace_text_of",
]  # fmt: skip

LINK = " interface link use Thing from some_robot_msgs "


def plant_of(body: str, name: str = "model.rscd") -> Plant:
    """The plant of a robot's declarations, or of a whole file."""
    text = body if body.lstrip().startswith(("robot", "//")) else f"robot R {{{LINK}{body}}}"
    robot, diagnostics = load(Source(name, text))
    assert robot is not None, f"{text}\n{render_all(diagnostics)}"
    return lower(robot)


def supervisor_of(body: str, engine: str = "explicit", max_states: int = 2**28) -> Supervisor:
    return synthesize(plant_of(body), engine, max_states)


def event_of(plant: Plant, name: str) -> Event:
    """``grab.request``; ``Comp.tau1`` for a tau."""
    for event in plant.events:
        kind = f"{event.kind.word}{event.index or ''}"
        if f"{event.name}.{kind}" == name:
            return event
    raise AssertionError(f"no event {name}")


def guard_of(supervisor: Supervisor, name: str) -> Guard:
    event = event_of(supervisor.plant, name)
    return next(guard for guard in supervisor.guards if guard.event is event)


def guard_text(supervisor: Supervisor, name: str) -> tuple[str, str]:
    """A guard as users read it, with its status."""
    guard = guard_of(supervisor, name)
    return to_dsl(guard.expr, supervisor.plant.robot), guard.status


def explanation_of(supervisor: Supervisor, name: str) -> Explanation:
    event = event_of(supervisor.plant, name)
    return next(found for found in supervisor.explanations if found.event is event)


def trace_text_of(steps: Sequence[Step]) -> list[str]:
    return [f"{step.event.name}.{step.event.kind.word}" for step in steps]


def replay(plant: Plant, steps: Sequence[Step]) -> PlantState | Verdict:
    """Where a trace ends in the plant; fails if the plant cannot do it."""
    state: PlantState | Verdict = plant.initial
    for step in steps:
        assert not isinstance(state, Verdict), f"{step} behind the end"
        values = () if step.event.kind in (EventKind.TAU, EventKind.AFTER) else step.values
        state = outcome(plant, step.event, values, state)
        assert state is not Verdict.IMPOSSIBLE, f"{step} is impossible"
    return state
