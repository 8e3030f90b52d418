"""Scripts show where sections of arrays begin and end: in what is assigned, and in guards."""

from __future__ import annotations

import re

import pytest
from emit.generated_code import controller_source, supervisor_of
from emit.scripted_controllers import scripts_of, tells_apart

from robosc.traces.scripts import choose

LOOKS = """robot Looks {
    datatype object Scan { ranges: array(double) }
    component Laser {
        outgoing message scan with type: Scan links scan
        behaviour {
            variable front: double
            initial marked state on {
                on response from scan do front := min(r for r in value.ranges[-8..5] if r < 9) else 0
            }
        }
    }
    component Side {
        outgoing message side with type: Scan links side
        behaviour {
            initial marked state clear {
                on response from side if max(r for r in value.ranges[2..3]) < 0.5 goto near
            }
            marked state near { on response from side goto clear }
        }
    }
    component Motor { incoming message move with type: none links move }
    interface scan use Scan from some_package
    interface side use Scan from some_package
    interface move use Move from some_package
    requirement move needs Laser.front > 0.35 and Side.clear
}"""


def test_each_end_is_shown_from_within_and_from_outside() -> None:
    traces = choose(supervisor_of(LOOKS))
    ends = {text: case in traces.shown for case, text in traces.cases.items() if case[0] == "end"}
    assert len(ends) == 4 + 4
    assert all(ends.values()), [text for text, shown in ends.items() if not shown]
    assert any("the element before value.ranges[-8..5] does not count" in text for text in ends)


@pytest.mark.parametrize("by", [-1, 1])
@pytest.mark.parametrize(
    "end", [(first, last, which) for first, last in [(-8, 5), (2, 3)] for which in (0, 1)]
)
def test_an_end_elsewhere_is_found(end: tuple[int, int, int], by: int) -> None:
    supervisor = supervisor_of(LOOKS)
    source = controller_source(supervisor)
    first, last, which = end
    right = f", {first}, {last})"
    wrong = f", {first + by * (which == 0)}, {last + by * (which == 1)})"
    assert right in source
    assert tells_apart(supervisor, scripts_of(supervisor), source.replace(right, wrong))


def test_a_number_beside_which_elements_count_is_shown() -> None:
    traces = choose(supervisor_of(LOOKS))
    near = {case in traces.shown for case, text in traces.cases.items() if re.search("r < 9", text)}
    assert near == {True}


SWEEPS = LOOKS.replace("ranges: array(double) }", """ranges: array(double)
        angle_min: double angle_increment: double range_min: double range_max: double }""").replace(
    "value.ranges[-8..5]", "sector(value, -0.6, 0.55)"
)  # fmt: skip


def test_ends_of_sectors_are_shown_by_single_rays() -> None:
    supervisor = supervisor_of(SWEEPS)
    traces = choose(supervisor)
    ends = {text: case in traces.shown for case, text in traces.cases.items() if case[0] == "end"}
    assert len(ends) == 4 + 4
    assert all(ends.values()), [text for text, shown in ends.items() if not shown]
    source = controller_source(supervisor)
    for right, wrong in ((" -0.6,", " -0.1,"), (" 0.55,", " 1.05,")):
        assert source.count(right) == 1, source
        assert tells_apart(supervisor, scripts_of(supervisor), source.replace(right, wrong))


BUMPS = """robot Bumps {
    component Base {
        outgoing message bumper with type: integer, timeout: 0.5 s links bumper
        behaviour {
            variable left: boolean
            initial marked state clear { on response from bumper do left := has(value, 4) goto bumped }
            marked state bumped { after 1 s goto clear }
        }
    }
    component Motor { incoming message back with type: boolean links back }
    interface bumper use Bumper from some_package
    interface back use Back from some_package
    requirement back needs bumper.fresh and Base.bumped
    provide back with Base.left
}"""


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (", 4)", ", 5)"),
        (", 4)", ", 6)"),
        # The message is silent before the delay is over, as on the robot.
        ('return self.bumper_fresh and self.base == "bumped"', 'return self.base == "bumped"'),
    ],
)
def test_bits_and_times_beside_those_of_the_model_are_found(right: str, wrong: str) -> None:
    supervisor = supervisor_of(BUMPS)
    source = controller_source(supervisor)
    assert right in source, source
    assert tells_apart(supervisor, scripts_of(supervisor), source.replace(right, wrong))
