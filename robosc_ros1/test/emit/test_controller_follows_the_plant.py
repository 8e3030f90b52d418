"""The generated controller means what the plant means: every event, in each state of a walk.

The reference is ``plant.step``; the controller is real generated code.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest
import steep_families
from emit.generated_code import controller_class, controller_source, supervisor_of
from quick import quick_first
from random_models import random_model
from runtime.lamp_robot import PlayedPort

from robosc.expr.traversal import path_text, walk
from robosc.expr.tree import ValueRef
from robosc.expr.types import (
    BooleanType,
    DoubleType,
    EnumType,
    IntegerType,
    ObjectType,
    StringType,
    Type,
    Value,
)
from robosc.language.events import EventKind
from robosc.plant import part_names
from robosc.plant.automaton import Event, Plant, PlantState, StateVariable, VariableKind
from robosc.plant.step import Verdict, holds, outcome, valuations
from robosc.runtime.core.commanding import controller_engine
from robosc.runtime.core.model import Command
from robosc.runtime.core.reasons import blocked_by
from robosc.runtime.core.settings import Settings
from robosc.runtime.core.values import Mismatch
from robosc.simulate.machines.event_by_event import reasons
from robosc.simulate.machines.state import state_of


class Twin:
    """A generated controller that is put into states of the plant and read back."""

    def __init__(self, text: str) -> None:
        self.supervisor = supervisor_of(text)
        self.plant: Plant = self.supervisor.plant
        make, context = controller_class(self.supervisor)
        self.controller = make()
        self.rows = {c.key: c for c in self.controller.COMMUNICATIONS}
        names = {(VariableKind.LOCATION, name): attribute for name, attribute in context.locations}
        names |= {(VariableKind.DATA, name): attribute for name, attribute in context.variables}
        self.attributes = {v: names[v.kind, v.name] for v in self.plant.variables if not _phase(v)}
        self.inputs = {(i.key, i.kind): i for i in self.controller.INPUTS}
        self.commands = {(c.key, c.kind): c for c in self.controller.COMMANDS}
        self.afters = {(a.component, a.number): a for a in self.controller.AFTERS}
        self.taus = {(t.component, t.number): t for t in self.controller.TAUS}

    def put(self, state: PlantState) -> None:
        for variable, index in zip(self.plant.variables, state, strict=True):
            if _phase(variable):
                for number, flag in enumerate(self.rows[variable.name].flags, 1):
                    setattr(self.controller, flag, index == number)
            else:
                setattr(self.controller, self.attributes[variable], variable.values[index])

    def state(self) -> PlantState:
        return tuple(
            variable.values.index(
                self.controller.phase(self.rows[variable.name])
                if _phase(variable)
                else getattr(self.controller, self.attributes[variable])
            )
            for variable in self.plant.variables
        )

    def call(self, method: Callable[..., Any] | None, *arguments: Any) -> Any:
        return method(self.controller, *arguments) if method is not None else None


def _phase(variable: StateVariable) -> bool:
    return variable.kind is VariableKind.PHASE


def incoming(plant: Plant, event: Event, values: tuple[Value | None, ...]) -> Any:
    """The value as a ``read_`` method gives it."""
    type_ = plant.robot.communications[event.key].value_type(event.kind)
    given = dict(zip((p.path for p in event.parameters), values, strict=True))
    parts: dict[tuple[str | int, ...], Type] = {}
    for automaton in event.automata:
        for edge in automaton.edges:
            for expr in (a.value for a in edge.assignments):
                for part in walk(expr):
                    if isinstance(part, ValueRef):
                        parts[part.path] = part.type
    if isinstance(type_, ObjectType):
        return {
            path_text(path): given[path] if path in given else some(part_type)
            for path, part_type in {**parts, **{p.path: p.type for p in event.parameters}}.items()
        }
    return given[()] if () in given else some(type_)


def some(type_: Type) -> Value:
    match type_:
        case BooleanType():
            return True
        case DoubleType():
            return 1.5
        case IntegerType(bounds=bounds):
            return bounds[0] if bounds else 3
        case EnumType(values=values):
            return values[0]
        case StringType():
            return "text"
    return 0


def check_event(
    twin: Twin, event: Event, values: tuple[Value | None, ...], state: PlantState
) -> PlantState | None:
    """Compare one event in one state; where it leads if it is possible."""
    expected = outcome(twin.plant, event, values, state)
    twin.put(state)
    if event.kind is EventKind.TAU:
        return check_tau(twin, event, state, expected)
    if event.kind is EventKind.AFTER:
        path = twin.call(twin.afters[event.key, event.index].step)
        assert (path is None) == isinstance(expected, Verdict), event
        assert twin.state() == (state if path is None else expected)
        return None if path is None else twin.state()
    if event.controllable:
        command = twin.commands[event.key, event.kind.word]
        in_phase = event.phase is None or state[event.phase.variable] in event.phase.sources
        assert command.possible(vars(twin.controller)) == in_phase
        synchronisation = command.synchronisation is None or twin.call(command.synchronisation)
        assert (in_phase and synchronisation) == (not isinstance(expected, Verdict)), event
        check_reasons(twin, event, state, command)
        if isinstance(expected, Verdict):
            return None
        check_guard(twin, event, state, command.guard)
        twin.call(command.apply)
    else:
        try:
            method = twin.inputs[event.key, event.kind.word].apply
            twin.call(method, incoming(twin.plant, event, values))
        except Mismatch:
            assert isinstance(expected, Verdict), event
            assert twin.state() == state, "a mismatch changes nothing"
            return None
    assert twin.state() == expected, (event, values)
    return twin.state()


def check_guard(twin: Twin, event: Event, state: PlantState, method: str) -> None:
    guard = next(g for g in twin.supervisor.guards if g.event == event)
    assert twin.call(method) == holds(twin.plant, guard.expr, state), event


def check_reasons(twin: Twin, event: Event, state: PlantState, command: Command) -> None:
    """The controller tells as the simulator does why the plant cannot do it."""
    guard = next(g for g in twin.supervisor.guards if g.event == event)
    nothing_known = state_of(twin.plant, state, dict.fromkeys(twin.plant.robot.variables))
    played = [(r.kind, r.text) for r in reasons(twin.supervisor, guard, state, nothing_known)]
    told = [(r["kind"], r["text"]) for r in blocked_by(twin.controller, command)]
    impossible = ("phase", "synchronisation", "range")
    assert [r for r in told if r[0] in impossible] == [r for r in played if r[0] in impossible]


def check_tau(twin: Twin, event: Event, state: PlantState, expected: Any) -> PlantState | None:
    guard = next(g for g in twin.supervisor.guards if g.event == event)
    possible = not isinstance(expected, Verdict) and holds(twin.plant, guard.expr, state)
    tau = twin.taus.get((event.key, event.index))
    path = twin.call(tau.step) if tau is not None else None
    if not possible or expected == state:  # a step that changes nothing is not taken
        assert path is None
        assert twin.state() == state
        return None
    variable = event.automata[0].variable
    names = twin.plant.variables[variable].values
    assert path == f"{names[state[variable]]}->{names[expected[variable]]}"
    assert twin.state() == expected
    return twin.state()


@pytest.mark.parametrize("seed", quick_first(range(30), 12))
def test_walks_of_random_models(seed: int) -> None:
    rng = random.Random(seed)
    walk_through(Twin(random_model(rng, 1 + seed % 3)), rng)


@pytest.mark.parametrize("seed", quick_first(range(30), 12))
def test_walks_of_random_models_that_the_robot_calls(seed: int) -> None:
    rng = random.Random(seed)
    walk_through(Twin(random_model(rng, 1 + seed % 3, served=True)), rng)


@pytest.mark.parametrize(
    ("family", "size"), [("crew", 4), ("not_all_busy", 9), ("allocation", 4), ("road", 3)]
)
def test_guards_that_call_methods_of_parts(
    family: str, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They decide as before, and the tables name what they read through the parts."""
    model = getattr(steep_families, family)(*((size, 2) if family == "road" else (size,)))
    plain = Twin(model)
    monkeypatch.setattr(part_names, "LONG", 0)
    monkeypatch.setattr(part_names, "_LEAST_SAVED", -1000)
    twin = Twin(model + "\n")  # a text of its own, whose supervisor is computed here
    assert any(name.startswith("part_") for name in vars(type(twin.controller)))
    walk_through(twin, random.Random(1))
    for one, other in zip(plain.controller.COMMANDS, twin.controller.COMMANDS, strict=True):
        assert set(one.reads) == set(other.reads), one.key


