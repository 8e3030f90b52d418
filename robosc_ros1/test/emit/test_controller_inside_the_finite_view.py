"""The generated controller on numbers and strings themselves, held against what the plant allows.

The plant knows data by classes and tests; the controller evaluates them exactly. Every step of it,
on any numbers, must be one of the plant, and must stay in the controlled system.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest
from data_models import SAMPLES, data_model
from emit.generated_code import controller_class
from quick import quick_first

from robosc.ir.automaton import Event, EventParameter, PlantState, StateVariable, VariableKind
from robosc.ir.expr import Leaf, Undefined
from robosc.ir.finite.terms import value_of
from robosc.ir.lower import lower
from robosc.ir.step import Verdict, holds, outcome
from robosc.model.entities import EventKind
from robosc.model.evaluation import part_of_value
from robosc.model.expr import StateRef, ValueRef, VariableRef
from robosc.model.resolve import load
from robosc.model.types import Value
from robosc.runtime.values import Mismatch
from robosc.simulate.start import supervisor_with
from robosc.source import Source
from robosc.supervisor import Supervisor
from robosc.synthesis import synthesize
from robosc.synthesis.parameters import weight


class Run:
    """A controller at work, and the state of the plant that its data belong to."""

    def __init__(
        self, supervisor: Supervisor, parameters: Mapping[str, Value] = MappingProxyType({})
    ) -> None:
        make, context = controller_class(supervisor)
        self.supervisor = supervisor = supervisor_with(supervisor, parameters)
        self.plant = supervisor.plant
        self.controller = make()
        self.controller.configure(parameters)
        self.busy = {key: name for name, key in _phases(self.controller).items()}
        self.attributes = dict(context.variables)
        self.guards = {id(g.event): g for g in supervisor.guards}

    def look(self, leaf: Leaf, value: Value | None = None) -> Value | None:
        match leaf:
            case VariableRef(component=component, variable=name):
                found: Value = getattr(self.controller, self.attributes[f"{component}.{name}"])
                return found
            case StateRef(component=component, state=name):
                return bool(self.controller.components()[component] == name)
            case ValueRef(path=path):
                return part_of_value(value, path)
        raise TypeError(leaf)

    def state(self) -> PlantState:
        return tuple(v.values.index(self.value(v)) for v in self.plant.variables)

    def value(self, variable: StateVariable) -> Any:
        if variable.kind is VariableKind.TEST:
            assert variable.test is not None
            return value_of(variable.test, self.look)
        if variable.kind is VariableKind.LOCATION:
            return self.controller.components()[variable.name]
        if variable.kind is VariableKind.PHASE:
            return variable.values[int(getattr(self.controller, self.busy[variable.name]))]
        return getattr(self.controller, self.attributes[variable.name])

    def perform(self, event: Event, value: Value | None) -> bool:
        """Let the controller take an event if it may; whether it did."""
        table = self.controller.COMMANDS if event.controllable else self.controller.INPUTS
        if event.kind is EventKind.TAU:
            steps = [
                t
                for t in self.controller.TAUS
                if (t.component, t.number) == (event.key, event.index)
            ]
            return any(_call(self.controller, tau.step) is not None for tau in steps)
        entry = next(e for e in table if (e.key, e.kind) == (event.key, event.kind.value))
        if event.controllable:
            conditions = (entry.guard, entry.synchronisation)
            if event.phase is not None and getattr(self.controller, entry.busy):
                return False
            if not all(_call(self.controller, c) for c in conditions if c is not None):
                return False
            _call(self.controller, entry.apply)
            return True
        try:
            read = value if isinstance(value, int | float | str | None) else entry.read(None, value)
            _call(self.controller, entry.apply, read)
        except Mismatch:
            return False
        return True


def _phases(controller: Any) -> dict[str, str]:
    return {c.busy: c.key for c in controller.COMMANDS if c.busy is not None}


def _call(controller: Any, method: Any, *arguments: Any) -> Any:
    if method is None:
        return None
    if isinstance(method, str):
        return getattr(controller, method)(*arguments)
    return method(controller, *arguments)


def taken(run: Run, parameter: EventParameter, value: Value | None) -> Value | None:
    """What a part of the event's value is, or a test of it comes to, before the event."""
    try:
        if parameter.test is not None:
            return value_of(parameter.test, lambda leaf: run.look(leaf, value))
        return None if value is None else part_of_value(value, parameter.path)
    except Undefined:
        return None


def step(run: Run, event: Event, value: Value | None) -> None:
    before = run.state()
    values = [taken(run, parameter, value) for parameter in event.parameters]
    guard = run.guards.get(id(event))
    if not run.perform(event, value):
        return
    after = run.state()
    for number, parameter in enumerate(event.parameters):
        if parameter.path[:1] and str(parameter.path[0]).startswith("new "):
            name = str(parameter.path[0]).removeprefix("new ")
            variable = next(v for v in run.plant.variables if v.name == name)
            values[number] = run.value(variable)
    if guard is not None:
        assert holds(run.plant, guard.expr, before), (event, before)
    expected = outcome(run.plant, event, tuple(values), before)
    assert not isinstance(expected, Verdict), (event, value, before)
    assert after == expected, (event, value, before)


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


@pytest.mark.parametrize("seed", quick_first(range(40), 8))
def test_steps_on_objects_and_arrays_are_steps_of_the_plant(seed: int) -> None:
    rng = random.Random(seed)
    robot, diagnostics = load(Source("model.rscd", object_model(rng)))
    assert robot is not None, diagnostics
    run = Run(synthesize(lower(robot)))
    for _ in range(150):
        event = rng.choice(run.plant.events)
        step(run, event, some_place(rng) if event.name == "place" else None)
