"""The generated controller on numbers and strings themselves, held against what the plant allows.

The plant knows data by classes and tests; the controller evaluates them exactly. Every step of it,
on any numbers, must be one of the plant, and must stay in the controlled system.
"""

from __future__ import annotations

import math
import random
from types import SimpleNamespace
from typing import Any

import pytest
from data_models import SAMPLES, data_model
from emit.steps_of_controllers import Run, step
from quick import quick_first

from robosc.language.events import EventKind
from robosc.model.resolve import load
from robosc.plant.build import lower
from robosc.plant.step import holds
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize
from robosc.synthesis.event_parameters import weight


def small_supervisor(rng: random.Random, computed: bool, extra: str) -> Supervisor:
    """That of the first random model whose events do not have all too many values."""
    while True:
        robot, diagnostics = load(Source("model.rscd", data_model(rng, computed, extra)))
        assert robot is not None, diagnostics
        plant = lower(robot)
        if all(weight(event) < 3000 for event in plant.events):
            return synthesize(plant)


CASES = [(seed, computed, "") for seed in range(25) for computed in (False, True)]
CASES += [
    (seed, computed, extra)
    for extra, count in (("parameter", 8), ("failure", 4), ("enum", 4))
    for seed in range(count)
    for computed in (False, True)
]


@pytest.mark.parametrize(("seed", "computed", "extra"), quick_first(CASES, 12))
def test_steps_on_exact_data_are_steps_of_the_plant(seed: int, computed: bool, extra: str) -> None:
    rng = random.Random(seed)
    supervisor = small_supervisor(rng, computed, extra)
    if supervisor.empty:
        return
    samples = SAMPLES[str(supervisor.plant.robot.communications["Sensor.sense"].response)]
    finite = [v for v in samples if not isinstance(v, float) or math.isfinite(v)]
    run = Run(supervisor, {"p": rng.choice(finite)} if extra == "parameter" else {})
    assert run.state() in set(supervisor.plant.initial_states)
    for _ in range(150):
        event = rng.choice(run.plant.events)
        value = rng.choice(samples) if event.name in ("sense", "probe") else None
        if (event.name, event.kind) == ("reach", EventKind.ERROR):
            value = rng.choice([*samples, None])
        step(run, event, value)
        for condition, _ in run.plant.invariants:
            assert holds(run.plant, condition, run.state())


OBJECTS = """
robot R {{
    interface links use Place from nowhere_msgs
    datatype object Place {{ x: double route: array(Stop) levels: array(double) }}
    datatype object Stop {{ y: integer }}
    component Sensor {{
        outgoing message place with type: Place links links
        behaviour {{
            variable here: Place
            variable there: Place
            variable levels: array(double)
            variable far: boolean
            variable x: double
            initial marked state s {{
                on response from place {guards[0]} do {actions[0]}
                on request to swap do there := here, {actions[1]} goto t
            }}
            marked state t {{
                on response from place {guards[1]} do {actions[2]} goto s
                on request to swap do {actions[3]} goto s
                transition if {conditions[0]} goto s
            }}
        }}
    }}
    component Base {{
        incoming message swap with type: none
        incoming message drive with type: Place links links
        incoming message go with type: none
    }}
    requirement drive needs {conditions[1]}
    requirement {conditions[2]} disables go
    provide drive with Sensor.{sent}
}}
"""
CONDITIONS = (
    "Sensor.here.x > 0.5", "!(Sensor.here.x > Sensor.there.x)", "Sensor.x > 0",
    "Sensor.far => Sensor.here.route[0].y > 1", "Sensor.there.x <= 0.5 or Sensor.far",
    "any(p.y > 1 for p in Sensor.here.route)", "min(l for l in Sensor.levels) < 1",
    "Sensor.levels[1] > Sensor.levels[0] and !Sensor.far", "length(Sensor.there.levels[0..1]) = 2",
)  # fmt: skip
ACTIONS = (
    "here := value", "levels := value.levels", "here := value, levels := value.levels",
    "x := value.x", "far := value.route[0].y > 1", "levels := value.levels[1..2]",
)  # fmt: skip
MOVES = (
    "far := here.x > 0.5", "x := here.x", "here := there", "levels := there.levels",
    "x := levels[1]", "far := there.route[length(levels)].y > 0",
)  # fmt: skip
GUARDS = ("", "if value.x > 0.5", "if value.x > Sensor.here.x", "if value.route[0].y > 1")


