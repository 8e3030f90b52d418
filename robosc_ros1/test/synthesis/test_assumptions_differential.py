"""robosc against the oracle on random robots of which something is assumed."""

from __future__ import annotations

import random

import pytest
from random_models import random_model
from synthesis.subject import robot_of
from synthesis.test_oracle_differential import check, engines

from robosc.plant.acceptance import gates_of
from robosc.plant.build import lower
from robosc.synthesis import synthesize


def _model(seed: int) -> str:
    return random_model(random.Random(seed), 1 + seed % 3, assumes=True)


@pytest.mark.slow
@pytest.mark.timeout(0)
@engines
def test_random_robots_with_assumptions(engine: str, pytestconfig: pytest.Config) -> None:
    count = pytestconfig.getoption("--models", default=None)
    first = pytestconfig.getoption("--first-model", default=0)
    for seed in range(first, first + (40 if count is None else count)):
        check(_model(seed), engine, seed)


def test_a_command_that_many_components_share_is_told_to_break_an_assumption() -> None:
    """Their transitions are combined only as far as the assumption reads what they change."""
    states = ["on request to go goto s1", "on request to go goto s2", "on request to go goto s0"]
    body = " ".join(
        f"{'initial marked ' * (not n)}state s{n} {{ {t} }}" for n, t in enumerate(states)
    )
    parts = [f"component C{n} {{ behaviour {{ {body} }} }}" for n in range(16)]
    parts[0] = parts[0].replace("{ behaviour", "{ incoming message go with type: none behaviour")
    text = f"robot Many {{ {' '.join(parts)} assume never C15.s2 }}"
    (told,) = synthesize(lower(robot_of(text)), "bdd").diagnostics
    assert told.code == "assumption-broken"
    assert told.message.endswith(": after go.request")


def test_a_message_that_many_components_take_is_restricted() -> None:
    """Each part of an assumption is brought before the event by itself."""
    body = (
        "initial marked state off { on response from tick if value goto on_ }"
        " state on_ { on response from tick if !value goto off }"
    )
    parts = [f"component C{n} {{ behaviour {{ {body} }} }}" for n in range(16)]
    parts[0] = parts[0].replace(
        "{ behaviour", "{ outgoing message tick with type: boolean behaviour"
    )
    every = " and ".join(f"C{n}.on_" for n in range(16))
    (tick,) = lower(robot_of(f"robot Many {{ {' '.join(parts)} assume never {every} }}")).events
    (gate,) = gates_of(tick)
    assert gate.edges[0].guard is not None


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_only_assumptions_that_leave_nothing_together_are_told(engine: str) -> None:
    text = """robot Level {
        component A {
            outgoing message level with type: double
            behaviour {
                variable low: boolean
                initial marked state on_ { on response from level do low := value < 1.0 }
            }
        }
        assume level needs value < 5.0
        assume never A.low
        assume level needs value > 2.0
        assume level needs value < 1.5
    }"""
    (told,) = (
        d
        for d in synthesize(lower(robot_of(text)), engine).diagnostics
        if d.code == "assumption-excludes-all"
    )
    assert told.message == (
        "'assume level needs value > 2.0' and 'assume level needs value < 1.5' leave no response of"
        " level: the robot is assumed never to send one"
    )


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
@pytest.mark.parametrize(
    ("condition", "told"),
    [
        ("A.tries = 1", ["say.request breaks 'assume never A.tries = 1': after near.response"]),
        ("A.far > 2.0", []),
        ("A.word = 'far'", []),
        ("A.scan[0] > 1.0", []),
    ],
)
def test_data_that_no_answer_changes_may_be_assumed_of(
    engine: str, condition: str, told: list[str]
) -> None:
    """Commands change the count, and nothing the others: no event is restricted by them."""
    text = f"""robot Odd {{
        component A {{
            outgoing message near with type: boolean
            incoming message say with type: none
            behaviour {{
                variable tries: integer
                variable far: double
                variable word: string
                variable scan: array(double)
                initial marked state p {{ on response from near goto q }}
                state q {{ on request to say do tries := 1 goto p }}
            }}
        }}
        assume never {condition}
    }}"""
    found = synthesize(lower(robot_of(text)), engine)
    assert [d.message for d in found.diagnostics if d.code == "assumption-broken"] == told
