"""The cases that the runs of a package's test are to show, and which of them a step shows.

A case is a tuple; its first word says of what sort it is. In one of a condition, one comparison or
other atom of the condition *alone decides*: if it came out otherwise, so would the whole, and
nothing else would stand in the way.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

from robosc.emit.controller.naming import place
from robosc.expr.tree import TRUE, Expr, Operation
from robosc.expr.types import BooleanType
from robosc.language.events import EventKind
from robosc.plant.logic import exact
from robosc.plant.model_text import to_dsl
from robosc.plant.part_names import LONG
from robosc.runtime.core.places import told_with_stage
from robosc.runtime.core.shortening import shortened_text
from robosc.runtime.core.values import Undefined
from robosc.simulate.machines.machine import label
from robosc.traces.deciding_atoms import Atom, DecidedCondition, filtered_in
from robosc.traces.exact_steps import (
    NOTHING,
    Carried,
    ExactEdge,
    ExactStep,
    Function,
    Partner,
    State,
    Steps,
    holds,
)

Case: TypeAlias = tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class Demand:
    """A condition on a command: what it is called, its place in the model, and itself.

    ``requirement`` is the index of a requirement; None: what synthesis demands beyond them.
    """

    text: str
    place: str
    requirement: int | None
    condition: DecidedCondition


@dataclass(frozen=True, eq=False)
class CommandDemands:
    """A command with all that may stand in its way."""

    step: ExactStep
    demands: tuple[Demand, ...]
    preferred: tuple[ExactStep, ...]


@dataclass(frozen=True, eq=False)
class JudgedEdge:
    """An edge with its guard (None: it has none), and the conditions that become variables."""

    edge: ExactEdge
    guard: DecidedCondition | None
    made: Mapping[str, DecidedCondition]


class Coverage:
    """All cases of a supervised robot: ``cases`` are their texts."""

    def __init__(self, steps: Steps) -> None:
        self.steps = steps
        self.robot = steps.robot
        self.rules = [
            self._rule(step) for step in steps.commands if step.event.key not in steps.unjudged
        ]
        self._edges: dict[tuple[int, str, str], list[JudgedEdge]] = {
            (step.number, partner.component, location): [self._judged(edge) for edge in edges]
            for step in steps.steps
            for partner in step.partners
            for location, edges in partner.edges.items()
        }
        self._elsewhere: dict[tuple[int, str], list[JudgedEdge]] = {}
        for (number, component, _), judged in self._edges.items():
            self._elsewhere.setdefault((number, component), []).extend(judged)
        self._provides = {
            step.number: [
                (p, None if c is None else self._condition(p.condition or TRUE))
                for c, p, _ in step.provides
            ]
            for step in steps.commands
        }
        self._by_data = {rule.step.number for rule in self.rules if steps.reads_data(rule.step)}
        self.rules_by_number = {rule.step.number: rule for rule in self.rules}
        self.outcomes: dict[Case, str] = {}
        """By case of a demand: which part of it decides, and how."""
        self.cases: dict[Case, str] = dict(self._all())

    def _text(self, expr: Expr) -> str:
        return to_dsl(expr, self.robot)

    def _condition(self, expr: Expr) -> DecidedCondition:
        return DecidedCondition(expr, self._text)

    def _judged(self, edge: ExactEdge) -> JudgedEdge:
        guard = None if edge.condition is None else self._condition(edge.condition)
        made = zip(edge.assigned, edge.made, strict=True)
        return JudgedEdge(edge, guard, {a[0]: self._condition(v) for a, v in made if _joins(v)})

    def _rule(self, step: ExactStep) -> CommandDemands:
        event, robot = step.event, self.robot
        guard = self.steps.guards.get(event.identity)
        demands = []
        if event.kind.sent:
            for index in event.requirements:
                requirement = robot.requirements[index]
                met = exact(self.steps.plant.view.met(requirement))
                where = place(requirement.span)
                demands.append(Demand(requirement.text, where, index, self._condition(met)))
        if guard is not None and (guard.status != "as required" or not event.kind.sent):
            text = "synthesis" if event.kind.sent else "a requirement that is violated"
            where = place(event.span)
            if guard.expr != TRUE:
                demands.append(Demand(text, where, None, self._condition(exact(guard.expr))))
        preferred = self.steps.preferred.get(event.command, ()) if event.kind.sent else ()
        return CommandDemands(step, tuple(demands), tuple(preferred))

    # --- all cases -------------------------------------------------------------------------------

    def _all(self) -> Iterator[tuple[Case, str]]:
        for number in self.steps.on_states:
            requirement = self.robot.requirements[number]
            told = f"{shortened_text(requirement.text, LONG)} ({place(requirement.span)})"
            yield ("states", number, True), f"{told} holds"
            yield ("states", number, False), f"{told} is violated"
        for rule in self.rules:
            yield from self._of_rule(rule)
        for step in self.steps.steps:
            event = step.event
            if not event.controllable:
                for phase in step.sources or ("",):
                    yield (
                        ("event", step.number, phase),
                        f"{label(event)}{phase and f' while {phase}'}",
                    )
            for partner in step.partners:
                if partner.component in (*self._components, event.key):
                    yield from self._of_partner(step, partner)

    @cached_property
    def _components(self) -> set[str]:
        return {c.name for c in self.robot.components}

    def _of_rule(self, rule: CommandDemands) -> Iterator[tuple[Case, str]]:
        number, name = rule.step.number, label(rule.step.event)
        yield ("sent", number), f"{name} is sent"
        if rule.step.may_replace:
            yield ("replaced", number, True), f"{name} takes the place of the goal that runs"
            if self.steps.guards_others:
                yield ("replaced", number, False), f"{name} must not take the place of another goal"
        for index, demand in enumerate(rule.demands):
            demanded = shortened_text(demand.text, LONG)
            for outcome, text in _outcomes(demand.condition):
                told = f"{name}, {demanded} ({demand.place}): {text} alone decides"
                short = text.replace(", which is ", " is ").rstrip(",")
                case: Case = ("demand", number, index, *outcome)
                self.outcomes[case] = short
                yield case, told
        for partner in rule.step.partners:
            if partner.blocking:
                yield (
                    ("blocked", number, partner.component),
                    f"{name}: {partner.component} blocks it",
                )
        for other in rule.preferred:
            yield ("yields", number, other.number), f"{name} waits for {label(other.event)}"
        for index, (provide, condition) in enumerate(self._provides[number]):
            where = f"{name}, provide ({place(provide.span)})"
            yield ("provided", number, index), f"{where} gives its data"
            for outcome, text in () if condition is None else _outcomes(condition):
                yield ("provide", number, index, *outcome), f"{where}: {text} alone decides"

    def _of_partner(self, step: ExactStep, partner: Partner) -> Iterator[tuple[Case, str]]:
        name = label(step.event)
        for location in partner.edges:
            for judged in self._edges[step.number, partner.component, location]:
                (line, target), assigned = judged.edge.name, judged.edge.assigned
                case = step.number, partner.component, line, target
                where = f"(line {line}{target and f', to {told_with_stage(target)}'})"
                told = f"{name} in {partner.component} {where}"
                if partner.component == step.event.key:
                    told = f"{name} as expected {where}"
                yield ("taken", *case), told
                for key, *_ in assigned:
                    yield ("assigned", *case, key), f"{told}, which changes {key}"
                for outcome, text in () if judged.guard is None else _outcomes(judged.guard):
                    yield ("edge", *case, *outcome), f"{told}: {text} alone decides"
                for key, condition in judged.made.items():
                    for outcome, text in _outcomes(condition):
                        yield ("made", *case, key, *outcome), f"{told}: {text} decides {key}"

    # --- what is shown ---------------------------------------------------------------------------

    def of_state(self, state: State) -> set[Case]:
        """The cases of a state in which the controller waits."""
        violated = self.steps.violated(state)
        found: set[Case] = {("states", n, n not in violated) for n in self.steps.on_states}
        for rule in self.rules:
            if not self.steps.guards_others:
                self._see_rule(rule, state, found, None)
            elif not self.steps.follows and rule.step.number not in self._by_data:
                self._see_reasons(rule, state, found)
        for step in self.steps.taus:
            for partner in step.partners:
                self._see_edges(step, partner, state, NOTHING, found, False)
        return found

    def _see_reasons(self, rule: CommandDemands, state: State, found: set[Case]) -> None:
        """See which demand alone is told beside what else is in the way of a command."""
        step = rule.step
        if step.in_phase(state) and not step.blocked_by(state, NOTHING):
            return
        outcomes = [demand.condition.deciding(state)[0] for demand in rule.demands]
        if outcomes.count(False) == 1:
            found.add(("told", step.number, outcomes.index(False)))

    def _see_rule(
        self, rule: CommandDemands, state: State, found: set[Case], carried: Carried | None
    ) -> None:
        step = rule.step
        if not step.in_phase(state):
            return
        try:
            carried = step.carried(state) if carried is None else carried
        except Undefined:
            return
        blocking = step.blocked_by(state, carried)
        preferred = [other for other in rule.preferred if other.allowed(state)]
        outcomes = [demand.condition.deciding(state, carried) for demand in rule.demands]
        failing = [n for n, (value, _) in enumerate(outcomes) if not value]
        if len(blocking) + len(failing) + len(preferred) > 1:
            return
        if blocking:
            found.add(("blocked", step.number, blocking[0].component))
            return
        if preferred:
            found.add(("yields", step.number, preferred[0].number))
            return
        if step.after(state, carried) is None:
            return
        for index, (_, deciding) in enumerate(outcomes):
            if not failing or failing == [index]:
                found |= {("demand", step.number, index, *outcome) for outcome in deciding}

    def of_step(self, step: ExactStep, state: State, carried: Carried, after: State) -> set[Case]:
        """The cases of an event that happens in a state."""
        found: set[Case] = set()
        for partner in step.partners:
            found.add(("at", step.number, partner.component, state[partner.place]))
        if step.event.controllable:
            if step.event.kind is not EventKind.TAU:
                found.add(("sent", step.number))
                found |= {("replaced", step.number, True)} if step.replaces(state) else set()
                found |= self.of_state_of(step, state, carried)
                self._see_data(step, state, found)
        else:
            found.add(("event", step.number, "" if step.phase is None else state[step.phase]))
        for partner in step.partners:
            self._see_edges(step, partner, state, carried, found, True, after)
            self._see_stays(step, partner, (state, after), carried, found)
        return found

    def of_refusal(self, step: ExactStep, state: State, carried: Carried) -> set[Case]:
        """The cases of an answer that is not as expected."""
        found: set[Case] = {("refused", step.number, state[f"~{step.event.key}"])}
        for partner in step.partners:
            if partner.component == step.event.key:
                self._see_edges(step, partner, state, carried, found, False)
        return found

    def of_refused_call(self, step: ExactStep, state: State, carried: Carried) -> set[Case]:
        """The cases of a call that no component takes."""
        found: set[Case] = {("refused", step.number, "idle")}
        for partner in step.partners:
            found.add(("refused", step.number, partner.component, state[partner.place]))
            self._see_edges(step, partner, state, carried, found, False)
            self._see_stays(step, partner, (state, state), carried, found)
        return found

    def allows(self, step: ExactStep, state: State, carried: Carried) -> bool:
        """Whether a command of another controller may pass."""
        rule = self.rules_by_number[step.number]
        met = all(demand.condition.deciding(state, carried)[0] for demand in rule.demands)
        guarded = step.guard is None or holds(step.guard, state, carried)
        return met and guarded and step.after(state, carried) is not None

    def reasons(
        self, step: ExactStep, state: State, carried: Carried | None = None
    ) -> tuple[str, ...] | None:
        """Why a command is not enabled, as a node tells it; None if that cannot be told."""
        rule = self.rules_by_number[step.number]
        if step.event.kind is EventKind.CANCEL:
            return None
        found = []
        if not step.in_phase(state):
            found.append(f"it is {state[step.phase or '']}")
        try:
            carried = step.carried(state) if carried is None else carried
        except Undefined:
            return None
        blocking = step.blocked_by(state, carried)
        if step.in_phase(state) and not blocking and step.after(state, carried) is None:
            return None
        if any(p.component not in self._components for p in blocking):
            return None
        for name in dict.fromkeys(p.component for p in blocking):
            found.append(f"blocked by {name} in {told_with_stage(state[name])}")
        for demand in rule.demands:
            if demand.condition.deciding(state, carried)[0]:
                continue
            if demand.requirement is None:
                return None
            found.append(demand.text)
        return tuple(found) if found else None

    def of_state_of(
        self, step: ExactStep, state: State, carried: Carried | None = None
    ) -> set[Case]:
        """The cases of one command in a state; ``carried`` is what another controller sends."""
        found: set[Case] = set()
        guards = self.steps.guards_others
        self._see_rule(self.rules_by_number[step.number], state, found, carried if guards else None)
        return found

    def _see_edges(
        self,
        step: ExactStep,
        partner: Partner,
        state: State,
        carried: Carried,
        found: set[Case],
        happens: bool,
        after: State | None = None,
    ) -> None:
        for judged in self.edges_at(step, partner, state):
            edge, value = judged.edge, True
            case = step.number, partner.component, *edge.name
            if judged.guard is not None:
                value, deciding = judged.guard.deciding(state, carried)
                found |= {("edge", *case, *outcome) for outcome in deciding}
            if not value:
                continue
            if happens and after is not None:
                found.add(("taken", *case))
                for key, *_ in edge.assigned:
                    if after[key] != state[key]:
                        found.add(("assigned", *case, key))
                for key, condition in judged.made.items():
                    deciding = condition.deciding(state, carried)[1]
                    found |= {("made", *case, key, *outcome) for outcome in deciding}
            return

    def _see_stays(
        self,
        step: ExactStep,
        partner: Partner,
        states: tuple[State, State],
        carried: Carried,
        found: set[Case],
    ) -> None:
        """See which edges of other locations are not taken, though their guards hold and internal
        transitions would not lead on to the same."""
        state, after = states
        for number, edge in self._open_elsewhere(step, partner, state, carried):
            if self._end(after) != self._end(after | {partner.place: edge.target}):
                found.add(("stays", step.number, partner.component, number))

    def _open_elsewhere(
        self, step: ExactStep, partner: Partner, state: State, carried: Carried
    ) -> Iterator[tuple[int, ExactEdge]]:
        """The edges of an event, by number, that leave other locations, and whose guards hold."""
        here = {judged.edge.name for judged in self.edges_at(step, partner, state)}
        for number, judged in enumerate(self._elsewhere.get((step.number, partner.component), ())):
            if judged.edge.name not in here and judged.edge.is_open(state, carried):
                yield number, judged.edge

    def open_elsewhere(self, step: ExactStep, state: State) -> frozenset[Case]:
        """The edges with guards that would be taken if a component were elsewhere."""
        return frozenset(
            (partner.component, number)
            for partner in step.partners
            for number, edge in self._open_elsewhere(step, partner, state, NOTHING)
            if edge.guard is not None
        )

    def _end(self, state: State) -> State:
        """The state to which internal transitions lead."""
        for _, _, after in self.steps.completed(state):
            state = after
        return state

    def edges_at(self, step: ExactStep, partner: Partner, state: State) -> Sequence[JudgedEdge]:
        """The edges of an event that leave where a component is."""
        return self._edges.get((step.number, partner.component, state[partner.place]), ())

    def provided_if(self, step: ExactStep) -> list[DecidedCondition | None]:
        """The conditions of the statements that give a command's data."""
        return [condition for _, condition in self._provides[step.number]]

    def _see_data(self, step: ExactStep, state: State, found: set[Case]) -> None:
        for index, (_, condition) in enumerate(self._provides[step.number]):
            value = True
            if condition is not None:
                value, deciding = condition.deciding(state)
                found |= {("provide", step.number, index, *outcome) for outcome in deciding}
            if value:
                found.add(("provided", step.number, index))
                return

    def atoms(self) -> Sequence[Function]:
        """The atoms over states alone; two states in which all agree are alike."""
        conditions = [d.condition for rule in self.rules for d in rule.demands]
        edges = [judged for several in self._edges.values() for judged in several]
        conditions += [judged.guard for judged in edges if judged.guard is not None]
        conditions += [condition for judged in edges for condition in judged.made.values()]
        conditions += [c for found in self._provides.values() for _, c in found if c is not None]
        # What another controller sends comes later, in a state that is like the first of its kind.
        guards = self.steps.guards_others
        return [a.outcome if guards else a.value for c in conditions for a in c.outer]


