"""Build the supervisor from an engine's guards and sizes: add explanations and diagnostics."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property

from robosc.errors import Diagnostic, listing
from robosc.expr.tree import FALSE, TRUE
from robosc.lazy_dataclasses import dataclass
from robosc.plant.automaton import Plant
from robosc.progress import Progress
from robosc.supervisor import Explanation, Guard, Supervisor
from robosc.synthesis.controlled_system import System
from robosc.synthesis.explain.properties import Properties, examine
from robosc.synthesis.explain.reasons import explain_empty, explain_guards
from robosc.synthesis.explain.warnings import warnings
from robosc.synthesis.formatting import event_text

_MOST_NAMES = 6
"""Commands that a warning names beside the one that it explains."""


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


@dataclass(frozen=True, eq=False)
class Solved:
    """What an engine found: guards and sizes are there at once, what explains them takes longer.

    Without controlled states the supervisor is empty, and ``guards`` are ignored.
    ``opposite_order`` is that of the supervisor.
    """

    system: System
    engine: str
    seconds: float
    sizes: Sizes
    guards: tuple[Guard, ...]
    progress: Progress | None = None
    opposite_order: bool = False

    @property
    def nodes(self) -> int:
        """The nodes of decision diagrams that are kept for explanations."""
        return self.system.nodes

    @cached_property
    def supervisor(self) -> Supervisor:
        """The supervisor, not explained yet: no reasons, no diagnostics, no properties."""
        empty = self.sizes.controlled_states == 0
        return Supervisor(
            plant=self.system.plant,
            engine=self.engine,
            seconds=self.seconds,
            plant_states=self.sizes.plant_states,
            controlled_states=self.sizes.controlled_states,
            controlled_transitions=self.sizes.controlled_transitions,
            guards=nothing_allowed(self.system.plant) if empty else self.guards,
            explanations=(),
            properties=(),
            empty=empty,
            opposite_order=self.opposite_order,
        )

    def explained(self) -> Supervisor:
        """Return the supervisor with reasons, diagnostics and properties."""
        system, guards, empty = self.system, self.supervisor.guards, self.supervisor.empty
        left_out: tuple[Diagnostic, ...] = ()
        told: tuple[Diagnostic, ...] = ()
        with system.time.running(self.seconds):
            if empty:
                explanations: tuple[Explanation, ...] = (explain_empty(system),)
            else:
                explanations, left_out = explain_guards(system, guards, self.progress)
                told = warnings(system, guards)
        properties = Properties((), None)
        if not empty:
            properties = examine(system, guards, self.sizes.controlled_states)
        return replace(
            self.supervisor,
            explanations=explanations,
            properties=properties.holds,
            diagnostics=(
                # What has no trace at all the model itself rules out, and a warning says so.
                *_together(
                    [e for e in explanations if e.told and (empty or e.trace or not e.traced)]
                ),
                *left_out,
                *told,
                *properties.diagnostics,
            ),
            step_bound=properties.step_bound,
        )


def _together(explanations: Sequence[Explanation]) -> Iterator[Diagnostic]:
    """Yield one diagnostic for all commands that are restricted by the same place in the model."""
    groups: dict[object, list[Explanation]] = {}
    for number, explanation in enumerate(explanations):
        found = explanation.diagnostic
        groups.setdefault((found.code, found.notes) if found.notes else number, []).append(
            explanation
        )
    for alike in groups.values():
        first = alike[0].diagnostic
        others = [one for one in alike if one.diagnostic.span != first.span]
        names = [event_text(other.event) for other in others if other.event is not None]
        if len(names) > _MOST_NAMES:
            names[_MOST_NAMES - 1 :] = [f"{len(names) - _MOST_NAMES + 1} other commands"]
        more = f"; the same holds for {listing(names)}" if names else ""
        yield replace(first, message=first.message + more)
        # Copies of a command stand at one place of the model: reports say that of each place once.
        yield from (one.diagnostic for one in alike[1:] if one.diagnostic.span == first.span)
