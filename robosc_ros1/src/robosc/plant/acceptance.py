"""Where a call that the controller serves is accepted.

What the robot calls is uncontrollable, but not always possible: a call is accepted only where at
least one component takes its request; elsewhere the node refuses it, and nothing happens in the
plant. The phase of the call is one more automaton of the event, which blocks it where no component
takes it. So engines need no notion of it.
"""

from __future__ import annotations

from collections.abc import Sequence

from robosc.expr.presence import known_condition
from robosc.expr.tree import TRUE, Expr, StateRef
from robosc.language.events import EventKind
from robosc.plant.automaton import (
    ASSUMPTIONS,
    Edge,
    Event,
    LocalAutomaton,
    PhaseStep,
    StateVariable,
)
from robosc.plant.formulas import conjunction, disjunction
from robosc.source import Span


def acceptance(
    key: str,
    phase: PhaseStep,
    automata: Sequence[LocalAutomaton],
    variables: Sequence[StateVariable],
    span: Span,
) -> LocalAutomaton:
    """Return the phase of a call as an automaton that blocks it where no component takes it.

    Its ``component`` is the key of the communication, which is the name of no component.
    """
    cases = [
        _taken(edge, automaton, variables) for automaton in automata for edge in automaton.edges
    ]
    where = disjunction(cases)
    (source,) = phase.sources
    guard = None if where == TRUE else where
    edge = Edge(source, guard, (), (), phase.target, True, (), (), span)
    return LocalAutomaton(key, phase.variable, (edge,) if cases else (), True)


def _taken(edge: Edge, automaton: LocalAutomaton, variables: Sequence[StateVariable]) -> Expr:
    """The condition that a component is where an edge leaves, and its guard holds."""
    location = variables[automaton.variable]
    here = StateRef(automaton.component, str(location.values[edge.source]))
    return conjunction((here,) if edge.guard is None else (here, known_condition(edge.guard)))


def acceptance_of(event: Event) -> LocalAutomaton | None:
    """Return the automaton of a call that says where it is accepted; None of any other event."""
    if event.kind is not EventKind.CALL:
        return None
    return next(a for a in event.automata if a.component == event.key)


def gate_of(event: Event) -> LocalAutomaton | None:
    """Return the automaton of an event of the robot that says where it happens: where the call is
    accepted, or where assumptions allow it. None: the phase alone decides."""
    accepts = acceptance_of(event)
    assumed = (a for a in event.automata if a.component == ASSUMPTIONS)
    return accepts if accepts is not None else next(assumed, None)


def components_of(event: Event) -> tuple[LocalAutomaton, ...]:
    """Return the automata of an event that are those of components."""
    gate = gate_of(event)
    return tuple(a for a in event.automata if a is not gate)


def phase_of(event: Event) -> PhaseStep | None:
    """Return the phases in which an event is possible, if its communication has some."""
    accepts = acceptance_of(event)
    if accepts is None:
        return event.phase
    sources = tuple(edge.source for edge in accepts.edges)
    return PhaseStep(accepts.variable, sources, accepts.edges[0].target if sources else 0)
