"""What is known of data reads no state: conditions that ask for both are taken apart by the states."""

from __future__ import annotations

from itertools import product

import pytest
from model.model_text import resolve

from robosc.expr.evaluation import Undefined, evaluate
from robosc.expr.traversal import walk
from robosc.expr.tree import Expr, Leaf, PhaseRef, StateRef, VariableRef
from robosc.expr.types import Value
from robosc.plant.build import lower
from robosc.plant.logic import exact
from robosc.plant.model_text import to_dsl

MODEL = """
datatype object Data {{ ranges: array(double) }}
interface data use Data from example_msgs
component L {{
    outgoing message data with type: Data links data
    behaviour {{
        variable ranges: array(double)
        initial marked state s {{ on response from data do ranges := value.ranges }}
    }}
}}
component A {{
    incoming message go with type: none
    service lift with request: none, response: none links data
    behaviour {{
        initial marked state s {{ on request to go goto t }}
        state t {{ transition goto u }}
        state u {{ transition goto s }}
    }}
}}
requirement go needs {}
"""
CONDITIONS = {
    "any(A.s and r < 1 for r in L.ranges)": "A.s and any(r < 1 for r in L.ranges)",
    "any(r < 1 and A.s for r in L.ranges)": "A.s and any(r < 1 for r in L.ranges)",
    "!any(r < 1 and A.s for r in L.ranges)": (
        "A.s and defined(L.ranges) and !any(r < 1 for r in L.ranges) or !A.s and defined(L.ranges)"
    ),
    "all(r < 1 for r in L.ranges if A.t)": (
        "A.t and defined(L.ranges) and all(r < 1 for r in L.ranges) or !A.t and defined(L.ranges)"
    ),
    "count(r < 1 and lift.busy for r in L.ranges) > 1": (
        "lift.busy and count(r < 1 for r in L.ranges) > 1"
    ),
    "sum(r for r in L.ranges if A.s) > 1": "A.s and sum(r for r in L.ranges) > 1",
    "any(A.t for r in L.ranges) or L.ranges[0] < 1": (
        "A.t and defined(L.ranges) and any(true for r in L.ranges) or"
        " (A.t and defined(L.ranges) and !any(true for r in L.ranges) or !A.t and defined(L.ranges))"
        " and L.ranges[0] < 1"
    ),
    "any(r < 1 => A.s or A.u for r in L.ranges)": None,
    "any((r < 1) = A.s for r in L.ranges)": None,
    "any((r < 1) != (A.s or A.t) for r in L.ranges)": None,
    "count(A.s for r in L.ranges) = count(r < 1 for r in L.ranges)": None,
    "max(r for r in L.ranges if !A.s) > 1": None,
    "any(L.ranges[2] < r and A.s for r in L.ranges)": None,
    "all(L.ranges[2] < r and A.s for r in L.ranges)": None,
    "all(L.ranges[2] < r or A.s for r in L.ranges)": None,
    "all(L.ranges[2] < r => A.s for r in L.ranges)": None,
    "!all(any(r < q and A.t for q in L.ranges) for r in L.ranges if !A.s or lift.idle)": None,
    "string(A.s) = string(L.ranges[0] < 1)": None,
    "count(any(A.s for q in L.ranges[5..6]) for r in L.ranges) = 0": None,
}
"""And as what the plant takes them, where that is plain to read."""

ARRAYS = [None, (), (0.5,), (1.5,), (0.5, 1.5, 0.2), (float("nan"), 0.5, 2.5)]


def value(expr: Expr, state: str, busy: bool, ranges: Value | None) -> Value | None:
    """What an expression comes to; None if it is undefined."""

    def look(leaf: Leaf) -> Value | None:
        match leaf:
            case StateRef(state=name):
                return name == state
            case PhaseRef(phase=phase):
                return (phase == "busy") == busy
            case VariableRef():
                return ranges
        raise TypeError(leaf)

    try:
        return evaluate(expr, look)
    except Undefined:
        return None


@pytest.mark.parametrize("condition", CONDITIONS)
def test_tests_of_data_read_no_state_and_the_condition_is_the_same(condition: str) -> None:
    plant = lower(resolve(MODEL.format(condition)))
    assert not any(
        isinstance(part, StateRef | PhaseRef)
        for test in plant.view.tests
        for part in walk(test.subject)
    )
    (requirement,) = plant.robot.requirements
    taken = exact(plant.view.expression(requirement.condition))
    expected = CONDITIONS[condition]
    assert expected is None or to_dsl(taken, plant.robot) == expected
    for case in product("stu", (False, True), ARRAYS):
        assert value(taken, *case) == value(requirement.condition, *case), case
