"""Constants that are arrays and objects, with values of enums in them, in generated controllers."""

from __future__ import annotations

import pytest
from emit.generated_code import supervisor_of
from emit.scripted_controllers import faults_of
from simulate.players import play, session

MODEL = """
robot R {{
    datatype enum Side from {source} to {{
        value = {one} -> left value = {two} -> right default -> nowhere
    }}
    datatype object Place {{ side: Side x: double near: array(Side) }}
    constant modes: array(Side) = [left, right]
    constant first: Place = {{ side: left, x: 0.5, near: [right] }}
    constant places: array(Place) = [first, {{ side: right, x: 2.0, near: [left, nowhere] }}]
    component A {{
        outgoing message turned with type: Side
        outgoing message counted with type: integer(0..3)
        incoming message go with type: none
        behaviour {{
            variable s: Side
            variable n: integer(0..3)
            initial marked state on {{
                on response from turned do s := value
                on response from counted do n := value
            }}
        }}
    }}
    requirement go needs {condition}
}}
"""
NAMES = ("left", "right", "nowhere")
CONDITIONS = {
    "any(x = A.s for x in modes)": lambda side, n: side != "nowhere",
    "count(x != A.s for x in modes) = 2": lambda side, n: side == "nowhere",
    "any(x = left for x in modes) and A.n > 0": lambda side, n: n > 0,
    "any(x = A.s for x in modes[A.n..1])": (  # behind the end, it goes on from the beginning
        lambda side, n: side == "right" or (side == "left" and n != 1)
    ),
    "places[A.n].side = A.s": lambda side, n: n < 2 and side == NAMES[n],
    "places[A.n].near[0] = left": lambda side, n: n == 1,
    "first.side = A.s": lambda side, n: side == "left",
    "any(p.side = A.s and p.x > 1 for p in places)": lambda side, n: side == "right",
    "any(any(t = A.s for t in p.near) for p in places if p.side = right)": (
        lambda side, n: side in ("left", "nowhere")
    ),
}
SOURCES = {"integer": ("integer", "1", "2"), "string": ("string", '"right"', '"left"')}


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("condition", CONDITIONS)
def test_a_command_is_enabled_where_its_condition_on_constants_holds(
    condition: str, source: str
) -> None:
    type_, one, two = SOURCES[source]
    text = MODEL.format(source=type_, one=one, two=two, condition=condition)
    player = session(supervisor_of(text), execute=True)
    for side in NAMES:
        for n in range(4):
            expected = "enabled" if CONDITIONS[condition](side, n) else "disabled"
            play(player, f"turned {side}", f"counted {n}", f"expect {expected} go")


@pytest.mark.parametrize("condition", CONDITIONS)
def test_the_package_s_own_test_reads_constants_the_same_way(
    condition: str,
) -> None:
    text = MODEL.format(source="integer", one=1, two=2, condition=condition)
    assert faults_of(supervisor_of(text)) == []


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_functions_of_constants_are_computed_by_both_engines(engine: str) -> None:
    text = """
    robot R {
        constant levels: array(double) = [0.5, 1.5]
        constant nothing: array(double) = []
        component A {
            outgoing message measured with type: double
            outgoing message counted with type: integer(0..3)
            incoming message go with type: none
            incoming message come with type: none
            behaviour {
                variable x: double
                variable n: integer(0..3)
                initial marked state on {
                    on response from measured do x := value
                    on response from counted do n := value
                }
            }
        }
        requirement go needs A.x > length(levels)
        requirement come needs A.n > count(x > 1 for x in levels) + length(nothing)
    }
    """
    player = session(supervisor_of(text, engine=engine))
    play(player, "measured 2", "expect disabled go", "measured 2.5", "expect enabled go")
    play(player, "counted 1", "expect disabled come", "counted 2", "expect enabled come")
