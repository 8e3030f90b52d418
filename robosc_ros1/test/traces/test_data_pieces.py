"""Scripts show of which piece the data of commands are made, and what numbers do that are none."""

from __future__ import annotations

import math
from importlib.util import module_from_spec, spec_from_file_location
from typing import Any

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.scripted_controllers import scripts_of, tells_apart

from robosc.resources import templates_folder
from robosc.traces.scripts import choose

DRIVES = """robot Drives {
    datatype object Speed { x: double y: double z: boolean }
    component Seen {
        outgoing message near with type: double
        outgoing message turned with type: boolean
        behaviour {
            variable distance: double
            variable side: boolean
            on response from turned do side := value
            on response from near if !isnan(value) do distance := value
            initial marked state lost { on response from near if !isnan(value) goto found }
            marked state found { on response from near if isnan(value) goto lost }
        }
    }
    component Motor { incoming message move with type: Speed links speed }
    interface speed use Speed from some_package
    requirement move needs Seen.found
    provide move with {
        x: min(0.6, 0.8 * (Seen.distance - 0.5)) * max(0, 3.0 - Seen.distance),
        y: abs(Seen.distance - 1),
        z: Seen.distance > 2 and Seen.side
    }
}"""


def test_each_piece_is_shown_where_another_one_would_make_other_data() -> None:
    traces = choose(supervisor_of(DRIVES))
    pieces = {
        text: case in traces.shown for case, text in traces.cases.items() if case[0] == "piece"
    }
    assert len(pieces) == 2 + 2 + 2 + 2 * 2, "of min, max, abs, the condition and its comparison"
    assert all(pieces.values()), pieces


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (" 0.6,", " 0.77,"),
        ("0.8 * (", "0.9 * ("),
        ("greatest(0,", "greatest(-1,"),
        ("abs(", "("),
        (" and self.seen_side", " or self.seen_side"),
    ],
)
def test_a_fault_in_a_piece_is_found(right: str, wrong: str) -> None:
    supervisor = supervisor_of(DRIVES)
    source = controller_source(supervisor)
    assert source.count(right) == 1, source
    assert tells_apart(supervisor, scripts_of(supervisor), source.replace(right, wrong))


def test_data_of_what_nothing_lets_pass_are_proved_unreachable() -> None:
    """In lost, no move is sent, whatever its data would be."""
    only_lost = DRIVES.replace(
        "z: Seen.distance > 2 and Seen.side\n    }", "z: Seen.side } if Seen.lost"
    )
    assert only_lost != DRIVES
    traces = choose(supervisor_of(only_lost))
    given = {case for case in traces.cases if case[0] == "provided"}
    assert given
    assert given <= traces.proved


def test_a_state_to_which_only_nan_leads_is_shown() -> None:
    traces = choose(supervisor_of(DRIVES))
    back = [
        case for case, text in traces.cases.items() if "to lost)" in text and case[0] == "taken"
    ]
    assert back
    assert traces.shown.issuperset(back)


@pytest.mark.parametrize(
    ("told", "wanted", "expected"),
    [
        (math.nan, math.nan, True),
        (1.0, math.nan, False),
        (math.nan, 1.0, False),
        (math.inf, math.inf, True),
        (-math.inf, math.inf, False),
        (1.0, math.inf, False),
        (math.inf, 1.0, False),
        (None, math.nan, False),
        (None, 1.0, False),
        (0.1 + 1e-8, 0.1, True),
        (0.2, 0.1, False),
        ([math.nan, 1.0], [math.nan, 1], True),
        ({"x": math.nan, "y": 1}, {"x": math.nan}, True),
        ({"x": 0.0}, {"x": math.nan}, False),
    ],
)
def test_what_a_player_takes_for_the_same(told: Any, wanted: Any, expected: bool) -> None:
    path = templates_folder() / "common" / "test" / "scripts.py"
    spec = spec_from_file_location("scripts_of_packages", path)
    assert spec is not None and spec.loader is not None
    module: Any = module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.same(told, wanted) is expected