def through(step: ExactStep, before: State, after: State) -> set[Case]:
    """From where to where an event leads components, with all that follows at once; of a delay,
    also what it began with."""
    delayed = step.event.kind is EventKind.AFTER
    places = (
        (p.component, before[p.place], after[p.place], before[p.begun] if delayed else None)
        for p in step.partners
    )
    return {("through", step.number, *place) for place in places}


def _joins(expr: Expr) -> bool:
    """Whether an expression is a condition with parts, or has one on elements of an array."""
    is_condition = isinstance(expr, Operation) and expr.type == BooleanType()
    return is_condition or bool(expr.type != BooleanType() and filtered_in(expr))


_NEAR = {
    "at": "at the number",
    "below": "just below the number",
    "above": "just above the number",
}


def _outcomes(condition: DecidedCondition) -> Iterator[tuple[tuple[int, bool, str], str]]:
    """What each atom can come to, with the text of it."""
    for number, atom in enumerate(condition.atoms):
        for value in (True, False):
            yield (number, value, ""), f"{atom.text}, which is {str(value).lower()},"
        if atom.sides is None:
            continue
        for near, text in _NEAR.items():
            for value in (True, False):
                if _can_be(atom, near, value):
                    yield (number, value, near), f"{atom.text}, {text},"


def _can_be(atom: Atom, near: str, value: bool) -> bool:
    """Whether a comparison has this value there."""
    word = next(w for w in (" <= ", " >= ", " != ", " < ", " > ", " = ", "") if w in atom.text)
    true = {
        " <= ": ("at", "below"), " < ": ("below",), " >= ": ("at", "above"), " > ": ("above",),
        " = ": ("at",), " != ": ("below", "above"),
    }.get(word)  # fmt: skip
    return true is None or (near in true) is value
