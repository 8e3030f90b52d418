"""Reasons for what synthesis forbids: the trace, the harm, the remedy, and their place."""

from __future__ import annotations

import random

import families
import pytest
import steep_families
from quick import quick_first
from random_models import random_model
from synthesis.oracle import Oracle
from synthesis.plants import (
    explanation_of,
    guard_text,
    plant_of,
    replay,
    supervisor_of,
    trace_text_of,
)
from synthesis.subject import robot_of

from robosc.errors import Severity
from robosc.language.events import EventKind
from robosc.plant.build import lower
from robosc.plant.step import Verdict, holds
from robosc.synthesis import synthesize

GRABBER = """
    component ObstacleGrabber {
        action grab with request: none, response: none, feedback: none links link
        behaviour {
            initial marked state idle { on request to grab goto grabbing }
            state grabbing { on response from grab goto idle }
        }
    }
"""


def test_unhandled_error() -> None:
    found = supervisor_of(GRABBER)
    assert guard_text(found, "grab.request") == ("false", "never")
    why = explanation_of(found, "grab.request")
    assert trace_text_of(why.trace) == ["grab.request", "grab.error"]
    assert why.reason == (
        "grab.request can never be allowed: after grab.request the controller cannot prevent"
        " grab.error; then ObstacleGrabber is stuck in ObstacleGrabber.grabbing, from where no"
        " marked state can be reached"
    )
    assert why.remedy == "add 'on error from grab goto idle' in state grabbing of ObstacleGrabber"
    assert why.diagnostic.severity is Severity.WARNING
    assert why.diagnostic.code == "never-allowed"
    assert why.diagnostic.span.text == "grab"
    assert why.diagnostic.hint == why.remedy


def test_the_remedy_helps() -> None:
    mended = GRABBER.replace(
        "on response from grab goto idle",
        "on response from grab goto idle on error from grab goto idle",
    )
    found = supervisor_of(mended)
    assert guard_text(found, "grab.request") == ("true", "as required")
    assert [e.event.kind.word for e in found.explanations if e.event] == ["cancel"]
    assert found.diagnostics == ()


def test_unhandled_cancel() -> None:
    """The end of a cancelled goal leaves the component behind: synthesis forbids to cancel it."""
    found = supervisor_of(
        GRABBER.replace(
            "on response from grab goto idle",
            "on response from grab goto idle on error from grab goto idle",
        )
        + "component S { outgoing message m with type: boolean behaviour { variable x: boolean"
        " initial marked state s { on response from m do x := value } } }"
        " requirement S.x disables grab"
    )
    assert guard_text(found, "grab.cancel") == ("false", "never")
    why = explanation_of(found, "grab.cancel")
    assert trace_text_of(why.trace) == [
        "grab.request",
        "m.response",
        "grab.cancel",
        "grab.cancelled",
    ]
    remedy = "add 'on cancelled from grab goto idle' in state grabbing of ObstacleGrabber"
    assert why.remedy == remedy


DOOR = """
robot R {
    component Door {
        service close with request: none, response: none links Empty
        behaviour {
            initial marked state shut { transition goto open }
            marked state open { on request to close goto closing }
            state closing { on response from close goto locked }
            marked state locked { }
        }
    }
    interface Empty use Empty from std_srvs
}
"""


def test_after_an_error_the_remedy_goes_back_to_where_the_request_came_from() -> None:
    """Neither on to ``locked``, as if all had gone well, nor to the initial state."""
    why = explanation_of(supervisor_of(DOOR), "close.request")
    assert why.remedy == "add 'on error from close goto open' in state closing of Door"


def test_state_that_nothing_leaves() -> None:
    """The front end refuses a dead end by its own automaton; here the guard is what closes it."""
    found = supervisor_of(
        "component A { incoming message go with type: none outgoing message off with type: none"
        " behaviour { variable x: boolean"
        " initial marked state home { on request to go goto away }"
        " state away { on response from off if x goto home } } }"
    )
    why = explanation_of(found, "go.request")
    assert trace_text_of(why.trace) == ["go.request"]
    assert "A is stuck in A.away" in why.reason