def object_model(rng: random.Random) -> str:
    first, third = rng.sample(ACTIONS, 2)
    second, fourth = rng.choice(MOVES[:2] + MOVES[4:]), rng.choice(MOVES)
    return OBJECTS.format(
        guards=rng.sample(GUARDS, 2),
        actions=(first, second, third, fourth),
        conditions=rng.sample(CONDITIONS, 3),
        sent=rng.choice(["here", "there"]),
    )


def some_place(rng: random.Random) -> Any:
    route = [SimpleNamespace(y=rng.randint(0, 3)) for _ in range(rng.randint(0, 2))]
    levels = [rng.choice([0.5, 1.5, 2.5]) for _ in range(rng.randint(0, 3))]
    x = rng.choice([0.25, 0.5, 0.75, math.nan])
    return SimpleNamespace(x=x, route=route, levels=levels)


@pytest.mark.parametrize("seed", quick_first(range(24), 8))
def test_steps_on_objects_and_arrays_are_steps_of_the_plant(seed: int) -> None:
    rng = random.Random(seed)
    robot, diagnostics = load(Source("model.rscd", object_model(rng)))
    assert robot is not None, diagnostics
    run = Run(synthesize(lower(robot)))
    for _ in range(150):
        event = rng.choice(run.plant.events)
        step(run, event, some_place(rng) if event.name == "place" else None)


STATES = """
robot R {{
    interface links use Place from nowhere_msgs
    datatype object Place {{ levels: array(double) }}
    component Laser {{
        outgoing message place with type: Place links links
        behaviour {{
            variable levels: array(double)
            variable near: boolean
            variable seen: integer
            initial marked state s {{
                on response from place {guard} do levels := value.levels, {action}
            }}
        }}
    }}
    component Gate {{
        incoming message open with type: none
        incoming message shut with type: none
        service lift with request: none, response: none links links
        behaviour {{
            initial marked state closed {{ on request to open goto opened }}
            marked state opened {{
                on request to shut goto closed
                on request to lift goto lifting
            }}
            state lifting {{
                on response from lift goto opened
                on error from lift goto closed
            }}
        }}
    }}
    requirement open needs {conditions[0]}
    requirement {conditions[1]} disables shut
    requirement lift needs {conditions[2]}
    {never}
}}
"""
OF_STATES = (
    "any(Gate.closed and r < 1 for r in {0})", "all(r < 1 for r in {0} if Gate.opened)",
    "count(r < 1 or Gate.lifting for r in {0}) > 1", "any(r < 1 => Gate.closed for r in {0})",
    "!all((r < 1) = Gate.closed for r in {0})", "count(lift.busy or r < 1 for r in {0}) = 2",
    "max(r for r in {0} if !Gate.opened) > 1", "any(r < 1 and lift.idle for r in {0})",
    "sum(r for r in {0} if lift.idle and Gate.closed) < 2", "count(Gate.closed for r in {0}) = 0",
    "any(r < 1 and !Gate.lifting and !Gate.opened for r in {0})",
    "first(r for i, r in {0} if r < i or Gate.opened) > 1", "first(Gate.closed and r < 1 for r in {0})",
    "length([r for r in {0} if lift.idle and r > 1]) = 1", "any(r < i and Gate.closed for i, r in {0})",
    "any(lift.busy or {0}[i] < r for i, r in [r + 1 for r in {0}])",
)  # fmt: skip


def states_model(rng: random.Random) -> str:
    """A robot whose conditions read data and states at once."""
    chosen = [condition.format("Laser.levels") for condition in rng.sample(OF_STATES, 4)]
    incoming = [condition.format("value.levels") for condition in rng.sample(OF_STATES, 2)]
    given = rng.choice(
        [f"near := {incoming[0]}", "seen := count(Gate.closed for r in value.levels)"]
    )
    return STATES.format(
        guard=rng.choice(["", f"if {incoming[1]}"]),
        action=given,
        conditions=[*chosen[:2], rng.choice([chosen[2], "Laser.near", "Laser.seen > 1"])],
        never=rng.choice(["", "", f"requirement never {chosen[3]}"]),
    )


