"""Texts of guards are conditions of the language: read by the front end, they mean the same."""

from __future__ import annotations

import math
import random

import pytest
from data_models import data_model
from synthesis.subject import robot_of

from robosc import pipeline
from robosc.expr.evaluation import Undefined, evaluate
from robosc.expr.tree import Expr, Leaf, VariableRef
from robosc.expr.types import ArrayType, Type, Value, domain
from robosc.plant.logic import exact, negation
from robosc.plant.model_text import to_dsl

pytestmark = pytest.mark.slow

ARRAYS = """
robot R {{
    datatype object Place {{ x: double names: array(string) }}
    datatype object Scan {{ items: array(double) place: Place flags: array(boolean) }}
    datatype enum Way from double to {{ value < 0.5 -> near value > 2 -> far default -> middle }}
    interface scans use Scan from some_robot_msgs
    parameter limit: double = 0.5
    component L {{
        outgoing message scan with type: Scan links scans
        outgoing message probe with type: Scan links scans
        behaviour {{
            variable items: array(double)
            variable others: array(double)
            variable flags: array(boolean)
            variable place: Place
            variable x: double
            variable ready: boolean
            initial marked state s {{
                on response from scan do items := value.items, flags := value.flags, x := 1.0
                on response from probe if {local} do others := items, place := value.place goto t
            }}
            marked state t {{ on response from scan do x := value.items[0], ready := true goto s }}
        }}
    }}
    component Base {{
        incoming message go with type: none
        incoming message home with type: none
        behaviour {{
            initial marked state here {{ on request to go goto away }}
            marked state away {{ on request to home goto here }}
        }}
    }}
    requirement go needs {first}
    requirement {second} disables home
    requirement never Base.away and L.t and {third}
}}
"""
ATOMS = [
    "L.items[0] < 0.5", "L.items[1] >= 2", "!(L.items[0] < 0.5)", "L.others[0] != 0.5",
    "L.items[0] < L.others[0]", "L.items[0] < limit", "L.flags[0]", "L.place.x > -1.5",
    'L.place.names[0] = "a"', "any(r < 0.5 for r in L.items)", "length(L.items[0..1]) > 1",
    "all(!(r < 0.5) and L.s for r in L.others)", "min(r for r in L.items) < 0.5",
    "count(r < 0.5 for r in L.items if defined(L.others)) > 1", "Way(L.items[0]) = near",
    "defined(L.items)", "defined(L.items[1])", "defined(L.flags[0])", "defined(L.x)",
    "defined(L.place.names[0])", "defined(L.items[0] < L.others[0])", "L.x < 0.5", "L.x > L.items[0]",
    "L.ready", "L.s", "Base.here", "L.items[0] + L.x > 1", "defined(min(r for r in L.items))",
    "defined(L.items[0]) = L.ready",
]  # fmt: skip


def condition(rng: random.Random, depth: int = 2) -> str:
    kind = rng.random()
    if depth == 0 or kind < 0.2:
        return rng.choice(ATOMS)
    if kind < 0.4:
        return f"!({condition(rng, depth - 1)})"
    sides = [condition(rng, depth - 1) for _ in range(2)]
    return f"({sides[0]} {rng.choice(['and', 'or', 'or', '=>'])} {sides[1]})"


def array_model(rng: random.Random, depth: int = 2) -> str:
    fields = {name: condition(rng, depth) for name in ("local", "first", "second", "third")}
    local = fields["local"].replace("Base.here", "ready").replace("L.", "")
    return ARRAYS.format(**{**fields, "local": local})


SAMPLES = [-2.5, -1.0, 0.0, 0.1, 0.3, 0.5, 1.0, 2.0, 3.0, 1e308, math.nan, math.inf]


def some_value(rng: random.Random, type_: Type) -> Value | None:
    """A value of a type; None: a variable that holds nothing yet."""
    if isinstance(type_, ArrayType):
        if rng.random() < 0.25:
            return None
        return tuple(some_value(rng, type_.element) for _ in range(rng.randrange(3)))  # type: ignore[return-value]
    values = domain(type_)
    if values is not None:
        return rng.choice(list(values))
    name = str(type_)
    if name == "double":
        return rng.choice(SAMPLES)
    if name == "integer":
        return rng.choice([-1, 0, 1, 2, 3, 4, 2**53 + 1])
    if name == "string":
        return rng.choice(["", "a", "b"])
    if rng.random() < 0.25:
        return None
    return {"x": rng.choice(SAMPLES), "names": rng.choice([(), ("a",), ("b",)])}