def test_a_component_that_blocks_the_way_out_is_named() -> None:
    found = supervisor_of(
        "component A { incoming message go with type: none incoming message on_ with type: none"
        " behaviour { initial marked state home { on request to go goto away }"
        " state away { on request to on_ goto home } } }"
        " component B { outgoing message k with type: boolean"
        " behaviour { initial marked state shut { on response from k if value goto shut }"
        " state open { on request to on_ goto shut } } }"
    )
    why = explanation_of(found, "go.request")
    assert "A is stuck in A.away" in why.reason
    assert why.remedy is not None
    assert why.remedy.startswith("on_.request would lead on, but B does not take it in B.shut")


def test_overflow() -> None:
    found = supervisor_of(families.transfer_line(2, 1))
    why = explanation_of(found, "work0.request")
    assert guard_text(found, "work0.request") == ("Buffer0.level <= 0", "restricted")
    assert trace_text_of(why.trace) == [
        "work0.request", "work0.response", "work0.request", "work0.response",
    ]  # fmt: skip
    assert "Buffer0.level leaves its range 0..1 (it becomes 2)" in why.reason
    assert why.remedy is not None
    assert "'if Buffer0.level <= 0'" in why.remedy
    assert why.diagnostic.code == "restricted-command"
    assert why.diagnostic.notes[0].span is not None
    assert "level := level + 1" in why.diagnostic.notes[0].span.text


def test_no_guard_is_suggested_that_never_holds() -> None:
    found = supervisor_of(
        "component A { service go with request: none, response: none links g behaviour {"
        " variable x: integer(0..1) initial marked state s {"
        " on request to go on response from go do x := x + 3 } } }"
        " interface g use Go from no_msgs requirement always A.x >= 0"
    )
    assert explanation_of(found, "go.request").remedy == "widen the range of A.x"


def test_state_requirement() -> None:
    found = supervisor_of(
        "component A { incoming message on with type: none incoming message off with type: none"
        " behaviour { initial marked state down { on request to on goto up }"
        " marked state up { on request to off goto down } } }"
        "component B { outgoing message m with type: none behaviour {"
        " initial marked state low { on response from m goto high }"
        " marked state high { on response from m goto low } } }"
        " requirement never A.up and B.high"
    )
    why = explanation_of(found, "on.request")
    assert trace_text_of(why.trace) == ["on.request", "m.response"]
    assert why.reason.endswith("'requirement never A.up and B.high' fails")
    assert why.remedy == "change what m.response does to B, or relax the requirement"
    note = why.diagnostic.notes[0].span
    assert note is not None
    assert note.text == "requirement never A.up and B.high"


def test_forbidden_state_at_once() -> None:
    found = supervisor_of(
        "component A { incoming message on with type: none incoming message off with type: none"
        " behaviour { initial marked state down { on request to on goto up }"
        " marked state up { on request to off goto down } } }"
        " requirement never A.up"
    )
    why = explanation_of(found, "on.request")
    assert why.reason == (
        "on.request can never be allowed: after on.request, 'requirement never A.up' fails"
    )
    assert why.remedy == "change what on.request does to A, or relax the requirement"


def test_own_step_into_a_dead_end() -> None:
    found = supervisor_of(
        "component A { incoming message back with type: none"
        " outgoing message m with type: none"
        " behaviour { variable x: integer(0..1) = 0"
        " initial marked state home { transition goto away }"
        " state away { on request to back if x = 1 goto home } } }"
    )
    why = explanation_of(found, "A.tau1")
    assert [step.values for step in why.trace] == [("home->away",)]
    assert "A is stuck in A.away" in why.reason


def test_empty_supervisor() -> None:
    found = supervisor_of(
        "component A { outgoing message m with type: none behaviour {"
        " initial marked state low { on response from m goto high }"
        " marked state high { on response from m goto low } } }"
        " requirement never A.high"
    )
    assert found.empty
    assert (found.controlled_states, found.controlled_transitions) == (0, 0)
    (why,) = found.explanations
    assert why.event is None
    assert why.reason == (
        "no controller can satisfy the requirements: after m.response, which no controller can"
        " prevent, 'requirement never A.high' fails"
    )
    assert why.diagnostic.severity is Severity.ERROR
    assert why.diagnostic.code == "empty-supervisor"
    assert found.diagnostics == (why.diagnostic,)


