"""Random expressions and data of a robot, as model text, and what they are drawn over."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field

COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")


@dataclass(frozen=True)
class RandomType:
    """``values`` of a finite type as they are written in expressions; None for all others."""

    text: str
    kind: str
    values: tuple[str, ...] | None = None
    properties: tuple[tuple[str, RandomType], ...] = ()

    @property
    def size(self) -> int:
        return len(self.values) if self.values else 1


NONE = RandomType("none", "none")
BOOLEAN = RandomType("boolean", "boolean", ("false", "true"))
DOUBLE = RandomType("double", "double")
INTEGER = RandomType("integer", "integer")
STRING = RandomType("string", "string")


def ranged(low: int, high: int) -> RandomType:
    return RandomType(
        f"integer({low}..{high})", "integer", tuple(str(i) for i in range(low, high + 1))
    )


@dataclass
class RandomVariable:
    component: str
    name: str
    type: RandomType
    initial: str | None
    silent: bool  # never read where synthesis would see it

    def reference(self, component: str | None, rng: random.Random) -> str:
        if self.component == component and rng.random() < 0.8:
            return self.name
        return f"{self.component}.{self.name}"


@dataclass
class RandomCommunication:
    name: str
    kind: str
    request: RandomType = NONE
    response: RandomType = NONE
    feedback: RandomType = NONE

    @property
    def events(self) -> list[str]:
        return {
            "incoming": ["request"],
            "outgoing": ["response"],
            "service": ["request", "response", "error"],
            "action": ["request", "response", "feedback", "error", "cancel"],
            "outgoing service": ["request", "response", "error"],
            "outgoing action": ["request", "response", "feedback", "error", "cancel"],
        }[self.kind]

    @property
    def served(self) -> bool:
        return self.kind in ("outgoing service", "outgoing action")

    @property
    def sent(self) -> RandomType:
        """The type of what the controller gives."""
        return self.response if self.served else self.request

    def value(self, event: str) -> RandomType:
        if self.served:
            return self.request if event == "request" else NONE
        return {"response": self.response, "feedback": self.feedback}.get(event, NONE)


@dataclass
class RandomComponent:
    name: str
    states: list[str] = field(default_factory=list)
    marked: set[str] = field(default_factory=set)
    variables: list[RandomVariable] = field(default_factory=list)
    communications: list[RandomCommunication] = field(default_factory=list)
    machine: bool = False  # works through its own communications in a cycle, and counts


@dataclass(frozen=True)
class Scope:
    """Where an expression stands: in which behaviour, and what ``value`` is there."""

    component: str | None = None
    value: RandomType = NONE
    # Expressions over data-only variables are allowed where nothing of synthesis reads the result.
    data: bool = False


class RandomExpressions:
    """Draws expressions over what was declared so far."""

    def __init__(self, rng: random.Random, budget: int) -> None:
        self.rng = rng
        self.budget = budget
        self.enums: list[RandomType] = []
        self.objects: list[RandomType] = []
        self.declarations: list[str] = []
        self.components: list[RandomComponent] = []

    # --- chance ------------------------------------------------------------------------------

    def chance(self, percent: int) -> bool:
        return self.rng.randrange(100) < percent

    def pick(self, options: list[str] | tuple[str, ...]) -> str:
        return options[self.rng.randrange(len(options))]

    def number(self, low: int, high: int) -> int:
        return self.rng.randint(low, high)

    def spend(self, factor: int) -> bool:
        if factor > self.budget:
            return False
        self.budget //= factor
        return True

    def paths(self, type_: RandomType, path: str = "value") -> list[tuple[str, RandomType]]:
        """Finite parts of an incoming value."""
        if type_.values is not None:
            return [(path, type_)]
        if type_.kind == "array":
            element = type_.properties[0][1]
            return [p for i in (0, 1) for p in self.paths(element, f"{path}[{i}]")]
        return [p for name, t in type_.properties for p in self.paths(t, f"{path}.{name}")]

    def replaced(self, path: str, type_: RandomType) -> str:
        """An element of an array, or, depending on its path, what replaces it where it is missing."""
        rng = random.Random(f"{path} {type_.text} {self.budget}")
        if "[" not in path or not type_.values or rng.random() < 0.6:
            return path
        return f"({path} else {rng.choice(type_.values)})"

    # --- expressions -------------------------------------------------------------------------

    def readable(self, kind: str, scope: Scope, type_: RandomType | None = None) -> list[str]:
        """References of a kind that may stand in the scope; ``type_`` tells enums apart."""

        def fits(candidate: RandomType) -> bool:
            if candidate.values is None and not scope.data:
                return False
            return candidate.kind == kind and (type_ is None or candidate.text == type_.text)

        found = [
            variable.reference(scope.component, self.rng)
            for component in self.components
            for variable in component.variables
            if fits(variable.type) and (scope.data or not variable.silent)
        ]
        found += [self.replaced(path, t) for path, t in self.paths(scope.value) if fits(t)]
        return found

    def boolean(self, scope: Scope, depth: int = 2) -> str:
        if depth > 0 and self.chance(55):
            shape = self.number(0, 4)
            if shape == 0:
                return f"!({self.boolean(scope, depth - 1)})"
            operator = self.pick(("and", "or", "and", "or", "=>", "=", "!="))
            left, right = self.boolean(scope, depth - 1), self.boolean(scope, depth - 1)
            if operator in ("=", "!="):
                left, right = f"({left})", f"({right})"
            return f"({left} {operator} {right})"
        atoms: list[Callable[[Scope], str | None]] = [
            self.flag, self.place, self.comparison, self.enum_test, self.comparison,
        ]  # fmt: skip
        order = list(range(len(atoms)))
        self.rng.shuffle(order)
        for index in order:
            atom = atoms[index](scope)
            if atom is not None:
                return atom
        return self.pick(("true", "true", "false"))

    def flag(self, scope: Scope) -> str | None:
        found = self.readable("boolean", scope)
        return self.pick(found) if found else None

    def place(self, scope: Scope) -> str | None:
        places = []
        for component in self.components:
            for state in component.states:
                own = component.name == scope.component and self.chance(70)
                places.append(state if own else f"{component.name}.{state}")
        return self.pick(places) if places else None

    def comparison(self, scope: Scope) -> str | None:
        if not self.readable("integer", scope):
            return None
        left = self.integer(scope)
        if self.chance(10):
            return f"{left} / 2 {self.pick(('<', '>', '='))} {self.pick(('0.5', '1.0', '-1'))}"
        return f"{left} {self.pick(COMPARISONS)} {self.integer(scope)}"

    def enum_test(self, scope: Scope) -> str | None:
        if not self.enums:
            return None
        type_ = self.enums[self.rng.randrange(len(self.enums))]
        found = self.readable("enum", scope, type_)
        if not found:
            return None
        assert type_.values is not None
        operator = self.pick(("=", "=", "!="))
        other = self.pick(found) if self.chance(25) else self.pick(type_.values)
        return f"{self.pick(found)} {operator} {other}"

    def integer(self, scope: Scope, depth: int = 1) -> str:
        found = self.readable("integer", scope)
        if depth > 0 and self.chance(40):
            left, right = self.integer(scope, depth - 1), self.integer(scope, depth - 1)
            return f"({left} {self.pick(('+', '-', '+', '-', '*'))} {right})"
        if found and self.chance(70):
            reference = self.pick(found)
            return f"-{reference}" if self.chance(10) else reference
        return str(self.number(-1, 3))

    def assigned(self, variable: RandomVariable, scope: Scope) -> str:
        """A right-hand side for a variable."""
        type_ = variable.type
        if type_.values is None:
            return self.data_only(variable, scope)
        if type_.kind == "boolean":
            return self.boolean(scope, 1)
        found = self.readable(type_.kind, scope, type_ if type_.kind == "enum" else None)
        if type_.kind == "integer":
            if self.chance(40):
                reference = variable.reference(scope.component, self.rng)
                return f"{reference} + {self.pick(('1', '-1', '2'))}"
            if found and self.chance(40):
                return f"{self.pick(found)} {self.pick('+-*%')} {self.integer(scope)}"
        return self.pick(found) if found and self.chance(65) else self.pick(type_.values)

    def data_only(self, variable: RandomVariable, scope: Scope) -> str:
        kind = variable.type.kind
        if kind == "string":
            return self.pick(('"here"', "'there'"))
        if scope.value in (INTEGER, DOUBLE) and (kind == "double" or scope.value == INTEGER):
            return "value"
        if kind == "double" and self.chance(50):
            return f"{variable.name} * 0.5 + {self.integer(scope)}"
        return f"{variable.name} + {self.integer(scope)}"

    def rarely(self, kind: str) -> str:
        """A state requirement that leaves something: about a combination, not one condition."""
        parts = [self.boolean(Scope(), 1) for _ in range(2)]
        if self.chance(60):
            parts = [self.place(Scope()) or part for part in parts]
        if kind == "never":
            return f"({parts[0]} and {parts[1]})"
        return f"!({parts[0]} and {parts[1]})"

    def data(self, type_: RandomType) -> str:
        if type_.kind == "object":
            fields = [
                f"{name}: {self.data(t)}"
                for name, t in type_.properties
                if t.kind != "array" and self.chance(70)
            ]
            return "{ " + ", ".join(fields) + " }" if fields else "{}"
        if type_.kind == "string":
            return '"text"'
        if type_.kind == "double":
            return f"{self.integer(Scope(data=True))} / 2"
        if type_.values is None:
            return self.integer(Scope(data=True))
        return self.pick(type_.values)
