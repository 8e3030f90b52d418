"""Random robots whose decisions compare numbers without bounds and strings, as model text."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import Any

__all__ = ["CONSTANTS", "SAMPLES", "data_model"]

ABOVE = math.nextafter(0.1, 1.0)

CONSTANTS = {
    "double": [0.1, ABOVE, 0.5, 1e308, -2.5, 0.0],
    "integer": [-1, 0, 2, 3, 2**53 + 1],
    "string": ["", "a", "b"],
}
"""What models compare with: neighbours among doubles and integers, and numbers of any size."""


def _doubles() -> list[float]:
    beside = [math.nextafter(c, s) for c in CONSTANTS["double"] for s in (math.inf, -math.inf)]
    found = {*CONSTANTS["double"], *beside, 0.3, 1.0, math.inf, -math.inf}
    return [*sorted(found), math.nan]


SAMPLES: dict[str, list[Any]] = {
    "double": _doubles(),
    "integer": sorted({c + step for c in CONSTANTS["integer"] for step in (-1, 0, 1)}),
    "string": [*CONSTANTS["string"], "other"],
}
"""Numbers and strings of every class that models over these constants can tell apart."""


@dataclass
class _Builder:
    rng: random.Random
    type: str
    computed: bool
    quiet: bool
    extra: str

    def pick(self, *options: str) -> str:
        return self.rng.choice(options)

    def constant(self) -> str:
        value = self.rng.choice(CONSTANTS[self.type])
        return f'"{value}"' if isinstance(value, str) else repr(value).replace("e+", "E")

    def data(self, *leaves: str) -> str:
        """A number or a string; computed from others if that is allowed."""
        leaf = self.pick(*leaves)
        if self.extra == "parameter" and self.rng.random() < 0.25:
            leaf = "p"
        if self.computed and self.type != "string" and self.rng.random() < 0.15:
            return f"{leaf} {self.pick('+', '-', '*')} {self.pick(*leaves, self.constant())}"
        return leaf

    def comparison(self, *leaves: str) -> str:
        operators = ("=", "!=") if self.type == "string" else ("=", "!=", "<", "<=", ">", ">=")
        sides = [self.data(*leaves), self.constant()]
        if self.computed and self.rng.random() < 0.25:
            sides[1] = self.data(*leaves)
        self.rng.shuffle(sides)
        return f"{sides[0]} {self.pick(*operators)} {sides[1]}"

    def band(self, *leaves: str) -> str:
        """That a number or a string is converted to some value of the enum."""
        return f"Band({self.pick(*leaves)}) {self.pick('=', '!=')} {self.pick('low', 'middle')}"

    def enum(self) -> str:
        rules = [f"{self.comparison('value')} -> {v}" for v in ("low", "middle", "low")]
        joined = f"{self.comparison('value')} and !({self.comparison('value')}) -> middle"
        return f"datatype enum Band from {self.type} to {{ {' '.join(rules)} {joined} default -> high }}"

    def items(self) -> str:
        """A number of an array that came in, or its only string; or what replaces a missing one."""
        found = self.item()
        if self.rng.random() < 0.6:
            return found
        return f"({found} else {self.constant()})"

    def item(self) -> str:
        if self.type == "string":
            return "value.items[0]"
        kept = self.pick("", f" if {self.comparison('e')}")
        return f"{self.pick('min', 'max', 'sum')}(e for e in value.items{kept})"

    def quantified(self) -> str:
        kind = self.pick("any", "all", "count", "length")
        if kind == "length":
            return f"length(value.items) {self.pick('=', '<', '>')} {self.pick('0', '1')}"
        found = f"{kind}({self.comparison('e')} for e in value.items)"
        return f"{found} {self.pick('<', '>')} 1" if kind == "count" else found

    def condition(self, *leaves: str, others: tuple[str, ...] = ()) -> str:
        """A condition over data; ``others`` are booleans beside it."""
        kind = self.rng.random()
        if kind < 0.5 and "value.items" in leaves[0] and self.type != "string":
            return self.quantified()
        if kind < 0.15 and others:
            return self.pick(*others)
        if kind < 0.4 and self.extra == "enum":
            return self.band(*leaves)
        if kind < 0.65:
            return self.comparison(*leaves)
        if kind < 0.75:
            return f"!({self.condition(*leaves, others=others)})"
        parts = [self.condition(*leaves, others=others) for _ in range(2)]
        return f"({parts[0]} {self.pick('and', 'or', '=>')} {parts[1]})"

    def assignments(self, incoming: str) -> str:
        given = {
            "v": self.data(incoming, "w", self.constant()),
            "w": self.data(incoming, "v", self.constant()),
            "flag": self.condition(incoming, "v", others=("flag",)),
        }
        if self.extra == "enum":
            given["band"] = f"Band({self.pick(incoming, 'v', 'w')})"
        taken = [name for name in given if self.rng.random() < 0.6] or ["v"]
        return "do " + ", ".join(f"{name} := {given[name]}" for name in taken)

    def reaction(self, event: str, incoming: str) -> str:
        # What changes while the base is away leaves synthesis little but to keep it at home.
        guards = ["Base.here"] if self.quiet else []
        if self.rng.random() < 0.4:
            guards.append(self.condition(incoming, "v", "w", others=("flag", "Base.away")))
        guard = f"if {' and '.join(guards)}" if guards else ""
        goto = f"goto {self.pick('s', 't')}" if self.rng.random() < 0.4 else ""
        return f"on {event} {guard} {self.assignments(incoming)} {goto}"

    def reaching(self) -> str:
        """A goal is under way, and may fail with a result or without."""
        return f"""
            on error from reach {self.pick("", f"do x := {self.data('value')}")} goto here
            state reaching {{
                on response from reach goto {self.pick("here", "away")}
                on error from reach if {self.condition("value", "x")} do x := {self.data("value")}
                on cancelled from reach goto here
            }}
            """

    def build(self) -> str:
        leaves = ("Sensor.v", "Sensor.w")
        others: tuple[str, ...] = ("Sensor.flag", "Sensor.t", "Base.away")
        if self.extra == "enum":
            others += ("Sensor.band = middle",)
        failure, array = self.extra == "failure", self.extra == "array"
        carried = f"request: none, response: {self.type}, feedback: none"

        def state_condition() -> str:
            return self.condition(*leaves, others=others)

        return f"""
