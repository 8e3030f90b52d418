"""Conditions on data of provide statements that correct decide nothing: no stage asks the plant for
them, whether it is solved whole or in parts."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of

from robosc.language.events import EventKind
from robosc.synthesis.verify.verification import verify

ROBOT = """
robot Corrects {
    datatype object Scan { ranges: array(double) }
    interface scans use Scan from some_msgs
    function half(x: double): double = x / 2
    parameter limit: double = 0.5
    component Lamp[1..%d] {
        outgoing message flip with identifier: "/lamp{index}", type: none
        behaviour {
            initial marked state dark { on response from flip goto lit }
            marked state lit { on response from flip goto dark }
        }
    }
    component S {
        outgoing message lim with type: double
        outgoing message laser with type: Scan links scans
        outgoing message name with type: string
        outgoing message scan with timeout: 1 s, type: none
        incoming message move with identifier: "/move", type: double
        service ask with request: none, response: boolean links asks
        behaviour {
            variable v: double
            variable w: double
            variable text: string
            variable rays: array(double)
            on response from lim do v := value, w := 2 * value
            on response from laser do rays := value.ranges
            on response from name do text := value
            initial marked state s {}
        }
    }
    interface asks use Ask from some_msgs
    condition slow = S.v < 0.5 for 1 s
    provide move with min(value, 0.25) if %s
    provide move with min(value, 0.5)
    %s
}
"""
CONDITIONS = (
    "S.v < 0.5",
    "S.v < S.w",
    "S.v < limit",
    "half(S.v) > 0.1",
    'S.text = "slow"',
    "S.rays[0] < 0.5",
    "defined(S.rays[0])",
    "length(S.rays) > 0",
    "min(r for r in S.rays) < 1.0",
    "any(r < 0.5 for r in S.rays)",
    "(S.v else 0.0) < 0.5",
    "S.v in { 0.1, 0.2 }",
    "abs(S.v) < 0.5 and scan.fresh",
    "scan.silent or ask.busy",
    "value > S.v",
    "value > 0.1 and S.v < 0.5",
    "isnan(S.v)",
    "slow",
    "S.s",
)


@pytest.mark.parametrize("lamps", [1, 13], ids=["whole", "in parts"])
@pytest.mark.parametrize("condition", CONDITIONS)
def test_each_kind_of_condition(condition: str, lamps: int) -> None:
    supervisor = supervisor_of(ROBOT % (lamps, condition, ""), supervises=True)
    assert not supervisor.empty
    move = [g for g in supervisor.guards if g.event.key == "S.move"]
    assert move and all(g.event.kind is EventKind.REQUEST for g in move)
    if lamps == 1:
        assert verify(supervisor).verified


@pytest.mark.parametrize("lamps", [1, 13], ids=["whole", "in parts"])
@pytest.mark.parametrize("condition", [c for c in CONDITIONS if "value" not in c])
def test_what_a_requirement_asks_besides(condition: str, lamps: int) -> None:
    requirement = f"requirement move needs {condition}"
    text = ROBOT % (lamps, condition, requirement)
    assert not supervisor_of(text, supervises=True).empty
