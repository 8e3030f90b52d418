"""Build the supervisor from an engine's guards and sizes: add explanations and diagnostics."""

from __future__ import annotations

from dataclasses import dataclass

from robosc.ir.automaton import Plant
from robosc.model.expr import FALSE, TRUE
from robosc.progress import Progress
from robosc.supervisor import Explanation, Guard, Supervisor
from robosc.synthesis.explain.properties import Properties, examine
from robosc.synthesis.explain.reasons import explain_empty, explain_guards
from robosc.synthesis.explain.warnings import warnings
from robosc.synthesis.system import System


@dataclass(frozen=True, slots=True)
class Sizes:
    """Numbers of plant states, controlled states and controlled transitions."""

    plant_states: int
    controlled_states: int
    controlled_transitions: int


def nothing_allowed(plant: Plant) -> tuple[Guard, ...]:
    """Return the guards of an empty supervisor."""
    return tuple(
        Guard(e, FALSE, e.requirement or TRUE, "never") for e in plant.events if e.controllable
    )


def make_supervisor(
    system: System,
    engine: str,
    seconds: float,
    sizes: Sizes,
    guards: tuple[Guard, ...],
    progress: Progress | None = None,
) -> Supervisor:
    """Return the supervisor that an engine found; without controlled states it is empty.

    ``guards`` are ignored then.
    """
    empty = sizes.controlled_states == 0
    if empty:
        guards = nothing_allowed(system.plant)
        explanations: tuple[Explanation, ...] = (explain_empty(system),)
        properties = Properties((), None)
    else:
        explanations = explain_guards(system, guards, progress)
        properties = examine(system, guards, sizes.controlled_states)
    return Supervisor(
        plant=system.plant,
        engine=engine,
        seconds=seconds,
        plant_states=sizes.plant_states,
        controlled_states=sizes.controlled_states,
        controlled_transitions=sizes.controlled_transitions,
        guards=guards,
        explanations=explanations,
        properties=properties.holds,
        diagnostics=(
            # What has no trace at all the model itself rules out, and a warning says so.
            *(e.diagnostic for e in explanations if empty or e.trace or not e.traced),
            *(() if empty else warnings(system, guards)),
            *properties.diagnostics,
        ),
        empty=empty,
        step_bound=properties.step_bound,
    )
