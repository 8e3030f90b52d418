"""The search for states in which cases are shown: a graph of inputs, bounded by its steps.

A node stands for all states that agree in locations, phases, finite variables and in the atoms of
all conditions; its own state is the first that was reached. An edge is one input, with all that the
controller does about it. What is found depends on nothing but the model.
"""

from __future__ import annotations

import heapq
import math
from collections import Counter, deque
from collections.abc import Collection, Iterator, Set
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import combinations, islice
from typing import Any, TypeAlias

from robosc import dotted
from robosc.emit.supervisor.meant_messages import is_meant, meanings
from robosc.expr.traversal import walk
from robosc.expr.tree import VariableRef
from robosc.expr.types import IntegerType, domain
from robosc.language.events import EventKind, Kind
from robosc.runtime.core.values import Undefined
from robosc.traces.attempts import attempted
from robosc.traces.coverage import Case, CommandDemands, Coverage, through
from robosc.traces.exact_steps import (
    LATE,
    NOTHING,
    Carried,
    ExactStep,
    Results,
    State,
    Steps,
    refused,
)
from robosc.traces.samples import Sample, Samples

BUDGET, LEAST = 30000, 60
"""The most inputs that are tried, and the least, however large a model is."""
PATIENCE, SHORT = 5000, 500
"""So many inputs are tried after three times those that it took to show the last that is new: where
cases are left, and where none is, since what is no case may find a fault, too."""
LARGE = 800
"""So many cases a model may have before less is tried: more cases take longer for each input."""
USUAL, TRIES = 8, 80
"""So many samples of an event are tried in each node, and more where there are few events; the
most are tried where its components are for the first time."""

CONVERTED = 16
"""So many samples are tried where enums convert them."""

COUNTED = 6
"""So far states differ in what a model counts."""

AROUND = 5
"""So many nodes are expanded where a run knows no way on: to begin anew takes a node of ROS more
time."""

FAILURES = 2
"""An edge that has led elsewhere so often is no way any more."""

SILENT = Sample("", {}, NOTHING)
"""What time brings."""
Move: TypeAlias = tuple[ExactStep, Sample]
"""An input: an event of the robot, or one that the passing of time causes."""


@dataclass(eq=False)
class Node:
    """A class of states; ``edges`` are empty until it is expanded."""

    state: State
    kinds: tuple[Collection[Any], ...]
    """Where it is, without and with its finite variables, how each component is, and what stands in
    the way of each command."""
    number: int
    came: tuple[Node, ExactStep, Sample] | None = None
    """The node from which it was reached first, and by which input; None: it is the start."""
    edges: dict[Any, Edge] = field(default_factory=dict)
    is_expanded: bool = False