class State:
    """Data and states at random; each leaf has one value as long as this lives."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.known: dict[Leaf, Value | None] = {}

    def __call__(self, leaf: Leaf) -> Value | None:
        if leaf not in self.known:
            whole = isinstance(leaf, VariableRef)
            self.known[leaf] = some_value(self.rng, leaf.type) if whole else self.rng.random() < 0.5
        return self.known[leaf]

    def allows(self, expr: Expr) -> bool:
        try:
            return evaluate(expr, self) is True
        except Undefined:
            return False


def differing(model: str, conditions: list[Expr], rng: random.Random) -> list[str]:
    """Texts of conditions that mean something else than these."""
    robot = robot_of(model)
    texts = [to_dsl(expr, robot) for expr in conditions]
    body, end, _ = model.rpartition("}")
    added = "\n".join(f"requirement go needs {text}" for text in texts)
    back = [r.condition for r in robot_of(f"{body}{added}\n{end}").requirements]
    found = []
    for expr, text, again in zip(conditions, texts, back[len(back) - len(texts) :], strict=True):
        for _ in range(60):
            state = State(rng)
            if state.allows(exact(expr)) != state.allows(again):
                found.append(text)
                break
    return found


@pytest.mark.parametrize("seed", range(30))
def test_conditions_on_arrays_and_their_opposites(seed: int) -> None:
    rng = random.Random(seed)
    model = array_model(rng)
    conditions = [r.condition for r in robot_of(model).requirements if r.condition is not None]
    conditions += [negation(expr) for expr in conditions]
    assert differing(model, conditions, rng) == [], model


@pytest.mark.parametrize(
    ("condition", "text"),
    [
        ("L.s and (L.ready and (L.items[0] < 0.5 and L.t))",
         "L.s and L.ready and L.items[0] < 0.5 and L.t"),
        ("L.s and (L.ready or L.t)", "L.s and (L.ready or L.t)"),
    ],
)  # fmt: skip
def test_no_brackets_around_what_is_chained_anyway(condition: str, text: str) -> None:
    model = array_model(random.Random(0))
    robot = robot_of(model.replace("requirement never", f"requirement go needs {condition} //", 1))
    assert to_dsl(robot.requirements[-1].condition, robot) == text


def test_what_must_be_there_is_asked_for_once() -> None:
    condition = "L.items[0] > 0.5 and L.s and (L.items[0] < 2 and L.place.x > 0)"
    model = array_model(random.Random(0))
    robot = robot_of(model.replace("requirement never", f"requirement go needs {condition} //", 1))
    opposite = negation(robot.requirements[-1].condition)
    assert to_dsl(opposite, robot) == (
        "!(defined(L.items[0]) and L.items[0] > 0.5 and L.s and"
        " L.items[0] < 2 and defined(L.place.x) and L.place.x > 0)"
    )
    assert differing(model, [opposite], random.Random(0)) == []


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", ["arrays", "", "parameter", "failure", "enum", "array"])
def test_guards_of_supervisors(kind: str, seed: int) -> None:
    rng = random.Random(seed)
    model = array_model(rng, 0) if kind == "arrays" else data_model(rng, kind != "array", kind)
    supervisor = pipeline.synthesize(robot_of(model))
    guards = [guard.expr for guard in supervisor.guards]
    assert differing(model, guards, rng) == [], model


@pytest.mark.parametrize("seed", [8, 17])
def test_guards_and_reasons_of_nested_conditions(seed: int) -> None:
    """Thousands of values per event and hundreds of bad states: not all of that is tried."""
    rng = random.Random(seed)
    model = array_model(rng)
    supervisor = pipeline.synthesize(robot_of(model))
    assert any(explanation.trace for explanation in supervisor.explanations)
    assert differing(model, [guard.expr for guard in supervisor.guards], rng) == [], model
