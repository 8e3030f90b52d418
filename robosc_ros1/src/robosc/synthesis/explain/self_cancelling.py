"""The check for actions that what they do themselves cancels.

A requirement on an action is also a reason to cancel it. That is not meant where the action's own
request or feedback makes it false, nor where a message says only what the action achieves: a robot
that leaves its dock is not docked any more.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import product
from math import prod
from typing import TypeAlias

from robosc import dotted, limits
from robosc.errors import Diagnostic, Severity, StateSpaceError
from robosc.expr.traversal import walk_all
from robosc.expr.tree import Expr, PhaseRef, StateRef, TestRef, VariableRef
from robosc.language.events import EventKind
from robosc.model.entities import Requirement
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant
from robosc.plant.event_values import values_read
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.support import support
from robosc.supervisor import Guard
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import System, enabled, steps_of, taken_where
from robosc.synthesis.event_parameters import for_some
from robosc.synthesis.explain.starts import UNTRACED, whereabouts
from robosc.synthesis.formatting import quoted, trace_text
from robosc.synthesis.guards.precondition import after

_Taken: TypeAlias = list[tuple[LocalAutomaton, Edge]]


def self_cancelling(system: System, guards: Sequence[Guard]) -> Iterator[Diagnostic]:
    """Warn of requirements on actions that the action makes false; ``guards`` are all guards."""
    examiner = _Examiner(system)
    for guard in guards:
        if guard.event.kind is EventKind.CANCEL:
            requests = [
                other
                for other in guards
                if other.event.kind is EventKind.REQUEST and other.event.key == guard.event.key
            ]
            for number in guard.event.requirements:
                yield from examiner.requirement(requests, system.plant.robot.requirements[number])


class _Examiner:
    def __init__(self, system: System) -> None:
        self.system = system
        self.plant: Plant = system.plant
        self.stepper = Stepper(system.plant)
        self.events = {(event.kind, event.key): event for event in self.plant.events}

    def requirement(
        self, requests: Sequence[Guard], requirement: Requirement
    ) -> Iterator[Diagnostic]:
        """Yield at most one warning for a requirement on an action, whose requests these are."""
        action = requests[0].event
        kept = self.plant.view.met(requirement)
        busy = [PhaseRef(action.key, "busy"), kept]
        feedback = self.events[EventKind.FEEDBACK, action.key]
        starts = [(guard.event, [enabled(self.plant, guard)]) for guard in requests]
        for event, before in (*starts, (feedback, busy)):
            trace = self._trace(event, before, kept)
            if trace is not None:
                said = f"its own {event.kind.word} makes it false"
                yield self._diagnostic(action, requirement, said, trace)
                return
        for event in self._messages_of(action, kept):
            trace = self._trace(event, busy, kept)
            if trace is not None:
                said = f"{event.name} may say that it is false just because {action.name} succeeds"
                yield self._diagnostic(action, requirement, said, trace)
                return

    def _messages_of(self, action: Event, kept: Expr) -> Iterator[Event]:
        """Yield the messages that may report what an action achieves, and change a condition."""
        read = frozenset(support(self.plant, kept))
        alike = _named_alike(self.plant, action, kept)
        set_by_success = _assigned(self.events[EventKind.RESPONSE, action.key])
        for event in self.plant.events:
            if event.kind is EventKind.RESPONSE and event.key != action.key:
                mirrored = set_by_success & _assigned(event, from_value=True)
                if read & (mirrored | (alike & event.writes)):
                    yield event

    def _trace(self, event: Event, before: Sequence[Expr], kept: Expr) -> str | None:
        """Return how an event comes to make a condition false; None: it never does."""
        conditions = []
        for taken, where in self._choices(event, kept):
            fails = negation(after(self.plant, event, taken, kept))
            try:
                conditions.append(for_some(event, [*where, fails]))
            except StateSpaceError:
                return None
        condition = conjunction([*before, disjunction(conditions)])
        path = self.system.nearest(condition)
        if path is None:
            return None
        name = f"{event.name}.{event.kind.word}"
        if not self.plant.is_initial(path[0]):
            return f"{name} {whereabouts(self.plant, path[0], condition)} {UNTRACED}"
        earlier = trace_text(steps_of(self.stepper, path))
        return f"{earlier}, {name}" if earlier else name

    def _choices(self, event: Event, kept: Expr) -> Iterator[tuple[_Taken, list[Expr]]]:
        """Yield the transitions that may change a condition: which are taken together, and when."""
        read = frozenset(support(self.plant, kept))
        options: list[list[tuple[_Taken, list[Expr]]]] = []
        for automaton in event.automata:
            if read.isdisjoint(automaton.writes):
                continue
            taken = [
                ([(automaton, edge)], taken_where(self.plant, automaton, edge))
                for edge in automaton.edges
            ]
            ignored: tuple[_Taken, list[Expr]] = (
                [],
                [negation(conjunction(where)) for _, where in taken],
            )
            options.append([*taken, ignored])
        if (options or self._changes_phase(event, read)) and prod(
            map(len, options)
        ) <= limits.TRANSITION_CHOICES:
            for choice in product(*options):
                yield (
                    [pair for taken, _ in choice for pair in taken],
                    [condition for _, where in choice for condition in where],
                )

    def _changes_phase(self, event: Event, read: frozenset[int]) -> bool:
        return event.phase is not None and event.phase.variable in read

    def _diagnostic(
        self, action: Event, requirement: Requirement, said: str, trace: str
    ) -> Diagnostic:
        return Diagnostic(
            Severity.WARNING,
            "self-cancelling",
            f"{quoted(requirement.text)} is also a reason to cancel {action.name}, and {said}:"
            f" after {trace}, {action.name} is cancelled",
            requirement.span,
            "what is only about the beginning belongs into a requirement that ends with 'to start'",
        )


def _assigned(event: Event, from_value: bool = False) -> frozenset[int]:
    """The state variables that an event assigns; ``from_value``: from what it brings."""
    return frozenset(
        variable
        for automaton in event.automata
        for edge in automaton.edges
        for variable, expr in edge.updates
        if not from_value or values_read([expr])
    )


def _named_alike(plant: Plant, action: Event, condition: Expr) -> frozenset[int]:
    """The state variables of a condition that are called after an action, or have such a state.

    The state of a component that takes the request says only that the action runs.
    """
    stem = _stem(dotted.last(action.name).rpartition("_")[2])
    takes_part = {automaton.component for automaton in action.automata}
    found = set()
    for part in walk_all([condition]):
        names = []
        if isinstance(part, VariableRef | TestRef):
            sides = part.sides if isinstance(part, TestRef) else (part,)
            names = [p.variable for p in walk_all(sides) if isinstance(p, VariableRef)]
        elif isinstance(part, StateRef) and part.component not in takes_part:
            names = [part.state, *part.within]
        variable = plant.variable_of(part)
        if variable is not None and any(len(stem) > 2 and _stem(n) == stem for n in names):
            found.add(variable)
    return frozenset(found)


def _stem(name: str) -> str:
    """Return what ``undock``, ``docked`` and ``is_docked`` have in common: ``dock``."""
    word = re.sub(r"^(is|has|was)_?(?=[a-z]{3})", "", name.lower())
    word = re.sub(r"^(un|dis)(?=[a-z]{3})", "", word)
    word = re.sub(r"(ed|ing|e)$", "", word)
    return re.sub(r"([bdgklmnprt])\1$", r"\1", word)
