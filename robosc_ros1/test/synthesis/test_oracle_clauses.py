"""Each clause of the semantics on a robot small enough to be worked out by hand.

The expected systems were written down from the documents, step by step; the oracle and the engine
must both give them. A state is written as its values in order (components, variables,
communications), a step as ``state --event--> state``.
"""

from __future__ import annotations

import pytest
from synthesis.subject import SUBJECTS, Subject, steps

subjects = pytest.mark.parametrize("subject", SUBJECTS, ids=lambda s: s.__name__)
pytestmark = subjects

LINK = "interface link use Thing from some_robot_msgs\n"


def plant(subject: type[Subject], text: str) -> list[str]:
    return steps(subject("robot R {" + LINK + text + "}").explore(plant=True))


def controlled(subject: type[Subject], text: str) -> list[str]:
    return steps(subject("robot R {" + LINK + text + "}").explore(plant=False))


def same(found: list[str], expected: str) -> None:
    assert found == sorted(line.strip() for line in expected.strip().splitlines())


# --- events and their own automata ---------------------------------------------------------------


def test_outgoing_message_is_always_possible(subject: type[Subject]) -> None:
    same(plant(subject, "component A { outgoing message m with type: none }"), "--m.response-->")


def test_incoming_message_is_always_possible(subject: type[Subject]) -> None:
    same(plant(subject, "component A { incoming message m with type: none }"), "--m.request-->")


def test_service_is_busy_between_request_and_response_or_error(subject: type[Subject]) -> None:
    text = "component A { service s with request: none, response: none links link }"
    expected = """
        idle --s.request--> busy
        busy --s.response--> idle
        busy --s.error--> idle
    """
    same(plant(subject, text), expected)
    same(controlled(subject, text), expected)


ACTION = """
    component A { action a with request: none, response: none, feedback: none links link }
"""


def test_action_has_feedback_and_cancel_while_busy(subject: type[Subject]) -> None:
    same(
        plant(subject, ACTION),
        """
        idle --a.request--> busy
        busy --a.response--> idle
        busy --a.feedback--> busy
        busy --a.error--> idle
        busy --a.cancel--> idle
        """,
    )


def test_action_without_requirement_is_never_cancelled(subject: type[Subject]) -> None:
    same(
        controlled(subject, ACTION),
        """
        idle --a.request--> busy
        busy --a.response--> idle
        busy --a.feedback--> busy
        busy --a.error--> idle
        """,
    )


def test_each_tau_is_an_event_of_its_own(subject: type[Subject]) -> None:
    text = """
        component A {
            behaviour {
                transition goto two
                initial marked state one { transition goto two transition }
                marked state two { transition goto one }
            }
        }
    """
    same(
        plant(subject, text),
        """
        one --A.tau1(one->two)--> two
        one --A.tau2(one->two)--> two
        one --A.tau3(one->one)--> one
        two --A.tau1(two->two)--> two
        two --A.tau4(two->one)--> one
        """,
    )


# --- components ----------------------------------------------------------------------------------


def test_uncontrollable_event_is_never_blocked(subject: type[Subject]) -> None:
    text = """
        component A {
            outgoing message m with type: none
            behaviour {
                initial marked state one { on response from m goto two }
                marked state two {}
            }
        }
        component B {
            behaviour {
                initial marked state one {}
                marked state two { on response from m goto one }
            }
        }
    """
    same(
        plant(subject, text),
        """
        one one --m.response--> two one
        two one --m.response--> two one
        """,
    )


def test_cancel_is_never_blocked(subject: type[Subject]) -> None:
    text = (
        ACTION
        + """
        component B {
            behaviour {
                initial marked state one { on request to a goto two }
                marked state two { on response from a goto one }
                marked state three { on cancel to a goto one }
            }
        }
    """
    )
    same(
        plant(subject, text),
        """
        one idle --a.request--> two busy
        two busy --a.response--> one idle
        two busy --a.feedback--> two busy
        two busy --a.error--> two idle
        two busy --a.cancel--> two idle
        """,
    )


