"""The verifier's closures are those of the plainest iteration, and stop in time."""

from __future__ import annotations

import random
import sys
from functools import partial

import pytest
import steep_families
from random_models import random_model
from synthesis.plants import plant_of, supervisor_of

from robosc.errors import StateSpaceError
from robosc.synthesis.bdd.manager import Bdd, Manager
from robosc.synthesis.verify import closures
from robosc.synthesis.verify.closures import Arrow, Closure, place_of
from robosc.synthesis.verify.state_sets import Relation, StateSets
from robosc.synthesis.verify.symbolic import search_by_sets
from robosc.synthesis.verify.verification import verify

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")


def arrows_of(sets: StateSets, forward: bool) -> list[Arrow]:
    def after(relation: Relation, states: Bdd) -> Bdd:
        found = sets.manager.and_exists(states, relation.steps, relation.now)
        return sets.manager.rename(found, relation.forward)

    def before(relation: Relation, states: Bdd) -> Bdd:
        renamed = sets.manager.rename(states, relation.backward)
        return sets.manager.and_exists(renamed, relation.steps, relation.after)

    return [
        (min(map(place_of, (r.steps, r.now, r.after))), partial(after if forward else before, r))
        for r in sets.relations
    ]


def iterated(arrows: list[Arrow], states: Bdd, inside: Bdd) -> Bdd:
    while True:
        before = states
        for _, take in arrows:
            states = states | (take(before) & inside)
        if states == before:
            return states


@pytest.mark.parametrize("seed", range(30))
def test_closures_are_those_of_iteration(seed: int) -> None:
    """Forwards and backwards, from any set and inside any set."""
    chance = random.Random(seed)
    sets = StateSets(plant_of(random_model(chance, 1 + seed % 3)))
    some = [sets.initial, sets.marked, sets.manager.true]
    some += [relation.possible for relation in sets.relations]
    for forward in (True, False):
        arrows = arrows_of(sets, forward)
        for _ in range(5):
            states, inside = chance.choice(some), chance.choice([*some, ~chance.choice(some)])
            found = Closure(sets.manager, arrows).of(states & inside, inside)
            assert found == iterated(arrows, states & inside, inside)


def test_what_is_remembered_may_be_forgotten_at_any_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closures, "_MOST_REMEMBERED", 1)
    monkeypatch.setattr(Manager, "nodes", property(lambda manager: manager.capacity))
    assert verify(supervisor_of(steep_families.crew(4), "bdd"), limit=0).verified


DEPTH = 300
"""More than the tests themselves need."""


def test_more_variables_than_python_can_recurse() -> None:
    count = 2 * DEPTH
    components = "".join(
        f"component C{i} {{ outgoing message m{i} with type: none behaviour {{"
        f" initial marked state a {{ on response from m{i} goto b }}"
        f" marked state b {{ on response from m{i} goto a }} }} }}\n"
        for i in range(count)
    )
    sets = StateSets(plant_of(f"robot R {{ {components} }}"))
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(DEPTH)
    try:
        found = Closure(sets.manager, arrows_of(sets, True)).of(sets.initial, sets.manager.true)
        assert sets.count(found) == 2**count
    finally:
        sys.setrecursionlimit(limit)


def test_a_proof_that_takes_too_long_is_given_up() -> None:
    supervisor = supervisor_of(steep_families.crew(5), "bdd")
    with pytest.raises(StateSpaceError, match="verification stops after 0 s"):
        verify(supervisor, limit=0, seconds=0)


def test_the_proof_tells_its_progress() -> None:
    told: list[str] = []
    supervisor = supervisor_of(steep_families.crew(5), "bdd")
    search_by_sets(supervisor, lambda what, done, most: told.append(what))
    assert set(told) == {"verification"}
