"""Which engine ``auto`` takes: the one that is likely to be the faster."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import steep_families
from synthesis.plants import plant_of

from robosc.synthesis import compute, synthesize
from robosc.synthesis.bdd import synthesize as bdd_synthesize
from robosc.synthesis.bdd.symbolic_engine import SymbolicEngine
from robosc.synthesis.explicit.explicit_engine import Limit, ManyGuarded, TooMany
from robosc.synthesis.explicit.synthesize import ExplicitSynthesis
from robosc.synthesis.result import Solved

pytest.importorskip("oxidd", reason="the symbolic engine needs the Python package oxidd")


@pytest.mark.parametrize(
    ("family", "size", "engine"),
    [
        ("chain", (9,), "explicit"),  # 2^9 states
        ("chain", (16,), "bdd"),  # 2^16 states, a small diagram
        ("broad", (300,), "bdd"),  # 300 variables
        ("unrelated", (3,), "explicit"),
        ("allocation", (7,), "bdd"),  # 3,318 of 2^14 states, all commands restricted
        ("crew", (7,), "explicit"),
        ("crew", (10,), "bdd"),
        ("not_all_busy", (17,), "bdd"),
        ("gauges", (300,), "bdd"),
        ("readings", (30,), "bdd"),  # 27,000 combinations in one message
    ],
)
def test_auto_takes_the_better_engine(family: str, size: tuple[int, ...], engine: str) -> None:
    plant = plant_of(getattr(steep_families, family)(*size))
    assert synthesize(plant).engine == engine


def test_products_of_variables_are_no_obstacle_for_the_symbolic_engine() -> None:
    plant = plant_of(
        "component A { outgoing message m with type: integer(0..299)"
        " outgoing message n with type: integer(0..299) behaviour {"
        " variable x: integer(0..299) variable y: integer(0..299)"
        " initial marked state s { on response from m do x := value on response from n do y := value"
        " } } incoming message go with type: none }"
        " requirement go needs A.x * A.y < 1000"
    )
    assert synthesize(plant).engine == "bdd"


@pytest.mark.parametrize("name", ["crew", "allocation"])
def test_the_symbolic_engine_goes_on_after_the_turn_of_the_other(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant = plant_of(getattr(steep_families, name)(6))
    made: list[SymbolicEngine] = []
    turns: list[float] = []

    class Counted(SymbolicEngine):
        def __init__(self, *of: Any, **more: Any) -> None:
            made.append(self)
            super().__init__(*of, **more)

    def run(self: ExplicitSynthesis, limit: Limit, most_guarded: float) -> Solved:
        turns.append(most_guarded)
        raise ManyGuarded([]) if most_guarded > compute._FEW_GUARDED else TooMany("ended")

    monkeypatch.setattr(bdd_synthesize, "SymbolicEngine", Counted)
    monkeypatch.setattr(ExplicitSynthesis, "run", run)
    monkeypatch.setattr(compute, "_FEW_NODES", 1)
    found = synthesize(plant)
    assert len(made) == 1
    assert turns == [compute._FEW_GUARDED, compute._MOST_GUARDED]
    assert replace(found, seconds=0.0) == replace(synthesize(plant, "bdd"), seconds=0.0)