def test_request_is_synchronised_with_all_who_mention_it(subject: type[Subject]) -> None:
    text = """
        component A {
            incoming message m with type: none
            outgoing message n with type: none
            behaviour {
                initial marked state one { on request to m goto two }
                marked state two { on response from n goto one }
            }
        }
        component B {
            behaviour {
                initial marked state one { on response from n goto two }
                marked state two { on request to m goto one }
            }
        }
        component C { behaviour { initial marked state one { on response from n } } }
    """
    same(
        plant(subject, text),
        """
        one one one --n.response--> one two one
        one two one --m.request--> two one one
        one two one --n.response--> one two one
        two one one --n.response--> one two one
        """,
    )


def test_guarded_request_is_enabled_only_where_its_guard_holds(subject: type[Subject]) -> None:
    text = """
        component A {
            incoming message m with type: none
            behaviour {
                variable done: boolean
                initial marked state one { on request to m if !done do done := true }
            }
        }
    """
    same(plant(subject, text), "one false --m.request--> one true")


def test_automaton_level_exists_in_every_state_and_loses_to_state_level(
    subject: type[Subject],
) -> None:
    text = """
        component A {
            outgoing message m with type: none
            outgoing message n with type: none
            behaviour {
                on response from m goto two
                on response from n goto two
                initial marked state one {}
                marked state two { on response from m goto one }
            }
        }
    """
    same(
        plant(subject, text),
        """
        one --m.response--> two
        one --n.response--> two
        two --m.response--> one
        two --n.response--> two
        """,
    )


def test_automaton_level_is_taken_where_no_guard_of_the_state_holds(
    subject: type[Subject],
) -> None:
    text = """
        component A {
            outgoing message m with type: boolean
            behaviour {
                on response from m goto two
                initial marked state one { on response from m if value goto three }
                marked state two {}
                marked state three {}
            }
        }
    """
    same(
        plant(subject, text),
        """
        one --m.response(true)--> three
        one --m.response(false)--> two
        two --m.response(true)--> two
        two --m.response(false)--> two
        three --m.response(true)--> two
        three --m.response(false)--> two
        """,
    )


def test_transitions_of_state_and_automaton_are_taken_together(subject: type[Subject]) -> None:
    """The one of the state decides where both assign; one with goto does not come along."""
    text = """
        component A {
            outgoing message m with type: integer(0..1)
            incoming message probe with type: none
            behaviour {
                variable last: integer(0..1)
                variable seen: boolean
                on response from m if value = 0 do last := value, seen := true
                on response from m if value = 1 goto away
                initial marked state one {
                    on response from m do seen := false goto two
                }
                marked state two {}
                marked state away {}
            }
        }
        requirement probe needs A.last = 0 and !A.seen
    """
    found = plant(subject, text)
    leading = [line for line in found if "m.response" in line]
    same(
        [line for line in leading if line.startswith("one")],
        """
        one 0 false --m.response(0)--> two 0 false
        one 0 false --m.response(1)--> two 0 false
        """,
    )
    same(
        [line for line in leading if line.startswith("two 0 false")],
        """
        two 0 false --m.response(0)--> two 0 true
        two 0 false --m.response(1)--> away 0 false
        """,
    )


def test_guarded_uncontrollable_event_leaves_the_component_where_no_guard_holds(
    subject: type[Subject],
) -> None:
    text = """
        component A {
            outgoing message m with type: integer(0..2)
            behaviour {
                initial marked state one {
                    on response from m if value = 1 goto two
                    on response from m if value = 2 goto three
                }
                marked state two {}
                marked state three {}
            }
        }
    """
    found = plant(subject, text)
    same(
        [line for line in found if line.startswith("one")],
        """
        one --m.response(0)--> one
        one --m.response(1)--> two
        one --m.response(2)--> three
        """,
    )
    assert len(found) == 9


# --- values and assignments ----------------------------------------------------------------------


def test_value_that_no_synthesis_variable_takes_is_left_out(subject: type[Subject]) -> None:
    text = """
        datatype enum E from double to { value > 1 -> high default -> low }
        component A {
            incoming message go with type: double
            outgoing message m with type: E
            outgoing message n with type: double
            behaviour {
                variable kept: E
                variable read: double
                initial marked state one {
                    on response from m do kept := value
                    on response from n do read := value
                }
            }
        }
        provide go with A.read
    """
    same(
        plant(subject, text),
        """
        one --go.request--> one
        one --m.response--> one
        one --n.response--> one
        """,
    )