COUNTED = """
robot Counted {
    component Lamp[1..4] {
        incoming message light with identifier: "/l{index}/light", type: none
        outgoing message out with identifier: "/l{index}/out", type: none
        behaviour {
            initial marked state dark { on request to light goto lit }
            state lit { on response from out goto dark }
        }
    }
    for i in 1..2 { requirement Lamp[i].light needs count(l.lit for l in Lamp) < 2 }
    requirement never count(l.lit for l in Lamp) > 2
}
"""


def test_guards_that_count() -> None:
    twin = Twin(COUNTED)
    source = "".join(controller_source(twin.supervisor).split())
    assert source.count("sum((") >= 4
    walk_through(twin, random.Random(1))


@pytest.mark.parametrize("seed", quick_first(range(30), 8))
def test_the_engine_looks_again_at_all_that_an_event_may_change(seed: int) -> None:
    """What tables of reads and writes leave out is what it was."""
    rng = random.Random(seed)
    twin = Twin(random_model(rng, 1 + seed % 3))
    controller = twin.controller
    controller.INPUTS = tuple(
        i if i.read is None else i._replace(read=lambda _, value: value) for i in controller.INPUTS
    )
    port = PlayedPort()
    engine = controller_engine(controller, port, Settings(rate=2.0))
    engine.begin()
    inputs = [event for event in twin.plant.events if not event.controllable]
    for _ in range(60):
        event = rng.choice(inputs)
        value = incoming(twin.plant, event, rng.choice(list(valuations(event))))
        if twin.plant.robot.communications[event.key].phases is not None:
            engine.report(event.key, port.tokens.get(event.key, 0), event.kind.word, value)
        else:
            engine.post(event.key, event.kind.word, value)
        engine.cycle()
        port.time += rng.choice([0.0, 0.1, 0.5])
        if engine.stopped:
            break
        commands = engine.parts.scheduler.commands
        assert [c.was for c in commands] == [c.allowed() for c in commands]
        assert [tau for tau in controller.TAUS if tau.step(controller.copy())] == []


PHASES = """
robot Phases {
    component Arm {
        service grab with request: none, response: none links empty
        incoming message wave with type: none
        behaviour {
            initial marked state open { on response from grab if grab.busy goto shut }
            marked state shut { transition if grab.idle goto open }
        }
    }
    requirement wave needs Arm.grab.idle or Arm.shut
    requirement grab.busy disables grab
    interface empty use Empty from std_srvs
}
"""


def test_a_walk_of_a_model_that_reads_phases() -> None:
    walk_through(Twin(PHASES), random.Random(1))


def walk_through(twin: Twin, rng: random.Random) -> None:
    state = twin.plant.initial
    assert twin.state() == state
    for _ in range(40):
        successors = []
        for event in twin.plant.events:
            choices = list(valuations(event))
            for values in rng.sample(choices, min(len(choices), 8)):
                after = check_event(twin, event, values, state)
                if after is not None:
                    successors.append(after)
        if not successors:
            break
        state = rng.choice(successors)
