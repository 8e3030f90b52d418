"""Specifications of CIF 3 as transition systems: what data-based synthesis knows of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from typing import Any

State = tuple[tuple[str, Any], ...]
Expression = Callable[[dict[str, Any]], Any]


class CifError(Exception):
    """The specification is not valid CIF."""


@dataclass
class Edge:
    event: str
    guard: Expression
    updates: list[tuple[str, Expression]]
    target: str


@dataclass
class Automaton:
    kind: str
    name: str
    initial: str = ""
    marked: set[str] = field(default_factory=set)
    edges: dict[str, list[Edge]] = field(default_factory=dict)

    @property
    def alphabet(self) -> set[str]:
        return {edge.event for edges in self.edges.values() for edge in edges}


@dataclass
class Specification:
    controllable: dict[str, bool] = field(default_factory=dict)
    automata: list[Automaton] = field(default_factory=list)
    variables: dict[str, tuple[list[Any], Callable[[Any], bool]]] = field(default_factory=dict)
    state_invariants: list[Expression] = field(default_factory=list)
    event_invariants: list[tuple[str, Expression]] = field(default_factory=list)

    @property
    def initials(self) -> list[State]:
        """All initial states, that of the values that stand first at the beginning."""
        places = {a.name: a.initial for a in self.automata}
        starts = product(*(values for values, _ in self.variables.values()))
        return [
            tuple((places | dict(zip(self.variables, values, strict=True))).items())
            for values in starts
        ]

    @property
    def initial(self) -> State:
        return self.initials[0]

    def steps(self, state: State, supervised: bool) -> dict[str, State]:
        """What can happen in the plant automata, or with the supervisor's."""
        here = dict(state)
        view = {**here, **{f"{a.name}.{loc}": here[a.name] == loc for a in self.automata
                           for loc in a.edges}}  # fmt: skip
        automata = [a for a in self.automata if a.kind == "plant" or supervised]
        found = {}
        for event in self.controllable:
            partners = [a for a in automata if event in a.alphabet]
            choices = [
                [e for e in a.edges[here[a.name]] if e.event == event and e.guard(view)]
                for a in partners
            ]
            if not partners or not all(choices):
                continue
            if any(len(choice) > 1 for choice in choices):
                raise CifError(f"{event} is not deterministic in {state}")
            after = dict(here)
            for automaton, (edge,) in zip(partners, choices, strict=True):
                after[automaton.name] = edge.target
                for variable, value in edge.updates:
                    after[variable] = value(view)
                    if not self.variables[variable][1](after[variable]):
                        raise CifError(f"{event} takes {variable} out of its range in {state}")
            found[event] = tuple(after.items())
        return found

    def view(self, state: State) -> dict[str, Any]:
        here = dict(state)
        places = {f"{a.name}.{loc}": here[a.name] == loc for a in self.automata for loc in a.edges}
        return here | places

    def is_marked(self, state: State) -> bool:
        here = dict(state)
        return all(here[a.name] in a.marked for a in self.automata)

    def permits(self, state: State, event: str) -> bool:
        view = self.view(state)
        return all(holds(view) for name, holds in self.event_invariants if name == event)

    def is_safe(self, state: State) -> bool:
        view = self.view(state)
        return all(holds(view) for holds in self.state_invariants)

    def graph(self, supervised: bool = False) -> dict[State, dict[str, State]]:
        """Everything reachable."""
        found = {initial: self.steps(initial, supervised) for initial in self.initials}
        queue = deque(found)
        while queue:
            for target in found[queue.popleft()].values():
                if target not in found:
                    found[target] = self.steps(target, supervised)
                    queue.append(target)
        return found

    def synthesized(self) -> dict[State, dict[str, State]]:
        """What data-based synthesis leaves of the plant; nothing if it fails."""
        plant = self.graph()
        permitted = {
            state: {e: t for e, t in steps.items() if self.permits(state, e)}
            for state, steps in plant.items()
        }
        keep = {state for state in plant if self.is_safe(state)}
        while True:
            stays = {
                state
                for state in keep
                if all(t in keep for e, t in plant[state].items() if not self.controllable[e])
            }
            reaching = {state for state in stays if self.is_marked(state)}
            before = -1
            while before != len(reaching):
                before = len(reaching)
                reaching |= {s for s in stays if reaching & set(permitted[s].values())}
            if reaching == keep:
                break
            keep = reaching
        if not keep.issuperset(self.initials):
            return {}
        found: dict[State, dict[str, State]] = {}
        queue = deque(self.initials)
        while queue:
            state = queue.popleft()
            if state not in found:
                found[state] = {e: t for e, t in permitted[state].items() if t in keep}
                queue.extend(found[state].values())
        return found
