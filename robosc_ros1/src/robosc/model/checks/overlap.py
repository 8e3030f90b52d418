"""The check for overlapping guards in models without a state space.

Whether two guards can hold together depends on the reachable states, so synthesis checks it. A
model with errors, or a library, has no state space; there the guards are compared over all values
of what they read. In a library only guards that read nothing but received values are reported,
because its variables may never reach the other values.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import combinations

from robosc import dotted
from robosc.errors import Note
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, PhaseRef, StateRef, VariableRef
from robosc.model.automata import Behaviour, Transition
from robosc.model.checks.exclusive import hold_together
from robosc.model.diagnostics import Report
from robosc.model.entities import Component
from robosc.model.typing.command_values import fold_text


def check_overlaps(components: Iterable[Component], report: Report, *, library: bool) -> None:
    """Report each pair of transitions on one event whose guards can hold together.

    ``library``: only guards that read nothing but received values.
    """
    states = {c.name: [s.name for s in c.states] for c in components}
    for component in components:
        if component.behaviour is None or component.library is not None:
            continue
        for place, first, second in _pairs(component.behaviour):
            assert first.guard is not None and second.guard is not None
            here = states | {component.name: [s.name for s in component.states if s.is_in(place)]}
            guards = [first.guard, second.guard]
            if not (library and _reads_the_state(guards)) and hold_together(guards, here):
                _report(component, first, second, report)


def _pairs(
    behaviour: Behaviour,
) -> Iterator[tuple[str | None, Transition, Transition]]:
    """Pairs of guarded transitions on one event, with their state; None stands for every state."""
    places: list[tuple[str | None, tuple[Transition, ...]]]
    places = [(None, behaviour.on_communications)]
    places += [(place.name, place.on_communications) for place in behaviour.places]
    for place, transitions in places:
        guarded = [t for t in transitions if t.guard is not None]
        for first, second in combinations(guarded, 2):
            if (first.event, first.communication) == (second.event, second.communication):
                yield place, first, second


def _reads_the_state(guards: Iterable[Expr]) -> bool:
    return any(isinstance(p, VariableRef | StateRef | PhaseRef) for g in guards for p in walk(g))


def _report(component: Component, first: Transition, second: Transition, report: Report) -> None:
    guards = [fold_text(t.guard.span.text) for t in (first, second) if t.guard and t.guard.span]
    name = dotted.last(second.communication)
    report.add(
        "guard-overlap",
        second.span,
        f"the guards '{guards[0]}' and '{guards[1]}' of two transitions on"
        f" {name}.{second.event.value} of {component.name} can hold together",
        "make the guards exclude each other",
        [Note("the other transition", first.span)],
    )