def test_empty_from_the_start() -> None:
    found = supervisor_of(
        "component A { outgoing message m with type: none behaviour {"
        " initial marked state low { on response from m goto high }"
        " marked state high { on response from m goto low } } }"
        " requirement always A.high"
    )
    (why,) = found.explanations
    assert why.trace == ()
    assert why.reason == (
        "no controller can satisfy the requirements: 'requirement always A.high' fails"
    )
    assert why.remedy == "let A start otherwise, or relax the requirement"


def test_command_whose_requirements_never_hold() -> None:
    found = supervisor_of(
        "component A { incoming message go with type: none"
        " behaviour { variable x: integer(0..2) = 0 initial marked state s {} } }"
        " requirement go needs A.x = 1"
    )
    why = explanation_of(found, "go.request")
    assert why.trace == ()
    assert "its requirements hold in no state" in why.reason


def test_blocking_of_two_that_are_never_home_together() -> None:
    """Each comes home again and again, but they alternate."""
    found = supervisor_of(
        "component A { outgoing message tick with type: none incoming message go with type: none"
        " behaviour { initial marked state start { on request to go goto home }"
        " state home { on response from tick goto away }"
        " state away { on response from tick goto home } } }".replace(
            "state home", "marked state home"
        )
        + "component B { behaviour { initial marked state start { on request to go goto away }"
        " marked state home { on response from tick goto away }"
        " state away { on response from tick goto home } } }"
    )
    why = explanation_of(found, "go.request")
    assert why.reason.endswith("A and B are never in marked states at the same time again")


@pytest.mark.parametrize("seed", quick_first(range(300, 380), 20))
def test_traces_of_random_robots_can_be_played(seed: int) -> None:
    """Each trace runs in the plant, keeps the requirements, and ends where nobody may be."""
    robot = robot_of(random_model(random.Random(seed), 1 + seed % 3))
    plant = lower(robot)
    oracle = Oracle(robot)
    for found in synthesize(plant, "explicit").explanations:
        if not found.trace:
            continue
        end = replay(plant, found.trace)
        commands = [n for n, step in enumerate(found.trace) if step.event is found.event]
        if found.event is not None:
            assert commands, "the refused command is part of the trace"
            rest = found.trace[commands[-1] + 1 :]
            assert not any(step.event.controllable for step in rest)
        for number, step in enumerate(found.trace):
            before = replay(plant, found.trace[:number])
            assert not isinstance(before, Verdict)
            if step.event.requirement is not None:
                assert holds(plant, step.event.requirement, before)
        if end is not Verdict.OUT_OF_RANGE:
            values = tuple(
                variable.values[at] for variable, at in zip(plant.variables, end, strict=True)
            )
            assert values not in oracle.kept


@pytest.mark.parametrize("seed", quick_first(range(300, 340), 15))
def test_every_restricted_or_forbidden_event_is_explained(seed: int) -> None:
    plant = lower(robot_of(random_model(random.Random(seed), 2)))
    found = synthesize(plant, "explicit")
    told = [e.event for e in found.explanations]
    if found.empty:
        assert told == [None]
    else:
        expected = [g.event for g in found.guards if g.status != "as required"]
        silent = [event for event in expected if event not in told]
        assert told == [event for event in expected if event not in silent]
        assert all(event.kind is EventKind.CANCEL for event in silent)


def test_a_cancel_for_which_there_is_never_a_reason_is_not_told() -> None:
    model = """
        interface act use Test from actionlib
        component Base {
            outgoing message parked with type: none
            action lift with request: none, response: none, feedback: none links act
            behaviour {
                initial marked state away { on response from parked goto there }
                marked state there {%s}
            }
        }
        requirement lift needs Base.there
    """
    found = supervisor_of(model % "")
    assert [g.status for g in found.guards if g.event.kind is EventKind.CANCEL] == ["never"]
    assert found.explanations == ()
    violated = supervisor_of(model % " on response from parked goto away ")
    assert [g.status for g in violated.guards] == ["as required"] * 2


