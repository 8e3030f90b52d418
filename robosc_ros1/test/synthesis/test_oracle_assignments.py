"""Values of events, and assignments; see ``clauses.py``."""

from __future__ import annotations

import pytest
from synthesis.clauses import controlled, of_robot, plant, same
from synthesis.subject import SUBJECTS, Subject

pytestmark = pytest.mark.parametrize("subject", SUBJECTS, ids=lambda s: s.__name__)


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
        for step in of_robot(subject, text).explore(plant=True)["transitions"]
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
