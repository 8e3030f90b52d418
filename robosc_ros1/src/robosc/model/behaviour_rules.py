"""Checks of the transitions and states of one behaviour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from robosc.errors import Note
from robosc.language.events import EventKind
from robosc.model.diagnostics import Report
from robosc.model.entities import Behaviour, ResultTransition
from robosc.model.expr import ValueRef
from robosc.model.tables import Instance
from robosc.model.traversal import walk
from robosc.source import Span
from robosc.syntax.nodes import ResultTransitionNode, StateNode


def check_events(
    instance: Instance,
    report: Report,
    nodes: Sequence[ResultTransitionNode],
    results: Sequence[ResultTransition],
    state: StateNode | None,
) -> None:
    """Report transitions for one event of which one has no guard.

    ``state`` is that of the transitions, None for those that apply in every state.
    """
    node_at = {n.span.start: n for n in nodes}
    seen: dict[tuple[EventKind, str], list[ResultTransitionNode]] = {}
    for result in results:
        node = node_at[result.span.start]
        earlier = seen.setdefault((result.event, result.communication), [])
        clash = next((e for e in earlier if e.guard is None or node.guard is None), None)
        cut_short = instance.types.scope.is_cut_short
        if clash is not None and not (cut_short(node.span) or cut_short(clash.span)):
            where = f"in state '{state.name.text}'" if state else "for every state"
            report.add(
                "duplicate-transition",
                node.event_span,
                f"there is already a transition for '{node.event}' of"
                f" '{node.communication.span.text}' {where}",
                "join them, or give each an 'if' that excludes the other",
                [Note("the first one is here", clash.event_span)],
            )
        earlier.append(node)


def check_initial(instance: Instance, report: Report, initial: Sequence[StateNode]) -> None:
    """Report a behaviour with several initial states, or none."""
    name = instance.name
    for state in initial[1:]:
        report.add(
            "several-initial-states",
            state.name.span,
            f"{name} already has an initial state",
            f"remove 'initial' from '{state.name.text}' or from '{initial[0].name.text}'",
            [Note("the first one is here", initial[0].name.span)],
        )
    if not initial:
        states = [
            f"initial {'marked ' if s.marked else ''}state {s.name.text}"
            for s in instance.states.values()
        ]
        report.add(
            "no-initial-state",
            instance.node.name.span,
            f"{name} has behaviour but no initial state",
            f"write: {states[0]}" if states else "add: initial marked state idle {}",
        )


def check_hiding(behaviour: Behaviour, event_spans: Mapping[int, Span], report: Report) -> None:
    """Report transitions of a state that hide one of the behaviour for the same event.

    ``event_spans`` maps the offset of a transition to the span of its event.
    """
    common: dict[tuple[EventKind, str], list[ResultTransition]] = {}
    for transition in behaviour.transitions:
        common.setdefault((transition.event, transition.communication), []).append(transition)
    for state in behaviour.states:
        seen = set()
        for transition in state.transitions:
            key = (transition.event, transition.communication)
            hidden = [t for t in common.get(key, ()) if _hides(transition, t)]
            if not hidden or key in seen:
                continue
            seen.add(key)
            name = transition.communication.rpartition(".")[2]
            report.add(
                "hidden-transition",
                event_spans[transition.span.start],
                f"in state '{state.name}' this hides the transition for"
                f" '{transition.event.value}'"
                f" of '{name}' that applies in every state",
                None,
                [Note("the hidden one is here", event_spans[hidden[0].span.start])],
            )


def _hides(own: ResultTransition, common: ResultTransition) -> bool:
    """Whether a transition of a state makes one of the behaviour ineffective there.

    It does not if its guard reads an optional value: the other one is for events without a value.
    """
    if own.guard is not None and any(
        isinstance(part, ValueRef) and part.optional for part in walk(own.guard)
    ):
        return False
    assigned = {a.variable for a in own.assignments}
    return (
        own.event.synchronised
        or common.goto is not None
        or any(a.variable in assigned for a in common.assignments)
    )