def test_event_branches_over_every_value_taken(subject: type[Subject]) -> None:
    text = """
        datatype enum E from double to { value > 1 -> high default -> low }
        component A {
            incoming message go with type: none
            outgoing message m with type: E
            behaviour {
                variable kept: E = high
                initial marked state one { on response from m do kept := value }
            }
        }
        requirement go needs A.kept = low
    """
    same(
        plant(subject, text),
        """
        one high --go.request--> one high
        one high --m.response(high)--> one high
        one high --m.response(low)--> one low
        one low --go.request--> one low
        one low --m.response(high)--> one high
        one low --m.response(low)--> one low
        """,
    )
    same(
        controlled(subject, text),
        """
        one high --m.response(high)--> one high
        one high --m.response(low)--> one low
        one low --go.request--> one low
        one low --m.response(high)--> one high
        one low --m.response(low)--> one low
        """,
    )


def test_object_value_branches_over_the_paths_taken(subject: type[Subject]) -> None:
    text = """
        datatype object Inner { flag: boolean other: boolean }
        datatype object Outer { inner: Inner level: integer(1..2) far: double }
        component A {
            outgoing message m with type: Outer links link
            behaviour {
                variable on: boolean
                variable level: integer(0..2)
                initial marked state one {
                    on response from m do on := value.inner.flag, level := value.level
                }
            }
        }
        requirement always A.on or A.level < 9
    """
    found = plant(subject, text)
    same(
        [line for line in found if line.startswith("one false 0")],
        """
        one false 0 --m.response(inner.flag=false, level=1)--> one false 1
        one false 0 --m.response(inner.flag=false, level=2)--> one false 2
        one false 0 --m.response(inner.flag=true, level=1)--> one true 1
        one false 0 --m.response(inner.flag=true, level=2)--> one true 2
        """,
    )
    assert len(found) == 5 * 4


def test_missing_array_element_leaves_the_variable(subject: type[Subject]) -> None:
    text = """
        datatype object Found { seen: array(boolean) }
        component A {
            incoming message go with type: none
            outgoing message m with type: Found links link
            behaviour {
                variable on: boolean
                initial marked state one { on response from m do on := value.seen[0] }
            }
        }
        requirement go needs A.on
    """
    found = [line for line in plant(subject, text) if "m.response" in line]
    same(
        found,
        """
        one false --m.response(seen[0]=false)--> one false
        one false --m.response(seen[0]=true)--> one true
        one false --m.response(seen[0]=null)--> one false
        one true --m.response(seen[0]=false)--> one false
        one true --m.response(seen[0]=true)--> one true
        one true --m.response(seen[0]=null)--> one true
        """,
    )


def test_elements_of_an_array_are_missing_together(subject: type[Subject]) -> None:
    text = """
        datatype object Seen { seen: boolean near: boolean }
        datatype object Found { things: array(Seen) }
        component A {
            outgoing message m with type: Found links link
            behaviour {
                variable first: boolean
                variable second: boolean
                initial marked state one {
                    on response from m
                        if value.things[0].near
                        do first := value.things[0].seen, second := value.things[1].seen
                }
            }
        }
        requirement always A.first or !A.first or A.second
    """
    # Nothing, the first alone, or both; of the first two parts are taken.
    names = ("things[0].near", "things[0].seen", "things[1].seen")
    either = ("false", "true")
    expected = {("null", "null", "null")}
    expected |= {(near, seen, "null") for near in either for seen in either}
    expected |= {(near, seen, other) for near in either for seen in either for other in either}
    found = [
        step["event"]["value"]
        for step in subject("robot R {" + LINK + text + "}").explore(plant=True)["transitions"]
        if step["source"] == 0
    ]
    told = [
        tuple(str(value[name]).lower().replace("none", "null") for name in names) for value in found
    ]
    assert set(told) == expected
    assert len(told) == len(expected)


