"""In the order of the variables, what passes something on comes after what waits for it; of its two
directions the one is taken that begins with far fewer nodes; verification begins so. Components
stay together where that takes far fewer, too."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from dataclasses import replace

import pytest
from published_families import cells
from random_models import random_model
from robot_families import chargers, halls, riders
from synthesis.differential import differences
from synthesis.plants import plant_of
from synthesis.subject import oracle_of

from robosc.model.resolve import load
from robosc.plant.automaton import Plant, PlantState
from robosc.plant.build import lower
from robosc.source import Source
from robosc.synthesis import synthesize
from robosc.synthesis.bdd import manager
from robosc.synthesis.bdd import synthesize as bdd_synthesize
from robosc.synthesis.bdd.encoding import Encoding
from robosc.synthesis.bdd.rounds import first_rounds
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine, SymbolicSolution, TooManyNodes
from robosc.synthesis.verify import state_sets, symbolic

STATIONS = 8


def line(stations: Iterable[int]) -> Plant:
    """A line in which each station takes from the buffer before it, declared in some order."""
    parts = []
    for n in stations:
        taken = "do level := level - 1" if n else ""
        parts.append(f"""
  component Machine{n} {{
    incoming message start{n} with type: none
    outgoing message end{n} with type: none
    behaviour {{
      initial marked state idle {{ on request to start{n} goto busy }}
      state busy {{ on response from end{n} goto idle }}
    }}
  }}
  component Buffer{n} {{
    behaviour {{
      variable level: integer(0..3) = 0
      initial marked state s {{
        on request to start{n} {taken}
        {f"on response from end{n - 1} if Machine{n - 1}.busy do level := level + 1" if n else ""}
      }}
    }}
  }}""")
        if n:
            parts.append(f"\n  requirement start{n} needs Buffer{n}.level > 0")
    robot, diagnostics = load(Source("line.rscd", f"robot Line {{{''.join(parts)}\n}}\n"))
    assert robot is not None, diagnostics
    return lower(robot)


@pytest.mark.skipif(
    not manager.available(), reason="the symbolic engine needs the Python package oxidd"
)
@pytest.mark.parametrize("stations", [range(STATIONS), range(STATIONS)[::-1]])
def test_the_first_station_of_a_line_comes_last(stations: Iterable[int]) -> None:
    plant = line(stations)
    encoding = Encoding(plant, 2**26)
    names = {variable.name: encoding.place(n) for n, variable in enumerate(plant.variables)}
    places = [names[f"Machine{n}"] for n in range(STATIONS)]
    assert places == sorted(places, reverse=True)


def test_rounds_follow_the_line() -> None:
    plant = line(range(STATIONS))
    rounds = {plant.variables[n].name: number for n, number in first_rounds(plant).items()}
    assert [rounds[f"Machine{n}"] for n in range(STATIONS)] == [2 * n + 1 for n in range(STATIONS)]
    assert [rounds[f"Buffer{n}.level"] for n in range(1, STATIONS)] == [
        2 * n for n in range(1, STATIONS)
    ]


def test_what_never_changes_has_no_round() -> None:
    text = """
robot Still {
  component Lamp {
    incoming message blink with type: none
    behaviour {
      initial marked state off { on request to blink if false goto lit }
      state lit { on request to blink goto off }
    }
  }
}
"""
    robot, _ = load(Source("still.rscd", text))
    assert robot is not None
    assert first_rounds(lower(robot)) == {}


@pytest.mark.parametrize(("most_nodes", "far"), [(0, 3), (2**9, 3), (2**9, 0.01)])
def test_another_direction_is_the_same_system(
    most_nodes: int, far: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In reverse alone; and given up, in one direction or in both, at few nodes; and taken for what
    it begins with."""
    for seed in range(500, 508):
        oracle = oracle_of(random_model(random.Random(seed), 1 + seed % 2))
        with monkeypatch.context() as reverse:
            reverse.setattr(
                bdd_synthesize,
                "SymbolicEngine",
                lambda *args, **options: SymbolicEngine(*args, **{**options, "reverse": True}),
            )
            assert differences(oracle.robot, oracle, "bdd") == [], seed
        with monkeypatch.context() as few:
            few.setattr(bdd_synthesize, "_MANY_NODES", most_nodes)
            few.setattr(bdd_synthesize, "_FAR", far)
            few.setattr(bdd_synthesize, "_SLOW_START", 0)
            few.setattr(manager, "_AMPLE_NODES", 0)
            assert differences(oracle.robot, oracle, "bdd") == [], seed


def directions(monkeypatch: pytest.MonkeyPatch, failing: int) -> list[bool]:
    """Of each engine that is to solve a system whether its order is the opposite; so many fail."""
    begun: list[bool] = []

    class Engine(SymbolicEngine):
        def solve(self, found: Sequence[PlantState] | None = None) -> SymbolicSolution:
            begun.append(self.opposite_order)
            if len(begun) <= failing:
                raise TooManyNodes
            return super().solve(found)

    monkeypatch.setattr(bdd_synthesize, "SymbolicEngine", Engine)
    return begun


def test_the_direction_that_begins_with_far_fewer_nodes_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The calls of a hall with lifts, above these, take ten times the nodes of the opposite."""
    begun = directions(monkeypatch, 0)
    assert synthesize(plant_of(halls(3, 6)), "bdd").opposite_order
    assert begun == [True]


def test_components_stay_together_where_that_begins_with_far_fewer_nodes() -> None:
    """What nine robots reach, which do not depend on each other but by requirements."""
    plant = plant_of(chargers(9, 2))
    solution = bdd_synthesize._solved(plant, None, 2**28, None)
    assert solution.engine.together
    assert solution.engine.manager.made < 2**16
    usual = SymbolicEngine(plant).solve()
    assert usual.engine.manager.made > 2**18
    assert solution.controlled_states == usual.controlled_states


def test_a_direction_that_begins_with_far_more_nodes_is_not_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of three cells in a row it takes six times as many."""
    begun = directions(monkeypatch, 1)
    synthesize(plant_of(cells(3, 2)), "bdd", explain_seconds=0)
    assert begun == [False, False]


def test_what_takes_too_many_nodes_is_not_compiled_as_a_whole() -> None:
    with pytest.raises(TooManyNodes):
        SymbolicEngine(plant_of(cells(3, 2)), most_made=500)


def test_verification_begins_where_synthesis_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Riders and a lift take more than these nodes in the one order only."""
    with monkeypatch.context() as few:
        few.setattr(bdd_synthesize, "_MANY_NODES", 2**14)
        few.setattr(manager, "_AMPLE_NODES", 0)
        supervisor = synthesize(plant_of(riders(6, 4)), "bdd")
    assert supervisor.opposite_order
    begun = []

    def sets(plant: Plant, reverse: bool) -> state_sets.StateSets:
        begun.append(reverse)
        return state_sets.StateSets(plant, reverse)

    monkeypatch.setattr(symbolic, "StateSets", sets)
    assert symbolic.search_by_sets(supervisor).states == supervisor.controlled_states
    assert begun == [True]


def test_verification_in_the_opposite_order_finds_the_same() -> None:
    for seed in range(520, 528):
        oracle = oracle_of(random_model(random.Random(seed), 1 + seed % 2))
        supervisor = synthesize(lower(oracle.robot))
        usual = symbolic.search_by_sets(supervisor)
        assert symbolic.search_by_sets(replace(supervisor, opposite_order=True)) == usual, seed
