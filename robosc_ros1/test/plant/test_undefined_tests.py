"""A test of data that may be undefined is one more thing that can come in: no guard holds then."""

from __future__ import annotations

import pytest
from model.model_text import resolve

from robosc.language.events import EventKind
from robosc.plant.build import lower
from robosc.plant.step import Verdict, outcome, valuations

MODEL = """
datatype object Data {{ ranges: array({}) n: integer }}
interface data use Data from example_msgs
component A {{
    incoming message go with type: none
    outgoing message data with type: Data links data
    behaviour {{
        initial state s {{ on response from data if {} goto t }}
        marked state t {{}}
    }}
}}
requirement go needs A.t
"""


@pytest.mark.parametrize(
    ("element", "guard", "undefined"),
    [
        ("integer", "min(r for r in value.ranges) < 5", True),
        ("double", "isnan(max(r for r in value.ranges))", True),
        ("integer", "value.ranges[value.n] = 3", True),
        ("integer", "value.ranges[2] = 3", True),
        ("integer", "any(r > 5 for r in value.ranges)", False),
        ("integer", "length(value.ranges) > 5", False),
    ],
)
def test_what_may_be_undefined_may_be_missing(element: str, guard: str, undefined: bool) -> None:
    plant = lower(resolve(MODEL.format(element, guard)))
    (event,) = (e for e in plant.events if e.kind is EventKind.RESPONSE)
    assert (None in event.parameters[0].values) == undefined


def test_what_a_delayed_transition_computes_is_left_open() -> None:
    plant = lower(
        resolve(
            """
            component S {
                outgoing message m with type: double
                incoming message go with type: none
                behaviour {
                    variable x: double
                    initial marked state a {
                        on response from m do x := value
                        after 1 s do x := x * 2 goto b
                    }
                    marked state b {}
                }
            }
            requirement go needs S.x > 3
            """
        )
    )
    (event,) = (e for e in plant.events if e.kind is EventKind.AFTER)
    targets = {outcome(plant, event, values, plant.initial) for values in valuations(event)}
    assert {plant.variables[1].shown(target[1]) for target in targets} == {
        "S.x > 3",
        "!(S.x > 3)",
    }


ELSE = """
datatype object Data {{ ranges: array(double) }}
interface data use Data from example_msgs
component A {{
    outgoing message data with type: Data links data
    behaviour {{
        initial state s {{
            on response from data if {} goto t
            on response from data else goto u
        }}
        marked state t {{}}
        marked state u {{}}
    }}
}}
"""


@pytest.mark.parametrize(
    ("guard", "ways"),
    [
        (
            "value.ranges[2] >= 3.0",
            {"ranges[2] >= 3.0": "t", "!(ranges[2] >= 3.0)": "u", "missing": "u"},
        ),
        (
            "!(value.ranges[2] >= 3.0)",
            {"ranges[2] >= 3.0": "u", "!(ranges[2] >= 3.0)": "t", "missing": "u"},
        ),
        ("defined(value.ranges[2])", {"any": "t", "missing": "u"}),
    ],
)
def test_else_asks_nothing_new_of_an_element(guard: str, ways: dict[str, str]) -> None:
    plant = lower(resolve(ELSE.format(guard)))
    (event,) = (e for e in plant.events if e.kind is EventKind.RESPONSE)
    (parameter,) = event.parameters
    found = {}
    for (value,) in valuations(event):
        after = outcome(plant, event, (value,), plant.initial)
        found[parameter.shown(value)] = after if isinstance(after, Verdict) else "stu"[after[0]]
    assert found == ways
