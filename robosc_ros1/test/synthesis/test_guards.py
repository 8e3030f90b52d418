"""Guards: right in every state, short, and in the model's own words where possible."""

from __future__ import annotations

import random

import families
import numpy as np
import pytest
from emit.generated_code import controller_source
from hypothesis import given, settings
from hypothesis import strategies as st
from random_models import random_model
from synthesis.oracle import Event, Oracle
from synthesis.plants import guard_text, plant_of, supervisor_of
from synthesis.subject import robot_of

from robosc.expr.tree import Expr
from robosc.plant.build import lower
from robosc.plant.model_text import to_dsl
from robosc.synthesis import synthesize
from robosc.synthesis.compiled_steps import Stepper
from robosc.synthesis.guards.minimise import condition_of
from robosc.synthesis.guards.sum_of_products import Diagrams

LINE = families.transfer_line(3, 2)


@pytest.mark.parametrize("seed", range(200, 230))
def test_guard_is_what_the_oracle_enables(seed: int) -> None:
    robot = robot_of(random_model(random.Random(seed), 1 + seed % 3))
    oracle = Oracle(robot)
    supervisor = synthesize(lower(robot), "explicit")
    for guard in supervisor.guards:
        event = Event(guard.event.kind, guard.event.key, guard.event.index)
        assert guard.status == oracle.status(event)
        for state in oracle.controlled[0]:
            if event in oracle.possible(state):
                assert oracle.holds(guard.expr, state) == (event in oracle.enabled(state))


def test_as_required_keeps_the_wording() -> None:
    found = supervisor_of(
        "component A { incoming message go with type: none outgoing message m with type: none"
        " behaviour { initial marked state one { on response from m goto two }"
        " marked state two { on response from m goto one } } }"
        " requirement go needs A.one or A.two"
        " requirement A.two and !A.one disables go"
    )
    assert guard_text(found, "go.request") == (
        "(A.one or A.two) and !(A.two and !A.one)",
        "as required",
    )


def test_without_requirement_the_guard_is_true() -> None:
    found = supervisor_of("component A { incoming message go with type: none }")
    assert guard_text(found, "go.request") == ("true", "as required")


def test_cancel_without_requirement_is_never() -> None:
    found = supervisor_of(
        "component A { action a with request: none, response: none, feedback: none links link }"
    )
    assert guard_text(found, "a.cancel") == ("false", "never")


def test_overflow_is_prevented_by_one_comparison() -> None:
    found = supervisor_of(families.transfer_line(3, 4))
    assert guard_text(found, "work0.request") == ("Buffer0.level <= 3", "restricted")


def test_requirement_and_a_further_condition() -> None:
    found = supervisor_of(
        "component A { incoming message on with type: none incoming message off with type: none"
        " behaviour { initial marked state down { on request to on goto up }"
        " marked state up { on request to off goto down } } }"
        "component B { outgoing message m with type: none behaviour {"
        " initial marked state low { on response from m goto high }"
        " marked state high { on response from m goto low } } }"
        "component C { incoming message into with type: none incoming message out with type: none"
        " behaviour { initial marked state outside { on request to into goto inside }"
        " marked state inside { on request to out goto outside } } }"
        " requirement on needs B.low or B.high and C.outside"
        " requirement never A.up and C.inside"
        " requirement into needs B.low"
    )
    assert guard_text(found, "into.request") == ("B.low and A.down", "restricted")
    assert guard_text(found, "on.request") == ("C.outside", "restricted")


def test_requirement_that_ranges_imply_is_left_out() -> None:
    """The plant cannot take a part from an empty buffer, whatever the guard says."""
    assert guard_text(supervisor_of(LINE), "work1.request") == ("Buffer1.level <= 1", "restricted")


def test_invariant_on_what_is_controlled() -> None:
    found = supervisor_of(
        "component A { incoming message on with type: none incoming message off with type: none"
        " behaviour { initial marked state down { on request to on goto up }"
        " marked state up { on request to off goto down } } }"
        "component B { outgoing message m with type: none behaviour {"
        " initial marked state low { on response from m goto high }"
        " marked state high { on response from m goto low } } }"
        "component C { incoming message into with type: none incoming message out with type: none"
        " behaviour { initial marked state outside { on request to into goto inside }"
        " marked state inside { on request to out goto outside } } }"
        " requirement never A.up and C.inside"
    )
    assert guard_text(found, "on.request") == ("C.outside", "restricted")
    assert guard_text(found, "into.request") == ("A.down", "restricted")
    assert guard_text(found, "off.request") == ("true", "as required")


