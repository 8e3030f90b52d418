"""Calls that the controller serves, in the plant: by hand."""

from __future__ import annotations

import pytest
from synthesis.plants import explanation_of, guard_text, plant_of, supervisor_of, trace_text_of

from robosc.plant.step import Verdict, outcome
from robosc.synthesis.verify.verification import verify

ORDERS = """
    component Orders {{
        outgoing service order with request: integer(0..9), response: none links link
        behaviour {{
            initial marked state free {{
                on request from order if value > 3 goto asked
            }}
            state asked {{ {asked} }}
        }}
    }}
    component Door {{
        incoming message open with type: none
        incoming message close with type: none
        behaviour {{
            initial marked state closed {{ on request to open goto opened }}
            marked state opened {{ on request to close goto closed }}
        }}
    }}
"""
ANSWERED = ORDERS.format(asked="on response to order goto free")


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_a_call_is_accepted_where_a_component_takes_it(engine: str) -> None:
    found = supervisor_of(ANSWERED, engine)
    # Six of the ten values are taken in each of the two states in which Orders is free.
    assert (found.plant_states, found.controlled_states) == (4, 4)
    assert found.controlled_transitions == 2 * 6 + 2 + 4
    assert guard_text(found, "order.response") == ("true", "as required")
    assert all(check.holds for check in verify(found).checks)


def test_a_call_is_impossible_where_none_takes_it() -> None:
    plant = plant_of(ANSWERED)
    call = next(e for e in plant.events if e.kind.word == "request" and e.name == "order")
    (parameter,) = call.parameters
    free = plant.initial
    after = {v: outcome(plant, call, (v,), free) for v in parameter.values}
    refused = [v for v, found in after.items() if found is Verdict.IMPOSSIBLE]
    assert refused and all(not v > 3 for v in refused)
    (asked,) = {found for found in after.values() if not isinstance(found, Verdict)}
    assert {outcome(plant, call, (v,), asked) for v in parameter.values} == {Verdict.IMPOSSIBLE}


def test_a_lasting_condition_takes_no_call() -> None:
    """An accepted call sets back that nothing is asked; that alone accepts none."""
    lasting = "condition rested = order.idle for 2 s requirement open needs rested"
    found = supervisor_of(ORDERS.format(asked="on response to order goto free") + lasting)
    plant = found.plant
    call = next(e for e in plant.events if e.kind.word == "request" and e.name == "order")
    held = next(e for e in plant.events if e.name == "rested")
    rested = outcome(plant, held, (), plant.initial)
    assert not isinstance(rested, Verdict)
    for state in (plant.initial, rested):
        after = {v: outcome(plant, call, (v,), state) for v in call.parameters[0].values}
        assert {v for v, to in after.items() if to is Verdict.IMPOSSIBLE} == {0, 1, 2, 3}


def test_nobody_answers_with_an_error_by_itself() -> None:
    assert [e.kind.word for e in plant_of(ANSWERED).events if e.name == "order"] == [
        "request",
        "response",
    ]


def test_a_call_that_is_never_answered_empties_the_supervisor() -> None:
    never = "requirement order needs Door.opened and Door.closed"
    found = supervisor_of(ANSWERED + never)
    assert found.empty
    (why,) = (e for e in found.explanations if e.event is None)
    assert trace_text_of(why.trace)[0].startswith("order.request")


@pytest.mark.parametrize("engine", ["explicit", "bdd"])
def test_what_would_leave_a_call_unanswered_is_forbidden(engine: str) -> None:
    """The door closes for good once it has been opened, and the answer needs it open."""
    text = """
    component Orders {
        outgoing service order with request: none, response: none links link
        behaviour {
            initial marked state free { on request from order goto asked }
            state asked { on response to order goto free }
        }
    }
    component Door {
        incoming message shut with type: none
        behaviour {
            initial marked state opened { on request to shut goto shut_ }
            marked state shut_ {}
        }
    }
    requirement order needs Door.opened
    """
    found = supervisor_of(text, engine)
    assert guard_text(found, "shut.request") == ("false", "never")
    why = explanation_of(found, "shut.request")
    assert "order" in why.reason
    assert why.remedy is not None


def test_requirements_do_not_restrict_an_error() -> None:
    text = ORDERS.format(asked="on response, error to order goto free")
    found = supervisor_of(text + "requirement order needs Door.opened")
    assert guard_text(found, "order.response") == ("Door.opened", "as required")
    assert guard_text(found, "order.error") == ("true", "as required")


def test_an_error_ends_what_is_cancelled() -> None:
    """A goal is cancelled once, so that the remedy is no reaction to another cancel."""
    text = """
    component Orders {
        outgoing action order with request: none, response: none, feedback: none links link
        outgoing message gate with type: boolean
        behaviour {
            variable open: boolean
            on response from gate do open := value
            initial marked state free { on request from order goto running }
            state running {
                on response to order goto free
                on cancel from order goto leaving
            }
            state leaving { on response to order goto free %s }
        }
    }
    component Lock {
        outgoing message lost with type: none
        behaviour {
            initial marked state sound { on response from lost goto broken }
            marked state broken {}
        }
    }
    requirement order needs Lock.sound
    """
    (why,) = (e for e in supervisor_of(text % "").explanations if e.event is None)
    assert why.remedy is not None and "add 'on error to order" in why.remedy
    answered = "on error to order goto free"
    mended = text.replace("on cancel", f"{answered} on cancel") % answered
    assert not supervisor_of(mended).empty


def test_an_error_ends_what_cannot_be_answered() -> None:
    text = """
    component Orders {
        outgoing service order with request: none, response: none links link
        behaviour {
            initial marked state free { on request from order goto asked }
            state asked { on response to order goto free }
        }
    }
    component Door {
        outgoing message broken with type: none
        behaviour {
            initial marked state fine { on response from broken goto down }
            marked state down {}
        }
    }
    requirement order needs Door.fine
    """
    found = supervisor_of(text)
    assert found.empty
    (why,) = (e for e in found.explanations if e.event is None)
    assert trace_text_of(why.trace) == ["order.request", "broken.response"]
    assert why.remedy is not None
    assert "add 'on error to order if … goto free' in state asked of Orders" in why.remedy
    mended = text.replace(
        "on response to order goto free",
        "on response to order goto free on error to order goto free",
    )
    assert not supervisor_of(mended).empty