robot R {{
    {f"parameter p: {self.type} = {self.constant()}" if self.extra == "parameter" else ""}
    {self.enum() if self.extra == "enum" else ""}
    {f"datatype object Items {{ items: array({self.type}) }}" if array else ""}
    {"interface items use Items from some_robot_msgs" if array else ""}
    interface link use Thing from some_robot_msgs
    component Sensor {{
        outgoing message sense with type: {self.type}
        outgoing message probe with type: {"Items links items" if array else self.type}
        behaviour {{
            variable v: {self.type}
            variable w: {self.type} = {self.constant()}
            variable flag: boolean
            {"variable band: Band" if self.extra == "enum" else ""}
            initial marked state s {{
                {self.reaction("response from sense", "value")}
            }}
            {self.pick("marked", "")} state t {{
                {self.reaction("response from sense", "value")}
                {self.reaction("response from probe", self.items() if array else "value")}
                transition if {self.condition("v", "w", others=("flag",))} goto s
            }}
        }}
    }}
    component Base {{
        incoming message go with type: none
        incoming message home with type: none
        service lift with request: none, response: none links link
        {f"action reach with {carried} links link" if failure else ""}
        behaviour {{
            variable x: {self.type}
            initial marked state here {{
                on request to go do x := {self.data("Sensor.v", "x", self.constant())} goto away
            }}
            {self.pick("marked", "")} state away {{
                on request to home goto here
                on response from sense if {self.condition("value", "x")} goto here
                {"on request to reach goto reaching" if failure else ""}
            }}
            {self.reaching() if failure else ""}
        }}
    }}
    {f"requirement reach needs {state_condition()}" if failure and self.rng.random() < 0.5 else ""}
    {self.pick("", f"requirement go needs {state_condition()}")}
    {self.pick("", f"requirement {state_condition()} disables home")}
    requirement lift needs {self.condition("Base.x", *leaves, others=others)}
    requirement never Base.away and {self.comparison("Base.x", *leaves)}
    {self.pick("", "", "", f"requirement never Sensor.t and {state_condition()}")}
}}
"""


def data_model(rng: random.Random, computed: bool = False, extra: str = "") -> str:
    """The text of a robot without errors; ``computed``: with more than comparisons and copies.

    ``extra`` may be "parameter": a parameter p, of the type of all data; "failure": an action
    whose errors may bring a result; "enum": an enum as a function of them; or "array": an array of
    them that comes in.
    """
    type_ = rng.choice(list(CONSTANTS))
    return _Builder(rng, type_, computed, rng.random() < 0.8, extra).build()