def test_enum_values_are_named() -> None:
    found = supervisor_of(
        "datatype enum Place from integer to { value = 1 -> near value = 2 -> far default -> home }"
        "component Arm { action reach with request: none, response: Place, feedback: none"
        " links link behaviour { variable at: Place = home"
        " initial marked state rest { on request to reach goto moving }"
        " state moving { on response from reach do at := value goto rest"
        "   on error from reach goto rest } } }"
        "component Lid { service close with request: none, response: none links link"
        " behaviour { initial marked state open { on request to close goto closing }"
        " state closing { on response from close goto closed on error from close goto open }"
        " marked state closed { on request to close goto closing } } }"
        " requirement never Lid.closed and Arm.moving"
        " requirement never Lid.closing and Arm.at = far"
    )
    text, status = guard_text(found, "close.request")
    assert status == "restricted"
    assert "Arm.at != far" in text
    assert "Arm.rest" in text or "!Arm.moving" in text


# --- the cover by itself -------------------------------------------------------------------------

COVERED = plant_of(
    "datatype enum Colour from integer to { value = 1 -> red value = 2 -> green default -> blue }"
    "component A { service s with request: none, response: Colour links link"
    " incoming message go with type: none"
    " behaviour { variable x: integer(0..5) variable b: boolean variable c: Colour"
    " initial marked state one { on response from s do x := 1, b := true, c := value goto two }"
    " marked state two { on response from s goto three } marked state three {} } }"
    "requirement go needs A.x > 1 and A.b and A.c = red"
)
VARIABLES = tuple(range(len(COVERED.variables)))
SHAPE = tuple(variable.size for variable in COVERED.variables)


@pytest.mark.slow
@settings(max_examples=60)
@given(
    st.integers(0, 2**32), st.sampled_from([0.02, 0.3, 0.5, 0.9]), st.sampled_from([0.0, 0.5, 0.95])
)
def test_cover_separates_the_two_sets(seed: int, part: float, careless: float) -> None:
    rng = np.random.default_rng(seed)
    care = rng.random(SHAPE) >= careless
    inside = rng.random(SHAPE) < part
    holds = Stepper(COVERED).test(_condition_of(inside & care, ~inside & care))
    for place in np.ndindex(*SHAPE):
        if care[place]:
            assert holds(place) == inside[place]


def _condition_of(*sets: object) -> Expr:
    diagrams = Diagrams(SHAPE)
    return condition_of(
        COVERED,
        VARIABLES,
        diagrams,
        *(diagrams.of_rows(map(tuple, np.argwhere(each).tolist())) for each in sets),
    )


def _where(inside: object) -> Expr:
    found = np.zeros(SHAPE, np.bool_)
    for place in np.ndindex(*SHAPE):
        found[place] = inside(
            {
                variable.name: variable.values[at]
                for variable, at in zip(COVERED.variables, place, strict=True)
            }
        )
    return _condition_of(found, ~found)


SHORT = {
    "A.x <= 2": lambda v: v["A.x"] <= 2,
    "A.x >= 2": lambda v: v["A.x"] > 1,
    "A.x >= 2 and A.x <= 3": lambda v: v["A.x"] in (2, 3),
    "A.x = 4": lambda v: v["A.x"] == 4,
    "A.x != 4": lambda v: v["A.x"] != 4,
    "A.c != red": lambda v: v["A.c"] != "red",
    "A.c = red": lambda v: v["A.c"] == "red",
    "!A.b": lambda v: not v["A.b"],
    "A.one": lambda v: v["A"] == "one",
    "!A.one": lambda v: v["A"] != "one",
    "s.busy": lambda v: v["A.s"] == "busy",
    "A.b and A.c = red": lambda v: v["A.b"] and v["A.c"] == "red",
    "A.b or A.c = red": lambda v: v["A.b"] or v["A.c"] == "red",
    "false": lambda v: False,
    "true": lambda v: True,
}


@pytest.mark.parametrize("text", SHORT)
def test_short_sets_have_short_words(text: str) -> None:
    assert to_dsl(_where(SHORT[text]), COVERED.robot) == text


