"""Explanation of a state from which what must remain possible cannot be reached."""

from __future__ import annotations

from robosc import limits
from robosc.plant.automaton import PlantState
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.event_parameters import weight
from robosc.synthesis.explain.blocking import Cause
from robosc.synthesis.formatting import quoted


def why_impossible(stepper: Stepper, state: PlantState) -> Cause | None:
    """Return what must remain possible in a state and is not, whatever the controller does; None if
    all is possible, or if it is unknown."""
    plant = stepper.plant
    if any(weight(event) > limits.COMBINATIONS for event in plant.events):
        return None
    for goal in plant.goals:
        there, along, origin = map(stepper.test, goal.conditions)
        if not origin(state) or there(state):
            continue
        seen = {state}
        todo = [state]
        hit = False
        for here in todo:  # appended to below
            if not along(here):
                continue
            for event in stepper.required():
                targets = {target for _, target in event.targets(here)} - seen
                hit = hit or any(map(there, targets))
                seen |= targets
                todo += targets
            if hit:
                break
            if len(todo) > limits.BLOCKED_STATES:
                return None
        if not hit:
            written = plant.robot.goals[goal.index]
            reason = f"{quoted(written.text)} fails: it is not possible any more"
            return Cause(reason, None, written.span)
    return None
