"""Messages of which many parts are compared: nothing goes through all combinations of outcomes."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import combinations

import pytest
from random_models import random_model
from simulate.players import play, session
from synthesis.differential import ENGINES, differences
from synthesis.oracle import Oracle
from synthesis.plants import plant_of
from synthesis.subject import robot_of

from robosc import limits, pipeline
from robosc.emit.export.cif import cif_plant
from robosc.errors import StateSpaceError
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, Operation
from robosc.plant.automaton import Event, Plant, PlantState
from robosc.plant.partial_evaluation import holds
from robosc.plant.step import valuations
from robosc.simulate.faults import Refused
from robosc.synthesis import synthesize
from robosc.synthesis.bdd.manager import available
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.event_parameters import choices, for_some, weight

needs_library = pytest.mark.skipif(not available(), reason="needs oxidd")


def many(fields: int, type_: str = "double", *, guards: bool = False) -> str:
    """A message with that many fields, each of which decides about a variable.

    With ``guards`` they also decide together, and a command has to be restricted.
    """
    every = " and ".join(f"value.f{i} > {i}.5" for i in range(fields))
    assigned = ", ".join(f"v{i} := value.f{i} > {i}.5" for i in range(fields))
    variables = " ".join(f"variable v{i}: boolean" for i in range(fields))
    second = f"""
      on response from again if {every} goto full
      on response from again if value.f0 <= 0.5 goto empty
    """
    return f"""robot Many {{
  datatype object Report {{ {" ".join(f"f{i}: {type_}" for i in range(fields))} }}
  interface report use Report from report_msgs
  component Sensor {{
    outgoing message told with type: Report links report
    outgoing message again with type: Report links report
    outgoing message over with type: none
    behaviour {{
      {variables}
      initial marked state plain {{
        on response from told do {assigned}
        {second if guards else ""}
      }}
      marked state full {{ on response from over goto plain }}
      marked state empty {{ on response from over goto plain }}
    }}
  }}
  component Arm {{
    incoming message go with type: none
    behaviour {{
      initial marked state idle {{ on request to go goto busy }}
      state busy {{ on response from over goto idle }}
    }}
  }}
  requirement go needs {" and ".join(f"Sensor.v{i}" for i in range(fields))}
  {"requirement never Arm.busy and Sensor.empty" if guards else ""}
}}"""


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("guards", [False, True], ids=["assigned", "guards"])
def test_few_of_them_agree_with_the_oracle(guards: bool, engine: str) -> None:
    robot = robot_of(many(2, "integer(0..2)", guards=guards))
    assert differences(robot, Oracle(robot), engine) == []


@needs_library
@pytest.mark.parametrize("guards", [False, True], ids=["assigned", "guards"])
def test_very_many_are_solved(guards: bool) -> None:
    supervisor = pipeline.synthesize(robot_of(many(30, guards=guards)))
    small = synthesize(plant_of(many(4, guards=guards)), "explicit")
    assert supervisor.plant_states == small.plant_states * 2**26
    assert [g.status for g in supervisor.guards] == [g.status for g in small.guards]
    found, expected = (
        [(e.reason.partition(", again")[2], e.remedy, len(e.trace)) for e in one.explanations]
        for one in (supervisor, small)
    )
    assert found == expected


def test_the_explicit_engine_refuses_before_it_enumerates() -> None:
    with pytest.raises(StateSpaceError, match="values of told"):
        synthesize(plant_of(many(21, guards=True)), "explicit", max_states=2**40)


def test_cif_is_refused_before_an_event_is_made_of_each_value() -> None:
    with pytest.raises(StateSpaceError, match=r"told\.response has more than 16,384"):
        cif_plant(plant_of(many(25)))


@needs_library
@pytest.mark.slow
def test_the_simulator_finds_a_path_by_some_of_the_values(monkeypatch: pytest.MonkeyPatch) -> None:
    player = session(pipeline.synthesize(robot_of(many(25, guards=True))))
    play(player, "goto Arm.busy")
    assert player.machine.state.components == {"Sensor": "full", "Arm": "busy"}
    monkeypatch.setattr(limits, "PATH_EVENTS", 1000)
    with pytest.raises(Refused, match="no path was found by trying 1,000 events"):
        play(player, "goto Sensor.empty and Arm.busy")


def data_events(seeds: range) -> Iterator[Event]:
    for seed in seeds:
        for event in plant_of(random_model(random.Random(seed), 3)).events:
            if event.parameters and len(list(valuations(event))) < 2000:
                yield event


def test_values_are_counted() -> None:
    events = list(data_events(range(20)))
    assert any(None in p.values for event in events for p in event.parameters)
    for event in events:
        assert weight(event) == len(list(valuations(event)))


def conditions_of(event: Event) -> list[Expr]:
    return [
        edge.guard
        for automaton in event.automata
        for edge in automaton.edges
        if edge.guard is not None
    ]


def test_choices_are_those_that_can_come() -> None:
    for event in data_events(range(20)):
        for read in [[], conditions_of(event)]:
            paths = {n.path for e in read for n in walk(e) if hasattr(n, "optional")}
            places = [(i, p.path) for i, p in enumerate(event.parameters) if p.path in paths]
            expected = dict.fromkeys(tuple(v[i] for i, _ in places) for v in valuations(event))
            found = [tuple(chosen[path] for _, path in places) for chosen in choices(event, read)]
            assert found == list(expected)


def test_conditions_are_taken_apart_exactly() -> None:
    looked = 0
    for seed in range(8):
        plant = plant_of(random_model(random.Random(seed), 3))
        stepper = Stepper(plant)
        for event in plant.events:
            for pair in combinations(conditions_of(event), 2):
                apart = for_some(event, pair, few=0)
                for state in states_of(plant):
                    expected = any(
                        all(stepper.holds(holds(one, chosen), state) for one in pair)
                        for chosen in choices(event, pair)
                    )
                    assert stepper.holds(apart, state) == expected
                    looked += len(apart.operands) if isinstance(apart, Operation) else 0
    assert looked


def states_of(plant: Plant) -> list[PlantState]:
    """Some states: all variables at one end of their values, or at random between them."""
    rng = random.Random(0)
    sizes = [variable.size for variable in plant.variables]
    ends = [tuple(0 for _ in sizes), tuple(size - 1 for size in sizes)]
    return [*ends, *(tuple(rng.randrange(size) for size in sizes) for _ in range(5))]