def test_assignments_are_simultaneous_over_all_components(subject: type[Subject]) -> None:
    text = """
        component A {
            outgoing message swap with type: none
            behaviour {
                variable x: integer(0..2) = 1
                variable y: integer(0..2) = 0
                initial marked state one { on response from swap do x := y, y := B.x }
            }
        }
        component B {
            behaviour {
                variable x: integer(0..2) = 2
                initial marked state one { on response from swap do x := A.x }
            }
        }
        requirement always A.x + A.y + B.x = 3
    """
    same(
        plant(subject, text),
        """
        one one 1 0 2 --swap.response--> one one 0 2 1
        one one 0 2 1 --swap.response--> one one 2 1 0
        one one 2 1 0 --swap.response--> one one 1 0 2
        """,
    )


def test_controllable_event_that_would_leave_a_range_is_impossible(
    subject: type[Subject],
) -> None:
    text = """
        component A {
            incoming message up with type: none
            behaviour {
                variable n: integer(0..2)
                initial marked state one { on request to up do n := n + 1 }
            }
        }
        requirement always A.n >= 0
    """
    expected = """
        one 0 --up.request--> one 1
        one 1 --up.request--> one 2
    """
    same(plant(subject, text), expected)
    same(controlled(subject, text), expected)


OVERFLOW = """
    component A {
        incoming message up with type: none
        outgoing message burst with type: none
        behaviour {
            variable n: integer(0..3)
            initial marked state one {
                on request to up do n := n + 1
                on response from burst do n := n + N
            }
        }
    }
    requirement always A.n >= 0
"""


def test_state_in_which_an_uncontrollable_event_leaves_a_range_is_avoided(
    subject: type[Subject],
) -> None:
    # The burst repeats for ever, so that every state leads to one where it overflows.
    assert controlled(subject, OVERFLOW.replace("N", "1")) == []
    same(
        plant(subject, OVERFLOW.replace("N", "2")),
        """
        one 0 --burst.response--> one 2
        one 0 --up.request--> one 1
        one 1 --burst.response--> one 3
        one 1 --up.request--> one 2
        one 2 --up.request--> one 3
        """,
    )


def test_overflow_is_prevented_by_not_starting_early(subject: type[Subject]) -> None:
    # `fill` ends with one item more, whatever the controller does; `take` makes room.
    text = """
        component A {
            service fill with request: none, response: none links link
            incoming message take with type: none
            behaviour {
                variable n: integer(0..1)
                on response from fill do n := n + 1
                on request to take do n := n - 1
                initial marked state one {}
            }
        }
        requirement always A.n >= 0
    """
    same(
        controlled(subject, text),
        """
        one 0 idle --fill.request--> one 0 busy
        one 0 busy --fill.error--> one 0 idle
        one 0 busy --fill.response--> one 1 idle
        one 1 idle --take.request--> one 0 idle
        """,
    )


# --- requirements --------------------------------------------------------------------------------


DOOR = """
    component Door {
        outgoing message opened with type: none
        outgoing message closed with type: none
        incoming message go with type: none
        incoming message wait with type: none
        behaviour {
            initial marked state shut { on response from opened goto open }
            marked state open { on response from closed goto shut }
        }
    }
"""


@pytest.mark.parametrize(
    "requirement",
    ["go needs Door.shut", "{go} needs !Door.open", "Door.open disables go"],
)
def test_needs_and_disables(subject: type[Subject], requirement: str) -> None:
    same(
        [
            line
            for line in controlled(subject, f"{DOOR} requirement {requirement}")
            if "request" in line
        ],
        """
        shut --go.request--> shut
        shut --wait.request--> shut
        open --wait.request--> open
        """,
    )


def test_requirement_on_a_set_of_communications(subject: type[Subject]) -> None:
    same(
        [
            line
            for line in controlled(subject, f"{DOOR} requirement Door.open disables {{go, wait}}")
            if "request" in line
        ],
        """
        shut --go.request--> shut
        shut --wait.request--> shut
        """,
    )


