"""Marked states, blocking, and the supervisor as a whole; see ``clauses.py``."""

from __future__ import annotations

import pytest
from synthesis.clauses import controlled, of_robot, same
from synthesis.subject import SUBJECTS, Subject, steps

pytestmark = pytest.mark.parametrize("subject", SUBJECTS, ids=lambda s: s.__name__)


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
    document = of_robot(subject, text).explore(plant=True)
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
    run = of_robot(subject, text)
    assert run.statuses()["grab.request"] == "never"
    assert run.statuses()["look.request"] == "as required"


def test_handled_error_sets_the_action_free(subject: type[Subject]) -> None:
    text = GRABBER.replace("EXTRA", "on error from grab goto idle")
    run = of_robot(subject, text)
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
    assert of_robot(subject, text).statuses() == {
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
    run = of_robot(subject, text)
    assert run.counts() == (8, 6, 6 * 2 + 2 + 2 + 3 + 1 + 2)
    assert run.statuses()["go.request"] == "restricted"
