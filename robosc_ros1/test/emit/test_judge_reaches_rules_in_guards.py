"""Rules in guards, transitions that are taken together, and numbers without end beside them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from emit.judged_controllers import Robot, judged, judging_model

pytestmark = pytest.mark.slow

TOGETHER = """
robot Together {
    component Eye {
        outgoing message scan with identifier: "/scan", type: sensor_msgs/LaserScan
        outgoing message odom with identifier: "/odom", type: nav_msgs/Odometry
        service turn with identifier: "/turn", type: std_srvs/Trigger
        behaviour {
            variable side: double
            variable x: double
            on response from scan do side := min(r for r in value.ranges[50..60])
            on response from odom do x := value.pose.pose.position.x
            initial marked state free {
                on response from scan if Sight(value) = near goto blocked
            }
            state blocked {
                on request to turn
                on response from turn goto free
                on error from turn goto stuck
            }
            marked state stuck {
                on response from scan if Sight(value) = far goto blocked
                on response from odom if value.pose.pose.position.x > x + 2 goto free
            }
        }
    }
    component Motor {
        incoming message move with identifier: "/move", type: std_msgs/Float64
    }
    requirement move needs Eye.free
    provide move with { data: Eye.side }
    datatype enum Sight from sensor_msgs/LaserScan to {
        min(r for r in value.ranges[30..35]) < 0.3 -> near
        min(r for r in value.ranges[-20..20]) > 0.5 -> far
        default -> middle
    }
}
"""
_RULES = (("< 0.3", "<= 0.3"), ("> 0.5", ">= 0.5"), ("> 0.5", "> 0.65"), ("30, 35", "30, 36"))
_SIDES = tuple((", 50, 60)", f", 50, {last})", number) for number in range(3) for last in (59, 61))


@pytest.fixture(scope="module")
def together(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    with judging_model(tmp_path_factory.mktemp("together"), TOGETHER) as judging:
        yield judging


@pytest.mark.parametrize(("before", "after", "number"), [*((*rule, 0) for rule in _RULES), *_SIDES])
def test_it_comes_to_rules_in_guards_and_to_what_is_taken_together(
    together: tuple[Any, str], before: str, after: str, number: int
) -> None:
    judging, source = together
    parts = source.split(before)
    assert number < len(parts) - 1
    faulty = before.join(parts[: number + 1]) + after + before.join(parts[number + 1 :])
    assert judged(judging, faulty).faults != []


def test_numbers_of_the_model_are_compared_as_doubles_where_fields_are(
    together: tuple[Any, str],
) -> None:
    """Whole numbers would tell states apart that differ in nothing but numbers."""
    messages = list(Robot(together[0], 1, lambda data: data).boundaries("Eye.odom", "response"))
    assert messages
    assert all(isinstance(m.pose.pose.position.x, float) for m in messages)
