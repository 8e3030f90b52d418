"""Diagnostics of a model that need the state space (docs/diagnostics.md).

Each check is a condition; if a state of the controlled system satisfies it, the message has a
short trace to that state.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from robosc.errors import Diagnostic, Note, Severity, listing
from robosc.expr.traversal import walk_all
from robosc.expr.tree import TRUE, Expr, StateRef
from robosc.expr.types import NoneType, ObjectType
from robosc.language.events import EventKind, Kind
from robosc.model.entities import Command, Provide, Requirement
from robosc.plant.acceptance import components_of, phase_of
from robosc.plant.automaton import Edge, Event, LocalAutomaton, Plant
from robosc.plant.data.view import sent_wholes
from robosc.plant.logic import conjunction, disjunction, negation
from robosc.plant.model_text import to_dsl
from robosc.plant.partial_evaluation import holds
from robosc.runtime.core.places import place_of
from robosc.source import Span
from robosc.supervisor import Guard
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.controlled_system import System, enabled, in_phase, possible, steps_of
from robosc.synthesis.event_parameters import for_some
from robosc.synthesis.explain.assumed import assumed
from robosc.synthesis.explain.self_cancelling import self_cancelling
from robosc.synthesis.explain.starts import UNTRACED, whereabouts
from robosc.synthesis.formatting import quoted, trace_text
from robosc.synthesis.guards.greedy_selection import drop


def warnings(system: System, guards: Sequence[Guard]) -> tuple[Diagnostic, ...]:
    """Return errors and warnings of the controlled system, in no order."""
    examiner = _Examiner(system, guards)
    return (
        *examiner.topics(),
        *examiner.provides(),
        *examiner.requirements(),
        *examiner.overlaps(),
        *_free_goals(system.plant),
        *_goals_without_effect(system),
        *self_cancelling(system, guards),
        *assumed(system, guards, examiner.when),
    )


def _free_goals(plant: Plant) -> Iterator[Diagnostic]:
    """Yield a warning for each goal that reads what is taken as free."""
    for goal in plant.goals:
        written = plant.robot.goals[goal.index]
        texts = (to_dsl(part, plant.robot) for part in walk_all(written.conditions))
        free = next((text for text in texts if text in plant.view.free), None)
        if free is not None:
            yield Diagnostic(
                Severity.WARNING,
                "possible-free",
                f"{quoted(written.text)} reads '{free}', of which every outcome counts as possible:"
                " the robot need not come there",
                written.span,
                f"compare with a constant, or let a state tell it ({plant.view.free[free]})",
            )


def _goals_without_effect(system: System) -> Iterator[Diagnostic]:
    """Yield a warning for each goal that holds wherever it is asked for, or never is."""
    for goal in system.plant.goals:
        if system.plant_reaches(conjunction([goal.origin, negation(goal.condition)])) is not False:
            continue
        written = system.plant.robot.goals[goal.index]
        asked = system.plant_reaches(goal.origin)
        yield Diagnostic(
            Severity.WARNING,
            "requirement-always-true",
            f"{quoted(written.text)} asks for nothing: "
            + ("it holds there already" if asked else "the condition behind 'from' never holds"),
            written.span,
            "remove it, or correct the condition",
        )


class _Examiner:
    def __init__(self, system: System, guards: Sequence[Guard]) -> None:
        self.system = system
        self.plant: Plant = system.plant
        self.robot = system.plant.robot
        self.stepper = Stepper(system.plant)
        self.requests: dict[str, list[Guard]] = {}
        """Those of each command; of one whose data another controller sends, one for each case."""
        for guard in guards:
            if guard.event.kind.sent:
                self.requests.setdefault(guard.event.command, []).append(guard)
        taus = (guard for guard in guards if guard.event.kind is EventKind.TAU)
        self.at_rest = conjunction(negation(self._moves(tau)) for tau in taus)
        """Where commands are sent: elsewhere the controller takes internal transitions first."""

    def _moves(self, tau: Guard) -> Expr:
        """Return the condition under which the controller takes an internal transition."""
        automaton, *resets = tau.event.automata
        moving = tuple(e for e in automaton.edges if e.source != e.target or e.updates)
        event = replace(tau.event, automata=(replace(automaton, edges=moving), *resets))
        return conjunction([tau.expr, possible(self.plant, event)])

    def _sent(self, key: str) -> Expr:
        """Return the condition under which a command may be sent."""
        cases = disjunction(enabled(self.plant, guard) for guard in self.requests[key])
        return conjunction([cases, self.at_rest])

    def when(self, condition: Expr) -> str | None:
        """Return how a state with a condition is reached, to end a sentence with; None: never."""
        path = self.system.nearest(condition)
        if path is None:
            return None
        if not self.plant.is_initial(path[0]):
            return f"{whereabouts(self.plant, path[0], condition)} {UNTRACED}"
        trace = trace_text(steps_of(self.stepper, path))
        return f"after {trace}" if trace else "at the start"

    # --- two commands on one topic

    def topics(self) -> Iterator[Diagnostic]:
        by_topic: dict[str, list[str]] = {}
        # A supervisor leaves the choice to the controller that it guards.
        for key in () if self.robot.supervises else self.requests:
            communication = self.robot.commands[key].communication
            if communication.kind is Kind.INCOMING:
                by_topic.setdefault(communication.ros_name, []).append(key)
        for keys in by_topic.values():
            for first, second in combinations(keys, 2):
                if not self._one_is_preferred(first, second):
                    yield from self._topic(first, second)

    def _one_is_preferred(self, first: str, second: str) -> bool:
        """Whether a preference excludes that two commands are sent in one state."""
        yields_to = self.robot.yields_to
        return first in yields_to.get(second, ()) or second in yields_to.get(first, ())

    def _topic(self, first: str, second: str) -> Iterator[Diagnostic]:
        when = self.when(conjunction([self._sent(first), self._sent(second)]))
        if when is None:
            return
        first_one, second_one = (self.robot.communications[key] for key in (first, second))
        names = [self.robot.display_names[key] for key in (first, second)]
        more, less = reversed(names) if first == self.robot.stop else names
        topic = first_one.identifier
        yield Diagnostic(
            Severity.WARNING,
            "topic-conflict",
            f"{names[0]} and {names[1]} both go to {topic} and can be enabled together: {when}",
            second_one.span,
            f"say which comes first, as in 'prefer {more} over {less}', or let the requirements of"
            " one exclude the other",
            (Note(f"{names[0]} is declared here", first_one.span),),
        )

    # --- provided data

    def provides(self) -> Iterator[Diagnostic]:
        by_key: dict[str, list[Provide]] = {}
        for provide in () if self.robot.supervises else self.robot.provides:
            by_key.setdefault(provide.communication, []).append(provide)
        for key, provides in by_key.items():
            if key in self.requests:
                command = self._sent(key)
                yield from self._together(key, provides, command)
                yield from self._missing(key, provides, command)
                yield from self._nothing_to_send(key, provides, command)
        for key in self.requests:
            if key not in by_key:
                yield from self._never_provided(key)

    def _never_provided(self, key: str) -> Iterator[Diagnostic]:
        """Warn of a command with data that no statement provides.

        Zeros stop a robot: what :attr:`Robot.stop` names, or what is sent to a topic beside a
        command with data, may do without.
        """
        command = self.robot.commands[key]
        if self._carries_nothing(command) or key == self.robot.stop or self.robot.supervises:
            return
        provided = [self.robot.commands[p.communication] for p in self.robot.provides]
        on_its_name = (c.communication.ros_name for c in provided if c.kind is command.kind)
        if command.communication.ros_name in on_its_name:
            return
        if self.system.reaches(self._sent(key)):
            name = self.robot.display_names[key]
            yield Diagnostic(
                Severity.WARNING,
                "provide-missing",
                f"nothing says what {name} carries: the message's defaults are sent",
                command.communication.span,
                f"say it: provide {name} with ...",
            )

    @staticmethod
    def _carries_nothing(command: Command) -> bool:
        match command.type:
            case NoneType() | ObjectType(properties=()):
                return True
        return False

    def _together(
        self, key: str, provides: Sequence[Provide], command: Expr
    ) -> Iterator[Diagnostic]:
        for number, second in enumerate(provides):
            before = provides[:number]
            if second.condition is None:  # it is for the rest
                before = [p for p in before if p.condition is None]
            for first in before:
                both = [self._condition(p) for p in (first, second)]
                when = self.when(conjunction([command, *both]))
                if when is not None:
                    name = self.robot.display_names[key]
                    yield Diagnostic(
                        Severity.WARNING,
                        "provide-overlap",
                        f"two provide statements of {name} can hold together: {when}; the first"
                        " one in the file is used",
                        second.span,
                        "make their conditions exclude each other",
                        (Note("the other one", first.span),),
                    )
                    break

    def _missing(
        self, key: str, provides: Sequence[Provide], command: Expr
    ) -> Iterator[Diagnostic]:
        none = conjunction(negation(self._condition(p)) for p in provides)
        when = self.when(conjunction([command, none]))
        if when is not None:
            name = self.robot.display_names[key]
            yield Diagnostic(
                Severity.WARNING,
                "provide-missing",
                f"{name} can be sent where none of its provide conditions holds: {when}; the"
                " message's defaults are sent then",
                self.robot.commands[key].communication.span,
                f"add a provide statement for that case, or a requirement that forbids {name} then",
            )

    def _nothing_to_send(
        self, key: str, provides: Sequence[Provide], command: Expr
    ) -> Iterator[Diagnostic]:
        """Warn of data that may not have arrived when a command is to be sent with them."""
        earlier: list[Expr] = []
        for provide in provides:
            condition = self._condition(provide)
            for variable in dict.fromkeys(sent_wholes(provide)):
                absent = negation(self.plant.view.is_there(variable))
                when = self.when(conjunction([command, condition, *earlier, absent]))
                if when is not None:
                    yield self._about_absence(key, provide, to_dsl(variable, self.robot), when)
            earlier.append(negation(condition))

    def _about_absence(self, key: str, provide: Provide, data: str, when: str) -> Diagnostic:
        name = self.robot.display_names[key]
        return Diagnostic(
            Severity.WARNING,
            "nothing-to-send",
            f"{name} can be enabled while {data}, which it carries, holds nothing: {when}; it is"
            " not sent then",
            provide.span,
            f"let {name} need a state that is entered when {data} is assigned",
        )

    def _condition(self, provide: Provide) -> Expr:
        condition = provide.condition
        return TRUE if condition is None else self.plant.view.expression(condition)

    # --- requirements

    def requirements(self) -> Iterator[Diagnostic]:
        numbers = {number for _, number in self.plant.invariants}
        numbers.update(number for event in self.plant.events for number in event.requirements)
        reported: set[str] = set()
        for number in sorted(numbers):
            yield from self._requirement(self.robot.requirements[number], reported)
        for key, cases in self.requests.items():
            if all(guard.status == "never" for guard in cases) and key not in reported:
                yield from self._unmet_together([guard.event for guard in cases])

    def _requirement(self, requirement: Requirement, reported: set[str]) -> Iterator[Diagnostic]:
        """Check one requirement; add the commands that it makes impossible to ``reported``."""
        kept = self.plant.view.met(requirement)
        # One on data keeps whoever changes what is provided from sending what must not be sent.
        if not requirement.on_data and self.system.plant_reaches(negation(kept)) is False:
            if not requirement.implied:
                yield Diagnostic(
                    Severity.WARNING,
                    "requirement-always-true",
                    f"{quoted(requirement.text)} forbids nothing: its condition never"
                    f" {'holds' if requirement.forbids else 'fails'}",
                    requirement.span,
                    "remove it, or correct the condition",
                )
            return
        if requirement.to_cancel:
            return
        unmet = []
        for key in filter(self.requests.__contains__, requirement.communications):
            cases = [(g.event.data, possible(self.plant, g.event)) for g in self.requests[key]]
            where = disjunction(conjunction([holds(kept, data), at]) for data, at in cases)
            if self.system.plant_reaches(where) is False:
                if self.system.plant_reaches(disjunction(at for _, at in cases)) is False:
                    continue  # its components block it, whatever is required
                unmet.append(self.robot.display_names[key])
                reported.add(key)
        if unmet:
            yield Diagnostic(
                Severity.WARNING,
                "requirement-never-met",
                f"{quoted(requirement.text)} can never be met: {listing(unmet)} can never happen",
                requirement.span,
                "correct the condition",
            )

    def _unmet_together(self, cases: Sequence[Event]) -> Iterator[Diagnostic]:
        """Warn of requirements of a command that never hold together where it is possible."""

        def never_met(requirements: Sequence[Requirement]) -> bool:
            kept = list(map(self.plant.view.met, requirements))
            some = disjunction(
                conjunction([possible(self.plant, e), *(holds(each, e.data) for each in kept)])
                for e in cases
            )
            return not self.system.reaches(some)

        def without(
            left: list[Requirement], some: Sequence[Requirement]
        ) -> list[Requirement] | None:
            fewer = [requirement for requirement in left if requirement not in some]
            return fewer if never_met(fewer) else None

        event = cases[0]
        found = [self.robot.requirements[number] for number in event.requirements]
        if not found or never_met([]) or not never_met(found):
            return
        first, *others = drop(found, found, without)
        texts = listing([quoted(requirement.text) for requirement in (first, *others)])
        yield Diagnostic(
            Severity.WARNING,
            "requirement-never-met",
            f"{texts} can never be met{' together' if others else ' under control'}:"
            f" {event.name} can never happen",
            first.span,
            "correct the condition, or what keeps the system from getting there",
            tuple(Note("together with this one", other.span) for other in others),
        )

    # --- guarded transitions

    def overlaps(self) -> Iterator[Diagnostic]:
        for event in self.plant.events:
            for automaton in components_of(event):
                reported: set[tuple[Span, Span]] = set()
                for first, second in _guarded_pairs(automaton):
                    # A transition of the whole automaton is an edge in every location.
                    if (first.span, second.span) not in reported:
                        found = list(self._overlap(event, automaton, first, second))
                        reported.update((first.span, second.span) for _ in found)
                        yield from found

    def _overlap(
        self, event: Event, automaton: LocalAutomaton, first: Edge, second: Edge
    ) -> Iterator[Diagnostic]:
        assert first.guard is not None and second.guard is not None
        state = str(self.plant.variables[automaton.variable].values[first.source])
        here: list[Expr] = [StateRef(automaton.component, state)]
        if (phase := phase_of(event)) is not None:
            here.append(in_phase(self.plant, phase))
        both = for_some(event, [first.guard, second.guard])
        when = self.when(conjunction([*here, both]))
        if when is not None:
            guards = [to_dsl(guard, self.robot) for guard in (first.guard, second.guard)]
            yield Diagnostic(
                Severity.ERROR,
                "guard-overlap",
                f"the guards '{guards[0]}' and '{guards[1]}' of two transitions on"
                f" {event.name}.{event.kind.word} in state {place_of(state)} of"
                f" {automaton.component} can hold together: {when}",
                second.span,
                "make the guards exclude each other",
                (Note("the other transition", first.span),),
            )


def _guarded_pairs(automaton: LocalAutomaton) -> Iterator[tuple[Edge, Edge]]:
    for first, second in combinations(automaton.edges, 2):
        if first.source != second.source or first.levels != second.levels or len(first.levels) != 1:
            continue
        if first.guard is not None and second.guard is not None:
            yield first, second
