"""The engine's shortcuts for large models, forced upon small ones: nothing may change.

Small robots never need stages, cases, cuts or folding. Here the thresholds are lowered until
everything takes those ways, alone and together.
"""

from __future__ import annotations

import random

import pytest
from random_models import random_model
from synthesis.explored import explore_document
from synthesis.subject import oracle_of

from robosc.plant.build import lower
from robosc.synthesis import compute, explore, synthesize
from robosc.synthesis.dense import image_stages, layout, operations, transitions

pytestmark = pytest.mark.slow

VARIANTS = {
    "automata in turn": [(image_stages, "_MOST_CHOICES", 1)],
    "conditions in cases": [(transitions, "_WIDE", 1)],
    "dependent state variables folded": [(compute, "_SMALL", 0)],
    "operations in small parts": [
        (operations, "_LARGEST_STEP", 2),
        (operations, "_WORTH_UNROLLING", 1),
        (layout, "_LARGEST_GRID", 3),
    ],
    "nothing packed": [(layout, "_packed", lambda sizes: ())],
}
VARIANTS["all of that"] = [change for changes in VARIANTS.values() for change in changes]
VARIANTS["all but unpacked"] = VARIANTS["all of that"][:-1]


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("first", [7000, 7030, 7060, 7080])
def test_variant(variant: str, first: int, monkeypatch: pytest.MonkeyPatch) -> None:
    for module, name, value in VARIANTS[variant]:
        monkeypatch.setattr(module, name, value)
    for seed in range(first, first + 9):
        oracle = oracle_of(random_model(random.Random(seed), 1 + seed % 2))
        found = synthesize(lower(oracle.robot), "dense")
        states, steps = oracle.controlled
        assert found.plant_states == len(oracle.plant[0]), seed
        assert found.controlled_states == len(states), seed
        assert found.controlled_transitions == len(steps), seed
        walked = explore_document(explore(found))
        assert len(walked["states"]) == len(states), seed
        assert len(walked["transitions"]) == len(steps), seed
