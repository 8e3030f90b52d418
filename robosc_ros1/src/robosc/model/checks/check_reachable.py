"""Reachability and coreachability of the states of one component.

Guards are ignored, and every event is possible in every state, so this over-approximates the
component alone. Synthesis decides for the whole robot.
"""

from __future__ import annotations

from collections.abc import Iterable

from robosc import dotted
from robosc.language.events import EventKind
from robosc.model.automata import Behaviour, State
from robosc.model.diagnostics import Report, first_of
from robosc.model.names.tables import Instance
from robosc.runtime.core.places import place_of


def check_reach(
    instance: Instance, behaviour: Behaviour, initial: list[str], report: Report
) -> None:
    """Report unreachable states, and reachable ones from which no marked state is reachable."""
    steps = {state.name: _successors(state, behaviour) for state in behaviour.states}
    reached = _closure(initial, steps)
    for name, state in instance.states.items():
        if dotted.around(name) in instance.performed:
            continue  # it stands where no state can
        if reached.isdisjoint(instance.leaves(name)):
            report.add(
                "unreachable-state",
                state.name.span,
                f"no transition leads {instance.name} to state '{name}'",
            )
    back: dict[str, set[str]] = {name: set() for name in steps}
    for source, targets in steps.items():
        for target in targets:
            back[target].add(source)
    marked = [s.name for s in behaviour.states if s.marked]
    coreachable = _closure(marked, back)
    cut_off = list(
        dict.fromkeys(
            place_of(name) for name in steps if name in reached and name not in coreachable
        )
    )
    if not cut_off:
        return
    message = (
        f"from state '{cut_off[0]}' of {instance.name} no marked state can be reached"
        if marked
        else f"{instance.name} has no marked state"
    )
    hint = (
        f"blocking states: {first_of(cut_off)}; if the controller is to keep out of them, mark"
        f" them and add 'requirement never {instance.name}.{cut_off[0]}'"
        if marked
        else "mark the states in which its work is done: marked state"
    )
    report.add("no-marked-reachable", instance.states[cut_off[0]].name.span, message, hint)


def _successors(state: State, behaviour: Behaviour) -> set[str]:
    hiding: set[tuple[EventKind, str]] = set()
    targets: list[str | None] = []
    for level in behaviour.levels(state):
        targets += [t.goto for t in level if (t.event, t.communication) not in hiding]
        hiding |= {
            (t.event, t.communication) for t in level if t.guard is None or t.event.synchronised
        }
    for place in (state, *state.around, behaviour):
        targets += [t.goto for t in place.transitions if t.event.of_component]
    return {t for t in targets if t is not None}


def _closure(start: Iterable[str], steps: dict[str, set[str]]) -> set[str]:
    found = set(start)
    work = list(found)
    while work:
        for target in steps[work.pop()] - found:
            found.add(target)
            work.append(target)
    return found