class InputGraph:
    """The graph as far as it is known."""

    def __init__(
        self, steps: Steps, coverage: Coverage, samples: Samples, possible: Set[Case]
    ) -> None:
        self.steps = steps
        self.coverage = coverage
        self._possible = possible
        """Those that are searched for; the others nothing can show."""
        self._by_case = {
            ("sent", s.number): s for s in steps.commands if ("sent", s.number) in possible
        }
        self.tried = 0
        self._last = 0
        """The number of the input that has shown the last case."""
        self.failures: Counter[int] = Counter()
        """How often an edge has led elsewhere, since it stands for a class of states."""
        self._budget = scaled(BUDGET, coverage)
        self._tries = max(USUAL, min(TRIES, self._budget // 10))
        self._nodes: dict[Any, Node] = {}
        self._expanded: Counter[Any] = Counter()
        self._waiting: tuple[list[tuple[int, int, Node]], ...] = [], [], [], []
        """The nodes to be expanded, by each of their kinds: those first of whose kind fewer were.
        A model may have few places and count a lot, or many places; and what one component of many
        does late comes soon where each is seen as it has not been (width 1 of Lipovetzky & Geffner,
        ECAI 2012), as does what needs much at once where what stands in its way is new."""
        self._turn = 0
        self._places_tried: set[Any] = set()
        self._converted: dict[Case, Sample] = {}
        """By the case that it shows, what an enum makes something else of."""
        self._promising: deque[tuple[Node, ExactStep, Sample]] = deque()
        near: dict[Case, set[Case]] = {}
        for case in coverage.cases:
            if case[0] in ("demand", "edge", "made", "provide") and case[-1]:
                for value in (True, False):
                    near.setdefault((*case[:-2], value, ""), set()).add(case)
        self._near = {case: frozenset(others) for case, others in near.items()}
        self._refined: set[tuple[Case, int]] = set()
        """Those near which an event was tried."""
        robot = steps.robot
        self._finite = [k for k, v in robot.variables.items() if domain(v.type) is not None]
        self._infinite = [k for k in robot.variables if k not in self._finite]
        self._correcting = [k for k in steps.correcting() if k in self._infinite]
        self._begun = [p for p in steps.initial if p.startswith("@")]
        self._counters = [k for k in dict.fromkeys(_counters(steps)) if k not in self._finite]
        self._places = [c.name for c in robot.components if c.states]
        calls = (Kind.OUTGOING, Kind.INCOMING)
        phases = {f"~{k}": c.kind in calls for k, c in robot.communications.items()}
        self._calls = [
            p for p, is_message in phases.items() if p in steps.initial and not is_message
        ]
        self._messages = [
            p for p, is_message in phases.items() if p in steps.initial and is_message
        ]
        self._samples = samples
        self._meant = meanings(steps.robot, not steps.follows) if steps.guards_others else {}
        robots = steps.inputs
        self._inputs = [(s, self._distinct(s)) for s in robots]
        read = [s for s in robots if s.event.controllable and steps.reads_data(s)]
        usual, attempts = (max(USUAL, TRIES // max(1, len(found))) for found in (robots, read))
        self._most = {s.number: usual for s in robots}
        self._most |= {s.number: attempts if s in read else 1 for s in steps.commands}
        state, self.seen = coverage.of_settled(steps.initial)
        self.start = self.node(state)

    def node(self, state: State) -> Node:
        kind, key = self._key(state)
        found = self._nodes.get(key)
        if found is None:
            kinds = [kind], [key[0]], [*self._components(state)], [*self._obstacles(state)]
            found = self._nodes[key] = Node(state, kinds, len(self._nodes))
            for turn, waiting in enumerate(self._waiting):
                heapq.heappush(waiting, (self._times(found, turn), found.number, found))
        return found

    def _times(self, node: Node, turn: int) -> int:
        """How often nodes of its kind were expanded."""
        return min((self._expanded[kind] for kind in node.kinds[turn]), default=0)

    def _key(self, state: State) -> tuple[Any, Any]:
        finite = tuple(repr(state[k]) for k in self._finite)
        kind = (*(state.get(n) for n in self._places), *(state[p] for p in self._calls))
        rest = (
            *(state[p] for p in self._messages),
            *(repr(state[k]) for k in self._correcting),
            *(state[p] for p in self._begun),
            *(max(-COUNTED, min(COUNTED, state[k] or 0)) for k in self._counters),
        )
        return kind, ((kind, finite), rest, tuple(self.coverage.atoms(state)))

    def explore(self) -> None:
        """Expand nodes while they show something new and the budget lasts; for commands that are
        not seen then, spend it once more."""
        self.expand(self.start)
        while self.tried < self._patience():
            if self._promising:
                self._refine(*self._promising.popleft())
            elif not self._expand_next():
                break
        if self._unseen():
            self._explore_pairs()

    def _patience(self) -> int:
        """The number of inputs after which it is unlikely that another one shows anything new."""
        least = SHORT if self._possible <= self.seen else PATIENCE
        return min(self._budget, least + 3 * self._last)

    def _explore_pairs(self) -> None:
        """Expand, in the order in which they were found, the nodes in which two components are as
        they have not been together. What many components do together is too much."""
        most = self.tried + self._budget
        met: set[Any] = set()
        nodes = list(self._nodes.values())
        for node in nodes:
            pairs = set(combinations(node.kinds[2], 2))
            if pairs <= met:
                continue
            met |= pairs
            known = len(self._nodes)
            self.expand(node)
            nodes += islice(self._nodes.values(), known, None)
            if self.tried > most or not self._unseen():
                break

    @cached_property
    def _components(self) -> Results[tuple[str, str]]:
        """How each component is, with its calls and messages."""
        found: dict[str, list[str]] = {}
        for key in (*self._places, *self._calls, *self._messages, *self._finite):
            found.setdefault(dotted.first(key.lstrip("~")), []).append(key)

        def how(name: str, keys: list[str], state: State) -> tuple[str, str]:
            return name, repr([state[key] for key in keys])

        return Results((partial(how, name, keys), keys) for name, keys in found.items())

    @cached_property
    def _obstacles(self) -> Results[Any]:
        """What stands in the way of each command, where its components are."""

        def obstacles(rule: CommandDemands, state: State) -> Any:
            places = (state[partner.place] for partner in rule.step.partners)
            met = (True in demand.condition.possible(state) for demand in rule.demands)
            return rule.step.number, *places, *met

        rules = [rule for rule in self.coverage.rules if len(rule.demands) > 1]
        return Results((partial(obstacles, rule), self.coverage.reads(rule.step)) for rule in rules)

    def _expand_next(self) -> bool:
        """Expand a node, in turn by each kind; False: there is none."""
        self._turn = (self._turn + 1) % len(self._waiting)
        waiting = self._waiting[self._turn]
        while waiting:
            times, number, node = heapq.heappop(waiting)
            expanded = self._times(node, self._turn)
            if node.is_expanded:
                continue
            if expanded <= times:
                self.expand(node)
                return True
            heapq.heappush(waiting, (expanded, number, node))
        return False

    def _distinct(self, step: ExactStep) -> list[Sample]:
        """The samples of an event that differ in what they do, wherever its components are."""
        if self.steps.comes_by_time(step):
            return [SILENT if step.event.kind.clocked else Sample("", {}, LATE)]
        if step.event.controllable:
            key = step.event.key
            samples = [s for s in self._samples.of(step.event) if is_meant(self._meant, key, s.raw)]
            return samples[:TRIES]
        states = self._places_of(step)
        found: dict[Any, list[tuple[Sample, list[State | None]]]] = {}
        for sample in self._samples.of(step.event):
            ends = [step.after(state, sample.parts) for state in states]
            keys = tuple(self._shown(step, s, sample, e) for s, e in zip(states, ends, strict=True))
            alike = found.setdefault(keys, [(sample, ends)])
            if len(alike) == 1 and self._differ(alike[0][1], ends):
                alike.append((sample, ends))
        firsts = [alike[0][0] for alike in found.values()]
        converted = {value_of(step, one): one for one in reversed(firsts) if one.converted}
        most = len(converted) + CONVERTED
        for sample in self._samples.of(step.event):
            if sample.converted and len(converted) < most:
                converted.setdefault(value_of(step, sample), sample)
        firsts += converted.values()
        self._converted |= converted
        seconds = [sample for alike in found.values() for sample, _ in alike[1:]]
        return list(dict.fromkeys([*firsts, *seconds]))

    def _shown(self, step: ExactStep, state: State, sample: Sample, end: State | None) -> Any:
        """What a sample does in a state."""
        if end is not None:
            return self._key(end)[1], frozenset(
                self.coverage.of_step(step, state, sample.parts, end)
            )
        if self.steps.refuses(step, state):
            return frozenset(self.coverage.of_refused_call(step, state, sample.parts))
        if self.steps.refusal_of(step) is None:
            return None
        return frozenset(self.coverage.of_refusal(step, state, sample.parts))

    def _differ(self, ends: list[State | None], others: list[State | None]) -> bool:
        """Whether all that decides nothing has become something else, where it was assigned."""
        pairs = [(a, b) for a, b in zip(ends, others, strict=True) if a and b]
        return all(
            a[key] != b[key] or a[key] == self.steps.initial[key] == b[key]
            for a, b in pairs
            for key in self._infinite
        ) and any(a != b for a, b in pairs)

    def _places_of(self, step: ExactStep) -> list[State]:
        """States in which each component is at each place that it leaves with an event."""
        start = dict(self.steps.initial)
        if step.phase is not None and step.sources:
            start[step.phase] = step.sources[0]
        leaving = [(p.place, list(p.edges)) for p in step.partners if p.edges]
        count = max((len(places) for _, places in leaving), default=1)
        states = [
            start | {place: places[n % len(places)] for place, places in leaving}
            for n in range(count)
        ]
        states += [state | dict.fromkeys(self._messages, "fresh") for state in states]
        beside = self._samples.beside(step.event).items()
        return states + [s | {key: v} for key, values in beside for v in values for s in states]

    def expand(self, node: Node) -> None:
        """Try the inputs of a node."""
        if node.is_expanded or self.tried > 3 * self._budget:
            return
        node.is_expanded = True
        self._expanded.update(kind for several in node.kinds for kind in several)
        for step, samples in self._inputs:
            if step.event.kind.sent or step.in_phase(node.state):
                places = step.number, tuple(node.state[p.place] for p in step.partners)
                usual = self._tries if places not in self._places_tried else self._most[step.number]
                self._try(node, step, samples[:usual])
                self._places_tried.add(places)

    def expand_around(self, node: Node) -> None:
        """Expand the nodes next to one, so that there are more ways on."""
        queue, known, left = deque([node]), {node.number}, AROUND
        while queue and left:
            near = queue.popleft()
            left -= not near.is_expanded
            self.expand(near)
            ahead = {edge[1].number: edge[1] for edge in near.edges.values()}
            queue += [one for number, one in ahead.items() if number not in known]
            known |= ahead.keys()

    def convert(self, node: Node, wanted: set[Case]) -> None:
        """Try at a node the values whose conversion is wanted."""
        for step, _ in self._inputs:
            found = self._converted.items()
            mine = [sample for case, sample in found if case in wanted and case[1] == step.number]
            if mine and step.in_phase(node.state):
                self._try(node, step, mine)

    def _refine(self, node: Node, step: ExactStep, sample: Sample) -> None:
        """Try what differs little from a sample that has shown that a number decides."""
        self._try(node, step, self._samples.around(step.event, sample))

    def _set_by(self, node: Node) -> Iterator[tuple[Node, ExactStep, Sample]]:
        """The last input on the way to a node that has changed a number; nothing, if none has."""
        came = node.came
        while came is not None:
            if any(came[0].state[key] != node.state[key] for key in self._infinite):
                yield came
                return
            came = came[0].came

    def _try(self, node: Node, step: ExactStep, samples: list[Sample]) -> None:
        pending: list[tuple[Sample, ExactStep | None]] = [(sample, None) for sample in samples]
        for sample, first in pending:
            self.tried += 1
            found = self.taken(node.state, step, sample, first)
            if found is None:
                continue
            state, cases = found
            # Commands take turns: the one that was sent goes behind all others.
            pending += [(sample, other) for other in self._passed_over] if first is None else []
            known = len(self._nodes)
            target = self.node(state)
            if len(self._nodes) > known:  # else the way to it may have begun where a run was
                target.came = node, step, sample
            sort = step.number, target.number, cases
            if sort in node.edges:
                continue
            node.edges[sort] = (step, sample), target, cases
            new = cases - self.seen
            if new:
                self._last = self.tried
            self.seen |= cases
            decided = {(case, step.number) for case in cases & self._near.keys()} - self._refined
            if any(self._near[case] - self.seen for case, _ in decided):
                self._refined |= decided
                self._promising.append((node, step, sample))
                self._promising += self._set_by(node)

    def taken(
        self, state: State, step: ExactStep, sample: Sample, first: ExactStep | None = None
    ) -> tuple[State, frozenset[Case]] | None:
        """The state after an input and all that follows, and the cases that it shows; None if it is
        not possible, or if fields of 32 bits make a difference. ``first`` is the command whose turn
        it is."""
        cases: set[Case] = set()
        self._passed_over: list[ExactStep] = []
        parts, rounded, begun = sample.parts, sample.rounded, state
        if step.event.controllable:
            return self._attempted(state, step, parts)
        if sample.rejects and state[f"~{step.event.key}"] == "cancelling":
            return None
        after = step.after(state, parts)
        if after is None and self.steps.refuses(step, state):
            return state, frozenset(self.coverage.of_refused_call(step, state, parts))
        if after is None and (refusal := self.steps.refusal_of(step)) is not None:
            cases |= self.coverage.of_refusal(step, state, parts)
            step, parts = refusal, refused(parts)
            rounded = None if rounded is None else refused(rounded)
            after = step.after(state, parts)
        if after is None:
            return None
        if rounded is not None:
            near = step.after(state, rounded)
            if near is None or self._key(near)[1] != self._key(after)[1]:
                return None
            if not self._sends_the_same(near, after):
                return None
        cases |= self.coverage.of_step(step, state, parts, after)
        for event, others in sample.also:
            other = self.steps.by_event[event.identity]
            before, then = after, other.after(after, others)
            if then is not None:
                after = then
                cases |= self.coverage.of_step(other, before, others, after)
        cases |= {value_of(step, sample)} & self._converted.keys()
        state = after
        unseen = [self._by_case[case] for case in self._unseen()]
        for taken, before, after in self.steps.settled(state, first):
            cases |= self.coverage.of_step(taken, before, taken.carried(before), after)
            state = after
            if taken.event.kind is not EventKind.TAU:
                self._passed_over += [
                    s for s in unseen if s is not taken and self.steps.enabled(s, before)
                ]
        cases |= self.coverage.of_state(state) | through(step, begun, state)
        self._passed_over = [s for s in self._passed_over if ("sent", s.number) not in cases]
        return state, frozenset(cases)

    def _sends_the_same(self, near: State, state: State) -> bool:
        """Whether commands carry the same data in two states, as exactly as it is looked at."""
        others = {key for key, value in state.items() if near[key] != value}
        read = (c for c in self.steps.commands if not others.isdisjoint(c.read_by_data))
        return all(_alike(_sent(command, near), _sent(command, state)) for command in read)

    def _unseen(self) -> list[Case]:
        """The commands that are not sent yet."""
        return [case for case in self._by_case if case not in self.seen]

    def _attempted(
        self, state: State, step: ExactStep, sent: Carried
    ) -> tuple[State, frozenset[Case]] | None:
        """The same for a command of another controller; None if it is no attempt worth showing."""
        attempt = attempted(self.steps, self.coverage, step, state, sent)
        if attempt is None:
            return None
        after, cases = self.coverage.of_settled(attempt.after)
        return after, frozenset(cases | attempt.cases)

    def path(self, start: Node, wanted: set[Case]) -> list[Edge] | None:
        """The shortest known way to an edge that shows wanted cases, the most of those at the same
        distance; None if there is none."""
        came: dict[int, tuple[Node, Edge] | None] = {start.number: None}
        queue = deque([(start, 0)])
        best: tuple[int, Node, Edge] | None = None
        reach = None
        while queue:
            node, depth = queue.popleft()
            if reach is not None and depth > reach:
                break
            for edge in node.edges.values():
                if self.failures.get(id(edge), 0) >= FAILURES:
                    continue
                count = 0 if wanted.isdisjoint(edge[2]) else len(wanted & edge[2])
                if count and (best is None or count > best[0]):
                    best, reach = (count, node, edge), depth
                if edge[1].number not in came:
                    came[edge[1].number] = node, edge
                    queue.append((edge[1], depth + 1))
        if best is None:
            return None
        edges = [best[2]]
        step = came[best[1].number]
        while step is not None:
            node, edge = step
            edges.append(edge)
            step = came[node.number]
        return edges[::-1]


def value_of(step: ExactStep, sample: Sample) -> Case:
    """The case that an event carries what enums make something else of."""
    return "value", step.number, sample.converted


def scaled(most: int, coverage: Coverage) -> int:
    """The number of inputs that takes no longer with the cases of a large model."""
    return max(LEAST, int(most * min(1.0, LARGE / len(coverage.cases or "1"))))


def _counters(steps: Steps) -> Iterator[str]:
    """The integer variables that are assigned from themselves."""
    for event in steps.plant.events:
        for automaton in event.automata:
            for edge in automaton.edges:
                for assignment in edge.assignments:
                    key = f"{automaton.component}.{assignment.variable}"
                    reads = (p.key for p in walk(assignment.value) if isinstance(p, VariableRef))
                    if key in reads and isinstance(steps.robot.variables[key].type, IntegerType):
                        yield key


Edge: TypeAlias = tuple[Move, Node, frozenset[Case]]
"""An input, the node that it leads to, and the cases that are shown on the way."""


def _sent(command: ExactStep, state: State) -> Any:
    """The data of a command; None if there are none."""
    try:
        return command.provided(state)[1]
    except Undefined:
        return None


def _alike(one: Any, other: Any) -> bool:
    """Whether data are the same to the player of a package, which allows twice as much."""
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=5e-7, abs_tol=5e-7) or one != one != other != other
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_alike(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_alike, one, other))
    return bool(one == other)
