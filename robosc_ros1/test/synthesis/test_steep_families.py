"""Models that are steep for one engine: both agree with the oracle, and their guards stay short."""

from __future__ import annotations

import random

import pytest
import robot_families
import steep_families
from random_models import random_model
from synthesis.differential import ENGINES, differences
from synthesis.plants import plant_of
from synthesis.subject import oracle_of, robot_of

from robosc.plant.model_text import to_dsl
from robosc.synthesis import synthesize
from robosc.synthesis.guards import shorten

SMALL = {
    "allocation": (4,),
    "battery_swaps": (1,),
    "broad": (4,),
    "budget": (3, 4),
    "cat_and_mouse": (5, 2),
    "chain": (6,),
    "cluster_tool": (2,),
    "conveyor": (7,),
    "corridor_mesh": (2, 3),
    "crew": (4,),
    "elevator": (3,),
    "gauges": (14,),
    "not_all_busy": (6,),
    "one_tool_each": (3, 2),
    "priorities": (4,),
    "readings": (4,),
    "restless": (3,),
    "road": (3, 1),
    "tanks": (6,),
    "token": (5,),
    "two_tools_each": (2,),
    "unrelated": (2,),
}


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("family", SMALL)
def test_engines_agree_with_the_oracle(family: str, engine: str) -> None:
    oracle = oracle_of(getattr(steep_families, family)(*SMALL[family]))
    assert differences(oracle.robot, oracle, engine) == []


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
@pytest.mark.parametrize(
    ("family", "size", "longest"),
    [
        ("not_all_busy", (14,), 240),  # an array of one dimension per machine is too much
        ("token", (18,), 20),  # !Place17.have, rather than all the other places
        ("budget", (5, 7), 80),  # the requirement's own words
        ("crew", (8,), 140),
        ("conveyor", (12,), 40),  # what the requirements demand after the next response
        # 4,356 combinations that the requirements' own words tell
        pytest.param("tanks", (66,), 70, marks=pytest.mark.slow),
    ],
)
def test_guards_are_short(family: str, size: tuple[int, ...], longest: int, engine: str) -> None:
    text = getattr(steep_families, family)(*size)
    robot = robot_of(text)
    guards = [to_dsl(guard.expr, robot) for guard in synthesize(plant_of(text), engine).guards]
    assert max(map(len, guards)) <= longest


UNTUNED = {
    "dining": (3,),
    "grid": (2, 2, 3),
    "halls": (2, 2),
    "lift": (3, 1),
    "quotas": (4, 1),
    "ring": (3, 2),
    "served_copies": (4, 2),
    "warehouse": (3, 2),
}


def test_where_there_are_very_many_cases_what_a_guard_can_do_without_is_not_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def asked(*_: object) -> None:
        raise AssertionError("the precondition is the guard")

    monkeypatch.setattr(shorten, "_pruned", asked)
    for engine in ("explicit", "bdd"):
        supervisor = synthesize(plant_of(robot_families.grid(3, 3, 4)), engine)
        said = {g.event.name: to_dsl(g.expr, supervisor.plant.robot) for g in supervisor.guards}
        assert said["north2"] == (
            "!(Bot2.x = Bot0.x and Bot2.y + 1 = Bot0.y)"
            " and !(Bot2.x = Bot1.x and Bot2.y + 1 = Bot1.y)"
            " and !(Bot3.x = Bot2.x and Bot3.y = Bot2.y + 1)"
        )


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("family", UNTUNED)
def test_engines_agree_with_the_oracle_on_families_that_none_was_tuned_for(
    family: str, engine: str
) -> None:
    oracle = oracle_of(getattr(robot_families, family)(*UNTUNED[family]))
    assert differences(oracle.robot, oracle, engine) == []


@pytest.mark.parametrize(("engine", "n"), [("explicit", 5), ("bdd", 12)])
def test_guards_count_what_uncontrollable_events_may_bring_into_the_counted_state(
    engine: str, n: int
) -> None:
    text = robot_families.quotas(n, 2)
    robot = robot_of(text)
    assert [to_dsl(guard.expr, robot) for guard in synthesize(plant_of(text), engine).guards] == [
        f"User[{i}].used <= 2 and (User[{i}].used != 1 or count(u.used >= 2 for u in User) < 2)"
        for i in range(1, n + 1)
    ]


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_guards_count_what_uncontrollable_events_cannot_take_away(engine: str) -> None:
    text = """robot Lamps {
  component Lamp[1..7] {
    incoming message dim with identifier: "/l{index}/dim", type: none
    outgoing message fade with identifier: "/l{index}/fade", type: none
    behaviour {
      initial marked state on { on request to dim goto low }
      marked state low { on response from fade goto off }
      marked state off {}
    }
  }
  requirement always count(!l.off for l in Lamp) >= 3
}
"""
    robot = robot_of(text)
    found = {to_dsl(guard.expr, robot) for guard in synthesize(plant_of(text), engine).guards}
    assert found == {"count(l.on for l in Lamp) >= 4"}


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_guards_looked_for_in_every_way_are_exact(
    engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shorten, "_LONG", 0)
    for seed in range(300, 316):
        oracle = oracle_of(random_model(random.Random(seed), 1 + seed % 2))
        assert differences(oracle.robot, oracle, engine) == [], seed


@pytest.mark.parametrize("n", [20, 50])
def test_a_count_of_many_is_found_without_writing_out_its_cases(n: int) -> None:
    """With a requirement beside it, whose guard anew would have millions of products."""
    text = f"""robot Couriers {{
  component Bot[1..{n}] {{
    incoming message go with identifier: "/r{{index}}/go", type: none
    outgoing message there with identifier: "/r{{index}}/there", type: none
    outgoing message battery with identifier: "/r{{index}}/battery", type: boolean
    behaviour {{
      variable charged: boolean = false
      on response from battery do charged := value
      initial marked state rests {{ on request to go goto drives }}
      marked state drives {{ on response from there goto rests }}
    }}
    requirement go needs charged
  }}
  requirement always count(b.drives for b in Bot) <= 5
}}
"""
    robot = robot_of(text)
    found = {to_dsl(guard.expr, robot) for guard in synthesize(plant_of(text), "bdd").guards}
    count = "count(b.drives for b in Bot) < 5"
    assert found == {f"Bot[{i}].charged and {count}" for i in range(1, n + 1)}
