"""What is wrong with assumptions: one that leaves nothing of an event, or that commands break."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product

from robosc.errors import Diagnostic, Severity, StateSpaceError, listing
from robosc.expr.tree import FALSE, Expr
from robosc.model.entities import Assumption
from robosc.plant.acceptance import phase_of
from robosc.plant.assumptions import EXCLUDED, Restriction, joined
from robosc.plant.automaton import Event, Plant
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.support import support
from robosc.supervisor import Guard
from robosc.synthesis.controlled_system import System, enabled, in_phase, taken_where
from robosc.synthesis.event_parameters import for_some
from robosc.synthesis.formatting import quoted
from robosc.synthesis.guards.precondition import after

When = Callable[[Expr], str | None]
"""Tells how a state with a condition is reached, to end a sentence with; None: never."""


def assumed(system: System, guards: Sequence[Guard], when: When) -> Iterator[Diagnostic]:
    """Yield warnings about the assumptions of a controlled system."""
    plant = system.plant
    for event in plant.events if plant.robot.assumptions else ():
        if event.kind in EXCLUDED:
            yield from _excluding_all(system, event)
    for condition, number in plant.lasting:
        yield from _broken(plant, condition, plant.robot.assumptions[number], guards, when)


def _excluding_all(system: System, event: Event) -> Iterator[Diagnostic]:
    """Yield a warning if none of an event is left, although its phase lets it happen."""
    plant = system.plant
    assumed = plant.restrictions.get((event.kind, event.key), ())
    phase = phase_of(event)
    there = [] if phase is None else [in_phase(plant, phase)]

    def leave_some(those: Sequence[Restriction]) -> bool:
        passing = for_some(event, [plant.view.expression(joined(those))])
        return system.reaches(conjunction([*there, passing]))

    if not assumed or not system.reaches(conjunction(there)):
        return
    try:
        if leave_some(assumed):
            return
        for one in assumed if len(assumed) > 1 else ():
            others = [restriction for restriction in assumed if restriction is not one]
            assumed = assumed if not others or leave_some(others) else others
    except StateSpaceError:
        return
    texts = [quoted(restriction.assumption.text) for restriction in assumed]
    yield Diagnostic(
        Severity.WARNING,
        "assumption-excludes-all",
        f"{listing(texts)} leave{'s' if len(texts) == 1 else ''} no {event.kind.word} of"
        f" {event.name}: the robot is assumed never to send one",
        assumed[0].assumption.span,
        "relax the assumption: what needs this event is proved for no robot",
    )


def _broken(
    plant: Plant, holds: Expr, assumption: Assumption, guards: Sequence[Guard], when: When
) -> Iterator[Diagnostic]:
    """Yield a warning if a command leads from where an assumption holds to where it does not."""
    for guard in guards:
        event = guard.event
        if event.parameters:
            continue  # another controller decides what it carries
        fails = disjunction(_failing(plant, event, holds))
        told = None if fails == FALSE else when(conjunction([holds, enabled(plant, guard), fails]))
        if told is not None:
            yield Diagnostic(
                Severity.WARNING,
                "assumption-broken",
                f"{event.name}.{event.kind.word} breaks {quoted(assumption.text)}: {told}",
                assumption.span,
                f"assume only what the robot does by itself, or add a requirement on {event.name}",
            )
            return


def _failing(plant: Plant, event: Event, holds: Expr) -> Iterator[Expr]:
    """Yield where a command leads to a state in which a condition does not hold.

    Only the automata count that write what the condition reads.
    """
    read = frozenset(support(plant, holds))
    if event.writes.isdisjoint(read):
        return
    movers = [a for a in event.automata if not read.isdisjoint(a.writes)]
    for edges in product(*(automaton.edges for automaton in movers)):
        taken = list(zip(movers, edges, strict=True))
        where = [part for a, edge in taken for part in taken_where(plant, a, edge)]
        yield conjunction([*where, negation(after(plant, event, taken, holds))])
