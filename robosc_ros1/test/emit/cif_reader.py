"""A small reader of CIF 3, after the language reference: enough to run what robosc writes.

It knows what data-based synthesis knows of CIF: automata with discrete variables, enumerations,
events, edges with guards and updates, invariants. It is strict where the tools are: undeclared or
doubly declared names, kinds of events and values outside a range are errors.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from emit.cif_system import Automaton, CifError, Edge, Expression, Specification

_TOKEN = re.compile(
    r"\s+|//[^\n]*|(\$?[A-Za-z_]\w*(?:\.\$?[A-Za-z_]\w*)*|\d+|:=|=>|!=|<=|>=|\.\.|[=<>+\-*:;,(){}\[\]])"
)
_WORDS = (
    "alphabet and automaton bool controllable disables disc do edge elif else end enum false goto if"
    " in initial int invariant location marked needs not or plant requirement supervisor true uncontrollable"
    " when"
)
_KEYWORDS = set(_WORDS.split())


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
