"""A small reader of CIF 3, after the language reference: enough to run what robosc writes.

It knows what data-based synthesis knows of CIF: automata with discrete variables, enumerations,
events, edges with guards and updates, invariants. It is strict where the tools are: undeclared or
doubly declared names, kinds of events and values outside a range are errors.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from typing import Any

State = tuple[tuple[str, Any], ...]
Expression = Callable[[dict[str, Any]], Any]

_TOKEN = re.compile(
    r"\s+|//[^\n]*|(\$?[A-Za-z_]\w*(?:\.\$?[A-Za-z_]\w*)*|\d+|:=|=>|!=|<=|>=|\.\.|[=<>+\-*:;,(){}\[\]])"
)
_WORDS = (
    "alphabet and automaton bool controllable disables disc do edge elif else end enum false goto if"
    " in initial int invariant location marked needs not or plant requirement supervisor true uncontrollable"
    " when"
)
_KEYWORDS = set(_WORDS.split())


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


class Reader:
    """Recursive descent over the tokens of one specification."""

    def __init__(self, text: str) -> None:
        self.tokens: list[str] = []
        position = 0
        while position < len(text):
            match = _TOKEN.match(text, position)
            if match is None:
                raise CifError(f"unreadable: {text[position : position + 20]!r}")
            if match.group(1):
                self.tokens.append(match.group(1))
            position = match.end()
        self.tokens.append("")
        self.place = 0
        self.specification = Specification()
        self.enums: dict[str, list[str]] = {}
        self.literals: set[str] = set()
        self.declared: set[str] = set()
        self.references: list[str] = []

    # --- tokens

    @property
    def next(self) -> str:
        return self.tokens[self.place]

    def take(self, *expected: str) -> str:
        token = self.next
        if expected and token not in expected:
            around = " ".join(self.tokens[max(0, self.place - 8) : self.place + 3])
            raise CifError(f"expected {expected}, found {token!r} in: {around}")
        self.place += 1
        return token

    def found(self, token: str) -> bool:
        if self.next == token:
            self.place += 1
            return True
        return False

    def name(self) -> str:
        token = self.take()
        parts = token.split(".")
        if not all(re.fullmatch(r"\$?[A-Za-z_]\w*", part) for part in parts):
            raise CifError(f"{token!r} is no name")
        if any(part in _KEYWORDS for part in parts):
            raise CifError(f"{token!r} is a keyword")
        return token.replace("$", "")

    def declare(self, name: str) -> str:
        if name in self.declared:
            raise CifError(f"{name} is declared twice")
        self.declared.add(name)
        return name

    # --- declarations

    def read(self) -> Specification:
        while self.next:
            match self.take():
                case "enum":
                    self.enum()
                case "controllable" | "uncontrollable" as word:
                    name = self.declare(self.name())
                    if not name.startswith("c_" if word == "controllable" else "u_"):
                        raise CifError(f"{name} is {word}")
                    self.specification.controllable[name] = word == "controllable"
                    self.take(";")
                case "plant" | "supervisor" as kind:
                    self.automaton(kind)
                case "requirement":
                    self.take("invariant")
                    self.invariant()
                case token:
                    raise CifError(f"unexpected {token!r}")
        for reference in self.references:
            if reference not in self.declared:
                raise CifError(f"{reference} is not declared")
        return self.specification

    def enum(self) -> None:
        name = self.declare(self.name())
        self.take("=")
        literals = [self.declare(self.name())]
        while self.found(","):
            literals.append(self.declare(self.name()))
        self.take(";")
        self.enums[name] = literals
        self.literals.update(literals)

    def automaton(self, kind: str) -> None:
        self.take("automaton")
        automaton = Automaton(kind, self.declare(self.name()))
        self.take(":")
        while self.found("disc"):
            self.variable(automaton)
        while self.found("location"):
            self.location(automaton)
        self.take("end")
        if not automaton.initial:
            raise CifError(f"{automaton.name} has no initial location")
        targets = {e.target for edges in automaton.edges.values() for e in edges}
        if not targets <= set(automaton.edges):
            raise CifError(f"{automaton.name} goes to {targets - set(automaton.edges)}")
        self.specification.automata.append(automaton)

    def variable(self, automaton: Automaton) -> None:
        values: list[Any]
        match self.take():
            case "bool":
                values = [False, True]
            case "int":
                self.take("[")
                low = int(self.take())
                self.take("..")
                values = list(range(low, int(self.take()) + 1))
                self.take("]")
            case enum:
                values = list(self.enums[enum.replace("$", "")])
        name = self.declare(f"{automaton.name}.{self.name()}")
        several = self.found("in")
        self.take("{" if several else "=")
        starts = [self.expression()({})]
        while several and self.found(","):
            starts.append(self.expression()({}))
        if several:
            self.take("}")
        self.take(";")
        if not set(starts) <= set(values):
            raise CifError(f"{name} starts outside its range")
        self.specification.variables[name] = (starts, values.__contains__)

    def location(self, automaton: Automaton) -> None:
        place = "" if self.next == ":" else self.name()
        if place:
            self.declare(f"{automaton.name}.{place}")
        else:
            place = "*"
        self.take(":")
        automaton.edges[place] = []
        while self.next in ("initial", "marked", "edge"):
            match self.take():
                case "initial":
                    automaton.initial = place
                case "marked":
                    automaton.marked.add(place)
                case _:
                    automaton.edges[place].append(self.edge(automaton, place))
                    continue
            self.take(";")

    def edge(self, automaton: Automaton, place: str) -> Edge:
        event = self.name()
        if event not in self.specification.controllable:
            raise CifError(f"{event} is no event")
        guards: list[Expression] = []
        if self.found("when"):
            guards.append(self.expression())
            while self.found(","):
                guards.append(self.expression())
        updates = []
        if self.found("do"):
            updates.append(self.update(automaton))
            while self.found(","):
                updates.append(self.update(automaton))
        target = self.name() if self.found("goto") else place
        self.take(";")
        return Edge(event, lambda view: all(g(view) for g in guards), updates, target)

    def update(self, automaton: Automaton) -> tuple[str, Expression]:
        name = f"{automaton.name}.{self.name()}"
        if name not in self.specification.variables:
            raise CifError(f"{name} is no variable of {automaton.name}")
        self.take(":=")
        return name, self.expression()

    def invariant(self) -> None:
        specification = self.specification
        if self.next.replace("$", "") in specification.controllable:
            event = self.name()
            self.take("needs")
            specification.event_invariants.append((event, self.expression()))
        else:
            holds = self.expression()
            if self.found("disables"):
                event = self.name()
                specification.event_invariants.append((event, lambda view: not holds(view)))
            else:
                specification.state_invariants.append(holds)
        self.take(";")

    # --- expressions

    def expression(self) -> Expression:
        left = self.chain(("or",), lambda: self.chain(("and",), self.comparison))
        if self.found("=>"):
            right = self.chain(("or",), lambda: self.chain(("and",), self.comparison))
            return lambda view: (not left(view)) or right(view)
        return left

    def chain(self, operators: tuple[str, ...], part: Callable[[], Expression]) -> Expression:
        found = part()
        while self.next in operators:
            found = _joined(self.take(), found, part())
        return found

    def comparison(self) -> Expression:
        return self.chain(("=", "!=", "<", "<=", ">", ">="), self.sum)

    def sum(self) -> Expression:
        return self.chain(("+", "-"), self.unary)

    def unary(self) -> Expression:
        if self.found("not"):
            inner = self.unary()
            return lambda view: not _boolean(inner(view))
        return self.atom()

    def atom(self) -> Expression:
        if self.found("("):
            inner = self.expression()
            self.take(")")
            return inner
        if self.found("if"):
            return self.cases()
        token = self.next
        if token in ("true", "false"):
            self.take()
            return lambda view: token == "true"
        if token.isdigit():
            self.take()
            return lambda view: int(token)
        name = self.name()
        self.references.append(name)
        if name in self.literals:
            return lambda view: name
        return lambda view: view[name]

    def cases(self) -> Expression:
        cases = []
        while True:
            condition = self.expression()
            self.take(":")
            cases.append((condition, self.expression()))
            if self.take("elif", "else") == "else":
                break
        otherwise = self.expression()
        self.take("end")

        def value(view: dict[str, Any]) -> Any:
            for condition, result in cases:
                if condition(view):
                    return result(view)
            return otherwise(view)

        return value


def _boolean(value: Any) -> bool:
    if not isinstance(value, bool):
        raise CifError(f"{value!r} is no boolean")
    return value


def _joined(operator: str, left: Expression, right: Expression) -> Expression:
    def apply(view: dict[str, Any]) -> Any:
        first = left(view)
        if operator in ("and", "or"):
            second = right(view)
            _boolean(first), _boolean(second)
            return (first and second) if operator == "and" else (first or second)
        second = right(view)
        if type(first) is not type(second):
            raise CifError(f"{first!r} {operator} {second!r}")
        match operator:
            case "=":
                return first == second
            case "!=":
                return first != second
            case "<":
                return first < second
            case "<=":
                return first <= second
            case ">":
                return first > second
            case ">=":
                return first >= second
            case "+":
                return first + second
        return first - second

    return apply


def read_cif(text: str) -> Specification:
    return Reader(text).read()