GUARDED_ACTION = """
    component Door {
        outgoing message opened with type: none
        outgoing message closed with type: none
        action a with request: none, response: none, feedback: none links link
        behaviour {
            initial marked state shut { on response from opened goto open }
            marked state open { on response from closed goto shut }
        }
    }
"""


def commands(found: list[str]) -> list[str]:
    return [line for line in found if ".request" in line or ".cancel" in line]


def test_cancel_is_allowed_exactly_where_a_requirement_is_violated(
    subject: type[Subject],
) -> None:
    text = GUARDED_ACTION + "requirement a needs Door.shut"
    same(
        commands(controlled(subject, text)),
        """
        shut idle --a.request--> shut busy
        open busy --a.cancel--> open idle
        """,
    )


def test_one_of_several_requirements_is_enough_for_a_cancel(subject: type[Subject]) -> None:
    text = GUARDED_ACTION + "requirement a needs Door.shut requirement Door.shut disables a"
    same(
        commands(controlled(subject, text)),
        "",
    )
    other = GUARDED_ACTION + "requirement a needs Door.shut requirement a needs true"
    assert "open busy --a.cancel--> open idle" in controlled(subject, other)


@pytest.mark.parametrize("requirement", ["never Door.open", "always Door.shut"])
def test_state_requirement_that_cannot_be_kept_leaves_nothing(
    subject: type[Subject], requirement: str
) -> None:
    assert controlled(subject, f"{DOOR} requirement {requirement}") == []


def test_state_requirement_forbids_what_leads_to_it_unpreventably(
    subject: type[Subject],
) -> None:
    text = """
        component Arm {
            incoming message lift with type: none
            incoming message drop with type: none
            outgoing message slip with type: none
            behaviour {
                initial marked state low { on request to lift goto mid }
                marked state mid {
                    on request to lift goto high
                    on request to drop goto low
                    on response from slip goto low
                }
                marked state high { on response from slip goto fallen }
                marked state fallen {}
            }
        }
        requirement never Arm.fallen
    """
    same(
        controlled(subject, text),
        """
        low --lift.request--> mid
        low --slip.response--> low
        mid --drop.request--> low
        mid --slip.response--> low
        """,
    )


# --- marked states and blocking ------------------------------------------------------------------


def test_marked_needs_every_component_and_every_phase(subject: type[Subject]) -> None:
    text = """
        component A {
            outgoing message m with type: none
            service s with request: none, response: none links link
            behaviour {
                initial state one { on response from m goto two }
                marked state two {}
            }
        }
        component B {
            behaviour {
                initial state one { on response from m goto two }
                marked state two { on response from m goto one }
            }
        }
        component C {}
    """
    document = subject("robot R {" + LINK + text + "}").explore(plant=True)
    marked = {
        (*s["components"].values(), *s["communications"].values()): s["marked"]
        for s in document["states"]
    }
    assert marked == {
        ("one", "one", "idle"): False,
        ("one", "one", "busy"): False,
        ("two", "two", "idle"): True,
        ("two", "two", "busy"): False,
        ("two", "one", "idle"): False,
        ("two", "one", "busy"): False,
    }


GRABBER = """
    component Grabber {
        action grab with request: none, response: none, feedback: none links link
        incoming message look with type: none
        behaviour {
            initial marked state idle { on request to grab goto grabbing }
            state grabbing { on response from grab goto idle  EXTRA }
        }
    }
"""


def test_unhandled_error_means_that_the_action_can_never_be_started(
    subject: type[Subject],
) -> None:
    text = GRABBER.replace("EXTRA", "")
    same(controlled(subject, text), "idle idle --look.request--> idle idle")
    run = subject("robot R {" + LINK + text + "}")
    assert run.statuses()["grab.request"] == "never"
    assert run.statuses()["look.request"] == "as required"


def test_handled_error_sets_the_action_free(subject: type[Subject]) -> None:
    text = GRABBER.replace("EXTRA", "on error from grab goto idle")
    run = subject("robot R {" + LINK + text + "}")
    assert run.statuses()["grab.request"] == "as required"
    assert "idle idle --grab.request--> grabbing busy" in steps(run.explore(plant=False))


