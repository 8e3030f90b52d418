"""The explicit engine goes on where a limit ended it, and finds what it finds without one."""

from __future__ import annotations

from dataclasses import replace

import pytest
from robot_families import track, zones
from synthesis.plants import plant_of

from robosc.synthesis.explicit.explicit_engine import TooMany
from robosc.synthesis.explicit.synthesize import ExplicitSynthesis


@pytest.mark.parametrize("model", [zones(4, 8), track(3, 7)])
def test_where_it_was_ended(model: str) -> None:
    plant = plant_of(model)
    whole = ExplicitSynthesis(plant).run(lambda found, left, steps: None).supervisor
    piecewise = ExplicitSynthesis(plant)
    asked: list[int] = []

    def limit(found: int, left: int, steps: int) -> None:
        asked.append(steps)
        if len(asked) % 2 == 0:
            raise TooMany("ended")

    for _ in range(3):
        with pytest.raises(TooMany):
            piecewise.run(limit)
    start, *ends = asked
    assert start == 0 < ends[0] == ends[1] < ends[2] == ends[3] < ends[4]
    supervisor = piecewise.run(lambda found, left, steps: None).supervisor
    assert replace(supervisor, seconds=whole.seconds) == whole