def test_same_reasons_every_time() -> None:
    text = families.transfer_line(4, 2)
    first, second = (synthesize(plant_of(text), "explicit") for _ in range(2))
    assert [e.reason for e in first.explanations] == [e.reason for e in second.explanations]


def test_a_requirement_that_nothing_keeps() -> None:
    found = supervisor_of(
        "component A { behaviour { initial marked state s {} } } requirement never true"
    )
    assert [why.remedy for why in found.explanations] == ["relax the requirement"]


def test_a_long_requirement_is_told_by_its_beginning() -> None:
    found = supervisor_of(steep_families.not_all_busy(17))
    assert found.explanations
    for explanation in found.explanations:
        assert "'requirement never Machine0.busy and Machine1.busy and" in explanation.reason
        assert explanation.reason.endswith(" and …' fails")


def doors(count: int, most: int) -> str:
    """Doors that jam by themselves once they are in use; of which some may be jammed at a time."""
    parts = "".join(
        f"""
component Door{n} {{
    incoming message use{n} with type: none
    outgoing message jam{n} with type: none
    behaviour {{
        initial marked state idle {{ on request to use{n} goto used }}
        marked state used {{ on response from jam{n} goto jammed }}
        marked state jammed {{ }}
    }}
}}"""
        for n in range(count)
    )
    jammed = ", ".join(f"Door{n}.jammed" for n in range(count))
    return f"{parts}\nrequirement always count(x for x in [{jammed}]) <= {most}\n"


def test_a_requirement_that_restricts_many_commands_has_one_warning() -> None:
    supervisor = synthesize(plant_of(doors(9, 2)))
    warnings = [d for d in supervisor.diagnostics if d.code == "restricted-command"]
    assert len(supervisor.explanations) == 9
    (warning,) = warnings
    assert warning.message.startswith("use0.request is restricted further: after ")
    assert warning.message.endswith(
        "; the same holds for use1.request, use2.request, use3.request, use4.request, use5.request"
        " and 3 other commands"
    )


def test_a_bad_state_behind_many_failures_in_any_order_is_found() -> None:
    """13 of 16 doors jam: some 2^13 sets of jammed doors lie between, too many to look at all."""
    supervisor = synthesize(plant_of(doors(16, 12)))
    for explanation in supervisor.explanations:
        forced = [step for step in explanation.trace if not step.event.controllable]
        assert len(forced) == 13
        assert "fails" in explanation.reason


def test_a_message_that_falls_silent_changes_no_component() -> None:
    found = supervisor_of("""
        component Lamp {
            outgoing message bright with timeout: 1 s, type: boolean
            behaviour {
                variable lit: boolean
                initial marked state on { on response from bright do lit := value }
            }
        }
        requirement never Lamp.lit and bright.silent
    """)
    (why,) = found.explanations
    assert trace_text_of(why.trace) == ["bright.response", "bright.timeout"]
    assert why.remedy == "relax the requirement"


CALLED = """
    component Arm {
        service grab with request: none, response: none links link
        behaviour {
            variable failed: boolean
            OUTSIDE
            initial marked state idle { on request to grab goto busy }
            state busy { on response from grab goto idle INSIDE }
        }
    }
"""


@pytest.mark.parametrize(
    ("outside", "inside", "remedy", "mended"),
    [
        ("", "on error from grab goto busy",
         "let 'on error from grab' in state busy of Arm lead on: 'goto idle'",
         "on error from grab goto idle"),
        ("", "on error from grab do failed := true",
         "let 'on error from grab' in state busy of Arm lead on: 'goto idle'",
         "on error from grab do failed := true goto idle"),
        ("on error from grab do failed := true", "",
         "add 'on error from grab goto idle' in state busy of Arm", "on error from grab goto idle"),
    ],
)  # fmt: skip
def test_a_transition_that_leads_nowhere_is_to_lead_on(
    outside: str, inside: str, remedy: str, mended: str
) -> None:
    text = CALLED.replace("OUTSIDE", outside)
    why = explanation_of(supervisor_of(text.replace("INSIDE", inside)), "grab.request")
    assert why.remedy == remedy
    found = supervisor_of(text.replace("INSIDE", mended))
    assert guard_text(found, "grab.request") == ("true", "as required")
