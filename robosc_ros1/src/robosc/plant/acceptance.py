"""Where the phase of a communication alone does not say whether an event of it is possible.

A call that the robot makes is accepted only where at least one component takes its request;
elsewhere the node refuses it, and nothing happens in the plant. An answer for which the model's
``expect:`` does not hold is no response, and not every reason of an error goes with every value.
The phase of such a communication is one more automaton of the event, which blocks it elsewhere. So
engines need no notion of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from robosc.expr.tree import TRUE, Expr, StateRef
from robosc.expr.undefined_data import known_condition
from robosc.language.events import EventKind, Kind
from robosc.plant.automaton import (
    ASSUMPTIONS,
    Edge,
    Event,
    LocalAutomaton,
    PhaseStep,
    StateVariable,
)
from robosc.plant.logic import conjunction, disjunction
from robosc.source import Span


def is_left_to_components(event: EventKind, kind: Kind) -> bool:
    """Whether an event of a kind of communication happens only where a component says so: an error
    that answers a call, and of an action that is served, its result; its feedback also where a
    statement provides it."""
    of_goal = kind is Kind.SERVED_ACTION and event in (EventKind.ANSWER, EventKind.PROGRESS)
    return of_goal or event is EventKind.REFUSAL


def acceptance(
    key: str,
    phase: PhaseStep,
    automata: Sequence[LocalAutomaton],
    variables: Sequence[StateVariable],
    span: Span,
) -> LocalAutomaton:
    """Return the phase of a call as an automaton that blocks it where no component takes it."""
    cases = [
        _taken(edge, automaton, variables) for automaton in automata for edge in automaton.edges
    ]
    where = disjunction(cases)
    guards = dict.fromkeys(phase.sources, None if where == TRUE else where)
    accepts = guarded_phase(key, phase, guards, span)
    return accepts if cases else replace(accepts, edges=())


def handled(event: Event, variables: Sequence[StateVariable]) -> Event:
    """Return an event of a communication with phases without its occurrences that no component
    takes."""
    gate, automata = acceptance_of(event), components_of(event)
    cases = [
        _taken(edge, automaton, variables) for automaton in automata for edge in automaton.edges
    ]
    where = disjunction(cases)
    if gate is None:
        assert event.phase is not None
        taken = acceptance(event.key, event.phase, automata, variables, event.span)
        return replace(event, phase=None, automata=(*event.automata, taken))
    edges = tuple(
        replace(edge, guard=where if edge.guard is None else conjunction((edge.guard, where)))
        for edge in gate.edges
    )
    taken = replace(gate, edges=edges if cases else ())
    return replace(event, automata=tuple(taken if a is gate else a for a in event.automata))


def guarded_phase(
    key: str, phase: PhaseStep, guards: Mapping[int, Expr | None], span: Span
) -> LocalAutomaton:
    """Return the phase of a communication as an automaton that blocks an event where the guard of
    the source (None: it has none) does not hold.

    Its ``component`` is the key of the communication, which is the name of no component.
    """
    edges = (
        Edge(source, guards[source], (), (), phase.target, True, (), (), span)
        for source in phase.sources
    )
    return LocalAutomaton(key, phase.variable, tuple(edges), True)


def _taken(edge: Edge, automaton: LocalAutomaton, variables: Sequence[StateVariable]) -> Expr:
    """The condition that a component is where an edge leaves, and its guard holds."""
    location = variables[automaton.variable]
    here = StateRef(automaton.component, str(location.values[edge.source]))
    return conjunction((here,) if edge.guard is None else (here, known_condition(edge.guard)))


def acceptance_of(event: Event) -> LocalAutomaton | None:
    """Return the automaton that an event has in place of its phase; None if it has none."""
    if event.kind.of_component:
        return None
    return next((a for a in event.automata if a.component == event.key), None)


def gates_of(event: Event) -> tuple[LocalAutomaton, ...]:
    """Return the automata of an event of the robot that say where it happens: the one in place of
    its phase, and that of the assumptions. Where there is none the phase alone decides."""
    accepts = acceptance_of(event)
    return tuple(a for a in event.automata if a is accepts or a.component == ASSUMPTIONS)


def components_of(event: Event) -> tuple[LocalAutomaton, ...]:
    """Return the automata of an event that are those of components."""
    gates = gates_of(event)
    others = (*gates, *resets_of(event))
    return tuple(a for a in event.automata if not any(a is other for other in others))


def resets_of(event: Event) -> tuple[LocalAutomaton, ...]:
    """Return the automata of an event that set lasting conditions back."""
    return tuple(a for a in event.automata if a.resets)


def phase_of(event: Event) -> PhaseStep | None:
    """Return the phases in which an event is possible, if its communication has some."""
    accepts = acceptance_of(event)
    if accepts is None:
        return event.phase
    sources = tuple(edge.source for edge in accepts.edges)
    return PhaseStep(accepts.variable, sources, accepts.edges[0].target if sources else 0)