def test_mirrored_phases_are_not_mentioned() -> None:
    """Users cannot write a phase, so a guard speaks of the component that mirrors it."""
    line = families.services_hands(5).replace("requirement", "// requirement")
    found = supervisor_of(
        line.rstrip().removesuffix("}") + "  requirement never Hand0.busy and Hand1.busy\n}"
    )
    assert guard_text(found, "act0.request") == ("Hand1.idle", "restricted")


SHARED = """
component A {
    incoming message go with type: none
    action reach with request: none, response: none, feedback: none links link
    outgoing message s with type: integer(0..5)
    outgoing message t with type: none
    behaviour {
        variable x: integer(0..5) = 0
        on response from s do x := value
        on request to go
        initial marked state on { on response from t goto off }
        marked state off { on response from t goto on }
    }
}
requirement { go, reach } needs A.on and A.x > 2
requirement { go, reach } needs A.on and A.x < 5 and A.x != 4
"""


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_what_requirements_share_is_said_once(engine: str) -> None:
    supervisor = synthesize(plant_of(SHARED), engine)
    said = {
        (g.event.name, g.event.kind.word): to_dsl(g.expr, supervisor.plant.robot)
        for g in supervisor.guards
    }
    assert said["go", "request"] == "A.on and A.x > 2 and A.x < 5 and A.x != 4"
    assert said["reach", "request"] == said["go", "request"]
    # The generated guard still calls both requirements.
    source = controller_source(supervisor)
    assert "return self.requirement_1() and self.requirement_2()\n" in source
    assert "return not self.requirement_1() or not self.requirement_2()\n" in source


def cabins(floors: int) -> str:
    """Two lifts in one shaft, one above the other; doors open at different floors only."""
    cabins = "".join(
        f"""
component Cabin{n} {{
    incoming message up{n} with type: none
    incoming message down{n} with type: none
    incoming message open{n} with type: none
    outgoing message closed{n} with type: none
    behaviour {{
        variable floor: integer(0..{floors - 1}) = {n}
        initial marked state still {{
            on request to up{n} do floor := floor + 1
            on request to down{n} do floor := floor - 1
            on request to open{n} goto open
        }}
        state open {{ on response from closed{n} goto still }}
    }}
}}"""
        for n in range(2)
    )
    return f"""{cabins}
requirement always Cabin1.floor >= Cabin0.floor
requirement never Cabin0.open and Cabin1.floor = Cabin0.floor
"""


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_values_that_requirements_compare_are_compared_in_guards(engine: str) -> None:
    supervisor = synthesize(plant_of(cabins(10)), engine)
    assert guard_text(supervisor, "open0.request") == ("Cabin1.floor != Cabin0.floor", "restricted")
    assert guard_text(supervisor, "up0.request") == ("Cabin1.floor > Cabin0.floor", "restricted")


DOORS = "".join(
    f"""
component Lift{n} {{
    incoming message up{n} with type: none
    incoming message down{n} with type: none
    incoming message open{n} with type: none
    incoming message close{n} with type: none
    outgoing message opened{n} with type: none
    outgoing message closed{n} with type: none
    outgoing message blocked{n} with type: none
    behaviour {{
        variable floor: integer(0..9) = {n}
        initial marked state still {{
            on request to up{n} do floor := floor + 1
            on request to down{n} do floor := floor - 1
            on request to open{n} goto opening
        }}
        state opening {{ on response from opened{n} goto open }}
        state open {{ on request to close{n} goto closing }}
        state closing {{
            on response from closed{n} goto still
            on response from blocked{n} goto open
        }}
    }}
}}
component Light{n} {{
    behaviour {{
        initial marked state off {{ on response from opened0 if Lift0.floor = {n} goto on }}
        marked state on {{ on response from closed0 goto off }}
    }}
}}"""
    for n in range(2)
)


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_guards_say_what_is_kept_by_several_uncontrollable_events(engine: str) -> None:
    supervisor = synthesize(
        plant_of(
            f"{DOORS} requirement never Lift0.open and Lift1.open and Lift0.floor = Lift1.floor"
        ),
        engine,
    )
    assert guard_text(supervisor, "open0.request") == (
        "(!Lift1.closing or Lift0.floor != Lift1.floor)"
        " and (!Lift1.opening or Lift0.floor != Lift1.floor)"
        " and !(Lift1.open and Lift0.floor = Lift1.floor)",
        "restricted",
    )
