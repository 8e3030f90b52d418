"""What a count is expanded into shares its parts: each is computed once, and stays shared."""

from __future__ import annotations

from dataclasses import replace

import pytest
from synthesis.plants import plant_of

from robosc import limits
from robosc.expr import traversal, tree
from robosc.plant import logic
from robosc.plant.automaton import Plant
from robosc.plant.data.builder import ViewBuilder
from robosc.synthesis.bdd import encoding
from robosc.synthesis.bdd.manager import available


def fleet(n: int) -> Plant:
    return plant_of(f"""robot Fleet {{
        component Bot[1..{n}] {{
            outgoing message charge with identifier: "/r{{index}}/charge", type: double
            outgoing message order with identifier: "/r{{index}}/order", type: none
            incoming message drive with identifier: "/r{{index}}/drive", type: none
            behaviour {{
                variable charged: double
                on response from charge do charged := value
                initial marked state here {{ on request to drive goto there }}
                state there {{ on response from order goto here }}
            }}
            requirement drive needs charged > 0.15
        }}
        requirement always count(b.there for b in Bot) <= 5
    }}""")


def parts(expr: tree.Expr) -> int:
    """The different parts, by identity."""
    return len(list(traversal.walk_all([expr])))


@pytest.fixture(scope="module")
def count() -> tree.Expr:
    ((condition, _),) = fleet(25).invariants
    assert len(list(traversal.walk(condition))) > 5 * parts(condition)
    return condition


def test_rewritten_parts_stay_shared(count: tree.Expr) -> None:
    def leaf(node: tree.Literal | tree.Leaf) -> tree.Expr:
        return replace(node, component="Other") if isinstance(node, tree.StateRef) else node

    made = traversal.rewritten(count, leaf)
    assert made != count
    assert len(list(traversal.walk(made))) == len(list(traversal.walk(count)))
    # A leaf that is replaced is one for each place in which it stands.
    assert parts(made) <= 2 * parts(count)


def test_simplified_parts_stay_shared(count: tree.Expr) -> None:
    assert logic.simplified(count) == count
    assert parts(logic.simplified(count)) <= 2 * parts(count)


@pytest.mark.skipif(not available(), reason="the symbolic engine needs the Python package oxidd")
def test_sets_of_shared_parts_are_computed_once(
    count: tree.Expr, monkeypatch: pytest.MonkeyPatch
) -> None:
    computed = 0
    combined = encoding.combined

    def counted(*of: object) -> object:
        nonlocal computed
        computed += 1
        return combined(*of)  # type: ignore[arg-type]

    monkeypatch.setattr(encoding, "combined", counted)
    encoding.Encoding(fleet(25), limits.MEMORY).holds(count)
    assert 0 < computed <= parts(count)


def test_tests_of_data_look_at_what_assigns_their_variables(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked = 0
    update = ViewBuilder._update

    def counted(self: ViewBuilder, *of: object) -> object:
        nonlocal looked
        looked += 1
        return update(self, *of)  # type: ignore[arg-type]

    monkeypatch.setattr(ViewBuilder, "_update", counted)
    fleet(6)
    few, looked = looked, 0
    fleet(12)
    assert few > 0 and looked == 2 * few