def test_losing_states_to_blocking_may_make_others_uncontrollable_and_blocking_in_turn(
    subject: type[Subject],
) -> None:
    # `trap` blocks by itself (round 1). `slip` then leads out of `edge`, so `edge` is lost (round
    # 1, controllability). `far` reached a marked state through `edge` only: lost (round 2). `near`
    # goes to `far` by itself: lost. Only `home` and `side` are left, and `out` is never allowed.
    text = """
        component A {
            incoming message out with type: none
            incoming message aside with type: none
            incoming message back with type: none
            outgoing message slip with type: none
            outgoing message drift with type: none
            behaviour {
                initial marked state home { on request to out goto near
                    on request to aside goto side }
                state near { on response from drift goto far  on request to back goto home }
                state far { on request to out goto edge }
                state edge { on response from slip goto trap  on request to back goto home }
                state trap { on request to aside goto home }
                state side { on request to back goto home }
            }
        }
        requirement A.trap disables aside
    """
    same(
        controlled(subject, text),
        """
        home --aside.request--> side
        home --slip.response--> home
        home --drift.response--> home
        side --back.request--> home
        side --slip.response--> side
        side --drift.response--> side
        """,
    )


def test_taus_are_controllable(subject: type[Subject]) -> None:
    text = """
        component A {
            outgoing message m with type: none
            behaviour {
                initial marked state one { transition goto two transition goto three }
                state two { on response from m goto one }
                state three { on response from m goto four }
                marked state four { }
            }
        }
        requirement never A.four
    """
    same(
        controlled(subject, text),
        """
        one --A.tau1(one->two)--> two
        one --m.response--> one
        two --m.response--> one
        """,
    )


def test_escape_through_an_uncontrollable_event_counts_for_nonblocking(
    subject: type[Subject],
) -> None:
    text = """
        component A {
            outgoing message m with type: none
            behaviour {
                initial state one { on response from m goto two }
                marked state two {}
            }
        }
    """
    same(
        controlled(subject, text),
        """
        one --m.response--> two
        two --m.response--> two
        """,
    )


def test_robot_without_behaviour_has_one_marked_state(subject: type[Subject]) -> None:
    run = subject("robot R { component A {} }")
    document = run.explore(plant=False)
    assert [s["marked"] for s in document["states"]] == [True]
    assert document["transitions"] == []


# --- the supervisor as a whole -------------------------------------------------------------------


def test_status_of_each_command(subject: type[Subject]) -> None:
    text = """
        component A {
            incoming message free with type: none
            incoming message asked with type: none
            incoming message lift with type: none
            incoming message never_met with type: none
            outgoing message slip with type: none
            behaviour {
                initial marked state low { on request to lift goto mid }
                marked state mid { on response from slip goto low  on request to lift goto high }
                marked state high { on response from slip goto fallen }
                marked state fallen {}
            }
        }
        requirement asked needs A.low
        requirement never_met needs A.fallen
        requirement never A.fallen
    """
    assert subject("robot R {" + LINK + text + "}").statuses() == {
        "free.request": "as required",
        "asked.request": "as required",
        "lift.request": "restricted",
        "never_met.request": "never",
    }


def test_counts_are_of_reachable_states_and_of_steps_with_values(
    subject: type[Subject],
) -> None:
    text = """
        component A {
            incoming message go with type: none
            outgoing message m with type: boolean
            service s with request: none, response: none links link
            behaviour {
                variable on: boolean
                initial marked state one {
                    on response from m do on := value
                    on request to go goto two
                }
                state two { on error from s goto one }
            }
        }
        requirement s needs A.on
    """
    # Where `on` is false in `two`, the way back (an error of `s`) cannot be started any more. Nor
    # may `s` be under way there: its response would leave that state. So `go` needs `on`, and of
    # the plant's 2 x 2 x 2 states the two with `two` and false are lost.
    # Steps: `m` twice in each of the six; one/false: +0 idle, +2 busy; one/true: +2 idle, +3 busy;
    # two/true: +1 idle, +2 busy.
    run = subject("robot R {" + LINK + text + "}")
    assert run.counts() == (8, 6, 6 * 2 + 2 + 2 + 3 + 1 + 2)
    assert run.statuses()["go.request"] == "restricted"
