"""Both engines against libFAUDES: the same systems as automata, composed, and SupCon."""

from __future__ import annotations

from importlib.util import find_spec

import families
import pytest
import steep_families
from bench.synthesis_bench import synthesize_with_faudes
from synthesis.plants import plant_of

from robosc.synthesis import synthesize
from robosc.synthesis.bdd.manager import available

pytestmark = pytest.mark.skipif(
    find_spec("faudes") is None, reason="the comparison needs the Python package faudes"
)

ENGINES = ["explicit", "bdd"] if available() else ["explicit"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "text",
    [
        families.hands(3),
        families.services_hands(3),
        families.transfer_line(3, 2),
        families.transfer_line(4, 1),
        families.action_robot(2),
        families.philosophers(4),
        steep_families.cluster_tool(2),
        steep_families.elevator(3),
        steep_families.road(3, 1),
    ],
    ids=[
        "hands",
        "services",
        "line",
        "short line",
        "actions",
        "philosophers",
        "cluster tool",
        "elevator",
        "road",
    ],
)
def test_counts(engine: str, text: str) -> None:
    plant = plant_of(text)
    theirs, ours = synthesize_with_faudes(plant), synthesize(plant, engine)
    assert ours.controlled_states == theirs["states"]
    assert ours.controlled_transitions == theirs["transitions"]
