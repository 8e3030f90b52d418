"""The cases that the runs of a package's test are to show, and which of them a step shows.

A case is a tuple; its first word says of what sort it is. In one of a condition, one comparison or
other atom of the condition *alone decides*: if it came out otherwise, so would the whole, and
nothing else would stand in the way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from typing import Any, TypeAlias

from robosc.expr.tree import TRUE, Expr, Operation
from robosc.expr.types import BooleanType
from robosc.language.events import EventKind
from robosc.lazy_dataclasses import dataclass
from robosc.model.entities import data_expressions
from robosc.plant.logic import exact
from robosc.plant.model_text import to_dsl
from robosc.plant.part_names import LONG
from robosc.runtime.core.places import told_with_stage
from robosc.runtime.core.shortening import shortened_text
from robosc.runtime.core.values import Undefined
from robosc.simulate.machines.machine import label
from robosc.traces.data_pieces import SectionEnds, pieces_of
from robosc.traces.deciding_atoms import Atom, DecidedCondition, filtered_in
from robosc.traces.exact_steps import (
    NOTHING,
    UNKNOWN,
    Carried,
    ExactEdge,
    ExactStep,
    Function,
    Partner,
    Results,
    State,
    Steps,
    Unknown,
    holds,
    keys_read,
    possible_values,
    remembering,
)
from robosc.traces.regions import regions

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
class Obstacle:
    """What may stand in the way of a command: whether it lets it pass, with the cases that this is
    if nothing else stands there; and as what a node tells it (None: that cannot be told)."""

    ways: Mapping[bool, Sequence[Case]]
    told: str | None
    is_guard: bool = False
    """Whether it is what synthesis demands beyond the requirements, and with them."""

    @property
    def may_pass(self) -> bool:
        return True in self.ways


@dataclass(frozen=True, eq=False)
class JudgedEdge:
    """An edge with its guard, and the conditions that become variables; the ends of sections in the
    guard, and in what else is read."""

    edge: ExactEdge
    guard: DecidedCondition
    made: Mapping[str, DecidedCondition]
    asked: SectionEnds
    read: Sequence[SectionEnds]


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
                (p, self._condition(exact(p.condition or TRUE))) for p in steps.provides_of(step)
            ]
            for step in steps.commands
        }
        self._pieces = {
            number: [pieces_of(p.data, self._text) for p, _ in given]
            for number, given in self._provides.items()
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
        guard = self._condition(edge.condition or TRUE)
        pairs = zip(edge.assigned, edge.made, strict=True)
        made = {a[0]: self._condition(v) for a, v in pairs if _joins(v)}
        read = [SectionEnds(value, self._text) for value in edge.made]
        return JudgedEdge(edge, guard, made, SectionEnds(guard.expr, self._text), read)

    def _rule(self, step: ExactStep) -> CommandDemands:
        event, robot = step.event, self.robot
        guard = self.steps.guards.get(event.identity)
        demands = []
        if event.kind.sent:
            for index in event.requirements:
                requirement = robot.requirements[index]
                met = exact(self.steps.plant.view.met(requirement))
                where = requirement.span.place
                demands.append(Demand(requirement.text, where, index, self._condition(met)))
        if guard is not None and (guard.status != "as required" or not event.kind.sent):
            text = "synthesis" if event.kind.sent else "a requirement that is violated"
            where = event.span.place
            if guard.expr != TRUE:
                demands.append(Demand(text, where, None, self._condition(exact(guard.expr))))
        preferred = self.steps.preferred.get(event.command, ()) if event.kind.sent else ()
        return CommandDemands(step, tuple(demands), tuple(preferred))

    # --- all cases -------------------------------------------------------------------------------

    def _all(self) -> Iterator[tuple[Case, str]]:
        for number in self.steps.on_states:
            requirement = self.robot.requirements[number]
            told = f"{shortened_text(requirement.text, LONG)} ({requirement.span.place})"
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
            where = f"{name}, provide ({provide.span.place})"
            yield ("provided", number, index), f"{where} gives its data"
            for outcome, text in _outcomes(condition):
                yield ("provide", number, index, *outcome), f"{where}: {text} alone decides"
            for piece, found in enumerate(self._pieces[number][index]):
                for way, text in enumerate(found.texts):
                    yield ("piece", number, index, piece, way), f"{where}: {text} decides its data"

    def _of_partner(self, step: ExactStep, partner: Partner) -> Iterator[tuple[Case, str]]:
        name = label(step.event)
        for location in partner.edges:
            for judged in self._edges[step.number, partner.component, location]:
                (line, target), assigned = judged.edge.name, judged.edge.assigned
                case = step.number, partner.component, line, target
                where = f"({line}{target and f', to {told_with_stage(target)}'})"
                told = f"{name} in {partner.component} {where}"
                if partner.component == step.event.key:
                    told = f"{name} as expected {where}"
                yield ("taken", *case), told
                for key, *_ in assigned:
                    yield ("assigned", *case, key), f"{told}, which changes {key}"
                for outcome, text in _outcomes(judged.guard):
                    yield ("edge", *case, *outcome), f"{told}: {text} alone decides"
                for key, condition in judged.made.items():
                    for outcome, text in _outcomes(condition):
                        yield ("made", *case, key, *outcome), f"{told}: {text} decides {key}"
                for index, ends in enumerate((judged.asked, *judged.read)):
                    for number, text in enumerate(ends.texts):
                        yield ("end", *case, index, number), f"{told}: {text}"

    # --- what is shown ---------------------------------------------------------------------------

    def of_state(self, state: State) -> set[Case]:
        """The cases of a state in which the controller waits."""
        violated = self.steps.violated(state)
        found: set[Case] = {("states", n, n not in violated) for n in self.steps.on_states}
        return found.union(*self._of_waiting(state))

    @cached_property
    def _of_waiting(self) -> Results[set[Case]]:
        """The cases of each command and of each internal transition where a controller waits."""
        steps, functions = self.steps, list[tuple[Callable[[State], set[Case]], Iterable[str]]]()
        for rule in self.rules:
            reads, number = self.reads(rule.step), rule.step.number
            is_told = steps.guards_others and not steps.follows
            if not steps.guards_others or (is_told and rule.step.event.kind is EventKind.CANCEL):
                functions.append((self._of_command[number], reads))
            if is_told and number not in self._by_data:
                functions.append((partial(self._told, rule), reads))
        functions += [(partial(self._edges_in, tau), tau.reads) for tau in steps.taus]
        return Results(functions)

    @cached_property
    def _of_command(self) -> Mapping[int, Callable[[State], set[Case]]]:
        """By command :meth:`of_command` of a state; an input leaves most commands as they were."""
        steps = [rule.step for rule in self.rules]
        return {
            s.number: remembering(partial(self.of_command, s), (*self.reads(s),)) for s in steps
        }

    def reads(self, step: ExactStep) -> frozenset[str]:
        """The keys of a state that decide whether an event can happen, and what alone decides."""
        rule = self.rules_by_number.get(step.number)
        if rule is None:
            return step.reads
        demanded = keys_read(demand.condition.expr for demand in rule.demands)
        return step.reads.union(demanded, *(other.reads for other in rule.preferred))

    def _edges_in(self, tau: ExactStep, state: State) -> set[Case]:
        return set(self._edges_of(tau, state, NOTHING))

    def _told(self, rule: CommandDemands, state: State) -> set[Case]:
        """Which demand alone is told beside what else is in the way of a command."""
        step = rule.step
        if step.in_phase(state) and not step.blocked_by(state, NOTHING):
            return set()
        outcomes = [demand.condition.deciding(state)[0] for demand in rule.demands]
        if outcomes.count(False) != 1:
            return set()
        return {("told", step.number, outcomes.index(False))}

    def _obstacles(
        self, step: ExactStep, state: State, carried: Carried, is_demanded: bool = True
    ) -> list[Obstacle]:
        """All that may stand in the way of a command, its demands if they count."""
        found, rule = [], self.rules_by_number[step.number]
        for partner in step.partners:
            if partner.blocking:
                name = partner.component
                told = f"blocked by {name} in {told_with_stage(state[partner.place])}"
                ways = {
                    value: [] if value else self._blocked(step, partner, state, carried)
                    for value in partner.may_take(state, carried)
                }
                found.append(Obstacle(ways, told if name in self._components else None))
        for other in rule.preferred:
            known = not isinstance(carried, Unknown)
            allowed = {other.allowed(state)} if known else {False, other.in_phase(state)}
            yields: list[Case] = [("yields", step.number, other.number)]
            found.append(Obstacle({not v: yields if v else [] for v in allowed}, ""))
        for index, demand in enumerate(rule.demands if is_demanded else ()):
            case = "demand", step.number, index
            values = demand.condition.possible(state, carried).items()
            ways = {v: [(*case, *one) for one in some] for v, some in values}
            is_guard = demand.requirement is None and step.event.kind.sent
            text = None if demand.requirement is None else demand.text
            found.append(Obstacle(ways, text, is_guard))
        return found

    def _blocked(
        self, step: ExactStep, partner: Partner, state: State, carried: Carried
    ) -> list[Case]:
        """The cases of a component that blocks a command, and of what alone keeps it from taking an
        edge."""
        found: list[Case] = [("blocked", step.number, partner.component)]
        for judged in self._edges_at(step, partner, state):
            case = "edge", step.number, partner.component, *judged.edge.name
            outcomes = judged.guard.possible(state, carried).get(False, ())
            found += ((*case, *outcome) for outcome in outcomes)
        return found

    def demanded(self, case: Case) -> bool | None:
        """Whether a demand holds where one of its atoms alone decides it; None: that depends."""
        _, number, index, atom, value, _ = case
        return self.rules_by_number[number].demands[index].condition.comes_to(atom, value)

    def of_command(
        self, step: ExactStep, state: State, carried: Carried | None = None
    ) -> set[Case]:
        """The cases of what alone decides whether a command may be sent; ``carried`` is what
        another controller sends."""
        if not step.in_phase(state):
            return set()
        try:
            carried = step.carried(state) if carried is None else carried
        except Undefined:
            return set()
        obstacles = self._obstacles(step, state, carried)
        closed = [one for one in obstacles if not one.may_pass]
        found: set[Case] = set()
        if len(closed) <= 1:
            found = {c for one in closed or obstacles for cases in one.ways.values() for c in cases}
        if obstacles and obstacles[-1].is_guard:
            guard = obstacles[-1]
            for one in obstacles[:-1]:
                if all(other in (one, guard) for other in closed):
                    found |= self._in_both(one, guard)
        is_alone = not any(case[0] in ("blocked", "yields") for case in found)
        if not isinstance(carried, Unknown) and is_alone and step.after(state, carried) is None:
            return set()
        return found

    def _in_both(self, requirement: Obstacle, guard: Obstacle) -> set[Case]:
        """The cases of what alone decides that both forbid a command: a guard says again what the
        requirements do."""

        def parts(obstacle: Obstacle) -> dict[Any, Case]:
            cases = (case for case in obstacle.ways.get(False, ()) if case[0] == "demand")
            return {(self._atom_of(case).text, *case[-2:]): case for case in cases}

        firsts, seconds = parts(requirement), parts(guard)
        return {c for key in firsts.keys() & seconds for c in (firsts[key], seconds[key])}

    def _atom_of(self, case: Case) -> Atom:
        """What decides in a case of a demand."""
        _, number, index, atom, *_ = case
        return self.rules_by_number[number].demands[index].condition.atoms[atom]

    def allows(self, step: ExactStep, state: State, carried: Carried) -> bool:
        """Whether a command of another controller may pass."""
        met = all(one.may_pass for one in self._obstacles(step, state, carried))
        guarded = step.guard is None or holds(step.guard, state, carried)
        return met and guarded and step.after(state, carried) is not None

    def reasons(
        self, step: ExactStep, state: State, carried: Carried | None = None
    ) -> tuple[str, ...] | None:
        """Why a command is not enabled, as a node tells it; None if that cannot be told."""
        if step.event.kind is EventKind.CANCEL:
            return None
        try:
            carried = step.carried(state) if carried is None else carried
        except Undefined:
            return None
        found = [] if step.in_phase(state) else [f"it is {state[step.phase or '']}"]
        # Where a guard need not ask for a requirement, since the phase does, nor does the node.
        allowed = step.guard is not None and holds(step.guard, state, carried)
        obstacles = self._obstacles(step, state, carried, is_demanded=not allowed)
        closed = [one for one in obstacles if not one.may_pass]
        is_blocked = found or step.blocked_by(state, carried)
        if not is_blocked and step.after(state, carried) is None:
            return None
        if found or any(one.told for one in closed):
            closed = [one for one in closed if not one.is_guard]
        if any(one.told is None for one in closed):
            return None
        found += dict.fromkeys(one.told for one in closed if one.told)
        return tuple(found) if found else None

    def possible(self, step: ExactStep, state: State, carried: Unknown = UNKNOWN) -> set[Case]:
        """The cases of an event that may show in a state of the plant, of which numbers are left
        out."""
        found: set[Case] = set()
        if step.number in self.rules_by_number:
            found |= self.of_command(step, state, carried)
            if step.replaces(state):
                found |= {("replaced", step.number, value) for value in (True, False)}
            may_pass = all(one.may_pass for one in self._obstacles(step, state, carried))
            if may_pass:
                found.add(("sent", step.number))
            if may_pass or self.steps.guards_others:  # a correction may be why it passes, or not
                found.update(self.data_of(step, state, carried))
        elif not step.event.controllable:
            found.add(("event", step.number, "" if step.phase is None else state[step.phase]))
        if step.guard is None or True in possible_values(step.guard, state, carried):
            found.update(self._edges_of(step, state, carried, {}))
        return found

    def of_step(self, step: ExactStep, state: State, carried: Carried, after: State) -> set[Case]:
        """The cases of an event that happens in a state."""
        found: set[Case] = {("at", step.number, p.component, state[p.place]) for p in step.partners}
        if not step.event.controllable:
            found.add(("event", step.number, "" if step.phase is None else state[step.phase]))
        elif step.event.kind is not EventKind.TAU:
            found.add(("sent", step.number))
            found |= {("replaced", step.number, True)} if step.replaces(state) else set()
            if self.steps.guards_others:
                found |= self.of_command(step, state, carried)
            else:
                found |= self._of_command[step.number](state)
                found.update(self.data_of(step, state, NOTHING))
        found.update(self._edges_of(step, state, carried, after))
        return found | self._stays(step, state, carried, after)

    def of_settled(self, state: State) -> tuple[State, set[Case]]:
        """Where all leads that a controller does by itself, and the cases that it shows."""
        found: set[Case] = set()
        for step, before, state in self.steps.settled(state):  # noqa: B020
            found |= self.of_step(step, before, step.carried(before), state)
        return state, found | self.of_state(state)

    def of_refusal(self, step: ExactStep, state: State, carried: Carried) -> set[Case]:
        """The cases of an answer that is not as expected."""
        own = (case for case in self._edges_of(step, state, carried) if case[2] == step.event.key)
        return {("refused", step.number, state[f"~{step.event.key}"]), *own}

    def of_refused_call(self, step: ExactStep, state: State, carried: Carried) -> set[Case]:
        """The cases of a call that no component takes."""
        number, found = step.number, self._stays(step, state, carried, state)
        found |= {("refused", number, p.component, state[p.place]) for p in step.partners}
        return found | {("refused", number, "idle"), *self._edges_of(step, state, carried)}

    def _edges_of(
        self, step: ExactStep, state: State, carried: Carried, after: State | None = None
    ) -> Iterator[Case]:
        """What decides which edges are taken; the state ``after`` it is empty, where it is not
        known, and None, where nothing happens."""
        for partner in step.partners:
            for judged in self._edges_at(step, partner, state):
                case = step.number, partner.component, *judged.edge.name
                values = judged.guard.possible(state, carried)
                yield from (("edge", *case, *one) for some in values.values() for one in some)
                asked = judged.asked.mattering(state, carried)
                yield from (("end", *case, 0, number) for number in asked)
                if True in values and after is not None:
                    yield "taken", *case
                    for key, value, *_ in judged.edge.assigned:
                        if _changes(state, after, key, value):
                            yield "assigned", *case, key
                    for key, condition in judged.made.items():
                        for outcomes in condition.possible(state, carried).values():
                            yield from (("made", *case, key, *one) for one in outcomes)
                    for index, ends in enumerate(judged.read, 1):
                        read = ends.mattering(state, carried)
                        yield from (("end", *case, index, number) for number in read)
                if False not in values:
                    break

    def _stays(self, step: ExactStep, state: State, carried: Carried, after: State) -> set[Case]:
        """Which edges of other locations are not taken, though their guards hold and internal
        transitions would not lead on to the same."""
        found: set[Case] = set()
        for partner in step.partners:
            for number, edge in self._open_elsewhere(step, partner, state, carried):
                if self._end(after) != self._end(after | {partner.place: edge.target}):
                    found.add(("stays", step.number, partner.component, number))
        return found

    def _open_elsewhere(
        self, step: ExactStep, partner: Partner, state: State, carried: Carried
    ) -> Iterator[tuple[int, ExactEdge]]:
        """The edges of an event, by number, that leave other locations, and whose guards hold."""
        here = {judged.edge.name for judged in self._edges_at(step, partner, state)}
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

    def _edges_at(self, step: ExactStep, partner: Partner, state: State) -> Sequence[JudgedEdge]:
        """The edges of an event that leave where a component is."""
        return self._edges.get((step.number, partner.component, state[partner.place]), ())

    def data_of(self, step: ExactStep, state: State, carried: Carried) -> Iterator[Case]:
        """The cases of what provides the data of a command, or corrects what it carries."""
        for index, (_, condition) in enumerate(self._provides[step.number]):
            values = condition.possible(state, carried)
            case = step.number, index
            yield from (("provide", *case, *one) for some in values.values() for one in some)
            if True in values:
                yield "provided", *case
                for piece, found in enumerate(self._pieces[step.number][index]):
                    ways = found.deciding(state, carried)
                    yield from (("piece", *case, piece, way) for way in ways)
            if False not in values:
                return

    def regions(self, step: ExactStep) -> dict[Any, list[Any]]:
        """The numbers, of the robot and of what an event carries, that what decides about it only
        compares with numbers that stand, each with a value of every kind that this tells apart."""
        edges = [j for key, some in self._edges.items() if key[0] == step.number for j in some]
        exprs = [expr for j in edges for expr in (j.guard.expr, *j.edge.made)]
        rule = self.rules_by_number.get(step.number)
        exprs += [] if rule is None else [demand.condition.expr for demand in rule.demands]
        for provide, condition in self._provides.get(step.number, ()):
            exprs += [condition.expr, *data_expressions(provide.data)]
        guard = self.steps.guards.get(step.event.identity)
        exprs += [] if guard is None else [exact(guard.expr)]
        return regions(exprs)

    @cached_property
    def atoms(self) -> Results[Any]:
        """The atoms over states alone; two states in which all agree are alike."""
        conditions = [d.condition for rule in self.rules for d in rule.demands]
        edges = [judged for several in self._edges.values() for judged in several]
        conditions += [judged.guard for judged in edges]
        conditions += [condition for judged in edges for condition in judged.made.values()]
        conditions += [c for found in self._provides.values() for _, c in found]
        # What another controller sends comes later, in a state that is like the first of its kind.
        guards = self.steps.guards_others

        def of(atom: Atom) -> Callable[[State], Any]:
            found: Function = atom.outcome if guards else atom.value

            def outcome(state: State) -> Any:
                try:
                    return found(state, NOTHING)
                except Undefined:
                    return None

            return outcome

        pieces = [p for several in self._pieces.values() for some in several for p in some]
        return Results(
            [
                *((of(atom), atom.reads) for c in conditions for atom in c.outer),
                *((partial(piece.deciding, carried=NOTHING), piece.reads) for piece in pieces),
            ]
        )


def through(step: ExactStep, before: State, after: State) -> set[Case]:
    """From where to where an event leads components, with all that follows at once; of a delay,
    also what it began with."""
    delayed = step.event.kind is EventKind.AFTER
    places = (
        (p.component, before[p.place], after[p.place], before[p.begun] if delayed else None)
        for p in step.partners
    )
    return {("through", step.number, *place) for place in places}


def _changes(state: State, after: State, key: str, value: Function) -> bool:
    """Whether a variable changes, or may do so."""
    try:
        return bool((after[key] if after else value(state, UNKNOWN)) != state[key])
    except (Undefined, KeyError):
        return True


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
    true = {
        "<=": ("at", "below"), "<": ("below",), ">=": ("at", "above"), ">": ("above",),
        "=": ("at",), "!=": ("below", "above"),
    }[atom.operator]  # fmt: skip
    return (near in true) is value
