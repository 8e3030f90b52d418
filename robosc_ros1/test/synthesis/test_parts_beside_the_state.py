"""Parts of a message that may be missing, compared with variables of the state."""

from __future__ import annotations

import pytest
from synthesis.test_oracle_differential import check, engines

MODEL = """\
robot Parts {{
    interface link use Thing from robosc_testing
    datatype object Answer {{
        marks: array(integer(0..2))
        flags: array(boolean)
    }}
    component C {{
        action go with request: none, response: Answer, feedback: none links link
        incoming message rest with identifier: "/rest", type: none
        behaviour {{
            variable y: integer(-1..1) = 1
            variable b: boolean
            initial marked state idle {{
                on request to go goto busy
                on request to rest do y := -1, b := true
            }}
            state busy {{
                on response from go {guard} do y := 0{update} goto idle
                on error from go goto idle
                on cancelled from go goto idle
            }}
        }}
    }}
    {assumption}
}}
"""
CONDITIONS = (
    "value.marks[1] <= C.y",
    "value.marks[0] + C.y < 2",
    "C.y < 0 or value.marks[1] = C.y",
    "!(value.marks[1] = C.y)",
    "value.marks[0] < value.marks[1] + C.y",
    "value.flags[0] = C.b",
    "!(value.flags[0] => C.b)",
    "(value.marks[1] + C.y else 1) > 0",
    "(value.marks[1] <= C.y else C.b)",
    "defined(value.marks[1] + C.y)",
    "C.b = defined(value.marks[1])",
)


@engines
@pytest.mark.parametrize("condition", CONDITIONS)
@pytest.mark.parametrize("place", ["guard", "update", "assumption"])
def test_parts_beside_the_state(place: str, condition: str, engine: str) -> None:
    """A condition on a part that is missing is undefined, whatever the state."""
    texts = {
        "guard": f"if {condition}",
        "update": f", b := {condition}",
        "assumption": f"assume go needs {condition}",
    }
    parts = dict.fromkeys(texts, "") | {place: texts[place]}
    check(MODEL.format(**parts), engine)
