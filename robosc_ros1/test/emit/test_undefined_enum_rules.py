"""A rule of an enum that is undefined does not hold; the controller counts that, and goes on."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from emit.generated_code import controller_class, supervisor_of

MODEL = """
robot Walker {{
    interface laser use LaserScan from sensor_msgs

    datatype object Scan {{ ranges: array(double) }}
    datatype enum Way from Scan to {{ {rule} -> blocked default -> free }}

    component Eye {{
        outgoing message scan with identifier: "/scan", type: Way links laser
        behaviour {{
            variable way: Way
            on response from scan do way := value
            initial marked state on {{}}
        }}
    }}
    component Base {{ incoming message drive with type: none }}
    requirement drive needs Eye.way = free
}}
"""


@pytest.mark.parametrize(
    "rule",
    [
        "value.ranges[2] < 1.0",
        "min(x for x in value.ranges) < 1.0",
        "min(x for x in value.ranges[1..2]) < 1.0",
        "value.ranges[length(value.ranges) - 1] < 1.0",
    ],
)
def test_a_rule_that_reads_what_did_not_come_is_counted(rule: str) -> None:
    controller_type, _ = controller_class(supervisor_of(MODEL.format(rule=rule)))
    controller = controller_type()
    controller.on_response_of_scan(
        controller.read_response_of_scan(SimpleNamespace(ranges=[2.0, 2.0, 0.5]))
    )
    assert (controller.eye_way, controller.undefined) == ("blocked", {})
    controller.on_response_of_scan(controller.read_response_of_scan(SimpleNamespace(ranges=[])))
    assert controller.eye_way == "free"
    assert sum(controller.undefined.values()) == 1