@pytest.mark.parametrize("seed", quick_first(range(24), 8))
def test_steps_are_steps_of_the_plant_where_conditions_on_arrays_read_states(seed: int) -> None:
    rng = random.Random(seed)
    robot, diagnostics = load(Source("model.rscd", states_model(rng)))
    assert robot is not None, diagnostics
    supervisor = synthesize(lower(robot))
    if supervisor.empty:
        return
    run = Run(supervisor)
    for _ in range(150):
        event = rng.choice(run.plant.events)
        step(run, event, some_place(rng) if event.name == "place" else None)


SHARED = """
robot R {{
    interface links use Reading from nowhere_msgs
    datatype object Reading {{ a: double b: double c: double name: string }}
    parameter p: double = 1.0
    component A {{
        outgoing message reading with type: Reading links links
        behaviour {{
            variable x: double = 1.0
            variable y: double
            variable s: string = "a"
            {outer}
            initial marked state s0 {{ on response from reading {guards[0]} do {given[0]} }}
        }}
    }}
    component B {{
        incoming message go with type: none
        behaviour {{
            variable x: double
            variable y: double = 2.0
            variable s: string
            initial marked state off {{
                on response from reading {guards[1]} do {given[1]}
                on request to go do {copied} goto seen
            }}
            marked state seen {{ on response from reading do {given[2]} goto off }}
        }}
    }}
    component C {{
        outgoing message other with type: double
        behaviour {{
            variable x: double
            on response from reading do x := value.c
            on response from other do x := value
            initial marked state here {{}}
        }}
    }}
    requirement go needs {tests[0]}
    requirement never B.seen and {tests[1]} and {tests[2]}
}}
"""
_VARIABLES = ("A.x", "A.y", "B.x", "B.y", "C.x")
_COMPARED = (*_VARIABLES, "p", "1.5", "A.x + B.y", "2 * C.x")


def shared_model(rng: random.Random) -> str:
    """A robot with two or three tests of one variable, whose components take one message."""

    def test(left: str) -> str:
        if rng.random() < 0.15:
            return rng.choice(["A.s = B.s", "A.s = 'a'", "B.s != A.s"])
        right = rng.choice([term for term in _COMPARED if term != left])
        return f"{left} {rng.choice(['<', '<=', '>', '=', '!='])} {right}"

    def given(component: str) -> str:
        values = {
            "x": ["value.a", "value.b", "x", "y", "C.x", "value.a + x", "-value.b", "1.5", "p"],
            "y": ["value.b", "value.c", "y", "x", "value.c - value.a", "A.x"],
            "s": ["value.name", "'a'", "s"],
        }
        chosen = rng.sample(sorted(values), rng.randint(1, 3))
        return ", ".join(f"{name} := {rng.choice(values[name])}" for name in chosen)

    subject = rng.choice(_VARIABLES)
    outer = rng.choice(["", f"on response from reading if value.b > 1 do {given('A')}"])
    return SHARED.format(
        outer=outer,
        guards=[rng.choice(["", "if value.a > value.b", "if value.a > 1"]) for _ in range(2)],
        given=[given("A"), given("B"), given("B")],
        copied=rng.choice(["x := y", "x := x", "x := y, y := x", "x := A.x", "y := A.x + C.x"]),
        tests=[test(rng.choice(_VARIABLES)), test(subject), test(subject)],
    )


@pytest.mark.parametrize("seed", quick_first(range(30), 12))
def test_steps_are_steps_of_the_plant_where_components_take_one_message(seed: int) -> None:
    rng = random.Random(seed)
    while True:
        robot, diagnostics = load(Source("model.rscd", shared_model(rng)))
        assert robot is not None, diagnostics
        plant = lower(robot)
        if all(weight(event) < 3000 for event in plant.events):
            break
    supervisor = synthesize(plant)
    if supervisor.empty:
        return
    numbers = [0.5, 1.0, 1.5, 2.0, 2.5, math.nan]
    run = Run(supervisor, {"p": rng.choice(numbers[:-1])})
    assert run.state() in set(supervisor.plant.initial_states)
    for _ in range(150):
        event = rng.choice(run.plant.events)
        value: Any = None
        if event.name == "reading":
            a, b, c = (rng.choice(numbers) for _ in range(3))
            value = SimpleNamespace(a=a, b=b, c=c, name=rng.choice(["", "a", "b"]))
        elif event.name == "other":
            value = rng.choice(numbers)
        step(run, event, value)
        for condition, _ in run.plant.invariants:
            assert holds(run.plant, condition, run.state())
