"""The search for states in which cases are shown: a graph of inputs, bounded by its steps.

A node stands for all states that agree in locations, phases, finite variables and in the atoms of all
conditions; its own state is the first that was reached. An edge is one input, with all that the
controller does about it. What is found depends on nothing but the model.
"""

from __future__ import annotations

import heapq
from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from robosc.expr.types import domain
from robosc.language.events import EventKind, Kind
from robosc.plant.event_values import value_type
from robosc.runtime.values import Undefined
from robosc.traces.coverage import Case, Coverage
from robosc.traces.exact_steps import NOTHING, Carried, State, Step, Steps
from robosc.traces.samples import Sample, Samples

BUDGET = 8000
"""The most inputs that are tried."""
USUAL = 6
"""The most samples of an event that stand for the others."""

SILENT = Sample("", {}, NOTHING)
"""What time brings."""
Move: TypeAlias = tuple[Step, Sample]
"""An input: an event of the robot, or one that the passing of time causes."""


@dataclass(eq=False)
class Node:
    """A class of states; ``edges`` are empty until it is expanded."""

    state: State
    kind: tuple[Any, ...]
    number: int
    edges: list[tuple[Move, Node, frozenset[Case]]] = field(default_factory=list)
    is_expanded: bool = False


class Search:
    """The graph as far as it is known."""

    def __init__(self, steps: Steps, coverage: Coverage, samples: Samples) -> None:
        self.steps = steps
        self.coverage = coverage
        self.seen: set[Case] = set()
        """All cases that some edge shows."""
        self.aimed: frozenset[Case] = frozenset()
        """The cases that the last path leads to."""
        self.tried = 0
        self._nodes: dict[Any, Node] = {}
        self._expanded: Counter[Any] = Counter()
        self._waiting: list[tuple[int, int, Node]] = []
        self._usual: dict[int, list[Sample]] = {}
        self._promising: deque[tuple[Node, Step]] = deque()
        self._refined: set[tuple[int, int]] = set()
        near: dict[Case, set[Case]] = {}
        for case in coverage.cases:
            if case[0] in ("demand", "edge", "provide") and case[-1]:
                for value in (True, False):
                    near.setdefault((*case[:-2], value, ""), set()).add(case)
        self._near = {case: frozenset(others) for case, others in near.items()}
        robot = steps.robot
        self._atoms = list({id(a): a for a in coverage.atoms()}.values())
        self._finite = [k for k, v in robot.variables.items() if domain(v.type) is not None]
        self._places = [c.name for c in robot.components if c.behaviour is not None]
        calls = (Kind.OUTGOING, Kind.INCOMING)
        phases = {f"~{k}": c.kind in calls for k, c in robot.communications.items()}
        self._calls = [p for p, is_message in phases.items() if p in steps.initial and not is_message]
        self._messages = [p for p, is_message in phases.items() if p in steps.initial and is_message]
        self._inputs: list[tuple[Step, list[Sample]]] = [
            (s, [SILENT] if s.event.kind.clocked else samples.of(s.event))
            for s in steps.steps
            if not s.event.controllable
        ]
        state = steps.initial
        for step, before, after in steps.settled(state):
            self.seen |= coverage.of_step(step, before, step.carried(before), after)
            state = after
        self.seen |= coverage.of_state(state)
        self.start = self.node(state)

    def node(self, state: State) -> Node:
        kind, key = self._key(state)
        found = self._nodes.get(key)
        if found is None:
            found = self._nodes[key] = Node(state, kind, len(self._nodes))
            heapq.heappush(self._waiting, (self._expanded[kind], found.number, found))
        return found

    def _key(self, state: State) -> tuple[Any, Any]:
        kind = (*(state.get(n) for n in self._places), *(state[p] for p in self._calls))
        atoms = []
        for atom in self._atoms:
            try:
                atoms.append(atom(state, NOTHING))
            except Undefined:
                atoms.append(None)
        rest = (*(state[p] for p in self._messages), *(repr(state[k]) for k in self._finite))
        return kind, (kind, rest, tuple(atoms))

    def explore(self, budget: int = BUDGET) -> None:
        """Expand nodes until all cases are seen, or the budget is spent."""
        wanted = self.coverage.cases.keys()
        self.expand(self.start)
        while self.tried < budget and not wanted <= self.seen:
            if self._promising:
                self._refine(*self._promising.popleft())
            elif self._waiting:
                times, number, node = heapq.heappop(self._waiting)
                if self._expanded[node.kind] > times:
                    heapq.heappush(self._waiting, (self._expanded[node.kind], number, node))
                else:
                    self.expand(node)
            else:
                break

    def expand(self, node: Node) -> None:
        """Try the inputs of a node: of the start all samples, elsewhere those that stand for
        others."""
        if node.is_expanded:
            return
        node.is_expanded = True
        self._expanded[node.kind] += 1
        for step, samples in self._inputs:
            if not step.in_phase(node.state):
                continue
            before = len(node.edges)
            tried = self._usual.get(step.number)
            self._try(node, step, samples if tried is None else tried)
            if tried is None:
                chosen = [move[1] for move, _, _ in node.edges[before:]]
                self._usual[step.number] = list(dict.fromkeys([*samples[:2], *chosen]))[:USUAL]

    def _refine(self, node: Node, step: Step) -> None:
        """Try all samples of an event where one of them has shown that a number decides."""
        if (node.number, step.number) not in self._refined:
            self._refined.add((node.number, step.number))
            self._try(node, step, next(all_ for one, all_ in self._inputs if one is step))

    def _try(self, node: Node, step: Step, samples: list[Sample]) -> None:
        known = {(m[0].number, t.number, c) for m, t, c in node.edges}
        for sample in samples:
            self.tried += 1
            found = self.taken(node.state, step, sample)
            if found is None:
                continue
            state, cases = found
            target = self.node(state)
            sort = step.number, target.number, cases
            if sort in known:
                continue
            known.add(sort)
            node.edges.append(((step, sample), target, cases))
            new = cases - self.seen
            self.seen |= cases
            if any(self._near.get(case, frozenset()) - self.seen for case in new):
                self._promising.append((node, step))

    def taken(self, state: State, step: Step, sample: Sample) -> tuple[State, frozenset[Case]] | None:
        """The state after an input and all that follows, and the cases that it shows; None if it is
        not possible, or if fields of 32 bits make a difference."""
        after = step.after(state, sample.parts)
        if after is None:
            return None
        if sample.rounded is not None:
            other = step.after(state, sample.rounded)
            if other is None or self._key(other)[1] != self._key(after)[1]:
                return None
        cases = self.coverage.of_step(step, state, sample.parts, after)
        state = after
        for taken, before, after in self.steps.settled(state):
            cases |= self.coverage.of_step(taken, before, taken.carried(before), after)
            state = after
        cases |= self.coverage.of_state(state)
        return state, frozenset(cases)

    def path(self, start: Node, wanted: set[Case]) -> list[Move] | None:
        """The shortest known way to an edge that shows wanted cases, the most of those at the same
        distance; None if there is none."""
        came: dict[int, tuple[Node, Move] | None] = {start.number: None}
        queue = deque([(start, 0)])
        best: tuple[int, Node, Move] | None = None
        self.aimed = frozenset()
        reach = None
        while queue:
            node, depth = queue.popleft()
            if reach is not None and depth > reach:
                break
            for move, target, cases in node.edges:
                count = len(cases & wanted)
                if count and (best is None or count > best[0]):
                    best, reach, self.aimed = (count, node, move), depth, cases & frozenset(wanted)
                if target.number not in came:
                    came[target.number] = node, move
                    queue.append((target, depth + 1))
        if best is None:
            return None
        moves = [best[2]]
        step = came[best[1].number]
        while step is not None:
            node, move = step
            moves.append(move)
            step = came[node.number]
        return moves[::-1]


_ = (Callable, Iterator, EventKind, value_type, Carried)
