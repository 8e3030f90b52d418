"""``sector``: the rays of a scan between two angles, as they are found by asking each ray."""

from __future__ import annotations

import math
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from language.test_columns_of_the_tables import MEANING
from model.model_text import behaviour_of, faults, resolve

from robosc.expr.evaluation import evaluate
from robosc.plant.model_text import to_dsl
from robosc.runtime.core.functions import sector

MODEL = """
datatype object Scan { ranges: array(double) angle_min: double angle_increment: double n: integer }
datatype object Both { front: Scan scans: array(Scan) }
interface scan use Scan from example_msgs
interface both use Both from example_msgs
parameter half: double = 0.5
component P {
    outgoing message scan with type: Scan links scan
    outgoing message both with type: Both links both
    behaviour {
        variable last: Scan
        variable number: double
        initial marked state s { on response from %s do %s }
    }
}
"""
scans = st.builds(
    lambda count, start, step: (list(range(count)), start, step),
    st.integers(0, 40),
    st.floats(-7, 7),
    st.one_of(
        st.floats(-1, 1).filter(lambda step: step == 0 or abs(step) > 1e-3),
        st.sampled_from([s * 2 * math.pi / n for n in (8, 12, 36, 39, 40) for s in (1, -1)]),
    ),
)
angles = st.one_of(st.floats(-10, 10), st.sampled_from([0.0, math.pi / 2, math.pi, -math.pi / 6]))


def is_near(value: float) -> bool:
    return abs(value - round(value)) < 0.01


@given(scans, angles, angles)
def test_a_sector_has_the_rays_between_its_angles(
    scan: tuple[list[int], float, float], first: float, last: float
) -> None:
    _, start, step = scan
    expected = MEANING["sector"](*scan, first, last)
    found = sector(*scan, first, last)
    if sorted(found) != sorted(expected):
        # Only of rays that are a thousandth of a step from an end rounding may decide.
        ends = [(a - start) / step for a in (first, last)]
        turn = 2 * math.pi / step
        for ray in {*found} ^ {*expected}:
            off = [(end - ray) % abs(turn) for end in ends]
            assert any(abs(min(o, abs(turn) - o) - 1e-3) < 1e-6 for o in off)
    assert len(set(found)) == len(found)
    for before, behind in pairwise(found):
        turned = ((start + step * behind) - (start + step * before)) % (2 * math.pi)
        assert turned < 2 * math.pi - 2e-3 * abs(step) or is_near(turned / (2 * math.pi))


@pytest.mark.parametrize(
    ("first", "last", "found"),
    [
        (-math.pi / 2, math.pi / 2, [9, 10, 11, 0, 1, 2, 3]),  # over the end of a full turn
        (5 * math.pi / 6, -5 * math.pi / 6, [5, 6, 7]),  # behind the robot
        (0.0, 0.0, [0]),
        (0.1, 0.2, []),
        (0.0, 2 * math.pi, [*range(12)]),
        (-math.pi, math.pi, [6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5]),
        (math.nan, 1.0, []),
    ],
)
def test_a_scan_of_a_full_turn(first: float, last: float, found: list[int]) -> None:
    assert sector([*range(12)], 0.0, math.pi / 6, first, last) == found


def test_a_scan_whose_last_ray_is_its_first_has_both() -> None:
    """As simulators make them: 13 rays from 0 to 2 pi."""
    assert sector([*range(13)], 0.0, math.pi / 6, -0.6, 0.6) == [11, 12, 0, 1]


def test_a_scan_to_one_side_ends_there() -> None:
    assert sector([*range(7)], -math.pi / 2, math.pi / 6, -math.pi, -math.pi / 3) == [0, 1]
    # From the left to the right, as some scanners turn; its sectors begin on the right, too.
    assert sector([*range(7)], math.pi / 2, -math.pi / 6, -0.6, 0.0) == [4, 3]


def test_single_precision_does_not_move_the_ends() -> None:
    step = 0.017453292384743690  # one degree as float32
    assert len(sector([1.0] * 360, 0.0, step, -math.radians(30), math.radians(30))) == 61


def assigned(source: str, text: str) -> Any:
    robot = resolve(MODEL % (source, f"number := {text}"))
    (transition,) = behaviour_of(robot, "P").states[0].transitions
    value = transition.assignments[0].value
    assert to_dsl(value, robot) == text
    return value


@pytest.mark.parametrize(
    ("source", "text", "found"),
    [
        ("scan", "min(r for r in sector(value, -0.5, 0.5))", 3),
        ("scan", "min(r for r in sector(value, -half, value.n))", 3),
        ("both", "length(sector(value.front, -0.5, 0.5))", 3),
        ("both", "length(sector(value.scans[1], -0.5, 0.5)) + 1", 4),
        ("both", "max(length(sector(s, i - 9, 9.5)) for i, s in value.scans)", 9),
        ("scan", "first(i for i, r in sector(value, 0, 1) if r > 5)", 2),
    ],
)
def test_a_sector_of_any_scan(source: str, text: str, found: float) -> None:
    scan = SimpleNamespace(ranges=[*range(9)], angle_min=-2.0, angle_increment=0.5, n=1)
    value = scan if source == "scan" else SimpleNamespace(front=scan, scans=[scan, scan])

    def look(leaf: Any) -> Any:
        part: Any = value
        for step in leaf.path:
            part = getattr(part, step) if isinstance(step, str) else part[step]
        return part

    assert evaluate(assigned(source, text), look) == found


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("length(sector(value))", ("type-mismatch", "sector(value)")),
        ("length(sector(value.ranges, 0, 1))", ("type-mismatch", "value.ranges")),
        ("length(sector(value, 0, true))", ("type-mismatch", "true")),
        ("length(sector(last, 0, 1))", None),
        ("sector(value, 0, 1)", ("type-mismatch", "sector(value, 0, 1)")),
    ],
)
def test_a_sector_needs_a_scan_and_two_angles(text: str, fault: tuple[str, str] | None) -> None:
    found = faults(MODEL % ("scan", f"number := {text}"))
    left_out = ("unused", "package", "unread")
    assert [f for f in found if not f[0].startswith(left_out)] == ([] if fault is None else [fault])
