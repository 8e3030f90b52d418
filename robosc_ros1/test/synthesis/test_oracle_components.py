"""Events, and how components react to them; see ``clauses.py``."""

from __future__ import annotations

import pytest
from synthesis.clauses import controlled, plant, same
from synthesis.subject import SUBJECTS, Subject

pytestmark = pytest.mark.parametrize("subject", SUBJECTS, ids=lambda s: s.__name__)


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


def test_action_goes_on_after_a_cancel_until_its_server_ends_it(subject: type[Subject]) -> None:
    same(
        plant(subject, ACTION),
        """
        idle --a.request--> busy
        busy --a.response--> idle
        busy --a.feedback--> busy
        busy --a.error--> idle
        busy --a.cancel--> cancelling
        cancelling --a.response--> idle
        cancelling --a.error--> idle
        cancelling --a.cancelled--> idle
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
        two busy --a.cancel--> two cancelling
        two cancelling --a.response--> one idle
        two cancelling --a.error--> two idle
        two cancelling --a.cancelled--> two idle
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
